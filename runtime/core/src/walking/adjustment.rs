//! Where the swinging foot goes after a push: farther, where the zero moment point alone does not bring the divergent component back.
use super::divergent::Point;
use super::robot::{Leg, Place};
use super::space::{Vector, about_z, along, subtract, transpose};
use super::steps::{Foothold, Phase, Steps, Stride, clamp};
use crate::control::slices::get;
use crate::real::Scalar;

/// A foot that comes down within this time (s) stays with its goal.
const NEARLY_DOWN: f64 = 0.05;

/// The place of the swinging foot: the planned one, moved by what the divergent component will be off at the step's end beyond what the sole that
/// stands can mend, within the limits of the stride; nothing where no foot swings.
pub fn adjusted_goal<R: Scalar>(
    steps: &Steps<R>,
    stride: &Stride<R>,
    margin: R,
    (legs, place): ([&Leg<R>; 2], &Place<R>),
    divergent: Point<R>,
) -> Option<Foothold<R>> {
    let left = steps.left();
    if steps.phase != Phase::Swing || left < R::constant(NEARLY_DOWN) {
        return None;
    }
    let (leg, sole) = (legs.get(steps.stands)?, place.soles.get(steps.stands)?);
    let stand = steps.foot(steps.stands);
    let [forward, across, _] = transpose(about_z(stand.yaw));
    let on_ground =
        |axis: &Vector<R>, vector: &[R]| get(axis, 0) * get(vector, 0) + get(axis, 1) * get(vector, 1);
    let error = {
        let wished = steps.divergent_now(stride, steps.divergent_at_end(stride, &steps.nominal));
        let ([a, b], [c, d]) = (divergent, wished);
        [a - c, b - d]
    };
    let [x, y] = steps.reference_zmp();
    let inside = leg.inside(&sole.pose, [x, y, get(&sole.pose.position, 2)]);
    let growth = (stride.omega * left).exp();
    let zero = R::constant(0.0);
    // Of the error at the step's end, what is left when the zero moment point goes half as far as it can.
    let beyond = |axis: &Vector<R>, low: usize| {
        let error = on_ground(axis, &error);
        let side = if error > zero { low + 1 } else { low };
        let room = (get(&inside, side) - margin).larger(zero) * R::constant(0.5);
        let rest = (error.abs() * growth - (growth - R::constant(1.0)) * room).larger(zero);
        if error > zero { rest } else { -rest }
    };
    // As seen from the foot that stands.
    let way = subtract(steps.nominal.place, stand.place);
    let x = clamp(on_ground(&forward, &way) + beyond(&forward, 0), -stride.longest, stride.longest);
    let [nearest, farthest] = stride.across;
    let [low, high] = if steps.stands == 0 { [nearest, farthest] } else { [-farthest, -nearest] };
    let y = clamp(on_ground(&across, &way) + beyond(&across, 2), low, high);
    Some(Foothold { place: along(along(stand.place, x, forward), y, across), yaw: steps.nominal.yaw })
}
