//! Robots that stand on the ground in a log that does not say so: without columns of the base the trunk is taken as held.
//!
//! What the ground carries is, to the joints of a held robot, a mass below nothing at the last body of a leg: its weight pulls up. Where such masses explain
//! most of what the model misses, and come to about the robot's own in sum, it stands.
use super::hypothesis::View;
use super::{Evidence, list, quantile};
use crate::number::counting;
use bipedc_effects::diagnostic::Diagnostic;
use nalgebra::{DMatrix, DVector};
use std::ops::Range;

/// Mass and first moment of a body.
const OF_BODY: usize = 4;
/// Parts of a log by which loads may shift from foot to foot.
const WINDOWS: usize = 30;
/// Part of what the model misses that may be left.
const LEFT: f64 = 0.3;
/// What is carried in parts of the robot's mass, in half of all windows: others are those of steps.
const CARRIED: (f64, f64) = (0.7, 1.3);
/// A foot carries more than this part of it.
const FOOT: f64 = 0.05;
/// Part of the squares that numbers as large as can be expected may cost: a robot that hardly moves tells little of where its feet push.
const PRIOR: f64 = 1e-3;

/// An error where the log is one of a robot that stands.
pub(super) fn check(evidence: &Evidence<'_>, view: &View) -> Option<Diagnostic> {
    let total: f64 = evidence.links.links.iter().map(|link| link.mass).sum();
    let carried = carried(evidence, view, total)?;
    let is_foot = |carries: &&(usize, f64)| carries.1 > FOOT * total;
    let name = |(body, _): &(usize, f64)| evidence.links.bodies.get(*body).map(String::as_str);
    let kilograms: f64 = carried.iter().map(|(_, mass)| mass).sum();
    let message = format!(
        "the robot stands: the ground carries about {} kg at {}, but the log has no columns of its base, so that the trunk is taken as held",
        counting(kilograms, 2),
        list(carried.iter().filter(is_foot).filter_map(name))
    );
    let help = "log base/position, base/orientation and what the feet's sensors say (docs/logs.md), or record a motion with the trunk held";
    Some(Diagnostic::error(message).help(help))
}

/// Mass that the ground carries at each last body in the middle of all windows, kg; `None` unless that explains the torques and is about the robot's own.
fn carried(evidence: &Evidence<'_>, view: &View, total: f64) -> Option<Vec<(usize, f64)>> {
    let moments = Moments::of(evidence, view)?;
    let last = moments.last_bodies();
    let window = moments.states / WINDOWS;
    let (mut loads, mut left, mut squares) = (Vec::new(), 0.0, 0.0);
    for start in (0..WINDOWS).map(|index| index * window) {
        let equations = Equations::of(view, (&moments, &last), start..start + window);
        let (found, misses) = equations.solved(total)?;
        loads.push(found);
        left += misses;
        squares += equations.squares;
    }
    let part = |part: f64, of: &dyn Fn(&Vec<f64>) -> f64| {
        quantile(&mut loads.iter().map(of).collect::<Vec<_>>(), part)
    };
    let sum = |loads: &Vec<f64>| loads.iter().sum::<f64>() / total;
    let is_own =
        [0.25, 0.75].into_iter().all(|quarter| (CARRIED.0..=CARRIED.1).contains(&part(quarter, &sum)));
    let middle = |index: usize| part(0.5, &|loads: &Vec<f64>| loads[index]);
    (left < LEFT * squares && is_own)
        .then(|| last.iter().enumerate().map(|(index, &body)| (body, middle(index))).collect())
}

/// What some samples say of masses and first moments of the last bodies.
struct Equations {
    gram: DMatrix<f64>,
    right: DVector<f64>,
    squares: f64,
}

impl Equations {
    fn of(view: &View, (moments, last): (&Moments, &[usize]), samples: Range<usize>) -> Self {
        let size = OF_BODY * last.len();
        let (mut gram, mut right, mut squares) = (DMatrix::zeros(size, size), DVector::zeros(size), 0.0);
        for joint in view.joints() {
            let loads: Vec<f64> = view.motion.of_joint(&view.load, joint).collect();
            for state in samples.clone() {
                let of = |index: usize| moments.at(state, last[index / OF_BODY], index % OF_BODY, joint);
                let x = DVector::from_fn(size, |index, _| of(index));
                let y = view.effort[joint][state] - loads[state];
                gram.ger(1.0, &x, &x, 1.0);
                right.axpy(y, &x, 1.0);
                squares += y * y;
            }
        }
        Self { gram, right, squares }
    }

    /// Mass that is carried at each body, kg, and the squares that this leaves.
    fn solved(&self, total: f64) -> Option<(Vec<f64>, f64)> {
        let Self { gram, right, squares } = self;
        let found = self.with_prior(total).lu().solve(right)?;
        let left = squares - 2.0 * found.dot(right) + (gram * &found).dot(&found);
        Some((found.iter().step_by(OF_BODY).map(|mass| -mass).collect(), left))
    }

    /// Masses of about the robot's on levers that are as long as its own are what is expected.
    fn with_prior(&self, mass: f64) -> DMatrix<f64> {
        let gram = &self.gram;
        let sum = |of_mass: bool| -> f64 {
            (0..gram.nrows()).filter(|k| k.is_multiple_of(OF_BODY) == of_mass).map(|k| gram[(k, k)]).sum()
        };
        // Torques of masses over those of first moments.
        let lever = (3.0 * sum(true) / sum(false).max(f64::MIN_POSITIVE)).sqrt();
        let expected = |k: usize| if k.is_multiple_of(OF_BODY) { mass } else { mass * lever };
        let cost = |k: usize| PRIOR * self.squares / expected(k).powi(2).max(f64::MIN_POSITIVE);
        gram + DMatrix::from_diagonal(&DVector::from_fn(gram.nrows(), |k, _| {
            cost(k) + 1e-9 * gram[(k, k)] + f64::MIN_POSITIVE
        }))
    }
}

/// Torques of a unit of mass and of first moment of each body.
struct Moments {
    values: Vec<f64>,
    bodies: usize,
    nv: usize,
    first: usize,
    joints: usize,
    states: usize,
}

impl Moments {
    fn of(evidence: &Evidence<'_>, view: &View) -> Option<Self> {
        let (nv, joints) = (view.motion.nv(), view.effort.len());
        let states = view.motion.v.len() / nv.max(1);
        let values = (evidence.moments)(&view.motion);
        let bodies = values.len() / (OF_BODY * states * nv).max(1);
        (bodies > 0).then_some(Self { values, bodies, nv, first: nv - joints, joints, states })
    }

    fn at(&self, state: usize, body: usize, k: usize, joint: usize) -> f64 {
        self.values[((state * self.bodies + body) * OF_BODY + k) * self.nv + self.first + joint]
    }

    /// Bodies that move by joints by which no other one moves further.
    fn last_bodies(&self) -> Vec<usize> {
        let moves = |body: usize, joint: usize| {
            (0..self.states).any(|state| (0..OF_BODY).any(|k| self.at(state, body, k, joint) != 0.0))
        };
        let by: Vec<Vec<bool>> =
            (0..self.bodies).map(|body| (0..self.joints).map(|joint| moves(body, joint)).collect()).collect();
        let count = |body: usize| by[body].iter().filter(|moves| **moves).count();
        let holds = |other: usize, body: usize| by[body].iter().zip(&by[other]).all(|(b, o)| !b || *o);
        let is_last = |body: &usize| {
            count(*body) > 0
                && (0..self.bodies).all(|other| !holds(other, *body) || count(other) == count(*body))
        };
        (0..self.bodies).filter(is_last).collect()
    }
}
