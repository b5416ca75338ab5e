//! The constraint surface q = T(φ, p) (6.5).
use super::functions::GaitModel;
use bipedc_runtime::model::{Argument, State};
use nalgebra::{DMatrix, DVector};
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
                if found.0 < size || scale < 1e-3 {
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
        let n = self.size();
        let columns = self.call(self.functions.jacobian, state);
        if columns.iter().any(|x| !x.is_finite()) {
            return Err(SurfaceFailure::NotFinite);
        }
        let factors = DMatrix::from_vec(n, n, columns).full_piv_lu();
        let pivots = factors.u().diagonal().map(f64::abs);
        if pivots.min() <= SINGULAR * pivots.max() {
            return Err(SurfaceFailure::Singular);
        }
        Ok(move |b: &[f64]| {
            let right = -DVector::from_column_slice(b);
            let solved = factors.solve(&right).ok_or(SurfaceFailure::Singular)?;
            Ok(solved.as_slice().to_vec())
        })
    }
}
