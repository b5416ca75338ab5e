//! Least squares from triangles: estimates, error bars, what cannot be seen, and errors on data that did not teach.
use super::accumulate::Sums;
use super::design::Design;
pub use super::held_out::HeldOutError;
use super::triangle::Triangle;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// A direction shorter than this, with columns scaled to length 1, is not seen.
const UNSEEN: f64 = 1e-7;

/// Noise is at least this part of what was measured.
const EXACT: f64 = 1e-9;
/// Channels with fewer rows per unknown than this share the unknowns' cost.
const SCARCE: usize = 5;

/// How residuals count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Method {
    /// All alike.
    Ordinary,
    /// Each channel by its own noise.
    #[default]
    Weighted,
    /// As `Weighted`, and large residuals less (Huber).
    Huber,
    /// As `Weighted`, with instruments that do not share the regressors' noise.
    Instrumental,
}

/// The weighted regression, cut into cells.
#[derive(Debug, Clone, PartialEq)]
pub struct Estimate {
    /// Per cell the triangle over all unknowns.
    pub cells: Vec<Triangle>,
    /// Standard deviation by which each channel's rows were divided.
    pub noise: Vec<f64>,
    /// All cells together.
    pub total: Triangle,
    /// Unknowns that the data can tell; the others are held.
    pub seen: Vec<usize>,
    /// Values at which unseen unknowns are held.
    pub held: DVector<f64>,
}

/// An estimate with its errors.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// All unknowns; those that are not seen have the values at which they were held.
    pub theta: DVector<f64>,
    /// Covariance from leaving out one stretch of motion after the other: it needs no assumption about how long errors
    /// last within a stretch. Rows and columns of unseen unknowns are zero.
    pub covariance: DMatrix<f64>,
    /// Covariance as if all residuals were independent (8.2, 8.3).
    pub white: DMatrix<f64>,
    /// Standard deviation of each channel's residual, N m or N.
    pub residual: Vec<f64>,
    /// By how much noise of the regressors moves the estimate, as far as that is known: `covariance` has it too.
    pub moved: DVector<f64>,
    /// Unknowns whose estimates rest on that noise: they have no number.
    pub untold: Vec<usize>,
}

/// One triangle per channel, of all cells for which `keep` says so.
pub fn by_channel(sums: &Sums, design: &Design<'_>, keep: &dyn Fn(usize) -> bool) -> Vec<Triangle> {
    let of = |(index, channel): (usize, &super::design::Channel)| {
        let mut all = Triangle::new(channel.places.len());
        for (_, cell) in sums.cells.iter().enumerate().filter(|(k, cell)| keep(*k) && cell[index].rows() > 0)
        {
            all.add(&cell[index]);
        }
        all
    };
    design.channels.iter().enumerate().map(of).collect()
}

/// Errors of `theta` in the channels of such triangles.
pub fn errors(channels: &[Triangle], design: &Design<'_>, theta: &DVector<f64>) -> Vec<HeldOutError> {
    let error = |(triangle, channel): (&Triangle, &super::design::Channel)| {
        let own = DVector::from_iterator(channel.places.len(), channel.places.iter().map(|&p| theta[p]));
        HeldOutError {
            squares: triangle.squares(&own),
            measured: triangle.right_squares(),
            rows: triangle.rows(),
        }
    };
    channels.iter().zip(&design.channels).map(error).collect()
}

impl Estimate {
    /// Divides rows by `noise` and looks at what can be seen.
    pub fn new(design: &Design<'_>, sums: &Sums, noise: &[f64], held: DVector<f64>) -> Self {
        let weighted = |cell: &Vec<Triangle>| {
            let mut all = Triangle::new(design.unknowns.len());
            for ((triangle, channel), noise) in cell.iter().zip(&design.channels).zip(noise) {
                if triangle.rows() > 0 {
                    all.merge(triangle, &channel.places, 1.0 / noise);
                }
            }
            all
        };
        let cells: Vec<Triangle> = sums.cells.iter().map(weighted).collect();
        let total = joined(design.unknowns.len(), &cells);
        let seen = independent(&total);
        Self { cells, noise: noise.to_vec(), total, seen, held }
    }

    /// Ordinary least squares first, then each channel by the noise found in it.
    pub fn weighted(design: &Design<'_>, sums: &Sums, held: DVector<f64>, method: Method) -> Self {
        let mut estimate = Self::new(design, sums, &vec![1.0; design.channels.len()], held);
        if method == Method::Ordinary {
            return estimate;
        }
        let channels = by_channel(sums, design, &|_| true);
        for _ in 0..4 {
            let theta = estimate.solve(&estimate.total, &estimate.seen);
            let noise = residuals(&channels, design, &theta);
            // Exact data have no noise; a floor far below anything measured keeps weights finite, and the semidefinite
            // program solvable.
            let floor = 1e-12 * noise.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE.sqrt());
            let exact =
                |channel: &Triangle| EXACT * (channel.right_squares() / channel.rows().max(1) as f64).sqrt();
            let floors = channels.iter().map(|channel| floor.max(exact(channel)));
            let noise: Vec<f64> = noise.iter().zip(floors).map(|(x, floor)| x.max(floor)).collect();
            let held = std::mem::take(&mut estimate.held);
            estimate = Self::new(design, sums, &noise, held);
        }
        estimate
    }

    /// The same with unseen unknowns held elsewhere.
    pub fn with_held(self, held: DVector<f64>) -> Self {
        Self { held, ..self }
    }

    /// The unknowns `free` from a triangle, all others held.
    pub fn solve(&self, triangle: &Triangle, free: &[usize]) -> DVector<f64> {
        let (factor, lengths) = (triangle.matrix(), triangle.lengths());
        let mut theta = self.held.clone();
        free.iter().for_each(|&k| theta[k] = 0.0);
        let target = triangle.right() - &factor * &theta;
        let scale: Vec<f64> = free.iter().map(|&k| lengths[k].max(f64::MIN_POSITIVE)).collect();
        let mut columns = factor.select_columns(free);
        columns.column_iter_mut().zip(&scale).for_each(|(mut c, s)| c /= *s);
        let qr = columns.qr();
        let mut right = target;
        qr.q_tr_mul(&mut right);
        let r = qr.r();
        let mut solution = right.rows(0, free.len()).into_owned();
        if !r.solve_upper_triangular_mut(&mut solution) {
            // A direction that this triangle does not have: the shortest solution.
            let shortest = r.svd(true, true).solve(&right.rows(0, free.len()), UNSEEN);
            solution = shortest.unwrap_or_else(|_| DVector::zeros(free.len()));
        }
        for ((&k, value), scale) in free.iter().zip(solution.iter()).zip(&scale) {
            theta[k] = value / scale;
        }
        theta
    }

    /// The estimate from all cells, with errors; `sums` are those it was made of.
    pub fn fit(&self, design: &Design<'_>, sums: &Sums) -> Fit {
        self.fit_of(design, sums, &self.seen)
    }

    /// The same with `free` unknowns only.
    pub fn fit_of(&self, design: &Design<'_>, sums: &Sums, free: &[usize]) -> Fit {
        let theta = self.solve(&self.total, free);
        let channels = by_channel(sums, design, &|_| true);
        let rows: usize = channels.iter().map(Triangle::rows).sum();
        let freedom = rows.saturating_sub(free.len()).max(1) as f64;
        let variance = self.total.squares(&theta) / freedom;
        let white = self.spread(&self.inverse(free) * variance, free);
        let covariance = self.spread(self.jackknife(free), free);
        let moved = DVector::zeros(theta.len());
        Fit {
            residual: residuals(&channels, design, &theta),
            theta,
            covariance,
            white,
            moved,
            untold: Vec::new(),
        }
    }

    /// `(Wᵀ W)⁻¹` of these unknowns.
    pub fn inverse(&self, free: &[usize]) -> DMatrix<f64> {
        let lengths = self.total.lengths();
        let mut columns = self.total.matrix().select_columns(free);
        let scale: Vec<f64> = free.iter().map(|&k| lengths[k].max(f64::MIN_POSITIVE)).collect();
        columns.column_iter_mut().zip(&scale).for_each(|(mut c, s)| c /= *s);
        let r = columns.qr().r();
        let inverse = r.solve_upper_triangular(&DMatrix::identity(free.len(), free.len()));
        let inverse = inverse.unwrap_or_else(|| DMatrix::from_element(free.len(), free.len(), f64::INFINITY));
        let mut full = &inverse * inverse.transpose();
        for i in 0..free.len() {
            for j in 0..free.len() {
                full[(i, j)] /= scale[i] * scale[j];
            }
        }
        full
    }

    /// Covariance by leaving out one cell after the other (the estimator CR3 of cluster-robust covariance): errors may
    /// be correlated within a cell in any way, between channels too, and leverage is accounted for.
    fn jackknife(&self, free: &[usize]) -> DMatrix<f64> {
        let width = self.total.columns();
        let used: Vec<&Triangle> = self.cells.iter().filter(|cell| cell.rows() > 0).collect();
        let count = used.len();
        let mut after = vec![Triangle::new(width); count + 1];
        for k in (0..count).rev() {
            after[k] = after[k + 1].clone();
            after[k].add(used[k]);
        }
        let mut before = Triangle::new(width);
        let mut thetas: Vec<DVector<f64>> = Vec::with_capacity(count);
        for k in 0..count {
            let mut rest = before.clone();
            rest.add(&after[k + 1]);
            let theta = self.solve(&rest, free);
            thetas.push(DVector::from_iterator(free.len(), free.iter().map(|&i| theta[i])));
            before.add(used[k]);
        }
        let mut covariance = DMatrix::zeros(free.len(), free.len());
        if count < 2 {
            covariance.fill(f64::INFINITY);
            return covariance;
        }
        let mean = thetas.iter().sum::<DVector<f64>>() / count as f64;
        for theta in &thetas {
            let away = theta - &mean;
            covariance += &away * away.transpose();
        }
        covariance * ((count - 1) as f64 / count as f64)
    }

    fn spread(&self, small: DMatrix<f64>, free: &[usize]) -> DMatrix<f64> {
        let n = self.total.columns();
        let mut full = DMatrix::zeros(n, n);
        for (i, &a) in free.iter().enumerate() {
            for (j, &b) in free.iter().enumerate() {
                full[(a, b)] = small[(i, j)];
            }
        }
        full
    }

    /// Errors per channel on the cells of each fold, of the estimate from all others, weighted as this one.
    pub fn held_out(
        &self,
        design: &Design<'_>,
        sums: &Sums,
        folds: &[usize],
        solve: &dyn Fn(&Triangle) -> DVector<f64>,
    ) -> Vec<Vec<HeldOutError>> {
        let last = folds.iter().copied().max().unwrap_or(0);
        (0..=last)
            .map(|fold| {
                let others: Vec<Triangle> = self
                    .cells
                    .iter()
                    .zip(folds)
                    .filter(|(cell, of)| **of != fold && cell.rows() > 0)
                    .map(|(cell, _)| cell.clone())
                    .collect();
                let theta = solve(&joined(self.total.columns(), &others));
                errors(&by_channel(sums, design, &|cell| folds[cell] == fold), design, &theta)
            })
            .collect()
    }

    /// Singular values of the weighted regression with columns scaled to length 1, descending; of the seen unknowns.
    pub fn singular_values(&self) -> Vec<f64> {
        let lengths = self.total.lengths();
        let mut columns = self.total.matrix().select_columns(&self.seen);
        for (mut column, &k) in columns.column_iter_mut().zip(&self.seen) {
            column /= lengths[k].max(f64::MIN_POSITIVE);
        }
        columns.singular_values().iter().copied().collect()
    }
}

impl Fit {
    /// Standard errors: the larger of both covariances', because left-out stretches are few.
    pub fn standard_errors(&self) -> DVector<f64> {
        DVector::from_fn(self.theta.len(), |k, _| {
            self.covariance[(k, k)].max(self.white[(k, k)]).max(0.0).sqrt()
        })
    }

    /// Error bars that reach as far as noise of the regressors moves the estimate.
    pub fn widen(&mut self, moved: DVector<f64>, untold: Vec<usize>) {
        self.covariance += &moved * moved.transpose();
        (self.moved, self.untold) = (moved, untold);
    }

    /// Correlations of estimates (8.4) by the regression's own covariance.
    pub fn correlation(&self, i: usize, j: usize) -> f64 {
        let size = (self.white[(i, i)] * self.white[(j, j)]).sqrt();
        if size > 0.0 { self.white[(i, j)] / size } else { 0.0 }
    }
}

/// Standard deviations of the channels' residuals.
fn residuals(channels: &[Triangle], design: &Design<'_>, theta: &DVector<f64>) -> Vec<f64> {
    let errors = errors(channels, design, theta);
    let all: usize = errors.iter().map(|held| held.rows).sum();
    let freedom = |held: &HeldOutError, places: usize| {
        // Channels with few rows share their unknowns with the others: each pays for its part of them.
        let shared = (design.unknowns.len() * held.rows).div_ceil(all.max(1));
        let paid = if held.rows < SCARCE * places { places.min(shared) } else { places };
        held.rows.saturating_sub(paid).max(1) as f64
    };
    errors
        .iter()
        .zip(&design.channels)
        .map(|(held, channel)| (held.squares / freedom(held, channel.places.len())).sqrt())
        .collect()
}

/// Mean squared error over all rows, each channel in units of its noise.
pub fn normalised(errors: &[HeldOutError], noise: &[f64]) -> f64 {
    let squares: f64 = errors.iter().zip(noise).map(|(e, noise)| e.squares / (noise * noise)).sum();
    squares / errors.iter().map(|e| e.rows).sum::<usize>().max(1) as f64
}

/// Arithmetic mean.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Errors of several candidates on the same folds: by how much each is above the best on average, and the standard error
/// of that difference. Folds are hard or easy for all candidates alike, so differences tell more than errors.
pub fn compared(errors: &[Vec<f64>]) -> Vec<[f64; 2]> {
    let best = errors.iter().min_by(|a, b| mean(a).total_cmp(&mean(b)));
    let Some(best) = best else { return Vec::new() };
    let against = |own: &Vec<f64>| {
        let differences: Vec<f64> = own.iter().zip(best).map(|(a, b)| a - b).collect();
        let (n, centre) = (differences.len() as f64, mean(&differences));
        let variance = differences.iter().map(|d| (d - centre).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        [centre, (variance / n.max(1.0)).sqrt()]
    };
    errors.iter().map(against).collect()
}

/// Triangles over the same unknowns, together.
pub fn joined(columns: usize, parts: &[Triangle]) -> Triangle {
    let mut all = Triangle::new(columns);
    parts.iter().filter(|part| part.rows() > 0).for_each(|part| all.add(part));
    all
}

/// Columns that are no sums of others, the longest remainders first; in ascending order.
pub(super) fn independent(total: &Triangle) -> Vec<usize> {
    let lengths = total.lengths();
    let longest = lengths.max();
    let mut columns = total.matrix();
    let mut left: Vec<usize> = (0..columns.ncols()).filter(|&k| lengths[k] > 1e-14 * longest).collect();
    for &k in &left {
        let mut column = columns.column_mut(k);
        column /= lengths[k];
    }
    let mut chosen = Vec::new();
    loop {
        // Among equals the first, so that names lead as they are listed.
        let length = |k: usize| columns.column(k).norm();
        let best = left.iter().copied().fold(None, |best: Option<(usize, f64)>, k| match best {
            Some((_, most)) if length(k) <= most * (1.0 + 1e-9) => best,
            _ => Some((k, length(k))),
        });
        let Some((k, _)) = best.filter(|(_, length)| *length > UNSEEN) else { break };
        chosen.push(k);
        left.retain(|&other| other != k);
        let direction = columns.column(k).normalize();
        for &other in &left {
            let part = direction.dot(&columns.column(other));
            columns.column_mut(other).axpy(-part, &direction, 1.0);
        }
    }
    chosen.sort_unstable();
    chosen
}
