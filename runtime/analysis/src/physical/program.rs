//! The semidefinite program and its certificate.
use super::bodies::{COORDINATES, Links, PLACES};
use super::bounds::Bounds;
use bipedc_effects::diagnostic::Diagnostic;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// `1 + X` keeps at least this much of CAD's pseudo-inertia in every direction.
const LEAST: f64 = 1e-4;

/// Row, column and value of a sparse matrix.
type Entry = (usize, usize, f64);

/// Conditions `A x + s = b` with s in the cones.
struct Conditions {
    entries: Vec<Entry>,
    right: Vec<f64>,
    cones: Vec<SupportedConeT<f64>>,
}

/// Unknowns as functions of the links' coordinates and the extras.
pub struct Problem<'a> {
    /// Links with mass.
    pub links: &'a Links,
    /// Conditions beside the data.
    pub bounds: &'a Bounds,
    /// Unknowns at CAD, extras zero.
    nominal: DVector<f64>,
    /// Derivatives by coordinates and extras.
    slopes: DMatrix<f64>,
    /// Extras that must not be negative.
    positive: Vec<usize>,
}

/// Proof of the answer by duality.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Certificate {
    /// Value of what is minimised.
    pub objective: f64,
    /// Lower bound by the dual: nothing can be better.
    pub bound: f64,
    /// Their difference over max(1, objective).
    pub gap: f64,
    /// Largest violation of the dual's conditions, relative to the size of their terms.
    pub residual: f64,
    /// Iterations of the solver; 0 where the free optimum was possible already.
    pub iterations: u32,
}

/// Parameters that bodies can have.
#[derive(Debug, Clone, PartialEq)]
pub struct Physical {
    /// Coordinates of the links.
    pub coordinates: Vec<f64>,
    /// Values of the extras.
    pub extras: Vec<f64>,
    /// The regression's unknowns.
    pub theta: DVector<f64>,
    /// Why this is the optimum.
    pub certificate: Certificate,
}

/// A regression: `‖factor · θ − right‖² + rest` over some rows.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastSquares {
    /// As many columns as there are unknowns θ.
    pub factor: DMatrix<f64>,
    /// As many numbers as the factor has rows.
    pub right: DVector<f64>,
    /// What no θ takes away.
    pub rest: f64,
    /// Rows behind it.
    pub rows: usize,
}

impl<'a> Problem<'a> {
    /// The program for unknowns θ that are `nominal` at CAD and change with coordinates, then extras, by `slopes`; of the
    /// extras those in `positive` are not negative.
    pub fn new(
        (nominal, slopes): (DVector<f64>, DMatrix<f64>),
        positive: Vec<usize>,
        links: &'a Links,
        bounds: &'a Bounds,
    ) -> Self {
        Self { links, bounds, nominal, slopes, positive }
    }

    /// Minimises `‖R θ − z‖²/N + weight Σ ‖X‖²` for a regression of N rows.
    ///
    /// # Errors
    /// Bounds that no body can keep together; a solver that gives up.
    pub fn solve(&self, data: &LeastSquares, weight: f64) -> Result<Physical, Diagnostic> {
        let quadratic = Quadratic::new(self, data, weight);
        if let Some(free) = self.free(&quadratic) {
            return Ok(free);
        }
        self.constrained(&quadratic)
    }

    /// The optimum without conditions, if it keeps them.
    fn free(&self, quadratic: &Quadratic) -> Option<Physical> {
        let x = &quadratic.free;
        let coordinates = &x.as_slice()[..self.links.coordinates()];
        let inside = coordinates.chunks_exact(COORDINATES).all(|x| smallest(x) >= LEAST);
        let signs = self.positive.iter().all(|e| x[self.links.coordinates() + e] >= 0.0);
        let equal = self.bounds.linear.iter().any(|condition| condition.equal);
        if equal || !(inside && signs && self.bounds.kept(coordinates, 0.0)) {
            return None;
        }
        let objective = quadratic.value(x);
        let residual = quadratic.slope(x).amax() / quadratic.size();
        let certificate = Certificate { objective, bound: objective, gap: 0.0, residual, iterations: 0 };
        Some(self.answer(x, certificate))
    }

    fn answer(&self, x: &DVector<f64>, certificate: Certificate) -> Physical {
        let (coordinates, extras) = x.as_slice().split_at(self.links.coordinates());
        Physical {
            theta: &self.nominal + &self.slopes * x,
            coordinates: coordinates.to_vec(),
            extras: extras.to_vec(),
            certificate,
        }
    }

    /// In the coordinates `δ = T (x − free)` of the factor `TᵀT` the program is a projection: the shortest δ that
    /// keeps the conditions. So its scale is that of the conditions, however precise the data are.
    fn constrained(&self, quadratic: &Quadratic) -> Result<Physical, Diagnostic> {
        let n = self.slopes.ncols();
        let refused = |why: String| {
            Diagnostic::error(format!("no physically possible parameters were found: {why}"))
                .help("warnings about the log come first: correct its units, signs and missing columns; then bounds that contradict each other")
        };
        let back = quadratic.triangle.solve_upper_triangular(&DMatrix::identity(n, n));
        let back = back.ok_or_else(|| refused("the regression is singular".to_owned()))?;
        let Conditions { entries: conditions, right, cones } = self.conditions();
        // Without conditions CAD itself is an answer: no δ needs to be longer than the one from there.
        let size = (&quadratic.triangle * &quadratic.free).norm().max(f64::MIN_POSITIVE.sqrt());
        let back = back * size;
        let mut a = DMatrix::zeros(right.len(), n);
        let mut b = DVector::from_column_slice(&right);
        for &(row, k, value) in &conditions {
            b[row] -= value * quadratic.free[k];
            a.row_mut(row).iter_mut().zip(back.row(k).iter()).for_each(|(a, x)| *a += value * x);
        }
        let entries = |m: &DMatrix<f64>| -> Vec<Entry> {
            (0..m.ncols())
                .flat_map(|j| (0..m.nrows()).map(move |i| (i, j)))
                .map(|(i, j)| (i, j, m[(i, j)]))
                .collect()
        };
        let p = sparse(n, n, &(0..n).map(|k| (k, k, 2.0)).collect::<Vec<_>>());
        let a = sparse(b.len(), n, &entries(&a));
        let mut said = String::new();
        for settings in attempts() {
            let mut solver = DefaultSolver::new(&p, &vec![0.0; n], &a, b.as_slice(), &cones, settings)
                .map_err(|e| refused(e.to_string()))?;
            solver.solve();
            let solution = &solver.solution;
            let x = &quadratic.free + &back * DVector::from_column_slice(&solution.x);
            let dual = DVector::from_column_slice(&solution.z) * (size * size);
            let certificate = certificate(quadratic, &x, (&conditions, &right, &dual), solution.iterations);
            let solved = matches!(solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved);
            if solved || self.proven(&x, &certificate) {
                return Ok(self.answer(&x, certificate));
            }
            said = format!("the solver says {:?}", solution.status);
        }
        Err(refused(said))
    }

    /// Whether a point is possible and optimal by its own certificate, whatever the solver thinks of it: rounding often
    /// stops it a step before its own measure of the end.
    fn proven(&self, x: &DVector<f64>, certificate: &Certificate) -> bool {
        let (coordinates, extras) = x.as_slice().split_at(self.links.coordinates());
        let possible = coordinates.chunks_exact(COORDINATES).all(|x| smallest(x) >= 0.5 * LEAST)
            && self.positive.iter().all(|e| extras[*e] >= -PROVEN)
            && self.bounds.kept(coordinates, PROVEN);
        // Comparisons with what is no number are false.
        possible && certificate.gap.abs() < PROVEN && certificate.residual < PROVEN
    }

    /// Zero, not negative, semidefinite.
    fn conditions(&self) -> Conditions {
        let (mut rows, mut b, mut cones) = (Vec::new(), Vec::new(), Vec::new());
        let equal = self.bounds.linear.iter().filter(|c| c.equal);
        let unequal = self.bounds.linear.iter().filter(|c| !c.equal);
        for condition in equal.clone().chain(unequal.clone()) {
            // Scaled to length 1: conditions on masses and on inertias differ by orders.
            let length = condition.factors.iter().map(|(_, f)| f * f).sum::<f64>().sqrt();
            let scale = 1.0 / length.max(f64::MIN_POSITIVE);
            rows.extend(condition.factors.iter().map(|(k, f)| (b.len(), *k, -scale * f)));
            b.push(scale * condition.constant);
        }
        let coordinates = self.links.coordinates();
        for e in &self.positive {
            rows.push((b.len(), coordinates + e, -1.0));
            b.push(0.0);
        }
        let equals = equal.count();
        if equals > 0 {
            cones.push(SupportedConeT::ZeroConeT(equals));
        }
        if b.len() > equals {
            cones.push(SupportedConeT::NonnegativeConeT(b.len() - equals));
        }
        for link in 0..self.links.bodies.len() {
            for (place, (i, j)) in PLACES.iter().enumerate() {
                rows.push((b.len(), link * COORDINATES + place, -1.0));
                b.push(if i == j { 1.0 - LEAST } else { 0.0 });
            }
            cones.push(SupportedConeT::PSDTriangleConeT(4));
        }
        Conditions { entries: rows, right: b, cones }
    }

    /// Derivatives of the regression's unknowns by coordinates and extras.
    pub fn slopes(&self) -> &DMatrix<f64> {
        &self.slopes
    }
}

/// Gap and residual of a certificate that proves an optimum.
const PROVEN: f64 = 1e-6;

/// Settings of the solver, the usual ones first; then such that cope with what rounding spoilt.
fn attempts() -> [DefaultSettings<f64>; 3] {
    let usual = DefaultSettings {
        verbose: false,
        // Precise data make large multipliers, which must not pass for a proof that nothing is possible.
        tol_infeas_abs: 1e-12,
        tol_infeas_rel: 1e-12,
        ..DefaultSettings::default()
    };
    let unscaled = DefaultSettings { equilibrate_enable: false, ..usual.clone() };
    let short =
        DefaultSettings { max_step_fraction: 0.9, static_regularization_constant: 1e-9, ..usual.clone() };
    [usual, unscaled, short]
}

/// Smallest eigenvalue of `1 + X`.
fn smallest(x: &[f64]) -> f64 {
    let mut m = nalgebra::Matrix4::identity();
    for (place, &(i, j)) in PLACES.iter().enumerate() {
        let value = if i == j { 1.0 + x[place] } else { x[place] / std::f64::consts::SQRT_2 };
        (m[(i, j)], m[(j, i)]) = (value, value);
    }
    m.symmetric_eigenvalues().min()
}

/// `‖stacked · x − right‖² + rest`.
struct Quadratic {
    stacked: DMatrix<f64>,
    right: DVector<f64>,
    rest: f64,
    /// `TᵀT = stackedᵀ stacked`, upper.
    triangle: DMatrix<f64>,
    /// Where it is smallest.
    free: DVector<f64>,
}

/// Extras that neither data nor CAD tell stay where they are: this part of their column's length holds them at zero.
const HELD: f64 = 1e-7;

impl Quadratic {
    fn new(problem: &Problem<'_>, data: &LeastSquares, weight: f64) -> Self {
        let (n, coordinates) = (problem.slopes.ncols(), problem.links.coordinates());
        let scale = 1.0 / (data.rows.max(1) as f64).sqrt();
        let factor = &data.factor * scale;
        let rows = factor.nrows();
        let mut stacked = DMatrix::zeros(rows + n, n);
        stacked.rows_mut(0, rows).copy_from(&(&factor * &problem.slopes));
        for k in 0..n {
            let length = stacked.column(k).norm();
            let held = if length > 0.0 { HELD * length } else { 1.0 };
            stacked[(rows + k, k)] = if k < coordinates { weight.sqrt() } else { held };
        }
        let mut right = DVector::zeros(rows + n);
        right.rows_mut(0, rows).copy_from(&(&data.right * scale - factor * &problem.nominal));
        let qr = stacked.clone().qr();
        let triangle = qr.r();
        let mut turned = right.clone();
        qr.q_tr_mul(&mut turned);
        let mut free = turned.rows(0, n).into_owned();
        if !triangle.solve_upper_triangular_mut(&mut free) {
            free.fill(0.0);
        }
        Self { stacked, right, rest: data.rest * scale * scale, triangle, free }
    }

    fn value(&self, x: &DVector<f64>) -> f64 {
        (&self.stacked * x - &self.right).norm_squared() + self.rest
    }

    fn slope(&self, x: &DVector<f64>) -> DVector<f64> {
        self.stacked.tr_mul(&(&self.stacked * x - &self.right)) * 2.0
    }

    /// Size of the terms in [`Self::slope`].
    fn size(&self) -> f64 {
        (2.0 * self.stacked.tr_mul(&self.right).amax()).max(f64::MIN_POSITIVE.sqrt())
    }
}

/// The dual bound computed from the solver's multipliers, not taken from the solver: for
/// `min ‖F x − g‖²  s.t.  A x + s = b, s ∈ K` any z in the dual cone gives
/// `‖g‖² − ‖F x‖² − bᵀz` as a lower bound where `2 Fᵀ(F x − g) + Aᵀ z = 0`.
fn certificate(
    quadratic: &Quadratic,
    x: &DVector<f64>,
    (rows, b, z): (&[Entry], &[f64], &DVector<f64>),
    iterations: u32,
) -> Certificate {
    let mut slope = quadratic.slope(x);
    for &(row, k, value) in rows {
        slope[k] += value * z[row];
    }
    let objective = quadratic.value(x);
    let multipliers: f64 = b.iter().zip(z.iter()).map(|(b, z)| b * z).sum();
    let fitted = (&quadratic.stacked * x).norm_squared();
    let bound = quadratic.right.norm_squared() - fitted - multipliers + quadratic.rest;
    let gap = (objective - bound) / objective.abs().max(1.0);
    Certificate { objective, bound, gap, residual: slope.amax() / quadratic.size(), iterations }
}

fn sparse(rows: usize, columns: usize, triplets: &[Entry]) -> CscMatrix<f64> {
    let kept = || triplets.iter().filter(|t| t.2 != 0.0);
    CscMatrix::new_from_triplets(
        rows,
        columns,
        kept().map(|t| t.0).collect(),
        kept().map(|t| t.1).collect(),
        kept().map(|t| t.2).collect(),
    )
}
