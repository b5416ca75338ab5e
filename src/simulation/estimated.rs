//! How far off an estimator is that tells a controller where its robot is.
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use serde::Serialize;

/// Largest errors of the root link's pose, at the rows of the log until the robot fell; where it was at the first row counts as known.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct EstimateErrors {
    /// Along the ground, m.
    pub along_ground: f64,
    /// m
    pub up: f64,
    /// rad
    pub tilt: f64,
    /// rad
    pub heading: f64,
}

/// Compares estimates with the truth.
#[derive(Debug, Clone, Default)]
pub(super) struct EstimateWatch {
    /// From the estimator's world to the true one: heading and place at the first row.
    start: Option<(UnitQuaternion<f64>, Vector3<f64>)>,
    errors: EstimateErrors,
}

/// Place and attitude of a floating base.
fn pose(q: &[f64]) -> (UnitQuaternion<f64>, Vector3<f64>) {
    let turn = UnitQuaternion::from_quaternion(Quaternion::new(q[6], q[3], q[4], q[5]));
    (turn, Vector3::new(q[0], q[1], q[2]))
}

impl EstimateWatch {
    /// Takes a row; the largest errors until now.
    pub fn see(&mut self, truth: &[f64], estimate: &[f64; 7]) -> EstimateErrors {
        let (true_turn, true_place) = pose(truth);
        let (turn, place) = pose(estimate);
        let (heading, offset) = *self.start.get_or_insert_with(|| {
            let (_, _, yaw) = (true_turn * turn.inverse()).euler_angles();
            let heading = UnitQuaternion::from_axis_angle(&Vector3::z_axis(), yaw);
            (heading, true_place - heading * place)
        });
        let off = heading * place + offset - true_place;
        let turned = (heading * turn * true_turn.inverse()).scaled_axis();
        let most = &mut self.errors;
        most.along_ground = most.along_ground.max(off.x.hypot(off.y));
        most.up = most.up.max(off.z.abs());
        most.tilt = most.tilt.max(turned.x.hypot(turned.y));
        most.heading = most.heading.max(turned.z.abs());
        *most
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Another world is no error; what differs within it is.
    #[test]
    fn errors_are_those_since_the_first_row() {
        let of = |x: f64, yaw: f64, roll: f64| {
            let turn = UnitQuaternion::from_euler_angles(roll, 0.0, yaw);
            let [a, b, c, d]: [f64; 4] = turn.coords.into();
            [x, 0.0, 0.4, a, b, c, d]
        };
        let mut watch = EstimateWatch::default();
        let first = watch.see(&of(1.0, 0.0, 0.0), &of(0.0, 0.5, 0.0));
        assert!(first.along_ground < 1e-15 && first.heading < 1e-15);
        // 0.1 m ahead in its own world, which is turned by 0.5 rad.
        let ahead = [0.1 * 0.5_f64.cos(), 0.1 * 0.5_f64.sin()];
        let mut there = of(ahead[0], 0.6, 0.02);
        there[1] = ahead[1];
        let found = watch.see(&of(1.1, 0.0, 0.0), &there);
        assert!(found.along_ground < 1e-15 && (found.heading - 0.1).abs() < 1e-3, "{found:?}");
        assert!((found.tilt - 0.02).abs() < 1e-3, "{found:?}");
    }
}
