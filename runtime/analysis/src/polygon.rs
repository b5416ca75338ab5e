//! Convex polygons on the ground: supports and soles.

/// A convex polygon, corners counter-clockwise, m.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Polygon {
    /// Corners.
    pub corners: Vec<[f64; 2]>,
    /// Index of each corner among the points it was made of.
    pub sources: Vec<usize>,
}

/// How far two polygons are apart, and by what.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gap {
    /// m; negative where polygons overlap.
    pub distance: f64,
    /// Corners of the separating edge, as indices among the points that its polygon was made of.
    pub edge: [usize; 2],
    /// Nearest corner of the other polygon, likewise.
    pub nearest: usize,
    /// Whether the edge is the first polygon's.
    pub of_first: bool,
}

/// Signed distance of `c` from the line through `a` and `b`, positive on its left, m; with its derivatives by the three.
pub fn left_of(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> (f64, [[f64; 2]; 3]) {
    let (e, r) = ([b[0] - a[0], b[1] - a[1]], [c[0] - a[0], c[1] - a[1]]);
    let length = e[0].hypot(e[1]);
    let distance = (e[0] * r[1] - e[1] * r[0]) / length;
    let by_c = [-e[1] / length, e[0] / length];
    let square = length * length;
    let by_b = [r[1] / length - distance * e[0] / square, -r[0] / length - distance * e[1] / square];
    // Moving all three changes nothing.
    (distance, [[-by_b[0] - by_c[0], -by_b[1] - by_c[1]], by_b, by_c])
}

/// Twice the area of the triangle `a b c`, m², positive if it runs counter-clockwise.
pub fn cross(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

impl Polygon {
    /// The convex hull of points (Andrew's monotone chain).
    pub fn hull(points: &[[f64; 2]]) -> Self {
        let mut order: Vec<usize> = (0..points.len()).collect();
        order.sort_by(|&a, &b| {
            points[a][0].total_cmp(&points[b][0]).then(points[a][1].total_cmp(&points[b][1]))
        });
        let half = |order: &mut dyn Iterator<Item = usize>| {
            let mut chain: Vec<usize> = Vec::new();
            for next in order {
                while let [.., a, b] = chain[..] {
                    if cross(points[a], points[b], points[next]) > 0.0 {
                        break;
                    }
                    chain.pop();
                }
                chain.push(next);
            }
            chain.pop();
            chain
        };
        let mut sources = half(&mut order.iter().copied());
        sources.extend(half(&mut order.iter().rev().copied()));
        Self { corners: sources.iter().map(|&k| points[k]).collect(), sources }
    }

    /// Edges, as indices among the corners, that have a length; none of a polygon without an inside.
    pub fn edges(&self) -> impl Iterator<Item = [usize; 2]> + '_ {
        let count = self.corners.len();
        (0..count)
            .map(move |k| [k, (k + 1) % count])
            .filter(move |[a, b]| count > 2 && self.corners[*a] != self.corners[*b])
    }

    /// How far a point is from the nearest edge, m; negative outside. Without an inside minus infinity, less for a point
    /// outside a corner than its true distance.
    pub fn inside(&self, point: [f64; 2]) -> f64 {
        let distance = |[a, b]: [usize; 2]| left_of(self.corners[a], self.corners[b], point).0;
        let least = self.edges().map(distance).fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { f64::NEG_INFINITY }
    }

    /// By how much two polygons are apart along the edge normal that separates them best.
    pub fn apart(&self, other: &Self) -> Option<Gap> {
        let best = |one: &Self, two: &Self, of_first: bool| {
            let along = |[a, b]: [usize; 2]| {
                let distance = |k: &usize| -left_of(one.corners[a], one.corners[b], two.corners[*k]).0;
                let nearest = (0..two.corners.len()).min_by(|x, y| distance(x).total_cmp(&distance(y)))?;
                let edge = [one.sources[a], one.sources[b]];
                Some(Gap { distance: distance(&nearest), edge, nearest: two.sources[nearest], of_first })
            };
            one.edges().filter_map(along).max_by(|a, b| a.distance.total_cmp(&b.distance))
        };
        let gaps = [best(self, other, true), best(other, self, false)];
        gaps.into_iter().flatten().max_by(|a, b| a.distance.total_cmp(&b.distance))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square(x: f64, y: f64) -> Polygon {
        Polygon::hull(&[[x, y], [x + 1.0, y], [x + 1.0, y + 1.0], [x, y + 1.0], [x + 0.5, y + 0.5]])
    }

    #[test]
    fn a_square_has_four_corners_and_an_inside() {
        let square = square(0.0, 0.0);
        assert_eq!(square.corners.len(), 4);
        assert!(!square.sources.contains(&4));
        assert!((square.inside([0.5, 0.3]) - 0.3).abs() < 1e-15);
        assert!((square.inside([0.5, -0.2]) + 0.2).abs() < 1e-15);
        assert_eq!(Polygon::hull(&[[0.0, 0.0], [1.0, 0.0]]).inside([0.5, 0.0]), f64::NEG_INFINITY);
        assert_eq!(Polygon::hull(&[]).inside([0.0, 0.0]), f64::NEG_INFINITY);
    }

    #[test]
    fn derivatives_of_a_distance() {
        let points = [[0.1, -0.2], [0.7, 0.3], [-0.2, 0.6]];
        let (_, slopes) = left_of(points[0], points[1], points[2]);
        for k in 0..3 {
            for axis in 0..2 {
                let moved = |step: f64| {
                    let mut p = points;
                    p[k][axis] += step;
                    left_of(p[0], p[1], p[2]).0
                };
                let numeric = (moved(1e-6) - moved(-1e-6)) / 2e-6;
                assert!((numeric - slopes[k][axis]).abs() < 1e-9, "{k} {axis}");
            }
        }
    }

    #[test]
    fn gaps_between_squares() {
        assert!((square(0.0, 0.0).apart(&square(0.2, 1.5)).unwrap().distance - 0.5).abs() < 1e-15);
        assert!(square(0.0, 0.0).apart(&square(0.2, 0.9)).unwrap().distance < 0.0);
    }
}
