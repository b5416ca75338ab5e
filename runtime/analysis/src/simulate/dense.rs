//! Small dense factorisations on slices that the caller keeps: nalgebra's allocate for sizes known at run time only.

/// A function compiled twice: as it is, and for processors with 256 bit registers, which are asked for at run time. Both
/// do the same operations in the same order.
macro_rules! wide {
    ($(#[$meta:meta])* fn $name:ident($($argument:ident: $type:ty),*) $(-> $result:ty)? $body:block) => {
        $(#[$meta])*
        pub(super) fn $name($($argument: $type),*) $(-> $result)? {
            #[inline(always)]
            fn plain($($argument: $type),*) $(-> $result)? $body

            #[cfg(target_arch = "x86_64")]
            {
                #[target_feature(enable = "avx2")]
                fn wide($($argument: $type),*) $(-> $result)? {
                    plain($($argument),*)
                }
                if std::arch::is_x86_feature_detected!("avx2") {
                    // SAFETY: the processor has what the function is compiled for.
                    return unsafe { wide($($argument),*) };
                }
            }
            plain($($argument),*)
        }
    };
}

/// A stretch of columns outside of which a row is zero.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Stretch {
    pub begin: usize,
    pub end: usize,
}

impl Stretch {
    /// Of the numbers that are not zero.
    pub fn of(row: &[f64]) -> Self {
        let begin = row.iter().position(|x| *x != 0.0).unwrap_or(row.len());
        let end = row.iter().rposition(|x| *x != 0.0).map_or(begin, |last| last + 1);
        Self { begin, end }
    }

    /// The smallest that holds both.
    fn with(self, other: Self) -> Self {
        if self.begin >= self.end {
            return other;
        }
        if other.begin >= other.end {
            return self;
        }
        Self { begin: self.begin.min(other.begin), end: self.end.max(other.end) }
    }
}

wide! {
    /// Turns the lower triangle of `a` (`n × n`, row after row) into L with `a = Lᵀ L`, with reciprocals on the diagonal.
    /// `false`: the matrix is not positive definite; `a` is of no use then.
    ///
    /// From the last row on: limbs come before what carries them, and what is zero between them stays zero and is passed
    /// over (Featherstone, 2005).
    fn factor(a: &mut [f64], n: usize) -> bool {
        for k in (0..n).rev() {
            let (above, row) = a.split_at_mut(k * n);
            let rest = row[k];
            // Written so that NaN fails too.
            if !(rest > 0.0 && rest.is_finite()) {
                return false;
            }
            let reciprocal = rest.sqrt().recip();
            row[..k].iter_mut().for_each(|x| *x *= reciprocal);
            row[k] = reciprocal;
            for (i, target) in above.chunks_exact_mut(n).enumerate() {
                let factor = row[i];
                if factor != 0.0 {
                    target[..=i].iter_mut().zip(&row[..=i]).for_each(|(x, y)| *x -= factor * y);
                }
            }
        }
        true
    }
}

wide! {
    /// `Lᵀ Y = B` in place, `B` with `columns` columns, row after row; `stretches` are those of its rows, then of Y's.
    fn forward(l: &[f64], n: usize, b: &mut [f64], columns: usize, stretches: &mut [Stretch]) {
        for k in (0..n).rev() {
            let (above, row) = b.split_at_mut(k * columns);
            let own = stretches[k];
            let Some(row) = row.get_mut(own.begin..own.end) else { continue };
            let reciprocal = l[k * n + k];
            row.iter_mut().for_each(|x| *x *= reciprocal);
            for (i, target) in above.chunks_exact_mut(columns).enumerate() {
                let factor = l[k * n + i];
                if factor != 0.0 {
                    stretches[i] = stretches[i].with(own);
                    target[own.begin..own.end].iter_mut().zip(&*row).for_each(|(x, y)| *x -= factor * y);
                }
            }
        }
    }
}

/// `Lᵀ y = b` in place.
pub(super) fn forward_one(l: &[f64], n: usize, b: &mut [f64]) {
    for k in (0..n).rev() {
        let y = b[k] * l[k * n + k];
        b[k] = y;
        let row = &l[k * n..k * n + k];
        b[..k].iter_mut().zip(row).for_each(|(x, factor)| *x -= factor * y);
    }
}

/// `L x = b` in place.
pub(super) fn backward(l: &[f64], n: usize, b: &mut [f64]) {
    for i in 0..n {
        b[i] = (b[i] - dot(&l[i * n..i * n + i], &b[..i])) * l[i * n + i];
    }
}

wide! {
    /// `Yᵀ Y`; `Y` has `columns` columns, row after row.
    fn gram(y: &[f64], columns: usize, stretches: &[Stretch], g: &mut [f64]) {
        g.fill(0.0);
        for (row, stretch) in y.chunks_exact(columns).zip(stretches) {
            for i in stretch.begin..stretch.end {
                let factor = row[i];
                let own = &row[stretch.begin..=i];
                let target = &mut g[i * columns + stretch.begin..=i * columns + i];
                target.iter_mut().zip(own).for_each(|(x, y)| *x += factor * y);
            }
        }
        for i in 0..columns {
            for j in 0..i {
                g[j * columns + i] = g[i * columns + j];
            }
        }
    }
}

wide! {
    /// `out = start + G x` with a symmetric `G`.
    fn multiply(g: &[f64], x: &[f64], start: &[f64], out: &mut [f64]) {
        out.copy_from_slice(start);
        for (row, &factor) in g.chunks_exact(x.len().max(1)).zip(x) {
            if factor != 0.0 {
                out.iter_mut().zip(row).for_each(|(y, g)| *y += factor * g);
            }
        }
    }
}

wide! {
    /// Factors `a` (`n × n`, row after row) in place by elimination with row exchanges, which `order` takes down.
    /// `false`: singular to working precision.
    fn eliminate(a: &mut [f64], n: usize, order: &mut Vec<usize>) -> bool {
        order.clear();
        for k in 0..n {
            let largest = |best: usize, row: usize| {
                if a[row * n + k].abs() > a[best * n + k].abs() { row } else { best }
            };
            let pivot = (k + 1..n).fold(k, largest);
            let size = a[pivot * n + k].abs();
            if size <= f64::MIN_POSITIVE || !size.is_finite() {
                return false;
            }
            if pivot != k {
                let (upper, lower) = a.split_at_mut(pivot * n);
                upper[k * n..(k + 1) * n].swap_with_slice(&mut lower[..n]);
            }
            order.push(pivot);
            let (upper, lower) = a.split_at_mut((k + 1) * n);
            let pivot_row = &upper[k * n + k..];
            let reciprocal = pivot_row[0].recip();
            for row in lower.chunks_exact_mut(n) {
                let factor = row[k] * reciprocal;
                if factor != 0.0 {
                    row[k + 1..].iter_mut().zip(&pivot_row[1..]).for_each(|(x, y)| *x -= factor * y);
                }
                row[k] = factor;
            }
        }
        true
    }
}

wide! {
    /// Solves `a x = b` in place with what [`eliminate`] left. `false`: no finite solution.
    fn substitute(a: &[f64], n: usize, order: &[usize], b: &mut [f64]) -> bool {
        for (k, &pivot) in order.iter().enumerate() {
            b.swap(k, pivot);
        }
        for k in 0..n {
            let row = &a[k * n..k * n + k];
            b[k] -= dot(row, &b[..k]);
        }
        for k in (0..n).rev() {
            let row = &a[k * n..(k + 1) * n];
            b[k] = (b[k] - dot(&row[k + 1..], &b[k + 1..n])) / row[k];
        }
        b[..n].iter().all(|x| x.is_finite())
    }
}

/// Four sums side by side: one would wait for itself.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (a4, a_rest) = a.as_chunks::<4>();
    let (b4, b_rest) = b.as_chunks::<4>();
    for ([x0, x1, x2, x3], [y0, y1, y2, y3]) in a4.iter().zip(b4) {
        sums = [sums[0] + x0 * y0, sums[1] + x1 * y1, sums[2] + x2 * y2, sums[3] + x3 * y3];
    }
    let rest: f64 = a_rest.iter().zip(b_rest).map(|(x, y)| x * y).sum();
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};

    /// Numbers that look random; the same every time.
    fn numbers(count: usize) -> Vec<f64> {
        (0..count).map(|i| ((i * i + 7 * i) as f64 * 0.731).sin()).collect()
    }

    fn positive(n: usize) -> DMatrix<f64> {
        let a = DMatrix::from_row_slice(n, n, &numbers(n * n));
        &a * a.transpose() + DMatrix::identity(n, n) * 0.1
    }

    #[test]
    fn agree_with_nalgebra() {
        let (n, columns) = (9, 5);
        let d = positive(n);
        let mut l: Vec<f64> = d.transpose().as_slice().to_vec();
        assert!(factor(&mut l, n));
        let mut y = numbers(n * columns);
        // The last column is zero but in the last row, as where a limb has contacts of its own.
        (0..n - 1).for_each(|i| y[i * columns + columns - 1] = 0.0);
        let b = DMatrix::from_row_slice(n, columns, &y);
        let mut stretches: Vec<Stretch> = y.chunks(columns).map(Stretch::of).collect();
        assert_eq!(stretches[0], Stretch { begin: usize::from(y[0] == 0.0), end: columns - 1 });
        forward(&l, n, &mut y, columns, &mut stretches);
        let mut g = vec![0.0; columns * columns];
        gram(&y, columns, &stretches, &mut g);
        let expected = b.transpose() * d.clone().try_inverse().unwrap() * &b;
        assert!((DMatrix::from_row_slice(columns, columns, &g) - &expected).amax() < 1e-10 * expected.amax());
        let mut x = numbers(n);
        let right = DVector::from_row_slice(&x);
        forward_one(&l, n, &mut x);
        backward(&l, n, &mut x);
        assert!((&d * DVector::from_row_slice(&x) - &right).amax() < 1e-12);
        let (start, mut out) = (numbers(n), vec![0.0; n]);
        multiply(d.as_slice(), &x, &start, &mut out);
        let expected = &right + DVector::from_row_slice(&start);
        assert!((DVector::from_row_slice(&out) - expected).amax() < 1e-12);
    }

    #[test]
    fn elimination_solves_and_refuses() {
        let (n, mut order) = (7, Vec::new());
        let a = DMatrix::from_row_slice(n, n, &numbers(n * n));
        let mut factors = a.transpose();
        assert!(eliminate(factors.as_mut_slice(), n, &mut order));
        // Any number of right sides.
        for scale in [1.0, -3.0] {
            let mut x: Vec<f64> = numbers(n).iter().map(|x| scale * x).collect();
            let right = DVector::from_row_slice(&x);
            assert!(substitute(factors.as_slice(), n, &order, &mut x));
            assert!((&a * DVector::from_row_slice(&x) - right).amax() < 1e-10);
        }
        assert!(!eliminate(&mut [1.0, 2.0, 2.0, 4.0], 2, &mut order));
        assert!(!factor(&mut [1.0, 0.0, 2.0, 1.0], 2));
        assert!(!factor(&mut [f64::NAN], 1));
    }
}
