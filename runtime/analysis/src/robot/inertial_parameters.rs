//! Ten inertial parameters for each body.
use std::ops::{Deref, DerefMut};

/// Of the bodies of a robot, or changes of them; per body: m, m c_x, m c_y, m c_z (kg, kg m), I_xx, I_xy, I_xz, I_yy, I_yz, I_zz about the frame's origin (kg m²).
#[derive(Debug, Clone, Default, PartialEq)]
pub struct InertialParameters(Vec<f64>);

impl InertialParameters {
    /// How many a body has.
    pub const PER_BODY: usize = 10;

    /// From body after body.
    pub fn new(values: Vec<f64>) -> Self {
        debug_assert!(values.len().is_multiple_of(Self::PER_BODY));
        Self(values)
    }

    /// Of no bodies.
    pub fn none() -> &'static Self {
        static NONE: InertialParameters = InertialParameters(Vec::new());
        &NONE
    }

    /// Mass of everything, kg.
    pub fn mass(&self) -> f64 {
        mass(&self.0)
    }

    /// Those of a body.
    pub fn body(&self, body: usize) -> &[f64] {
        &self.0[of_body(body)]
    }

    /// Body after body.
    pub fn bodies(&self) -> std::slice::ChunksExact<'_, f64> {
        self.0.chunks_exact(Self::PER_BODY)
    }
}

impl IntoIterator for InertialParameters {
    type Item = f64;
    type IntoIter = std::vec::IntoIter<f64>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.into_iter()
    }
}

impl FromIterator<f64> for InertialParameters {
    fn from_iter<I: IntoIterator<Item = f64>>(values: I) -> Self {
        Self::new(values.into_iter().collect())
    }
}

impl<'p> IntoIterator for &'p InertialParameters {
    type Item = &'p f64;
    type IntoIter = std::slice::Iter<'p, f64>;
    fn into_iter(self) -> Self::IntoIter {
        self.0.iter()
    }
}

impl Deref for InertialParameters {
    type Target = [f64];
    fn deref(&self) -> &[f64] {
        &self.0
    }
}

impl DerefMut for InertialParameters {
    fn deref_mut(&mut self) -> &mut [f64] {
        &mut self.0
    }
}

/// Place of a parameter of a body among those of all bodies.
pub fn parameter_index(body: usize, element: usize) -> usize {
    InertialParameters::PER_BODY * body + element
}

/// The body that a parameter belongs to.
pub fn body_of(index: usize) -> usize {
    index / InertialParameters::PER_BODY
}

/// Which of its body's parameters it is: 0 for the mass, 1 to 3 for the first moments, 4 to 9 for the inertia.
pub fn element_of(index: usize) -> usize {
    index % InertialParameters::PER_BODY
}

/// Places of a body's parameters among those of all bodies.
pub fn of_body(body: usize) -> std::ops::Range<usize> {
    InertialParameters::PER_BODY * body..InertialParameters::PER_BODY * (body + 1)
}

/// Sum of the masses among inertial parameters, or among their changes; kg.
pub fn mass(parameters: &[f64]) -> f64 {
    parameters.iter().step_by(InertialParameters::PER_BODY).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_follow_each_other() {
        let two = InertialParameters::new((0..20).map(f64::from).collect());
        assert_eq!(two.mass(), 10.0);
        assert_eq!((parameter_index(1, 3), body_of(13), element_of(13)), (13, 1, 3));
        assert_eq!((two.body(1)[0], two.bodies().count(), two.len()), (10.0, 2, 20));
    }
}
