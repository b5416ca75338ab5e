//! What is left of the measurements of a log under effects.
use super::experiment::{MotionExperiment, less};
use super::on_ground::OnGround;
use crate::experiments::{Channel, Inertial};
use crate::robot::inertial_parameters::body_of;
use crate::robot::{BaseKind, Trajectory};
use bipedc_effects::effect::{Acts, Effect, Law};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// What the rigid model needs, `samples × nv` (N m, N), and the states of links, if these are not as they were logged.
pub(super) type Turned = (Vec<f64>, Option<Trajectory>);

/// How inertial parameters enter the torques of each row.
pub(super) type Inertials = Vec<Option<Inertial>>;

/// Whether an effect turns joints or the base.
fn turns(effect: &Effect) -> bool {
    matches!(effect.kind.law, Law::EncoderOffset | Law::GravityTilt)
}

impl MotionExperiment<'_> {
    /// Torques of the rigid model under effects that change its geometry, and the states of links then;
    /// `None` if there are no such effects. `ground`: what the effects make of the robot on the ground, if they change that.
    pub(super) fn turned_load(&self, effects: &[Effect], ground: Option<&OnGround>) -> Option<Arc<Turned>> {
        let motors = || self.turned_states(effects);
        let is_turned = effects.iter().any(turns);
        if let Some(ground) = ground {
            let made = || Arc::new(self.load_on_ground(motors(), ground, is_turned));
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
            let states = motors();
            (self.load_of(&states, &self.ground), Some(states))
        };
        is_turned.then(|| self.turned.of(effects, turns, made))
    }

    /// The same on the ground, of what effects make of the robot there.
    fn load_on_ground(&self, mut states: Trajectory, ground: &OnGround, is_turned: bool) -> Turned {
        ground.behind.iter().for_each(|link| link.add_to(&mut states));
        let load = self.load_of(&states, &ground.forces);
        (load, (is_turned || !ground.behind.is_empty()).then_some(states))
    }

    /// How the inertial parameters of the links that effects change enter torques where effects turn joints or the base, or links move behind their
    /// motors: what they carry moves with them. `None` where nothing does.
    fn inertial_under(
        &self,
        effects: &[Effect],
        turned: &Turned,
        ground: Option<&OnGround>,
    ) -> Option<Arc<Inertials>> {
        let states = turned.1.as_ref()?;
        let is_behind =
            ground.map_or_else(|| !self.hidden(effects).is_empty(), |ground| !ground.behind.is_empty());
        let body = |effect: &Effect| self.body_of(effect);
        // Which link an effect changes matters here, and not by how much, unless links move by what they carry.
        let at = |effect: &Effect| match body(effect) {
            Some(_) if !is_behind => Effect { parameters: BTreeMap::new(), ..effect.clone() },
            _ => effect.clone(),
        };
        let matters = |effect: &&Effect| is_behind || turns(effect) || body(effect).is_some();
        let key: Vec<Effect> = effects.iter().filter(matters).map(at).collect();
        let made = || self.inertial_at(effects, states);
        Some(self.turned_inertial.of(&key, |_| true, made))
    }

    /// The body whose inertial parameters an effect changes.
    fn body_of(&self, effect: &Effect) -> Option<usize> {
        self.link_inertias.link(effect.location.link.as_deref()?).map(|link| link.body)
    }

    /// How the inertial parameters of the links that effects change enter torques at these states.
    pub(super) fn inertial_at(&self, effects: &[Effect], states: &Trajectory) -> Inertials {
        let bodies: BTreeSet<usize> = effects.iter().filter_map(|effect| self.body_of(effect)).collect();
        self.inertial_columns(states, states, &|column| bodies.contains(&body_of(column)))
    }

    /// What the rigid model needs beside forces of the ground.
    fn load_of(&self, states: &Trajectory, ground: &[f64]) -> Vec<f64> {
        less(self.rigid.inverse_dynamics(&states.q, &states.v, &states.a), ground)
    }

    /// The logged states under effects that turn joints or the base.
    fn turned_states(&self, effects: &[Effect]) -> Trajectory {
        let states = &self.recording.trajectory;
        self.turned_positions(effects).map_or_else(|| states.clone(), |q| states.turned(q))
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

    /// Torques of the rigid model at a joint, with changes of inertial parameters that enter as said.
    pub(super) fn rigid_torques(
        &self,
        load: &[f64],
        joint: usize,
        change: &[f64],
        inertial: Option<&Inertials>,
    ) -> Vec<f64> {
        let mut rigid: Vec<f64> = match std::ptr::eq(load, &*self.load) {
            true => self.of_load(joint).to_vec(),
            false => self.strided(load, joint).collect(),
        };
        let row = self.effort_row(joint).filter(|_| change.iter().any(|c| *c != 0.0));
        let of = |row: usize| inertial.map_or_else(|| self.all_inertial(), Vec::as_slice)[row].as_ref();
        if let Some(inertial) = row.and_then(of) {
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
        let changes = change.iter().any(|x| *x != 0.0);
        let inertial = changes.then(|| self.inertial_under(effects, turned.as_deref()?, ground)).flatten();
        let of_row = |&row: &usize| {
            let joint = self.joint_of[row];
            let rigid = self.rigid_torques(load, joint, &change, inertial.as_deref());
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

/// Samples that are summed side by side: each sum waits for its own last term.
const SIDE_BY_SIDE: usize = 8;

fn add_inertial(inertial: &Inertial, change: &[f64], rigid: &mut [f64]) {
    let width = inertial.columns.len().max(1);
    // Effects change a link or two.
    let changes = inertial.columns.iter().map(|column| change[*column]).enumerate();
    let changed: Vec<(usize, f64)> = changes.filter(|(_, change)| *change != 0.0).collect();
    let add = |torques: &mut [f64], rows: &[f64]| {
        let mut sums = [0.0; SIDE_BY_SIDE];
        for (at, change) in &changed {
            let column = rows[*at..].iter().step_by(width);
            sums.iter_mut().zip(column).for_each(|(sum, y)| *sum += y * change);
        }
        torques.iter_mut().zip(sums).for_each(|(torque, sum)| *torque += sum);
    };
    let rows = inertial.values.chunks(SIDE_BY_SIDE * width);
    rigid.chunks_mut(SIDE_BY_SIDE).zip(rows).for_each(|(torques, rows)| add(torques, rows));
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
