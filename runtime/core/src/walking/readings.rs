//! Readings of sensors, judged before anybody believes them: not finite, out of range, jumping, frozen.
use super::sensed::{Fault, MOST_JOINTS, Sensed, Settings};
use super::space::Vector;
use crate::control::slices::{get, set};
use crate::real::Scalar;

/// So many readings that repeat the last one to the last bit are none.
const FROZEN: u16 = 25;
/// So many jumped readings that agree with one another are where the joint is.
const SETTLED: u16 = 25;
/// A joint's reading may jump by as much, rad: counts of coarse encoders.
const COUNTS: f64 = 0.01;

/// Three axes of a sensor.
#[derive(Debug, Clone, Copy)]
pub(super) struct Axes<R> {
    last: Vector<R>,
    repeated: u16,
}

impl<R: Scalar> Axes<R> {
    /// Whether a reading is to be believed.
    fn judge(&mut self, reading: Vector<R>, range: R) -> bool {
        self.repeated = if reading == self.last { self.repeated.saturating_add(1) } else { 0 };
        self.last = reading;
        self.repeated < FROZEN && reading.iter().all(|x| x.abs() <= range)
    }
}

/// What is known of the joints, and of sensors before.
#[derive(Debug, Clone)]
pub(super) struct Readings<R> {
    /// The last ones believed.
    pub positions: [R; MOST_JOINTS],
    /// Filtered.
    pub velocities: [R; MOST_JOINTS],
    /// Those of the present sample are not believed.
    pub wrong: [bool; MOST_JOINTS],
    suspect: [R; MOST_JOINTS],
    suspected: [u16; MOST_JOINTS],
    gyroscope: Axes<R>,
    accelerometer: Axes<R>,
}

/// What the unit is believed to say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Believed<R> {
    pub angular_velocity: Option<Vector<R>>,
    pub specific_force: Option<Vector<R>>,
    /// N
    pub load: [Option<R>; 2],
}

impl<R: Scalar> Readings<R> {
    pub fn new() -> Self {
        let (zero, axes) = (R::constant(0.0), Axes { last: [R::constant(f64::INFINITY); 3], repeated: 0 });
        Self {
            positions: [zero; MOST_JOINTS],
            velocities: [zero; MOST_JOINTS],
            wrong: [false; MOST_JOINTS],
            suspect: [zero; MOST_JOINTS],
            suspected: [0; MOST_JOINTS],
            gyroscope: axes,
            accelerometer: axes,
        }
    }

    /// Judges a sample; `step` is the time since the last one, `None` for the first.
    pub fn take(
        &mut self,
        sensed: &Sensed<'_, R>,
        settings: &Settings<R>,
        step: Option<R>,
        fault: &mut Option<Fault>,
    ) -> Believed<R> {
        for (joint, position) in sensed.joint_position.iter().enumerate().take(MOST_JOINTS) {
            let right = self.joint(joint, *position, settings, step);
            set(&mut self.wrong, joint, !right);
            let velocity = sensed.joint_velocity.map(|all| get(all, joint));
            if velocity.is_some_and(|velocity| !velocity.is_finite()) {
                fault.get_or_insert(Fault::JointVelocity(joint));
            }
            if let Some(velocity) = velocity.filter(|velocity| velocity.is_finite()) {
                set(&mut self.velocities, joint, velocity);
            }
            if !right {
                fault.get_or_insert(Fault::JointPosition(joint));
            }
        }
        let [turning, accelerating] = settings.ranges;
        let gyroscope = self.gyroscope.judge(sensed.angular_velocity, turning);
        let accelerometer = self.accelerometer.judge(sensed.specific_force, accelerating);
        if !gyroscope {
            fault.get_or_insert(Fault::Gyroscope);
        }
        if !accelerometer {
            fault.get_or_insert(Fault::Accelerometer);
        }
        let mut load = [None; 2];
        for (foot, (place, reading)) in load.iter_mut().zip(sensed.load).enumerate() {
            *place = Some(reading).filter(|reading| reading.is_finite());
            if place.is_none() {
                fault.get_or_insert(Fault::Load(foot));
            }
        }
        Believed {
            angular_velocity: Some(sensed.angular_velocity).filter(|_| gyroscope),
            specific_force: Some(sensed.specific_force).filter(|_| accelerometer),
            load,
        }
    }

    /// Takes a joint's reading; `false`: it is not believed.
    fn joint(&mut self, joint: usize, position: R, settings: &Settings<R>, step: Option<R>) -> bool {
        let last = get(&self.positions, joint);
        let Some(step) = step else {
            let known = position.is_finite();
            set(&mut self.positions, joint, if known { position } else { R::constant(0.0) });
            return known;
        };
        let reach = settings.joint_speed * step + R::constant(COUNTS);
        if (position - last).abs() <= reach {
            self.follow(joint, position, (settings, step));
            return true;
        }
        if !position.is_finite() {
            return false;
        }
        // Somewhere else: after a while that is where it is.
        let again = (position - get(&self.suspect, joint)).abs() <= reach;
        let count = self.suspected.get(joint).copied().unwrap_or(0);
        let count = if again { count.saturating_add(1) } else { 0 };
        set(&mut self.suspected, joint, count);
        set(&mut self.suspect, joint, position);
        if count >= SETTLED {
            set(&mut self.positions, joint, position);
            set(&mut self.velocities, joint, R::constant(0.0));
            set(&mut self.suspected, joint, 0);
        }
        false
    }

    /// The next position, and the filtered difference.
    fn follow(&mut self, joint: usize, position: R, (settings, step): (&Settings<R>, R)) {
        let difference = (position - get(&self.positions, joint)) / step;
        let velocity = get(&self.velocities, joint);
        let part = step / (step + settings.velocity_filter);
        set(&mut self.velocities, joint, R::fused(part, difference - velocity, velocity));
        set(&mut self.positions, joint, position);
        set(&mut self.suspected, joint, 0);
    }
}
