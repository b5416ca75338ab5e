//! Motions that tell two effects apart.
//!
//! Let Z_A and Z_B be what two effects do to the measured torques along a motion, one column per parameter that enters
//! linearly. The largest canonical correlation ρ of the two spaces is that of the pair of effects that look most alike;
//! its angle θ = acos ρ is made large. If the bodies' inertial parameters are free too, both are seen beside the space
//! of their columns. Effects that stay below the noise tell nothing either, so what is made small is
//! `−ln sin θ + ½ ln(1 + σ²/r_A²) + ½ ln(1 + σ²/r_B²)` with r the effective torques of the effects at usual values and
//! σ the noise: minus the logarithm of the part of an effect that shows.
mod angle;
mod columns;
mod objective;
#[cfg(test)]
mod tests;

pub use columns::Candidate;
pub use objective::Separation;

use super::basis::Basis;
use super::search::{best, check, guess};
use super::{Early, Machine, Peaks, Request};
use crate::robot::{JointLayout, LinkInertias};
use angle::{Layout, View, independent, lengths};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::Effect;
use bipedc_effects::random::Random;
use bipedc_runtime::model::Model;
use columns::{Bench, Columns};
use nalgebra::DMatrix;
use objective::Apart;

/// Random motions on which is decided what no motion can tell.
const MOTIONS: usize = 4;
/// Parts of a column's length below this are rounding.
const LEAST: f64 = 1e-6;

/// Two effects of a robot.
pub struct Pair<'a> {
    /// The rigid robot, with functions `inverse_dynamics` and `inverse_dynamics_regressor`.
    pub model: &'a (dyn Model<f64> + Sync),
    /// Of that model: the machine's joints, on a fixed base or on one that stays at rest (then the world may turn).
    pub layout: &'a JointLayout,
    /// Of that model.
    pub link_inertias: &'a LinkInertias,
    /// Effects of the description.
    pub present: &'a [Effect],
    /// Joints whose torque is measured.
    pub measured: &'a [usize],
    /// The two.
    pub effects: [Candidate; 2],
    /// Whether the bodies' inertial parameters are free too.
    pub beside_bodies: bool,
    /// Standard deviation of a measured torque, N m (N of joints that slide).
    pub noise: f64,
}

/// A motion and how well it tells the two apart.
#[derive(Debug, Clone)]
pub struct Separating {
    /// Functions of time.
    pub basis: Basis,
    /// As [`Machine::coefficients`].
    pub coefficients: Vec<f64>,
    /// Independent columns of each effect.
    pub columns: [usize; 2],
    /// Independent columns of the bodies.
    pub body_columns: usize,
    /// Combinations of parameters that the two have in common along every motion of these joints; they do not count.
    pub common: usize,
    /// Of the first random motion that keeps the limits.
    pub before: Separation,
    /// Of the answer.
    pub after: Separation,
    /// Largest values of each moving joint.
    pub peaks: Vec<Peaks>,
    /// Least distance of the feet, m, where they are kept apart.
    pub feet_distance: Option<f64>,
    /// Starts that were made.
    pub starts: usize,
    /// Evaluations of cost and gradient.
    pub evaluations: usize,
    /// As of [`Designed`](super::Designed).
    pub early: Option<Early>,
}

/// Combinations of columns that count.
struct Reduced {
    pub effects: [DMatrix<f64>; 2],
    pub beside: DMatrix<f64>,
    pub layout: Layout,
}

/// Looks for the motion that best tells two effects apart and keeps all limits; search, starts and limits are those of
/// [`design`](super::design()), whose criterion and scaling play no part.
///
/// # Errors
/// Effects that no motion of these joints shows, or tells apart; those of [`design`](super::design()).
pub fn separate(
    machine: &Machine<'_>,
    pair: &Pair<'_>,
    request: &Request,
    progress: &dyn Fn(f64),
    stop: &dyn Fn() -> bool,
) -> Result<Separating, Diagnostic> {
    check(request)?;
    machine.check()?;
    if !(pair.noise.is_finite() && pair.noise > 0.0) {
        return Err(Diagnostic::error(format!("the noise of torques is {} N m", pair.noise))
            .help("give its standard deviation, above 0 N m"));
    }
    if pair.effects[0].usual == pair.effects[1].usual {
        return Err(Diagnostic::error(format!("{} is the same effect twice", pair.effects[0].usual))
            .help("name two kinds, or two places"));
    }
    let bench = Bench::new(machine, pair, request.duration);
    let reduced = reduced(&bench, request)?;
    let layout = reduced.layout;
    let apart = Apart::new(bench, reduced);
    let found = best(machine, &apart, request, progress, stop)?;
    Ok(Separating {
        basis: found.basis,
        coefficients: found.coefficients,
        columns: layout.effects,
        body_columns: layout.beside,
        common: layout.common,
        before: found.before,
        after: found.after,
        peaks: found.peaks,
        feet_distance: found.feet_distance,
        starts: found.starts,
        evaluations: found.evaluations,
        early: found.early,
    })
}

/// What is independent along random motions, which do not depend on the seed.
fn reduced(bench: &Bench<'_, '_>, request: &Request) -> Result<Reduced, Diagnostic> {
    let (machine, pair) = (bench.machine, bench.pair);
    let basis = Basis::new(request.family, request.duration);
    let mut random = Random::new(0x1dea);
    let mut parts = Vec::new();
    for _ in 0..MOTIONS {
        let x = guess(machine, &basis, &mut random);
        parts.push(bench.columns(&machine.motion(&basis, &x, basis.samples()))?);
    }
    let all = |of: &dyn Fn(&Columns) -> &DMatrix<f64>| stacked(&parts.iter().map(of).collect::<Vec<_>>());
    let bodies = all(&|columns| &columns.beside);
    let nothing = DMatrix::zeros(bodies.nrows(), 0);
    let beside = independent(&bodies, &nothing, LEAST);
    let bodies = bodies * &beside;
    let mut effects = [DMatrix::zeros(0, 0), DMatrix::zeros(0, 0)];
    let mut kept = [nothing.clone(), nothing];
    for which in 0..2 {
        let columns = all(&|columns| &columns.effects[which]);
        effects[which] = independent(&columns, &bodies, LEAST);
        if effects[which].ncols() == 0 {
            return Err(unseen(&pair.effects[which].usual, lengths(&columns).iter().any(|l| *l > 0.0)));
        }
        kept[which] = columns * &effects[which];
    }
    let [first, second] = kept.each_ref().map(|columns| columns.ncols());
    let mut layout = Layout { effects: [first, second], beside: bodies.ncols(), common: 0 };
    let [first, second] = kept;
    let view = View::new(&beside_each_other(&[&first, &second, &bodies]), layout);
    let view = view.ok_or_else(|| Diagnostic::error("the torques of random motions are no numbers"))?;
    let least = layout.effects[0].min(layout.effects[1]);
    layout.common = (0..least).filter(|&k| view.pair(k).is_some_and(|(.., sine)| sine < LEAST)).count();
    if layout.common == least {
        return Err(alike(pair, layout));
    }
    Ok(Reduced { effects, beside, layout })
}

fn stacked(parts: &[&DMatrix<f64>]) -> DMatrix<f64> {
    let rows: usize = parts.iter().map(|part| part.nrows()).sum();
    let mut all = DMatrix::zeros(rows, parts.first().map_or(0, |part| part.ncols()));
    let mut at = 0;
    for part in parts {
        all.rows_mut(at, part.nrows()).copy_from(part);
        at += part.nrows();
    }
    all
}

fn beside_each_other(parts: &[&DMatrix<f64>]) -> DMatrix<f64> {
    let columns: usize = parts.iter().map(|part| part.ncols()).sum();
    let mut all = DMatrix::zeros(parts.first().map_or(0, |part| part.nrows()), columns);
    let mut at = 0;
    for part in parts {
        all.columns_mut(at, part.ncols()).copy_from(part);
        at += part.ncols();
    }
    all
}

/// Of an effect without columns of its own.
fn unseen(effect: &Effect, acts: bool) -> Diagnostic {
    if acts {
        return Diagnostic::error(format!(
            "{effect} changes no torque in a way that the bodies' inertial parameters could not"
        ))
        .help("ask without --beside-bodies, or measure more joints");
    }
    Diagnostic::error(format!("{effect} changes no measured torque along any motion of these joints"))
        .help("let other joints move with --joints, or hang the robot at another link with --root")
}

/// Of two effects of which one can do all that the other does.
fn alike(pair: &Pair<'_>, layout: Layout) -> Diagnostic {
    let [first, second] = pair.effects.each_ref().map(|effect| effect.usual.to_string());
    let beside = if pair.beside_bodies { ", beside the bodies' inertial parameters" } else { "" };
    let why = match layout.effects {
        [one, two] if one == two => {
            format!("the two change torques in the same {one} way{}", if one == 1 { "" } else { "s" })
        }
        [one, two] if one < two => format!("whatever {first} does to torques, {second} can do too"),
        _ => format!("whatever {second} does to torques, {first} can do too"),
    };
    Diagnostic::error(format!(
        "no motion of these joints tells {first} from {second}: their canonical correlation is 1 along every motion{beside}; {why}"
    ))
    .help("let other joints move with --joints, change the load or the root, or measure something else: bipedc effects says what tells them apart")
}
