//! From the base as files state it to the generalised coordinates of each kind of base.
use super::BaseState;
use crate::tree::BaseKind;

/// Numbers below this (SI units) count as zero where a base cannot move: files hold rounded numbers.
const DUST: f64 = 1e-9;
/// Quaternions may be this far from unit length: files hold rounded numbers.
const UNIT: f64 = 1e-3;

/// The base's part of `q`, `v`, `a` and `tau`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct BaseCoordinates {
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
    pub tau: Vec<f64>,
}

type Vector = [f64; 3];

impl BaseState {
    /// In the coordinates of a base.
    ///
    /// # Errors
    /// A quaternion that is not of unit length, or motion that such a base cannot have: in one sentence.
    pub fn coordinates(&self, kind: BaseKind) -> Result<BaseCoordinates, String> {
        let orientation = self.unit_orientation()?;
        match kind {
            BaseKind::Floating => Ok(self.floating(orientation)),
            BaseKind::Planar => self.planar(orientation),
            BaseKind::Fixed | BaseKind::Pivot => {
                self.must_be_zero(orientation, |_| false, "the base does not move: it")?;
                // A pivot's one angle is given like a joint's, under the name `base/pivot`.
                Ok(BaseCoordinates::default())
            }
        }
    }

    fn unit_orientation(&self) -> Result<[f64; 4], String> {
        let length = self.orientation.iter().map(|x| x * x).sum::<f64>().sqrt();
        if (length - 1.0).abs() > UNIT {
            return Err(format!("`orientation` has length {length}, expected 1 (a unit quaternion x y z w)"));
        }
        Ok(self.orientation.map(|x| x / length))
    }

    fn floating(&self, orientation: [f64; 4]) -> BaseCoordinates {
        BaseCoordinates {
            q: self.position.into_iter().chain(orientation).collect(),
            v: [self.linear_velocity, self.angular_velocity].concat(),
            a: [self.linear_acceleration, self.angular_acceleration].concat(),
            tau: [self.force, self.torque].concat(),
        }
    }

    /// x, z, pitch: velocities and forces in world axes.
    fn planar(&self, orientation: [f64; 4]) -> Result<BaseCoordinates, String> {
        self.must_be_zero(orientation, |name| ["x", "z", "pitch"].contains(&name), "a planar base: it")?;
        let (sine, cosine) = (orientation[1], orientation[3]);
        let pitch = half_turn(2.0 * sine.atan2(cosine));
        // Rotation about y: base x points along (cos, −sin) in the world's (x, z).
        let (s, c) = (2.0 * sine * cosine, cosine * cosine - sine * sine);
        let world = |v: Vector| [c * v[0] + s * v[2], c * v[2] - s * v[0]];
        let (v, rate) = (self.linear_velocity, self.angular_velocity[1]);
        // World velocity is R v; its derivative is R (v̇ + ω × v) with ω along y.
        let u = self.linear_acceleration;
        let acceleration = world([u[0] + rate * v[2], 0.0, u[2] - rate * v[0]]);
        let three = |xz: [f64; 2], y: f64| vec![xz[0], xz[1], y];
        Ok(BaseCoordinates {
            q: vec![self.position[0], self.position[2], pitch],
            v: three(world(v), rate),
            a: three(acceleration, self.angular_acceleration[1]),
            tau: three(world(self.force), self.torque[1]),
        })
    }

    /// Checks every component of which `moves` says no: its arguments are `x`, `y`, `z`, `roll`, `pitch`, `yaw`.
    fn must_be_zero(
        &self,
        orientation: [f64; 4],
        moves: impl Fn(&str) -> bool,
        why: &str,
    ) -> Result<(), String> {
        const LINEAR: [&str; 3] = ["x", "y", "z"];
        const ANGULAR: [&str; 3] = ["roll", "pitch", "yaw"];
        let turn = [orientation[0], orientation[1], orientation[2]];
        let all: [(&str, Vector, [&str; 3]); 8] = [
            ("position", self.position, LINEAR),
            ("orientation", turn, ANGULAR),
            ("linear_velocity", self.linear_velocity, LINEAR),
            ("angular_velocity", self.angular_velocity, ANGULAR),
            ("linear_acceleration", self.linear_acceleration, LINEAR),
            ("angular_acceleration", self.angular_acceleration, ANGULAR),
            ("force", self.force, LINEAR),
            ("torque", self.torque, ANGULAR),
        ];
        for (key, values, directions) in all {
            for ((value, direction), axis) in values.iter().zip(directions).zip(LINEAR) {
                if value.abs() > DUST && !moves(direction) {
                    return Err(format!("`{key}` has {axis} component {value}, but this is {why} must be 0"));
                }
            }
        }
        Ok(())
    }
}

/// The angle in (−π, π].
fn half_turn(angle: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if angle > PI {
        angle - TAU
    } else if angle <= -PI {
        angle + TAU
    } else {
        angle
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A base that moves on a known path: its world velocity, differentiated numerically, is what comes out.
    #[test]
    fn planar_acceleration_is_the_derivative_of_the_world_velocity() {
        // Twist components u(t), w(t) and pitch p(t), all smooth.
        let pitch = |t: f64| 0.7 + 0.9 * t;
        let u = |t: f64| [0.3 + 1.1 * t, 0.0, -0.4 + 0.2 * t];
        let at = |t: f64| BaseState {
            orientation: [0.0, (pitch(t) / 2.0).sin(), 0.0, (pitch(t) / 2.0).cos()],
            linear_velocity: u(t),
            angular_velocity: [0.0, 0.9, 0.0],
            linear_acceleration: [1.1, 0.0, 0.2],
            ..BaseState::default()
        };
        let here = |t: f64| at(t).coordinates(BaseKind::Planar).unwrap();
        let h = 1e-6;
        for k in 0..2 {
            let difference = (here(h).v[k] - here(-h).v[k]) / (2.0 * h);
            assert!((difference - here(0.0).a[k]).abs() < 1e-9, "{k}: {difference} {:?}", here(0.0).a);
        }
        assert!((here(0.0).q[2] - 0.7).abs() < 1e-15);
    }

    #[test]
    fn sideways_motion_of_a_planar_base_is_refused() {
        let base = BaseState { linear_velocity: [0.0, 0.1, 0.0], ..BaseState::default() };
        let message = base.coordinates(BaseKind::Planar).unwrap_err();
        assert!(message.contains("`linear_velocity` has y component 0.1"), "{message}");
        let base = BaseState { orientation: [1.0, 1.0, 0.0, 0.0], ..BaseState::default() };
        assert!(base.coordinates(BaseKind::Floating).unwrap_err().contains("unit quaternion"));
    }
}
