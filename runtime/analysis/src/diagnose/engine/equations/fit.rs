//! Fits of effects and inertial corrections together, and their errors on other data.
use super::block_equations::{BlockEquations, Spread};
use crate::experiments::form::{Form, Search};
use crate::robot::inertial_parameters::parameter_index;
use nalgebra::{DMatrix, DVector};

/// What one coefficient multiplies.
#[derive(Debug, Clone)]
pub(crate) enum Term {
    /// A column by its id.
    Data(usize),
    /// A direction of inertial parameters, as multiples of the spread.
    Inertial(Vec<f64>),
}

/// A form with its terms.
pub(crate) struct Candidate {
    pub form: Form,
    pub terms: Vec<Term>,
    /// Rows that it touches.
    pub rows: Vec<usize>,
    /// Parameters that the data decide; those of columns that are zero throughout are none.
    pub parameters: usize,
}

impl Candidate {
    pub fn new(form: Form, ids: &[usize], rows: Vec<usize>, spread: &Spread, idle: usize) -> Self {
        let parameters = form.parameters().saturating_sub(idle).max(1);
        let terms = match &form.search {
            Search::Probes(_) => ids.iter().map(|&id| Term::Data(id)).collect(),
            Search::Inertial(directions) => {
                directions.iter().map(|d| Term::Inertial(spread.coordinates(d))).collect()
            }
        };
        Self { form, terms, rows, parameters }
    }

    /// How far off inertial parameters are with these coefficients, in standard deviations of CAD data (root mean square over the
    /// candidate's parameters); `None` if it changes none.
    pub fn deviations(&self, coefficients: &[f64]) -> Option<f64> {
        let mut sum: Vec<f64> = Vec::new();
        for (term, coefficient) in self.terms.iter().zip(coefficients) {
            let Term::Inertial(direction) = term else { return None };
            sum.resize(direction.len(), 0.0);
            sum.iter_mut().zip(direction).for_each(|(sum, x)| *sum += coefficient * x);
        }
        let squares: f64 = sum.iter().map(|x| x * x).sum();
        (!sum.is_empty()).then(|| (squares / self.terms.len() as f64).sqrt())
    }
}

/// Sums of products over some blocks of all rows.
pub(crate) struct NormalEquations {
    pub rows: Vec<RowEquations>,
}

/// One row of [`NormalEquations`].
pub(crate) struct RowEquations {
    bodies: Vec<usize>,
    ids: Vec<usize>,
    gram: DMatrix<f64>,
    /// Samples.
    pub count: usize,
}

/// Products of everything in a row, over some blocks or one.
#[derive(Clone, Copy)]
pub(crate) struct RowGram<'a> {
    /// Those of [`BlockEquations::bodies`], whose inertial columns come first.
    pub bodies: &'a [usize],
    /// Ids of the columns that follow, ascending.
    pub ids: &'a [usize],
    /// Symmetric; the residual is last.
    pub gram: &'a DMatrix<f64>,
}

impl RowGram<'_> {
    /// Sum of squares of a combination of everything: places, each once, and factors.
    fn square(&self, used: &[(usize, f64)]) -> f64 {
        let rows = self.gram.nrows();
        let mut sum = 0.0;
        for (k, &(c, factor)) in used.iter().enumerate() {
            let column = &self.gram.as_slice()[c * rows..(c + 1) * rows];
            // Symmetric: pairs count twice.
            let before: f64 = used[..k].iter().map(|&(r, x)| x * column[r]).sum();
            sum += factor * (2.0 * before + factor * column[c]);
        }
        sum.max(0.0)
    }

    /// Corrections and terms with these coefficients, as a combination of everything. Most columns of the library are idle.
    fn combined(&self, corrections: &[f64], terms: &[(&Term, f64)]) -> Vec<(usize, f64)> {
        let p = parameter_index(self.bodies.len(), 0);
        let mut used = Vec::new();
        let has_inertial = terms.iter().any(|(term, _)| matches!(term, Term::Inertial(_)));
        if has_inertial || !corrections.is_empty() {
            let mut inertial = vec![0.0; p];
            let directions = terms.iter().filter_map(|(term, factor)| match term {
                Term::Inertial(direction) => Some((direction.as_slice(), *factor)),
                Term::Data(_) => None,
            });
            let own = (!corrections.is_empty()).then_some((corrections, 1.0));
            for (direction, factor) in own.into_iter().chain(directions) {
                for (sum, body) in inertial.chunks_exact_mut(10).zip(self.bodies) {
                    let of_body = &direction[parameter_index(*body, 0)..][..10];
                    sum.iter_mut().zip(of_body).for_each(|(sum, x)| *sum += factor * x);
                }
            }
            used.extend(inertial.into_iter().enumerate().filter(|(_, factor)| *factor != 0.0));
        }
        for (term, factor) in terms {
            let Term::Data(id) = term else { continue };
            if let Ok(place) = self.ids.binary_search(id) {
                used.push((p + place, *factor));
            }
        }
        used
    }

    /// Sum of squares of what a fit leaves.
    fn error(&self, corrections: &[f64], terms: &[(&Term, f64)]) -> f64 {
        let mut used = self.combined(corrections, terms);
        used.push((self.gram.nrows() - 1, -1.0));
        self.square(&used)
    }
}

impl RowEquations {
    fn as_gram(&self) -> RowGram<'_> {
        RowGram { bodies: &self.bodies, ids: &self.ids, gram: &self.gram }
    }

    fn residual(&self) -> usize {
        self.gram.nrows() - 1
    }
    /// Sum of squares of the residual.
    pub fn squares(&self) -> f64 {
        self.gram[(self.residual(), self.residual())]
    }
    /// The products of everything with a term that is `local` here.
    fn product(&self, term: &Term, local: &DVector<f64>) -> DVector<f64> {
        match term {
            // One column of the sums.
            Term::Data(_) => {
                let place = local.iter().position(|x| *x != 0.0).unwrap_or(0);
                self.gram.column(place).into_owned()
            }
            Term::Inertial(_) => {
                let inertial = parameter_index(self.bodies.len(), 0);
                self.gram.columns(0, inertial) * local.rows(0, inertial)
            }
        }
    }

    /// A term in the coordinates of this row; `None` if it does not touch it.
    fn local(&self, term: &Term) -> Option<DVector<f64>> {
        let mut out = DVector::zeros(self.gram.nrows());
        self.add(term, 1.0, &mut out).then_some(out)
    }

    /// Adds a multiple of a term in the coordinates of this row; tells whether the term touches it.
    fn add(&self, term: &Term, factor: f64, out: &mut DVector<f64>) -> bool {
        match term {
            Term::Data(id) => {
                let Ok(place) = self.ids.binary_search(id) else { return false };
                out[parameter_index(self.bodies.len(), 0) + place] += factor;
            }
            Term::Inertial(direction) => {
                for (place, body) in self.bodies.iter().enumerate() {
                    for k in 0..10 {
                        out[parameter_index(place, k)] += factor * direction[parameter_index(*body, k)];
                    }
                }
            }
        }
        true
    }
}

impl NormalEquations {
    /// All rows.
    pub fn grams(&self) -> impl Iterator<Item = RowGram<'_>> {
        self.rows.iter().map(RowEquations::as_gram)
    }

    pub fn of(equations: &[BlockEquations], blocks: &[usize]) -> Self {
        let rows = equations.iter().map(|of_row| RowEquations {
            bodies: of_row.bodies.clone(),
            ids: of_row.ids.clone(),
            gram: of_row.sum(blocks),
            count: of_row.count(blocks),
        });
        Self { rows: rows.collect() }
    }
}

/// The normal equations of the inertial corrections alone, for given weights, factored once for all fits.
///
/// They are the larger part of every fit and the same in all: each fit adds the few rows of its terms.
pub(crate) struct Corrections {
    /// One over the roots of the diagonal, prior included.
    scale: DVector<f64>,
    /// Cholesky factor of the scaled matrix with the prior.
    lower: DMatrix<f64>,
    /// The scaled right side, through the factor once.
    right: DVector<f64>,
    /// The corrections without any term.
    alone: DVector<f64>,
}

impl Corrections {
    pub fn new(train: &NormalEquations, weights: &[f64], count: usize) -> Self {
        let mut matrix = DMatrix::zeros(count, count);
        let mut right = DVector::zeros(count);
        for (row, w) in train.rows.iter().zip(weights) {
            for (a, body_a) in row.bodies.iter().enumerate() {
                for i in 0..10 {
                    right[parameter_index(*body_a, i)] +=
                        w * row.gram[(parameter_index(a, i), row.residual())];
                    for (b, body_b) in row.bodies.iter().enumerate() {
                        for k in 0..10 {
                            matrix[(parameter_index(*body_a, i), parameter_index(*body_b, k))] +=
                                w * row.gram[(parameter_index(a, i), parameter_index(b, k))];
                        }
                    }
                }
            }
        }
        Self::factored(matrix, right)
    }

    /// The unit matrix as prior makes the matrix positive definite; numbers that are none make a factor of such.
    fn factored(mut matrix: DMatrix<f64>, right: DVector<f64>) -> Self {
        let count = right.len();
        for i in 0..count {
            matrix[(i, i)] += 1.0;
        }
        let scale = DVector::from_fn(count, |i, _| matrix[(i, i)].sqrt().recip());
        let scaled = DMatrix::from_fn(count, count, |r, c| matrix[(r, c)] * scale[r] * scale[c]);
        let lower =
            scaled.cholesky().map_or_else(|| DMatrix::from_element(count, count, f64::NAN), |c| c.unpack());
        let mut right = right.component_mul(&scale);
        lower.solve_lower_triangular_mut(&mut right);
        let alone = DVector::zeros(0);
        let mut this = Self { scale, lower, right, alone };
        this.alone = this.back(this.right.clone());
        this
    }

    /// Corrections of what went through the factor.
    fn back(&self, mut through: DVector<f64>) -> DVector<f64> {
        self.lower.tr_solve_lower_triangular_mut(&mut through);
        through.component_mul_assign(&self.scale);
        through
    }

    /// Products with the inertial columns, scaled and through the factor: all that fits need of them.
    fn through_factor(&self, mut products: DVector<f64>) -> DVector<f64> {
        products.component_mul_assign(&self.scale);
        self.lower.solve_lower_triangular_mut(&mut products);
        products
    }
}

/// A term's products with all else, formed once for all fits with the same weights.
pub(crate) struct TermProducts {
    /// By row that the term touches, ascending.
    rows: Vec<RowProducts>,
    /// With the inertial columns, see [`Corrections::through_factor`]; empty without corrections.
    inertial: DVector<f64>,
    /// What one of it takes from the corrections; empty without them.
    response: DVector<f64>,
}

struct RowProducts {
    row: usize,
    /// The term in the coordinates of the row: places and factors.
    local: Vec<(usize, f64)>,
    /// Weighted, with everything in the row.
    products: DVector<f64>,
}

impl TermProducts {
    pub fn new(
        train: &NormalEquations,
        weights: &[f64],
        corrections: Option<&Corrections>,
        term: &Term,
    ) -> Self {
        let mut rows = Vec::new();
        let mut inertial = DVector::zeros(corrections.map_or(0, |c| c.right.len()));
        for (index, (row, w)) in train.rows.iter().zip(weights).enumerate() {
            let Some(local) = row.local(term) else { continue };
            let products = row.product(term, &local) * *w;
            if !inertial.is_empty() {
                for (place, body) in row.bodies.iter().enumerate() {
                    for i in 0..10 {
                        inertial[parameter_index(*body, i)] += products[parameter_index(place, i)];
                    }
                }
            }
            let local = local.iter().copied().enumerate().filter(|(_, x)| *x != 0.0).collect();
            rows.push(RowProducts { row: index, local, products });
        }
        let nothing = || DVector::zeros(0);
        let inertial = corrections.map_or_else(nothing, |c| c.through_factor(inertial));
        let response = corrections.map_or_else(nothing, |c| c.back(inertial.clone()));
        Self { rows, inertial, response }
    }

    /// With another term.
    pub fn with(&self, other: &Self) -> f64 {
        // Both lists ascend.
        let (mut own, mut sum) = (self.rows.iter().peekable(), 0.0);
        for o in &other.rows {
            while own.next_if(|row| row.row < o.row).is_some() {}
            if let Some(row) = own.next_if(|row| row.row == o.row) {
                sum += o.local.iter().map(|(place, x)| row.products[*place] * x).sum::<f64>();
            }
        }
        sum
    }

    /// With the residual, the last of everything in a row.
    fn residual(&self) -> f64 {
        self.rows.iter().map(|row| row.products[row.products.len() - 1]).sum()
    }
}

/// The result of a fit.
#[derive(Debug, Clone)]
pub(crate) struct Fit {
    /// Inertial corrections as multiples of the spread; empty if there are none.
    pub corrections: Vec<f64>,
    /// One coefficient per term.
    pub coefficients: Vec<f64>,
    /// Half the log of the posterior odds of the corrections: their sum of squares.
    pub prior: f64,
}

/// Least squares of the terms, with the inertial corrections if there are any (the same with which the products were formed).
///
/// `None` if the data cannot tell the terms apart.
pub(crate) fn fit(corrections: Option<&Corrections>, terms: &[&TermProducts]) -> Option<Fit> {
    let k = terms.len();
    let mut own = DMatrix::zeros(k, k);
    for c in 0..k {
        for r in c..k {
            own[(r, c)] = terms[r].with(terms[c]);
            own[(c, r)] = own[(r, c)];
        }
    }
    let right = DVector::from_fn(k, |r, _| terms[r].residual());
    let (corrections, coefficients) = solve(corrections, own, &right, terms)?;
    let prior = corrections.iter().map(|x| x * x).sum();
    Some(Fit { corrections, coefficients, prior })
}

/// Scaled Cholesky, the corrections' part of which is known; terms of which less than a millionth is their own are
/// refused. Gives corrections and coefficients.
fn solve(
    corrections: Option<&Corrections>,
    mut own: DMatrix<f64>,
    right: &DVector<f64>,
    terms: &[&TermProducts],
) -> Option<(Vec<f64>, Vec<f64>)> {
    let k = right.len();
    // Columns that change nothing, such as a shift out of the plane of a planar robot, get the coefficient 0.
    let largest = (0..k).map(|i| own[(i, i)]).fold(0.0, f64::max);
    let mut right = right.clone();
    let idle: Vec<bool> = (0..k).map(|i| own[(i, i)] <= 1e-16 * largest).collect();
    for i in (0..k).filter(|&i| idle[i]) {
        own.row_mut(i).fill(0.0);
        own.column_mut(i).fill(0.0);
        (own[(i, i)], right[i]) = (largest, 0.0);
    }
    let scale = DVector::from_fn(k, |i, _| own[(i, i)].sqrt().recip());
    if scale.iter().any(|s| !s.is_finite()) {
        return None;
    }
    for c in 0..k {
        for r in 0..k {
            own[(r, c)] *= scale[r] * scale[c];
        }
    }
    let mut right = right.component_mul(&scale);
    let unless_idle = |c: usize| if idle[c] { 0.0 } else { scale[c] };
    let p = corrections.map_or(0, |known| known.right.len());
    let cross = DMatrix::from_fn(p, k, |r, c| terms[c].inertial[r] * unless_idle(c));
    if let Some(known) = corrections.filter(|_| k > 0) {
        own.gemm_tr(-1.0, &cross, &cross, 1.0);
        right.gemv_tr(-1.0, &cross, &known.right, 1.0);
    }
    let cholesky = own.cholesky()?;
    if (0..k).any(|i| cholesky.l_dirty()[(i, i)] < 1e-4) {
        return None;
    }
    let coefficients = cholesky.solve(&right).component_mul(&scale);
    let mut inertial = corrections.map_or_else(|| DVector::zeros(0), |known| known.alone.clone());
    for (term, coefficient) in terms.iter().zip(&coefficients).filter(|_| p > 0) {
        inertial.axpy(-coefficient, &term.response, 1.0);
    }
    let all = |values: &DVector<f64>| values.iter().copied().collect::<Vec<f64>>();
    inertial.iter().all(|x| x.is_finite()).then(|| (all(&inertial), all(&coefficients)))
}

/// Sums of squared errors of a fit, by row.
pub(crate) fn errors<'r>(rows: impl Iterator<Item = RowGram<'r>>, fit: &Fit, terms: &[&Term]) -> Vec<f64> {
    let terms: Vec<(&Term, f64)> = terms.iter().copied().zip(fit.coefficients.iter().copied()).collect();
    rows.map(|row| row.error(&fit.corrections, &terms)).collect()
}

/// Sums of squares of what some terms with these coefficients make, by row.
pub(crate) fn sizes(sums: &NormalEquations, terms: &[Term], coefficients: &[f64]) -> Vec<f64> {
    let terms: Vec<(&Term, f64)> = terms.iter().zip(coefficients.iter().copied()).collect();
    sums.grams().map(|row| row.square(&row.combined(&[], &terms))).collect()
}
