//! Restoration: where no step is acceptable, constraints alone are made smaller, by damped Gauss–Newton steps on ½ Σ r² − b Σ ln d, with the distances d from all bounds.
//!
//! b is the mean of r², up to the present barrier: places that are restored keep away from bounds, as the search that goes on from there has to. With a thousandth of that many ended
//! within a millionth of a bound, and the steps behind them were as short.
use super::Iteration;
use super::interior_point::Search;
use super::iterate::total;

/// Violation of what is polished.
const POLISHED: f64 = 1e-9;
/// Smaller violations cannot be what keeps steps from being acceptable: this part of the tolerance.
const NOTHING: f64 = 0.1;
/// Part of the distance from each bound that a step keeps.
const KEPT: f64 = 0.01;
/// Part of the violation that may be left.
const LEFT: f64 = 0.9;
/// Damping at the beginning, and between these.
const DAMPING: f64 = 1e-4;
const DAMPINGS: [f64; 2] = [1e-10, 1e12];
/// Steps that gain next to nothing, at most.
const SLOW: usize = 20;

fn squares(residual: &[f64]) -> f64 {
    residual.iter().map(|r| r * r).sum()
}

impl Search<'_, '_> {
    /// Steps that make constraints hold, and nothing else.
    pub(super) fn polish(&mut self) {
        for _ in 0..20 {
            let now: f64 = total(&self.values.residual);
            if now < POLISHED {
                return;
            }
            let Some(d) = self.restoring_step(1e-8, now * now) else { return };
            let x = self.moved(&d, self.of.longest(&self.at.x, &d, KEPT));
            let falls = total(&self.of.residual(&x)) < now;
            if !falls {
                return;
            }
            self.at.x = x;
            self.values = self.of.values(&self.at.x);
        }
    }

    /// Makes constraints smaller until the filter accepts the place; false: they stay.
    pub(super) fn restore(&mut self, watch: &mut dyn FnMut(&Iteration) -> bool) -> bool {
        let begin = total(&self.values.residual);
        if begin < NOTHING * self.settings.tolerance {
            return false;
        }
        let here = self.of.barrier_function(&self.at.x, self.values.objective, self.barrier);
        self.filter.add((1.0 - 1e-5) * begin, here - 1e-5 * begin);
        let mut damping = DAMPING;
        let mut slow = 0;
        while self.iterations < self.settings.iterations {
            self.iterations += 1;
            let now = squares(&self.values.residual);
            let Some(d) = self.restoring_step(damping, now) else { return false };
            let step = self.of.longest(&self.at.x, &d, KEPT);
            let x = self.moved(&d, step);
            let found = squares(&self.of.residual(&x));
            let barrier = 2.0 * self.restoring_barrier(now);
            let merit = |x: &[f64], squares: f64| self.of.barrier_function(x, squares, barrier);
            let falls = merit(&x, found) < merit(&self.at.x, now);
            if !falls {
                damping *= 8.0;
                if damping > DAMPINGS[1] {
                    return false;
                }
                continue;
            }
            slow = if found > (1.0 - 1e-4) * now { slow + 1 } else { 0 };
            damping = (damping / if step > 0.3 { 4.0 } else { 1.5 }).max(DAMPINGS[0]);
            (self.at.x, self.step, self.primal) = (x, step, damping);
            self.values = self.of.values(&self.at.x);
            if !self.tell(watch, true) || slow > SLOW {
                return false;
            }
            if self.restored(LEFT * begin) {
                return true;
            }
        }
        false
    }

    /// Whether the filter accepts the place, with so much violation at most: then multipliers begin anew.
    fn restored(&mut self, most: f64) -> bool {
        let violation = total(&self.values.residual);
        let barrier = self.of.barrier_function(&self.at.x, self.values.objective, self.barrier);
        let accepted = violation <= most && self.filter.accepts(violation, barrier);
        if accepted {
            self.forget();
        }
        accepted
    }

    /// b.
    fn restoring_barrier(&self, squares: f64) -> f64 {
        (squares / (self.of.n + self.of.m) as f64).min(self.barrier)
    }

    /// A damped Gauss–Newton step of the squared residuals.
    fn restoring_step(&mut self, damping: f64, squares: f64) -> Option<Vec<f64>> {
        let (n, m) = (self.of.n, self.of.m);
        let barrier = self.restoring_barrier(squares);
        let curvature = |k: usize| {
            let [low, high] = self.of.distances(&self.at.x, k);
            damping + barrier / (low * low) + barrier / (high * high)
        };
        let sigma: Vec<f64> = (0..n).map(curvature).collect();
        let soft: Vec<f64> = (n..n + m).map(curvature).collect();
        let stiff = |row: usize| if self.of.equation(row) { 0.0 } else { 1.0 / soft[row] };
        let delta: Vec<f64> = (0..m).map(|row| 1.0 + stiff(row)).collect();
        self.kkt.fill(&vec![0.0; self.of.hessian.len()], &self.values.jacobian, &sigma, &delta);
        if !self.kkt.factorise(0.0, 0.0) {
            return None;
        }
        let slope = |k: usize| self.of.barrier_slope(&self.at.x, k, barrier);
        let mut right: Vec<f64> = (0..n).map(|k| -slope(k)).collect();
        right.extend((0..m).map(|row| -self.values.residual[row] - slope(n + row) * stiff(row)));
        let mut d = Vec::new();
        self.kkt.solve(&right, 0.0, &mut d);
        let y = d.split_off(n);
        d.extend((0..m).map(|row| (y[row] - slope(n + row)) * stiff(row)));
        d.iter().all(|d| d.is_finite()).then_some(d)
    }
}
