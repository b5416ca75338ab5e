//! `bipedc gait step`: one step on the zero dynamics.
use super::values::assignment;
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::Workbench;
use bipedc::gait::{AnyBench, Assignment, ChainOptions, PhasedBench, StepOptions};
use bipedc_effects::diagnostic::Diagnostic;
use clap::Args;
use std::process::ExitCode;

const STEP: &str = "\
Examples:
  bipedc gait step robots/three_link --gait thesis --speed 1.5
  bipedc gait step robots/three_link --gait thesis --speed 1.5 --set torso_lean=-0.7
  bipedc gait step robots/five_link --gait thesis --speed 2 --from step_length=0.3
  bipedc gait step robots/five_link --gait my_gait.toml --speed 2 --json

On virtual constraints a robot with point feet has one freedom left: its phase φ, with the angular momentum σ = α(φ) φ̇ about \
the foot that stands. σ²/2 + P(φ) stays as it is along a step (thesis 6.9), so the speed φ̇ at one place tells that \
at all others. --speed is φ̇ at the dead centre of a step, where P is largest; the answer is the same of the next step, after the \
impact.

Both steps have the parameters of the gait file, or those of --set; --from names those of the first step that differ. The first \
step follows others of its own kind, or one with the parameters of --before.

Parameters beyond their bounds are computed with a warning. A step that is not possible has a reason, and every number \
that exists all the same; exit code 0. Margins say how far the next step is from slipping, pulling, scuffing, the torque limits, the \
stops and the velocity limits of joints of the URDF; negative ones are violated, but do not make a step infeasible.
A gait of several phases is followed through all of them, under its own controller; the speed is that at the dead centre of the first. \
There the step takes the parameters of --set, where --from says others until then; --before has no meaning. \
Its JSON: {\"speed\", \"next_speed\" (per s), \"phi_m\", \"delta\", \"p_minus\", \"p_max\", \"energy\", \"next_energy\" ((unit of φ/s)²), \"limit_speed\" (null: `bipedc gait cycle` finds it), \"duration\" (s), \"feasible\", \
\"reason\", \"reason_code\", \"margins\", \"phases\": [{\"name\", \"phi_start\", \"phi_end\", \"speed_start\", \"speed_end\", \"duration\", \"nu\", \"p_minus\", \"limited\"}]}.

JSON: {\"next_speed\" (per s), \"delta\", \"p_minus\", \"p_max\" ((kg m²/s)²), \"phi_m\", \"limit_speed\" (per s), \"feasible\", \
\"reason\", \"reason_code\", \"margins\": {\"friction\", \"pull\" (N), \"zmp\" (m), \"clearance\" (m), \"torque\" (N m), \"joint\" (rad or m), \"velocity\" (rad/s or m/s), \"impact_friction\", \
\"impact_pull\" (N s), \"lift_off\" (m/s)}, \"phi_start\", \"phi_end\", \"eta\", \"this_step\": {\"p_minus\", \"p_max\", \"phi_m\"}, \"energy\", \"next_energy\", \"p_error\", \"k_min\", \"k_max\" ((kg m²/s)²)}; null: \
there is no such number.";

/// The speed at mid-stance of the next step, from that of this one
#[derive(Args)]
#[command(after_help = STEP)]
pub struct Step {
    #[command(flatten)]
    robot: RobotArguments,
    /// Name of a gait in gaits/ beside the robot's description, or a file
    #[arg(long, value_name = "NAME|FILE.toml")]
    gait: String,
    /// Speed of the phase variable at the dead centre of this step, per second (rad/s where it is an angle)
    #[arg(long, value_name = "V", allow_negative_numbers = true)]
    speed: f64,
    /// A parameter of both steps (SI units)
    #[arg(long, value_name = "NAME=X", value_parser = assignment)]
    set: Vec<Assignment>,
    /// A parameter of this step, where the next one has another
    #[arg(long, value_name = "NAME=X", value_parser = assignment)]
    from: Vec<Assignment>,
    /// A parameter of the step before this one, if that was another one than this
    #[arg(long, value_name = "NAME=X", value_parser = assignment)]
    before: Vec<Assignment>,
    /// Print the result as JSON
    #[arg(long)]
    json: bool,
}

impl Step {
    pub fn run(self) -> Outcome {
        let bench = self.robot.open()?;
        let gait = match bench.any_gait(&self.gait)? {
            AnyBench::OnePhase(gait) => gait,
            AnyBench::Phased(gait) => return self.run_phases(&bench, &gait),
        };
        output::diagnostics(&gait.warnings);
        let options = StepOptions { speed: self.speed, set: self.set, from: self.from, before: self.before };
        let stepped = gait.step(&options)?;
        output::diagnostics(&stepped.messages);
        if self.json {
            output::print_json(&stepped)?;
        } else {
            output::print(&stepped.to_string())?;
        }
        Ok(ExitCode::SUCCESS)
    }

    /// A step of several phases.
    fn run_phases(self, bench: &Workbench, gait: &PhasedBench) -> Outcome {
        output::diagnostics(&gait.warnings);
        if let Some((name, _)) = self.before.first() {
            let message = format!("`{name}`: this step of several phases follows one of its own kind");
            let help =
                "leave --before out; --from says the parameters until mid-stance, --set those from there on";
            return Err(Diagnostic::error(message).help(help).into());
        }
        let options = ChainOptions { speed: self.speed, set: self.set, from: self.from };
        output::diagnostics(&gait.beyond(&options)?);
        let found = bench.chained_step(gait, &options)?;
        if self.json {
            output::print_json(&found)?;
        } else {
            output::print(&found.to_string())?;
        }
        Ok(ExitCode::SUCCESS)
    }
}
