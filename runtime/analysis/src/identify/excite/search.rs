//! The search for a motion that tells much.
use super::basis::{Basis, Family};
use super::clearance::Clearance;
use super::information::{MotionQuality, Regression};
use super::limits::{Obstacle, Peaks, excess, fine, kept, peaks};
use super::machine::{Machine, dot};
use super::spectrum::{Criterion, Scaling};
use crate::robot::Trajectory;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::random::Random;
use slsqp::{StopTols, minimize};
use std::cell::{Cell, RefCell};
use std::time::{Duration, Instant};

/// How much breaking a limit costs, from round to round of one start.
const PENALTIES: [f64; 2] = [10.0, 1000.0];
/// Coefficients are at most this, in parts of half the range.
const LARGEST: f64 = 3.0;
/// Limits are penalties: no constraint is given to the minimiser.
type Constraint = fn(&[f64], Option<&mut [f64]>, &mut ()) -> f64;

/// What motions cost that do not tell everything.
const NOTHING: f64 = 1e3;

/// What is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Shape of the trajectories.
    pub family: Family,
    /// s.
    pub duration: f64,
    /// Part of every limit that is left unused.
    pub margin: f64,
    /// What is made small.
    pub criterion: Criterion,
    /// Of the regressor's columns, for condition numbers.
    pub scaling: Scaling,
    /// Of the random starts.
    pub seed: u64,
    /// Number of starts.
    pub starts: usize,
    /// Most evaluations of the cost in one start.
    pub evaluations: usize,
    /// After this the best so far is the answer.
    pub time_limit: Option<Duration>,
}

/// Why a search ended before it was through: another run may answer otherwise then.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Early {
    /// The request's time limit passed.
    OutOfTime,
    /// Whoever waits asked for the best so far.
    Interrupted,
}

impl std::fmt::Display for Early {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::OutOfTime => "time ran out",
            Self::Interrupted => "interrupted",
        })
    }
}

/// A motion and how it was found.
#[derive(Debug, Clone)]
pub struct Designed {
    /// Functions of time.
    pub basis: Basis,
    /// As [`Machine::coefficients`].
    pub coefficients: Vec<f64>,
    /// Number of unknowns that it tells.
    pub unknowns: usize,
    /// Of the first random motion that keeps the limits.
    pub before: MotionQuality,
    /// Of the answer.
    pub after: MotionQuality,
    /// Largest values of each moving joint, at samples much finer than its fastest wave.
    pub peaks: Vec<Peaks>,
    /// Least distance of the feet at these samples, m, where they are kept apart.
    pub feet_distance: Option<f64>,
    /// Starts that were made; the last one may have been broken off.
    pub starts: usize,
    /// Evaluations of cost and gradient.
    pub evaluations: usize,
    /// Why starts are missing, or the last one was broken off.
    pub early: Option<Early>,
}

/// What a motion is wanted for.
pub(super) trait Objective {
    /// What a motion is worth.
    type Quality: Copy;
    /// Of a motion that is judged.
    fn quality(&self, motion: &Trajectory) -> Result<Self::Quality, Diagnostic>;
    /// The smooth cost and its derivatives by positions, velocities and accelerations, laid out like them; `None`
    /// where it is infinite.
    fn cost(&self, motion: &Trajectory) -> Result<Option<(f64, Trajectory)>, Diagnostic>;
    /// Whether the first is worth more.
    fn better(&self, one: &Self::Quality, other: &Self::Quality) -> bool;
}

/// Telling the inertial parameters.
struct Telling<'r, 'm> {
    regression: Regression<'r, 'm>,
    request: &'r Request,
}

impl Objective for Telling<'_, '_> {
    type Quality = MotionQuality;

    fn quality(&self, motion: &Trajectory) -> Result<MotionQuality, Diagnostic> {
        Ok(self.regression.quality(motion))
    }

    fn cost(&self, motion: &Trajectory) -> Result<Option<(f64, Trajectory)>, Diagnostic> {
        Ok(self.regression.cost(motion, self.request.criterion, self.request.scaling))
    }

    fn better(&self, one: &MotionQuality, other: &MotionQuality) -> bool {
        match self.request.criterion {
            Criterion::Condition => match self.request.scaling {
                Scaling::Unit => one.condition_number < other.condition_number,
                Scaling::Own => one.unscaled_condition_number < other.unscaled_condition_number,
            },
            Criterion::Information => one.log_determinant > other.log_determinant,
        }
    }
}

/// Looks for the motion that tells most and keeps all limits; `progress` hears which part is done.
///
/// Several random starts, each minimised (SLSQP, Kraft 1988) with limits as growing penalties, then made to keep its
/// limits exactly. Equal requests give equal answers unless time ran out.
///
/// # Errors
/// Limits that no motion keeps; requests without meaning; errors of the model.
pub fn design(
    machine: &Machine<'_>,
    request: &Request,
    progress: &dyn Fn(f64),
    stop: &dyn Fn() -> bool,
) -> Result<Designed, Diagnostic> {
    check(request)?;
    machine.check()?;
    // Always the same: which unknowns there are does not depend on the seed.
    let mut probe = Random::new(0x1dea);
    let telling = Telling { regression: Regression::new(machine, &mut || probe.symmetric()), request };
    let found = best(machine, &telling, request, progress, stop)?;
    if !found.after.condition_number.is_finite() {
        return Err(Diagnostic::error("no motion that keeps the limits tells all parameters")
            .help("widen the limits, or give a longer --duration or more --harmonics"));
    }
    Ok(Designed {
        basis: found.basis,
        coefficients: found.coefficients,
        unknowns: telling.regression.unknowns(),
        before: found.before,
        after: found.after,
        peaks: found.peaks,
        feet_distance: found.feet_distance,
        starts: found.starts,
        evaluations: found.evaluations,
        early: found.early,
    })
}

/// A motion, what it is worth, and how it was found.
pub(super) struct Best<Q> {
    pub basis: Basis,
    pub coefficients: Vec<f64>,
    /// Of the first random motion that keeps the limits.
    pub before: Q,
    pub after: Q,
    pub peaks: Vec<Peaks>,
    pub feet_distance: Option<f64>,
    pub starts: usize,
    pub evaluations: usize,
    pub early: Option<Early>,
}

/// The motion that serves an objective best; request and machine were checked.
pub(super) fn best<O: Objective>(
    machine: &Machine<'_>,
    objective: &O,
    request: &Request,
    progress: &dyn Fn(f64),
    stop: &dyn Fn() -> bool,
) -> Result<Best<O::Quality>, Diagnostic> {
    let mut random = Random::new(request.seed);
    let basis = Basis::new(request.family, request.duration);
    let (evaluations, early, begun) = (Cell::new(0), Cell::new(None), Instant::now());
    let search = Search { machine, request, basis, objective, stop, begun, evaluations, early };
    let (mut first, mut best, mut refused) = (None, None::<(O::Quality, Vec<f64>)>, None::<Obstacle>);
    let mut starts = 0;
    for start in 0..request.starts {
        let guess = guess(machine, &search.basis, &mut random);
        let report = |part: f64| progress(search.part(start, part));
        for (optimised, x) in [(false, guess.clone()), (true, search.minimised(&guess, &report)?)] {
            match search.judged(&x)? {
                Ok((quality, x)) => {
                    if !optimised {
                        first.get_or_insert(quality);
                    }
                    if best.as_ref().is_none_or(|(other, _)| objective.better(&quality, other)) {
                        best = Some((quality, x));
                    }
                }
                Err(obstacle) => refused = Some(refused.map_or(obstacle, |other| other.lesser(obstacle))),
            }
        }
        starts += 1;
        if starts < request.starts && search.ends_early() {
            break;
        }
    }
    let (after, coefficients) = best.ok_or_else(|| search.impossible(refused))?;
    let (evaluations, early) = (search.evaluations.get(), search.early.get());
    let motion = machine.motion(&search.basis, &coefficients, fine(&search.basis));
    let (peaks, feet_distance) =
        (peaks(machine, &motion)?, machine.clearance.map(|clearance| clearance.distance(&motion)));
    let (basis, before) = (search.basis, first.unwrap_or(after));
    Ok(Best { basis, coefficients, before, after, peaks, feet_distance, starts, evaluations, early })
}

/// Random coefficients of a motion of moderate size.
pub(super) fn guess(machine: &Machine<'_>, basis: &Basis, random: &mut Random) -> Vec<f64> {
    let m = basis.len();
    (0..machine.coefficients(basis))
        .map(|k| if k % m == 0 { 0.4 } else { 0.6 } * random.symmetric())
        .collect()
}

/// Requests without meaning.
pub(super) fn check(request: &Request) -> Result<(), Diagnostic> {
    let refuse = |what: String, help: &str| Err(Diagnostic::error(what).help(help.to_owned()));
    if !(request.duration.is_finite() && request.duration > 0.0) {
        return refuse(
            format!("the duration is {} s", request.duration),
            "give a time above 0 s; 10 s is usual",
        );
    }
    if !(0.0..=0.9).contains(&request.margin) {
        return refuse(
            format!("the margin is {}", request.margin),
            "give a part of the limits between 0 and 0.9",
        );
    }
    let (count, least) = match request.family {
        Family::Polynomial(degree) => (degree, 2),
        Family::RestingPolynomial(degree) => (degree, 3),
        Family::Fourier(harmonics) => (harmonics, 2),
    };
    if !(least..=50).contains(&count) {
        return refuse(format!("{count} harmonics or degrees"), "give a number from 2 to 50; 5 is usual");
    }
    if !(1..=10_000).contains(&request.starts) || !(1..=1_000_000).contains(&request.evaluations) {
        return refuse(
            format!("{} starts with {} evaluations", request.starts, request.evaluations),
            "give 1 to 10000 starts and at most a million evaluations",
        );
    }
    Ok(())
}

/// What a motion that keeps its limits is worth, and its coefficients.
type Judged<Q> = Result<(Q, Vec<f64>), Obstacle>;

struct Search<'r, 'm, O> {
    machine: &'r Machine<'m>,
    request: &'r Request,
    basis: Basis,
    objective: &'r O,
    /// Whether the best so far shall be the answer.
    stop: &'r dyn Fn() -> bool,
    begun: Instant,
    evaluations: Cell<usize>,
    /// The first reason not to go on that was met where there was something left to do.
    early: Cell<Option<Early>>,
}

impl<O: Objective> Search<'_, '_, O> {
    /// Whether to end here, asked before more is done. The first reason is kept.
    fn ends_early(&self) -> bool {
        if self.early.get().is_none() {
            let late = self.request.time_limit.is_some_and(|limit| self.begun.elapsed() >= limit);
            let reason = late.then_some(Early::OutOfTime);
            self.early.set(if (self.stop)() { Some(Early::Interrupted) } else { reason });
        }
        self.early.get().is_some()
    }

    /// Which part of the search is done, of starts or of time.
    fn part(&self, start: usize, within: f64) -> f64 {
        let starts = (start as f64 + within) / self.request.starts as f64;
        let limit = self.request.time_limit.map_or(f64::INFINITY, |limit| limit.as_secs_f64());
        starts.max(self.begun.elapsed().as_secs_f64() / limit).min(1.0)
    }

    /// The motion that keeps its limits, and what it is worth.
    fn judged(&self, x: &[f64]) -> Result<Judged<O::Quality>, Diagnostic> {
        match kept(self.machine, &self.basis, x, self.request.margin)? {
            Ok(x) => {
                // More than the search has, so that both ends count no more than other times.
                let motion = self.machine.motion(&self.basis, &x, 8 * self.basis.samples());
                Ok(Ok((self.objective.quality(&motion)?, x)))
            }
            Err(obstacle) => Ok(Err(obstacle)),
        }
    }

    /// The best that one start leads to.
    fn minimised(&self, guess: &[f64], progress: &dyn Fn(f64)) -> Result<Vec<f64>, Diagnostic> {
        let mut x = guess.to_vec();
        let bounds = vec![(-LARGEST, LARGEST); x.len()];
        let each = self.request.evaluations.div_ceil(PENALTIES.len());
        for (round, penalty) in PENALTIES.into_iter().enumerate() {
            let best = RefCell::new((f64::INFINITY, x.clone()));
            let failure = RefCell::new(None);
            let done = Cell::new(0_usize);
            let cost = |x: &[f64], gradient: Option<&mut [f64]>, (): &mut ()| {
                // What is left of the run costs nothing then.
                if self.ends_early() || failure.borrow().is_some() {
                    gradient.into_iter().for_each(|gradient| gradient.fill(0.0));
                    return best.borrow().0.min(NOTHING);
                }
                done.set(done.get() + 1);
                progress(
                    (round as f64 + (done.get() as f64 / each as f64).min(1.0)) / PENALTIES.len() as f64,
                );
                let (value, slopes) = self.cost(x, penalty).unwrap_or_else(|error| {
                    failure.replace(Some(error));
                    (NOTHING, vec![0.0; x.len()])
                });
                if value < best.borrow().0 {
                    best.replace((value, x.to_vec()));
                }
                if let Some(gradient) = gradient {
                    gradient.copy_from_slice(&slopes);
                }
                value
            };
            let tolerances = StopTols { ftol_abs: 1e-5, ..StopTols::default() };
            // The best is kept here, however the run ends.
            let _ = minimize(cost, &x, &bounds, &[] as &[Constraint], (), each, Some(tolerances));
            if let Some(error) = failure.into_inner() {
                return Err(error);
            }
            x = best.into_inner().1;
        }
        Ok(x)
    }

    /// The smooth cost with limits as penalties, and its derivatives by the coefficients.
    fn cost(&self, x: &[f64], penalty: f64) -> Result<(f64, Vec<f64>), Diagnostic> {
        self.evaluations.set(self.evaluations.get() + 1);
        let motion = self.machine.motion(&self.basis, x, self.basis.samples());
        let (over, of_limits) = excess(self.machine, &motion, self.request.margin)?;
        let Some((cost, mut slopes)) = self.objective.cost(&motion)? else {
            return Ok((NOTHING, vec![0.0; x.len()]));
        };
        let pairs =
            [(&mut slopes.q, &of_limits.q), (&mut slopes.v, &of_limits.v), (&mut slopes.a, &of_limits.a)];
        for (slopes, limits) in pairs {
            slopes.iter_mut().zip(limits).for_each(|(slope, limit)| *slope += penalty * limit);
        }
        Ok((cost + penalty * over, self.by_coefficients(&slopes)))
    }

    /// Derivatives by states to derivatives by coefficients.
    fn by_coefficients(&self, slopes: &Trajectory) -> Vec<f64> {
        let (m, joints) = (self.basis.len(), self.machine.layout.joints.len());
        let mut gradient = vec![0.0; self.machine.coefficients(&self.basis)];
        for i in 0..slopes.len() {
            let functions = self.basis.at(self.basis.duration() * i as f64 / (slopes.len() - 1) as f64);
            for (k, &joint) in self.machine.moving.iter().enumerate() {
                let at = i * joints + joint;
                let slope =
                    [slopes.q[at], slopes.v[at], slopes.a[at]].map(|s| s * self.machine.limits[k].room());
                for (f, gradient) in gradient[k * m..][..m].iter_mut().enumerate() {
                    *gradient += dot(&slope, &[functions[0][f], functions[1][f], functions[2][f]]);
                }
            }
        }
        gradient
    }

    fn impossible(&self, refused: Option<Obstacle>) -> Diagnostic {
        let (joint, needed, limit) = match refused {
            None => return Diagnostic::error("no motion was found"),
            Some(Obstacle::Feet(distance)) => {
                let least = self.machine.clearance.map_or(0.0, Clearance::least);
                return Diagnostic::error(format!(
                    "no motion keeps the feet {least} m apart: in the easiest posture tried they are {distance:.4} m apart"
                ))
                .help("ask for a smaller distance, or for --joints of one leg");
            }
            Some(Obstacle::Overload { joint, effort: (needed, limit) }) => (joint, needed, limit),
        };
        let joint = &self.machine.layout.joints[self.machine.moving[joint]];
        let unit = joint.unit();
        Diagnostic::error(format!(
            "no motion keeps the limits: merely holding still in the easiest posture tried, joint `{}` needs {needed:.3} {unit}, and {limit:.3} {unit} are left of its limit",
            joint.name
        ))
        .help("raise the effort limit, lower the margin, or keep joints in postures that load it less")
    }
}

impl Obstacle {
    /// The one that is easier to overcome; efforts before feet, since a posture is judged by its feet first.
    fn lesser(self, other: Self) -> Self {
        let better = match (self, other) {
            (Self::Overload { effort: own, .. }, Self::Overload { effort, .. }) => {
                effort.0 / effort.1 < own.0 / own.1
            }
            (Self::Feet(own), Self::Feet(distance)) => distance > own,
            (Self::Feet(_), Self::Overload { .. }) => true,
            (Self::Overload { .. }, Self::Feet(_)) => false,
        };
        if better { other } else { self }
    }
}
