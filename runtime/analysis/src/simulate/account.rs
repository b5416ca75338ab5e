//! Work of everything that acts on a robot, step by step.
use super::ground::{Compliance, JointLaw};
use super::problem::{Block, Law};

/// Sums over the steps so far, J. None of them knows the energy of the robot: whoever compares both sees what the
/// steps made or lost by themselves.
///
/// A step with the mass matrix of its midpoint, `D (v⁺ − v) = h (τ − H − d v̄) + W Λ` with `v̄ = ½ (v + v⁺)`, gains
/// `v̄ · D (v⁺ − v)`: every term times `v̄` is its work.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Account {
    /// Of the generalised forces that the step was given.
    pub applied: f64,
    /// Of servos that are solved together with the contacts.
    pub servos: f64,
    /// Lost in the damping of joints.
    pub viscous_friction: f64,
    /// Lost in the dry friction of joints.
    pub dry_friction: f64,
    /// Lost in stops of joints.
    pub stops: f64,
    /// Lost where velocities of contact points change suddenly: `−Λ_N γ̄_N − Λ_T · (γ_T⁻ − γ_T⁺)/2` on hard ground, of
    /// which only impacts keep something as the step shrinks. Negative: restitution made energy.
    pub impacts: f64,
    /// Lost in sliding, `−Λ_T · γ_T⁺`.
    pub sliding: f64,
    /// Given to the springs and dampers of soft ground.
    pub soft_ground: f64,
    /// Of that, in springs now.
    pub ground_springs: f64,
}

/// What a step knows when it is over; rows are those of the contact problem.
pub(super) struct Done<'a> {
    pub time: f64,
    /// Velocities before it and their change.
    pub velocity: &'a [f64],
    pub change: &'a [f64],
    pub force: &'a [f64],
    pub joints: &'a [JointLaw],
    pub blocks: &'a [Block],
    /// Λ.
    pub impulse: &'a [f64],
    /// γ⁻ and γ⁺.
    pub before: &'a [f64],
    pub after: &'a [f64],
    /// Heights by row at the midpoint, where the row is the normal of a point.
    pub heights: &'a [f64],
    /// By block: whether it is a servo's.
    pub driven: &'a [bool],
    pub soft: Option<Compliance>,
}

impl Account {
    /// Adds a step.
    pub(super) fn add(&mut self, step: &Done<'_>) {
        let mean = |i: usize| step.velocity[i] + 0.5 * step.change[i];
        self.applied += step.time * step.force.iter().enumerate().map(|(i, f)| f * mean(i)).sum::<f64>();
        let first = step.velocity.len() - step.joints.len();
        for (j, joint) in step.joints.iter().enumerate() {
            self.viscous_friction += step.time * joint.damping * mean(first + j).powi(2);
            // What smooth laws change within the step.
            self.applied -= 0.5 * step.time * joint.slope * step.change[first + j] * mean(first + j);
        }
        self.ground_springs = 0.0;
        for (index, block) in step.blocks.iter().enumerate() {
            let row = block.first;
            let work = |row: usize| 0.5 * step.impulse[row] * (step.before[row] + step.after[row]);
            if step.driven.get(index) == Some(&true) {
                self.servos += work(row);
                continue;
            }
            match block.law {
                Law::Limited { .. } => self.dry_friction -= work(row),
                Law::Unilateral => self.stops -= work(row),
                // Soles that turn are not accounted: see `Simulation::with_energy`.
                Law::Sole { .. } => {}
                Law::Contact { tangents, .. } => {
                    match step.soft {
                        None => self.impacts -= work(row),
                        Some(soft) => {
                            self.soft_ground -= work(row);
                            if step.impulse[row] > 0.0 {
                                let depth = step.heights[row] + 0.5 * step.time * step.after[row];
                                self.ground_springs += 0.5 * soft.stiffness * depth.min(0.0).powi(2);
                            }
                        }
                    }
                    for row in row + 1..=row + tangents {
                        let slid = step.impulse[row] * step.after[row];
                        self.sliding -= slid;
                        self.impacts -= work(row) - slid;
                    }
                }
            }
        }
    }
}
