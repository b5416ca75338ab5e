//! `bipedc export`: the robot as amended, for other tools.
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::{Workbench, export};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::Effect;
use bipedc_effects::files::write;
use clap::Args;
use std::path::PathBuf;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc export robots/tulip --urdf amended.urdf

Links get the masses, centres of mass and inertias that they have with the effects of biped.toml (payload, com_offset, \
inertia_error, inertial_correction), joints the damping (N m s/rad) and friction (N m) of viscous_friction and coulomb_friction as \
<dynamics>. Everything else of the URDF stays byte for byte, comments too. What a URDF has no words for is listed.";

/// Write the robot with what was amended as a URDF
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Export {
    /// Folder with `biped.toml`, or that file
    #[arg(value_name = "ROBOT")]
    path: PathBuf,
    /// File to write
    #[arg(long, value_name = "OUT.urdf")]
    urdf: PathBuf,
}

impl Export {
    /// Reads, rewrites, writes.
    pub fn run(self) -> Outcome {
        let bench = Workbench::open(&self.path)?;
        output::diagnostics(&bench.robot().warnings);
        bench.ledger().writes("--urdf", &self.urdf)?;
        let exported = export::urdf(bench.robot())?;
        write(&self.urdf, &exported.urdf)?;
        if !exported.left_out.is_empty() {
            let list: Vec<String> = exported.left_out.iter().map(Effect::to_string).collect();
            let warning = Diagnostic::warning(format!("a URDF has no words for: {}", list.join(", ")));
            output::diagnostics(&[warning.help("they stay in biped.toml")]);
        }
        let count = |names: &[String], what: &str| match names {
            [] => format!("no {what}s"),
            [one] => format!("{what} {one}"),
            several => format!("{what}s {}", several.join(", ")),
        };
        output::print(&format!(
            "wrote {}: other numbers for {}; {}\n",
            self.urdf.display(),
            count(&exported.links, "link"),
            count(&exported.joints, "joint")
        ))?;
        Ok(ExitCode::SUCCESS)
    }
}
