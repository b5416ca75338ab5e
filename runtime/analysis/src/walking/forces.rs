//! How two feet share the wrench of the ground, and the corners of a foot its share.
use super::polygon::Point;
use nalgebra::{DMatrix, Matrix6, Vector3, Vector6};

/// Force (N), then moment about the world's origin (N m), world axes.
pub type Wrench = [f64; 6];

/// Shares a wrench between the feet that stand: `shares` (at least 0, together 1) say how much each shall carry. The least forces and
/// moments about the `centers` of the soles, moments by the length `arm` (m), each divided by its share, add up to the wrench; so a foot
/// whose share goes to nothing is let go without a jump, and a single foot carries all of it.
pub fn distribute(wrench: &Wrench, centers: [[f64; 3]; 2], shares: [f64; 2], arm: f64) -> [Wrench; 2] {
    // w = Σ G_k f_k with G_k from a foot's own wrench to the world's origin; f_k = s_k W⁻¹ G_kᵀ μ.
    let to_origin = centers.map(|center| carried(center, arm));
    let mut gram = Matrix6::zeros();
    for (map, share) in to_origin.iter().zip(shares) {
        gram += share.max(0.0) * map * map.transpose();
    }
    let target = Vector6::from_column_slice(wrench);
    let multipliers = gram.lu().solve(&target).unwrap_or_else(Vector6::zeros);
    let mut found = [[0.0; 6]; 2];
    for k in 0..2 {
        let own = shares[k].max(0.0) * to_origin[k] * (to_origin[k].transpose() * multipliers);
        found[k].copy_from_slice(own.as_slice());
    }
    found
}

/// From (force, moment / arm) at a place to force and moment about the origin.
fn carried(place: [f64; 3], arm: f64) -> Matrix6<f64> {
    let mut map = Matrix6::identity();
    let r = Vector3::from(place).cross_matrix();
    map.fixed_view_mut::<3, 3>(3, 0).copy_from(&r);
    for k in 3..6 {
        map[(k, k)] = arm;
    }
    map
}

/// Forces on the corners of a sole on the ground (z = 0) with the vertical force and horizontal moments of a wrench: the least ones. Horizontal
/// forces are shared as the vertical ones. A centre of pressure near an edge may ask a corner to pull: that is cut off.
pub fn corner_forces(wrench: &Wrench, corners: &[Point]) -> Vec<[f64; 3]> {
    let n = corners.len();
    let rows = DMatrix::from_fn(3, n, |row, k| match row {
        0 => 1.0,
        1 => corners[k][1],
        _ => -corners[k][0],
    });
    let target = nalgebra::DVector::from_column_slice(&[wrench[2], wrench[3], wrench[4]]);
    let vertical = rows.clone().svd(true, true).solve(&target, 1e-9).map(|x| x.as_slice().to_vec());
    let vertical: Vec<f64> = vertical.unwrap_or_else(|_| vec![0.0; n]).iter().map(|f| f.max(0.0)).collect();
    let load: f64 = vertical.iter().sum();
    let part = |k: usize| if load > 0.0 { vertical[k] / load } else { 0.0 };
    (0..n).map(|k| [wrench[0] * part(k), wrench[1] * part(k), vertical[k]]).collect()
}
