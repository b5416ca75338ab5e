//! Robots simulated in process: what the log says of effects, motors and sensors.
mod carried;
mod effects;
mod sensors;

use bipedc::simulation::{plant, true_model};
use bipedc_analysis::simulate::{Mechanics, Plant, Run, Scenario, Simulation};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::{Argument, Model, State};
use std::path::{Path, PathBuf};

/// A log in memory.
struct Log {
    names: Vec<String>,
    rows: Vec<Vec<f64>>,
}

impl Log {
    fn column(&self, name: &str) -> usize {
        self.names.iter().position(|other| other == name).unwrap_or_else(|| panic!("no column {name}"))
    }
    fn at(&self, row: usize, name: &str) -> f64 {
        self.rows[row][self.column(name)]
    }
    fn last(&self, name: &str) -> f64 {
        self.at(self.rows.len() - 1, name)
    }
    /// The column as a whole.
    fn all(&self, name: &str) -> Vec<f64> {
        let column = self.column(name);
        self.rows.iter().map(|row| row[column]).collect()
    }
}

fn robot(name: &str, base: Option<&str>) -> Robot {
    let folder: PathBuf = [env!("CARGO_MANIFEST_DIR"), "robots", name].iter().collect();
    let robot = Robot::read(&folder).unwrap();
    base.map_or_else(|| robot.clone(), |base| robot.clone().with_base(base, None).unwrap())
}

fn scenario(plant: &Plant, text: &str) -> Result<Scenario, String> {
    Scenario::parse(Path::new("scenario.toml"), text, plant).map_err(|errors| errors.to_string())
}

fn simulate(robot: &Robot, text: &str) -> Log {
    ran(robot, text).unwrap()
}

/// The log, or why there is none.
fn ran(robot: &Robot, text: &str) -> Result<Log, String> {
    let plant = plant(&robot.description, &robot.tree().unwrap()).unwrap();
    let scenario = scenario(&plant, text)?;
    let model = true_model(robot, &scenario.effects).unwrap();
    let mechanics = Mechanics::new(&model, plant.layout.base).unwrap();
    let simulation = Simulation::new(mechanics, &plant, &scenario).map_err(|error| error.to_string())?;
    let mut log = Log { names: simulation.columns(), rows: Vec::new() };
    let mut row = |values: &[f64]| {
        log.rows.push(values.to_vec());
        Ok(())
    };
    let run = simulation.run(&mut Run { row: &mut row, progress: &|_| (), stop: &|| false });
    run.map_err(|error| error.to_string())?;
    Ok(log)
}

const STEP: f64 = 5e-4;
/// Rows.
const SETTLED: usize = 800;
const JOINTS: [&str; 4] = ["right_hip_pitch", "right_knee_pitch", "left_hip_pitch", "left_knee_pitch"];
const JOINT: &str = "left_knee_pitch";
/// Five-link robot on a stand.
const SWING: &str = "duration = 1.5
step = 0.0005
[control]
stiffness = 300.0
damping = 5.0
servo = \"drive\"
effort_limits = false
[joint]
right_hip_pitch = { position = -0.2, sines = [[0.3, 0.5, 0.0], [0.1, 1.1, 1.0]] }
right_knee_pitch = { position = 0.6, sines = [[0.3, 0.4, 0.2], [0.1, 0.9, 0.5]] }
left_hip_pitch = { position = -0.2, sines = [[0.25, 0.45, 0.3], [0.1, 1.3, 0.0]] }
left_knee_pitch = { position = 0.6, sines = [[0.3, 0.55, 0.7], [0.12, 1.2, 0.0]] }
";

/// `inverse_dynamics` of a robot.
struct Torques(ProgramModel);

impl Torques {
    /// As `biped.toml` would have it with these effects.
    fn of(robot: &Robot, effects: &str) -> Self {
        let mut robot = robot.clone();
        let plant = plant(&robot.description, &robot.tree().unwrap()).unwrap();
        robot.description.effects = scenario(&plant, &format!("duration = 1.0\n{effects}")).unwrap().effects;
        let request = FunctionRequest::of_robot("inverse_dynamics");
        Self(ProgramModel::new(robot.compile_only(&[request]).unwrap()))
    }

    /// Logged minus derived efforts of all joints at a sample: acceleration is the mean of the two steps around it, as the
    /// logged effort is. And the velocities.
    fn missed(&self, log: &Log, row: usize, clip: f64) -> (Vec<f64>, Vec<f64>) {
        let of = |row: usize, quantity: &str| -> Vec<f64> {
            JOINTS.iter().map(|joint| log.at(row, &format!("{joint}/{quantity}"))).collect()
        };
        let (q, v) = (of(row, "position"), of(row, "velocity"));
        let change = of(row + 1, "velocity").into_iter().zip(of(row - 1, "velocity"));
        let a: Vec<f64> = change.map(|(next, last)| (next - last) / (2.0 * STEP)).collect();
        let state = State::new().with(Argument::Q, &q).with(Argument::V, &v).with(Argument::A, &a);
        let mut torque = vec![0.0; JOINTS.len()];
        Model::<f64>::evaluate(&self.0, 0, &state, &mut torque).unwrap();
        let mut effort = of(row, "effort");
        effort[3] = effort[3].clamp(-clip, clip);
        (effort.into_iter().zip(torque).map(|(effort, torque)| effort - torque).collect(), v)
    }

    /// Largest error where all joints move.
    fn worst(&self, log: &Log, clip: f64) -> f64 {
        let mut worst = 0.0_f64;
        // After the transient of the start, whose higher derivatives the samples do not show.
        for row in (SETTLED..log.rows.len() - 1).step_by(7) {
            let (missed, v) = self.missed(log, row, clip);
            // Friction turns round smoothly in the derived functions.
            // A sample is of two steps, of which one may be beyond the limit.
            let edge = (log.at(row, &format!("{JOINT}/effort")).abs() - clip).abs() < 0.5;
            if v.iter().all(|v| v.abs() > 0.25) && !edge {
                worst = missed.iter().fold(worst, |worst, error| worst.max(error.abs()));
            }
        }
        worst
    }
}

/// TUlip stands and is pushed.
const STAND: &str = "duration = 0.6
[control]
stiffness = 600.0
damping = 8.0
servo = \"drive\"
";

fn tulip(rest: &str) -> Log {
    simulate(&robot("tulip", None), &format!("{STAND}{rest}"))
}
