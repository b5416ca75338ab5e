//! Where all bodies are.
use bipedc_analysis::report::Pose;
use bipedc_compiler::tree::{Body, JointMotion, Placement, Tree, matrix_vector};

type Matrix = [[f64; 3]; 3];
const IDENTITY: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Rotation matrix and origin.
type Place = (Matrix, [f64; 3]);

/// The frame of each body of the tree in the world for a configuration `q` as the model's (m, rad, quaternion x y z w;
/// elements that are missing are zero).
pub fn poses(tree: &Tree, q: &[f64]) -> Vec<Pose> {
    let mut placed: Vec<Place> = Vec::with_capacity(tree.bodies.len());
    for body in &tree.bodies {
        let parent = body.parent.and_then(|parent| placed.get(parent)).copied();
        let carried = after(parent.unwrap_or((IDENTITY, [0.0; 3])), place(&body.placement));
        placed.push(after(carried, moved(body, q)));
    }
    let pose = |&(rotation, position): &Place| Pose { position, orientation: quaternion(&rotation) };
    placed.iter().map(pose).collect()
}

fn place(placement: &Placement) -> Place {
    (placement.rotation.matrix(), placement.translation)
}

/// `inner` is placed in the frame that `outer` places.
fn after((outer, origin): Place, (inner, place): Place) -> Place {
    let shifted = matrix_vector(&outer, place);
    let product = |r: usize, c: usize| (0..3).map(|k| outer[r][k] * inner[k][c]).sum();
    let rotation = [0, 1, 2].map(|r| [0, 1, 2].map(|c| product(r, c)));
    (rotation, [0, 1, 2].map(|i| origin[i] + shifted[i]))
}

/// What its joint does in a body's frame.
fn moved(body: &Body, q: &[f64]) -> Place {
    let at = |offset: usize| q.get(body.q_index + offset).copied().unwrap_or(0.0);
    let signed = |reversed: bool| if reversed { -at(0) } else { at(0) };
    match body.motion {
        JointMotion::Free => (matrix([at(3), at(4), at(5), at(6)]), [at(0), at(1), at(2)]),
        JointMotion::Revolute { axis, reversed } => {
            let (sine, cosine) = signed(reversed).sin_cos();
            let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
            let mut rotation = IDENTITY;
            (rotation[u][u], rotation[v][v]) = (cosine, cosine);
            (rotation[u][v], rotation[v][u]) = (-sine, sine);
            (rotation, [0.0; 3])
        }
        JointMotion::Prismatic { axis, reversed } => {
            let mut shift = [0.0; 3];
            shift[axis] = signed(reversed);
            (IDENTITY, shift)
        }
    }
}

/// Of a quaternion x y z w of about unit length.
fn matrix(orientation: [f64; 4]) -> Matrix {
    let pose = Pose { position: [0.0; 3], orientation };
    let columns = IDENTITY.map(|axis| pose.at(axis));
    [0, 1, 2].map(|r| [0, 1, 2].map(|c| columns[c][r]))
}

/// Of a rotation matrix, after Shepperd (1978): divides by the largest component.
fn quaternion(m: &Matrix) -> [f64; 4] {
    let trace = m[0][0] + m[1][1] + m[2][2];
    let (i, largest) = [m[0][0], m[1][1], m[2][2]]
        .into_iter()
        .enumerate()
        .fold((3, trace), |best, (i, x)| if x > best.1 { (i, x) } else { best });
    let mut q = [0.0; 4];
    if i == 3 {
        let s = 2.0 * (1.0 + largest).sqrt();
        q = [(m[2][1] - m[1][2]) / s, (m[0][2] - m[2][0]) / s, (m[1][0] - m[0][1]) / s, 0.25 * s];
    } else {
        let (j, k) = ((i + 1) % 3, (i + 2) % 3);
        let s = 2.0 * (1.0 + m[i][i] - m[j][j] - m[k][k]).sqrt();
        q[i] = 0.25 * s;
        q[j] = (m[j][i] + m[i][j]) / s;
        q[k] = (m[k][i] + m[i][k]) / s;
        q[3] = (m[k][j] - m[j][k]) / s;
    }
    q
}
