//! Whether a body can have these parameters: judged from mass, centre and inertia alone, without the solver's coordinates.
use super::bodies::Inertia;
use nalgebra::{Matrix4, SymmetricEigen};
use serde::Serialize;

/// What can be said of one link's parameters.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Consistency {
    /// Mass positive, pseudo-inertia positive definite, triangle inequality kept.
    pub consistent: bool,
    /// Smallest eigenvalue of the pseudo-inertia about the centre of mass; kg m² (or kg, if that is smaller).
    pub smallest_eigenvalue: f64,
    /// Principal moments of inertia, ascending, kg m².
    pub principal_moments: [f64; 3],
    /// Sum of the two smaller principal moments minus the largest, over the largest; a flat body has 0.
    pub triangle_margin: f64,
}

/// Judges a link.
pub fn check(link: &Inertia) -> Consistency {
    let mut moments: [f64; 3] = SymmetricEigen::new(link.inertia).eigenvalues.into();
    moments.sort_by(f64::total_cmp);
    let mut pseudo = Matrix4::zeros();
    for i in 0..3 {
        for j in 0..3 {
            let diagonal = if i == j { 0.5 * link.inertia.trace() } else { 0.0 };
            pseudo[(i, j)] = diagonal - link.inertia[(i, j)];
        }
    }
    pseudo[(3, 3)] = link.mass;
    let smallest = SymmetricEigen::new(pseudo).eigenvalues.min();
    let margin = (moments[0] + moments[1] - moments[2]) / moments[2].abs().max(f64::MIN_POSITIVE);
    let finite = link.center.iter().all(|c| c.is_finite());
    Consistency {
        consistent: finite && link.mass > 0.0 && smallest > 0.0 && moments[0] > 0.0 && margin > 0.0,
        smallest_eigenvalue: smallest,
        principal_moments: moments,
        triangle_margin: margin,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{Matrix3, Vector3};

    #[test]
    fn a_box_can_be_and_a_needle_with_one_fat_moment_cannot() {
        let with = |x: f64, y: f64, z: f64| Inertia {
            mass: 1.0,
            center: Vector3::zeros(),
            inertia: Matrix3::from_diagonal(&Vector3::new(x, y, z)),
        };
        assert!(check(&with(0.02, 0.03, 0.04)).consistent);
        assert!(!check(&with(0.01, 0.01, 0.03)).consistent, "0.01 + 0.01 < 0.03");
        assert!(!check(&with(-0.01, 0.02, 0.02)).consistent);
        assert!(!check(&Inertia { mass: -1.0, ..with(0.02, 0.03, 0.04) }).consistent);
        assert!(!check(&with(f64::NAN, 0.03, 0.04)).consistent);
    }
}
