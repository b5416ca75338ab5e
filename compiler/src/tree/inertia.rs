//! Barycentric inertial parameters: all of them add up and are linear in the equations of motion.
use super::placement::Placement;
use crate::description::model::Inertial;
use crate::expression::decimal::{dot, product, sum};
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
    let square = dot(d, d);
    let of = |r: usize, c: usize| sum(if r == c { square } else { 0.0 }, -product(d[r], d[c]));
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| product(mass, of(r, c))))
}

fn rotate(m: &[[f64; 3]; 3], i: &[[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let half = [0, 1, 2].map(|r| i.map(|row| dot(row, m[r])));
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| dot(m[c], half[r])))
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
            first_moment: c.map(|x| product(inertial.mass, x)),
            second_moment: [0, 1, 2].map(|r| [0, 1, 2].map(|k| sum(about_com[r][k], shift[r][k]))),
        }
    }

    /// The same body seen from the frame in which `placement` places its present frame.
    pub fn transformed(&self, placement: &Placement) -> Self {
        let m = placement.rotation.matrix();
        let p = placement.translation;
        let l = m.map(|row| dot(row, self.first_moment));
        let turned = rotate(&m, &self.second_moment);
        let twice = product(2.0, dot(p, l));
        let shift = point_inertia(self.mass, p);
        Self {
            mass: self.mass,
            first_moment: [0, 1, 2].map(|i| sum(l[i], product(self.mass, p[i]))),
            second_moment: [0, 1, 2].map(|r| {
                [0, 1, 2].map(|c| {
                    let diagonal = if r == c { twice } else { 0.0 };
                    [diagonal, -product(p[r], l[c]), -product(l[r], p[c]), shift[r][c]]
                        .into_iter()
                        .fold(turned[r][c], sum)
                })
            }),
        }
    }

    /// Both bodies together, in the same frame.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            mass: sum(self.mass, other.mass),
            first_moment: [0, 1, 2].map(|i| sum(self.first_moment[i], other.first_moment[i])),
            second_moment: [0, 1, 2]
                .map(|r| [0, 1, 2].map(|c| sum(self.second_moment[r][c], other.second_moment[r][c]))),
        }
    }

    /// What is left of it without another, in the same frame.
    pub fn less(&self, other: &Self) -> Self {
        self.plus(&Self {
            mass: -other.mass,
            first_moment: other.first_moment.map(|x| -x),
            second_moment: other.second_moment.map(|row| row.map(|x| -x)),
        })
    }

    /// The ten standard parameters: m, m c_x, m c_y, m c_z, L_xx, L_xy, L_xz, L_yy, L_yz, L_zz.
    pub fn parameters(&self) -> [f64; 10] {
        let (l, i) = (self.first_moment, self.second_moment);
        [self.mass, l[0], l[1], l[2], i[0][0], i[0][1], i[0][2], i[1][1], i[1][2], i[2][2]]
    }
}
