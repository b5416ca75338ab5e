//! Motions that nothing resists: rows in which the mass matrix is singular in whatever posture.
//!
//! A point mass on a joint's axis, two joints about one axis with nothing between them, a whole robot that is a
//! thin rod: no torque belongs to an acceleration there. Found in numbers, because a zero that went through a
//! rotation by an odd angle is dust in the expressions, and its inverse a number of no meaning.
use super::support::{cross, dot};
use crate::tree::{Inertia, JointMotion, Placement, Rotation, Tree, matrix_vector};
use bipedc_effects::random::Random;

/// A pivot below this part of the inertia of everything that the joint carries is rounding.
const DUST: f64 = 1e-12;
/// Postures that are tried: what is singular in all of them is singular by construction.
const POSTURES: u64 = 3;

/// Rows of `v`, ascending. `added` is what drives add to the diagonal, by row (kg m² or kg).
pub fn unresisted(tree: &Tree, added: &[f64]) -> Vec<usize> {
    let singular = |seed| singular_rows(tree, added, &posture(tree, seed));
    let mut rows = singular(1);
    for seed in 2..=POSTURES {
        if rows.is_empty() {
            break;
        }
        let also = singular(seed);
        rows.retain(|row| also.contains(row));
    }
    rows
}

/// Positions of the bodies' joints in (-1.5, 1.5), rad or m: nothing is aligned by chance.
fn posture(tree: &Tree, seed: u64) -> Vec<f64> {
    let mut random = Random::new(seed);
    tree.bodies.iter().map(|_| 1.5 * random.symmetric()).collect()
}

/// Rows without a pivot in one posture: D = Lᵀ Δ L, leaves first, as `derive/solve.rs` does it in symbols.
fn singular_rows(tree: &Tree, added: &[f64], posture: &[f64]) -> Vec<usize> {
    let (mut d, carried) = mass_matrix(tree, posture);
    for (k, row) in d.iter_mut().enumerate() {
        row[k] += added.get(k).copied().unwrap_or(0.0);
    }
    let mut rows = Vec::new();
    // Within a floating base and from body to body, later rows hang on earlier ones.
    let order: Vec<usize> =
        tree.bodies.iter().flat_map(|body| body.v_index..body.v_index + body.motion.nv()).collect();
    for (at, &k) in order.iter().enumerate().rev() {
        let pivot = d[k][k];
        if pivot <= DUST * carried[k] {
            rows.push(k);
            continue;
        }
        for &i in &order[..at] {
            let factor = d[i][k] / pivot;
            for &j in &order[..at] {
                d[i][j] -= factor * d[k][j];
            }
        }
    }
    rows.sort_unstable();
    rows
}

/// Mass matrix by composite rigid bodies, and by row the inertia of all that it moves: mass, or the sum of the
/// principal moments about the joint's origin.
fn mass_matrix(tree: &Tree, posture: &[f64]) -> (Vec<Vec<f64>>, Vec<f64>) {
    let placements: Vec<Placement> =
        tree.bodies.iter().zip(posture).map(|(body, &x)| moved(body, x)).collect();
    let mut composite: Vec<Inertia> = tree.bodies.iter().map(|body| body.inertia).collect();
    for index in (0..composite.len()).rev() {
        if let Some(parent) = tree.bodies[index].parent {
            composite[parent] = composite[parent].plus(&composite[index].transformed(&placements[index]));
        }
    }
    let mut d = vec![vec![0.0; tree.nv]; tree.nv];
    let mut carried = vec![0.0; tree.nv];
    for (index, body) in tree.bodies.iter().enumerate() {
        for (k, motion) in unit_motions(body.motion).into_iter().enumerate() {
            let column = body.v_index + k;
            let own = &composite[index];
            let second: f64 = (0..3).map(|i| own.second_moment[i][i].abs()).sum();
            carried[column] = if motion.0 == [0.0; 3] { second } else { own.mass.abs() };
            let mut wrench = momentum(own, motion);
            let mut at = index;
            loop {
                for (l, (linear, angular)) in unit_motions(tree.bodies[at].motion).into_iter().enumerate() {
                    let x = dot(linear, wrench.0) + dot(angular, wrench.1);
                    let row = tree.bodies[at].v_index + l;
                    d[row][column] = x;
                    d[column][row] = x;
                }
                let Some(parent) = tree.bodies[at].parent else { break };
                wrench = in_parent(&placements[at], wrench);
                at = parent;
            }
        }
    }
    (d, carried)
}

/// Where the body is in its parent's frame; a free one stays where it is, which changes no pivot.
fn moved(body: &crate::tree::Body, x: f64) -> Placement {
    let step = match body.motion {
        JointMotion::Free => Placement::default(),
        JointMotion::Revolute { axis, .. } => {
            Placement { rotation: Rotation(vec![(axis, x)]), translation: [0.0; 3] }
        }
        JointMotion::Prismatic { axis, .. } => Placement::shift(unit(axis).map(|e| e * x)),
    };
    body.placement.then(&step)
}

type Pair = ([f64; 3], [f64; 3]);

/// Linear and angular velocity of the body per unit of each of its coordinates, in its axes; the sign of a
/// reversed joint cancels in every pivot.
fn unit_motions(motion: JointMotion) -> Vec<Pair> {
    match motion {
        JointMotion::Free => {
            (0..6).map(|k| if k < 3 { (unit(k), [0.0; 3]) } else { ([0.0; 3], unit(k - 3)) }).collect()
        }
        JointMotion::Revolute { axis, .. } => vec![([0.0; 3], unit(axis))],
        JointMotion::Prismatic { axis, .. } => vec![(unit(axis), [0.0; 3])],
    }
}

/// Linear and angular momentum about the frame's origin.
fn momentum(body: &Inertia, (linear, angular): Pair) -> Pair {
    let turned = cross(angular, body.first_moment);
    let moment = cross(body.first_moment, linear);
    let spin = matrix_vector(&body.second_moment, angular);
    ([0, 1, 2].map(|i| body.mass * linear[i] + turned[i]), [0, 1, 2].map(|i| moment[i] + spin[i]))
}

fn in_parent(placement: &Placement, (force, moment): Pair) -> Pair {
    let m = placement.rotation.matrix();
    let (force, moment) = (matrix_vector(&m, force), matrix_vector(&m, moment));
    let lever = cross(placement.translation, force);
    (force, [0, 1, 2].map(|i| moment[i] + lever[i]))
}

fn unit(axis: usize) -> [f64; 3] {
    [0, 1, 2].map(|k| if k == axis { 1.0 } else { 0.0 })
}
