//! Where links that are no feet can touch the ground: a few points of the shapes of the URDF.
use super::parts::{bounds, solids};
use bipedc_compiler::robot::Robot;
use std::path::Path;

/// The six directions along the axes and the eight between them: of a shape the farthest points in these can touch the ground.
const DIRECTIONS: [[f64; 3]; 14] = [
    [1.0, 1.0, 1.0],
    [1.0, 1.0, -1.0],
    [1.0, -1.0, 1.0],
    [1.0, -1.0, -1.0],
    [-1.0, 1.0, 1.0],
    [-1.0, 1.0, -1.0],
    [-1.0, -1.0, 1.0],
    [-1.0, -1.0, -1.0],
    [1.0, 0.0, 0.0],
    [-1.0, 0.0, 0.0],
    [0.0, 1.0, 0.0],
    [0.0, -1.0, 0.0],
    [0.0, 0.0, 1.0],
    [0.0, 0.0, -1.0],
];
/// Points nearer than this to another one are that one, m.
const SAME: f64 = 1e-3;

/// Points of every link that has a shape, in the link's frame, m: of `<collision>`, else of `<visual>` elements. Corners of
/// boxes, rims of cylinders and capsules, spheres all around; of a mesh its hull. Of links with many the outermost remain.
pub fn touching_points(robot: &Robot) -> Vec<(String, Vec<[f64; 3]>)> {
    let folder = robot.sources.urdf_path.parent().unwrap_or(Path::new(""));
    let mut links: Vec<(String, Vec<[f64; 3]>)> = Vec::new();
    for (link, form, placement) in solids(&robot.sources.urdf_text, folder, ["collision", "visual"]) {
        let at =
            |point: &[f64; 3]| placement.then(&bipedc_compiler::tree::Placement::shift(*point)).translation;
        let points = form.corners().iter().map(at);
        match links.iter_mut().find(|(other, _)| *other == link) {
            Some((_, own)) => own.extend(points),
            None => links.push((link, points.collect())),
        }
    }
    links.into_iter().map(|(link, points)| (link, outermost(&points))).collect()
}

/// The farthest points in all directions, from the middle of what they span; each once.
fn outermost(points: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let [low, high] = bounds(points.iter());
    let half = [0, 1, 2].map(|k| (0.5 * (high[k] - low[k])).max(SAME));
    // Directions follow the proportions of the link, so that the corners of a flat box are its corners.
    let reach = |point: &[f64; 3], direction: &[f64; 3]| -> f64 {
        (0..3).map(|k| direction[k] * point[k] / half[k]).sum()
    };
    let mut found: Vec<[f64; 3]> = Vec::new();
    for direction in &DIRECTIONS {
        let farthest = points.iter().max_by(|a, b| reach(a, direction).total_cmp(&reach(b, direction)));
        let near = |a: &[f64; 3], b: &[f64; 3]| (0..3).all(|k| (a[k] - b[k]).abs() < SAME);
        // Where a corner already reaches as far, as of boxes, another point would be one too many.
        let reached = |far: &[f64; 3]| {
            found.iter().any(|p| near(p, far) || reach(p, direction) > reach(far, direction) - 1e-9)
        };
        if let Some(far) = farthest.filter(|far| !reached(far)) {
            found.push(*far);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_box_touches_with_its_corners() {
        let sign = |bit: usize, k: usize| if bit >> k & 1 == 1 { 0.5 } else { -0.5 };
        let size = [0.1, 0.6, 0.02];
        let corners: Vec<[f64; 3]> = (0..8).map(|bit| [0, 1, 2].map(|k| sign(bit, k) * size[k])).collect();
        let mut many = corners.clone();
        many.extend([[0.0; 3], [0.0, 0.1, 0.0]]);
        let found = outermost(&many);
        assert_eq!(found.len(), 8, "{found:?}");
        assert!(corners.iter().all(|corner| found.contains(corner)));
        assert!(outermost(&[]).is_empty());
    }
}
