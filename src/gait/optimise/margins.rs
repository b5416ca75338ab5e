//! How far a motion stays from its limits, at its nodes.
use super::layout::Layout;
use bipedc_compiler::compile::{Collocation, NodeRow};
use serde::Serialize;

/// Smallest distances from limits over all nodes and impacts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct MotionMargins {
    /// Largest \|F_x\|/F_z on a foot that holds.
    pub friction: f64,
    /// The same of impulses.
    pub impact_friction: Option<f64>,
    /// Smallest F_z on a foot that holds, N.
    pub push: f64,
    /// Smallest vertical impulse on a foot that an impact holds, N s.
    pub impulse: Option<f64>,
    /// Smallest distance of a centre of pressure from an end of the sole over which the phase does not end, m.
    pub zmp: Option<f64>,
    /// Lowest height of a foot in the air over the middle four fifths of each phase, m; see [`Collocation::swings`].
    pub clearance: Option<f64>,
    /// Smallest distance of a torque from its limit, N m.
    pub torque: Option<f64>,
    /// Largest torque, N m.
    pub largest_torque: f64,
    /// Smallest distance of a joint from its limits, rad or m.
    pub joint: Option<f64>,
    /// Smallest distance of a joint's speed from its limit, rad/s or m/s.
    pub velocity: Option<f64>,
}

fn lower(of: &mut Option<f64>, by: f64) {
    *of = Some(of.map_or(by, |x| x.min(by)));
}

pub(super) fn margins(of: &Collocation, layout: &Layout, x: &[f64]) -> MotionMargins {
    let mut found = MotionMargins {
        friction: 0.0,
        impact_friction: None,
        push: f64::INFINITY,
        impulse: None,
        zmp: None,
        clearance: None,
        torque: None,
        largest_torque: 0.0,
        joint: None,
        velocity: None,
    };
    for p in 0..of.phases.len() {
        for node in 0..layout.phases[p].nodes() {
            forces(&mut found, of, layout, (p, node), x);
            joints(&mut found, of, layout, (p, node), x);
            clearance(&mut found, of, layout, (p, node), x);
        }
        let first = layout.phases[p].impulses.start;
        for foot in of.changes[p].feet.iter().flatten() {
            let [along, up] = foot.force.map(|k| x[first + k]);
            lower(&mut found.impulse, up);
            found.impact_friction = Some(found.impact_friction.unwrap_or(0.0).max(along.abs() / up));
        }
    }
    found
}

fn forces(
    found: &mut MotionMargins,
    of: &Collocation,
    layout: &Layout,
    (p, node): (usize, usize),
    x: &[f64],
) {
    let first = layout.forces(p, node);
    for foot in of.phases[p].feet.iter().flatten() {
        let [along, up] = foot.force.map(|k| x[first + k]);
        if foot.holds {
            found.friction = found.friction.max(along.abs() / up);
            found.push = found.push.min(up);
        }
        let Some(moment) = foot.moment.filter(|_| foot.holds) else { continue };
        let centre = -x[first + moment] / up;
        for side in (0..2).filter(|&side| foot.level[side]) {
            let sign = [-1.0, 1.0][side];
            lower(&mut found.zmp, sign * (foot.sole[side] - centre));
        }
    }
}

fn joints(
    found: &mut MotionMargins,
    of: &Collocation,
    layout: &Layout,
    (p, node): (usize, usize),
    x: &[f64],
) {
    for (k, joint) in of.tree.joints.iter().enumerate() {
        let named = of.description.joints.iter().find(|other| other.name == joint.name);
        let torque = x[layout.torques(p, node) + k].abs();
        found.largest_torque = found.largest_torque.max(torque);
        if let Some(limit) = named.and_then(|joint| joint.effort_limit) {
            lower(&mut found.torque, limit - torque);
        }
        if let Some((low, high)) = named.and_then(|joint| joint.position_limits) {
            let q = x[layout.motion(p, node, 0) + joint.v_index];
            lower(&mut found.joint, (q - low).min(high - q));
        }
        if let Some(limit) = named.and_then(|joint| joint.velocity_limit) {
            lower(&mut found.velocity, limit - x[layout.motion(p, node, 1) + joint.v_index].abs());
        }
    }
}

fn clearance(
    found: &mut MotionMargins,
    of: &Collocation,
    layout: &Layout,
    (p, node): (usize, usize),
    x: &[f64],
) {
    let phase = &of.phases[p];
    if !(0.1..=0.9).contains(&layout.phases[p].part(node)) {
        return;
    }
    let local: Vec<f64> = layout.node(p, node).iter().map(|&k| x[k]).collect();
    let mut values = vec![0.0; phase.node.rows()];
    phase.node.values(&local, &mut values);
    let first = phase.rows.iter().find(|row| row.0 == NodeRow::Height).map_or(0, |row| row.1);
    for point in 0..of.tree.points.len() {
        if of.swings(p, point) {
            lower(&mut found.clearance, values[first + point]);
        }
    }
}
