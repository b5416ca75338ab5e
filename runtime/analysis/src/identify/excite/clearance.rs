//! Feet that keep clear of each other while a robot hangs and moves.
use crate::robot::Foot;
use crate::robot::Trajectory;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::model::{Argument, Model, State};
use nalgebra::{DMatrix, DVector, Vector3};

/// Functions that [`Clearance`] looks up.
pub const CLEARANCE_FUNCTIONS: [&str; 4] =
    ["contact_positions", "contact_distances", "contact_tangential_directions", "contact_normal_directions"];

/// Singular values below this part of the largest are none.
const RANK: f64 = 1e-9;
/// Motion sideways below this is rounding, m/rad.
const SIDEWAYS: f64 = 1e-9;

/// The soles of a robot, and how far from each other they stay.
///
/// A sole is taken as all that is nearer to its longer middle line than half its width: this contains the rectangle of its
/// corners, so that distances are never too large, and distance and gradient are those of two segments.
pub struct Clearance {
    model: Box<dyn Model<f64>>,
    /// In the order of [`CLEARANCE_FUNCTIONS`].
    functions: [usize; 4],
    soles: Vec<Sole>,
    /// m
    least: f64,
}

/// A segment, by weights of the sole's contact points, and the distance from it that belongs to the sole.
#[derive(Debug, Clone, PartialEq)]
struct Sole {
    /// Its first point among those of the model.
    first: usize,
    ends: [DVector<f64>; 2],
    /// m
    radius: f64,
}

impl Clearance {
    /// Of the feet of a robot on a fixed base, in the order of the model's contact points; `least` in m.
    ///
    /// # Errors
    /// The model lacks a function; a distance that is not finite or negative.
    pub fn new(model: Box<dyn Model<f64>>, feet: &[Foot], least: f64) -> Result<Self, Diagnostic> {
        if !(0.0..f64::MAX).contains(&least) {
            return Err(Diagnostic::error(format!("feet cannot be kept {least} m apart"))
                .help("give a distance from 0 m on; 0.02 m is usual"));
        }
        let mut functions = [0; 4];
        for (function, name) in functions.iter_mut().zip(CLEARANCE_FUNCTIONS) {
            *function = model
                .function(name)
                .ok_or_else(|| Diagnostic::error(format!("the model has no function `{name}`")))?;
        }
        let mut first = 0;
        let soles = feet
            .iter()
            .map(|foot| {
                let sole = Sole::new(foot, first);
                first += foot.corners.len();
                sole
            })
            .collect();
        Ok(Self { model, functions, soles, least })
    }

    /// Least distance that is wanted between two soles, m.
    pub fn least(&self) -> f64 {
        self.least
    }

    /// Whether no joint moves a foot sideways: the legs of such a model pass through each other.
    pub fn is_sagittal(&self) -> bool {
        let rows = |function: usize| self.model.signature(function).map_or(0, |s| s.rows);
        // Contact points of a planar model have no y at all.
        if rows(self.functions[0]) < 2 * rows(self.functions[1]) {
            return true;
        }
        let q: Vec<f64> = (0..self.model.nq()).map(|k| 0.3 + 0.1 * k as f64).collect();
        let columns = self.call(self.functions[2], &q);
        columns.chunks_exact(self.model.nv()).skip(1).step_by(2).flatten().all(|by| by.abs() < SIDEWAYS)
    }

    /// Least distance of two soles in a motion, m; negative: they overlap.
    pub fn distance(&self, motion: &Trajectory) -> f64 {
        let mut points = Points::default();
        let joints = self.model.nv();
        let mut least = f64::INFINITY;
        for q in motion.q.chunks_exact(joints) {
            self.places(q, &mut points);
            for (a, b) in self.pairs() {
                least = least.min(self.between(a, b, &points).0);
            }
        }
        least
    }

    /// Sum over pairs of soles and samples of `(1 − d/d_least)²` where the middle lines are nearer (`d`) than they may be,
    /// and its derivatives by positions added to `gradient`, times `weight`.
    pub fn excess(&self, motion: &Trajectory, gradient: &mut [f64]) -> f64 {
        let mut points = Points::default();
        let (joints, mut sum) = (self.model.nv(), 0.0);
        for (q, gradient) in motion.q.chunks_exact(joints).zip(gradient.chunks_exact_mut(joints)) {
            self.places(q, &mut points);
            let mut known = false;
            for (a, b) in self.pairs() {
                let (distance, [s, t]) = self.between(a, b, &points);
                let reach = a.radius + b.radius + self.least;
                let line = distance + a.radius + b.radius;
                if line >= reach {
                    continue;
                }
                if !known {
                    self.slopes(q, &mut points);
                    known = true;
                }
                let excess = 1.0 - line / reach;
                sum += excess * excess;
                let apart = b.at(t, &points.places) - a.at(s, &points.places);
                // Lines that cross have no direction in which they part: the other samples decide.
                let Some(away) = apart.try_normalize(1e-12) else { continue };
                let slope = -2.0 * excess / reach;
                b.push(t, slope * away, &points, gradient);
                a.push(s, -slope * away, &points, gradient);
            }
        }
        sum
    }

    fn pairs(&self) -> impl Iterator<Item = (&Sole, &Sole)> {
        let soles = &self.soles;
        soles.iter().enumerate().flat_map(|(i, a)| soles[i + 1..].iter().map(move |b| (a, b)))
    }

    /// Distance of two soles, m, and where on their segments.
    fn between(&self, a: &Sole, b: &Sole, points: &Points) -> (f64, [f64; 2]) {
        let ends = |sole: &Sole| [0.0, 1.0].map(|part| sole.at(part, &points.places));
        let at = nearest(ends(a), ends(b));
        let apart = b.at(at[1], &points.places) - a.at(at[0], &points.places);
        (apart.norm() - a.radius - b.radius, at)
    }

    fn places(&self, q: &[f64], points: &mut Points) {
        let [positions, distances, ..] = self.functions;
        let horizontal = self.call(positions, q);
        let heights = self.call(distances, q);
        points.places.clear();
        let both = horizontal.chunks_exact(2).zip(heights);
        points.places.extend(both.map(|(xy, z)| Vector3::new(xy[0], xy[1], z)));
    }

    fn slopes(&self, q: &[f64], points: &mut Points) {
        let [.., tangential, normal] = self.functions;
        (points.tangential, points.normal) = (self.call(tangential, q), self.call(normal, q));
    }

    fn call(&self, function: usize, q: &[f64]) -> Vec<f64> {
        let size = self.model.signature(function).map_or(0, |s| s.rows * s.columns);
        let mut out = vec![0.0; size];
        // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
        if self.model.evaluate(function, &State::new().with(Argument::Q, q), &mut out).is_err() {
            out.fill(f64::NAN);
        }
        out
    }
}

/// Contact points at a state.
#[derive(Debug, Default)]
struct Points {
    places: Vec<Vector3<f64>>,
    /// Column after column: by the joints, of x and y of every point.
    tangential: Vec<f64>,
    /// Likewise of z.
    normal: Vec<f64>,
}

impl Sole {
    fn new(foot: &Foot, first: usize) -> Self {
        let (count, corners) = (foot.corners.len(), &foot.corners);
        let extent = |axis: usize| {
            let of = |pick: fn(f64, f64) -> f64| {
                corners.iter().map(|c| c.position[axis]).reduce(pick).unwrap_or(0.0)
            };
            [of(f64::min), of(f64::max)]
        };
        let [x, y, z] = [extent(0), extent(1), extent(2)];
        let middle = [x, y, z].map(|[low, high]| 0.5 * (low + high));
        let (along, [low, high], [left, right]) =
            if x[1] - x[0] >= y[1] - y[0] { (0, x, y) } else { (1, y, x) };
        let system = DMatrix::from_fn(4, count, |row, point| {
            if row < 3 { corners[point].position[row] - middle[row] } else { 1.0 }
        });
        let inverse = system.pseudo_inverse(RANK).unwrap_or_else(|_| DMatrix::zeros(count, 4));
        let end = |at: f64| {
            let mut wanted = DVector::from_vec(vec![0.0, 0.0, 0.0, 1.0]);
            wanted[along] = at - middle[along];
            &inverse * wanted
        };
        Self { first, ends: [end(low), end(high)], radius: 0.5 * (right - left) }
    }

    /// Weight of a contact point at a part of the segment.
    fn weight(&self, point: usize, part: f64) -> f64 {
        (1.0 - part) * self.ends[0][point] + part * self.ends[1][point]
    }

    fn at(&self, part: f64, places: &[Vector3<f64>]) -> Vector3<f64> {
        (0..self.ends[0].len()).map(|i| places[self.first + i] * self.weight(i, part)).sum()
    }

    /// Adds what a derivative by the place at `part` is by the joints.
    fn push(&self, part: f64, slope: Vector3<f64>, points: &Points, gradient: &mut [f64]) {
        let joints = gradient.len();
        for i in 0..self.ends[0].len() {
            let (point, own) = (self.first + i, slope * self.weight(i, part));
            let columns = [
                &points.tangential[2 * point * joints..][..joints],
                &points.tangential[(2 * point + 1) * joints..][..joints],
                &points.normal[point * joints..][..joints],
            ];
            for (column, slope) in columns.into_iter().zip(own.iter()) {
                gradient.iter_mut().zip(column).for_each(|(g, by)| *g += slope * by);
            }
        }
    }
}

/// Where two segments are nearest, in parts of each (0: first end, 1: second).
fn nearest(a: [Vector3<f64>; 2], b: [Vector3<f64>; 2]) -> [f64; 2] {
    let (u, v, w) = (a[1] - a[0], b[1] - b[0], b[0] - a[0]);
    let (uu, uv, vv) = (u.norm_squared(), u.dot(&v), v.norm_squared());
    let (uw, vw) = (u.dot(&w), v.dot(&w));
    let onto =
        |product: f64, square: f64| if square > 0.0 { (product / square).clamp(0.0, 1.0) } else { 0.0 };
    let determinant = uu * vv - uv * uv;
    // Parallel segments: any place of the first will do to begin with.
    let s =
        if determinant > 1e-12 * uu * vv { ((uw * vv - vw * uv) / determinant).clamp(0.0, 1.0) } else { 0.0 };
    let t = onto(s * uv - vw, vv);
    [onto(t * uv + uw, uu), t]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::ContactPoint;

    /// The distance of two segments by brute force.
    fn searched(a: [Vector3<f64>; 2], b: [Vector3<f64>; 2]) -> f64 {
        let along = |[from, to]: [Vector3<f64>; 2]| -> Vec<Vector3<f64>> {
            (0..=200).map(|k| from + (to - from) * (f64::from(k) / 200.0)).collect()
        };
        let (a, b) = (along(a), along(b));
        let all = a.iter().flat_map(|a| b.iter().map(move |b| (a - b).norm_squared()));
        all.fold(f64::INFINITY, f64::min).sqrt()
    }

    #[test]
    fn segments_are_nearest_where_a_search_says() {
        let mut random = bipedc_effects::random::Random::new(7);
        for round in 0..60 {
            let mut point = || Vector3::from_fn(|_, _| random.symmetric());
            let (a, mut b) = ([point(), point()], [point(), point()]);
            if round % 4 == 0 {
                b[1] = b[0] + 0.7 * (a[1] - a[0]);
            }
            if round % 10 == 1 {
                b[1] = b[0];
            }
            let [s, t] = nearest(a, b);
            let found = (a[0] + (a[1] - a[0]) * s - b[0] - (b[1] - b[0]) * t).norm();
            let wanted = searched(a, b);
            assert!(found <= wanted + 1e-12 && found > wanted - 0.02, "{round}: {found} {wanted}");
        }
    }

    #[test]
    fn a_sole_is_its_middle_line_and_half_its_width() {
        let corner = |x: f64, y: f64| ContactPoint { name: String::new(), position: [x, y, -0.05] };
        let foot = Foot {
            name: "foot".to_owned(),
            frame: "foot".to_owned(),
            side: None,
            corners: vec![corner(0.15, 0.04), corner(0.15, -0.04), corner(-0.05, 0.04), corner(-0.05, -0.04)],
        };
        let sole = Sole::new(&foot, 0);
        let places: Vec<_> = foot.corners.iter().map(|c| Vector3::from(c.position)).collect();
        assert!((sole.at(0.0, &places) - Vector3::new(-0.05, 0.0, -0.05)).norm() < 1e-12);
        assert!((sole.at(1.0, &places) - Vector3::new(0.15, 0.0, -0.05)).norm() < 1e-12);
        assert!((sole.radius - 0.04).abs() < 1e-15);
        let point = Foot { corners: vec![corner(0.02, 0.01)], ..foot };
        let sole = Sole::new(&point, 0);
        let places = [Vector3::new(1.0, 2.0, 3.0)];
        assert!((sole.at(0.3, &places) - places[0]).norm() < 1e-12 && sole.radius == 0.0);
    }
}
