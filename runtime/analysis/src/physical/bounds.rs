//! What is known beside the data: the mass on the scales, where a centre of mass can be, left equal to right.
use super::bodies::{COORDINATES, Links};
use bipedc_effects::diagnostic::Diagnostic;

/// Something known.
#[derive(Debug, Clone, PartialEq)]
pub enum Bound {
    /// All links that move together weigh this, kg.
    TotalMass(f64),
    /// The centre of mass of a link lies in a box of its frame, m.
    Center {
        /// Name of the link.
        link: String,
        /// Smallest coordinates.
        low: [f64; 3],
        /// Largest coordinates.
        high: [f64; 3],
    },
    /// Two links are mirror images of each other at the x-z plane of their frames.
    Mirror {
        /// One.
        left: String,
        /// The other.
        right: String,
    },
}

/// A linear condition on the coordinates: `constant + Σ factor · x` is zero, or not negative.
#[derive(Debug, Clone, PartialEq)]
pub struct Linear {
    /// (coordinate, factor)
    pub factors: Vec<(usize, f64)>,
    /// Its value at CAD.
    pub constant: f64,
    /// Zero instead of not negative.
    pub equal: bool,
}

/// All bounds as linear conditions.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Bounds {
    /// In the order of the bounds.
    pub linear: Vec<Linear>,
}

/// A mirror at the x-z plane turns these of the ten parameters round.
const MIRRORED: [f64; 10] = [1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0, 1.0, -1.0, 1.0];
/// CAD data of a mirrored pair differ by at most this part of their size.
const ALIKE: f64 = 0.2;

impl Bounds {
    /// Puts bounds into conditions.
    ///
    /// # Errors
    /// Links that do not exist, boxes without inside, pairs whose CAD data are no mirror images.
    pub fn new(bounds: &[Bound], links: &Links) -> Result<Self, Diagnostic> {
        let mut linear = Vec::new();
        for bound in bounds {
            match bound {
                Bound::TotalMass(mass) => linear.push(total_mass(*mass, links)?),
                Bound::Center { link, low, high } => {
                    linear.extend(center(find(links, link)?, links, low, high)?)
                }
                Bound::Mirror { left, right } => {
                    linear.extend(mirror([find(links, left)?, find(links, right)?], links)?);
                }
            }
        }
        Ok(Self { linear })
    }

    /// Whether coordinates keep all conditions within a tolerance.
    pub fn kept(&self, x: &[f64], tolerance: f64) -> bool {
        self.linear.iter().all(|condition| {
            let value = condition.value(x);
            if condition.equal { value.abs() <= tolerance } else { value >= -tolerance }
        })
    }
}

impl Linear {
    /// The value that is zero or not negative.
    pub fn value(&self, x: &[f64]) -> f64 {
        self.constant + self.factors.iter().map(|(k, factor)| factor * x[*k]).sum::<f64>()
    }
}

fn find(links: &Links, name: &str) -> Result<usize, Diagnostic> {
    links.bodies.iter().position(|body| body.name == name).ok_or_else(|| {
        let known: Vec<&str> = links.bodies.iter().map(|body| body.name.as_str()).collect();
        Diagnostic::error(format!("a bound names `{name}`, which is no moving link with mass"))
            .help(format!("links are: {}", known.join(", ")))
    })
}

/// Parameter `k` of a link in its frame: value at CAD and factors.
fn parameter(links: &Links, link: usize, k: usize) -> (f64, Vec<(usize, f64)>) {
    let body = &links.bodies[link];
    let nominal = body.own_parameters(&[0.0; COORDINATES])[k];
    let factor = |place: usize| {
        let mut x = [0.0; COORDINATES];
        x[place] = 1.0;
        (link * COORDINATES + place, body.own_parameters(&x)[k] - nominal)
    };
    (nominal, (0..COORDINATES).map(factor).filter(|(_, f)| *f != 0.0).collect())
}

/// `Σ weight · parameter + constant`.
fn combined(links: &Links, terms: &[(usize, usize, f64)], equal: bool) -> Linear {
    let mut linear = Linear { factors: Vec::new(), constant: 0.0, equal };
    for &(link, k, weight) in terms {
        let (nominal, factors) = parameter(links, link, k);
        linear.constant += weight * nominal;
        linear.factors.extend(factors.iter().map(|(place, f)| (*place, weight * f)));
    }
    linear
}

fn total_mass(mass: f64, links: &Links) -> Result<Linear, Diagnostic> {
    let nominal: f64 = links.bodies.iter().map(|body| body.nominal.mass).sum();
    if !(mass.is_finite() && mass > 0.01 * nominal && mass < 100.0 * nominal) {
        let message = format!(
            "a total mass of {mass} kg is asked for, but the moving links of the description weigh {nominal:.3} kg"
        );
        return Err(Diagnostic::error(message).help("give the mass of all links that move, in kg"));
    }
    let terms: Vec<_> = (0..links.bodies.len()).map(|link| (link, 0, 1.0)).collect();
    let mut linear = combined(links, &terms, true);
    linear.constant -= mass;
    Ok(linear)
}

fn center(link: usize, links: &Links, low: &[f64; 3], high: &[f64; 3]) -> Result<Vec<Linear>, Diagnostic> {
    let mut linear = Vec::new();
    for axis in 0..3 {
        let (low, high) = (low[axis], high[axis]);
        if !(low.is_finite() && high.is_finite() && low < high) {
            let name = &links.bodies[link].name;
            let message = format!(
                "the box for the centre of mass of `{name}` reaches from {low} to {high} m along {}",
                ["x", "y", "z"][axis]
            );
            return Err(Diagnostic::error(message).help("give the smaller number first"));
        }
        linear.push(combined(links, &[(link, 1 + axis, 1.0), (link, 0, -low)], false));
        linear.push(combined(links, &[(link, 1 + axis, -1.0), (link, 0, high)], false));
    }
    Ok(linear)
}

fn mirror([left, right]: [usize; 2], links: &Links) -> Result<Vec<Linear>, Diagnostic> {
    let of = |link: usize| links.bodies[link].own_parameters(&[0.0; COORDINATES]);
    let (a, b) = (of(left), of(right));
    // Masses, moments and inertias are compared among themselves: their units differ.
    for range in [0..1, 1..4, 4..10] {
        let size = range.clone().map(|k| a[k].abs().max(b[k].abs())).fold(0.0, f64::max);
        if range.clone().any(|k| (a[k] - MIRRORED[k] * b[k]).abs() > ALIKE * size) {
            let names = [left, right].map(|link| links.bodies[link].name.as_str());
            let message = format!(
                "`{}` and `{}` are not mirror images at the x-z plane of their frames in the description",
                names[0], names[1]
            );
            return Err(
                Diagnostic::error(message).help("left = right needs link frames that mirror each other")
            );
        }
    }
    Ok((0..10).map(|k| combined(links, &[(left, k, 1.0), (right, k, -MIRRORED[k])], true)).collect())
}
