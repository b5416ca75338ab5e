//! The errors of an estimated state: their covariance, how they grow, and what one scalar measurement says of them.
use super::space::{Turn, Vector};
use crate::control::slices::get;
use crate::real::Scalar;

/// Where three errors begin: position of the unit (m), its velocity (m/s), attitude (rad), biases of gyroscope (rad/s) and accelerometer
/// (m/s²); all but the biases in world axes.
pub(super) const POSITION: usize = 0;
pub(super) const VELOCITY: usize = 3;
pub(super) const ATTITUDE: usize = 6;
pub(super) const GYROSCOPE: usize = 9;
pub(super) const ACCELEROMETER: usize = 12;
/// Position and attitude of each foot.
pub(super) const FEET: [usize; 2] = [15, 21];
/// Horizontal gravity (m/s²) in the world, whose plane is the ground's.
pub(super) const GRAVITY: usize = 27;
/// How many there are.
pub(super) const ERRORS: usize = 30;

/// So many standard deviations are believed as they are; what is farther off counts less.
const BELIEVED: f64 = 3.0;
/// So many are not believed at all.
const REFUSED: f64 = 10.0;

/// Covariance, and the errors as far as measurements of the present sample tell them.
#[derive(Debug, Clone)]
pub(super) struct Errors<R> {
    covariance: [[R; ERRORS]; ERRORS],
    known: [R; ERRORS],
}

/// A measured scalar: what each error adds to it, up to six of them.
pub(super) type Row<R> = [(usize, R); 6];

impl<R: Scalar> Errors<R> {
    pub fn new() -> Self {
        let zero = R::constant(0.0);
        Self { covariance: [[zero; ERRORS]; ERRORS], known: [zero; ERRORS] }
    }

    /// Three errors are independent of all others, with these variances.
    pub fn forget(&mut self, first: usize, variances: Vector<R>) {
        let zero = R::constant(0.0);
        for (i, row) in self.covariance.iter_mut().enumerate() {
            let own = i.wrapping_sub(first);
            for (j, element) in row.iter_mut().enumerate() {
                if own < 3 || j.wrapping_sub(first) < 3 {
                    *element = if i == j { get(&variances, own) } else { zero };
                }
            }
        }
    }

    /// Adds to the variances of three errors.
    pub fn grow(&mut self, first: usize, variances: Vector<R>) {
        for (k, variance) in variances.into_iter().enumerate() {
            if let Some(element) = self.covariance.get_mut(first + k).and_then(|row| row.get_mut(first + k)) {
                *element = *element + variance;
            }
        }
    }

    /// The variance of an error.
    pub fn variance(&self, index: usize) -> R {
        self.covariance.get(index).map_or(R::constant(0.0), |row| get(row, index))
    }

    /// e_to ← keep e_to + Σ M e_from for blocks of three errors.
    pub fn mix(&mut self, to: usize, keep: bool, parts: &[(usize, Turn<R>)]) {
        let zero = R::constant(0.0);
        // Rows, then columns.
        let mut rows = [[zero; ERRORS]; 3];
        for (i, row) in rows.iter_mut().enumerate() {
            if keep {
                *row = self.covariance.get(to + i).copied().unwrap_or([zero; ERRORS]);
            }
            for (from, matrix) in parts {
                let factors = matrix.get(i).copied().unwrap_or([zero; 3]);
                let sources = self.covariance.iter().skip(*from).take(3);
                for (factor, source) in factors.into_iter().zip(sources) {
                    row.iter_mut().zip(source).for_each(|(a, b)| *a = R::fused(factor, *b, *a));
                }
            }
        }
        self.covariance.iter_mut().skip(to).zip(rows).for_each(|(place, row)| *place = row);
        for row in &mut self.covariance {
            let mut own = [zero; 3];
            for (i, own) in own.iter_mut().enumerate() {
                if keep {
                    *own = get(row, to + i);
                }
                for (from, matrix) in parts {
                    let factors = matrix.get(i).copied().unwrap_or([zero; 3]);
                    let sources = row.iter().skip(*from);
                    *own = factors.into_iter().zip(sources).fold(*own, |sum, (m, p)| R::fused(m, *p, sum));
                }
            }
            row.iter_mut().skip(to).zip(own).for_each(|(place, own)| *place = own);
        }
    }

    /// A scalar that is `value` where the present errors make it Σ row e, give or take √`variance`. How many standard deviations it was off.
    pub fn measure(&mut self, row: &Row<R>, value: R, variance: R) -> R {
        let zero = R::constant(0.0);
        let mut covariance = [zero; ERRORS];
        let mut rest = value;
        for (index, factor) in row {
            rest = R::fused(-*factor, get(&self.known, *index), rest);
            if let Some(line) = self.covariance.get(*index) {
                covariance.iter_mut().zip(line).for_each(|(c, p)| *c = R::fused(*factor, *p, *c));
            }
        }
        let own = row.iter().fold(zero, |sum, (index, a)| R::fused(*a, get(&covariance, *index), sum));
        let mut whole = own + variance;
        if whole <= zero || !whole.is_finite() || !rest.is_finite() {
            return R::constant(REFUSED);
        }
        let off = rest.abs() / whole.sqrt();
        if off > R::constant(REFUSED) {
            return off;
        }
        if off > R::constant(BELIEVED) {
            // Huber: as if it had been measured so much worse.
            whole = whole * off * R::constant(1.0 / BELIEVED);
        }
        let gain = covariance.map(|c| c / whole);
        self.known.iter_mut().zip(gain).for_each(|(known, gain)| *known = R::fused(gain, rest, *known));
        for (line, gain) in self.covariance.iter_mut().zip(gain) {
            line.iter_mut().zip(covariance).for_each(|(p, c)| *p = R::fused(-gain, c, *p));
        }
        off
    }

    /// The errors that measurements told; the state is to be corrected by them, and they are 0 then.
    pub fn take(&mut self) -> [R; ERRORS] {
        let zero = R::constant(0.0);
        // Roundings make it neither asymmetric nor negative.
        for i in 0..ERRORS {
            for j in 0..i {
                let of = |i: usize, j: usize| self.covariance.get(i).map_or(zero, |row| get(row, j));
                let mean = R::constant(0.5) * (of(i, j) + of(j, i));
                for (i, j) in [(i, j), (j, i)] {
                    if let Some(element) = self.covariance.get_mut(i).and_then(|row| row.get_mut(j)) {
                        *element = mean;
                    }
                }
            }
            if let Some(element) = self.covariance.get_mut(i).and_then(|row| row.get_mut(i)) {
                *element = element.larger(R::constant(1e-14));
            }
        }
        core::mem::replace(&mut self.known, [zero; ERRORS])
    }

    pub fn is_finite(&self) -> bool {
        self.covariance.iter().flatten().chain(&self.known).all(|x| x.is_finite())
    }
}
