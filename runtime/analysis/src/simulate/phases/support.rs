//! What the ground does to standing feet, from the rows of the constrained dynamics.

/// One constraint row of a phase and what its force is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Index of the foot.
    pub foot: usize,
    /// See [`RowKind`].
    pub kind: RowKind,
}

/// Forces in world axes at the middle of what stands; moments there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RowKind {
    /// N
    ForceX,
    /// N
    ForceY,
    /// N
    ForceZ,
    /// N m
    MomentX,
    /// N m
    MomentY,
    /// Of an edge: about the axis along the sole that is perpendicular to it, N m.
    MomentAcross,
    /// N m, or a moment that no assumption asks for.
    Other,
}

impl RowKind {
    /// By the end of a row's name, `force/x`.
    pub fn named(name: &str) -> Self {
        match name {
            "force/x" => Self::ForceX,
            "force/y" => Self::ForceY,
            "force/z" => Self::ForceZ,
            "moment/x" => Self::MomentX,
            "moment/y" => Self::MomentY,
            "moment/across" => Self::MomentAcross,
            _ => Self::Other,
        }
    }
}

/// Force and moment on one foot.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Load {
    /// x, y, z, N
    pub force: [f64; 3],
    /// About x and y, N m.
    pub moment: [f64; 2],
    /// Whether the whole sole stands.
    pub flat: bool,
}

impl Load {
    /// Of a foot, from the forces of all rows.
    pub fn of(foot: usize, rows: &[Row], forces: &[f64]) -> Self {
        let mut load = Self::default();
        for (row, force) in rows.iter().zip(forces).filter(|(row, _)| row.foot == foot) {
            match row.kind {
                RowKind::ForceX => load.force[0] = *force,
                RowKind::ForceY => load.force[1] = *force,
                RowKind::ForceZ => load.force[2] = *force,
                RowKind::MomentX => load.moment[0] = *force,
                RowKind::MomentY => load.moment[1] = *force,
                RowKind::MomentAcross | RowKind::Other => {}
            }
            load.flat |= row.kind == RowKind::MomentY;
        }
        load
    }

    /// Centre of pressure relative to the middle of the sole, m (4.43).
    pub fn pressure(&self) -> [f64; 2] {
        [-self.moment[1] / self.force[2], self.moment[0] / self.force[2]]
    }
}

/// How far a place is inside the hull of some points (negative: outside), m; along x alone in the plane.
pub(super) fn inside(place: [f64; 2], points: &[[f64; 2]], planar: bool) -> f64 {
    if planar {
        let low = points.iter().map(|p| p[0]).fold(f64::INFINITY, f64::min);
        let high = points.iter().map(|p| p[0]).fold(f64::NEG_INFINITY, f64::max);
        return f64::min(place[0] - low, high - place[0]);
    }
    // Every pair of points that has all others on its left is an edge of the hull.
    let mut least = f64::INFINITY;
    for a in points {
        for b in points.iter().filter(|b| *b != a) {
            let along = [b[0] - a[0], b[1] - a[1]];
            let length = along[0].hypot(along[1]);
            let left = |p: &[f64; 2]| (along[0] * (p[1] - a[1]) - along[1] * (p[0] - a[0])) / length;
            if points.iter().all(|p| left(p) > -1e-9) {
                least = least.min(left(&place));
            }
        }
    }
    least
}

/// Distance of a place from the line through some points (a point in the plane), positive on the side of `middle`, m.
pub(super) fn before_line(place: [f64; 2], line: &[[f64; 2]], middle: [f64; 2], planar: bool) -> f64 {
    let a = line[0];
    if planar || line.len() < 2 {
        let side = (middle[0] - a[0]).signum();
        return side * (place[0] - a[0]);
    }
    let along = [line[1][0] - a[0], line[1][1] - a[1]];
    let length = along[0].hypot(along[1]);
    let left = |p: [f64; 2]| (along[0] * (p[1] - a[1]) - along[1] * (p[0] - a[0])) / length;
    left(place) * left(middle).signum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hulls() {
        let sole = [[0.1, 0.05], [0.1, -0.05], [-0.1, 0.05], [-0.1, -0.05]];
        assert!((inside([0.0, 0.0], &sole, false) - 0.05).abs() < 1e-12);
        assert!((inside([0.08, 0.0], &sole, false) - 0.02).abs() < 1e-12);
        assert!((inside([0.13, 0.0], &sole, false) + 0.03).abs() < 1e-12);
        assert!((inside([0.13, 9.0], &sole, true) + 0.03).abs() < 1e-12);
        let front = [[0.1, 0.05], [0.1, -0.05]];
        assert!((before_line([0.07, 0.01], &front, [0.0, 0.0], false) - 0.03).abs() < 1e-12);
        assert!((before_line([0.12, 0.01], &front, [0.0, 0.0], false) + 0.02).abs() < 1e-12);
        assert!((before_line([0.07, 0.01], &front[..1], [0.0, 0.0], true) - 0.03).abs() < 1e-12);
    }

    #[test]
    fn pressure_is_where_the_moment_vanishes() {
        // 100 N at x = 0.03, y = −0.02: moments r × F = (y F, −x F).
        let load = Load { force: [0.0, 0.0, 100.0], moment: [-2.0, -3.0], flat: true };
        assert_eq!(load.pressure(), [0.03, -0.02]);
    }
}
