//! What the simulated experiments share: runs of TUlip's scenarios, and what their logs say.
#![allow(dead_code)]
pub mod figure;
pub mod inverse;

use bipedc::simulation::plant;
use bipedc_analysis::simulate::{Mechanics, Run, Scenario, Simulation, Summary};
use bipedc_compiler::Robot;
use bipedc_runtime::Model;
use std::path::{Path, PathBuf};

/// Whatever went wrong, in words.
pub type Failure = Box<dyn std::error::Error>;

/// A file of TUlip.
pub fn tulip_file(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/tulip").join(name)
}

/// TUlip's description.
pub fn tulip() -> Result<Robot, Failure> {
    Robot::read(&tulip_file("")).map_err(|list| list.to_string().into())
}

/// The log of a run.
pub struct Trial {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
    pub summary: Summary,
    /// Of the robot, N.
    pub weight: f64,
}

impl Trial {
    /// Runs a scenario of TUlip, after `edit` changed it, on the emitted model.
    pub fn of_tulip(scenario: &str, edit: impl FnOnce(&mut Scenario)) -> Result<Self, Failure> {
        Self::run(&tulip()?, &tulip::Tulip, scenario, edit)
    }

    /// The same with another model and description: those of a simplified TUlip.
    pub fn run(
        robot: &Robot,
        model: &dyn Model<f64>,
        scenario: &str,
        edit: impl FnOnce(&mut Scenario),
    ) -> Result<Self, Failure> {
        let said = |found: bipedc_effects::diagnostic::Diagnostic| found.to_string();
        let tree = robot.tree().map_err(said)?;
        let plant = plant(&robot.description, &tree).map_err(said)?;
        let path = tulip_file(&format!("scenarios/{scenario}.toml"));
        let mut scenario = Scenario::open(&path, &plant).map_err(|list| list.to_string())?;
        edit(&mut scenario);
        let mechanics = Mechanics::new(model, plant.layout.base).map_err(said)?;
        let simulation =
            Simulation::new(mechanics, &plant, &scenario).and_then(Simulation::with_energy).map_err(said)?;
        let names = simulation.columns();
        let mut rows = Vec::new();
        let summary = simulation
            .run(&mut Run {
                row: &mut |row| {
                    rows.push(row.to_vec());
                    Ok(())
                },
                progress: &|_| (),
                stop: &|| false,
            })
            .map_err(said)?;
        Ok(Self { names, rows, summary, weight: 9.81 * tree.total_mass() })
    }

    /// A column of the log.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let at = self.names.iter().position(|n| n == name).unwrap_or_else(|| panic!("no column {name}"));
        self.rows.iter().map(|row| row[at]).collect()
    }

    /// s
    pub fn time(&self) -> Vec<f64> {
        self.column("time")
    }

    /// Index of the first row at or after this time.
    pub fn at(&self, time: f64) -> usize {
        self.rows.partition_point(|row| row[0] < time - 1e-9)
    }

    /// Position of a joint, rad.
    pub fn joint(&self, name: &str) -> Vec<f64> {
        self.column(&format!("{name}/position"))
    }

    /// Roll, pitch and yaw of the torso, rad.
    pub fn torso(&self) -> [Vec<f64>; 3] {
        let [x, y, z, w] = ["x", "y", "z", "w"].map(|axis| self.column(&format!("base/orientation/{axis}")));
        let each = |f: &dyn Fn(f64, f64, f64, f64) -> f64| -> Vec<f64> {
            (0..x.len()).map(|i| f(x[i], y[i], z[i], w[i])).collect()
        };
        [
            each(&|x, y, z, w| (2.0 * (w * x + y * z)).atan2(1.0 - 2.0 * (x * x + y * y))),
            each(&|x, y, z, w| (2.0 * (w * y - z * x)).clamp(-1.0, 1.0).asin()),
            each(&|x, y, z, w| (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z))),
        ]
    }

    /// What the sensor of a corner says, N.
    pub fn corner(&self, foot: &str, corner: &str) -> Vec<f64> {
        self.column(&format!("{foot}/{corner}/force/z"))
    }

    /// Sum of two corners, N.
    pub fn edge(&self, foot: &str, edge: &str) -> Vec<f64> {
        let [a, b] = match edge {
            "left" => ["front_left", "rear_left"],
            "right" => ["front_right", "rear_right"],
            "front" => ["front_left", "front_right"],
            _ => ["rear_left", "rear_right"],
        };
        self.corner(foot, a).iter().zip(self.corner(foot, b)).map(|(a, b)| a + b).collect()
    }

    /// Part of the lost energy that the balance does not explain.
    pub fn unexplained(&self) -> f64 {
        self.summary.energy.map_or(f64::NAN, |energy| (energy.remainder / energy.lost).abs())
    }

    /// J
    pub fn lost(&self) -> f64 {
        self.summary.energy.map_or(f64::NAN, |energy| energy.lost)
    }
}

/// Largest and smallest value.
pub fn range(values: &[f64]) -> [f64; 2] {
    values
        .iter()
        .filter(|x| x.is_finite())
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], &x| [low.min(x), high.max(x)])
}

/// Mean of a stretch.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// The extremum between every two crossings of `level`: index and distance from the level, with sign.
pub fn peaks(values: &[f64], level: f64) -> Vec<(usize, f64)> {
    let mut found: Vec<(usize, f64)> = Vec::new();
    for (i, value) in values.iter().enumerate() {
        let from = value - level;
        match found.last_mut() {
            Some(last) if last.1 * from >= 0.0 => {
                if from.abs() > last.1.abs() {
                    *last = (i, from);
                }
            }
            _ => found.push((i, from)),
        }
    }
    found
}
