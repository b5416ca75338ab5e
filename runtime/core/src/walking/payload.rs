//! A mass on the root link that the model does not know: what it does to the robot's motion.
use super::robot::{BASE, Place};
use super::space::{Turn, Vector, add, along, cross, scale, turned, turned_back, zero};
use super::steps::clamp;
use crate::control::slices::get;
use crate::real::Scalar;

/// Farthest that a payload is taken to be from the root's origin along an axis, m.
const FAR: f64 = 1.0;

/// A mass that is fixed to the root link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Payload<R> {
    /// kg
    pub mass: R,
    /// Mass times place, from the root's origin in its axes, kg m.
    pub moment: Vector<R>,
}

impl<R: Scalar> Payload<R> {
    /// There is none.
    pub fn none() -> Self {
        Self { mass: R::constant(0.0), moment: zero() }
    }

    /// Where it is, from the root's origin in its axes, m; the origin where there is next to no mass.
    pub fn place(&self) -> Vector<R> {
        if self.mass.abs() < R::constant(1e-3) {
            return zero();
        }
        let far = R::constant(FAR);
        self.moment.map(|x| clamp(x / self.mass, -far, far))
    }

    /// What accelerates it, about the root's origin in its axes: force (N) and moment (N m).
    fn wrench(&self, linear: Vector<R>, angular: Vector<R>) -> [Vector<R>; 2] {
        let turning = cross(angular, self.moment);
        let force = along(turning, self.mass, linear);
        [force, add(cross(self.moment, linear), cross(self.place(), turning))]
    }

    /// Onto D, column after column.
    pub(super) fn add_to_mass(&self, mass: &mut [R], nv: usize) {
        for k in 0..BASE {
            let Some(column) = mass.get_mut(k * nv..(k + 1) * nv) else { return };
            let unit =
                |first: usize| [0, 1, 2].map(|axis| R::constant(f64::from(u8::from(first + axis == k))));
            let [force, moment] = self.wrench(unit(0), unit(3));
            column.iter_mut().zip(force.iter().chain(&moment)).for_each(|(to, x)| *to = *to + *x);
        }
    }

    /// Onto H of a robot whose root is turned so and moves so (its own axes).
    pub(super) fn add_to_bias(&self, bias: &mut [R], turn: Turn<R>, v: &[R], gravity: R) {
        let [linear, angular] = twist(v);
        let up = turned_back(turn, [R::constant(0.0), R::constant(0.0), gravity]);
        let [force, moment] = self.wrench(add(cross(angular, linear), up), zero());
        let outward = cross(angular, cross(angular, self.moment));
        let (force, moment) = (add(force, outward), add(moment, cross(self.place(), outward)));
        bias.iter_mut().zip(force.iter().chain(&moment)).for_each(|(to, x)| *to = *to + *x);
    }

    /// Moves the centre of mass of a robot of `weighs` kg.
    pub(super) fn shift(&self, place: &mut Place<R>, weighs: R) {
        let all = weighs + self.mass;
        if all <= R::constant(0.0) {
            return;
        }
        let arm = turned(place.base.turn, self.moment);
        let [center, velocity] = place.center;
        let mean = |of: Vector<R>, base: Vector<R>, more: Vector<R>| {
            scale(R::constant(1.0) / all, add(scale(weighs, of), along(more, self.mass, base)))
        };
        place.center = [
            mean(center, place.base.position, arm),
            mean(velocity, place.velocity, cross(place.angular, arm)),
        ];
    }
}

/// Linear and angular velocity of the root.
pub(super) fn twist<R: Scalar>(v: &[R]) -> [Vector<R>; 2] {
    [0, 3].map(|first| [0, 1, 2].map(|k| get(v, first + k)))
}
