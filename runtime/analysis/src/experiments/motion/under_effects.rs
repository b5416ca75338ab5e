//! What is left of the measurements of a log under effects.
use super::experiment::{MotionExperiment, less};
use super::on_ground::OnGround;
use crate::experiments::{Channel, Inertial};
use crate::robot::{BaseKind, Trajectory};
use bipedc_effects::effect::{Acts, Effect, Law};
use std::sync::Arc;

/// What the rigid model needs, `samples × nv` (N m, N), and the states of links, if these move behind their motors.
pub(super) type Turned = (Vec<f64>, Option<Trajectory>);

/// Whether an effect turns joints or the base.
fn turns(effect: &Effect) -> bool {
    matches!(effect.kind.law, Law::EncoderOffset | Law::GravityTilt)
}

impl MotionExperiment<'_> {
    /// Torques of the rigid model under effects that change its geometry, and the states of links that move behind motors;
    /// `None` if there are none. `ground`: what the effects make of the robot on the ground, if they change that.
    pub(super) fn turned_load(&self, effects: &[Effect], ground: Option<&OnGround>) -> Option<Arc<Turned>> {
        let motors = || self.turned_states(effects);
        if let Some(ground) = ground {
            let made = || Arc::new(self.load_on_ground(motors(), ground));
            return Some(ground.load.get_or_init(made).clone());
        }
        // On the ground links move as `ground` says.
        let hidden = if self.ground.is_empty() { self.hidden(effects) } else { Vec::new() };
        if !hidden.is_empty() {
            let states = motors();
            let load = self.load_of(&states, &self.ground);
            let needed = |states: &Trajectory| self.load_of(states, &self.ground);
            let (load, links) = self.load_behind_motors(hidden, effects, (states, load), &needed);
            return Some(Arc::new((load, Some(links))));
        }
        let made = || {
            let motion = &self.recording.trajectory;
            let turned = self.turned_positions(effects);
            let q = turned.as_ref().unwrap_or(&motion.q);
            (less(self.rigid.inverse_dynamics(q, &motion.v, &motion.a), &self.ground), None)
        };
        effects.iter().any(turns).then(|| self.turned.of(effects, turns, made))
    }

    /// The same on the ground, of what effects make of the robot there.
    fn load_on_ground(&self, mut states: Trajectory, ground: &OnGround) -> Turned {
        ground.behind.iter().for_each(|link| link.add_to(&mut states));
        let load = self.load_of(&states, &ground.forces);
        (load, (!ground.behind.is_empty()).then_some(states))
    }

    /// What the rigid model needs beside forces of the ground.
    fn load_of(&self, states: &Trajectory, ground: &[f64]) -> Vec<f64> {
        less(self.rigid.inverse_dynamics(&states.q, &states.v, &states.a), ground)
    }

    /// The logged states under effects that turn joints or the base.
    fn turned_states(&self, effects: &[Effect]) -> Trajectory {
        let mut states = self.recording.trajectory.clone();
        states.q = self.turned_positions(effects).unwrap_or(states.q);
        states
    }

    /// Configurations under effects that turn joints or the base; `None` if there are none.
    pub(super) fn turned_positions(&self, effects: &[Effect]) -> Option<Vec<f64>> {
        let motion = &self.recording.trajectory;
        let mut turned: Option<Vec<f64>> = None;
        for effect in effects {
            match effect.kind.law {
                Law::EncoderOffset => {
                    let Some(joint) = self.joint(effect) else { continue };
                    let offset = effect.value("offset");
                    let q = turned.get_or_insert_with(|| motion.q.clone());
                    motion.positions_in(q, joint).for_each(|x| *x -= offset);
                }
                Law::GravityTilt => {
                    let q = turned.get_or_insert_with(|| motion.q.clone());
                    for q in q.chunks_exact_mut(motion.nq()) {
                        tilt(self.layout.base, q, effect.value("roll"), effect.value("pitch"));
                    }
                }
                // No other turns what the joints carry.
                law => debug_assert!(!matches!(law.acts(), Acts::Position | Acts::Gravity)),
            }
        }
        turned
    }

    /// Torques of the rigid model at a joint, with changes of inertial parameters.
    pub(super) fn rigid_torques(&self, load: &[f64], joint: usize, change: &[f64]) -> Vec<f64> {
        let mut rigid: Vec<f64> = match std::ptr::eq(load, &*self.load) {
            true => self.of_load(joint).to_vec(),
            false => self.strided(load, joint).collect(),
        };
        let row = self.effort_row(joint).filter(|_| change.iter().any(|c| *c != 0.0));
        if let Some(inertial) = row.and_then(|row| self.all_inertial()[row].as_ref()) {
            add_inertial(inertial, change, &mut rigid);
        }
        rigid
    }

    /// Measured minus predicted under all effects, for these rows.
    pub(crate) fn residuals(
        &self,
        effects: &[Effect],
        rows: &[usize],
        ground: Option<&OnGround>,
    ) -> Vec<(usize, Vec<f64>)> {
        let turned = self.turned_load(effects, ground);
        let load = turned.as_deref().map_or(&self.load, |(load, _)| load);
        let links = turned.as_deref().and_then(|(_, links)| links.as_ref());
        let links = links.unwrap_or(&self.recording.trajectory);
        let change = self.link_inertias.change(effects);
        let of_row = |&row: &usize| {
            let joint = self.joint_of[row];
            let rigid = self.rigid_torques(load, joint, &change);
            let residual = match self.rows[row].channel {
                Channel::Transmission => self.transmission_residual(joint, &rigid, effects, links),
                _ => self.effort_residual(joint, &rigid, effects, links),
            };
            (row, residual)
        };
        rows.iter().map(of_row).collect()
    }

    /// Rows that an effect can change.
    pub(crate) fn touched(&self, effects: &[Effect]) -> Vec<usize> {
        let everywhere = effects.iter().any(|effect| effect.location.joint.is_none())
            || effects.iter().any(|e| e.kind.law == Law::EncoderOffset)
            || effects.iter().any(|e| {
                e.kind.law.acts() == Acts::Transmission
                    && self.joint(e).is_some_and(|j| self.is_motor_side(j))
            });
        (0..self.rows.len())
            .filter(|&row| everywhere || effects.iter().any(|e| self.joint(e) == Some(self.joint_of[row])))
            .collect()
    }
}

fn add_inertial(inertial: &Inertial, change: &[f64], rigid: &mut [f64]) {
    let width = inertial.columns.len();
    for (torque, row) in rigid.iter_mut().zip(inertial.values.chunks_exact(width.max(1))) {
        *torque += inertial.columns.iter().zip(row).map(|(column, y)| y * change[*column]).sum::<f64>();
    }
}

/// Turns the base: true orientation = R_y(pitch) R_x(roll) times the logged one.
fn tilt(base: BaseKind, q: &mut [f64], roll: f64, pitch: f64) {
    match base {
        BaseKind::Fixed | BaseKind::Pivot => {}
        BaseKind::Planar => q[2] += pitch,
        BaseKind::Floating => {
            let ((sr, cr), (sp, cp)) = ((0.5 * roll).sin_cos(), (0.5 * pitch).sin_cos());
            // R_y(pitch) R_x(roll) as a quaternion x y z w.
            let [ax, ay, az, aw] = [cp * sr, sp * cr, -sp * sr, cp * cr];
            let [bx, by, bz, bw] = [q[3], q[4], q[5], q[6]];
            q[3] = aw * bx + ax * bw + ay * bz - az * by;
            q[4] = aw * by - ax * bz + ay * bw + az * bx;
            q[5] = aw * bz + ax * by - ay * bx + az * bw;
            q[6] = aw * bw - ax * bx - ay * by - az * bz;
        }
    }
}
