//! A foot in the air: a motion of least jerk to a place that may change on the way.
use crate::real::Scalar;

/// Shortest time in which a changed goal is aimed at, s: below it jerks would grow without bound.
const SHORTEST: f64 = 0.03;

/// One coordinate of a reference with its first two derivatives.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moving<R> {
    /// m or rad
    pub place: R,
    /// per s
    pub rate: R,
    /// per s²
    pub acceleration: R,
}

impl<R: Scalar> Moving<R> {
    /// At rest.
    pub fn resting(place: R) -> Self {
        let zero = R::constant(0.0);
        Self { place, rate: zero, acceleration: zero }
    }

    /// Goes on for `step` s on the motion of least squared jerk that rests at `goal` after `left` s.
    pub fn toward(&mut self, goal: R, left: R, step: R) {
        let left = left.larger(R::constant(SHORTEST));
        let Self { place, rate, acceleration } = *self;
        // The quintic from here that ends at rest (Flash and Hogan, 1985).
        let jerk = (R::constant(60.0) * (goal - place) / left - R::constant(36.0) * rate) / (left * left)
            - R::constant(9.0) * acceleration / left;
        self.go_on(jerk, step);
    }

    /// Goes on for `step` s at this velocity, reached smoothly.
    pub fn at_rate(&mut self, rate: R, step: R) {
        let short = R::constant(SHORTEST);
        let jerk =
            (R::constant(6.0) * (rate - self.rate) / short - R::constant(4.0) * self.acceleration) / short;
        self.go_on(jerk, step);
    }

    fn go_on(&mut self, jerk: R, step: R) {
        let (half, sixth) = (R::constant(0.5), R::constant(1.0 / 6.0));
        self.place =
            self.place + step * (self.rate + step * (half * self.acceleration + step * sixth * jerk));
        self.rate = self.rate + step * (self.acceleration + half * step * jerk);
        self.acceleration = self.acceleration + step * jerk;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_goal_that_changes_is_reached_without_jumps() {
        let (mut x, h) = (Moving::resting(0.0), 1e-3);
        let mut last = x;
        for k in 0..400 {
            let left = 0.4 - f64::from(k) * h;
            let goal = if k < 200 { 0.2 } else { 0.25 };
            x.toward(goal, left, h);
            assert!((x.rate - last.rate).abs() < 0.02, "{k}");
            last = x;
        }
        assert!((x.place - 0.25).abs() < 1e-3 && x.rate.abs() < 0.02, "{x:?}");
    }

    #[test]
    fn it_goes_on_at_a_rate() {
        let mut x = Moving::resting(0.0);
        (0..300).for_each(|_| x.at_rate(-0.1, 1e-3));
        assert!((x.rate + 0.1_f64).abs() < 1e-6, "{x:?}");
    }
}
