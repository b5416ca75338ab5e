//! `bipedc log`: what a log holds, how it is sampled, and how its columns could be mapped.
use crate::terminal::failure::{Failure, Outcome};
use crate::terminal::output;
use bipedc::Workbench;
use bipedc::inventory::{Inventory, Robot, examine, rewrite};
use bipedc_analysis::log::Mapping;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::files::{Ledger, write};
use bipedc_effects::input::read_to_string;
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc log tests/data/examples/coulomb/train.csv.gz
  bipedc log log.csv --robot robots/tulip
  bipedc log plotjuggler.csv --robot robots/tulip --out columns.toml
  bipedc log joint_states.csv --robot robots/tulip --csv log.csv
  bipedc log log.csv --mapping columns.toml --robot robots/tulip --json

Tells rows, duration (s), sampling rate (Hz) and how regular it is, gaps, time stamps that stand still or run back, and of every \
column what it is taken as, its unit, its range, whether it never changes, where it has no number. docs/logs.md explains all \
columns.

With --robot also which joints have which columns. Where names do not match, a mapping file is proposed from names such as \
`/joint_states/left_knee/position`, `KneeL.pos [deg]`, `tau_3` or `velocity[2]`; numbers stand for the joints in the order of the \
description, if there are as many. --out writes it, for --mapping of the other commands: check it first.

--csv writes the log again under our names, in SI units: also joint states as `ros2 topic echo --csv` prints them, which have no \
header row that could be mapped.

JSON: {\"file\", \"kind\", \"rows\", \"has_header\", \"sampling\": {\"column\", \"from_s\", \"to_s\", \"duration_s\", \"step_s\", \
\"rate_hz\", \"shortest_s\", \"longest_s\", \"uneven\", \"gaps\", \"largest_gap\": {\"length_s\", \"from_s\", \"line\"}, \"doubled\", \
\"first_doubled\", \"backward\", \"first_backward\", \"without_time\"}, \"columns\": [{\"name\", \"number\", \"taken_as\", \"proposed\", \
\"unit\", \"least\", \"most\", \"constant\", \"missing\", \"first_missing\", \"unusable\": {\"rows\", \"line\", \"example\"}}], \
\"robot\": {\"robot\", \"joints\": [{\"name\", \"has\", \"proposed\"}], \"missing\", \"unknown\": [{\"name\", \"meant\"}]}, \
\"proposal\": {\"entries\": [{\"name\", \"column\", \"scale\", \"unit\"}], \"assumptions\", \"doubts\"}, \"warnings\"}.";

/// Tell what a log holds and propose names for its columns
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Log {
    /// The log, or a table of postures or impacts
    #[arg(value_name = "FILE.csv")]
    file: PathBuf,
    /// Folder with `robot.urdf` and `biped.toml`, or one of these files: whose joints the columns are of
    #[arg(long, value_name = "DIR")]
    robot: Option<PathBuf>,
    /// TOML file with other column names, factors and signs
    #[arg(long, value_name = "FILE.toml")]
    mapping: Option<PathBuf>,
    /// Write the mapping file that is proposed
    #[arg(long, value_name = "OUT.toml", requires = "robot")]
    out: Option<PathBuf>,
    /// Write the log again under our names, in SI units
    #[arg(long, value_name = "OUT.csv")]
    csv: Option<PathBuf>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Log {
    /// Reads, tells, writes what was asked for.
    pub fn run(self) -> Outcome {
        let bench = self.robot.as_ref().map(Workbench::open).transpose()?;
        self.check_files(bench.as_ref())?;
        let mapping = self.mapping.as_deref().map(Mapping::open).transpose()?.unwrap_or_default();
        let robot = bench.as_ref().map(|bench| Robot::of(bench.robot())).transpose()?;
        let found = examine(&self.file, &mapping, robot.as_ref())?;
        output::diagnostics(&found.warnings);
        if self.json {
            output::print_json(&found)?;
        } else {
            output::print(&format!("{found}{}", self.proposed(&found)?))?;
        }
        if let Some(out) = &self.out {
            write(out, &self.writable(&found)?)?;
            output::remark(&format!("wrote {}: check it", out.display()));
        }
        if let Some(out) = &self.csv {
            let written = rewrite(&found, out)?;
            let (columns, rows, left_out) = (written.columns, written.rows, written.left_out);
            let rest = match left_out {
                0 => String::new(),
                count => format!("; {count} rows left out (cut off, of other joints or without a time)"),
            };
            output::remark(&format!("wrote {}: {columns} columns, {rows} rows{rest}", out.display()));
        }
        Ok(ExitCode::SUCCESS)
    }

    /// Before anything is computed: outputs must not be inputs.
    fn check_files(&self, bench: Option<&Workbench>) -> Result<(), Failure> {
        let mut ledger = bench.map_or_else(Ledger::default, Workbench::ledger);
        ledger.reads("the log", &self.file);
        self.mapping.iter().for_each(|file| ledger.reads("the mapping file", file));
        self.out.as_ref().map_or(Ok(()), |path| ledger.writes_source("--out", path))?;
        self.csv.as_ref().map_or(Ok(()), |path| ledger.writes("--csv", path))?;
        Ok(())
    }

    /// The mapping file, and what to do with it.
    fn proposed(&self, found: &Inventory) -> Result<String, Diagnostics> {
        let entries = found.proposal.entries.len();
        let strange = found.columns.iter().any(|column| column.taken_as.is_none());
        if self.robot.is_none() && strange {
            return Ok(format!(
                "next: bipedc log {} --robot ROBOT proposes names for the columns\n",
                self.file.display()
            ));
        }
        if entries == 0 {
            return Ok(String::new());
        }
        let robot = self.robot.as_deref().unwrap_or(Path::new("ROBOT")).display();
        let log = self.file.display();
        if !found.has_header {
            return Ok(format!(
                "\nnext: bipedc log {log} --robot {robot} --csv OUT.csv writes it under these names\n"
            ));
        }
        let next =
            |mapping: &Path| format!("next: bipedc compare {robot} {log} --mapping {}\n", mapping.display());
        Ok(match &self.out {
            Some(out) => format!("\n{}", next(out)),
            None => format!(
                "\na mapping file for {entries} columns{} (--out FILE.toml writes it):\n\n{}\n{}",
                self.mapping.as_ref().map_or("", |_| " beside those that are mapped"),
                self.merged(found)?,
                next(Path::new("FILE.toml"))
            ),
        })
    }

    /// The mapping file that is proposed, with all that the given one says: other commands take one.
    fn merged(&self, found: &Inventory) -> Result<String, Diagnostics> {
        let Some(file) = &self.mapping else { return Ok(found.mapping()) };
        let given = read_to_string(file).map_err(|error| {
            Diagnostic::error(format!("cannot read the mapping file: {error}")).in_file(file)
        })?;
        let name = file.file_name().unwrap_or_default().to_string_lossy().replace(char::is_control, " ");
        // Tables of the given file would take lines behind them for theirs.
        Ok(format!("{}\n# As {name} says:\n{given}", found.mapping()))
    }

    /// The text of the mapping file, if there is one to write.
    fn writable(&self, found: &Inventory) -> Result<String, Diagnostics> {
        can_be_mapped(found)?;
        let text = self.merged(found)?;
        // Nobody is to find out later that both say something of one column.
        Mapping::parse(self.out.as_deref().unwrap_or(Path::new("FILE.toml")), &text)?;
        Ok(text)
    }
}

/// Refuses a log of which nothing could be written into a mapping file.
fn can_be_mapped(found: &Inventory) -> Result<(), Diagnostic> {
    let refused = |message: &str, help: &str| {
        Err(Diagnostic::error(message).in_file(Path::new(&found.file)).at(1, 0).help(help))
    };
    if !found.has_header {
        let help = "--csv OUT.csv writes it again with names";
        return refused("the log has no header row whose names could be mapped", help);
    }
    if found.proposal.entries.is_empty() {
        let help =
            "columns that are understood need no mapping; what is not, docs/logs.md says how to map by hand";
        return refused(
            "there is nothing to propose: no column with another name looks like one of ours",
            help,
        );
    }
    Ok(())
}
