//! What a push changes of a step: where the swinging foot comes down, and when.
//!
//! At the end of a step the divergent component is ξ(T) = z + (ξ − z) e^(ωT). A later or earlier end moves it without moving the foot, in particular
//! where the foot must not go because the other leg is there (Khadiv and others, IEEE Transactions on Robotics 36, 2020, solve for both by a quadratic program
//! in the place and e^(ωT)). Here times are tried one by one, and for each one the place is known in closed form.
use super::divergent::Point;
use super::robot::{Leg, Place};
use super::space::{Vector, about_z, along, subtract, transpose};
use super::steps::{Foothold, Phase, Steps, Stride, clamp};
use crate::control::slices::get;
use crate::real::Scalar;

/// A foot that comes down within this time (s) stays with its goal.
const NEARLY_DOWN: f64 = 0.05;
/// Durations that are tried, as parts of the planned one: the first, the distance between them, how many.
const TRIED: (f64, f64, u32) = (0.5, 0.05, 31);

/// The rest of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adjusted<R> {
    /// Where the swinging foot goes.
    pub goal: Foothold<R>,
    /// Of the whole phase, s.
    pub duration: R,
    /// How far the divergent component will be from where it should be nevertheless, m.
    pub missing: R,
}

/// One axis of the foot that stands, as seen from where the zero moment point is wished; m.
#[derive(Debug, Clone, Copy)]
struct Axis<R> {
    /// The divergent component now, and at the end of the step as planned.
    divergent: [R; 2],
    /// How far the zero moment point can go back and ahead.
    room: [R; 2],
    /// The planned way of the foot, from the foot that stands.
    way: R,
    /// Least and farthest way.
    bounds: [R; 2],
    /// Where the swinging foot is, and where it goes just now, from the foot that stands.
    present: [R; 2],
}

impl<R: Scalar> Axis<R> {
    /// With so much time (s) left: the way of the foot, and what remains then (m). `gain`: by how much the divergent component at the end moves per
    /// metre of the foot.
    fn after(&self, left: R, stride: &Stride<R>, gain: R) -> (R, R) {
        let (zero, half, one) = (R::constant(0.0), R::constant(0.5), R::constant(1.0));
        let growth = (stride.omega * left).exp();
        let [now, end] = self.divergent;
        let off = now * growth - end;
        let [back, ahead] = self.room;
        // What the zero moment point takes when it goes half as far as it can.
        let room = half * (growth - one) * if off > zero { ahead } else { back };
        let beyond = off.sign() * (off.abs() - room).larger(zero);
        let [low, high] = self.bounds;
        let [place, goal] = self.present;
        let near = |at: R, reach: R, [low, high]: [R; 2]| {
            [clamp(at - reach, low, high), clamp(at + reach, low, high)]
        };
        let [low, high] = near(place, stride.speed * left, [low, high]);
        // The integral of how fast the goal may move.
        let [low, high] = near(goal, stride.agility * left * left * left / R::constant(3.0), [low, high]);
        let way = clamp(self.way + beyond / gain, low, high);
        let rest = beyond - gain * (way - self.way);
        (way, (rest.abs() - room).larger(zero))
    }
}

/// How a step goes on for `step` (s), so that the divergent component ends where the steps want it: as planned, if the sole that stands can do that; else
/// with another place of the swinging foot and another duration, within the limits of the stride. Nothing where no foot swings or the foot is nearly down.
pub fn adjusted<R: Scalar>(
    steps: &Steps<R>,
    stride: &Stride<R>,
    margin: R,
    (legs, place): ([&Leg<R>; 2], &Place<R>),
    (divergent, step): (Point<R>, R),
) -> Option<Adjusted<R>> {
    if steps.phase != Phase::Swing || steps.left() < R::constant(NEARLY_DOWN) {
        return None;
    }
    let axes = axes(steps, stride, margin, (legs, place), divergent)?;
    let (one, angle) = (R::constant(1.0), stride.omega * stride.double_support * steps.pace);
    let gain = if angle > R::constant(1e-6) { (one - (-angle).exp()) / angle } else { one };
    let Ending { duration, way, missing } = Choice { steps, stride, axes, gain }.best();
    let stand = steps.foot(steps.stands);
    let [forward, across, _] = transpose(about_z(stand.yaw));
    let left = duration - steps.time;
    let most = stride.agility * left * left * step;
    let [x, y] = [0, 1].map(|k| {
        let at = axes.get(k).map_or(R::constant(0.0), |axis| get(&axis.present, 1));
        at + clamp(get(&way, k) - at, -most, most)
    });
    let place = along(along(stand.place, x, forward), y, across);
    Some(Adjusted { goal: Foothold { place, yaw: steps.nominal.yaw }, duration, missing })
}

/// A way in which a step can end.
#[derive(Debug, Clone, Copy)]
struct Ending<R> {
    /// Of the whole phase, s.
    duration: R,
    /// Of the foot, from the foot that stands, m.
    way: [R; 2],
    /// Of the divergent component, m.
    missing: R,
}

/// What there is to choose from.
struct Choice<'a, R> {
    steps: &'a Steps<R>,
    stride: &'a Stride<R>,
    axes: [Axis<R>; 2],
    /// By how much the divergent component wished at the end moves per metre of the foot.
    gain: R,
}

impl<R: Scalar> Choice<'_, R> {
    fn with(&self, duration: R) -> Ending<R> {
        let left = duration - self.steps.time;
        let [(x, a), (y, b)] = self.axes.each_ref().map(|axis| axis.after(left, self.stride, self.gain));
        Ending { duration, way: [x, y], missing: a + b }
    }

    /// How far the foot comes down from where it was planned, in widths, squared.
    fn moved(&self, ending: &Ending<R>) -> R {
        let ([x, y], [a, b]) = (ending.way, self.axes.each_ref().map(|axis| axis.way));
        ((x - a) * (x - a) + (y - b) * (y - b)) / (self.stride.width * self.stride.width)
    }

    fn cost(&self, ending: &Ending<R>) -> R {
        let changed = ending.duration / self.steps.usual - R::constant(1.0);
        let Stride { punctual, strict, width, .. } = *self.stride;
        punctual * changed * changed + self.moved(ending) + strict * ending.missing / width
    }

    fn is_as_planned(&self, ending: &Ending<R>) -> bool {
        let zero = R::constant(0.0);
        ending.duration == self.steps.usual && self.moved(ending) == zero && ending.missing == zero
    }

    fn best(&self) -> Ending<R> {
        let Steps { usual, duration, time, .. } = *self.steps;
        // The foot is on its way there: that is always possible.
        let mut best = self.with(duration);
        if self.is_as_planned(&best) {
            return best;
        }
        let planned = self.with(usual);
        if usual - time >= self.stride.soonest && self.is_as_planned(&planned) {
            return planned;
        }
        let mut least = self.cost(&best);
        let (first, between, count) = TRIED;
        for k in 0..count {
            let duration = usual * R::constant(first + between * f64::from(k));
            if duration - time < self.stride.soonest {
                continue;
            }
            let found = self.with(duration);
            let cost = self.cost(&found);
            if cost < least {
                (least, best) = (cost, found);
            }
        }
        best
    }
}

/// Along and across the foot that stands.
fn axes<R: Scalar>(
    steps: &Steps<R>,
    stride: &Stride<R>,
    margin: R,
    (legs, place): ([&Leg<R>; 2], &Place<R>),
    divergent: Point<R>,
) -> Option<[Axis<R>; 2]> {
    let (leg, sole) = (legs.get(steps.stands)?, place.soles.get(steps.stands)?);
    let swinging = place.soles.get(steps.swings())?.pose.position;
    let stand = steps.foot(steps.stands);
    let [forward, across, _] = transpose(about_z(stand.yaw));
    let on_ground =
        |axis: &Vector<R>, vector: &[R]| get(axis, 0) * get(vector, 0) + get(axis, 1) * get(vector, 1);
    let [x, y] = steps.reference_zmp();
    let ([a, b], [c, d]) = (divergent, steps.divergent_at_end(stride, &steps.nominal));
    let (now, end) = ([a - x, b - y], [c - x, d - y]);
    let inside = leg.inside(&sole.pose, [x, y, get(&sole.pose.position, 2)]);
    let room = |side: usize| (get(&inside, side) - margin).larger(R::constant(0.0));
    let [nearest, farthest] = stride.across;
    let aside = if steps.stands == 0 { [nearest, farthest] } else { [-farthest, -nearest] };
    let of = |axis: &Vector<R>, low: usize, bounds: [R; 2]| Axis {
        divergent: [on_ground(axis, &now), on_ground(axis, &end)],
        room: [room(low), room(low + 1)],
        way: on_ground(axis, &subtract(steps.nominal.place, stand.place)),
        bounds,
        present: [swinging, steps.goal.place].map(|place| on_ground(axis, &subtract(place, stand.place))),
    };
    Some([of(&forward, 0, [-stride.longest, stride.longest]), of(&across, 2, aside)])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walking::robot::Sole;
    use crate::walking::space::{Pose, identity, zero};
    use crate::walking::steps::Velocity;

    fn stride() -> Stride<f64> {
        Stride {
            time: 0.6,
            shortest: 0.36,
            easy: 0.25,
            double_support: 0.25,
            width: 0.16,
            longest: 0.3,
            across: [0.13, 0.37],
            largest_turn: 0.35,
            change: 0.1,
            punctual: 1.0,
            strict: 20.0,
            soonest: 0.1,
            patience: 0.3,
            speed: 1.2,
            agility: 60.0,
            omega: 4.0,
        }
    }

    fn leg() -> Leg<f64> {
        let sole = Pose { position: zero(), turn: identity() };
        let [position, rotation, jacobian, jacobian_rate] = [0; 4];
        let extent = [-0.12, 0.12, -0.06, 0.06];
        let (joints, foot, knee, bends) = ([0; 6], 0, 0, 1.0);
        Leg { position, rotation, jacobian, jacobian_rate, joints, sole, extent, foot, knee, bends }
    }

    /// On the right foot, `time` s into a step on the spot; the left one is on its way.
    fn stepping(time: f64) -> (Steps<f64>, Place<f64>) {
        let feet = [-0.08, 0.08].map(|y| Foothold { place: [0.0, y, 0.0], yaw: 0.0 });
        let mut steps = Steps::standing(feet);
        steps.start(&stride(), 0, 0.6);
        steps.lift(&stride(), &Velocity::zero());
        steps.time = time;
        let soles = feet.map(|foot| Sole {
            pose: Pose { position: foot.place, turn: identity() },
            velocity: [zero(); 2],
            drift: [zero(); 2],
            columns: [[0.0; 6]; 6],
        });
        let base = Pose { position: zero(), turn: identity() };
        (steps, Place { base, velocity: zero(), angular: zero(), center: [zero(); 2], soles })
    }

    /// What becomes of a push that moves the divergent component by `off` (m), `time` s into the step.
    fn pushed(time: f64, off: [f64; 2]) -> (Steps<f64>, Adjusted<f64>) {
        let ((steps, place), leg) = (stepping(time), leg());
        let end = steps.divergent_at_end(&stride(), &steps.nominal);
        let [x, y] = steps.divergent_now(&stride(), end);
        let at = [x + off[0], y + off[1]];
        let found = adjusted(&steps, &stride(), 0.015, ([&leg, &leg], &place), (at, 1.0)).unwrap();
        (steps, found)
    }

    #[test]
    fn who_is_not_pushed_walks_on_as_planned() {
        let (steps, found) = pushed(0.15, [0.0; 2]);
        assert_eq!((found.duration, found.missing), (steps.usual, 0.0));
        let nominal = steps.nominal.place;
        assert!((0..2).all(|k| (found.goal.place[k] - nominal[k]).abs() < 1e-15), "{found:?}");
    }

    /// Toward the foot in the air it comes down sooner and farther out; away from it the step lasts longer, and feet do not cross.
    #[test]
    fn pushes_to_the_side_change_the_time() {
        let (steps, inward) = pushed(0.15, [0.0, 0.05]);
        assert!(
            inward.duration < 0.95 * steps.usual && inward.goal.place[1] > steps.nominal.place[1] + 0.005
        );
        let (steps, outward) = pushed(0.15, [0.0, -0.05]);
        assert!(outward.duration > 1.1 * steps.usual, "{outward:?}");
        let ways = [inward, outward].map(|found| found.goal.place[1] - steps.foot(0).place[1]);
        assert!(ways.iter().all(|way| (0.13 - 1e-12..=0.37 + 1e-12).contains(way)), "{ways:?}");
    }

    /// With the time that was found, and the sole used as far as it was counted on, the divergent component ends where the new place wants it.
    #[test]
    fn the_divergent_component_ends_at_its_place() {
        let (steps, found) = pushed(0.1, [0.0, 0.05]);
        assert_eq!(found.missing, 0.0);
        let end = steps.divergent_at_end(&stride(), &steps.nominal);
        let from = steps.divergent_now(&stride(), end)[1] + 0.05;
        let wished = steps.divergent_at_end(&stride(), &found.goal)[1];
        let growth = (stride().omega * (found.duration - steps.time)).exp();
        // ξ(T) = z + (ξ − z) e^(ωT) with the zero moment point at its place, and where it is 0.045 m farther.
        let of = |z: f64| z + (from - z) * growth;
        let foot = steps.foot(0).place[1];
        assert!(of(foot + 0.045) <= wished + 1e-9 && wished <= of(foot) + 1e-9, "{wished} {}", of(foot));
    }

    /// A goal moves no faster than a foot can follow, and a foot that is nearly down stays.
    #[test]
    fn late_goals_move_little() {
        let ((steps, place), leg) = (stepping(0.3), leg());
        let of = |steps: &Steps<f64>, step: f64| {
            adjusted(steps, &stride(), 0.015, ([&leg, &leg], &place), ([0.3, 0.1], step))
        };
        let found = of(&steps, 1e-3).unwrap();
        let left = found.duration - steps.time;
        let moved = found.goal.place[0] - steps.goal.place[0];
        assert!(moved > 0.0 && moved <= 60.0 * left * left * 1e-3 + 1e-12, "{moved}");
        let (down, _) = stepping(steps.usual - 0.04);
        assert_eq!(of(&down, 1e-3), None);
    }
}
