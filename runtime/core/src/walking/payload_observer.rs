//! A payload on the root link found while the robot walks: recursive least squares with forgetting.
//!
//! Vertical momentum and the angular momentum about a point of the ground change by what the soles give and by gravity; forces along level ground have no
//! part in it. Filtered on both sides, (s/(s + λ)) p = (λ/(s + λ)) w, this needs no accelerations. What the model cannot account for is linear in mass and
//! first moment of a payload: the columns of the root's own link in the momentum's regressor (its inertia left out).
use super::payload::{Payload, twist};
use super::space::{Pose, Vector, add, along, cross, subtract, turned, zero};
use crate::control::slices::{get, set};
use crate::real::Scalar;

/// Mass and first moment.
const UNKNOWNS: usize = 4;
/// Vertical force, moments about x and y.
const ROWS: usize = 3;
/// λ, 1/s.
const FILTER: f64 = 10.0;
/// Time after which data count a third, s.
const FORGET: f64 = 1.0;
/// Errors of the rows last so long, s: so many samples are one.
const LASTING: f64 = 0.2;
/// Until filters have forgotten how they began, s.
const SETTLE: f64 = 0.5;
/// Farthest of the centre of mass from the point about which moments are taken, m.
const ASIDE: f64 = 0.2;

/// What is seen of the robot as the model knows it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Seen<'a, R> {
    /// The root link.
    pub base: Pose<R>,
    /// Velocities; those of the root first, in its axes.
    pub v: &'a [R],
    /// Of the model, about the root's origin in its axes: linear (kg m/s), angular (kg m²/s).
    pub momentum: [Vector<R>; 2],
    /// Of the model, kg.
    pub mass: R,
    /// Of the model, m.
    pub center: Vector<R>,
    /// m/s²
    pub gravity: R,
    /// Where the centres of pressure are (m), and how much is on them (N).
    pub pressed: [(Vector<R>, R); 2],
}

/// See the module.
#[derive(Debug, Clone)]
pub struct PayloadObserver<R> {
    /// λ/(s + λ) of w + λ p: of what the model accounts for, then per unknown with the opposite sign.
    filtered: [[R; 1 + UNKNOWNS]; ROWS],
    about: Option<Vector<R>>,
    /// Since the filters began, s.
    age: R,
    found: [R; UNKNOWNS],
    covariance: [[R; UNKNOWNS]; UNKNOWNS],
    /// Standard deviations of the unknowns before anything is seen.
    prior: [R; UNKNOWNS],
    /// Standard deviations of the rows.
    noise: [R; ROWS],
}

impl<R: Scalar> PayloadObserver<R> {
    /// Of a robot that weighs so much (N) and whose payloads are about so far (m) from its root's origin.
    pub fn new(weight: R, reach: R, gravity: R) -> Self {
        let x = R::constant;
        let mass = x(0.1) * weight / gravity;
        // What the base's tilt and velocity are off acts on moments, where the mass counts with its height; loads alone tell the mass.
        let (force, moment) = (x(0.005) * weight, x(0.002) * weight);
        let mut made = Self {
            filtered: [[x(0.0); 1 + UNKNOWNS]; ROWS],
            about: None,
            age: x(0.0),
            found: [x(0.0); UNKNOWNS],
            covariance: [[x(0.0); UNKNOWNS]; UNKNOWNS],
            prior: [mass, mass * reach, mass * reach, mass * reach],
            noise: [force, moment, moment],
        };
        made.forget_all();
        made
    }

    /// What was found.
    pub fn payload(&self) -> Payload<R> {
        let [mass, x, y, z] = self.found;
        Payload { mass, moment: [x, y, z] }
    }

    /// Standard deviations: of the mass (kg), of the first moment (kg m).
    pub fn deviations(&self) -> (R, Vector<R>) {
        let of = |k: usize| self.covariance.get(k).map_or(R::constant(0.0), |row| get(row, k)).sqrt();
        (of(0), [of(1), of(2), of(3)])
    }

    /// Nothing is known.
    fn forget_all(&mut self) {
        let o = R::constant(0.0);
        self.found = [o; UNKNOWNS];
        self.covariance = [[o; UNKNOWNS]; UNKNOWNS];
        for (k, (row, prior)) in self.covariance.iter_mut().zip(self.prior).enumerate() {
            set(row, k, prior * prior);
        }
        self.about = None;
    }

    /// Loads or centres of pressure are unknown for a while.
    pub fn pause(&mut self) {
        self.about = None;
    }

    /// Takes what is seen, `step` (s) after the last time.
    pub fn update(&mut self, seen: &Seen<'_, R>, step: R) {
        let begins = self.about.is_none();
        let carried = seen.pressed.iter().fold(R::constant(0.0), |sum, (_, load)| sum + *load);
        if begins && carried < R::constant(0.5) * seen.mass * seen.gravity {
            return;
        }
        self.age = if begins { R::constant(0.0) } else { self.age + step };
        let about = self.point(seen);
        let [linear, angular] = seen.momentum;
        let (turn, arm) = (seen.base.turn, subtract(seen.base.position, about));
        let rows = |force: Vector<R>, moment: Vector<R>| {
            let [x, y, _] = moment;
            [get(&force, 2), x, y]
        };
        let momentum = |linear: Vector<R>, angular: Vector<R>| {
            let linear = turned(turn, linear);
            rows(linear, add(turned(turn, angular), cross(arm, linear)))
        };
        let upward = |at: Vector<R>, force: R| {
            let force = [R::constant(0.0), R::constant(0.0), force];
            rows(force, cross(at, force))
        };
        let mut rest = upward(subtract(seen.center, about), -seen.mass * seen.gravity);
        for (place, load) in seen.pressed {
            rest = add(rest, upward(subtract(place, about), load));
        }
        let [velocity, turning] = twist(seen.v);
        let mut own = [momentum(linear, angular), zero(), zero(), zero(), zero()];
        let mut given = [rest, zero(), zero(), zero(), zero()];
        let [_, by_mass, ..] = &mut own;
        *by_mass = momentum(velocity, zero());
        let [_, by_mass, ..] = &mut given;
        *by_mass = upward(arm, -seen.gravity);
        for axis in 0..3 {
            let mut unit = zero();
            set(&mut unit, axis, R::constant(1.0));
            set(&mut own, 2 + axis, momentum(cross(turning, unit), cross(unit, velocity)));
            let [_, x, y] = upward(turned(turn, unit), -seen.gravity);
            set(&mut given, 2 + axis, [R::constant(0.0), x, y]);
        }
        self.filter(&own, &given, (!begins).then_some(step));
        if self.age > R::constant(SETTLE) {
            self.learn(&own, step);
        }
    }

    /// The point of the ground about which moments are taken: near the robot, and the same from one sample to the next as far as filters know.
    fn point(&mut self, seen: &Seen<'_, R>) -> Vector<R> {
        let [(right, on_right), (left, on_left)] = seen.pressed;
        let ground = if on_right > on_left { get(&right, 2) } else { get(&left, 2) };
        let [x, y, _] = seen.center;
        let old = self.about.unwrap_or([x, y, ground]);
        let [dx, dy, _] = subtract([x, y, ground], old);
        let moves = dx.abs().larger(dy.abs()) > R::constant(ASIDE);
        let [x, y, _] = if moves { [x, y, ground] } else { old };
        if moves {
            let [force, about_x, about_y] = &mut self.filtered;
            for ((f, mx), my) in force.iter().zip(about_x).zip(about_y) {
                (*mx, *my) = (*mx - dy * *f, *my + dx * *f);
            }
        }
        self.about = Some([x, y, ground]);
        [x, y, ground]
    }

    /// `step`: none where it begins.
    fn filter(
        &mut self,
        own: &[Vector<R>; 1 + UNKNOWNS],
        given: &[Vector<R>; 1 + UNKNOWNS],
        step: Option<R>,
    ) {
        let lambda = R::constant(FILTER);
        let part = step.map(|step| lambda * step / (R::constant(1.0) + lambda * step));
        for (row, filtered) in self.filtered.iter_mut().enumerate() {
            for (to, (own, given)) in filtered.iter_mut().zip(own.iter().zip(given)) {
                let now = get(&along(*given, lambda, *own), row);
                // What is no number is forgotten where it begins anew.
                *to = part.map_or(now, |part| R::fused(part, now - *to, *to));
            }
        }
    }

    /// Least squares, row after row.
    fn learn(&mut self, own: &[Vector<R>; 1 + UNKNOWNS], step: R) {
        self.forget(step);
        let lambda = R::constant(FILTER);
        for row in 0..ROWS {
            let filtered = self.filtered.get(row).copied().unwrap_or([R::constant(0.0); 1 + UNKNOWNS]);
            let mut left = [R::constant(0.0); 1 + UNKNOWNS];
            for (to, (filtered, own)) in left.iter_mut().zip(filtered.iter().zip(own)) {
                *to = *filtered - lambda * get(own, row);
            }
            let [rest, columns @ ..] = left;
            let noise = get(&self.noise, row);
            let many = R::constant(LASTING) / step.larger(R::constant(1e-4));
            self.row(columns.map(|x| -x), rest, noise * noise * many.larger(R::constant(1.0)));
        }
        let finite = self.found.iter().chain(self.covariance.iter().flatten()).all(|x| x.is_finite());
        if !finite {
            self.forget_all();
        }
    }

    fn row(&mut self, columns: [R; UNKNOWNS], value: R, variance: R) {
        let dot = |a: &[R; UNKNOWNS], b: &[R; UNKNOWNS]| {
            a.iter().zip(b).fold(R::constant(0.0), |sum, (a, b)| R::fused(*a, *b, sum))
        };
        let reached = self.covariance.each_ref().map(|row| dot(row, &columns));
        let spread = dot(&reached, &columns) + variance;
        let missing = value - dot(&columns, &self.found);
        for (found, reached) in self.found.iter_mut().zip(reached) {
            *found = R::fused(reached / spread, missing, *found);
        }
        for (row, a) in self.covariance.iter_mut().zip(reached) {
            for (place, b) in row.iter_mut().zip(reached) {
                // The same product on both sides of the diagonal.
                *place = *place - a * b / spread;
            }
        }
    }

    /// Old data count less, but nothing is known less than at first.
    fn forget(&mut self, step: R) {
        let grown = R::constant(1.0) + step / R::constant(FORGET);
        let mut most = [R::constant(1.0); UNKNOWNS];
        for (k, ((row, prior), most)) in self.covariance.iter().zip(self.prior).zip(&mut most).enumerate() {
            let variance = grown * get(row, k);
            if variance > prior * prior {
                *most = prior / variance.sqrt();
            }
        }
        for (row, a) in self.covariance.iter_mut().zip(most) {
            for (place, b) in row.iter_mut().zip(most) {
                *place = *place * (grown * (a * b));
            }
        }
    }
}

/// Where a sole is pressed, from its middle forward and left, when the centre of pressure is at x and y of the foot's link.
pub(super) fn on_sole<R: Scalar>(sole: &Pose<R>, center: [R; 2]) -> Option<[R; 2]> {
    let [x, y] = center;
    let [px, py, _] = sole.position;
    let [[fx, lx, _], [fy, ly, _], _] = sole.turn;
    let determinant = fx * ly - lx * fy;
    let (dx, dy) = (x - px, y - py);
    let found = [(ly * dx - lx * dy) / determinant, (fx * dy - fy * dx) / determinant];
    found.iter().all(|x| x.is_finite()).then_some(found)
}

/// The same place in the world.
pub(super) fn in_world<R: Scalar>(sole: &Pose<R>, [forward, left]: [R; 2]) -> Vector<R> {
    add(sole.position, turned(sole.turn, [forward, left, R::constant(0.0)]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walking::space::identity;

    #[test]
    fn a_pressed_sole_is_found_from_its_link() {
        // Forward is the link's −y, left its x.
        let turn = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        let sole = Pose { position: [0.1, 0.2, -0.3], turn };
        let found: [f64; 2] = on_sole(&sole, [0.13, 0.15]).unwrap();
        assert!((found[0] - 0.05).abs() < 1e-15 && (found[1] - 0.03).abs() < 1e-15, "{found:?}");
        assert_eq!(on_sole(&Pose { position: [0.0; 3], turn: identity() }, [f64::NAN, 0.0]), None);
        let world = in_world(&sole, found);
        assert!(subtract(world, [0.13, 0.15, -0.3]).iter().all(|x| x.abs() < 1e-15), "{world:?}");
    }

    /// 20 kg at rest above the origin; 1 kg more, 30 mm ahead and 20 mm to the left of it, pressing on both feet.
    fn standing() -> Seen<'static, f64> {
        let gravity = 9.81;
        let load = 0.5 * 21.0 * gravity;
        // About the origin: 1 kg at (0.03, 0.02) on 21 kg.
        let (x, y) = (0.03 / 21.0, 0.02 / 21.0);
        Seen {
            base: Pose { position: [0.0, 0.0, 0.7], turn: identity() },
            v: &[0.0; 6],
            momentum: [zero(); 2],
            mass: 20.0,
            center: [0.0, 0.0, 0.6],
            gravity,
            pressed: [([x, y - 0.1, 0.0], load), ([x, y + 0.1, 0.0], load)],
        }
    }

    fn finds(observer: &mut PayloadObserver<f64>) {
        (0..5000).for_each(|_| observer.update(&standing(), 1e-3));
        let found = observer.payload();
        let [x, y, _] = found.place();
        assert!(
            (found.mass - 1.0).abs() < 0.01 && (x - 0.03).abs() < 0.002 && (y - 0.02).abs() < 0.002,
            "{found:?}"
        );
    }

    #[test]
    fn what_presses_at_rest_is_found_also_after_nonsense() {
        let mut observer = PayloadObserver::new(20.0 * 9.81, 0.3, 9.81);
        finds(&mut observer);
        for nonsense in [1e308, -1e308] {
            let pressed = standing().pressed.map(|(place, _)| (place, nonsense));
            (0..3).for_each(|_| observer.update(&Seen { pressed, ..standing() }, 1e-3));
            let Payload { mass, moment } = observer.payload();
            assert!(mass.is_finite() && moment.iter().all(|x| x.is_finite()));
            observer.pause();
            finds(&mut observer);
        }
    }
}
