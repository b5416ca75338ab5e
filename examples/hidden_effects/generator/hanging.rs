//! A robot with its torso bolted to a stand; its joints follow sums of sines under control.
use super::drive::{Drive, Mechanism, Moving, mechanism, smooth_torque};
use super::model::{Rigid, read, with_effects};
use super::motion::{self, JointMotion};
use super::outside::Outsider;
use super::random::Random;
use super::truth::{Plan, Scales, Truth};
use super::{Failure, Made, draw, failure, inertia, sensors};
use bipedc_compiler::robot::Robot;
use bipedc_runtime::Argument;
use nalgebra::{DMatrix, DVector};
use std::collections::VecDeque;
use std::path::Path;

/// Steps per second of the integration.
pub const STEPS: f64 = 4000.0;
/// Seconds before the log begins, in which the controller settles.
const RUN_UP: f64 = 1.0;
/// Length of the two logs, s.
pub const DURATION: [f64; 2] = [14.0, 9.0];

/// One joint without sensor errors.
#[derive(Debug, Clone, Default)]
pub struct Signals {
    /// True angle of the link, rad.
    pub q: Vec<f64>,
    /// rad/s
    pub v: Vec<f64>,
    /// rad/s²
    pub a: Vec<f64>,
    /// Reported torque, N m.
    pub u: Vec<f64>,
    /// Motor angle behind a gear that gives way, else empty, rad.
    pub motor: Vec<f64>,
}

/// A run without sensor errors.
#[derive(Debug, Clone, Default)]
pub struct Recording {
    /// s
    pub time: Vec<f64>,
    /// In the order of the model.
    pub joints: Vec<Signals>,
}

/// Draws, simulates and measures a case.
pub fn generate(plan: &Plan, folder: &Path) -> Result<Made, Failure> {
    let nominal = read(folder, true)?;
    let mut random = Random::named(&plan.seed);
    // What happens at low speed shows where there is much of it.
    let slow = plan.parts.iter().any(|part| part.kind == "stribeck_friction");
    let pace = if slow { 0.35 } else { 1.0 };
    let motions = [(); 2].map(|()| motion::draw(&nominal.description, pace, &mut random));
    let resting = |motion: Vec<JointMotion>| motion.into_iter().map(JointMotion::with_rests).collect();
    let motions = if plan.rests { motions.map(resting) } else { motions };
    let mut truth = Truth::new(plan);
    let rigid = rigid(&nominal)?;
    // Those that are held are drawn as well: all others are what they were.
    let moves = |name: &String| plan.moving.is_empty() || plan.moving.contains(&name.as_str());
    let held = |(motion, name): (JointMotion, &String)| if moves(name) { motion } else { motion.held() };
    let motions = motions.map(|all| all.into_iter().zip(&rigid.joints).map(held).collect::<Vec<_>>());
    let quiet = run(&rigid, &[], &motions[0], 6.0, 250.0)?;
    truth.scales = scales(&rigid, &quiet);
    draw::effects(plan, &nominal.description, &mut truth, &mut random);

    let mut actual = with_effects(&nominal, &truth.effects)?;
    if truth.cad_errors {
        inertia::cad_errors(&mut actual.description, plan.size, &mut random);
    }
    let changed = self::rigid(&actual)?;
    let acting = truth.acting();
    let local: Vec<_> = acting.iter().filter(|effect| effect.location.joint.is_some()).cloned().collect();
    let clean = [0, 1].map(|i| run(&changed, &local, &motions[i], DURATION[i], plan.rate));
    let [train, validation] = clean;
    sensors::measure_hanging(
        plan,
        [&nominal, &actual],
        &rigid,
        truth,
        [train?, validation?],
        &local,
        &mut random,
    )
}

/// The functions that the simulation needs.
pub fn rigid(robot: &Robot) -> Result<Rigid, Failure> {
    Rigid::new(robot, &["mass_matrix", "bias", "inverse_dynamics"])
}

fn scales(rigid: &Rigid, run: &Recording) -> std::collections::BTreeMap<String, Scales> {
    let of = |joint: &Signals| Scales::of([&joint.q, &joint.v, &joint.a, &joint.u]);
    rigid.joints.iter().cloned().zip(run.joints.iter().map(of)).collect()
}

/// Simulates joints with these effects on a given motion.
pub fn run(
    rigid: &Rigid,
    effects: &[bipedc_effects::effect::Effect],
    motion: &[JointMotion],
    duration: f64,
    rate: f64,
) -> Result<Recording, Failure> {
    let mut drives = mechanism(&rigid.joints, effects)?;
    let center: Vec<f64> = motion.iter().map(|joint| joint.center).collect();
    let mass = rigid.run(rigid.function("mass_matrix")?, &[(Argument::Q, &center)]);
    let mass = DMatrix::from_vec(motion.len(), motion.len(), mass);
    let inverse = mass.clone().try_inverse().ok_or_else(|| failure("the mass matrix is singular"))?;
    for (j, drive) in drives.iter_mut().enumerate() {
        drive.gains = gains(drive, motion[j].rests, mass[(j, j)], 1.0 / inverse[(j, j)]);
    }
    simulate(rigid, drives, motion, duration, rate)
}

/// Simulates joints with these drives.
fn simulate(
    rigid: &Rigid,
    drives: Mechanism,
    motion: &[JointMotion],
    duration: f64,
    rate: f64,
) -> Result<Recording, Failure> {
    let mut simulation = Simulation::new(rigid, drives, motion)?;
    let every = (STEPS / rate).round().max(1.0) as usize;
    let samples = (duration * rate).round() as usize + 1;
    let before = (RUN_UP * STEPS) as usize;
    let mut recording = Recording { time: Vec::new(), joints: vec![Signals::default(); motion.len()] };
    for step in 0..before + (samples - 1) * every + 1 {
        let time = (step as f64 - before as f64) * simulation.step;
        simulation.advance(time);
        if step >= before && (step - before).is_multiple_of(every) {
            recording.time.push(((step - before) / every) as f64 / rate);
            simulation.record(&mut recording.joints);
        }
    }
    Ok(recording)
}

/// Of a controller with a bandwidth of 60 rad/s, so that dry joints stick only briefly; of 20 where they are to rest; slower where a limit
/// would wind it up, or a spring or delay would make it unstable.
/// `inertia` is that with all other joints held, `apparent` with all others free.
fn gains(drive: &Drive, rests: bool, inertia: f64, apparent: f64) -> [f64; 2] {
    // Stiffer than a light joint asks for, as far as the integration's step allows.
    let light = inertia.max(0.02).min(8.0 * apparent);
    let (bandwidth, inertia) = match drive {
        _ if drive.delay > 0.0 => (15.0, inertia),
        _ if drive.limit.is_finite() || drive.elastic.is_some() => (30.0, light),
        _ => (if rests { 20.0 } else { 60.0 }, light),
    };
    [inertia * bandwidth * bandwidth, 1.4 * inertia * bandwidth]
}

/// State of the integration: positions at whole steps, velocities half a step earlier (leapfrog).
struct Simulation<'a> {
    rigid: &'a Rigid,
    mass: super::model::Function,
    bias: super::model::Function,
    drives: Mechanism,
    motion: &'a [JointMotion],
    step: f64,
    q: Vec<f64>,
    /// Half a step before `q`; after [`Self::advance`] half a step after the last recorded position.
    half: Vec<f64>,
    motor: Vec<[f64; 2]>,
    /// Loose parts on springs: angle and half-step velocity.
    loose: Vec<[f64; 2]>,
    queue: Vec<VecDeque<f64>>,
    dry: Vec<f64>,
    last: Last,
}

/// What was true at the last whole step.
#[derive(Default)]
struct Last {
    q: Vec<f64>,
    v: Vec<f64>,
    a: Vec<f64>,
    u: Vec<f64>,
    motor: Vec<f64>,
}

impl<'a> Simulation<'a> {
    fn new(rigid: &'a Rigid, drives: Mechanism, motion: &'a [JointMotion]) -> Result<Self, Failure> {
        let step = 1.0 / STEPS;
        let without_rotor = |drive: &Drive| drive.elastic.is_some_and(|e| e.motor_inertia <= 0.0);
        if drives.iter().any(without_rotor) {
            return Err(failure("a motor behind a spring or play needs a `rotor_inertia`"));
        }
        let start: Vec<[f64; 3]> = motion.iter().map(|joint| joint.at(-RUN_UP)).collect();
        let n = motion.len();
        let queue =
            drives.iter().map(|drive| VecDeque::from(vec![0.0; (drive.delay / step).round() as usize]));
        Ok(Self {
            rigid,
            mass: rigid.function("mass_matrix")?,
            bias: rigid.function("bias")?,
            queue: queue.collect(),
            motion,
            step,
            q: start.iter().map(|s| s[0]).collect(),
            half: start.iter().map(|s| s[1]).collect(),
            motor: start.iter().map(|s| [s[0], s[1]]).collect(),
            loose: start.iter().map(|s| [s[0], s[1]]).collect(),
            dry: vec![0.0; n],
            last: Last { a: vec![0.0; n], ..Last::default() },
            drives,
        })
    }

    fn record(&self, joints: &mut [Signals]) {
        for (j, joint) in joints.iter_mut().enumerate() {
            joint.q.push(self.last.q[j]);
            joint.v.push(self.last.v[j]);
            joint.a.push(self.last.a[j]);
            joint.u.push(self.last.u[j]);
            if self.drives[j].elastic.is_some() {
                joint.motor.push(self.last.motor[j]);
            }
        }
    }

    /// One step from `time`; see the module `drive` for the signs.
    fn advance(&mut self, time: f64) {
        let (n, h) = (self.q.len(), self.step);
        // Velocity at the whole step, as far as it is known before the acceleration is.
        let v: Vec<f64> = (0..n).map(|j| self.half[j] + 0.5 * h * self.last.a[j]).collect();
        let arguments = [(Argument::Q, &self.q[..]), (Argument::V, &v[..])];
        let bias = DVector::from_vec(self.rigid.run(self.bias, &arguments));
        let rigid_mass = DMatrix::from_vec(n, n, self.rigid.run(self.mass, &arguments));
        let load = &rigid_mass * DVector::from_column_slice(&self.last.a) + &bias;
        let mut mass = rigid_mass;
        for (j, drive) in self.drives.iter().enumerate() {
            mass[(j, j)] += drive.rotor;
            if let Some((other, [inertia, ..])) = drive.coupling {
                mass[(j, other)] += inertia;
            }
        }
        let (reported, torque) = self.torques(time, &v);
        let inverse = mass.lu();
        let mut a = inverse.solve(&(torque - bias)).unwrap_or_else(|| DVector::zeros(n));
        self.rub(time, &v, &load, &mut a, |column| inverse.solve(column));
        self.finish(reported, a);
    }

    /// Reported torques, and those on the links from drives and everything smooth.
    fn torques(&mut self, time: f64, v: &[f64]) -> (Vec<f64>, DVector<f64>) {
        let (n, h) = (self.q.len(), self.step);
        let state = Moving { q: &self.q, v };
        let mut reported = vec![0.0; n];
        let mut torque = DVector::zeros(n);
        for (j, drive) in self.drives.iter().enumerate() {
            let [q, w, _] = self.motion[j].at(time);
            let elastic = drive.elastic.is_some();
            let (angle, speed) =
                if elastic { (self.motor[j][0], self.motor[j][1]) } else { (self.q[j], v[j]) };
            let wanted = drive.gains[0] * (q - angle) + drive.gains[1] * (w - speed);
            reported[j] = wanted + drive.bias;
            self.queue[j].push_back(wanted);
            let late = self.queue[j].pop_front().unwrap_or(wanted);
            let acting = (drive.gain * late).clamp(-drive.limit, drive.limit);
            torque[j] = -smooth_torque(drive, j, &state)
                + match &drive.elastic {
                    None => acting,
                    Some(elastic) => {
                        let [angle, speed] = &mut self.motor[j];
                        let passed = elastic.torque(*angle - self.q[j], *speed - v[j]);
                        *speed += h * (acting - passed) / elastic.motor_inertia;
                        passed
                    }
                };
            for outsider in &drive.outsiders {
                if let Outsider::Oscillator([inertia, stiffness, damping]) = *outsider {
                    let [angle, speed] = &mut self.loose[j];
                    let pull = stiffness * (*angle - self.q[j]) + damping * (*speed - v[j]);
                    torque[j] += pull;
                    *speed -= h * pull / inertia;
                    *angle += h * *speed;
                }
            }
        }
        (reported, torque)
    }

    /// Dry friction that stops a joint at the end of the step, or as much of it as there is: Gauss–Seidel over the
    /// joints that have some.
    fn rub(
        &mut self,
        time: f64,
        v: &[f64],
        load: &DVector<f64>,
        a: &mut DVector<f64>,
        solve: impl Fn(&DVector<f64>) -> Option<DVector<f64>>,
    ) {
        let n = self.q.len();
        let mut rubbing = Vec::new();
        for (j, drive) in self.drives.iter().enumerate() {
            let extra: f64 = drive.outsiders.iter().map(|o| o.dry(self.q[j], time)).sum();
            let limits = drive.dry.iter().map(|dry| dry.limits(v[j], load[j]));
            let [positive, negative] = limits.fold([extra; 2], |sum, l| [sum[0] + l[0], sum[1] + l[1]]);
            if positive > 0.0 || negative > 0.0 {
                let mut unit = DVector::zeros(n);
                unit[j] = 1.0;
                let Some(column) = solve(&unit) else { continue };
                // Start from the friction of the last step.
                a.axpy(-self.dry[j], &column, 1.0);
                rubbing.push((j, positive, negative, column));
            }
        }
        for _ in 0..50 {
            let mut change: f64 = 0.0;
            for (j, positive, negative, column) in &rubbing {
                let after = self.half[*j] + self.step * a[*j];
                let wanted = self.dry[*j] + after / (self.step * column[*j]);
                let next = wanted.clamp(-negative, *positive);
                let by = next - self.dry[*j];
                a.axpy(-by, column, 1.0);
                self.dry[*j] = next;
                change = change.max(by.abs());
            }
            if change < 1e-10 {
                break;
            }
        }
    }

    fn finish(&mut self, reported: Vec<f64>, a: DVector<f64>) {
        let h = self.step;
        self.last.q.clone_from(&self.q);
        self.last.v = (0..self.q.len()).map(|j| self.half[j] + 0.5 * h * a[j]).collect();
        self.last.motor = self.motor.iter().map(|motor| motor[0]).collect();
        self.last.u = reported;
        for j in 0..self.q.len() {
            self.half[j] += h * a[j];
            self.q[j] += h * self.half[j];
            self.motor[j][0] += h * self.motor[j][1];
        }
        self.last.a = a.as_slice().to_vec();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generator::drive::Dry;

    fn five_link(functions: &[&str]) -> Rigid {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/five_link");
        Rigid::new(&read(&folder, true).unwrap(), functions).unwrap()
    }

    fn motion(rigid: &Rigid) -> Vec<JointMotion> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/five_link");
        let robot = read(&folder, true).unwrap();
        assert_eq!(rigid.joints.len(), 4);
        motion::draw(&robot.description, 1.0, &mut Random::named("energy"))
    }

    #[test]
    fn a_free_robot_keeps_its_energy() {
        let rigid = five_link(&["mass_matrix", "bias", "kinetic_energy", "potential_energy"]);
        let run = simulate(&rigid, vec![Drive::default(); 4], &motion(&rigid), 3.0, 200.0).unwrap();
        let energy = |i: usize| {
            let q: Vec<f64> = run.joints.iter().map(|s| s.q[i]).collect();
            let v: Vec<f64> = run.joints.iter().map(|s| s.v[i]).collect();
            let part = |name: &str| {
                rigid.run(rigid.function(name).unwrap(), &[(Argument::Q, &q), (Argument::V, &v)])[0]
            };
            [part("kinetic_energy"), part("potential_energy")]
        };
        let start: f64 = energy(0).iter().sum();
        let swing = (0..run.time.len()).map(|i| energy(i)[0]).fold(0.0, f64::max);
        let drift =
            (0..run.time.len()).map(|i| (energy(i).iter().sum::<f64>() - start).abs()).fold(0.0, f64::max);
        println!("largest kinetic energy {swing} J, drift {drift} J");
        assert!(swing > 1.0 && drift < 1e-3 * swing, "drift {drift} J of {swing} J");
    }

    #[test]
    fn dry_friction_above_the_load_holds_a_joint_still() {
        let rigid = five_link(&["mass_matrix", "bias"]);
        let hold =
            Drive { dry: vec![Dry::Constant { positive: 500.0, negative: 500.0 }], ..Drive::default() };
        let run = simulate(&rigid, vec![hold; 4], &motion(&rigid), 1.0, 200.0).unwrap();
        for joint in &run.joints {
            let moved = joint.q.iter().map(|q| (q - joint.q[0]).abs()).fold(0.0, f64::max);
            assert!(moved < 1e-12, "slipped by {moved} rad");
        }
    }
}
