//! What is put onto the root link while the robot moves: point masses.
use nalgebra::{Matrix3, Vector3};

/// A mass that is put onto the root link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PutOn {
    /// When, s. It has the link's velocity there.
    pub time: f64,
    /// It, and what was carried before.
    pub carried: Carried,
}

/// Moments of masses about the root's origin, in its axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Carried {
    /// kg
    mass: f64,
    /// Σ m r, kg m.
    first: Vector3<f64>,
    /// Σ m r rᵀ, kg m².
    second: Matrix3<f64>,
}

impl Carried {
    /// A mass (kg) at a place (m).
    pub fn new(mass: f64, place: [f64; 3]) -> Self {
        let place = Vector3::from(place);
        Self { mass, first: mass * place, second: mass * place * place.transpose() }
    }

    /// Both.
    #[must_use]
    pub fn and(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            first: self.first + other.first,
            second: self.second + other.second,
        }
    }

    /// Onto the mass matrix, row after row, of which the first six rows are the root's linear and angular velocity.
    pub(super) fn add_to_mass(&self, out: &mut [f64], nv: usize) {
        let cross = self.first.cross_matrix();
        let inertia = Matrix3::identity() * self.second.trace() - self.second;
        for i in 0..3 {
            out[i * nv + i] += self.mass;
            for j in 0..3 {
                out[i * nv + 3 + j] -= cross[(i, j)];
                out[(3 + i) * nv + j] += cross[(i, j)];
                out[(3 + i) * nv + 3 + j] += inertia[(i, j)];
            }
        }
    }

    /// Onto what velocity and weight need; `upward`: specific force of a body at rest, m/s².
    pub(super) fn add_to_bias(&self, out: &mut [f64], v: &[f64], upward: [f64; 3]) {
        let (linear, angular) = (Vector3::from_column_slice(&v[..3]), Vector3::from_column_slice(&v[3..6]));
        let at_origin = angular.cross(&linear) + Vector3::from(upward);
        let force = self.mass * at_origin + angular.cross(&angular.cross(&self.first));
        let moment = self.first.cross(&at_origin) - angular.cross(&(self.second * angular));
        out.iter_mut().zip(force.iter().chain(moment.iter())).for_each(|(to, x)| *to += x);
    }
}
