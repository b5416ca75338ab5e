//! The smallest angle between what two effects do to torques, and its derivatives.
use nalgebra::{DMatrix, DVector};

/// Directions of this part of the largest are none.
const NOTHING: f64 = 1e-9;

/// How many columns a matrix has of the first effect, of the second, of what stands beside both; two more follow: what
/// the two effects do at their usual values.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    pub effects: [usize; 2],
    pub beside: usize,
    /// Largest canonical correlations that are 1 along every motion and do not count.
    pub common: usize,
}

/// Two spaces beside a third, seen from each other.
pub(super) struct View {
    /// Orthonormal columns of the third.
    third: Space,
    spaces: [Space; 2],
    /// Canonical correlations, largest first.
    pub correlations: Vec<f64>,
    /// Canonical directions in terms of the spaces' bases.
    left: DMatrix<f64>,
    right: DMatrix<f64>,
}

/// A space spanned by columns: an orthonormal basis `U`, and `X` with `columns · X = U`.
struct Space {
    basis: DMatrix<f64>,
    inverse: DMatrix<f64>,
}

impl Space {
    /// Directions that remain of the columns after `third` is taken away; none of `sizes`' rounding.
    fn new(columns: DMatrix<f64>, sizes: &[f64]) -> Self {
        let mut scaled = columns;
        let factors: Vec<f64> = sizes.iter().map(|size| if *size > 0.0 { 1.0 / size } else { 0.0 }).collect();
        scaled.column_iter_mut().zip(&factors).for_each(|(mut column, factor)| column *= *factor);
        let (rows, width) = scaled.shape();
        let none = Self { basis: DMatrix::zeros(rows, 0), inverse: DMatrix::zeros(width, 0) };
        if scaled.is_empty() || scaled.iter().any(|x| !x.is_finite()) {
            return none;
        }
        let Some(svd) = scaled.try_svd(true, true, f64::EPSILON, 10_000) else { return none };
        let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return none };
        let kept: Vec<usize> =
            (0..svd.singular_values.len()).filter(|&k| svd.singular_values[k] > NOTHING).collect();
        let basis = u.select_columns(&kept);
        let inverse = DMatrix::from_fn(width, kept.len(), |i, k| {
            factors[i] * v_t[(kept[k], i)] / svd.singular_values[kept[k]]
        });
        Self { basis, inverse }
    }

    fn without(&self, columns: &DMatrix<f64>) -> DMatrix<f64> {
        let mut left = columns.clone();
        // Twice is enough (Parlett).
        for _ in 0..2 {
            left -= &self.basis * self.basis.tr_mul(&left);
        }
        left
    }
}

/// Lengths of columns.
pub(super) fn lengths(columns: &DMatrix<f64>) -> Vec<f64> {
    columns.column_iter().map(|column| column.norm()).collect()
}

/// Combinations of columns that are independent of each other and of `beside`, at least `least` of their own length.
///
/// Columns times the answer are such combinations.
pub(super) fn independent(columns: &DMatrix<f64>, beside: &DMatrix<f64>, least: f64) -> DMatrix<f64> {
    let third = Space::new(beside.clone(), &lengths(beside));
    let sizes = lengths(columns);
    let factors: Vec<f64> = sizes.iter().map(|size| if *size > 0.0 { 1.0 / size } else { 0.0 }).collect();
    let mut scaled = third.without(columns);
    scaled.column_iter_mut().zip(&factors).for_each(|(mut column, factor)| column *= *factor);
    if scaled.is_empty() || scaled.iter().any(|x| !x.is_finite()) {
        return DMatrix::zeros(columns.ncols(), 0);
    }
    let Some(svd) = scaled.try_svd(false, true, f64::EPSILON, 10_000) else {
        return DMatrix::zeros(columns.ncols(), 0);
    };
    let Some(v_t) = svd.v_t else { return DMatrix::zeros(columns.ncols(), 0) };
    let kept: Vec<usize> =
        (0..svd.singular_values.len()).filter(|&k| svd.singular_values[k] > least).collect();
    DMatrix::from_fn(columns.ncols(), kept.len(), |i, k| factors[i] * v_t[(kept[k], i)])
}

impl View {
    /// Of a matrix with columns as the layout says; `None` if one of the two does nothing.
    pub fn new(matrix: &DMatrix<f64>, layout: Layout) -> Option<Self> {
        let [first, second] = layout.effects;
        let beside = matrix.columns(first + second, layout.beside).into_owned();
        let third = Space::new(beside.clone(), &lengths(&beside));
        let space = |from: usize, width: usize| {
            let columns = matrix.columns(from, width).into_owned();
            Space::new(third.without(&columns), &lengths(&columns))
        };
        let spaces = [space(0, first), space(first, second)];
        if spaces.iter().any(|space| space.basis.ncols() == 0) {
            return None;
        }
        let svd = spaces[0].basis.tr_mul(&spaces[1].basis).try_svd(true, true, f64::EPSILON, 10_000)?;
        let correlations = svd.singular_values.iter().copied().collect();
        Some(Self { third, spaces, correlations, left: svd.u?, right: svd.v_t?.transpose() })
    }

    /// The k-th pair of unit vectors, and sine of the angle between them.
    pub fn pair(&self, k: usize) -> Option<(DVector<f64>, DVector<f64>, f64)> {
        (k < self.correlations.len()).then(|| {
            let a = &self.spaces[0].basis * self.left.column(k);
            let b = &self.spaces[1].basis * self.right.column(k);
            let sine = (&a - &b * self.correlations[k]).norm();
            (a, b, sine)
        })
    }

    /// What remains of a column once the third space and one of the two are taken away.
    pub fn rest(&self, column: &DVector<f64>, other: usize) -> DVector<f64> {
        let left = self.third.without(&DMatrix::from_column_slice(column.len(), 1, column.as_slice()));
        self.spaces[other].without(&left).column(0).into_owned()
    }

    /// Minus the logarithm of the sine of the k-th angle, and its derivatives by every element of the matrix.
    ///
    /// With a = M(Aα − Cγ) and b likewise the unit vectors, M the projection beside C, and ρ = aᵀb the correlation is
    /// stationary in α, β and γ, so that dρ = (dA α − dC γ)ᵀ(b − ρ a) + (dB β − dC δ)ᵀ(a − ρ b).
    pub fn slopes(&self, matrix: &DMatrix<f64>, layout: Layout) -> Option<(f64, DMatrix<f64>)> {
        let k = layout.common;
        let (a, b, sine) = self.pair(k)?;
        if sine.is_nan() || sine < 1e-12 {
            return None;
        }
        let rho = self.correlations[k];
        let [alpha, beta] = [(0, &self.left), (1, &self.right)]
            .map(|(which, directions)| &self.spaces[which].inverse * directions.column(k));
        let [first, second] = layout.effects;
        let gamma = |from: usize, width: usize, alpha: &DVector<f64>| {
            &self.third.inverse * self.third.basis.tr_mul(&(matrix.columns(from, width) * alpha))
        };
        let (gamma_a, gamma_b) = (gamma(0, first, &alpha), gamma(first, second, &beta));
        // d(−ln sin θ) = ρ/sin² θ dρ.
        let factor = rho / (sine * sine);
        let (to_a, to_b) = ((&b - &a * rho) * factor, (&a - &b * rho) * factor);
        let mut slopes = DMatrix::zeros(matrix.nrows(), matrix.ncols());
        slopes.columns_mut(0, first).ger(1.0, &to_a, &alpha, 0.0);
        slopes.columns_mut(first, second).ger(1.0, &to_b, &beta, 0.0);
        if layout.beside > 0 {
            let mut beside = slopes.columns_mut(first + second, layout.beside);
            beside.ger(-1.0, &to_a, &gamma_a, 0.0);
            beside.ger(-1.0, &to_b, &gamma_b, 1.0);
        }
        Some((-sine.ln(), slopes))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: usize, columns: usize) -> DMatrix<f64> {
        let mut seed = 7_u64;
        DMatrix::from_fn(rows, columns, |_, _| {
            seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (seed >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
    }

    /// Of two planes in space that share an axis: by hand.
    #[test]
    fn planes_have_the_angles_that_were_drawn() {
        let angle = 0.3_f64;
        let all = DMatrix::from_row_slice(
            4,
            4,
            &[1.0, 1.0, 2.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0, 3.0, 0.0, angle.cos() * 2.0, 0.0, 0.0, 0.0, 0.0],
        );
        // Second: 2 e₁, and e₁ + e₂ + 2 cos e₃; first: e₁ + e₂, and e₁ + 3 e₃: all in one space of three.
        let layout = Layout { effects: [2, 2], beside: 0, common: 0 };
        let view = View::new(&all, layout).unwrap();
        assert!((view.correlations[0] - 1.0).abs() < 1e-14, "planes of one space share a line");
        // Normals: (−3, 3, 1) of the first plane, (0, 2 cos, −1) of the second.
        let c = 2.0 * angle.cos();
        let expected = (3.0 * c - 1.0).abs() / (19.0_f64.sqrt() * (c * c + 1.0).sqrt());
        assert!((view.correlations[1] - expected).abs() < 1e-14);
    }

    /// The multiple correlation coefficient of a regression is the canonical correlation of one column with many.
    #[test]
    fn one_column_beside_others_is_a_partial_regression() {
        let all = matrix(30, 6);
        let layout = Layout { effects: [1, 3], beside: 2, common: 0 };
        let residual = |y: DVector<f64>, x: DMatrix<f64>| {
            let normal = (x.transpose() * &x).cholesky().unwrap();
            &y - &x * normal.solve(&(x.transpose() * &y))
        };
        let y = all.column(0).into_owned();
        let beside = residual(y.clone(), all.columns(4, 2).into_owned());
        let rest = residual(y, all.columns(1, 5).into_owned());
        let expected = (1.0 - rest.norm_squared() / beside.norm_squared()).sqrt();
        let view = View::new(&all, layout).unwrap();
        assert!((view.correlations[0] - expected).abs() < 1e-13);
        assert!((view.rest(&all.column(0).into_owned(), 1) - rest).norm() < 1e-12);
    }

    #[test]
    fn slopes_are_those_of_the_logarithm() {
        let all = matrix(20, 9);
        for common in [0, 1] {
            let layout = Layout { effects: [2, 3], beside: 2, common };
            let of = |all: &DMatrix<f64>| View::new(all, layout).unwrap().slopes(all, layout).unwrap();
            let (_, slopes) = of(&all);
            let scale = slopes.amax();
            for at in 0..all.len() {
                let moved = |h: f64| {
                    let mut other = all.clone();
                    other[at] += h;
                    of(&other).0
                };
                let expected = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!((slopes[at] - expected).abs() < 1e-7 * scale, "{at}: {} {expected}", slopes[at]);
            }
        }
    }

    #[test]
    fn dependent_columns_are_dropped() {
        let mut all = matrix(20, 5);
        let sum = all.column(0) + all.column(1) * 1e3;
        all.set_column(2, &sum);
        let none = DMatrix::zeros(20, 0);
        assert_eq!(independent(&all.columns(0, 3).into_owned(), &none, 1e-7).ncols(), 2);
        let beside = all.columns(1, 4).into_owned();
        assert_eq!(independent(&none, &beside, 1e-7).shape(), (0, 0));
        assert_eq!(independent(&all.columns(0, 1).into_owned(), &beside, 1e-7).ncols(), 0);
        all.fill(0.0);
        assert_eq!(independent(&all, &none, 1e-7).ncols(), 0);
        assert!(View::new(&all, Layout { effects: [1, 1], beside: 1, common: 0 }).is_none());
    }
}
