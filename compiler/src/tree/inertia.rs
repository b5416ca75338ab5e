//! Barycentric inertial parameters: all of them add up and are linear in the equations of motion.
use super::placement::{Placement, matrix_vector};
use crate::description::model::Inertial;
use crate::tree::Rotation;

/// Mass, first moment and inertia about the frame's origin.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inertia {
    /// kg
    pub mass: f64,
    /// Mass times centre of mass, kg m.
    pub first_moment: [f64; 3],
    /// About the origin of the frame (not the centre of mass), symmetric, kg m².
    pub second_moment: [[f64; 3]; 3],
}

/// `m |d|² 1 − m d dᵀ`
fn point_inertia(mass: f64, d: [f64; 3]) -> [[f64; 3]; 3] {
    let square = d.iter().map(|x| x * x).sum::<f64>();
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| mass * (if r == c { square } else { 0.0 } - d[r] * d[c])))
}

fn rotate(m: &[[f64; 3]; 3], i: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let half = [0, 1, 2].map(|r| matrix_vector(i, m[r]));
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| (0..3).map(|k| m[c][k] * half[r][k]).sum::<f64>()))
}

impl Inertia {
    /// From the URDF's mass, centre of mass and inertia about it.
    pub fn from_inertial(inertial: &Inertial) -> Self {
        let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
        let about_com = rotate(
            &Rotation::from_rpy(inertial.origin.rpy).matrix(),
            &[[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]],
        );
        let c = inertial.origin.xyz;
        let shift = point_inertia(inertial.mass, c);
        Self {
            mass: inertial.mass,
            first_moment: c.map(|x| inertial.mass * x),
            second_moment: [0, 1, 2].map(|r| [0, 1, 2].map(|k| about_com[r][k] + shift[r][k])),
        }
    }

    /// The same body seen from the frame in which `placement` places its present frame.
    pub fn transformed(&self, placement: &Placement) -> Self {
        let m = placement.rotation.matrix();
        let p = placement.translation;
        let l = matrix_vector(&m, self.first_moment);
        let turned = rotate(&m, &self.second_moment);
        let dot = (0..3).map(|i| p[i] * l[i]).sum::<f64>();
        let shift = point_inertia(self.mass, p);
        Self {
            mass: self.mass,
            first_moment: [0, 1, 2].map(|i| l[i] + self.mass * p[i]),
            second_moment: [0, 1, 2].map(|r| {
                [0, 1, 2].map(|c| {
                    let diagonal = if r == c { 2.0 * dot } else { 0.0 };
                    turned[r][c] + diagonal - p[r] * l[c] - l[r] * p[c] + shift[r][c]
                })
            }),
        }
    }

    /// Both bodies together, in the same frame.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first_moment: [0, 1, 2].map(|i| self.first_moment[i] + other.first_moment[i]),
            second_moment: [0, 1, 2]
                .map(|r| [0, 1, 2].map(|c| self.second_moment[r][c] + other.second_moment[r][c])),
        }
    }

    /// The ten standard parameters: m, m c_x, m c_y, m c_z, L_xx, L_xy, L_xz, L_yy, L_yz, L_zz.
    pub fn parameters(&self) -> [f64; 10] {
        let (l, i) = (self.first_moment, self.second_moment);
        [self.mass, l[0], l[1], l[2], i[0][0], i[0][1], i[0][2], i[1][1], i[1][2], i[2][2]]
    }
}
