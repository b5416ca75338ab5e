//! Contact points: distances to the ground, their directions W and rates w.
use super::frames::{frame_pose, jacobian, jacobian_rate_times_velocity, world_poses};
use super::model::RobotModel;
use crate::expression::{Sym, Vector3};
use crate::tree::{BaseKind, JointMotion, Tree, matrix_vector};

/// Everything the contact laws (4.2)–(4.7) need, for all points of `tree.points` in their order.
///
/// The ground is the plane z = 0. World axes; tangential directions are x and y of the first point, then of
/// the second, …; a planar robot ([`is_planar`]) has x alone.
#[derive(Debug, Clone)]
pub struct ContactPoints<'g> {
    /// Normal distances κ_N: heights above the ground, m; n elements.
    pub normal: Vec<Sym<'g>>,
    /// Tangential positions κ_T, m; 2 n elements (planar: n).
    pub tangential: Vec<Sym<'g>>,
    /// W_N, `nv × n`, rows in the order of `v`: κ̇_N = W_Nᵀ v, and W_N λ_N is the generalised force. The
    /// thesis prints W_Nᵀ for both; W = (∂κ/∂q)ᵀ is the form that fits the dimensions of (4.7).
    pub normal_directions: Vec<Vec<Sym<'g>>>,
    /// W_T, `nv × 2n` (planar: `nv × n`).
    pub tangential_directions: Vec<Vec<Sym<'g>>>,
    /// w_N = (d/dt W_Nᵀ) v, m/s²: the normal accelerations are W_Nᵀ v̇ + w_N.
    pub normal_rate: Vec<Sym<'g>>,
    /// w_T = (d/dt W_Tᵀ) v, m/s².
    pub tangential_rate: Vec<Sym<'g>>,
}

/// Distances, directions and rates of all contact points.
pub fn contact_points<'g>(model: &RobotModel<'g, '_>) -> ContactPoints<'g> {
    let tree = model.tree;
    let poses = world_poses(model);
    let tangents: &[usize] = if is_planar(tree) { &[0] } else { &[0, 1] };
    let mut out = ContactPoints {
        normal: Vec::new(),
        tangential: Vec::new(),
        normal_directions: vec![Vec::new(); tree.nv],
        tangential_directions: vec![Vec::new(); tree.nv],
        normal_rate: Vec::new(),
        tangential_rate: Vec::new(),
    };
    for point in &tree.points {
        let position = frame_pose(model, &poses, point).position;
        let rate = jacobian_rate_times_velocity(model, &poses, point);
        let columns: Vec<Vector3<'g>> =
            jacobian(model, &poses, point.body, position).into_iter().map(|(linear, _)| linear).collect();
        out.normal.push(position[2]);
        out.normal_rate.push(rate[2]);
        out.tangential.extend(tangents.iter().map(|&k| position[k]));
        out.tangential_rate.extend(tangents.iter().map(|&k| rate[k]));
        for (row, column) in columns.iter().enumerate() {
            out.normal_directions[row].push(column[2]);
            out.tangential_directions[row].extend(tangents.iter().map(|&k| column[k]));
        }
    }
    out
}

/// Whether the robot can move in the x-z plane only: a planar base, or a fixed or pivoting one whose joints
/// all turn about the world's y axis or slide across it.
pub fn is_planar(tree: &Tree) -> bool {
    match tree.base {
        BaseKind::Planar => true,
        BaseKind::Floating => false,
        BaseKind::Fixed | BaseKind::Pivot => {
            let tree = tree.structure();
            let rotations = zero_rotations(tree);
            tree.bodies.iter().zip(&rotations).all(|(body, rotation)| match body.motion {
                JointMotion::Revolute { axis, .. } => rotation[1][axis].abs() > 1.0 - 1e-12,
                JointMotion::Prismatic { axis, .. } => rotation[1][axis].abs() < 1e-12,
                JointMotion::Free => false,
            })
        }
    }
}

/// Rotation (rows) of every body in the world when all joint positions are zero and the base is upright.
pub(super) fn zero_rotations(tree: &Tree) -> Vec<[[f64; 3]; 3]> {
    let mut out: Vec<[[f64; 3]; 3]> = Vec::new();
    for body in &tree.bodies {
        let own = body.placement.rotation.matrix();
        let columns = [0, 1, 2].map(|k| own.map(|row| row[k]));
        let rotation = match body.parent {
            Some(parent) => {
                let turned = columns.map(|column| matrix_vector(&out[parent], column));
                [0, 1, 2].map(|r| [0, 1, 2].map(|c| turned[c][r]))
            }
            None => own,
        };
        out.push(rotation);
    }
    out
}
