//! The links behind the inertial parameters: how payloads, shifted centres of mass and CAD errors change them.
use super::inertial_parameters::{InertialParameters, of_body};
use bipedc_effects::effect::{Acts, Effect, Law};
use serde::{Deserialize, Serialize};

type Matrix = [[f64; 3]; 3];

/// A link of the robot, with the place of its frame in the body that it belongs to.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Link {
    /// URDF name.
    pub name: String,
    /// Index of the body, in the order of the inertial parameters.
    pub body: usize,
    /// Axes of the link frame in the frame that the body's parameters are stated in.
    pub rotation: Matrix,
    /// Origin of the link frame in that frame, m.
    pub translation: [f64; 3],
    /// kg
    pub mass: f64,
    /// Centre of mass in the link frame, m.
    pub center: [f64; 3],
    /// About the centre of mass, link axes, kg m².
    pub inertia: Matrix,
}

/// All links of a robot.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
pub struct LinkInertias {
    /// In the order of the URDF.
    pub links: Vec<Link>,
    /// Names of the bodies' main links.
    pub bodies: Vec<String>,
}

/// How far CAD data are usually off: one standard deviation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CadError {
    /// Relative error of masses.
    pub mass: f64,
    /// Of each coordinate of a centre of mass, in parts of the link's size ([`Link::size`]), or of half the robot's mean
    /// where the link is smaller.
    pub center: f64,
    /// Relative error of inertias about the centre of mass.
    pub inertia: f64,
}

impl CadError {
    /// Everything is as described.
    pub const NONE: Self = Self { mass: 0.0, center: 0.0, inertia: 0.0 };
}

impl Default for CadError {
    fn default() -> Self {
        Self { mass: 0.02, center: 0.02, inertia: 0.04 }
    }
}

/// Ten parameters of a point mass, or of a body: m, m c, second moment about the origin.
fn parameters(mass: f64, c: [f64; 3], about_center: &Matrix) -> [f64; 10] {
    let square: f64 = c.iter().map(|x| x * x).sum();
    let second =
        |r: usize, k: usize| about_center[r][k] + mass * (if r == k { square } else { 0.0 } - c[r] * c[k]);
    [
        mass,
        mass * c[0],
        mass * c[1],
        mass * c[2],
        second(0, 0),
        second(0, 1),
        second(0, 2),
        second(1, 1),
        second(1, 2),
        second(2, 2),
    ]
}

fn product(m: &Matrix, x: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|r| (0..3).map(|k| m[r][k] * x[k]).sum())
}

impl Link {
    /// Ten parameters in the body's frame.
    pub fn parameters(&self) -> [f64; 10] {
        self.changed(0.0, [0.0; 3], &[[0.0; 3]; 3])
    }

    /// How far its mass lies from its centre, m: the mean radius of gyration, or a part of the distance to the frame where
    /// the mass is a point.
    pub fn size(&self) -> f64 {
        /// Radius of gyration of a usual link, in parts of the distance of its centre from the joint.
        const USUAL: f64 = 0.3;
        /// The same of what is a point.
        const POINT: f64 = 0.05;
        let trace: f64 = (0..3).map(|i| self.inertia[i][i]).sum();
        let gyration = (0.5 * trace / self.mass).max(0.0).sqrt();
        let arm = self.center.iter().map(|x| x * x).sum::<f64>().sqrt();
        if gyration > POINT * arm { gyration } else { USUAL * arm }
    }

    /// How far from its frame it has mass, m: its centre, and as far again as its mass lies from that.
    pub fn extent(&self) -> f64 {
        self.center.iter().map(|x| x * x).sum::<f64>().sqrt() + self.size()
    }

    /// A point of the link frame in the body's frame.
    fn point(&self, x: [f64; 3]) -> [f64; 3] {
        let turned = product(&self.rotation, x);
        [0, 1, 2].map(|i| self.translation[i] + turned[i])
    }

    /// A symmetric matrix in link axes, in the body's axes.
    fn turned(&self, m: &Matrix) -> Matrix {
        let half = [0, 1, 2].map(|r| product(m, self.rotation[r]));
        [0, 1, 2].map(|r| [0, 1, 2].map(|c| (0..3).map(|k| self.rotation[c][k] * half[r][k]).sum()))
    }

    /// The values of the one `inertial_correction` that does what two do together, each stated from the described link: mass,
    /// shift of the centre (m) and inertia about it (kg m²). First and second moments add; shifts and inertias about the centre
    /// do not.
    pub fn joined(&self, corrections: [&Effect; 2]) -> [(&'static str, f64); 10] {
        let axes = [0, 1, 2].map(|r| [0, 1, 2].map(|c| f64::from(u8::from(r == c))));
        let own = Self { rotation: axes, translation: [0.0; 3], ..self.clone() };
        let before = own.parameters();
        let mut all = before;
        for effect in corrections {
            let shift = ["x", "y", "z"].map(|axis| effect.value(axis));
            let changed = own.changed(effect.value("mass"), shift, &inertia_of(effect));
            all.iter_mut().zip(changed.iter().zip(before)).for_each(|(x, (new, old))| *x += new - old);
        }
        let [mass, mx, my, mz, xx, xy, xz, yy, yz, zz] = all;
        let center = [mx, my, mz].map(|moment| if mass == 0.0 { 0.0 } else { moment / mass });
        // The second moment of all mass in its centre.
        let [.., cxx, cxy, cxz, cyy, cyz, czz] = parameters(mass, center, &[[0.0; 3]; 3]);
        let was = &self.inertia;
        [
            ("mass", mass - self.mass),
            ("x", center[0] - self.center[0]),
            ("y", center[1] - self.center[1]),
            ("z", center[2] - self.center[2]),
            ("ixx", xx - cxx - was[0][0]),
            ("ixy", xy - cxy - was[0][1]),
            ("ixz", xz - cxz - was[0][2]),
            ("iyy", yy - cyy - was[1][1]),
            ("iyz", yz - cyz - was[1][2]),
            ("izz", zz - czz - was[2][2]),
        ]
    }

    /// Ten parameters in the body's frame, with mass, centre and inertia (about the centre) changed.
    fn changed(&self, mass: f64, shift: [f64; 3], inertia: &Matrix) -> [f64; 10] {
        let center = [0, 1, 2].map(|i| self.center[i] + shift[i]);
        let about = [0, 1, 2].map(|r| [0, 1, 2].map(|c| self.inertia[r][c] + inertia[r][c]));
        parameters(self.mass + mass, self.point(center), &self.turned(&about))
    }
}

impl LinkInertias {
    /// The link of this name.
    pub fn link(&self, name: &str) -> Option<&Link> {
        self.links.iter().find(|link| link.name == name)
    }

    /// Nominal parameters of all bodies, ten each.
    pub fn parameters(&self) -> InertialParameters {
        let mut all = vec![0.0; InertialParameters::PER_BODY * self.bodies.len()];
        for link in &self.links {
            add(&mut all, link.body, &link.changed(0.0, [0.0; 3], &[[0.0; 3]; 3]), 1.0);
        }
        InertialParameters::new(all)
    }

    /// What inertial effects add to the parameters; zero for other effects and unknown links.
    pub fn change(&self, effects: &[Effect]) -> InertialParameters {
        let mut all = vec![0.0; InertialParameters::PER_BODY * self.bodies.len()];
        for effect in effects {
            let Some(link) = effect.location.link.as_deref().and_then(|name| self.link(name)) else {
                continue;
            };
            let vector = ["x", "y", "z"].map(|axis| effect.value(axis));
            let nothing = [[0.0; 3]; 3];
            let unchanged = link.changed(0.0, [0.0; 3], &nothing);
            match effect.kind.law {
                Law::Payload => {
                    add(
                        &mut all,
                        link.body,
                        &parameters(effect.value("mass"), link.point(vector), &nothing),
                        1.0,
                    );
                }
                Law::CenterOfMassOffset => {
                    add(&mut all, link.body, &link.changed(0.0, vector, &nothing), 1.0);
                    add(&mut all, link.body, &unchanged, -1.0);
                }
                // The former has no mass and no shift.
                Law::InertiaError | Law::InertialCorrection => {
                    let more = inertia_of(effect);
                    add(&mut all, link.body, &link.changed(effect.value("mass"), vector, &more), 1.0);
                    add(&mut all, link.body, &unchanged, -1.0);
                }
                law => debug_assert!(law.acts() != Acts::Body, "{effect} does not change the link"),
            }
        }
        InertialParameters::new(all)
    }

    /// Directions in parameter space, each with the length of one standard deviation of a usual CAD error:
    /// per link its mass, three coordinates of its centre of mass, six of its inertia.
    ///
    /// Body (index) and ten numbers; the link's index comes with them.
    pub fn cad_directions(&self, error: &CadError) -> Vec<(usize, usize, [f64; 10])> {
        let mut directions = Vec::new();
        let heavy = || self.links.iter().enumerate().filter(|(_, link)| link.mass > 0.0);
        let sum = |of: fn(&Link) -> f64| heavy().map(|(_, link)| of(link)).sum::<f64>();
        let mean = sum(|link| link.mass * link.size()) / sum(|link| link.mass).max(f64::MIN_POSITIVE);
        for (index, link) in heavy() {
            let nothing = [[0.0; 3]; 3];
            let base = link.changed(0.0, [0.0; 3], &nothing);
            let mut push = |changed: [f64; 10]| {
                directions.push((index, link.body, std::array::from_fn(|k| changed[k] - base[k])));
            };
            let mass = error.mass * link.mass;
            // A heavier link of the same shape has more inertia too.
            push(link.changed(mass, [0.0; 3], &link.inertia.map(|row| row.map(|x| error.mass * x))));
            for axis in 0..3 {
                let mut shift = [0.0; 3];
                shift[axis] = error.center * link.size().max(0.5 * mean);
                push(link.changed(0.0, shift, &nothing));
            }
            let size = error.inertia * (0..3).map(|i| link.inertia[i][i]).sum::<f64>() / 3.0;
            for (r, c) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
                let mut more = nothing;
                (more[r][c], more[c][r]) = (size, size);
                push(link.changed(0.0, [0.0; 3], &more));
            }
        }
        directions
    }
}

/// The six components that an effect adds.
fn inertia_of(effect: &Effect) -> Matrix {
    let [xx, xy, xz, yy, yz, zz] = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|name| effect.value(name));
    [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
}

fn add(all: &mut [f64], body: usize, change: &[f64; 10], factor: f64) {
    for (a, c) in all[of_body(body)].iter_mut().zip(change) {
        *a += factor * c;
    }
}
