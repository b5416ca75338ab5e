//! What an output is to be over φ: a formula, or a polynomial by its Bezier coefficients, which the gait parameters move.
use super::PHASE;
use super::dimension::{Dimension, words};
use super::names::{Allowed, Names};
use super::read::{check_turns, range};
use crate::description::settings::table::Section;
use crate::description::source::Messages;
use bipedc_effects::effect::formula::Formula;

/// Most coefficients of a polynomial: beyond that they are noise.
const MOST: usize = 24;

/// h_d as a function of φ.
#[derive(Debug, Clone, PartialEq)]
pub enum Curve {
    /// Of φ, its ends and the gait parameters.
    Formula(Formula),
    /// Σ c_k C(n,k) s^k (1−s)^(n−k) with s = (φ − a)/(b − a), which stays where it is 15 % beyond either end.
    Bezier {
        /// c_k
        coefficients: Vec<f64>,
        /// a and b, in the unit of φ.
        over: [f64; 2],
        /// Stands for φ in s, in its unit: so that a phase gets longer or shorter with the gait parameters.
        along: Option<Formula>,
        /// What is added to the polynomial.
        plus: Option<Formula>,
    },
}

impl Curve {
    /// How far beyond its ends a polynomial is followed, of its length.
    pub const BEYOND: f64 = 0.15;

    /// Names that its formulas depend on.
    pub fn names(&self) -> impl Iterator<Item = &String> {
        let formulas = match self {
            Self::Formula(formula) => [Some(formula), None],
            Self::Bezier { along, plus, .. } => [along.as_ref(), plus.as_ref()],
        };
        formulas.into_iter().flatten().flat_map(Formula::names)
    }
}

const ALONG: Allowed = Allowed {
    configuration: false,
    parameters: true,
    phase: true,
    rule: "curves are functions of phase, phase_start, phase_end and the gait parameters",
};

/// A formula of phase and parameters that may be left out; `None`: it is wrong.
pub(super) fn read_moved(
    table: &Section<'_, '_>,
    key: &str,
    (wanted, names): (Dimension, &Names),
    messages: &mut Messages<'_>,
) -> Option<Option<Formula>> {
    let Some(entry) = table.get(key) else { return Some(None) };
    let (formula, dimension) = names.formula(&entry, ALONG, messages)?;
    if let (Some(wanted), Some(found)) = (wanted, dimension)
        && wanted != found
    {
        let message = format!("{} is in {}, not in {}", entry.name(), words(found), words(wanted));
        messages.error(entry.at, message, "correct the formula");
        return None;
    }
    Some(Some(formula))
}

/// The unit of φ.
pub(super) fn phase_dimension(names: &Names) -> Dimension {
    names.known.get(PHASE).and_then(|known| known.dimension)
}

/// `{ bezier = […], over = [a, b], along = "…", plus = "…" }`, or `polynomial` for `bezier`.
pub(super) fn read_bezier(
    table: &Section<'_, '_>,
    (unit, names): (Dimension, &Names),
    messages: &mut Messages<'_>,
) -> Option<Curve> {
    table.check_keys(&["bezier", "polynomial", "over", "along", "plus"], messages);
    let along = read_moved(table, "along", (phase_dimension(names), names), messages);
    let plus = read_moved(table, "plus", (unit, names), messages);
    if let Some(entry) = table.get("polynomial").filter(|_| table.has("bezier")) {
        let message = format!("`{}` has `bezier` and `polynomial`", table.title);
        messages.error(entry.at, message, "remove one of them");
        return None;
    }
    let powers = table.has("polynomial");
    let mut need = |key: &'static str, help: &str| {
        let found = table.get(key);
        if found.is_none() {
            messages.error(table.at, format!("`{}` has no `{key}`", table.title), help);
        }
        found
    };
    let help = "add bezier = [0.1, 0.2, 0.1] or polynomial = [0.1, 0.2, -0.2], or write a formula";
    let coefficients = need(if powers { "polynomial" } else { "bezier" }, help);
    let over = need("over", "add over = [-0.2, 0.1]: φ at the first and at the last coefficient");
    let (coefficients, over) = (coefficients?, over?);
    let found = coefficients.numbers(messages)?;
    if !(2..=MOST).contains(&found.len()) {
        let message = format!("{} has {} coefficients", coefficients.name(), found.len());
        let help = format!("write 2 to {MOST} numbers: a polynomial has a degree of 1 or more");
        messages.error(coefficients.at, message, help);
        return None;
    }
    let places = range(&over, messages)?;
    if names.phase_in_rad {
        check_turns(&over, &places, messages);
    }
    let found = if powers { of_powers(&found) } else { found };
    Some(Curve::Bezier { coefficients: found, over: places, along: along?, plus: plus? })
}

/// The Bézier coefficients of Σ cₖ sᵏ with s from 0 to 1: bⱼ = Σₖ C(j, k) / C(n, k) cₖ.
fn of_powers(powers: &[f64]) -> Vec<f64> {
    let degree = powers.len() - 1;
    let mut part = vec![1.0; powers.len()];
    let mut found = Vec::with_capacity(powers.len());
    for j in 0..=degree {
        // C(j, k) / C(n, k) is the product of (j − i) / (n − i) over i below k.
        for k in 1..=degree {
            let i = (k - 1) as f64;
            part[k] = part[k - 1] * (j as f64 - i).max(0.0) / (degree as f64 - i);
        }
        found.push(powers.iter().zip(&part).map(|(c, part)| c * part).sum());
    }
    found
}

#[cfg(test)]
mod tests {
    use super::of_powers;

    #[test]
    fn powers_are_the_same_curve() {
        let powers = [0.3, -1.2, 0.7, 2.5, -0.4];
        let coefficients = of_powers(&powers);
        for s in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let wanted: f64 = powers.iter().rev().fold(0.0, |sum, c| sum * s + c);
            // De Casteljau.
            let mut row = coefficients.clone();
            while row.len() > 1 {
                row = row.windows(2).map(|two| (1.0 - s) * two[0] + s * two[1]).collect();
            }
            assert!((row[0] - wanted).abs() < 1e-13, "{} {wanted}", row[0]);
        }
    }
}
