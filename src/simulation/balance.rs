//! What the controller of a walk knows of its balance, for films: in the world of the simulation, and in words.
use super::footsteps::Live;
use bipedc_analysis::report::Balance;
use bipedc_runtime::walking::estimator::Fault;
use bipedc_runtime::walking::ground_forces::Shared;
use bipedc_runtime::walking::steps::{Phase, Steps};
use nalgebra::{Quaternion, Rotation2, UnitQuaternion, Vector2};

/// Steps whose duration is within this (s) of the planned one are as planned.
const AS_PLANNED: f64 = 1e-3;

impl Live {
    /// In the world in which the configuration is `q`; `None`: the controller was not asked yet.
    pub fn balance(&self, q: &[f64]) -> Option<Balance> {
        let walked = self.walked?;
        let place = |p: [f64; 2]| self.in_world(q, p);
        Some(Balance {
            divergent: walked.divergent.map(place),
            zero_moment_point: place(walked.zero_moment_point[0]),
            phase: self.steps.map_or("stands", phase).to_owned(),
            limits: self.limits(walked.limited, walked.shared),
        })
    }

    /// A point of the ground where the controller believes it, seen from the robot as it is.
    fn in_world(&self, q: &[f64], point: [f64; 2]) -> [f64; 2] {
        let Some(estimate) = self.estimate else { return point };
        let heading = |q: &[f64]| {
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]));
            turn.euler_angles().2
        };
        let turn = Rotation2::new(heading(q) - heading(&estimate));
        let from = Vector2::from(point) - Vector2::new(estimate[0], estimate[1]);
        (Vector2::new(q[0], q[1]) + turn * from).into()
    }

    /// Everything that keeps the controller from what it would do undisturbed.
    fn limits(&self, edge: bool, shared: Option<Shared<f64>>) -> Vec<String> {
        let mut all = Vec::new();
        let mut say = |words: &str| all.push(words.to_owned());
        if edge {
            say("zero moment point at the edge of what the soles allow");
        }
        match shared {
            Some(Shared::GroundGaveWay { .. }) => say("the ground cannot give the force that is asked for"),
            Some(Shared::Clamped { .. }) => say("torques of drives at their limits"),
            Some(Shared::Refused) => say("forces of the ground cannot be shared"),
            Some(Shared::Met) | None => {}
        }
        if let Some(steps) = self.steps.filter(|steps| steps.phase == Phase::Swing) {
            let longer = steps.duration - steps.usual;
            if longer > AS_PLANNED {
                say("the step takes longer than planned");
            } else if longer < -AS_PLANNED {
                say("the step is shorter than planned");
            }
        }
        match self.fault {
            Some(Fault::Aloft) => say("no foot carries the robot"),
            Some(Fault::Slip(_)) => say("a foot slips"),
            Some(_) => say("a sensor is not believed"),
            None => {}
        }
        if self.braked {
            say("joints are braked");
        }
        all
    }
}

fn phase(steps: Steps<f64>) -> &'static str {
    match (steps.phase, steps.stands) {
        (Phase::Stand, _) => "stands",
        (Phase::Shift, 0) => "weight goes to the right foot",
        (Phase::Shift, _) => "weight goes to the left foot",
        (Phase::Halt, _) => "comes to a stop",
        (Phase::Swing, 0) => "stands on the right foot",
        (Phase::Swing, _) => "stands on the left foot",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot that believes to be elsewhere, turned: a point ahead of it is ahead of it in the world too.
    #[test]
    fn points_are_seen_from_the_robot() {
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let live = Live { estimate: Some([5.0, 6.0, 0.7, 0.0, 0.0, 0.0, 1.0]), ..Live::default() };
        // Turned to the left by 90°.
        let q = [1.0, 2.0, 0.7, 0.0, 0.0, half, half];
        let [x, y] = live.in_world(&q, [5.3, 6.0]);
        assert!((x - 1.0).abs() < 1e-12 && (y - 2.3).abs() < 1e-12, "{x} {y}");
        assert_eq!(Live::default().in_world(&q, [5.3, 6.0]), [5.3, 6.0]);
    }

    #[test]
    fn what_limits_is_said_and_nothing_else() {
        assert!(Live::default().limits(false, Some(Shared::Met)).is_empty());
        let live = Live { fault: Some(Fault::Gyroscope), braked: true, ..Live::default() };
        let said = live.limits(true, Some(Shared::Clamped { missing: [0.0; 6] }));
        assert_eq!(said.len(), 4, "{said:?}");
    }
}
