//! Controllers, motors and the laws of joints around a step: what they give before it, what they reported after it.
use super::carried::Carried;
use super::control::{JointServos, refused};
use super::driven_joint::Reading;
use super::instability::Swing;
use super::resistance::Variables;
use super::run::Simulation;
use super::servo::DriveServo;
use crate::robot::BaseKind;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Servo};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};

/// h² k/D from which on a spring that is held swings within some twenty steps.
const NOTICEABLE: f64 = 0.1;

/// What a motor is commanded in the present step, and the joint's state before it.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Command {
    /// Reported torque but for the back-EMF, N m.
    torque: f64,
    /// Back-EMF per speed, as reported, N m s/rad.
    damping: f64,
    /// Torque that truly acts but for the back-EMF, N m: of held controllers.
    applied: f64,
    /// Viscous friction with the back-EMF, N m s/rad.
    loss: f64,
    rotor_inertia: f64,
    /// Speed of the motor's axis before the step, rad/s.
    speed: f64,
    clipped: bool,
}

/// Where a torque is measured that a log reports.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum EffortSensor {
    /// Motor current times torque constant times gear.
    #[default]
    Motor,
    /// A torque sensor between motor and link.
    Joint,
}

impl Simulation<'_> {
    /// Torques that the controllers ask for, and laws of friction, of the next step.
    ///
    /// # Errors
    /// A held controller that is unstable at this step.
    pub(super) fn control(&mut self, time: f64) -> Result<(), Diagnostic> {
        self.force.fill(0.0);
        self.push(time);
        self.load(time);
        self.inside.clear();
        if let Some(energy_flow) = &mut self.energy_flow {
            energy_flow.torque.fill(0.0);
        }
        match self.ask(time) {
            Err(refusal) if self.keeps_refused && time > 0.0 => {
                self.summary.refused = Some(refusal.message);
                return Ok(());
            }
            asked => asked?,
        }
        for j in 0..self.commands.len() {
            self.resist(j);
            self.command(j, time)?;
        }
        self.stepper.set_servos(self.inside.iter().copied());
        Ok(())
    }

    /// What the controllers ask for: the scenario's servos first, others over them.
    fn ask(&mut self, time: f64) -> Result<(), Diagnostic> {
        let scenario = self.scenario;
        let ahead = if scenario.inside { 0.5 * scenario.step } else { 0.0 };
        self.weigh();
        for j in 0..self.motors.len() {
            self.motors[j] = self.drives.motor(j).map_or(f64::NAN, |motor| self.stepper.motor(motor)[0]);
        }
        self.sense(time);
        let observed = Observation::new(time, 0, &self.motion.q, &self.motion.v);
        let observed = observed.with_loads(&self.loads).with_centers(&self.centers).with_motors(&self.motors);
        let mut asked = JointServos::new(&scenario.servos, ahead).command(&observed, &mut self.asked);
        if let Some(controller) = &mut self.controller {
            if time == 0.0 {
                asked = asked.and_then(|()| controller.begin_phase(&observed));
            }
            let told = match &self.sensed {
                Some(sensed) => sensed.observed(time),
                None => observed,
            };
            asked = asked.and_then(|()| controller.command(&told, &mut self.asked));
        }
        asked.map_err(|refusal| refused(refusal, None, time))?;
        match &mut self.phased {
            Some(phased) => phased.command(&self.stepper, &self.motion, time, &mut self.asked),
            None => Ok(()),
        }
    }

    /// What pushes the origin of the base over the step that begins.
    fn push(&mut self, time: f64) {
        let middle = time + 0.5 * self.scenario.step;
        for push in &self.scenario.pushes {
            let force = push.force(middle);
            if force == 0.0 {
                continue;
            }
            let (sine, cosine) = push.direction.sin_cos();
            let q = &self.motion.q;
            if self.plant.layout.base == BaseKind::Floating {
                // Linear velocities of the base are in its own axes.
                let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]));
                let own = turn.inverse() * Vector3::new(force * cosine, force * sine, 0.0);
                self.force.iter_mut().zip(own.iter()).for_each(|(f, own)| *f += own);
            } else if let Some(first) = self.force.first_mut() {
                *first += force;
            }
        }
    }

    /// Puts onto the root link what it carries from now on.
    fn load(&mut self, time: f64) {
        let middle = time + 0.5 * self.scenario.step;
        let on_it = self.scenario.payloads.iter().filter(|payload| payload.time <= middle);
        if let Some(sum) = on_it.map(|payload| payload.carried).reduce(Carried::and) {
            self.stepper.carry(sum);
        }
    }

    /// What sensors say now: forces and torques are those of the last step.
    fn sense(&mut self, time: f64) {
        let Some(mut sensed) = self.sensed.take() else { return };
        self.take(&mut sensed.sample, time);
        self.measured(&mut sensed.sample.forces);
        sensed.sample.effort.clone_from(&self.effort[0]);
        sensed.sample.current.clone_from(&self.current[0]);
        let step = self.scenario.step;
        let inertial = self.inertial.as_ref().map(|unit| unit.say(step, sensed.sensing.random()));
        let joints = self.commands.len();
        let base = [self.motion.q.len() - joints, self.motion.v.len() - joints];
        sensed.read(&self.drives, base, inertial);
        self.sensed = Some(sensed);
    }

    /// Normal force of the last step on each foot, N, and its centre, m.
    fn weigh(&mut self) {
        let mut point = 0;
        for ((load, center), foot) in self.loads.iter_mut().zip(&mut self.centers).zip(&self.plant.feet) {
            let (mut push, mut moment) = (0.0, [0.0; 2]);
            for corner in 0..foot.corners.len() {
                let touches = point < self.stepper.mechanics().points();
                let force = if touches { self.stepper.impulse(point)[2] } else { 0.0 };
                let place = foot.corner(corner);
                push += force;
                moment = [moment[0] + place.x * force, moment[1] + place.y * force];
                point += 1;
            }
            *load = push / self.scenario.step;
            *center = moment.map(|moment| if push > 0.0 { moment / push } else { f64::NAN });
        }
    }

    /// Position and velocity of a joint.
    fn joint(&self, j: usize) -> [f64; 2] {
        let joints = self.commands.len();
        let (q, v) = (&self.motion.q, &self.motion.v);
        [q[q.len() - joints + j], v[v.len() - joints + j]]
    }

    /// Position and velocity of what the motor of a joint turns.
    fn shaft(&self, j: usize) -> [f64; 2] {
        self.drives.motor(j).map_or_else(|| self.joint(j), |motor| self.stepper.motor(motor))
    }

    /// Index among the forces.
    fn coordinate(&self, axis: usize) -> usize {
        self.stepper.mechanics().nv() - self.commands.len() + axis
    }

    /// Smooth laws and friction of a joint: held at the middle of the step, with their slopes.
    fn resist(&mut self, j: usize) {
        let h = self.scenario.step;
        let joints = self.commands.len();
        let (nq, nv) = (self.motion.q.len(), self.motion.v.len());
        let (q, v) = (&self.motion.q[nq - joints..], &self.motion.v[nv - joints..]);
        // Friction that follows the load follows that of the last step: looking ahead would make it swing.
        let (rates, load) = (&self.acceleration, self.transmitted[j]);
        let state = |k: usize| [q[k] + 0.5 * h * v[k], v[k] + 0.5 * h * rates[k]];
        let own = Variables { own: [q[j] + 0.5 * h * v[j], v[j], rates[j]], load, ..Variables::default() };
        let link = self.drives.resistance(j, false, own, &state);
        let [angle, speed] = self.shaft(j);
        let motor = self.drives.motor(j);
        let (axis, coordinate) = (self.drives.axis(j), self.coordinate(j));
        self.force[coordinate] -= link.value;
        // At the middle of the step; of a motor behind a spring its speed before it.
        let middle = if motor.is_some() { speed } else { state(j)[1] };
        let dry = self.drives.dry(j, middle, load);
        let (_, rotor) = self.drives.constant(j);
        let laws = &mut self.stepper.joints_mut()[j];
        laws.slope = link.velocity;
        laws.rotor_inertia = link.acceleration + if motor.is_some() { 0.0 } else { rotor };
        match motor {
            None => laws.dry = dry,
            Some(motor) => {
                self.stepper.motors_mut()[motor].dry = dry;
                let own =
                    Variables { own: [angle + 0.5 * h * speed, speed, 0.0], load, ..Variables::default() };
                let ripple = self.drives.resistance(j, true, own, &|_| [0.0; 2]);
                let coordinate = self.coordinate(axis);
                self.force[coordinate] -= ripple.value;
            }
        }
    }

    /// What the drive of a joint makes of what it is asked for.
    fn command(&mut self, j: usize, time: f64) -> Result<(), Diagnostic> {
        let (viscous, rotor_inertia) = self.drives.constant(j);
        let [angle, speed] = self.shaft(j);
        let scenario = self.scenario;
        let reading = self.drives.reading(j, scenario.sensors.torque == EffortSensor::Joint);
        self.reference[j] = scenario.servos[j].reference.at(time)[0];
        self.commands[j] = Command { rotor_inertia, speed, loss: viscous, ..Command::default() };
        if self.drives.actuator(j).is_some_and(|actuator| !actuator.drive.has_motor()) {
            return Ok(());
        }
        match self.asked[j] {
            JointCommand::Servo(servo) if scenario.inside => self.ask_inside(j, &servo, reading),
            // Torques are held over the step.
            command => {
                let asked = self.hold(j, command, [angle, speed], reading);
                if let (Some(swing), JointCommand::Servo(servo)) =
                    (self.instability[j].swings(asked), command)
                {
                    self.refuse_gains(j, &servo, swing)?;
                }
            }
        }
        let loss = self.commands[j].loss;
        match self.drives.motor(j) {
            Some(motor) => self.stepper.motors_mut()[motor].damping = loss,
            None => self.stepper.joints_mut()[j].damping = loss,
        }
        Ok(())
    }

    /// A command that is worked out once per step, a servo's with what the encoder reads: the torque that is asked for.
    fn hold(
        &mut self,
        j: usize,
        command: JointCommand<f64>,
        [angle, speed]: [f64; 2],
        reading: Reading,
    ) -> f64 {
        let read = self.sensing.encoder(&self.drives, j, angle);
        let (asked, limit) = match command {
            JointCommand::Servo(servo) => (servo.unlimited(read, speed), servo.limit),
            other => (other.torque(read, speed), f64::INFINITY),
        };
        let limit = limit.min(self.scenario.servos[j].limit);
        let limited = asked.clamp(-limit, limit);
        let (given, late) = self.drives.give(j, limited, speed);
        let coordinate = self.coordinate(self.drives.axis(j));
        let applied = reading.torque(late);
        self.force[coordinate] += applied;
        if let Some(energy_flow) = &mut self.energy_flow {
            energy_flow.torque[j] = applied;
        }
        let command = &mut self.commands[j];
        command.torque = given.torque;
        command.damping = given.damping;
        command.applied = applied;
        command.loss += given.damping * reading.gain;
        command.clipped = limited != asked || given.clipped;
        limited
    }

    /// A controller inside the drive: a row of the step's problem.
    fn ask_inside(&mut self, j: usize, servo: &Servo<f64>, reading: Reading) {
        let command = &mut self.commands[j];
        let ([low, high], damping) = self.drives.range(j, command.speed);
        let most = servo.limit.min(self.scenario.servos[j].limit);
        let limits = [low.max(-most), high.min(most)];
        command.damping = damping;
        command.loss += damping * reading.gain;
        self.inside.push(DriveServo {
            axis: self.drives.axis(j),
            stiffness: reading.gain * servo.stiffness,
            damping: reading.gain * servo.damping,
            wanted: [servo.position - self.drives.encoder_offset(j), servo.velocity],
            bias: reading.gain * servo.torque + reading.offset,
            limits: limits.map(|limit| reading.torque(limit)),
        });
    }

    /// What the motors reported over the step that was just done, and what they transmitted.
    pub(super) fn report(&mut self) {
        let h = self.scenario.step;
        self.effort.swap(0, 1);
        self.current.swap(0, 1);
        let sensor = self.scenario.sensors.torque == EffortSensor::Joint;
        for j in 0..self.commands.len() {
            let axis = self.drives.axis(j);
            let mut command = self.commands[j];
            let speed = self.shaft(j)[1];
            let mean = 0.5 * (command.speed + speed);
            if self.inside.iter().any(|servo| servo.axis == axis) {
                self.answer(j, axis, &mut command);
            }
            self.clipped[j] += usize::from(command.clipped);
            let reported = command.torque - command.damping * mean;
            let now = self.joint(j)[1];
            self.transmitted[j] = match self.drives.motor(j) {
                Some(motor) => self.stepper.spring_torque(motor),
                None => {
                    let friction = self.stepper.dry_impulse(j) / h - command.loss * mean;
                    command.applied + friction - command.rotor_inertia * (now - command.speed) / h
                }
            };
            self.acceleration[j] = (now - self.joint_speed[j]) / h;
            self.joint_speed[j] = now;
            self.effort[0][j] = if sensor { self.drives.sensed(j, self.transmitted[j]) } else { reported };
            let constant = self.drives.actuator(j).and_then(|actuator| actuator.drive.torque_per_ampere());
            self.current[0][j] = constant.map_or(f64::NAN, |constant| reported / constant);
        }
    }

    /// What a servo inside the drive gave in the step, and what it reports.
    fn answer(&self, j: usize, axis: usize, command: &mut Command) {
        let (h, scenario) = (self.scenario.step, self.scenario);
        let reading = self.drives.reading(j, scenario.sensors.torque == EffortSensor::Joint);
        let asked = (self.stepper.servo_asked(axis, h) - reading.offset) / reading.gain;
        let ([low, high], _) = self.drives.range(j, command.speed);
        let most = scenario.servos[j].limit;
        command.applied = self.stepper.servo_torque(axis, h);
        command.torque = asked.max(low.max(-most)).min(high.min(most));
        command.clipped = (command.torque - asked).abs() > 1e-6 * asked.abs();
    }

    /// Says which gain is too large, if it is.
    fn refuse_gains(&self, j: usize, servo: &Servo<f64>, swing: Swing) -> Result<(), Diagnostic> {
        let h = self.scenario.step;
        let mobility = self.stepper.mobility(self.drives.axis(j));
        // Held over a step, torques −k q − d q̇ on an inertia D are unstable where h d/D > 2, and where h d/D < ½ h² k/D.
        let (fade, turn) = (h * servo.damping * mobility, h * h * servo.stiffness * mobility);
        let motion = &self.plant.layout.joints[j];
        let unit = if motion.prismatic { ["N s/m", "N/m", "kg"] } else { ["N m s/rad", "N m/rad", "kg m²"] };
        // Joints that swing together are unstable earlier than each alone.
        let most = if swing == Swing::EveryStep { 0.8 } else { 2.0 };
        let (gain, help) = if fade >= most {
            let lower = servo.damping / fade;
            (format!("damping = {} {}", servo.damping, unit[0]), format!("lower the damping to {lower:.2}"))
        } else if turn >= NOTICEABLE && fade < 0.5 * turn {
            let least = 0.5 * h * servo.stiffness;
            (
                format!("stiffness = {} {}", servo.stiffness, unit[1]),
                format!("lower it, or raise the damping well above {least:.2} {}", unit[0]),
            )
        } else {
            return Ok(());
        };
        Err(Diagnostic::error(format!(
            "`{}`: the controller is unstable: its {gain}, held over a step of {h} s, makes it swing ever more (at {:.3} s; the joint resists with {:.2e} {})",
            motion.name,
            self.motion.time,
            1.0 / mobility,
            unit[2],
        ))
        .help(format!(
            "write `servo = \"drive\"` under [control], which is evaluated within the step; or {help}, or shorten `step`"
        )))
    }
}
