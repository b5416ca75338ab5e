//! What the log says of the true state: names of the columns, and a row of numbers.
use super::actuation::EffortSensor;
use super::drives::Drives;
use super::mechanics::rotate;
use super::plant::Plant;
use super::scenario::{Scenario, Sensors};
use super::turned::Turned;
use super::wrench::{Wrench, lever, moment};
use crate::robot::BaseKind;
use bipedc_effects::effect::{Acts, Effect, Law};
use bipedc_effects::random::Random;
use std::f64::consts::TAU;

/// Load below which a foot has no centre of pressure, N.
const LOADED: f64 = 1.0;

/// The truth at one sample.
#[derive(Debug, Clone, Default)]
pub struct Sample {
    /// s
    pub time: f64,
    /// As the model's.
    pub q: Vec<f64>,
    /// As the model's.
    pub v: Vec<f64>,
    /// Reported torques, N m.
    pub effort: Vec<f64>,
    /// Where the controllers want the joints, rad or m.
    pub reference: Vec<f64>,
    /// On the contact points, world axes, N.
    pub forces: Vec<[f64; 3]>,
    /// Axes of the soles, column after column; empty where the model does not tell them.
    pub soles: Vec<[f64; 9]>,
    /// Angles of motors behind a spring or play, as seen at the joint, rad; NaN where motor and joint are one.
    pub motor: Vec<f64>,
    /// Of the motors, A; NaN where there is none.
    pub current: Vec<f64>,
}

/// What a log has of a joint.
#[derive(Debug, Clone, Copy, Default)]
struct Channels {
    effort: bool,
    /// Turns of what is logged as the motor's angle per turn of the joint.
    motor: Option<f64>,
    current: bool,
    /// Counts per turn of the joint: of the joint's encoder and of the motor's; 0: exact.
    counts: [f64; 2],
    /// The controller's encoder is the motor's.
    by_motor: bool,
}

impl Channels {
    fn new(joint: usize, drives: &Drives, sensors: &Sensors) -> Self {
        let split = drives.motor(joint).is_some();
        let general = sensors.encoder_counts;
        let given = |own: f64| if own > 0.0 { own } else { general };
        let Some(actuator) = drives.actuator(joint) else {
            let motor = split.then_some(1.0);
            return Self { effort: true, motor, counts: [general; 2], by_motor: split, ..Self::default() };
        };
        let drive = &actuator.drive;
        let counts_of_motor = given(drive.motor_encoder_counts.unwrap_or(0.0) * drive.turns().abs());
        // Where nothing gives, the motor's encoder tells the joint's angle.
        let own = drive.joint_encoder_counts.unwrap_or(0.0);
        let of_joint = if own > 0.0 || split { given(own) } else { counts_of_motor };
        let current = drive.torque_constant.is_some() && drive.has_motor();
        let sensor = sensors.torque == EffortSensor::Joint;
        // A described drive is known by its current, at its shaft.
        let shaft = actuator.described && current && !sensor;
        Self {
            effort: !shaft && drive.has_motor(),
            motor: (shaft || split).then_some(if actuator.described { drive.turns() } else { 1.0 }),
            current,
            counts: [of_joint, counts_of_motor],
            by_motor: split || own == 0.0,
        }
    }
}

/// Turns samples into rows.
pub(super) struct Sensing<'a> {
    plant: &'a Plant,
    sensors: Sensors,
    /// Those of foot force sensors.
    effects: Vec<&'a Effect>,
    random: Random,
    /// Whether the log has feet and base.
    stands: bool,
    /// Whether it has the moments on the feet, for which samples need the axes of the soles.
    moments: bool,
    /// By joint.
    channels: Vec<Channels>,
    turned: Turned,
}

impl<'a> Sensing<'a> {
    pub fn new(
        plant: &'a Plant,
        scenario: &Scenario,
        drives: &Drives,
        effects: &[&'a Effect],
        turned: Turned,
    ) -> Self {
        let effects = effects.iter().filter(|e| e.kind.law.acts() == Acts::Sensor).copied().collect();
        let stands = plant.layout.base != BaseKind::Fixed;
        let sensors = scenario.sensors;
        let channels = (0..plant.layout.joints.len()).map(|j| Channels::new(j, drives, &sensors)).collect();
        Self {
            plant,
            sensors,
            effects,
            random: Random::new(scenario.seed),
            stands,
            moments: false,
            channels,
            turned,
        }
    }

    /// The same with other noise.
    pub fn seeded(self, seed: u64) -> Self {
        Self { random: Random::new(seed), ..self }
    }

    /// The same with the moments on the feet.
    pub fn with_moments(self, moments: bool) -> Self {
        Self { moments, ..self }
    }

    /// The numbers that noise is made from.
    pub fn random(&mut self) -> &mut Random {
        &mut self.random
    }

    /// Where a row has the angle of each joint's motor, and that motor's turns per turn of the joint; none where it has none.
    pub fn motors(&self) -> Vec<Option<(usize, f64)>> {
        let columns = self.columns();
        let place = |joint: &str| {
            let name = format!("{joint}/motor_position");
            columns.iter().position(|column| *column == name)
        };
        let joints = self.plant.joint_names().zip(&self.channels);
        joints.map(|(joint, channels)| Some((place(joint)?, channels.motor?))).collect()
    }

    /// Names of the columns, `time` first.
    pub fn columns(&self) -> Vec<String> {
        let mut names = vec!["time".to_owned()];
        for (joint, channels) in self.plant.joint_names().zip(&self.channels) {
            let wanted = [
                ("position", true),
                ("velocity", self.sensors.velocities),
                ("effort", channels.effort),
                ("reference", true),
                ("motor_position", channels.motor.is_some()),
                ("motor_current", channels.current),
            ];
            let wanted = wanted.iter().filter(|(_, there)| *there);
            names.extend(wanted.map(|(quantity, _)| format!("{joint}/{quantity}")));
        }
        if self.stands {
            for foot in &self.plant.feet {
                names.extend(
                    ["force/x", "force/y", "force/z", "cop/x", "cop/y"].map(|c| format!("{}/{c}", foot.name)),
                );
                names.extend(
                    foot.corners.iter().map(|corner| format!("{}/{}/force/z", foot.name, corner.name)),
                );
                if self.moments {
                    names.extend(["x", "y", "z"].map(|axis| format!("{}/torque/{axis}", foot.name)));
                }
            }
        }
        let base: &[&str] = match self.plant.layout.base {
            BaseKind::Fixed | BaseKind::Pivot => &[],
            BaseKind::Planar => &[
                "position/x",
                "position/z",
                "orientation/pitch",
                "linear_velocity/x",
                "linear_velocity/z",
                "angular_velocity/y",
            ],
            BaseKind::Floating => &[
                "position/x",
                "position/y",
                "position/z",
                "orientation/x",
                "orientation/y",
                "orientation/z",
                "orientation/w",
                "linear_velocity/x",
                "linear_velocity/y",
                "linear_velocity/z",
                "angular_velocity/x",
                "angular_velocity/y",
                "angular_velocity/z",
            ],
        };
        names.extend(base.iter().map(|name| format!("base/{name}")));
        names
    }

    /// The position that an encoder reads, without noise: what the controller works with.
    pub fn encoder(&self, drives: &Drives, joint: usize, position: f64) -> f64 {
        let Channels { counts, by_motor, .. } = self.channels[joint];
        rounded(position + drives.encoder_offset(joint), counts[usize::from(by_motor)])
    }

    /// A row, in the order of the columns; NaN where there is nothing.
    pub fn row(&mut self, sample: &Sample, drives: &Drives, row: &mut Vec<f64>) {
        row.clear();
        row.push(sample.time);
        let joints = self.plant.layout.joints.len();
        let (first_q, first_v) = (sample.q.len() - joints, sample.v.len() - joints);
        let sensors = self.sensors;
        for j in 0..joints {
            let position = sample.q[first_q + j] + drives.encoder_offset(j) + self.noise(sensors.position);
            let channels = self.channels[j];
            row.push(rounded(position, channels.counts[0]));
            if sensors.velocities {
                row.push(sample.v[first_v + j] + self.noise(sensors.velocity));
            }
            let effort = sample.effort[j] + self.noise(sensors.effort);
            if channels.effort {
                row.push(effort);
            }
            row.push(sample.reference[j]);
            self.motor(sample, drives, j, row);
        }
        if self.stands {
            self.feet(sample, row);
            if self.turned.is_none() {
                self.base(&sample.q, &sample.v, row);
            } else {
                let (mut q, mut v) = (sample.q.clone(), sample.v.clone());
                self.turned.into_log(&mut q, &mut v);
                self.base(&q, &v, row);
            }
        }
    }

    /// Angle and current of a joint's motor.
    fn motor(&mut self, sample: &Sample, drives: &Drives, j: usize, row: &mut Vec<f64>) {
        let (channels, sensors) = (self.channels[j], self.sensors);
        if let Some(turns) = channels.motor {
            let joint = sample.q[sample.q.len() - self.channels.len() + j];
            let own = if sample.motor[j].is_nan() { joint } else { sample.motor[j] };
            let angle = own + drives.encoder_offset(j) + self.noise(sensors.position);
            row.push(turns * rounded(angle, channels.counts[1]));
        }
        if channels.current {
            let current = sample.current[j] + self.noise(sensors.current);
            let step = sensors.current_step;
            row.push(if step > 0.0 { (current / step).round() * step } else { current });
        }
    }

    /// Forces, centres of pressure, moments.
    fn feet(&mut self, sample: &Sample, row: &mut Vec<f64>) {
        let mut first = 0;
        for (index, foot) in self.plant.feet.iter().enumerate() {
            let points = first..first + foot.corners.len();
            first = points.end;
            let axes = sample.soles.get(index).copied().unwrap_or([f64::NAN; 9]);
            let (mut sum, mut pressed, mut load) = (Wrench::default(), [0.0; 2], 0.0);
            let mut corners = Vec::with_capacity(foot.corners.len());
            for (point, corner) in points.zip(&foot.corners) {
                let force = self.of_corner(sample.forces[point]);
                let mut own = Wrench { force: self.turned.logged(force), moment: [0.0; 3] };
                let place = foot.corner(corners.len());
                let moment = self.turned.logged(moment(&axes, place, force));
                (0..3).for_each(|axis| sum.force[axis] += own.force[axis]);
                (0..3).for_each(|axis| sum.moment[axis] += moment[axis]);
                pressed = [pressed[0] + place.x * force[2], pressed[1] + place.y * force[2]];
                load += force[2];
                self.read([&foot.name, &format!("{}/{}", foot.name, corner.name)], [0.0; 3], &mut own);
                corners.push(own.force[2]);
            }
            let center = pressed.map(|pressed| if load > LOADED { pressed / load } else { f64::NAN });
            let arm = if load > LOADED { lever(&axes, [center[0], center[1], 0.0]) } else { [0.0; 3] };
            self.read([&foot.name, &foot.name], self.turned.logged(arm), &mut sum);
            row.extend(sum.force);
            row.extend(center);
            row.extend(corners);
            if self.moments {
                row.extend(sum.moment);
            }
        }
    }

    /// A corner's force with noise, as far as it is reported.
    fn of_corner(&mut self, mut force: [f64; 3]) -> [f64; 3] {
        let planar = self.plant.layout.base == BaseKind::Planar;
        for (axis, force) in force.iter_mut().enumerate() {
            if !(planar && axis == 1) {
                *force += self.sensors.force * self.random.normal();
            }
        }
        if self.sensors.force_limit > 0.0 {
            force[2] = force[2].min(self.sensors.force_limit);
        }
        force
    }

    /// A force through the effects of a foot's sensor, or of that of one of its corners. What a sensor does not report
    /// of a force is missing at the centre of pressure.
    fn read(&self, [foot, place]: [&str; 2], center: [f64; 3], wrench: &mut Wrench) {
        for effect in &self.effects {
            let sensor = effect.location.sensor.as_deref();
            if sensor.is_some_and(|sensor| sensor != foot && sensor != place) {
                continue;
            }
            let Wrench { force, moment } = wrench;
            match effect.kind.law {
                Law::ForceSensorGain => {
                    force.iter_mut().chain(moment).for_each(|x| *x *= effect.value("gain"));
                }
                Law::ForceSensorBias => {
                    (0..3).for_each(|i| force[i] += effect.value(["x", "y", "z"][i]));
                }
                _ => {
                    let lost = (force[2] - effect.value("limit")).max(0.0);
                    force[2] -= lost;
                    moment[0] -= center[1] * lost;
                    moment[1] += center[0] * lost;
                }
            }
        }
    }

    /// Pose and velocities of the base.
    fn base(&mut self, q: &[f64], v: &[f64], row: &mut Vec<f64>) {
        let s = self.sensors;
        if self.plant.layout.base == BaseKind::Planar {
            let noise = [s.base_position, s.base_position, s.base_orientation];
            for (value, deviation) in q[..3].iter().zip(noise) {
                row.push(value + self.noise(deviation));
            }
            for value in &v[..3] {
                row.push(value + self.noise(s.base_velocity));
            }
            return;
        }
        for value in &q[..3] {
            row.push(value + self.noise(s.base_position));
        }
        let turn = [0; 3].map(|_| 0.5 * self.noise(s.base_orientation));
        let own = [q[3], q[4], q[5], q[6]];
        let noisy = small_turn(own, turn);
        row.extend(noisy);
        for value in rotate(own, [v[0], v[1], v[2]]) {
            row.push(value + self.noise(s.base_velocity));
        }
        for value in &v[3..6] {
            row.push(value + self.noise(s.base_velocity));
        }
    }

    fn noise(&mut self, deviation: f64) -> f64 {
        // Every channel draws, so that switching one off leaves the noise of the others as it was.
        deviation * self.random.normal()
    }
}

/// A quaternion (x y z w) turned by half a rotation vector that is small.
fn small_turn([x, y, z, w]: [f64; 4], [a, b, c]: [f64; 3]) -> [f64; 4] {
    let turned = [
        x + w * a + y * c - z * b,
        y + w * b + z * a - x * c,
        z + w * c + x * b - y * a,
        w - x * a - y * b - z * c,
    ];
    let length = turned.iter().map(|x| x * x).sum::<f64>().sqrt();
    turned.map(|x| x / length)
}

/// To the nearest count; 0 counts per turn: exact.
fn rounded(value: f64, counts: f64) -> f64 {
    if counts > 0.0 { (value * counts / TAU).round() * TAU / counts } else { value }
}
