//! What a step of the whole robot under its gait's controller makes of small deviations: Poincaré multipliers of the full hybrid model.
use super::{Walker, walker};
use crate::gait::cycle::{Whole, WholeCycle};
use crate::gait::{AnyBench, Chain};
use bipedc_analysis::simulate::phases::{
    Assumptions, End, LandingGuard, PhasedRobot, Precision, Start, walk,
};
use bipedc_compiler::Robot;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_runtime::control::{Controller, Observation};
use bipedc_runtime::{Argument, Model, State};
use nalgebra::{DMatrix, DVector};
use std::cmp::Ordering;

/// Deviations of angles (rad, m) and of speeds, as a part of the largest one: where torques go from limit to limit steps are known to some 1e-7.
const MOVED: [f64; 2] = [2e-5, 2e-5];
const MOVED_ACROSS_LIMITS: [f64; 2] = [1e-3, 1e-3];
/// A step takes no longer, s.
const LONGEST: f64 = 20.0;
/// Singular values of contacts that count as none, as a part of the largest.
const DEPENDENT: f64 = 1e-9;
/// Steps of Newton's method at most.
const NEWTON: usize = 6;
/// Steps that miss no more than this repeat themselves: the integration is not known better, rad, m, rad/s, m/s.
const KNOWN: f64 = 1e-8;
/// Rounds in which contacts are put back where they were.
const ROUNDS: usize = 12;

/// Multipliers of a cycle with these parameters that passes its dead centre at `speed` (per s).
///
/// A step begins just after an impact, with its feet held where they are; every direction of q and q̇ in which they stay there is tried, by central
/// differences of the event-driven simulation. Nothing is assumed of the ground. h_p takes up at once what a deviation leaves of the outputs, so that
/// with it most multipliers vanish.
///
/// # Errors
/// The robot's phases cannot be derived.
pub fn returned(robot: &Robot, bench: &AnyBench, values: &[f64], speed: f64) -> Result<Whole, Diagnostics> {
    let mut robot = robot.clone();
    robot.description = match bench {
        AnyBench::OnePhase(bench) => bench.compiled().description.clone(),
        AnyBench::Phased(bench) => bench.compiled().description.clone(),
    };
    let walker = walker(&robot)?;
    let found = Returned::new(&walker, bench, values, speed).and_then(|returned| returned.multipliers());
    Ok(found.unwrap_or_else(|why| Whole { reason: Some(why.message), ..Whole::default() }))
}

/// A step that is taken again and again, from states near the one in which it begins.
struct Returned<'w> {
    walker: &'w Walker,
    bench: &'w AnyBench,
    values: Vec<f64>,
    /// Of the description.
    phase: usize,
    q: DVector<f64>,
    v: DVector<f64>,
    /// Directions in which the contacts stay, one per column.
    free: DMatrix<f64>,
    /// Places of the contacts, along x and z, m.
    held: DVector<f64>,
}

fn first(found: Diagnostics) -> Diagnostic {
    found.0.into_iter().next().unwrap_or_else(|| Diagnostic::error("it is not known why"))
}

impl<'w> Returned<'w> {
    fn new(walker: &'w Walker, bench: &'w AnyBench, values: &[f64], speed: f64) -> Result<Self, Diagnostic> {
        let (state, phase) = match bench {
            AnyBench::OnePhase(bench) => {
                let named = |phase: &bipedc_analysis::simulate::phases::PhaseSpec| {
                    phase.name == bench.gait.phase.name
                };
                let phase = walker.phases.iter().position(named).unwrap_or(0);
                (bench.beginning(values, speed)?, phase)
            }
            AnyBench::Phased(bench) => {
                let controller = bench.controller(None, &[]).map_err(first)?;
                let chain = Chain::new(bench, &walker.phases, controller)?;
                (chain.beginning(values, speed).map_err(Diagnostic::from)?, chain.first()?)
            }
        };
        let [q, v] = state.map(DVector::from_vec);
        let mut found = Self {
            walker,
            bench,
            values: values.to_vec(),
            phase,
            free: DMatrix::zeros(0, 0),
            held: DVector::zeros(0),
            q,
            v,
        };
        found.held = found.places(&found.q)?;
        let jacobian = found.jacobian(&found.q)?;
        // Eigenvectors of JᵀJ: all directions, those in which nothing moves among them.
        let squares = (jacobian.transpose() * &jacobian).symmetric_eigen();
        let largest = squares.eigenvalues.amax();
        let still: Vec<_> = (0..squares.eigenvalues.len())
            .filter(|&k| squares.eigenvalues[k].abs() <= DEPENDENT * largest)
            .map(|k| squares.eigenvectors.column(k).into_owned())
            .collect();
        found.free = DMatrix::from_columns(&still);
        Ok(found)
    }

    fn call(&self, name: &str, q: &DVector<f64>) -> Result<Vec<f64>, Diagnostic> {
        let (model, missing) =
            (&self.walker.model, || Diagnostic::error(format!("the model has no `{name}`")));
        let function = Model::<f64>::function(model, name).ok_or_else(missing)?;
        let size = Model::<f64>::signature(model, function).map_or(0, |s| s.rows * s.columns);
        let mut out = vec![0.0; size];
        let state = State::new().with(Argument::Q, q.as_slice());
        model
            .evaluate(function, &state, &mut out)
            .map_err(|error| Diagnostic::error(format!("{error:?}")))?;
        Ok(out)
    }

    fn standing(&self) -> &[usize] {
        &self.walker.phases[self.phase].standing
    }

    /// Places of the standing points along x, then their heights.
    fn places(&self, q: &DVector<f64>) -> Result<DVector<f64>, Diagnostic> {
        let (x, z) = (self.call("contact_positions", q)?, self.call("contact_distances", q)?);
        let of = |all: Vec<f64>| self.standing().iter().map(|&point| all[point]).collect::<Vec<_>>();
        Ok(DVector::from_vec([of(x), of(z)].concat()))
    }

    fn jacobian(&self, q: &DVector<f64>) -> Result<DMatrix<f64>, Diagnostic> {
        let n = q.len();
        let of = |all: Vec<f64>| {
            self.standing()
                .iter()
                .flat_map(|&point| all[point * n..(point + 1) * n].to_vec())
                .collect::<Vec<_>>()
        };
        let rows = [
            of(self.call("contact_tangential_directions", q)?),
            of(self.call("contact_normal_directions", q)?),
        ];
        Ok(DMatrix::from_row_slice(2 * self.standing().len(), n, &rows.concat()))
    }

    /// A state with these deviations along the free directions, its contacts where they were and at rest.
    fn state(&self, moved: &DVector<f64>) -> Result<[DVector<f64>; 2], Diagnostic> {
        let count = self.free.ncols();
        let mut q = &self.q + &self.free * moved.rows(0, count);
        let mut v = &self.v + &self.free * moved.rows(count, count);
        let least = |q: &DVector<f64>, missed: DVector<f64>| -> Result<DVector<f64>, Diagnostic> {
            let svd = self.jacobian(q)?.svd(true, true);
            let smallest = DEPENDENT.sqrt() * svd.singular_values.amax();
            svd.solve(&missed, smallest).map_err(Diagnostic::error)
        };
        for _ in 0..ROUNDS {
            let missed = self.places(&q)? - &self.held;
            if missed.amax() < 1e-14 {
                break;
            }
            q -= least(&q, missed)?;
        }
        let missed = self.jacobian(&q)? * &v;
        v -= least(&q, missed)?;
        Ok([q, v])
    }

    /// Deviations where the next step begins, of a step that begins with some.
    fn step(&self, moved: &DVector<f64>) -> Result<DVector<f64>, Diagnostic> {
        let [q, v] = self.state(moved)?;
        let observed = Observation::new(0.0, self.phase, q.as_slice(), v.as_slice());
        let refused = |refusal: bipedc_runtime::control::Refusal| Diagnostic::error(refusal.to_string());
        match self.bench {
            AnyBench::OnePhase(bench) => {
                let mut controller = bench.controller(Default::default(), &[]).map_err(first)?.unlimited();
                for (index, &value) in self.values.iter().enumerate() {
                    controller.ask(index, value).map_err(refused)?;
                }
                controller.begin_phase(&observed).map_err(refused)?;
                let guard = bench.guard();
                let negative = controller.guard_before().is_some_and(|guard| guard < 0.0);
                let ending = |q: &[f64]| {
                    let value = guard(q, &self.values);
                    if negative { -value } else { value }
                };
                self.walked([&q, &v], controller, 1, Some(&ending))
            }
            AnyBench::Phased(bench) => {
                let mut controller = bench.controller(None, &[]).map_err(first)?;
                for (index, &value) in self.values.iter().enumerate() {
                    controller.ask(index, value).map_err(refused)?;
                }
                controller.begin_phase(&observed).map_err(refused)?;
                self.walked([&q, &v], controller, bench.gait.phases.len(), None)
            }
        }
    }

    fn walked(
        &self,
        [q, v]: [&DVector<f64>; 2],
        controller: impl Controller<f64>,
        changes: usize,
        ending: Option<&LandingGuard<'_>>,
    ) -> Result<DVector<f64>, Diagnostic> {
        let nothing = Assumptions {
            scuffing: f64::INFINITY,
            pushing: false,
            second_impact: false,
            level: f64::INFINITY,
            ..Assumptions::default()
        };
        let Walker { model, base, feet, phases, .. } = self.walker;
        let robot = PhasedRobot::new(model, *base, feet, phases.clone(), nothing, controller)?;
        let robot = robot.landing_where(ending);
        let x = [q.as_slice(), v.as_slice()].concat();
        let precision = Precision { relative: 1e-11, absolute: 1e-11, ..Precision::default() };
        let start = Start { time: 0.0, phase: self.phase, x };
        let walked = walk(&robot, start, LONGEST, changes, &precision, &mut |_, _, _| {})?;
        let after = match (walked.end, walked.changes.last()) {
            (End::Changes, Some(change)) => &change.after,
            (End::Violated(found), _) => {
                return Err(Diagnostic::error(format!("in phase `{}` {}", found.phase, found.meaning)));
            }
            _ => return Err(Diagnostic::error("a step does not come to its end")),
        };
        let (q, v) = after.split_at(self.q.len());
        let mut q = DVector::from_column_slice(q);
        // A step further on.
        q[0] -= self.places(&q)?[0] - self.held[0];
        let parts = [q - &self.q, DVector::from_column_slice(v) - &self.v].map(|off| self.free.tr_mul(&off));
        Ok(DVector::from_iterator(2 * self.free.ncols(), parts.iter().flat_map(|part| part.iter().copied())))
    }

    fn multipliers(&self) -> Result<Whole, Diagnostic> {
        let count = self.free.ncols();
        let [angle, speed] = match self.bench {
            AnyBench::OnePhase(_) => MOVED,
            AnyBench::Phased(_) => MOVED_ACROSS_LIMITS,
        };
        let missed = self.step(&DVector::zeros(2 * count))?;
        let miss = missed.amax();
        let mut slopes = DMatrix::zeros(2 * count, 2 * count);
        for k in 0..2 * count {
            let by = if k < count { angle } else { speed * self.v.amax() };
            let moved = |by: f64| {
                let mut moved = DVector::zeros(2 * count);
                moved[k] = by;
                self.step(&moved)
            };
            slopes.set_column(k, &((moved(by)? - moved(-by)?) / (2.0 * by)));
        }
        let repeats = self.repeating(&slopes, missed);
        let mut found: Vec<[f64; 2]> =
            slopes.complex_eigenvalues().iter().map(|value| [value.re, value.im]).collect();
        found.sort_by(|a, b| b[0].hypot(b[1]).total_cmp(&a[0].hypot(a[1])).then(b[1].total_cmp(&a[1])));
        found.pop();
        Ok(Whole { multipliers: found, miss: Some(miss), repeats, reason: None })
    }

    /// Newton's method on the step of the whole robot with one set of slopes, from the cycle of the zero dynamics, which a step misses by `missed`; none: steps do not come nearer to repeating themselves.
    fn repeating(&self, slopes: &DMatrix<f64>, mut missed: DVector<f64>) -> Option<WholeCycle> {
        let count = slopes.nrows();
        let newton = (slopes - DMatrix::identity(count, count)).lu();
        let (mut moved, mut rounds) = (DVector::zeros(count), 0);
        while rounds < NEWTON {
            let further = &moved - newton.solve(&missed)?;
            let next = self.step(&further).ok()? - &further;
            // What is left are the tolerances of the integration, or torques that go from limit to limit.
            if next.amax().partial_cmp(&missed.amax()) != Some(Ordering::Less) {
                break;
            }
            (moved, missed, rounds) = (further, next, rounds + 1);
        }
        let [q, v] = self.state(&moved).ok()?;
        let off = (q - &self.q).amax().max((v - &self.v).amax());
        (rounds > 0 || missed.amax() <= KNOWN).then(|| WholeCycle { off, miss: missed.amax(), rounds })
    }
}
