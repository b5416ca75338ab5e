//! The divergent component of motion ξ = x + ẋ/ω of a linear inverted pendulum (6.45): ξ̇ = ω (ξ − z), where z is the zero moment point.
use crate::real::Scalar;

/// A place on the ground, m.
pub type Point<R> = [R; 2];

/// A piece of a walk in which the zero moment point goes straight from one place to another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece<R> {
    /// Where it is at the beginning, m.
    pub from: Point<R>,
    /// Where it is at the end, m.
    pub to: Point<R>,
    /// s
    pub duration: R,
}

impl<R: Scalar> Piece<R> {
    /// ξ at the beginning of the piece if it is `end` at its end: bounded backwards whatever comes after.
    pub fn before(&self, omega: R, end: Point<R>) -> Point<R> {
        let one = R::constant(1.0);
        let angle = omega * self.duration;
        let short = angle.abs() < R::constant(1e-9);
        let (decay, slope) = ((-angle).exp(), if short { R::constant(0.0) } else { one / angle });
        let of = |from: R, to: R, end: R| {
            if short {
                return end;
            }
            // y = ξ − from: y(t) = C e^(ωt) + s t + s/ω with s = (to − from)/T.
            let way = to - from;
            let constant = (end - from - way - way * slope) * decay;
            from + constant + way * slope
        };
        let ([a, b], [c, d], [e, f]) = (self.from, self.to, end);
        [of(a, c, e), of(b, d, f)]
    }

    /// Where the zero moment point is this long (s) after the beginning.
    pub fn at(&self, time: R) -> Point<R> {
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let part = if self.duration > zero { time / self.duration } else { one };
        let part = -(-part.larger(zero)).larger(-one);
        let ([a, b], [c, d]) = (self.from, self.to);
        [R::fused(part, c - a, a), R::fused(part, d - b, b)]
    }

    /// What is left of it after this long (s).
    pub fn rest(&self, time: R) -> Self {
        let left = (self.duration - time).larger(R::constant(0.0));
        Self { from: self.at(time), to: self.to, duration: left }
    }
}

/// What the divergent component seems to be off: ξ̇ = ω (ξ + b − z). A slope, a centre of mass elsewhere than known, a wind make b; it is the mean over two
/// steps, in which what legs and sway do to the pendulum goes to and fro.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DivergentBias<R> {
    bias: Point<R>,
    /// ∫ ω (ξ + b − z) dt less how far ξ went (m), and the time (s): of the present step and the one before.
    steps: [(Point<R>, R); 2],
    /// ξ + b as it was last.
    last: Option<Point<R>>,
}

/// Part of what a step says of the bias that is believed.
const BELIEVED: f64 = 0.5;
/// Larger biases (m) are none.
const LARGEST: f64 = 0.08;

impl<R: Scalar> DivergentBias<R> {
    /// None.
    pub fn new() -> Self {
        let zero = R::constant(0.0);
        Self { bias: [zero; 2], steps: [([zero; 2], zero); 2], last: None }
    }

    /// b, m
    pub fn bias(&self) -> Point<R> {
        self.bias
    }

    /// After another `step` (s) with the zero moment point at `zmp`: `divergent` is ξ + b.
    pub fn update(&mut self, divergent: Point<R>, zmp: Point<R>, omega: R, step: R) {
        let last = self.last.replace(divergent).unwrap_or(divergent);
        let [(missing, time), _] = &mut self.steps;
        *time = *time + omega * step;
        let parts = missing.iter_mut().zip(divergent).zip(last).zip(zmp);
        parts.for_each(|(((sum, now), last), z)| *sum = *sum + (now - last) - omega * step * (now - z));
    }

    /// A foot has come down.
    pub fn step(&mut self) {
        let zero = R::constant(0.0);
        let [(a, time), (b, before)] = self.steps;
        if before > zero && time > zero {
            let most = R::constant(LARGEST);
            let parts = self.bias.iter_mut().zip(a).zip(b);
            parts.for_each(|((bias, a), b)| {
                let found = *bias + R::constant(BELIEVED) * (a + b) / (time + before);
                *bias = -(-found.larger(-most)).larger(-most);
            });
            self.last = None;
        }
        self.steps = [([zero; 2], zero), (a, time)];
    }
}

impl<R: Scalar> Default for DivergentBias<R> {
    fn default() -> Self {
        Self::new()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ξ̇ = ω (ξ − z), integrated forwards by small steps, ends where the closed form began.
    #[test]
    fn pieces_solve_the_pendulum() {
        let omega: f64 = 3.5;
        for duration in [0.15, 0.45, 1.2] {
            let piece = Piece { from: [0.1, -0.2], to: [0.3, 0.05], duration };
            let end = [0.35, 0.1];
            let mut divergent = piece.before(omega, end);
            let count = 100_000;
            let h = duration / f64::from(count);
            for k in 0..count {
                let middle = piece.at((f64::from(k) + 0.5) * h);
                let grow = (omega * h).exp();
                divergent = [0, 1].map(|i| middle[i] + (divergent[i] - middle[i]) * grow);
            }
            assert!((0..2).all(|i| (divergent[i] - end[i]).abs() < 1e-8), "{duration}: {divergent:?}");
        }
    }

    #[test]
    fn no_time_changes_nothing() {
        let piece = Piece { from: [0.1, -0.2], to: [0.3, 0.05], duration: 0.0 };
        assert_eq!(piece.before(3.0, [1.0, 2.0]), [1.0, 2.0]);
        let at: [f64; 2] = piece.at(0.0);
        assert!((at[0] - 0.3).abs() < 1e-15 && (at[1] - 0.05).abs() < 1e-15);
        let rest = Piece { duration: 0.5, ..piece }.rest(0.25);
        assert!((rest.from[0] - 0.2).abs() < 1e-15 && (rest.from[1] + 0.075).abs() < 1e-15);
        assert_eq!((rest.to, rest.duration), ([0.3, 0.05], 0.25));
    }

    /// A pendulum that goes to and fro with a bias that it is not told of.
    #[test]
    fn a_bias_is_found_within_a_few_steps() {
        let (omega, h, bias) = (4.0, 1e-3, [0.02, -0.01]);
        let mut found = DivergentBias::new();
        let mut divergent: Point<f64> = [0.0, 0.0];
        for k in 0..6000 {
            // It is balanced by what is known.
            let side = if k / 600 % 2 == 0 { 0.05 } else { -0.05 };
            let seen = [0, 1].map(|i| divergent[i] + found.bias()[i]);
            let zmp = [2.0 * seen[0], side + 2.0 * seen[1]];
            divergent = [0, 1].map(|i| divergent[i] + h * omega * (divergent[i] + bias[i] - zmp[i]));
            let after = [0, 1].map(|i| divergent[i] + found.bias()[i]);
            found.update(after, zmp, omega, h);
            if k % 600 == 599 {
                found.step();
            }
        }
        let off = [0, 1].map(|i| (found.bias()[i] - bias[i]).abs());
        assert!(off.iter().all(|off| *off < 1e-3), "{:?}", found.bias());
    }
}
