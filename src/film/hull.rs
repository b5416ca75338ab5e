//! Convex hulls of a handful of points.
use bipedc_analysis::report::Form;

/// Points nearer than this part of their extent to a plane lie in it.
const FLAT: f64 = 1e-6;

/// The convex solid around some points, its faces triangles; `None` if they lie in a plane. Made for a few dozen points that
/// may lie anywhere, the same place included: the cost grows with their square.
pub(super) fn hull(points: &[[f64; 3]]) -> Option<Form> {
    let extent =
        points.iter().flat_map(|p| points.first().map(|q| length(minus(*p, *q)))).fold(0.0, f64::max);
    let mut faces = tetrahedron(points, FLAT * extent)?;
    for (new, point) in points.iter().enumerate() {
        let seen = |face: &[usize; 3]| height(points, face, *point) > FLAT * extent;
        let (gone, kept): (Vec<[usize; 3]>, Vec<[usize; 3]>) = faces.iter().partition(|face| seen(face));
        faces = kept;
        let edges: Vec<[usize; 2]> =
            gone.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
        // The rim of what the new point sees: edges whose other face it does not see.
        let rim = edges.iter().filter(|[a, b]| !edges.contains(&[*b, *a]));
        faces.extend(rim.map(|[a, b]| [*a, *b, new]));
    }
    let mut used: Vec<usize> = faces.iter().flatten().copied().collect();
    used.sort_unstable();
    used.dedup();
    let place = |corner: usize| used.binary_search(&corner).unwrap_or_default();
    Some(Form::Solid {
        corners: used.iter().map(|&corner| points[corner]).collect(),
        faces: faces.iter().map(|face| face.map(place).to_vec()).collect(),
    })
}

/// Faces of four points that span a body, looking outwards.
fn tetrahedron(points: &[[f64; 3]], least: f64) -> Option<Vec<[usize; 3]>> {
    let farthest = |measure: &dyn Fn([f64; 3]) -> f64| {
        let all = points.iter().enumerate().map(|(i, point)| (i, measure(*point)));
        all.filter(|(_, x)| *x > least).max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    };
    let a = 0;
    let b = farthest(&|p| length(minus(p, points[a])))?;
    let axis = minus(points[b], points[a]);
    let c = farthest(&|p| length(cross(axis, minus(p, points[a]))) / length(axis))?;
    let d = farthest(&|p| height(points, &[a, b, c], p).abs())?;
    let [b, c] = if height(points, &[a, b, c], points[d]) > 0.0 { [c, b] } else { [b, c] };
    Some(vec![[a, b, c], [a, d, b], [b, d, c], [c, d, a]])
}

/// Height of a point above a face, positive outside, m; of a face without an area minus infinity.
fn height(points: &[[f64; 3]], face: &[usize; 3], point: [f64; 3]) -> f64 {
    let [a, b, c] = face.map(|corner| points[corner]);
    let normal = cross(minus(b, a), minus(c, a));
    let area = length(normal);
    if area > 0.0 { dot(normal, minus(point, a)) / area } else { f64::NEG_INFINITY }
}

fn minus(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[k] - b[k])
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|k| a[k] * b[k]).sum()
}

fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn random(count: usize) -> Vec<[f64; 3]> {
        let mut state = 5_u64;
        let mut next = move || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) as f64 / (1_u64 << 31) as f64 - 0.5
        };
        (0..count).map(|_| [next(), 2.0 * next(), 3.0 * next()]).collect()
    }

    fn corners_and_faces(form: Form) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
        let Form::Solid { corners, faces } = form else { panic!("no solid") };
        (corners, faces.iter().map(|face| [face[0], face[1], face[2]]).collect())
    }

    #[test]
    fn no_point_lies_outside_and_the_surface_is_closed() {
        let mut all = random(60);
        // Repeated points, and points in one plane with others.
        all.extend_from_within(..5);
        all.extend([[0.5, 1.0, 1.5], [0.5, 1.0, -1.5], [0.5, -1.0, 1.5], [0.5, 0.0, 0.0], [0.5, 0.1, 0.2]]);
        let (corners, faces) = corners_and_faces(hull(&all).unwrap());
        for face in &faces {
            assert!(all.iter().all(|point| height(&corners, face, *point) < 1e-5), "{face:?}");
        }
        let edges: Vec<[usize; 2]> =
            faces.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]).collect();
        assert!(edges.iter().all(|[a, b]| edges.iter().filter(|e| **e == [*b, *a]).count() == 1));
        // Euler: corners − edges + faces = 2.
        assert_eq!(corners.len() + faces.len(), edges.len() / 2 + 2);
    }

    #[test]
    fn a_cube_has_its_volume() {
        let bit = |i: usize, k: usize| if i >> k & 1 == 1 { 1.0 } else { 0.0 };
        let mut cube: Vec<[f64; 3]> = (0..8).map(|i| [bit(i, 0), bit(i, 1), bit(i, 2)]).collect();
        cube.push([0.5, 0.5, 0.5]);
        let (corners, faces) = corners_and_faces(hull(&cube).unwrap());
        let volume = |[a, b, c]: &[usize; 3]| dot(corners[*a], cross(corners[*b], corners[*c])) / 6.0;
        assert!((faces.iter().map(volume).sum::<f64>() - 1.0).abs() < 1e-12);
        assert_eq!((corners.len(), faces.len()), (8, 12));
    }

    #[test]
    fn what_is_flat_has_no_hull() {
        assert!(hull(&[]).is_none());
        assert!(hull(&[[1.0; 3]; 7]).is_none());
        assert!(hull(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]]).is_none());
    }
}
