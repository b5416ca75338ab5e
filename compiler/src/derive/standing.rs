//! A free robot on one foot, as the tree that is rooted there: nothing is constrained in it any more.
//!
//! With the foot's point at rest the base's rows that move it fall away, and what is left are the equations of motion of a
//! robot on a ball joint (a point), or on a fixed base (a sole). The ground's forces are what the held rows take.
use super::articulated::{duration, less};
use super::constraint::{BodyJacobian, Constraints};
use super::kinematics::{Motions, forward};
use super::model::{Given, InertiaMode, RobotModel, rotate};
use super::sensitivity::{Axes, External, Sensitivity, Wrench, articulated};
use super::solve::{Factor, Topology};
use super::support::{Support, SupportKind};
use crate::expression::{Sym, Vector3};
use crate::tree::{Body, JointMotion, Standing, Trunk};
use bipedc_runtime::Argument;

/// Motion in the order of `v`, and forces in the order of the constraints' rows.
pub(super) type Solution<'g> = (Vec<Sym<'g>>, Vec<Sym<'g>>);

/// What sets the robot in motion.
#[derive(Clone, Copy)]
pub(super) enum Load<'a, 'g> {
    /// Generalised forces, in the order of `v`: accelerations are wanted.
    Forces(&'a [Sym<'g>]),
    /// The foot's velocity vanishes at once: jumps of velocities are wanted.
    Impact,
}

/// The foot that stands alone.
struct Stance<'m, 'g, 't> {
    model: &'m RobotModel<'g, 't>,
    support: &'m Support,
    standing: Standing,
    /// Number of base rows that are held.
    held: usize,
    planar: bool,
    /// The foot seen from its own body.
    seen: BodyJacobian<'g>,
    rotors: Vec<Sym<'g>>,
}

/// The response of a robot to a load, by the way that takes the least time; `None` unless it is free and stands on one foot.
pub(super) fn respond<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rotors: &[Sym<'g>],
    load: Load<'_, 'g>,
) -> Option<Solution<'g>> {
    let ways = by_every_way(model, constraints, rotors, load);
    ways.into_iter().min_by_key(|(motion, forces)| duration(model, &[motion.as_slice(), forces].concat()))
}

/// The same by every way, none unless the robot is free and stands on one foot.
fn by_every_way<'g>(
    model: &RobotModel<'g, '_>,
    constraints: &Constraints<'g>,
    rotors: &[Sym<'g>],
    load: Load<'_, 'g>,
) -> Vec<Solution<'g>> {
    let Some(stance) = Stance::new(model, constraints, rotors) else { return Vec::new() };
    match load {
        Load::Forces(forces) => stance.dynamics(forces),
        Load::Impact => stance.impact(),
    }
}

impl<'m, 'g, 't> Stance<'m, 'g, 't> {
    fn new(
        model: &'m RobotModel<'g, 't>,
        constraints: &'m Constraints<'g>,
        rotors: &[Sym<'g>],
    ) -> Option<Self> {
        let ([support], Some(trunk)) = (constraints.supports.as_slice(), model.tree.trunk()) else {
            return None;
        };
        let planar = matches!(trunk, Trunk::Planar(_));
        let all = if planar { 2 } else { 3 };
        let held = match &support.kind {
            SupportKind::Point { linear } if linear.len() == all => all,
            SupportKind::Flat { linear, angular } if linear.len() == all && angular.len() == 2 * all - 3 => {
                3 * (all - 1)
            }
            _ => return None,
        };
        // A foot's inertia in other axes is rounded.
        let numbers = matches!(model.mode, Some(InertiaMode::Folded | InertiaMode::Plain));
        if model.graph.is_exact() || model.given.is_some() || !numbers {
            return None;
        }
        let standing = model.tree.standing_on(support.body, support.point)?;
        let zero = model.constant(0.0);
        let rotor = |row: usize| rotors.get(row).copied().unwrap_or(zero);
        let on_base = (0..model.tree.nv).filter(|row| !standing.rows.contains(&Some(*row)));
        if on_base.into_iter().any(|row| !rotor(row).is_zero()) {
            return None;
        }
        let rotors = standing.rows.iter().map(|row| row.map_or(zero, rotor)).collect();
        let seen = BodyJacobian::new(model, support.body, support.point);
        Some(Self { model, support, standing, held, planar, seen, rotors })
    }

    fn zero(&self) -> Sym<'g> {
        self.model.constant(0.0)
    }

    /// The model of the tree on the foot, with positions of joints, `base` rows of velocities, and those of joints if they count.
    fn on_foot(&self, base: &[Sym<'g>], moving: bool, gravity: bool) -> RobotModel<'g, '_> {
        let (model, tree) = (self.model, &self.standing.tree);
        let mode = model.mode.unwrap_or(InertiaMode::Folded);
        let mut q: Vec<Sym<'g>> = self.joints(Argument::Q);
        if self.planar {
            q[2] = self.foot_angle(Argument::Q);
        }
        let mut v = if moving { self.joints(Argument::V) } else { vec![self.zero(); tree.nv] };
        v[..base.len()].copy_from_slice(base);
        let down = |g: Vector3<'g>| if self.planar { g } else { self.seen.rotation.transpose() * g };
        let gravity = if gravity { down(model.gravity()) } else { model.zero3() };
        let mut on_foot = RobotModel::new(model.graph, tree, mode);
        on_foot.given = Some(Given { q, v, gravity });
        on_foot
    }

    /// Elements of an argument in the order of the other tree, 0 for its base.
    fn joints(&self, argument: Argument) -> Vec<Sym<'g>> {
        let places = if argument == Argument::Q { &self.standing.coordinates } else { &self.standing.rows };
        places.iter().map(|place| place.map_or(self.zero(), |k| self.model.input(argument, k))).collect()
    }

    /// Angle of a planar robot's foot about the world's y axis, without constants; or its rate.
    fn foot_angle(&self, argument: Argument) -> Sym<'g> {
        let model = self.model;
        let (Some(Trunk::Planar(trunk)) | Some(Trunk::Floating(trunk))) = model.tree.trunk() else {
            return self.zero();
        };
        let body = &model.tree.bodies[trunk];
        let place = if argument == Argument::Q { body.q_index } else { body.v_index };
        let own = model.signed(trunk, model.input(argument, place));
        self.standing.turns.iter().fold(own, |sum, turn| {
            let place = if argument == Argument::Q { turn.coordinate } else { turn.row };
            match turn.sign {
                0.0 => sum,
                _ => sum + model.input(argument, place) * turn.sign,
            }
        })
    }

    /// Rows of the base as the foot turns: its point rests.
    fn turning(&self) -> Vec<Sym<'g>> {
        let (zero, model) = (self.zero(), self.model);
        if self.planar {
            return vec![zero, zero, self.foot_angle(Argument::V)];
        }
        let motions = Motions { velocity: true, acceleration: false, gravity: false };
        let w = forward(model, motions)[self.support.body].angular_velocity;
        vec![zero, zero, zero, w[0], w[1], w[2]]
    }

    fn dynamics(&self, forces: &[Sym<'g>]) -> Vec<Solution<'g>> {
        let on_foot = self.on_foot(&self.turning(), true, true);
        let still = vec![self.zero(); on_foot.tree.nv];
        let robot =
            Sensitivity::pushed(&on_foot, &still, true, 2.0, |axes| Some(self.push(&on_foot, axes, forces)));
        let tau: Vec<Sym<'g>> =
            self.standing.rows.iter().map(|row| row.map_or(self.zero(), |row| forces[row])).collect();
        let done = |(changes, reactions): Solution<'g>| {
            let change = robot.handed_on(&self.standing.leg, &changes);
            (self.all(&changes, self.base_acceleration(&robot, change)), self.published(&reactions))
        };
        self.solved(&robot, &tau).into_iter().map(done).collect()
    }

    fn impact(&self) -> Vec<Solution<'g>> {
        let on_foot = self.on_foot(&[], false, false);
        let still = vec![self.zero(); on_foot.tree.nv];
        let mut before = self.joints(Argument::V);
        let turning = self.turning();
        before[..turning.len()].copy_from_slice(&turning);
        let velocity = self.foot_velocity(&Sensitivity::new(&on_foot, &still, false, 2.0), &before);
        let mut stopped = still.clone();
        for (row, v) in velocity.into_iter().enumerate().take(self.held) {
            stopped[row] = -v;
        }
        let robot = Sensitivity::new(&on_foot, &stopped, false, 2.0);
        let done = |(changes, reactions): Solution<'g>| {
            let mut after: Vec<Sym<'g>> = before.iter().zip(&changes).map(|(&v, &x)| v + x).collect();
            after[..self.held].fill(self.zero());
            let base = self.base_velocity(&robot, &after);
            let now = (0..base.len()).map(|k| self.model.input(Argument::V, k));
            let jumps = base.into_iter().zip(now).map(|(after, v)| after - v).collect();
            (self.all(&changes, jumps), self.published(&reactions))
        };
        self.solved(&robot, &still).into_iter().map(done).collect()
    }

    /// Changes of accelerations, and what holds the foot's rows, under forces: by every way.
    fn solved(&self, robot: &Sensitivity<'_, 'g, '_>, tau: &[Sym<'g>]) -> Vec<Solution<'g>> {
        let mut ways = vec![self.factored(&robot.mass_matrix(), &less(tau, &robot.forces()))];
        if self.rotors.iter().all(|rotor| rotor.is_zero()) {
            let forces = less(&robot.in_absolute_angles(tau), &robot.absolute_forces());
            let (absolute, reactions) = self.factored(&robot.absolute_mass_matrix(), &forces);
            ways.push((robot.joint_velocities(&absolute), reactions));
            ways.push(articulated::solve_held(robot, tau, self.held));
        }
        ways
    }

    /// With the factored mass matrix `d`.
    fn factored(&self, d: &[Vec<Sym<'g>>], forces: &[Sym<'g>]) -> Solution<'g> {
        let mut d = d.to_vec();
        for (k, &rotor) in self.rotors.iter().enumerate() {
            d[k][k] = d[k][k] + rotor;
        }
        let tree = &self.standing.tree;
        let mut changes = vec![self.zero(); tree.nv];
        if tree.nv > self.held {
            let factor = Factor::with_topology(self.model, Topology::beyond(tree, self.held), &d);
            changes = factor.solve(forces);
        }
        let reaction =
            |row: usize| (self.held..tree.nv).fold(-forces[row], |sum, k| sum + d[row][k] * changes[k]);
        let reactions = (0..self.held).map(reaction).collect();
        (changes, reactions)
    }

    /// What acts on the base from outside, on the body that was the trunk.
    fn push(&self, on_foot: &RobotModel<'g, '_>, axes: &[Axes<'g>], forces: &[Sym<'g>]) -> External<'g> {
        let Standing { trunk, trunk_frame, leg, .. } = &self.standing;
        let at = Vector3::constant(self.model.graph, trunk_frame.translation);
        let about_origin = |(force, moment): Wrench<'g>, at: Vector3<'g>| (force, moment + at.cross(force));
        if !self.planar {
            let part = |k: usize| on_foot.placed(trunk_frame, Vector3([0, 1, 2].map(|i| forces[k + i])));
            let own = about_origin((part(0), part(3)), at);
            let joint = (axes[*trunk].out(own.0), axes[*trunk].out(own.1));
            return External { body: *trunk, own, joint };
        }
        let (mut force, mut moment) = (self.model.zero3(), self.model.zero3());
        for (index, (body, &x)) in self.model.tree.bodies.iter().zip(&forces[..3]).enumerate() {
            match body.motion {
                JointMotion::Prismatic { axis, .. } => force[axis] = self.model.signed(index, x),
                _ => moment[1] = self.model.signed(index, x),
            }
        }
        if leg.iter().skip(1).all(|&index| axes[index].joined) {
            let joint = about_origin((force, moment), axes[*trunk].out(at));
            let own = (axes[*trunk].into_body(joint.0), axes[*trunk].into_body(joint.1));
            return External { body: *trunk, own, joint };
        }
        let (s, c) = self.model.sin_cos(2);
        let into = |x: Vector3<'g>| on_foot.placed(trunk_frame, rotate(1, -s, c, x));
        let own = about_origin((into(force), into(moment)), at);
        External { body: *trunk, own, joint: (axes[*trunk].out(own.0), axes[*trunk].out(own.1)) }
    }

    /// From the trunk in the tree on the foot, its point at the base's origin, to rows of the base: linear and angular parts of an
    /// acceleration or a velocity, given in the joint axes and in the body's own.
    fn base_rows(&self, robot: &Sensitivity<'_, 'g, '_>, joint: Wrench<'g>, own: Wrench<'g>) -> Wrench<'g> {
        let Standing { trunk_frame, leg, .. } = &self.standing;
        if self.planar && robot.share_axes(leg) {
            return joint;
        }
        let into = |x| self.model.placed_back(trunk_frame, x);
        let (linear, angular) = (into(own.0), into(own.1));
        if !self.planar {
            return (linear, angular);
        }
        let (s, c) = self.model.sin_cos(2);
        (rotate(1, s, c, linear), rotate(1, s, c, angular))
    }

    /// Linear and angular part in the rows of the base.
    fn rows(&self, linear: Vector3<'g>, angular: Vector3<'g>) -> Vec<Sym<'g>> {
        if !self.planar {
            return linear.0.into_iter().chain(angular.0).collect();
        }
        let bodies = self.model.tree.bodies.iter().enumerate().take(3);
        let row = |(index, body): (usize, &Body)| match body.motion {
            JointMotion::Prismatic { axis, .. } => self.model.signed(index, linear[axis]),
            _ => self.model.signed(index, angular[1]),
        };
        bodies.map(row).collect()
    }

    fn base_acceleration(&self, robot: &Sensitivity<'_, 'g, '_>, change: Wrench<'g>) -> Vec<Sym<'g>> {
        let (model, trunk) = (self.model, self.standing.trunk);
        let at = Vector3::constant(model.graph, self.standing.trunk_frame.translation);
        let (joint, own) =
            (robot.acceleration_of(trunk, at, change), robot.acceleration_in(trunk, at, change));
        let (linear, angular) = self.base_rows(robot, joint, own);
        if self.planar {
            return self.rows(linear + model.gravity(), angular);
        }
        // d/dt of components in turning axes.
        let (v, w) = (model.input3(Argument::V, 0), model.input3(Argument::V, 3));
        self.rows(linear + model.down(0, model.gravity()) - w.cross(v), angular)
    }

    /// Rows of the base at velocities of the tree on the foot.
    fn base_velocity(&self, robot: &Sensitivity<'_, 'g, '_>, velocities: &[Sym<'g>]) -> Vec<Sym<'g>> {
        let (linear, angular) = robot.handed_on(&self.standing.leg, velocities);
        let at = Vector3::constant(self.model.graph, self.standing.trunk_frame.translation);
        let (joint, own) = robot.at_point(self.standing.trunk, at, (linear, angular));
        let (linear, angular) = self.base_rows(robot, joint, own);
        self.rows(linear, angular)
    }

    /// Rows of the foot's own velocity, as far as they are held.
    fn foot_velocity(&self, robot: &Sensitivity<'_, 'g, '_>, velocities: &[Sym<'g>]) -> Vec<Sym<'g>> {
        if !self.planar {
            let v = |k: usize| self.model.input(Argument::V, k);
            let sum = |part: &dyn Fn(&(Vector3<'g>, Vector3<'g>)) -> Vector3<'g>| {
                let columns = self.seen.columns.iter().enumerate();
                columns.fold(self.model.zero3(), |sum, (k, column)| sum + part(column).scale(v(k)))
            };
            let (linear, angular) = (sum(&|c| c.0), sum(&|c| c.1));
            return linear.0.into_iter().chain(angular.0).collect();
        }
        // The base's velocity, less what it would have if the foot's point were at rest.
        let rest = self.base_velocity(robot, velocities);
        let moving = (0..3).map(|k| self.model.input(Argument::V, k) - rest[k]);
        let mut out = vec![self.zero(), self.zero(), velocities[2]];
        for (index, x) in moving.enumerate() {
            if let JointMotion::Prismatic { axis, .. } = self.model.tree.bodies[index].motion {
                out[usize::from(axis == 2)] = self.model.signed(index, x);
            }
        }
        out
    }

    /// Rows of the other tree.
    fn all(&self, changes: &[Sym<'g>], base: Vec<Sym<'g>>) -> Vec<Sym<'g>> {
        let mut out = vec![self.zero(); self.model.tree.nv];
        out[..base.len()].copy_from_slice(&base);
        for (row, &x) in self.standing.rows.iter().zip(changes) {
            if let Some(row) = row {
                out[*row] = x;
            }
        }
        out
    }

    /// What holds the rows, in the axes of the world.
    fn published(&self, reactions: &[Sym<'g>]) -> Vec<Sym<'g>> {
        if self.planar {
            return reactions.to_vec();
        }
        let part = |k: usize| self.seen.rotation * Vector3([0, 1, 2].map(|i| reactions[k + i]));
        (0..self.held).step_by(3).flat_map(|k| part(k).0).collect()
    }
}

#[cfg(test)]
#[path = "standing_tests.rs"]
mod tests;
