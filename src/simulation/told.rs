//! What a controller was told and asked for, call by call, to the last bit: a log that its crate answers alike.
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::Output;
use bipedc_runtime::control::JointCommand;
use bipedc_runtime::walking::estimator::Sensed;
use bipedc_runtime::walking::steps::Velocity;
use std::fmt::Write as _;
use std::path::Path;

/// The file, as it is written.
#[derive(Debug)]
pub(super) struct ToldLog {
    file: Output,
    line: String,
    /// Whether the velocities of joints are measured.
    velocities: bool,
    /// Joints of whose motors the controller reads the angle.
    motors: Vec<usize>,
    failed: Option<Diagnostic>,
}

impl ToldLog {
    /// Of joints and feet (right, left) by name; `motors`: joints whose springs the controller knows.
    pub fn begin(
        path: &Path,
        (joints, velocities): (&[String], bool),
        motors: Vec<usize>,
        feet: [&str; 2],
    ) -> Result<Self, Diagnostic> {
        let mut names = vec!["time".to_owned()];
        names.extend(["forward", "left", "turning"].map(|way| format!("walking/{way}")));
        let quantities = ["position", "velocity", "effort"].into_iter();
        for quantity in quantities.filter(|quantity| velocities || *quantity != "velocity") {
            names.extend(joints.iter().map(|joint| format!("{joint}/{quantity}")));
        }
        for quantity in ["linear_acceleration", "angular_velocity"] {
            names.extend(["x", "y", "z"].map(|axis| format!("imu/{quantity}/{axis}")));
        }
        for foot in feet {
            names.extend(["force/z", "cop/x", "cop/y"].map(|quantity| format!("{foot}/{quantity}")));
        }
        names.extend(motors.iter().map(|joint| format!("{}/motor_position", joints[*joint])));
        let mut file = Output::create(path)?;
        file.put(&(names.join(",") + "\n"))?;
        Ok(Self { file, line: String::new(), velocities, motors, failed: None })
    }

    /// A call: commands are torques.
    pub fn note(&mut self, sensed: &Sensed<'_, f64>, wanted: Velocity<f64>, commands: &[JointCommand<f64>]) {
        let mut row = vec![sensed.time, wanted.forward, wanted.left, wanted.turning];
        row.extend(sensed.joint_position);
        if self.velocities {
            let unknown = vec![f64::NAN; commands.len()];
            row.extend(sensed.joint_velocity.unwrap_or(&unknown));
        }
        row.extend(commands.iter().map(|command| command.torque(0.0, 0.0)));
        row.extend(sensed.specific_force.iter().chain(&sensed.angular_velocity));
        for (load, [x, y]) in sensed.load.iter().zip(sensed.center) {
            row.extend([*load, x, y]);
        }
        let angle = |joint: &usize| sensed.motor_position.get(*joint).copied().unwrap_or(f64::NAN);
        row.extend(self.motors.iter().map(angle));
        self.line.clear();
        for (place, value) in row.iter().enumerate() {
            let comma = if place == 0 { "" } else { "," };
            // Writing to a string cannot fail; the digits are as many as tell the number from its neighbours.
            let _ = match value.is_nan() {
                true => write!(self.line, "{comma}"),
                false => write!(self.line, "{comma}{value}"),
            };
        }
        self.line.push('\n');
        if self.failed.is_none() {
            self.failed = self.file.put(&self.line).err();
        }
    }

    /// The file, waiting to take its place.
    pub fn end(self) -> Result<Output, Diagnostic> {
        self.failed.map_or(Ok(self.file), Err)
    }
}
