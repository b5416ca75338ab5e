//! Ground that is not level and logs whose upright direction is off: three sets of axes.
//!
//! A simulation takes place in the axes of the *ground*, where contact is at z = 0. With R_s the slope (`ground_slope`) the *world*
//! is turned against them: gravity in the ground's axes is `R_sᵀ g`. A log says everything in axes of its own: with R_t
//! the tilt (`gravity_tilt`) true = R_t logged. On a fixed base the tilt is part of the model instead.
use super::mechanics::rotate;
use super::plant::Plant;
use crate::robot::BaseKind;
use crate::robot::world::World;
use bipedc_effects::effect::Effect;
use nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};

/// Turns between the axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Turned {
    base: BaseKind,
    /// From the world's axes to the ground's.
    to_ground: UnitQuaternion<f64>,
    /// From the ground's axes to the log's.
    to_log: UnitQuaternion<f64>,
}

impl Turned {
    pub fn new(plant: &Plant, effects: &[&Effect]) -> Self {
        let effects: Vec<Effect> = effects.iter().map(|effect| (*effect).clone()).collect();
        let world = World::of(&effects, &plant.layout);
        let turn = |matrix: Matrix3<f64>| {
            UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(matrix))
        };
        let base = plant.layout.base;
        if base == BaseKind::Fixed {
            let none = UnitQuaternion::identity();
            return Self { base, to_ground: none, to_log: none };
        }
        Self {
            base,
            to_ground: turn(world.slope.transpose()),
            to_log: turn(world.tilt.transpose() * world.slope),
        }
    }

    /// Whether all axes are the same.
    pub fn is_none(&self) -> bool {
        [self.to_ground, self.to_log].iter().all(|turn| turn.angle() == 0.0)
    }

    /// A configuration and velocity of the world in the ground's axes.
    pub fn into_ground(self, q: &mut [f64], v: &mut [f64]) {
        self.turn(self.to_ground, q, v);
    }

    /// A configuration and velocity in the log's axes.
    pub fn into_log(self, q: &mut [f64], v: &mut [f64]) {
        self.turn(self.to_log, q, v);
    }

    /// A vector in the log's axes.
    pub fn logged(&self, vector: [f64; 3]) -> [f64; 3] {
        let [x, y, z] = vector;
        (self.to_log * Vector3::new(x, y, z)).into()
    }

    fn turn(&self, turn: UnitQuaternion<f64>, q: &mut [f64], v: &mut [f64]) {
        let [x, y, z, w] = [turn.i, turn.j, turn.k, turn.w];
        let own = [x, y, z, w];
        match self.base {
            BaseKind::Fixed | BaseKind::Pivot => {}
            BaseKind::Planar => {
                for values in [&mut q[..2], &mut v[..2]] {
                    let turned = rotate(own, [values[0], 0.0, values[1]]);
                    (values[0], values[1]) = (turned[0], turned[2]);
                }
                q[2] += 2.0 * y.atan2(w);
            }
            // Velocities are in the base's own axes.
            BaseKind::Floating => {
                let place = rotate(own, [q[0], q[1], q[2]]);
                q[..3].copy_from_slice(&place);
                let before =
                    UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[6], q[3], q[4], q[5]));
                q[3..7].copy_from_slice((turn * before).coords.as_slice());
            }
        }
    }
}

impl Plant {
    /// Gravity in the axes of the ground, m/s², as these effects turn it.
    pub fn gravity_on_ground(&self, effects: &[Effect]) -> [f64; 3] {
        let turned = Turned::new(self, &effects.iter().collect::<Vec<_>>());
        let [x, y, z] = self.gravity;
        (turned.to_ground * Vector3::new(x, y, z)).into()
    }
}
