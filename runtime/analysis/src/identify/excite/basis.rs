//! Joint trajectories that are linear in a few coefficients.
use nalgebra::DVector;
use std::f64::consts::TAU;

/// The shape of all joints' trajectories.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Family {
    /// Polynomials of this degree in time (thesis 5.17); they may begin and end in motion.
    Polynomial(usize),
    /// The same with velocity zero at start and end, so that a robot can begin and end them.
    RestingPolynomial(usize),
    /// Finite Fourier series with this many harmonics of 1/duration: periodic, and at rest (velocity and acceleration
    /// zero) at start and end.
    Fourier(usize),
}

/// Functions of time whose sums are the trajectories; the first one is the constant 1, all are of order 1.
#[derive(Debug, Clone)]
pub struct Basis {
    family: Family,
    /// s.
    duration: f64,
    /// Directions of sine and of cosine coefficients, or of odd and of even ones of polynomials, that keep the ends at
    /// rest.
    sines: Vec<DVector<f64>>,
    cosines: Vec<DVector<f64>>,
}

impl Basis {
    /// For trajectories of `duration` s.
    pub fn new(family: Family, duration: f64) -> Self {
        let (mut sines, mut cosines) = (Vec::new(), Vec::new());
        if let Family::Fourier(harmonics) = family {
            // Of sin(kωt)/k and cos(kωt)/k: the velocity at 0 is ω Σ b_k, the acceleration -ω² Σ k a_k.
            sines = complement(&DVector::from_element(harmonics, 1.0));
            cosines = complement(&DVector::from_fn(harmonics, |k, _| (k + 1) as f64));
        }
        if let Family::RestingPolynomial(degree) = family {
            // Slopes of Legendre polynomials at the ends: P_k'(±1) = (±1)^(k-1) k (k + 1)/2.
            let slopes = |first: usize| {
                let slopes = (first..=degree).step_by(2).map(|k| (k * (k + 1)) as f64 / 2.0);
                complement(&DVector::from_iterator((degree + 2 - first) / 2, slopes))
            };
            (sines, cosines) = (slopes(1), slopes(2));
        }
        Self { family, duration, sines, cosines }
    }

    /// Number of functions.
    pub fn len(&self) -> usize {
        match self.family {
            Family::Polynomial(degree) => degree + 1,
            Family::Fourier(_) | Family::RestingPolynomial(_) => 1 + self.sines.len() + self.cosines.len(),
        }
    }

    /// Whether there is none: never.
    pub fn is_empty(&self) -> bool {
        false
    }

    /// s.
    pub fn duration(&self) -> f64 {
        self.duration
    }

    /// Samples that show every wave well.
    pub fn samples(&self) -> usize {
        match self.family {
            Family::Polynomial(degree) | Family::RestingPolynomial(degree) => 12 * degree.max(5),
            Family::Fourier(harmonics) => 16 * harmonics.max(4),
        }
    }

    /// All functions with their first and second time derivatives (1/s, 1/s²) at a time, s.
    pub fn at(&self, time: f64) -> [Vec<f64>; 3] {
        match self.family {
            Family::Polynomial(degree) => self.legendre(degree, time),
            Family::RestingPolynomial(degree) => self.resting(degree, time),
            Family::Fourier(harmonics) => self.waves(harmonics, time),
        }
    }

    /// Legendre polynomials over the duration: the same space as powers of time, but well-conditioned.
    fn legendre(&self, degree: usize, time: f64) -> [Vec<f64>; 3] {
        let rate = 2.0 / self.duration;
        let u = rate * time - 1.0;
        let mut p = [vec![1.0], vec![0.0], vec![0.0]];
        for k in 0..degree {
            let before = |of: usize| if k == 0 { 0.0 } else { p[of][k - 1] };
            let odd = (2 * k + 1) as f64;
            let value = (odd * u * p[0][k] - k as f64 * before(0)) / (k + 1) as f64;
            let next = [value, before(1) + odd * p[0][k], before(2) + odd * p[1][k]];
            p.iter_mut().zip(next).for_each(|(p, next)| p.push(next));
        }
        p[1].iter_mut().for_each(|x| *x *= rate);
        p[2].iter_mut().for_each(|x| *x *= rate * rate);
        p
    }

    fn resting(&self, degree: usize, time: f64) -> [Vec<f64>; 3] {
        self.legendre(degree, time).map(|p| {
            let every_second = |first: usize| {
                DVector::from_iterator((degree + 2 - first) / 2, p[first..].iter().copied().step_by(2))
            };
            let (odd, even) = (every_second(1), every_second(2));
            let odd = self.sines.iter().map(|direction| direction.dot(&odd));
            let even = self.cosines.iter().map(|direction| direction.dot(&even));
            [p[0]].into_iter().chain(odd).chain(even).collect()
        })
    }

    fn waves(&self, harmonics: usize, time: f64) -> [Vec<f64>; 3] {
        let omega = TAU / self.duration;
        let angle = |k: usize| (k + 1) as f64 * omega * time;
        let rate = |k: usize| (k + 1) as f64 * omega;
        let sin = DVector::from_fn(harmonics, |k, _| angle(k).sin() / (k + 1) as f64);
        let cos = DVector::from_fn(harmonics, |k, _| angle(k).cos() / (k + 1) as f64);
        let times = |x: &DVector<f64>, factor: f64, power: i32| {
            DVector::from_fn(harmonics, |k, _| factor * rate(k).powi(power) * x[k])
        };
        let pairs = [
            (sin.clone(), cos.clone()),
            (times(&cos, 1.0, 1), times(&sin, -1.0, 1)),
            (times(&sin, -1.0, 2), times(&cos, -1.0, 2)),
        ];
        let mut order = 0;
        pairs.map(|(sin, cos)| {
            let constant = if order == 0 { 1.0 } else { 0.0 };
            order += 1;
            let sines = self.sines.iter().map(|direction| direction.dot(&sin));
            let cosines = self.cosines.iter().map(|direction| direction.dot(&cos));
            [constant].into_iter().chain(sines).chain(cosines).collect()
        })
    }
}

/// Orthonormal directions across a vector: the other columns of the Householder reflection that turns it into an axis.
fn complement(normal: &DVector<f64>) -> Vec<DVector<f64>> {
    let mut mirror = normal.normalize();
    mirror[0] += 1.0;
    let scale = 2.0 / mirror.norm_squared();
    (1..normal.len())
        .map(|k| {
            DVector::from_fn(normal.len(), |i, _| f64::from(u8::from(i == k)) - scale * mirror[i] * mirror[k])
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_are_those_of_the_values() {
        for family in [Family::Polynomial(5), Family::RestingPolynomial(5), Family::Fourier(4)] {
            let basis = Basis::new(family, 7.0);
            let h = 1e-5;
            for step in 0..20 {
                let time = 0.3 * f64::from(step) + 0.1;
                let [_, v, a] = basis.at(time);
                let ([up, v_up, _], [down, v_down, _]) = (basis.at(time + h), basis.at(time - h));
                assert_eq!(v.len(), basis.len());
                for k in 0..basis.len() {
                    assert!((v[k] - (up[k] - down[k]) / (2.0 * h)).abs() < 1e-8, "{family:?} {k}");
                    assert!((a[k] - (v_up[k] - v_down[k]) / (2.0 * h)).abs() < 1e-8, "{family:?} {k}");
                }
            }
        }
    }

    #[test]
    fn resting_polynomials_start_and_end_at_rest() {
        let basis = Basis::new(Family::RestingPolynomial(5), 10.0);
        assert_eq!(basis.len(), 4);
        for [_, v, _] in [basis.at(0.0), basis.at(10.0)] {
            assert!(v.iter().all(|v| v.abs() < 1e-14), "{v:?}");
        }
    }

    #[test]
    fn waves_start_and_end_at_rest() {
        let basis = Basis::new(Family::Fourier(6), 10.0);
        assert_eq!(basis.len(), 11);
        let (start, end) = (basis.at(0.0), basis.at(10.0));
        for k in 0..basis.len() {
            assert!(start[1][k].abs() < 1e-14 && start[2][k].abs() < 1e-14);
            assert!((0..3).all(|of| (start[of][k] - end[of][k]).abs() < 1e-12));
        }
    }
}
