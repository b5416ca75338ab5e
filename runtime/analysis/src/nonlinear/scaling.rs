//! A program with rows and objective of comparable size.
use super::Program;

/// Largest slope of a scaled row at the first guess.
const LARGEST: f64 = 100.0;

/// Factors of objective and constraints.
pub(super) struct Scaling {
    pub objective: f64,
    pub rows: Vec<f64>,
}

impl Scaling {
    /// From the slopes at x.
    pub fn new(program: &dyn Program, structure: &[[usize; 2]], x: &[f64]) -> Self {
        let factor = |largest: f64| if largest > LARGEST { (LARGEST / largest).max(1e-8) } else { 1.0 };
        let mut gradient = vec![0.0; x.len()];
        program.gradient(x, &mut gradient);
        let mut values = vec![0.0; structure.len()];
        program.jacobian(x, &mut values);
        let mut rows = vec![0.0f64; program.limits().len()];
        for (&[row, _], value) in structure.iter().zip(&values) {
            rows[row] = rows[row].max(value.abs());
        }
        let largest = gradient.iter().fold(0.0f64, |a, b| a.max(b.abs()));
        Self { objective: factor(largest), rows: rows.into_iter().map(factor).collect() }
    }
}
