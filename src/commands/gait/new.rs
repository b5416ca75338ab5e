//! `bipedc gait new`: a first gait file for a robot.
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::next::Typed;
use crate::terminal::output;
use bipedc_compiler::description::gait::{DoubleSupport, FormWishes, gait_form, usual_speed};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::write_with_folders;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

const NEW: &str = "\
Examples:
  bipedc gait new my_robot --out my_robot/gaits/form.toml
  bipedc gait optimise my_robot --gait form --speed 0.5 --out my_robot/gaits/walk.toml

Writes the form of a gait: a phase for each [[phase]] of biped.toml, φ (on one point foot the direction to the hip, else how far the base is ahead of \
the foot), and as outputs the joints that, with φ and the contacts, fix all others. It has no curves: `bipedc gait optimise` finds those. \
Change what is controlled as you like; docs/gaits.md explains every key.
JSON: {\"wrote\", \"next\" (a command)}.";

/// Write the form of a gait for a robot that has none, for `bipedc gait optimise` to fill
#[derive(Args)]
#[command(after_help = NEW)]
pub struct New {
    #[command(flatten)]
    robot: RobotArguments,
    /// The gait file to write; gaits/NAME.toml beside the description is found by its name
    #[arg(long, value_name = "NEW.toml")]
    out: PathBuf,
    /// On two feet control the knees instead of the base's height and the feet: for robots whose legs get straight, where optimise says that a phase has no posture
    #[arg(long)]
    knees: bool,
    /// For a step of one phase on a point: its controller keeps friction and push of the foot as those of several phases do, instead of the outputs; on a whole
    /// sole it always does
    #[arg(long)]
    grounded: bool,
    /// Replace a file that is there
    #[arg(long)]
    force: bool,
    /// Print what was written as JSON
    #[arg(long)]
    json: bool,
}

impl New {
    pub fn run(self) -> Outcome {
        let bench = self.robot.open()?;
        let mut ledger = bench.ledger();
        ledger.writes_source("--out", &self.out)?;
        if self.out.exists() && !self.force {
            let error = Diagnostic::error("the gait exists already").in_file(&self.out);
            return Err(error.help("--force replaces it").into());
        }
        let double = if self.knees { DoubleSupport::Knees } else { DoubleSupport::Height };
        let wishes = FormWishes { double, grounded: self.grounded };
        let robot = bench.robot();
        let text = gait_form(&robot.description, wishes)
            .map_err(|error| error.or_in_file(&robot.sources.toml_path))?;
        write_with_folders(&self.out, &text)?;
        let said = format!("with a speed V in m/s, {} to begin with", usual_speed(&robot.description));
        let next = Typed::command("gait optimise").path(bench.path()).file("--gait", Some(&self.out));
        // Beside the form, where scenarios find it by its name.
        let found = ["walk.toml", "walk-2.toml"].map(|name| self.out.with_file_name(name));
        let found = found.iter().map(PathBuf::as_path).find(|found| *found != self.out);
        let next = next.words(" --speed V").file("--out", found).because(&said);
        output::written(&self.out, &next, self.json)?;
        Ok(ExitCode::SUCCESS)
    }
}
