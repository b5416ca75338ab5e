//! The ground between the feet: where the zero moment point can be.
use super::divergent::Point;
use super::robot::Leg;
use super::space::{Pose, along, transpose};
use crate::control::slices::get;
use crate::real::Scalar;

/// Corners of two soles.
const MOST: usize = 8;

/// A convex polygon, counterclockwise.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Support<R> {
    corners: [Point<R>; MOST],
    count: usize,
}

/// By x, then y. The library's sort may panic where numbers have no order.
fn sort<R: Scalar>(points: &mut [Point<R>]) {
    for end in 1..points.len() {
        for k in (1..=end).rev() {
            let Some([before, here]) =
                points.get_mut(k - 1..=k).and_then(|pair| <&mut [_; 2]>::try_from(pair).ok())
            else {
                return;
            };
            if *before <= *here {
                break;
            }
            core::mem::swap(before, here);
        }
    }
}

/// > 0: c is to the left of the line from a to b.
fn left<R: Scalar>([ax, ay]: Point<R>, [bx, by]: Point<R>, [cx, cy]: Point<R>) -> R {
    (bx - ax) * (cy - ay) - (by - ay) * (cx - ax)
}

impl<R: Scalar> Support<R> {
    /// Hull of the soles that stand, each so much (m) smaller on every side, but never smaller than a line.
    pub fn of<'a>(feet: impl Iterator<Item = (&'a Leg<R>, &'a Pose<R>)>, margin: R) -> Self {
        let mut corners = [[R::constant(0.0); 2]; MOST];
        let mut count = 0;
        for (leg, pose) in feet {
            let [rear, front, right, left] = leg.extent;
            let half = R::constant(0.5);
            let shrink = |low: R, high: R| {
                let (middle, room) =
                    (half * (low + high), (half * (high - low) - margin).larger(R::constant(0.0)));
                [middle - room, middle + room]
            };
            let ([rear, front], [right, left]) = (shrink(rear, front), shrink(right, left));
            let [forward, across, _] = transpose(pose.turn);
            for (x, y) in [(rear, right), (front, right), (front, left), (rear, left)] {
                let [px, py, _] = along(along(pose.position, x, forward), y, across);
                if let Some(corner) = corners.get_mut(count) {
                    *corner = [px, py];
                    count += 1;
                }
            }
        }
        Self { corners, count }.hull()
    }

    /// By Andrew's monotone chain.
    fn hull(mut self) -> Self {
        let points = self.corners.get_mut(..self.count).unwrap_or(&mut []);
        sort(points);
        let mut chain = [[R::constant(0.0); 2]; 2 * MOST];
        let mut count = 0;
        let mut extend = |points: &mut dyn Iterator<Item = Point<R>>| {
            let first = count;
            for point in points {
                while count >= first + 2 {
                    let (a, b) = (chain.get(count - 2), chain.get(count - 1));
                    let turns = a.zip(b).is_some_and(|(a, b)| left(*a, *b, point) > R::constant(0.0));
                    if turns {
                        break;
                    }
                    count -= 1;
                }
                if let Some(place) = chain.get_mut(count) {
                    *place = point;
                    count += 1;
                }
            }
            // The last one begins the other half.
            count = count.saturating_sub(1);
        };
        extend(&mut points.iter().copied());
        extend(&mut points.iter().rev().copied());
        self.corners.iter_mut().zip(chain).for_each(|(to, from)| *to = from);
        self.count = count.min(MOST);
        self
    }

    /// The corners, counterclockwise.
    pub fn corners(&self) -> &[Point<R>] {
        self.corners.get(..self.count).unwrap_or(&[])
    }

    fn edges(&self) -> impl Iterator<Item = (Point<R>, Point<R>)> + '_ {
        let corners = self.corners();
        corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
    }

    /// How far (m) a place is inside: the least distance from the lines through the edges; negative outside.
    pub fn inside(&self, place: Point<R>) -> R {
        let mut least: Option<R> = None;
        for (a, b) in self.edges() {
            let [x, y] = [get(&b, 0) - get(&a, 0), get(&b, 1) - get(&a, 1)];
            let length = (x * x + y * y).sqrt();
            if length > R::constant(0.0) {
                let distance = left(a, b, place) / length;
                least = Some(least.map_or(distance, |least| -(-least).larger(-distance)));
            }
        }
        least.unwrap_or(R::constant(0.0))
    }

    /// The nearest place that is inside.
    pub fn nearest(&self, place: Point<R>) -> Point<R> {
        let zero = R::constant(0.0);
        let [x, y] = place;
        let mut outside = self.count < 3;
        let mut best: Option<(R, Point<R>)> = None;
        for (a, b) in self.edges() {
            outside |= left(a, b, place) < zero;
            let ([ax, ay], [bx, by]) = (a, b);
            let (wx, wy) = (bx - ax, by - ay);
            let square = wx * wx + wy * wy;
            let part = if square > zero { ((x - ax) * wx + (y - ay) * wy) / square } else { zero };
            let part = -(-part.larger(zero)).larger(-R::constant(1.0));
            let near = [ax + part * wx, ay + part * wy];
            let [nx, ny] = near;
            let distance = (nx - x) * (nx - x) + (ny - y) * (ny - y);
            if best.is_none_or(|(least, _)| distance < least) {
                best = Some((distance, near));
            }
        }
        match best {
            Some((_, near)) if outside => near,
            _ => place,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::walking::space::{about_z, identity, zero};

    fn leg() -> Leg<f64> {
        let sole = Pose { position: zero(), turn: identity() };
        let [position, rotation, jacobian, jacobian_rate] = [0; 4];
        let extent = [-0.1, 0.1, -0.05, 0.05];
        Leg {
            position,
            rotation,
            jacobian,
            jacobian_rate,
            joints: [0; 6],
            sole,
            extent,
            foot: 0,
            knee: 0,
            bends: 1.0,
        }
    }

    #[test]
    fn one_sole_is_a_rectangle() {
        let pose = Pose { position: [1.0, 2.0, 0.0], turn: about_z(0.0) };
        let support = Support::of([(&leg(), &pose)].into_iter(), 0.01);
        assert_eq!(support.corners().len(), 4);
        assert!((support.inside([1.0, 2.0]) - 0.04).abs() < 1e-15);
        let near = support.nearest([1.3, 2.01]);
        assert!((near[0] - 1.09).abs() < 1e-15 && (near[1] - 2.01).abs() < 1e-15);
        assert_eq!(support.nearest([1.05, 1.97]), [1.05, 1.97]);
    }

    #[test]
    fn two_soles_span_what_is_between_them() {
        let [right, left] =
            [(-0.1, 0.0), (0.1, 0.3)].map(|(y, yaw)| Pose { position: [0.0, y, 0.0], turn: about_z(yaw) });
        let support = Support::of([(&leg(), &right), (&leg(), &left)].into_iter(), 0.0);
        assert!(support.corners().len() >= 5);
        assert!(support.inside([0.0, 0.0]) > 0.05);
        for k in 0..200 {
            let angle = 0.1 * f64::from(k);
            let far = [angle.cos(), angle.sin()];
            let near = support.nearest(far);
            assert!(support.inside(near).abs() < 1e-12, "{near:?}");
            // Nobody inside is nearer: the corners are not.
            let distance = |p: [f64; 2]| (p[0] - far[0]).hypot(p[1] - far[1]);
            assert!(support.corners().iter().all(|corner| distance(*corner) >= distance(near) - 1e-12));
        }
    }
}
