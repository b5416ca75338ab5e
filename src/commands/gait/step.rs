//! `bipedc gait step`: one step on the zero dynamics.
use super::values::assignment;
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use bipedc::gait::{Assignment, StepOptions};
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
that exists all the same; exit code 0. Margins say how far the next step is from slipping, pulling, scuffing and the torque limits of \
the URDF; negative ones are violated, but do not make a step infeasible.
JSON: {\"next_speed\" (per s), \"delta\", \"p_minus\", \"p_max\" ((kg m²/s)²), \"phi_m\", \"limit_speed\" (per s), \"feasible\", \
\"reason\", \"margins\": {\"friction\", \"pull\" (N), \"zmp\" (m), \"clearance\" (m), \"torque\" (N m), \"impact_friction\", \
\"impact_pull\" (N s), \"lift_off\" (m/s)}, \"phi_start\", \"phi_end\", \"eta\", \"this_step\": {\"p_minus\", \"p_max\", \"phi_m\"}, \"energy\", \"next_energy\", \"p_error\"}; null: \
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
        let gait = bench.gait(&self.gait)?;
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
}
