//! Base parameters as people and programs read them.
use super::coefficients::{Coefficient, Group};
use super::columns::Column;
use super::fraction::Fraction;
use serde::Serialize;

/// Which combinations of inertial parameters a model depends on (thesis 5.2.2).
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BaseParameters {
    /// Number of base parameters: the exact rank of the regressor over all states.
    pub rank: usize,
    /// All columns of the regressor, in order of preference.
    pub columns: Vec<Column>,
    /// The minimal set.
    pub parameters: Vec<BaseParameter>,
    /// Columns that are zero in every state: these parameters do not matter at all.
    pub unidentifiable: Vec<String>,
    /// Angles that were taken as right angles: where, and what the description says (rad).
    pub assumed_right_angles: Vec<(String, f64)>,
    /// Prime fields used, the certifying one included.
    pub primes: usize,
}

/// One base parameter: a sum of inertial parameters that only act together.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BaseParameter {
    /// The column that stands for the group; its coefficient is 1.
    pub leading: usize,
    /// All terms, the leading one first.
    pub combination: Vec<Term>,
    /// Such as `torso.m*cx + 0.0764 (left_hip + left_knee).m`; `~` marks a rounded coefficient.
    pub text: String,
    /// `kg`, `kg m` or `kg m²`.
    pub unit: &'static str,
    /// Value for the parameters of the description, in that unit.
    pub value: f64,
}

/// One inertial parameter in a base parameter.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Term {
    /// Index among the columns.
    pub column: usize,
    /// Name of that column.
    pub name: String,
    /// Factor, in the unit that makes the term fit the sum.
    pub coefficient: f64,
    /// The factor as a fraction, if certified; else it is rounded.
    pub exact: Option<String>,
}

impl BaseParameters {
    /// Puts groups into words; `values` are those of the columns.
    pub(super) fn new(
        columns: Vec<Column>,
        groups: &[Group],
        values: &[f64],
        assumed_right_angles: Vec<(String, f64)>,
        primes: usize,
    ) -> Self {
        let parameters: Vec<_> = groups.iter().map(|group| parameter(&columns, group, values)).collect();
        let mut seen = vec![false; columns.len()];
        for term in parameters.iter().flat_map(|parameter| &parameter.combination) {
            seen[term.column] = true;
        }
        let unseen = columns.iter().zip(&seen).filter(|(_, seen)| !**seen);
        let unidentifiable = unseen.map(|(column, _)| column.name.clone()).collect();
        let rank = groups.len();
        Self { rank, columns, parameters, unidentifiable, assumed_right_angles, primes }
    }

    /// The matrix that makes base parameters of parameters (5.6): `rank` rows.
    pub fn matrix(&self) -> Vec<Vec<f64>> {
        let row = |parameter: &BaseParameter| {
            let mut row = vec![0.0; self.columns.len()];
            for term in &parameter.combination {
                row[term.column] = term.coefficient;
            }
            row
        };
        self.parameters.iter().map(row).collect()
    }

    /// Indices of the columns that form the base regressor.
    pub fn independent_columns(&self) -> Vec<usize> {
        self.parameters.iter().map(|parameter| parameter.leading).collect()
    }

    /// Number of columns that are not zero: how many of the list's parameters appear in the model.
    pub fn appearing(&self) -> usize {
        self.columns.len() - self.unidentifiable.len()
    }
}

fn parameter(columns: &[Column], group: &Group, values: &[f64]) -> BaseParameter {
    let term = |column: usize, coefficient: &Coefficient| {
        let (coefficient, exact) = match coefficient {
            Coefficient::Exact(fraction) => (fraction.to_f64(), Some(fraction.to_string())),
            Coefficient::Rounded(value) => (*value, None),
        };
        Term { column, name: columns[column].name.clone(), coefficient, exact }
    };
    let mut combination = vec![term(group.leading, &Coefficient::Exact(Fraction::read(1.0)))];
    combination.extend(group.others.iter().map(|(column, coefficient)| term(*column, coefficient)));
    let value = combination.iter().map(|term| term.coefficient * values[term.column]).sum();
    let text = sum_text(columns, &combination);
    BaseParameter { leading: group.leading, combination, text, unit: columns[group.leading].unit, value }
}

/// The sum in words; the same parameter of several links with one factor is written once.
fn sum_text(columns: &[Column], combination: &[Term]) -> String {
    let mut text = combination.first().map_or(String::new(), |leading| leading.name.clone());
    let mut bundles: Vec<Vec<&Term>> = Vec::new();
    for term in combination.iter().skip(1) {
        // Lengths in oddly turned frames are rounded before the analysis and leave 1e-16 behind; that stays
        // in the combination and is not worth reading.
        if term.exact.is_none() && term.coefficient.abs() < 1e-12 {
            continue;
        }
        let alike = |other: &Term| {
            (other.coefficient < 0.0) == (term.coefficient < 0.0)
                && factor_text(other) == factor_text(term)
                && columns[other.column].parameter == columns[term.column].parameter
        };
        match bundles.iter_mut().find(|bundle| alike(bundle[0])) {
            Some(bundle) => bundle.push(term),
            None => bundles.push(vec![term]),
        }
    }
    for bundle in bundles {
        text.push_str(if bundle[0].coefficient < 0.0 { " - " } else { " + " });
        text.push_str(&factor_text(bundle[0]));
        if let [term] = bundle[..] {
            text.push_str(&term.name);
            continue;
        }
        let links: Vec<&str> = bundle.iter().map(|term| columns[term.column].link.as_str()).collect();
        text.push_str(&format!("({}).{}", links.join(" + "), columns[bundle[0].column].parameter));
    }
    text
}

/// The size of the factor and a blank; nothing for 1.
fn factor_text(term: &Term) -> String {
    let size = term.coefficient.abs();
    match &term.exact {
        Some(_) if size == 1.0 => String::new(),
        Some(_) => format!("{} ", decimal(size)),
        None => format!("~{} ", decimal(size)),
    }
}

/// At most ten significant digits, no trailing zeros.
fn decimal(value: f64) -> String {
    let short = value.to_string();
    if short.len() <= 12 {
        return short;
    }
    let rounded: f64 = format!("{value:.9e}").parse().unwrap_or(value);
    if (1e-4..1e6).contains(&rounded) { rounded.to_string() } else { format!("{rounded:e}") }
}

impl std::fmt::Display for BaseParameters {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        writeln!(f, "{} base parameters of {} columns (exact)", self.rank, self.columns.len())?;
        for (index, parameter) in self.parameters.iter().enumerate() {
            let value = format!("{:.6}", parameter.value);
            writeln!(f, "{:4}  {value:>12} {:<5}  {}", index + 1, parameter.unit, parameter.text)?;
        }
        if !self.unidentifiable.is_empty() {
            writeln!(f, "without influence: {}", self.unidentifiable.join(", "))?;
        }
        for (place, angle) in &self.assumed_right_angles {
            let what = if place.starts_with("axis") { "a coordinate axis" } else { "a multiple of pi/2" };
            writeln!(f, "{place}: angle {angle} rad taken as {what}")?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_read_well() {
        let text = |coefficient, exact: Option<&str>| {
            factor_text(&Term {
                column: 0,
                name: String::new(),
                coefficient,
                exact: exact.map(str::to_owned),
            })
        };
        assert_eq!(text(-0.0764, Some("-191/2500")), "0.0764 ");
        assert_eq!(text(-1.0, Some("-1")), "");
        assert_eq!(text(1.0 / 3.0, None), "~0.3333333333 ");
        assert_eq!(decimal(1.234_567_890_123e-9), "1.23456789e-9");
    }
}
