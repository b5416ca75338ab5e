//! How the controller of walks keeps its balance: zero moment point first, then the torso, then place and time of the next step.
use super::adjustment::{Adjusted, adjusted};
use super::controller::{Walked, WalkingController, mean, two};
use super::divergent::Point;
use super::gains::Gains;
use super::robot::Place;
use super::space::Vector;
use super::steps::{Phase, Steps, clamp};
use super::support::Support;
use crate::control::slices::get;
use crate::real::Scalar;

impl<M, R: Scalar> WalkingController<M, R> {
    /// Whether the step that comes can end as it should, or it has been waited for long enough.
    pub(super) fn may_lift(&self, steps: &Steps<R>, place: &Place<R>) -> bool {
        let Gains { stride, margin, .. } = self.gains;
        let mut next = *steps;
        next.lift(&stride, &self.asked);
        let legs = self.robot.legs.each_ref();
        let found =
            adjusted(&next, &stride, margin, (legs, place), (self.divergent(place), R::constant(0.0)));
        let fine = |found: Adjusted<R>| found.missing <= R::constant(0.0);
        found.is_none_or(fine) || steps.time > steps.duration + stride.patience
    }

    /// Angular acceleration that makes the ground push as if the zero moment point were so much (m) farther out.
    pub(super) fn hip(&self, beyond: Point<R>) -> Vector<R> {
        let [gain, most] = self.gains.hip;
        let [x, y] = beyond.map(|x| clamp(gain * x, -most, most));
        [-y, x, R::constant(0.0)]
    }

    /// The divergent component with its bias, m.
    pub(super) fn divergent(&self, place: &Place<R>) -> Point<R> {
        let [center, velocity] = place.center;
        let bias = self.bias.bias();
        two(|i| get(&center, i) + get(&velocity, i) / self.gains.stride.omega + get(&bias, i))
    }

    /// Where the zero moment point has to be, that the divergent component comes to where the steps want it.
    pub(super) fn balance(
        &mut self,
        steps: &mut Steps<R>,
        place: &Place<R>,
        step: R,
    ) -> (Point<R>, Point<R>) {
        let stride = &self.gains.stride;
        let [center, _] = place.center;
        let divergent = self.divergent(place);
        let legs = self.robot.legs.each_ref();
        let found = adjusted(steps, stride, self.gains.margin, (legs, place), (divergent, step));
        if let Some(Adjusted { goal, duration, .. }) = found {
            (steps.goal, steps.duration) = (goal, duration);
        }
        let end = steps.divergent_at_end(stride, &steps.goal);
        let wished = steps.divergent_now(stride, end);
        let reference = steps.reference_zmp();
        let gain = R::constant(1.0) + self.gains.divergent / stride.omega;
        let asked = two(|i| get(&reference, i) + gain * (get(&divergent, i) - get(&wished, i)));
        let standing = legs.iter().zip(&place.soles).enumerate();
        let standing =
            standing.filter(|(foot, _)| steps.is_standing(*foot)).map(|(_, (leg, sole))| (*leg, &sole.pose));
        let support = Support::of(standing, self.gains.margin);
        let zmp = support.nearest(asked);
        self.walked = Some(Walked {
            divergent: [divergent, wished],
            zero_moment_point: [zmp, reference],
            limited: zmp != asked,
            center: two(|i| get(&center, i)),
            height: get(&center, 2) - self.ground(steps, place),
            shared: None,
        });
        (zmp, two(|i| get(&asked, i) - get(&zmp, i)))
    }

    /// Height of the ground below the zero moment point, m.
    pub(super) fn ground(&self, steps: &Steps<R>, place: &Place<R>) -> R {
        let heights = place.soles.each_ref().map(|sole| get(&sole.pose.position, 2));
        match steps.phase {
            Phase::Swing => get(&heights, steps.stands),
            _ => mean(heights),
        }
    }

    /// Parts of the load on right and left: where the zero moment point is on the way between them.
    pub(super) fn shares(&self, steps: &Steps<R>, place: &Place<R>, zmp: Point<R>) -> [R; 2] {
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        if steps.phase == Phase::Swing {
            return if steps.stands == 0 { [one, zero] } else { [zero, one] };
        }
        let [right, left] = place.soles.each_ref().map(|sole| sole.pose.position);
        let way = two(|i| get(&left, i) - get(&right, i));
        let from = two(|i| get(&zmp, i) - get(&right, i));
        let along = get(&way, 0) * get(&from, 0) + get(&way, 1) * get(&from, 1);
        let square = get(&way, 0) * get(&way, 0) + get(&way, 1) * get(&way, 1);
        let part = if square > zero { along / square } else { R::constant(0.5) };
        let part = clamp(part, zero, one);
        [one - part, part]
    }
}
