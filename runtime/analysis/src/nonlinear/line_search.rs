//! How far to go along a Newton step: as far as the filter accepts it, or all the way for some steps where it accepts next to nothing.
use super::Iteration;
use super::filter::Filter;
use super::interior_point::{Direction, Search};
use super::iterate::total;

/// So many steps in a row that were cut short, and full ones are tried.
pub(super) const SHORT: usize = 3;
/// Cut short are steps of less than this part of what bounds allow.
const SHORTENED: f64 = 0.3;
/// Full steps that are tried.
const DARING: usize = 4;

impl Search<'_, '_> {
    /// A step along a direction; false: none is acceptable.
    pub(super) fn go(&mut self, direction: &Direction, watch: &mut dyn FnMut(&Iteration) -> bool) -> bool {
        match self.short >= SHORT {
            true => self.dare(direction, watch),
            false => self.search_along(direction),
        }
    }

    /// Violation and barrier function, and the barrier function's slope along a direction.
    fn prospect(&self, direction: &Direction) -> ([f64; 2], f64) {
        let violation = total(&self.values.residual);
        let barrier = self.of.barrier_function(&self.at.x, self.values.objective, self.barrier);
        let slope = |k: usize| {
            let own = if k < self.of.n { self.values.gradient[k] } else { 0.0 };
            (own + self.of.barrier_slope(&self.at.x, k, self.barrier)) * direction.x[k]
        };
        ([violation, barrier], (0..direction.x.len()).map(slope).sum())
    }

    /// The longest step along a direction.
    fn longest(&self, direction: &Direction) -> f64 {
        self.of.longest(&self.at.x, &direction.x, self.barrier.min(0.01))
    }

    /// Full steps, whatever they violate, until one is acceptable from where they began. Where constraints bend much and hold nearly, only tiny steps violate them less at once, but a
    /// second full step mends what the first one did. Else back there, and multipliers begin anew: what led to tiny steps was their curvature.
    fn dare(&mut self, direction: &Direction, watch: &mut dyn FnMut(&Iteration) -> bool) -> bool {
        let (here, slope) = self.prospect(direction);
        let begin = (self.at.clone(), self.values.clone());
        let first = self.longest(direction);
        self.short = 0;
        let mut next = Some(direction.clone());
        for _ in 0..DARING {
            let Some(direction) = next else { break };
            let step = self.longest(&direction);
            let x = self.moved(&direction.x, step);
            let accepted = self.acceptable(&x, here, slope, first);
            if !total(&self.of.residual(&x)).is_finite() {
                break;
            }
            self.take(x, &direction, step);
            if let Some(by_barrier) = accepted {
                self.leave(here, by_barrier);
                return true;
            }
            self.iterations += 1;
            // Whoever wants to stop is asked again where the iteration ends.
            self.tell(watch, false);
            next = self.direction();
        }
        (self.at, self.values) = begin;
        self.forget();
        self.direction().is_some_and(|direction| self.search_along(&direction))
    }

    /// A step of acceptable length along a direction, if there is one.
    fn search_along(&mut self, direction: &Direction) -> bool {
        let longest = self.longest(direction);
        let (here, slope) = self.prospect(direction);
        let mut step = longest;
        let mut first = true;
        while step > 1e-7 * longest.min(1.0) && step > 1e-12 {
            let x = self.moved(&direction.x, step);
            if let Some(by_barrier) = self.acceptable(&x, here, slope, step) {
                self.short = if step < SHORTENED * longest { self.short + 1 } else { 0 };
                self.take(x, direction, step);
                self.leave(here, by_barrier);
                return true;
            }
            if first && self.corrected(direction, longest, (here, slope)) {
                self.short = 0;
                return true;
            }
            first = false;
            step *= 0.5;
        }
        false
    }

    /// Whether a place is acceptable, and if so, whether because of the barrier function.
    fn acceptable(&self, x: &[f64], here: [f64; 2], slope: f64, step: f64) -> Option<bool> {
        let violation = total(&self.of.residual(x));
        let barrier = self.of.barrier_function(x, self.of.objective(x), self.barrier);
        let rounding = 1e-14 * here[1].abs();
        if !violation.is_finite()
            || !barrier.is_finite()
            || !self.filter.accepts(violation, barrier - rounding)
        {
            return None;
        }
        let by_barrier = slope < 0.0
            && step * (-slope).powf(2.3) > here[0].powf(1.1)
            && here[0] <= self.smallest_violation;
        let better = match by_barrier {
            true => barrier - here[1] - rounding <= 1e-4 * step * slope,
            false => Filter::improves([violation, barrier - rounding], here),
        };
        better.then_some(by_barrier)
    }

    /// Second-order corrections of the full step: the constraints' curvature taken in.
    fn corrected(&mut self, direction: &Direction, longest: f64, (here, slope): ([f64; 2], f64)) -> bool {
        let trial = self.of.residual(&self.moved(&direction.x, longest));
        let mut before = total(&trial);
        if !before.is_finite() || before < here[0] {
            return false;
        }
        let mut residual: Vec<f64> =
            self.values.residual.iter().zip(&trial).map(|(a, b)| longest * a + b).collect();
        for _ in 0..4 {
            let Some(found) = self.step_for(&residual) else { return false };
            let step = self.of.longest(&self.at.x, &found.x, self.barrier.min(0.01));
            let x = self.moved(&found.x, step);
            if let Some(by_barrier) = self.acceptable(&x, here, slope, longest) {
                self.take(x, &found, step);
                self.leave(here, by_barrier);
                return true;
            }
            let trial = self.of.residual(&x);
            let violation = total(&trial);
            let falls = violation < 0.99 * before;
            if !falls {
                return false;
            }
            before = violation;
            residual.iter_mut().zip(&trial).for_each(|(a, b)| *a = step * *a + b);
        }
        false
    }

    /// Remembers what a step has left, unless the barrier function alone says that it is better.
    fn leave(&mut self, here: [f64; 2], by_barrier: bool) {
        if !by_barrier {
            self.filter.add((1.0 - 1e-5) * here[0], here[1] - 1e-5 * here[0]);
        }
    }

    fn take(&mut self, x: Vec<f64>, direction: &Direction, step: f64) {
        let kept = self.barrier.min(0.01);
        let mut dual: f64 = 1.0;
        for (z, d) in self.at.z.iter().zip(&direction.z) {
            for side in 0..2 {
                if d[side] < 0.0 {
                    dual = dual.min(-(1.0 - kept) * z[side] / d[side]);
                }
            }
        }
        self.at.x = x;
        self.at.y.iter_mut().zip(&direction.y).for_each(|(y, d)| *y += step * d);
        for k in 0..self.at.x.len() {
            let distances = self.of.distances(&self.at.x, k);
            for (side, distance) in distances.into_iter().enumerate() {
                let z = self.at.z[k][side] + dual * direction.z[k][side];
                let central = self.barrier / distance;
                self.at.z[k][side] = z.clamp(central * 1e-10, central * 1e10);
            }
        }
        self.step = step;
        self.values = self.of.values(&self.at.x);
    }
}
