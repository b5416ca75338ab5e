//! temporary
use super::robot::{BASE, Place, WalkingRobot};
use super::space::{Vector, add, cross, scale, subtract};
use crate::control::slices::{get, set};
use crate::real::Scalar;

pub fn share<R: Scalar>(
    robot: &WalkingRobot<R>,
    place: &Place<R>,
    shares: [R; 2],
    required: [R; 6],
    torques: &mut [R],
) {
    let [a, b, c, d, e, f] = required;
    let (force, moment): (Vector<R>, Vector<R>) = ([a, b, c], [d, e, f]);
    let mut left = moment;
    for (sole, share) in place.soles.iter().zip(shares) {
        left = subtract(left, cross(sole.pose.position, scale(share, force)));
    }
    for ((leg, sole), share) in robot.legs.iter().zip(&place.soles).zip(shares) {
        let (force, moment) = (scale(share, force), scale(share, left));
        let _ = add(force, moment);
        let wrench = [force, moment];
        for (joint, column) in leg.joints.iter().zip(&sole.columns) {
            let work =
                column.iter().zip(wrench.iter().flatten()).fold(R::constant(0.0), |s, (x, y)| s + *x * *y);
            let k = joint - BASE;
            set(torques, k, get(torques, k) - work);
        }
    }
}
