//! Down to the postures that tell most: barriers and a quasi-Newton method on the surface of flat soles.
use super::problem::{Direction, Point, Problem};
use super::surface::Tangent;
use nalgebra::DVector;
use std::cell::Cell;
use std::collections::VecDeque;

/// How much coming near a limit costs, from round to round of one start.
const BARRIERS: [f64; 4] = [1e-3, 1e-4, 1e-5, 1e-6];
/// Pairs that the quasi-Newton method remembers.
const MEMORY: usize = 20;
/// Largest motion in one step, rad or m.
const LARGEST: f64 = 0.2;
/// Part of the expected fall that a step must reach (Armijo).
const FALL: f64 = 1e-4;
/// Halvings of a step.
const HALVINGS: usize = 30;
/// A round ends when its last ten steps together fall by less.
const STALLED: f64 = 1e-5;
/// One start's way down.
pub(super) struct Descent<'p, 's, 'm> {
    pub problem: &'p Problem<'s, 'm>,
    /// Evaluations that are left.
    pub left: Cell<usize>,
    pub stop: &'p dyn Fn() -> bool,
}

/// Where a descent is.
struct Place {
    point: Point,
    cost: f64,
    tangents: Vec<Tangent>,
    gradient: DVector<f64>,
}

impl Descent<'_, '_, '_> {
    pub fn minimised(&self, begin: &Point, budget: usize, progress: &dyn Fn(f64)) -> Point {
        let mut best = begin.clone();
        for (round, barrier) in BARRIERS.into_iter().enumerate() {
            // The last round may use what the others left.
            let keep = budget * (BARRIERS.len() - 1 - round) / BARRIERS.len();
            let report = || progress(1.0 - self.left.get() as f64 / budget.max(1) as f64);
            best = self.round(best, barrier, keep, &report);
        }
        best
    }

    fn place(&self, point: Point, barrier: f64) -> Option<Place> {
        let (cost, slope) = self.evaluated(&point, barrier)?;
        let tangents = self.problem.tangents(&point)?;
        let gradient = slope.pulled_back(&tangents, &point.of);
        Some(Place { point, cost, tangents, gradient })
    }

    fn evaluated(&self, point: &Point, barrier: f64) -> Option<(f64, Direction)> {
        self.left.set(self.left.get().saturating_sub(1));
        self.problem.slopes(point, barrier)
    }

    fn round(&self, begin: Point, barrier: f64, keep: usize, report: &dyn Fn()) -> Point {
        let Some(mut here) = self.place(begin.clone(), barrier) else { return begin };
        let mut memory: VecDeque<(Direction, Direction)> = VecDeque::new();
        let mut costs = vec![here.cost];
        while self.left.get() > keep && !(self.stop)() {
            report();
            let placements = here.point.placements.len();
            let mut x = two_loops(&here.gradient, &memory, &here.tangents);
            let slope = x.dot(&here.gradient);
            if slope.is_nan() || slope >= 0.0 {
                memory.clear();
                x = -&here.gradient;
            }
            let direction = Direction::of_coordinates(&x, &here.tangents, &here.point.of, placements);
            let expected = x.dot(&here.gradient);
            let Some((step, next)) = self.stepped(&here, &direction, expected, barrier) else {
                if memory.is_empty() {
                    break;
                }
                memory.clear();
                continue;
            };
            let old = Direction::of_coordinates(&here.gradient, &here.tangents, &here.point.of, placements);
            let new = Direction::of_coordinates(&next.gradient, &next.tangents, &next.point.of, placements);
            memory.push_back((direction.times(step), new.minus(&old)));
            if memory.len() > MEMORY {
                memory.pop_front();
            }
            here = next;
            costs.push(here.cost);
            if costs.len() > 10 && costs[costs.len() - 11] - here.cost < STALLED {
                break;
            }
        }
        here.point
    }

    /// The first step along the direction, halved again and again, that falls enough.
    fn stepped(
        &self,
        here: &Place,
        direction: &Direction,
        expected: f64,
        barrier: f64,
    ) -> Option<(f64, Place)> {
        let mut step = (LARGEST / direction.largest().max(f64::MIN_POSITIVE)).min(1.0);
        for _ in 0..HALVINGS {
            if let Some(point) = self.problem.moved(&here.point, direction, step) {
                let next = self.place(point, barrier);
                if let Some(next) = next.filter(|next| next.cost < here.cost + FALL * step * expected) {
                    return Some((step, next));
                }
            }
            if self.left.get() == 0 || (self.stop)() {
                return None;
            }
            step *= 0.5;
        }
        None
    }
}

impl Direction {
    fn times(&self, factor: f64) -> Self {
        Self {
            placements: self.placements.iter().map(|p| p.map(|x| factor * x)).collect(),
            joints: self.joints.iter().map(|q| q * factor).collect(),
        }
    }

    fn minus(&self, other: &Self) -> Self {
        let placed = self.placements.iter().zip(&other.placements);
        Self {
            placements: placed.map(|(a, b)| [0, 1, 2].map(|k| a[k] - b[k])).collect(),
            joints: self.joints.iter().zip(&other.joints).map(|(a, b)| a - b).collect(),
        }
    }
}

/// Minus the approximate inverse of the second derivatives times the gradient; remembered pairs are carried to the
/// present point's surface by projection.
fn two_loops(
    gradient: &DVector<f64>,
    memory: &VecDeque<(Direction, Direction)>,
    tangents: &[Tangent],
) -> DVector<f64> {
    let pairs: Vec<(DVector<f64>, DVector<f64>, f64)> = memory
        .iter()
        .filter_map(|(s, y)| {
            let (s, y) = (s.coordinates(tangents), y.coordinates(tangents));
            let product = s.dot(&y);
            (product > 1e-12 * s.norm() * y.norm()).then(|| (s, y, 1.0 / product))
        })
        .collect();
    let mut x = -gradient;
    let mut factors = Vec::with_capacity(pairs.len());
    for (s, y, rho) in pairs.iter().rev() {
        let factor = rho * s.dot(&x);
        x.axpy(-factor, y, 1.0);
        factors.push(factor);
    }
    match pairs.last() {
        Some((_, y, rho)) => x *= 1.0 / (rho * y.norm_squared()),
        None => x *= LARGEST / gradient.amax().max(f64::MIN_POSITIVE),
    }
    for ((s, y, rho), factor) in pairs.iter().zip(factors.into_iter().rev()) {
        let back = rho * y.dot(&x);
        x.axpy(factor - back, s, 1.0);
    }
    x
}
