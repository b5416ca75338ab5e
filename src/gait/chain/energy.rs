//! The energies of a phase (6.32–6.34): ψ and P along φ, of the law without limits, by which φ̈ = a(φ) + b(φ) φ̇².
use super::{Chain, Refused};

/// ψ and P of one phase over φ, from φ₊ on.
#[derive(Debug, Clone)]
pub struct PhaseEnergy {
    /// φ, ln ψ(φ₊, φ), P(φ) and its slope at every second place of the quadrature.
    places: Vec<[f64; 4]>,
    /// How far ln ψ and P at the end are from those of half as many steps.
    pub error: [f64; 2],
}

impl PhaseEnergy {
    /// Of the present phase of a chain, from `start` to `end`; `steps` of the quadrature, an even number.
    ///
    /// # Errors
    /// There is no posture on the way.
    pub(super) fn new(
        chain: &Chain<'_>,
        phase: usize,
        [start, end]: [f64; 2],
        steps: usize,
    ) -> Result<Self, Refused> {
        let place = |k: usize| start + (end - start) * k as f64 / (2 * steps) as f64;
        let law: Vec<[f64; 2]> =
            (0..=2 * steps).map(|k| chain.law(phase, place(k))).collect::<Result<_, _>>()?;
        let fine = integrated(&law, 1, (end - start) / steps as f64);
        let coarse = integrated(&law, 2, 2.0 * (end - start) / steps as f64);
        let off = |k: usize| (fine[steps][k] - coarse[steps / 2][k]).abs();
        let error = [off(0), off(1)];
        let entry = |(k, &[log, potential]): (usize, &[f64; 2])| {
            [place(2 * k), log, potential, -law[2 * k][0] * (-log).exp()]
        };
        Ok(Self { places: fine.iter().enumerate().map(entry).collect(), error })
    }

    /// ψ(φ₊, φ₋).
    pub fn psi(&self) -> f64 {
        self.places.last().map_or(1.0, |place| place[1].exp())
    }

    /// P₋, (unit of φ/s)².
    pub fn p_minus(&self) -> f64 {
        self.places.last().map_or(0.0, |place| place[2])
    }

    /// ψ(φ₊, φ) and P(φ), on straight lines between the places of the quadrature.
    pub fn at(&self, phi: f64) -> [f64; 2] {
        let after = self.places.partition_point(|place| place[0] < phi).clamp(1, self.places.len() - 1);
        let ([x0, log0, p0, _], [x1, log1, p1, _]) = (self.places[after - 1], self.places[after]);
        let part = ((phi - x0) / (x1 - x0)).clamp(0.0, 1.0);
        [(log0 + part * (log1 - log0)).exp(), p0 + part * (p1 - p0)]
    }

    /// Where P is largest: φ, ψ(φ₊, φ) and P there.
    pub fn dead_centre(&self) -> [f64; 3] {
        let largest = self.places.iter().max_by(|a, b| a[2].total_cmp(&b[2]));
        let mut best = largest.map_or([0.0, 1.0, 0.0], |place| [place[0], place[1].exp(), place[2]]);
        for pair in self.places.windows(2) {
            let ([x0, log0, p0, rising], [x1, log1, p1, falling]) = (pair[0], pair[1]);
            if rising > 0.0 && falling <= 0.0 {
                // The cubic with these values and slopes; its slope vanishes once.
                let h = x1 - x0;
                let slope = |s: f64| {
                    let (a, b) = (6.0 * s * (1.0 - s) * (p1 - p0) / h, (1.0 - s) * (1.0 - 3.0 * s) * rising);
                    a + b + s * (3.0 * s - 2.0) * falling
                };
                let (mut low, mut high) = (0.0, 1.0);
                for _ in 0..60 {
                    let middle = 0.5 * (low + high);
                    if slope(middle) > 0.0 { low = middle } else { high = middle }
                }
                let s = 0.5 * (low + high);
                let rest = 1.0 - s;
                let p = (1.0 + 2.0 * s) * rest * rest * p0
                    + s * s * (3.0 - 2.0 * s) * p1
                    + s * rest * (rest * rising - s * falling) * h;
                if p >= best[2] {
                    best = [x0 + s * h, (log0 + s * (log1 - log0)).exp(), p];
                }
            }
        }
        best
    }
}

/// ln ψ and P after every step of Runge and Kutta's fourth order, each over two places of `law`, `stride` times as far apart:
/// (ln ψ)′ = 2 b, P′ = −a/ψ.
fn integrated(law: &[[f64; 2]], stride: usize, length: f64) -> Vec<[f64; 2]> {
    let rate = |k: usize, log: f64| [2.0 * law[k][1], -law[k][0] * (-log).exp()];
    let mut all = vec![[0.0, 0.0]];
    let mut now = [0.0_f64, 0.0];
    for k in (0..law.len() - 1).step_by(2 * stride) {
        let first = rate(k, now[0]);
        let second = rate(k + stride, now[0] + 0.5 * length * first[0]);
        let third = rate(k + stride, now[0] + 0.5 * length * second[0]);
        let fourth = rate(k + 2 * stride, now[0] + length * third[0]);
        for i in 0..2 {
            now[i] += length / 6.0 * (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]);
        }
        all.push(now);
    }
    all
}
