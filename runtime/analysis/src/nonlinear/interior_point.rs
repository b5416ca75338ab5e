//! The interior point method: one barrier after the other, Newton steps, a filter.
use super::filter::Filter;
use super::iterate::{Iterate, Slacked, Values, largest, total};
use super::kkt::Kkt;
use super::line_search;
use super::{Central, Ending, Iteration, Minimiser, Program, Solution, Start};

/// A primal-dual interior point method with a filter line search.
#[derive(Debug, Clone, PartialEq)]
pub struct InteriorPoint {
    /// Largest error of the scaled conditions of a minimum.
    pub tolerance: f64,
    /// Largest violation of a constraint, in its own unit, in what is called feasible.
    pub feasible: f64,
    /// Iterations at most.
    pub iterations: usize,
    /// The first barrier's parameter, where nothing is known of a neighbour.
    pub barrier: f64,
    /// The least barrier's parameter of a place from which neighbours can be begun.
    pub central: f64,
    /// A search ends where so many iterations near the last barrier changed the objective by less than this part.
    pub patience: (usize, f64),
}

impl Default for InteriorPoint {
    fn default() -> Self {
        Self {
            tolerance: 1e-6,
            feasible: 1e-6,
            iterations: 1000,
            barrier: 0.1,
            central: 1e-3,
            patience: (20, 2e-3),
        }
    }
}

/// A search under way.
pub(super) struct Search<'p, 's> {
    pub settings: &'s InteriorPoint,
    pub of: Slacked<'p>,
    pub kkt: Kkt,
    pub filter: Filter,
    pub barrier: f64,
    central: Option<Central>,
    pub at: Iterate,
    pub values: Values,
    /// What was last added to the Hessian's diagonal.
    last_primal: f64,
    pub primal: f64,
    pub smallest_violation: f64,
    pub step: f64,
    /// Steps cut short one after the other.
    pub short: usize,
    pub iterations: usize,
    /// Objectives of the last iterations near the last barrier.
    recent: Vec<f64>,
}

/// A Newton step.
#[derive(Debug, Clone)]
pub(super) struct Direction {
    pub x: Vec<f64>,
    pub y: Vec<f64>,
    pub z: Vec<[f64; 2]>,
}

/// Additions to the diagonal of the constraints, removed again by refinement.
const DUAL: f64 = 1e-9;
/// The same of the Hessian.
const PRIMAL: f64 = 1e-9;
const LARGEST_PRIMAL: f64 = 1e20;

impl Minimiser for InteriorPoint {
    fn minimise(
        &self,
        program: &dyn Program,
        start: &Start<'_>,
        watch: &mut dyn FnMut(&Iteration) -> bool,
    ) -> Solution {
        let mut search = Search::new(self, program, start);
        let ending = search.run(watch);
        search.solution(ending)
    }
}

impl<'p, 's> Search<'p, 's> {
    fn new(settings: &'s InteriorPoint, program: &'p dyn Program, start: &Start<'_>) -> Self {
        let of = Slacked::new(program, start.central.map_or(start.x, |central| &central.x));
        let barrier = start.central.map_or(settings.barrier, |central| central.barrier);
        let at = match start.central {
            Some(central) => of.go_on(central),
            None => of.begin(start.x, barrier),
        };
        let values = of.values(&at.x);
        let kkt = Kkt::new(of.n, of.m, &of.hessian, &of.jacobian);
        let violation = total(&values.residual).max(1.0);
        let filter = Filter::below(1e4 * violation);
        Self {
            settings,
            of,
            kkt,
            filter,
            barrier,
            central: None,
            at,
            values,
            last_primal: 0.0,
            primal: 0.0,
            smallest_violation: 1e-4 * violation,
            step: 1.0,
            // Near the path full steps are what converges.
            short: if start.central.is_some() { line_search::SHORT } else { 0 },
            iterations: 0,
            recent: Vec::new(),
        }
    }

    fn run(&mut self, watch: &mut dyn FnMut(&Iteration) -> bool) -> Ending {
        loop {
            let [dual, primal, complementary] = self.of.errors(&self.at, &self.values, 0.0);
            if dual.max(primal).max(complementary) <= self.settings.tolerance {
                return Ending::Minimum;
            }
            if self.iterations >= self.settings.iterations || self.is_slow(primal) {
                self.polish();
                return Ending::Iterations;
            }
            self.lower_barrier();
            let Some(direction) = self.direction() else {
                if !self.restore(watch) {
                    return Ending::Infeasible;
                }
                continue;
            };
            if !self.go(&direction, watch) && !self.restore(watch) {
                return Ending::Infeasible;
            }
            self.iterations += 1;
            if !self.tell(watch, false) {
                return Ending::Stopped;
            }
        }
    }

    /// Whether nothing is to be gained any more: constraints hold nearly, and the objective stays.
    fn is_slow(&mut self, violation: f64) -> bool {
        let (count, part) = self.settings.patience;
        if self.barrier > 100.0 * self.settings.tolerance || violation > 1e-3 {
            self.recent.clear();
            return false;
        }
        self.recent.push(self.values.objective);
        let Some(first) = self.recent.len().checked_sub(count + 1) else { return false };
        let last = &self.recent[first..];
        let [low, high] =
            [last.iter().copied().fold(f64::MAX, f64::min), last.iter().copied().fold(f64::MIN, f64::max)];
        high - low <= part * high.abs()
    }

    pub(super) fn tell(&self, watch: &mut dyn FnMut(&Iteration) -> bool, restoring: bool) -> bool {
        let [stationarity, ..] = self.of.errors(&self.at, &self.values, self.barrier);
        let worst = self.violations(0.0).first().map_or(0.0, |(_, by)| by.abs());
        watch(&Iteration {
            number: self.iterations,
            objective: self.values.objective / self.of.scaling.objective,
            violation: worst,
            stationarity,
            barrier: self.barrier,
            restoring,
            step: self.step,
            regularisation: self.primal,
        })
    }

    fn lower_barrier(&mut self) {
        let least = self.settings.tolerance / 10.0;
        loop {
            let errors = self.of.errors(&self.at, &self.values, self.barrier);
            let error = errors.into_iter().fold(0.0, f64::max);
            if error > 10.0 * self.barrier || self.barrier <= least {
                return;
            }
            if self.barrier >= self.settings.central {
                self.central = Some(self.place());
            }
            self.barrier = (0.2 * self.barrier).min(self.barrier.powf(1.5)).max(least);
            self.filter.clear();
        }
    }

    /// Where the search is, unscaled.
    fn place(&self) -> Central {
        let (x, multipliers) = (self.at.x[..self.of.n].to_vec(), self.of.multipliers(&self.at.y));
        Central { barrier: self.barrier, x, multipliers }
    }

    /// Σ of variables and slacks.
    fn curvature(&self, k: usize) -> f64 {
        let [low, high] = self.of.distances(&self.at.x, k);
        self.at.z[k][0] / low + self.at.z[k][1] / high
    }

    /// Factorises the system of a Newton step, its inertia made right; false: no addition does that.
    fn factorise(&mut self) -> bool {
        let hessian = self.of.second(&self.at.x, &self.at.y);
        if hessian.iter().any(|h| !h.is_finite()) {
            return false;
        }
        let mut primal = 0.0;
        loop {
            let sigma: Vec<f64> = (0..self.of.n).map(|k| self.curvature(k)).collect();
            let delta: Vec<f64> = (0..self.of.m)
                .map(|row| match self.of.equation(row) {
                    true => 0.0,
                    false => 1.0 / (self.curvature(self.of.n + row) + primal),
                })
                .collect();
            self.kkt.fill(&hessian, &self.values.jacobian, &sigma, &delta);
            if self.kkt.factorise(primal + PRIMAL, DUAL) {
                self.primal = primal;
                if primal > 0.0 {
                    self.last_primal = primal;
                }
                return true;
            }
            primal = match (primal, self.last_primal) {
                (0.0, 0.0) => 1e-4,
                (0.0, last) => (last / 3.0).max(1e-12),
                (x, 0.0) => 100.0 * x,
                (x, _) => 8.0 * x,
            };
            if primal > LARGEST_PRIMAL {
                self.last_primal = 0.0;
                return false;
            }
        }
    }

    pub(super) fn direction(&mut self) -> Option<Direction> {
        if !self.factorise() {
            return None;
        }
        let residual = self.values.residual.clone();
        self.step_for(&residual)
    }

    /// The step that the factorised system gives with these residuals of the constraints.
    pub(super) fn step_for(&mut self, residual: &[f64]) -> Option<Direction> {
        let (n, m) = (self.of.n, self.of.m);
        let gradient = self.of.lagrangian_gradient(&self.values, &self.at.y);
        let lack = |k: usize| gradient[k] + self.of.barrier_slope(&self.at.x, k, self.barrier);
        let mut right: Vec<f64> = (0..n).map(|k| -lack(k)).collect();
        let soft: Vec<f64> = (0..m).map(|row| self.curvature(n + row) + self.primal).collect();
        for row in 0..m {
            let slack = if self.of.equation(row) { 0.0 } else { lack(n + row) / soft[row] };
            right.push(-residual[row] - slack);
        }
        let mut solved = Vec::new();
        let error = self.kkt.solve(&right, self.primal, &mut solved);
        let solves = error < 1e-2;
        if !solves {
            return None;
        }
        let y = solved.split_off(n);
        for row in 0..m {
            let slack = if self.of.equation(row) { 0.0 } else { (y[row] - lack(n + row)) / soft[row] };
            solved.push(slack);
        }
        let along = |k: usize| {
            let distances = self.of.distances(&self.at.x, k);
            let [zl, zu] = self.at.z[k];
            let of = |d: f64, z: f64, dx: f64| match d.is_finite() {
                true => (self.barrier - z * dx) / d - z,
                false => 0.0,
            };
            [of(distances[0], zl, solved[k]), of(distances[1], zu, -solved[k])]
        };
        let z = (0..n + m).map(along).collect();
        let found = Direction { x: solved, y, z };
        found.x.iter().chain(&found.y).all(|d| d.is_finite()).then_some(found)
    }

    pub(super) fn moved(&self, d: &[f64], step: f64) -> Vec<f64> {
        self.at.x.iter().zip(d).map(|(x, d)| x + step * d).collect()
    }

    /// Multipliers begin anew.
    pub(super) fn forget(&mut self) {
        self.at.z = self.of.central(&self.at.x, self.barrier);
        self.at.y.fill(0.0);
    }

    /// Constraints that do not hold within a tolerance in their own unit, the worst first.
    fn violations(&self, tolerance: f64) -> Vec<(usize, f64)> {
        let mut values = vec![0.0; self.of.m];
        self.of.program.constraints(&self.at.x[..self.of.n], &mut values);
        let limits = self.of.program.limits();
        let by = |(row, (value, [low, high])): (usize, (&f64, &[f64; 2]))| {
            let by = if value < low { value - low } else { (value - high).max(0.0) };
            let met = by.abs() <= tolerance;
            (!met).then_some((row, by))
        };
        let mut found: Vec<(usize, f64)> = values.iter().zip(&limits).enumerate().filter_map(by).collect();
        found.sort_by(|a, b| b.1.abs().total_cmp(&a.1.abs()));
        found
    }

    fn solution(mut self, ending: Ending) -> Solution {
        let violations = self.violations(self.settings.feasible);
        let ending = match ending {
            Ending::Minimum | Ending::Stopped => ending,
            other if largest(&self.values.residual).is_nan() => other,
            _ if violations.is_empty() => Ending::Feasible,
            other => other,
        };
        let of = &self.of;
        let multipliers = of.multipliers(&self.at.y);
        self.at.x.truncate(of.n);
        Solution {
            ending,
            objective: of.program.objective(&self.at.x),
            x: self.at.x,
            multipliers,
            central: self.central,
            iterations: self.iterations,
            violations,
        }
    }
}
