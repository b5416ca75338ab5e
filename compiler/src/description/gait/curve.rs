//! What an output is to be over φ: a formula, or a polynomial by its Bezier coefficients.
use super::read::range;
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
    },
}

impl Curve {
    /// How far beyond its ends a polynomial is followed, of its length.
    pub const BEYOND: f64 = 0.15;

    /// Names that it depends on; those of a polynomial are `phase` alone.
    pub fn names(&self) -> &[String] {
        match self {
            Self::Formula(formula) => formula.names(),
            Self::Bezier { .. } => &[],
        }
    }
}

/// `{ bezier = […], over = [a, b] }`
pub(super) fn read_bezier(table: &Section<'_, '_>, messages: &mut Messages<'_>) -> Option<Curve> {
    table.check_keys(&["bezier", "over"], messages);
    let mut need = |key: &'static str, help: &str| {
        let found = table.get(key);
        if found.is_none() {
            messages.error(table.at, format!("`{}` has no `{key}`", table.title), help);
        }
        found
    };
    let coefficients = need("bezier", "add bezier = [0.1, 0.2, 0.1], or write a formula");
    let over = need("over", "add over = [-0.2, 0.1]: φ at the first and at the last coefficient");
    let (coefficients, over) = (coefficients?, over?);
    let found = coefficients.numbers(messages)?;
    if !(2..=MOST).contains(&found.len()) {
        let message = format!("{} has {} coefficients", coefficients.name(), found.len());
        let help = format!("write 2 to {MOST} numbers: a polynomial has a degree of 1 or more");
        messages.error(coefficients.at, message, help);
        return None;
    }
    Some(Curve::Bezier { coefficients: found, over: range(&over, messages)? })
}
