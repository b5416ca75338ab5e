//! `bipedc generate`: a robot's crate, written or checked.
use super::compare::Compare;
use crate::arguments::RobotArguments;
use crate::crate_paths::{folder_name, runtime_dependency, source_name};
use crate::failure::{Failure, Outcome};
use crate::output;
use bipedc_compiler::compile::{CompiledModel, Function};
use bipedc_compiler::emit::Package;
use bipedc_runtime::diagnostic::Diagnostic;
use clap::Args;
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::time::Instant;

const EXAMPLES: &str = "\
Examples:
  bipedc generate robots/tulip                               writes generated/tulip
  bipedc generate robots/tulip --out my_workspace/tulip --runtime 0.1.0
  bipedc generate robots/tulip --check                       is generated/tulip what would be written?

The crate is `no_std` and never allocates. What it holds is chosen by `[generate]` in biped.toml; by default
everything. --check writes nothing: it names missing, changed (stale or edited) and extra files, exit code 1.";

/// Write a robot's equations of motion as a Rust crate
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Generate {
    #[command(flatten)]
    robot: RobotArguments,
    /// Folder of the crate [default: generated/<name of the robot's folder>]
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
    /// Only compare with what is there; write nothing
    #[arg(long)]
    check: bool,
    /// Where the crate finds `bipedc-runtime`: a folder, or a version [default: the one of this repository if
    /// there is one, else the version of this program]
    #[arg(long, value_name = "PATH|VERSION")]
    runtime: Option<String>,
    /// Then compare the model's torques with this log, as `bipedc compare` does
    #[arg(long, value_name = "LOG.csv", conflicts_with = "check")]
    compare: Option<PathBuf>,
}

impl Generate {
    /// Compiles everything that the description asks for.
    pub fn run(self) -> Outcome {
        let started = Instant::now();
        let robot = self.robot.read()?;
        let out =
            self.out.clone().unwrap_or_else(|| Path::new("generated").join(folder_name(&self.robot.path)));
        let runtime = runtime_dependency(self.runtime.as_deref(), &out)?;
        let compiled = output::progress("deriving", || robot.compile())?;
        let source = source_name(&self.robot.path);
        let package = output::progress("writing Rust", || robot.package_of(&compiled, &source, &runtime));
        if self.check {
            return self.difference(&package, &out);
        }
        refuse_foreign(&out)?;
        package.write(&out)?;
        let bytes: usize = package.files.values().map(String::len).sum();
        output::print(&format!(
            "{}\n{}: {} functions, {} files, {bytes} bytes, {:.2} s\n",
            functions(&compiled),
            out.display(),
            compiled.functions.len(),
            package.files.len(),
            started.elapsed().as_secs_f64(),
        ))?;
        match self.compare {
            Some(log) => {
                output::print(&format!(
                    "\nthe same programs, run in process, against {}:\n\n",
                    log.display()
                ))?;
                Compare::of_log(self.robot, log).run()
            }
            None => Ok(ExitCode::SUCCESS),
        }
    }

    fn difference(&self, package: &Package, out: &Path) -> Outcome {
        let difference = package.compare(out)?;
        if difference.is_empty() {
            output::print(&format!("{} is up to date ({} files)\n", out.display(), package.files.len()))?;
            return Ok(ExitCode::SUCCESS);
        }
        let refresh = format!("refresh with: {}", self.refresh_command(out));
        let lists = [
            (&difference.missing, "is missing"),
            (&difference.changed, "differs from what would be generated: stale, or edited by hand"),
            (&difference.extra, "would not be generated: left over, or added by hand"),
        ];
        let message = |file: &String, what: &str| {
            Diagnostic::error(format!("`{file}` {what}")).in_file(&out.join(file))
        };
        let mut all: Vec<Diagnostic> = lists
            .into_iter()
            .flat_map(|(files, what)| files.iter().map(move |file| message(file, what)))
            .collect();
        // Said once: it is the same for all.
        if let Some(last) = all.last_mut() {
            last.help = Some(refresh);
        }
        Err(Failure(all))
    }

    fn refresh_command(&self, out: &Path) -> String {
        let runtime =
            self.runtime.as_ref().map_or_else(String::new, |runtime| format!(" --runtime {runtime}"));
        let overrides = self.robot.overrides();
        format!("bipedc generate {} --out {}{runtime}{overrides}", self.robot.path.display(), out.display())
    }
}

/// Writing removes what is no longer generated, so it must not happen in somebody's own crate.
fn refuse_foreign(out: &Path) -> Result<(), Diagnostic> {
    let manifest = out.join("Cargo.toml");
    let generated = match std::fs::read_to_string(&manifest) {
        Ok(text) => text.starts_with("# @generated by bipedc"),
        Err(_) => !manifest.exists() && !out.join("src").exists(),
    };
    if generated {
        return Ok(());
    }
    Err(Diagnostic::error("the folder holds a crate that was not generated by bipedc")
        .in_file(out)
        .help("choose another folder with --out, or remove this one"))
}

fn functions(compiled: &CompiledModel) -> String {
    let row = |f: &Function| {
        let shape = format!("{} × {}", f.rows.len(), f.columns.len());
        vec![f.name.clone(), shape, f.operations.to_string()]
    };
    output::table(&["function", "shape", "operations"], compiled.functions.iter().map(row).collect(), 3)
}
