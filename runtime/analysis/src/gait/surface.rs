//! The constraint surface q = T(φ, p) (6.5).
use super::functions::GaitModel;
use bipedc_runtime::model::{Argument, State};
use std::fmt;

/// Iterations after which there is no solution nearby.
const ITERATIONS: usize = 60;
/// Residuals (m, rad) of a solution.
const SOLVED: f64 = 1e-12;
/// A pivot below this part of the largest one means that the constraints do not fix q.
const SINGULAR: f64 = 1e-12;

/// A point of the constraint surface.
#[derive(Debug, Clone, PartialEq)]
pub struct SurfacePoint {
    /// T, m and rad.
    pub q: Vec<f64>,
    /// T′, per unit of φ.
    pub slope: Vec<f64>,
    /// T″.
    pub curvature: Vec<f64>,
}

impl SurfacePoint {
    /// A posture of which nothing is known but itself.
    pub(super) fn at_rest(q: &[f64]) -> Self {
        Self { q: q.to_vec(), slope: vec![0.0; q.len()], curvature: vec![0.0; q.len()] }
    }

    /// About where the surface is so much further on.
    pub(super) fn ahead(&self, by: f64) -> Vec<f64> {
        let slopes = self.slope.iter().zip(&self.curvature);
        self.q.iter().zip(slopes).map(|(q, (slope, bend))| q + by * (slope + 0.5 * by * bend)).collect()
    }
}

/// Why there is no point of the surface at a phase.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceFailure {
    /// The outputs and the phase variable do not fix the joints there.
    Singular,
    /// No posture was found where the outputs vanish.
    NotConverged,
    /// Formulas, or their slopes, are no finite numbers there.
    NotFinite,
}

impl fmt::Display for SurfaceFailure {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Singular => "the outputs do not fix the joints",
            Self::NotConverged => "no posture was found where the outputs vanish",
            Self::NotFinite => "the formulas or their slopes are no finite numbers",
        })
    }
}

impl GaitModel<'_> {
    /// T, T′ and T″ at the arguments of a gait (φ first): in closed form where there is one, else by Newton's method from `near`.
    ///
    /// # Errors
    /// No such posture, or no single one.
    pub fn surface(&self, arguments: &[f64], near: &[f64]) -> Result<SurfacePoint, SurfaceFailure> {
        let Some(function) = self.functions.surface else { return self.iterate(arguments, near) };
        let found = self.call(function, &State::new().with(Argument::Parameters, arguments));
        if found.iter().any(|x| !x.is_finite()) {
            return Err(SurfaceFailure::NotFinite);
        }
        let column = |k: usize| found[k * self.size()..(k + 1) * self.size()].to_vec();
        Ok(SurfacePoint { q: column(0), slope: column(1), curvature: column(2) })
    }

    fn iterate(&self, arguments: &[f64], near: &[f64]) -> Result<SurfacePoint, SurfaceFailure> {
        let q = self.newton(arguments, near)?;
        let state = State::new().with(Argument::Parameters, arguments).with(Argument::Q, &q);
        let factors = self.factors(&state)?;
        let slope = factors(&self.call(self.functions.slope, &state))?;
        let state = state.with(Argument::V, &slope);
        let curvature = factors(&self.call(self.functions.curvature, &state))?;
        let finite = slope.iter().chain(&curvature).all(|x| x.is_finite());
        if finite { Ok(SurfacePoint { slope, curvature, q }) } else { Err(SurfaceFailure::NotFinite) }
    }

    /// q where all constraints vanish: steps are halved while they make it worse.
    fn newton(&self, arguments: &[f64], near: &[f64]) -> Result<Vec<f64>, SurfaceFailure> {
        let residual = |q: &[f64]| {
            let state = State::new().with(Argument::Parameters, arguments).with(Argument::Q, q);
            let found = self.call(self.functions.constraints, &state);
            let size = found.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            (if found.iter().any(|x| x.is_nan()) { f64::INFINITY } else { size }, found)
        };
        let mut q = near.to_vec();
        let (mut size, mut values) = residual(&q);
        for _ in 0..ITERATIONS {
            let state = State::new().with(Argument::Parameters, arguments).with(Argument::Q, &q);
            let step = self.factors(&state)?(&values)?;
            let mut scale = 1.0;
            let (next, found) = loop {
                let next: Vec<f64> = q.iter().zip(&step).map(|(q, d)| q + scale * d).collect();
                let found = residual(&next);
                // What a whole step does not make better near a solution is rounding.
                if found.0 < size || scale < 1e-3 || size <= SOLVED {
                    break (next, found);
                }
                scale *= 0.5;
            };
            if found.0 >= size {
                break;
            }
            (q, (size, values)) = (next, found);
            if size == 0.0 {
                break;
            }
        }
        if size <= SOLVED { Ok(q) } else { Err(SurfaceFailure::NotConverged) }
    }

    /// Solves J x = −b for the Jacobian of the constraints at a state.
    fn factors(
        &self,
        state: &State<'_, f64>,
    ) -> Result<impl Fn(&[f64]) -> Result<Vec<f64>, SurfaceFailure> + use<>, SurfaceFailure> {
        let columns = self.call(self.functions.jacobian, state);
        if columns.iter().any(|x| !x.is_finite()) {
            return Err(SurfaceFailure::NotFinite);
        }
        let factors = Factors::new(columns, self.size()).ok_or(SurfaceFailure::Singular)?;
        Ok(move |b: &[f64]| Ok(factors.solved(b)))
    }
}

/// L and U of a small matrix, rows exchanged: a general library spends more on its own generality than on nine joints.
struct Factors {
    /// Column after column.
    columns: Vec<f64>,
    /// Rows by their places.
    rows: Vec<usize>,
}

impl Factors {
    /// None where a pivot is next to nothing beside the largest one.
    fn new(mut columns: Vec<f64>, n: usize) -> Option<Self> {
        let mut rows: Vec<usize> = (0..n).collect();
        let (mut least, mut largest) = (f64::INFINITY, 0.0_f64);
        for k in 0..n {
            let size = |row: &usize| columns[k * n + row].abs();
            let pivot = (k..n).max_by(|a, b| size(a).total_cmp(&size(b)))?;
            if pivot != k {
                rows.swap(k, pivot);
                (0..n).for_each(|column| columns.swap(column * n + k, column * n + pivot));
            }
            let (done, rest) = columns.split_at_mut((k + 1) * n);
            let own = &mut done[k * n..];
            let pivot = own[k];
            (least, largest) = (least.min(pivot.abs()), largest.max(pivot.abs()));
            own[k + 1..].iter_mut().for_each(|x| *x /= pivot);
            for column in rest.chunks_exact_mut(n) {
                let above = column[k];
                column[k + 1..].iter_mut().zip(&own[k + 1..]).for_each(|(x, l)| *x -= l * above);
            }
        }
        (least > SINGULAR * largest).then_some(Self { columns, rows })
    }

    /// x of A x = −b.
    fn solved(&self, b: &[f64]) -> Vec<f64> {
        let n = self.rows.len();
        let mut x: Vec<f64> = self.rows.iter().map(|&row| -b[row]).collect();
        for k in 0..n {
            let (known, rest) = x.split_at_mut(k + 1);
            let column = &self.columns[k * n + k + 1..(k + 1) * n];
            rest.iter_mut().zip(column).for_each(|(x, l)| *x -= l * known[k]);
        }
        for k in (0..n).rev() {
            let column = &self.columns[k * n..k * n + k + 1];
            let (above, own) = x.split_at_mut(k);
            own[0] /= column[k];
            above.iter_mut().zip(column).for_each(|(x, u)| *x -= u * own[0]);
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::Factors;

    /// Column after column; its first pivot is zero.
    const MATRIX: [f64; 9] = [0.0, 2.0, 1.0, 1.0, -1.0, 0.5, 3.0, 0.0, 4.0];

    #[test]
    fn what_factors_solve_is_solved() {
        let b = [1.0, -2.0, 0.5];
        let x = Factors::new(MATRIX.to_vec(), 3).unwrap().solved(&b);
        for row in 0..3 {
            let sum: f64 = (0..3).map(|column| MATRIX[3 * column + row] * x[column]).sum();
            assert!((sum + b[row]).abs() < 1e-15, "{row} {sum}");
        }
    }

    #[test]
    fn matrices_that_fix_nothing_have_no_factors() {
        assert!(Factors::new(vec![1.0, 2.0, 2.0, 4.0], 2).is_none());
        assert!(Factors::new(vec![0.0; 4], 2).is_none());
        assert!(Factors::new(vec![1.0, 0.0, 0.0, 1e-13], 2).is_none());
    }
}
