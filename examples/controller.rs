//! A controller of one's own in the simulator, made from generated code: a leg on a stand carries its own weight.
//!
//!   cargo run --release --example controller
//!
//! The closure is what would run on the robot: `bipedc_runtime` and `generated/tulip_v1_leg` need neither a heap nor an operating
//! system.
use bipedc::{Diagnostics, Workbench, simulation};
use bipedc_runtime::control::{JointCommand, Observation, Refusal};
use nalgebra::SVector;
use std::path::Path;

/// Torques against gravity, and a little damping.
pub fn carry(observed: &Observation<'_, f64>, commands: &mut [JointCommand<f64>]) -> Result<(), Refusal> {
    let weight = tulip_v1_leg::gravity(&SVector::from_column_slice(observed.q));
    for (command, (weight, rate)) in commands.iter_mut().zip(weight.iter().zip(observed.v)) {
        *command = JointCommand::Torque(weight - 0.5 * rate);
    }
    Ok(())
}

/// Simulates it, and writes the log that the leg's sensors would write.
pub fn simulate(log: &Path) -> Result<String, Diagnostics> {
    let leg = Workbench::open("robots/tulip_v1_leg")?;
    let scene = leg.scene("robots/tulip_v1_leg/scenarios/released.toml")?;
    let done = leg.simulate_with(&scene, &mut carry, log, &simulation::Options::default())?;
    Ok(done.to_string())
}

fn main() {
    match simulate(Path::new("carried.csv")) {
        Ok(text) => print!("{text}"),
        Err(errors) => eprintln!("{errors}"),
    }
}
