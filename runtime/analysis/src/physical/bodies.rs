//! Links in the coordinates of the invariant metric.
use crate::robot::LinkInertias;
use crate::robot::inertial_parameters::of_body;
use crate::robot::link_inertias::Link;
use nalgebra::{Matrix3, Matrix4, SymmetricEigen, Vector3};

/// Coordinates per link.
pub const COORDINATES: usize = 10;
/// Second moments about the centre of mass of CAD data are taken at least as large as those of a ball of this radius (m)
/// with the link's mass: the metric needs a body, and boxes without thickness are none.
const SMALLEST: f64 = 2e-3;

/// Mass, centre of mass and inertia of a link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inertia {
    /// kg
    pub mass: f64,
    /// In the link frame, m.
    pub center: Vector3<f64>,
    /// About the centre of mass, link axes, kg m².
    pub inertia: Matrix3<f64>,
}

/// A link that has mass.
#[derive(Debug, Clone, PartialEq)]
pub struct Body {
    /// URDF name.
    pub name: String,
    /// Index of the body it belongs to.
    pub body: usize,
    /// What CAD says.
    pub nominal: Inertia,
    /// CAD data that no body can have were mended for the metric.
    pub mended: bool,
    /// `P₀ = C Cᵀ`, link frame.
    root: Matrix4<f64>,
    /// Link frame in the body's frame.
    placement: Matrix4<f64>,
}

/// All links with mass, as functions of coordinates.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Links {
    /// In the order of the URDF.
    pub bodies: Vec<Body>,
    /// Number of bodies, each with ten parameters.
    count: usize,
}

/// `‖X‖²` is the sum of squares of its coordinates: the diagonal, and √2 times the rest.
fn symmetric(x: &[f64]) -> Matrix4<f64> {
    let mut m = Matrix4::zeros();
    for (place, &(i, j)) in PLACES.iter().enumerate() {
        let value = if i == j { x[place] } else { x[place] / std::f64::consts::SQRT_2 };
        (m[(i, j)], m[(j, i)]) = (value, value);
    }
    m
}

/// Upper triangle column by column: the order in which the solver wants it.
pub const PLACES: [(usize, usize); COORDINATES] =
    [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2), (0, 3), (1, 3), (2, 3), (3, 3)];

/// Ten standard parameters of a pseudo-inertia: m, h, L about the frame's origin.
fn ten(p: &Matrix4<f64>) -> [f64; 10] {
    let trace = p[(0, 0)] + p[(1, 1)] + p[(2, 2)];
    [
        p[(3, 3)],
        p[(0, 3)],
        p[(1, 3)],
        p[(2, 3)],
        trace - p[(0, 0)],
        -p[(0, 1)],
        -p[(0, 2)],
        trace - p[(1, 1)],
        -p[(1, 2)],
        trace - p[(2, 2)],
    ]
}

/// The pseudo-inertia of ten standard parameters.
fn pseudo_inertia(parameters: &[f64; 10]) -> Matrix4<f64> {
    let [m, x, y, z, xx, xy, xz, yy, yz, zz] = *parameters;
    // Half the trace less the inertia is the second moment of the mass itself.
    let half = 0.5 * (xx + yy + zz);
    Matrix4::new(half - xx, -xy, -xz, x, -xy, half - yy, -yz, y, -xz, -yz, half - zz, z, x, y, z, m)
}

/// Whether a body can have these ten parameters: its pseudo-inertia is positive definite.
pub fn is_possible(parameters: &[f64; 10]) -> bool {
    pseudo_inertia(parameters).cholesky().is_some()
}

impl Inertia {
    fn of_pseudo_inertia(p: &Matrix4<f64>) -> Self {
        let mass = p[(3, 3)];
        let center = Vector3::new(p[(0, 3)], p[(1, 3)], p[(2, 3)]) / mass;
        let second = p.fixed_view::<3, 3>(0, 0) - center * center.transpose() * mass;
        Self { mass, center, inertia: Matrix3::identity() * second.trace() - second }
    }
}

impl Body {
    fn new(link: &Link) -> Self {
        let center = Vector3::from(link.center);
        let inertia = Matrix3::from_fn(|i, j| link.inertia[i][j]);
        let nominal = Inertia { mass: link.mass, center, inertia };
        let second = Matrix3::identity() * (0.5 * inertia.trace()) - inertia;
        let eigen = SymmetricEigen::new(second);
        let least = link.mass * SMALLEST * SMALLEST / 5.0;
        let mended = eigen.eigenvalues.iter().any(|value| *value < least);
        let half =
            eigen.eigenvectors * Matrix3::from_diagonal(&eigen.eigenvalues.map(|x| x.max(least).sqrt()));
        let mut root = Matrix4::zeros();
        root.fixed_view_mut::<3, 3>(0, 0).copy_from(&half);
        root.fixed_view_mut::<3, 1>(0, 3).copy_from(&(center * link.mass.sqrt()));
        root[(3, 3)] = link.mass.sqrt();
        let mut placement = Matrix4::identity();
        for (i, row) in link.rotation.iter().enumerate() {
            for (j, x) in row.iter().enumerate() {
                placement[(i, j)] = *x;
            }
            placement[(i, 3)] = link.translation[i];
        }
        Self { name: link.name.clone(), body: link.body, nominal, mended, root, placement }
    }

    /// `P` of the link in its own frame.
    pub fn pseudo_inertia(&self, x: &[f64]) -> Matrix4<f64> {
        self.root * (Matrix4::identity() + symmetric(x)) * self.root.transpose()
    }

    /// Mass, centre and inertia.
    pub fn inertia(&self, x: &[f64]) -> Inertia {
        Inertia::of_pseudo_inertia(&self.pseudo_inertia(x))
    }

    /// Ten parameters in the body's frame.
    pub fn parameters(&self, x: &[f64]) -> [f64; 10] {
        ten(&(self.placement * self.pseudo_inertia(x) * self.placement.transpose()))
    }

    /// Mass, centre and inertia of a link whose ten parameters in the body's frame are these.
    pub fn inertia_of(&self, parameters: &[f64; 10]) -> Inertia {
        let back = self.placement.try_inverse().unwrap_or_else(Matrix4::identity);
        Inertia::of_pseudo_inertia(&(back * pseudo_inertia(parameters) * back.transpose()))
    }

    /// Ten parameters in the link's frame.
    pub fn own_parameters(&self, x: &[f64]) -> [f64; 10] {
        ten(&self.pseudo_inertia(x))
    }
}

impl Links {
    /// The links of a robot; those without mass are left as they are.
    pub fn new(link_inertias: &LinkInertias) -> Self {
        let bodies = link_inertias.links.iter().filter(|link| link.mass > 0.0).map(Body::new).collect();
        Self { bodies, count: link_inertias.bodies.len() }
    }

    /// Number of coordinates.
    pub fn coordinates(&self) -> usize {
        COORDINATES * self.bodies.len()
    }

    /// Ten parameters per body, all links together.
    pub fn parameters(&self, x: &[f64]) -> Vec<f64> {
        let mut all = vec![0.0; 10 * self.count];
        for (body, x) in self.bodies.iter().zip(x.chunks_exact(COORDINATES)) {
            for (sum, value) in all[of_body(body.body)].iter_mut().zip(body.parameters(x)) {
                *sum += value;
            }
        }
        all
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn link() -> Link {
        Link {
            name: "shank".to_owned(),
            body: 0,
            rotation: [[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
            translation: [0.1, 0.2, -0.3],
            mass: 2.0,
            center: [0.01, -0.02, 0.1],
            inertia: [[0.02, 0.001, 0.0], [0.001, 0.025, -0.002], [0.0, -0.002, 0.01]],
        }
    }

    #[test]
    fn no_coordinates_are_cad() {
        let link_inertias = LinkInertias { links: vec![link()], bodies: vec!["shank".to_owned()] };
        let links = Links::new(&link_inertias);
        let found = links.parameters(&[0.0; 10]);
        for (a, b) in found.iter().zip(link_inertias.parameters()) {
            assert!((a - b).abs() < 1e-14, "{a} {b}");
        }
        let inertia = links.bodies[0].inertia(&[0.0; 10]);
        assert!((inertia.inertia - links.bodies[0].nominal.inertia).norm() < 1e-15);
        let back = links.bodies[0].inertia_of(&found.try_into().unwrap());
        assert!((back.center - inertia.center).norm() < 1e-14 && (back.mass - 2.0).abs() < 1e-14);
        assert!((back.inertia - inertia.inertia).norm() < 1e-14);
        assert!(!links.bodies[0].mended);
    }

    #[test]
    fn the_metric_does_not_depend_on_the_frame() {
        // The same change of the same body, seen from a frame that lies elsewhere.
        let moved = Link { center: [0.31, 0.18, -0.4], ..link() };
        let (a, b) = (Body::new(&link()), Body::new(&moved));
        let shift = Matrix4::new_translation(&(b.nominal.center - a.nominal.center));
        let change = a.pseudo_inertia(&[0.1, 0.05, -0.2, 0.0, 0.1, 0.3, -0.1, 0.02, 0.03, 0.2]);
        let seen = shift * change * shift.transpose();
        let length = |body: &Body, p: &Matrix4<f64>| {
            let inverse = body.root.try_inverse().unwrap();
            (inverse * p * inverse.transpose() - Matrix4::identity()).norm()
        };
        assert!((length(&a, &change) - length(&b, &seen)).abs() < 1e-12);
    }
}
