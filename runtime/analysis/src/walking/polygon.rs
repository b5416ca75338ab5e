//! Support polygons: convex hulls of contact points, margins, distances.
use crate::polygon::{Polygon, cross};

/// A point of the ground, m.
pub type Point = [f64; 2];

/// The convex hull, counterclockwise; of points without an inside the points themselves.
pub fn hull(points: &[Point]) -> Vec<Point> {
    let mut distinct = points.to_vec();
    distinct.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    distinct.dedup();
    if distinct.len() < 3 { distinct } else { Polygon::hull(&distinct).corners }
}

/// How far a point lies inside a convex polygon (counterclockwise), m: the distance to the nearest edge, outside negative.
pub fn margin(polygon: &[Point], point: Point) -> f64 {
    let inside = edges(polygon).map(|(a, b)| {
        let length = (b[0] - a[0]).hypot(b[1] - a[1]);
        if length > 0.0 { cross(a, b, point) / length } else { f64::INFINITY }
    });
    let least = inside.fold(f64::INFINITY, f64::min);
    if polygon.len() > 2 && least >= 0.0 {
        return least;
    }
    -edges(polygon).map(|(a, b)| to_segment(point, a, b)).fold(f64::INFINITY, f64::min)
}

/// Distance between two convex polygons (counterclockwise), m; 0 if they overlap or one is empty.
pub fn distance(a: &[Point], b: &[Point]) -> f64 {
    let within = |one: &[Point], other: &[Point]| one.iter().any(|p| margin(other, *p) >= 0.0);
    let crossing = |(p, q): (Point, Point)| {
        edges(b).any(|(r, s)| cross(p, q, r) * cross(p, q, s) < 0.0 && cross(r, s, p) * cross(r, s, q) < 0.0)
    };
    if a.is_empty() || b.is_empty() || within(a, b) || within(b, a) || edges(a).any(crossing) {
        return 0.0;
    }
    let apart = |one: &[Point], other: &[Point]| {
        let near = |p: &Point| edges(other).map(|(a, b)| to_segment(*p, a, b)).fold(f64::INFINITY, f64::min);
        one.iter().map(near).fold(f64::INFINITY, f64::min)
    };
    apart(a, b).min(apart(b, a))
}

fn edges(polygon: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    (0..polygon.len()).map(|k| (polygon[k], polygon[(k + 1) % polygon.len()]))
}

fn to_segment(p: Point, a: Point, b: Point) -> f64 {
    let way = [b[0] - a[0], b[1] - a[1]];
    let square = way[0] * way[0] + way[1] * way[1];
    let along = (way[0] * (p[0] - a[0]) + way[1] * (p[1] - a[1])) / square;
    let part = if square > 0.0 { along.clamp(0.0, 1.0) } else { 0.0 };
    (p[0] - a[0] - part * way[0]).hypot(p[1] - a[1] - part * way[1])
}
