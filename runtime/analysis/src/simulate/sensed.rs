//! What sensors tell a controller before each step: joints, loads of the feet, inertial unit; nothing of where the base is.
use super::drives::Drives;
use super::imu::Imu;
use super::sensing::{Sample, Sensing};
use bipedc_runtime::control::Observation;
use nalgebra::{UnitQuaternion, Vector3};

/// Readings of the present step.
pub(super) struct Sensed<'a> {
    /// With noise of its own: a log is read at other times.
    pub sensing: Sensing<'a>,
    imu: Option<Imu>,
    /// Places in a row.
    positions: Vec<usize>,
    velocities: Vec<usize>,
    pushes: Vec<usize>,
    pressed: Vec<[usize; 2]>,
    /// Of each joint's motor, and its turns per turn of the joint.
    motors: Vec<Option<(usize, f64)>>,
    pub sample: Sample,
    row: Vec<f64>,
    /// As the model's, of which the base is unknown.
    q: Vec<f64>,
    v: Vec<f64>,
    loads: Vec<f64>,
    centers: Vec<[f64; 2]>,
    /// As seen at the joint.
    angles: Vec<f64>,
    inertial: Option<[[f64; 3]; 2]>,
}

impl<'a> Sensed<'a> {
    pub fn new(sensing: Sensing<'a>, imu: Option<Imu>, feet: &[String]) -> Self {
        let columns = sensing.columns();
        let ending = |with: &str| {
            let own = columns
                .iter()
                .enumerate()
                .filter(|(_, name)| name.ends_with(with) && !name.starts_with("base/"));
            own.map(|(place, _)| place).collect::<Vec<_>>()
        };
        let place = |foot: &String, of: &str| columns.iter().position(|name| *name == format!("{foot}/{of}"));
        let center = |foot| Some([place(foot, "cop/x")?, place(foot, "cop/y")?]);
        Self {
            positions: ending("/position"),
            velocities: ending("/velocity"),
            pushes: feet.iter().filter_map(|foot| place(foot, "force/z")).collect(),
            pressed: feet.iter().filter_map(center).collect(),
            motors: sensing.motors(),
            sensing,
            imu,
            sample: Sample::default(),
            row: Vec::new(),
            q: Vec::new(),
            v: Vec::new(),
            loads: Vec::new(),
            centers: Vec::new(),
            angles: Vec::new(),
            inertial: None,
        }
    }

    /// Reads the sample, and the inertial unit: readings in its own axes.
    pub fn read(&mut self, drives: &Drives, base: [usize; 2], inertial: Option<Vec<f64>>) {
        self.sensing.row(&self.sample, drives, &mut self.row);
        let of = |places: &[usize], into: &mut Vec<f64>, base: usize| {
            into.clear();
            into.resize(base, f64::NAN);
            into.extend(places.iter().map(|place| self.row[*place]));
        };
        of(&self.positions, &mut self.q, base[0]);
        of(&self.velocities, &mut self.v, base[1]);
        of(&self.pushes, &mut self.loads, 0);
        self.centers.clear();
        self.centers.extend(self.pressed.iter().map(|center| center.map(|place| self.row[place])));
        self.angles.clear();
        let angle =
            |motor: &Option<(usize, f64)>| motor.map_or(f64::NAN, |(place, turns)| self.row[place] / turns);
        self.angles.extend(self.motors.iter().map(angle));
        self.v.resize(base[1] + self.positions.len(), f64::NAN);
        self.inertial = self.imu.as_ref().zip(inertial).and_then(|(imu, readings)| {
            let [roll, pitch, yaw] = imu.rotation;
            let mounted = UnitQuaternion::from_euler_angles(roll, pitch, yaw);
            let [a, b, c, d, e, f] = readings[..].try_into().ok()?;
            Some([(mounted * Vector3::new(a, b, c)).into(), (mounted * Vector3::new(d, e, f)).into()])
        });
    }

    /// What the controller is told.
    pub fn observed(&self, time: f64) -> Observation<'_, f64> {
        let observed = Observation::new(time, 0, &self.q, &self.v);
        let observed = observed.with_loads(&self.loads).with_centers(&self.centers).with_motors(&self.angles);
        match self.inertial {
            Some(inertial) => observed.with_inertial(inertial),
            None => observed,
        }
    }
}
