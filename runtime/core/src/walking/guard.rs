//! What stands between a controller and its drives: torques change by little from call to call whatever the controller says, and joints are braked while
//! nothing tells where they are.
use super::robot::MOST_VELOCITIES;
use crate::control::JointCommand;
use crate::control::slices::{get, set};
use crate::real::Scalar;

/// In one call a torque changes by at most this part of its drive's limit: from nothing to the limit in five calls. Undisturbed walks ask for more in one of
/// a thousand calls.
pub const TORQUE_CHANGE: f64 = 0.2;
/// So many calls in a row the controller goes on by what it knew before; from then on joints are braked.
pub const BLIND_CALLS: u16 = 20;
/// So many calls in a row have to tell where the joints are before the controller stands up again.
pub const SEEING_CALLS: u16 = 200;

/// See the module.
#[derive(Debug, Clone)]
pub(super) struct Guard<R> {
    /// Torques of the last call.
    last: [R; MOST_VELOCITIES],
    blind: u16,
    seeing: u16,
    braking: bool,
}

impl<R: Scalar> Guard<R> {
    /// Of drives without torque.
    pub fn new() -> Self {
        Self { last: [R::constant(0.0); MOST_VELOCITIES], blind: 0, seeing: 0, braking: false }
    }

    /// Notes whether a call tells where the joints are; whether they are to be braked.
    pub fn judge(&mut self, blind: bool) -> bool {
        self.blind = if blind { self.blind.saturating_add(1) } else { 0 };
        self.seeing = if blind { 0 } else { self.seeing.saturating_add(1) };
        self.braking = if self.braking { self.seeing < SEEING_CALLS } else { self.blind >= BLIND_CALLS };
        self.braking
    }

    /// Torques in place of commands: finite, within the drives' limits, near those of the last call. What is no number is nothing.
    pub fn pass(&mut self, limits: &[R], commands: &mut [JointCommand<R>]) {
        let o = R::constant(0.0);
        for (joint, command) in commands.iter_mut().enumerate() {
            let limit = get(limits, joint);
            let asked = command.torque(o, o);
            let asked = within(limit, if asked.is_finite() { asked } else { o });
            let last = get(&self.last, joint);
            let torque = within(limit, last + within(R::constant(TORQUE_CHANGE) * limit, asked - last));
            set(&mut self.last, joint, torque);
            *command = JointCommand::Torque(torque);
        }
    }
}

/// No farther from 0 than that.
fn within<R: Scalar>(most: R, x: R) -> R {
    -(-x.larger(-most)).larger(-most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torques_go_to_what_is_asked_in_five_calls_and_stay_there() {
        let mut guard = Guard::<f64>::new();
        let mut last = 0.0;
        for call in 1..30 {
            let mut commands = [JointCommand::Torque(70.0), JointCommand::Torque(f64::NAN)];
            guard.pass(&[60.0, 20.0], &mut commands);
            let torque = commands[0].torque(0.0, 0.0);
            assert!(
                (torque - (12.0 * f64::from(call)).min(60.0)).abs() < 1e-12 && torque - last < 12.0 + 1e-12
            );
            assert_eq!(commands[1], JointCommand::Torque(0.0));
            last = torque;
        }
    }

    #[test]
    fn drives_without_a_limit_are_not_slowed() {
        let mut commands = [JointCommand::Torque(-1e3)];
        Guard::<f64>::new().pass(&[f64::INFINITY], &mut commands);
        assert_eq!(commands[0], JointCommand::Torque(-1e3));
    }

    #[test]
    fn a_blind_controller_brakes_until_it_has_seen_for_a_while() {
        let mut guard = Guard::<f64>::new();
        for _ in 0..5 {
            assert!((1..BLIND_CALLS).all(|_| !guard.judge(true)) && guard.judge(true));
            assert!((1..SEEING_CALLS).all(|_| guard.judge(false)) && !guard.judge(false));
        }
    }
}
