//! What the integration asks of a robot: accelerations, where phases end, what changes there.
use super::integrate::{Passage, Phased, Violation};
use super::robot::{Memory, PhasedRobot};
use super::spec::{Ending, PhaseSpec};
use super::support::{Load, before_line};
use crate::robot::BaseKind;
use crate::simulate::mechanics::rotate;
use bipedc_runtime::control::Observation;
use bipedc_runtime::model::{Argument, State};

impl Phased for PhasedRobot<'_> {
    fn derivative(&self, phase: usize, time: f64, x: &[f64], out: &mut [f64]) {
        let mut work = self.work.borrow_mut();
        self.dynamics(phase, time, x, &mut work);
        let (q, v) = self.split(x);
        let (rates, accelerations) = out.split_at_mut(q.len());
        accelerations.copy_from_slice(&work.out[..v.len()]);
        let joints = self.model.joints();
        rates[q.len() - joints..].copy_from_slice(&v[v.len() - joints..]);
        match self.base {
            BaseKind::Fixed => {}
            BaseKind::Planar | BaseKind::Pivot => {
                rates[..self.base.nv()].copy_from_slice(&v[..self.base.nv()]);
            }
            BaseKind::Floating => {
                let turn = [q[3], q[4], q[5], q[6]];
                rates[..3].copy_from_slice(&rotate(turn, [v[0], v[1], v[2]]));
                let [x, y, z, w] = turn;
                let [a, b, c] = [0.5 * v[3], 0.5 * v[4], 0.5 * v[5]];
                rates[3] = w * a + y * c - z * b;
                rates[4] = w * b + z * a - x * c;
                rates[5] = w * c + x * b - y * a;
                rates[6] = -x * a - y * b - z * c;
            }
        }
    }

    fn guard(&self, phase: usize, time: f64, x: &[f64]) -> f64 {
        let spec = &self.phases[phase].0;
        let (q, v) = self.split(x);
        let mut work = self.work.borrow_mut();
        match &spec.ending {
            Ending::Never => f64::INFINITY,
            Ending::Touch(points) => self.above(spec, q, points, &mut work),
            Ending::Release(foot) => {
                self.dynamics(phase, time, x, &mut work);
                Load::of(*foot, &spec.rows, &work.out[v.len()..]).force[2]
            }
            Ending::Tip(foot, edge) => {
                self.dynamics(phase, time, x, &mut work);
                let load = Load::of(*foot, &spec.rows, &work.out[v.len()..]);
                let sole = self.sole(*foot, &spec.standing);
                let (place, _, middle) = self.pressure(q, &load, &sole, &mut work);
                let edge = self.places(q, edge, &mut work);
                before_line(place, &edge, middle, self.base == BaseKind::Planar)
            }
        }
    }

    fn name(&self, phase: usize) -> String {
        self.phases[phase].0.name.clone()
    }

    fn violation(&self, phase: usize, time: f64, x: &[f64]) -> Option<Violation> {
        // Taken out, so that what is called can use the shared workspace too.
        let mut work = self.work.take();
        let found = self.broken(phase, time, x, &mut work);
        self.work.replace(work);
        found
    }

    fn glimpse(&self, phase: usize, time: f64, x: &[f64]) -> Option<Violation> {
        self.broken_in_the_air(phase, time, x)
    }

    fn before_event(&self, phase: usize, time: f64, x: &[f64]) -> Option<f64> {
        let (q, v) = self.split(x);
        let phase = if phase < self.described { phase } else { self.driven() };
        self.controller.borrow_mut().before_event(&Observation::new(time, phase, q, v))
    }

    fn at_event(&self, phase: usize, time: f64, x: &[f64]) {
        let (q, v) = self.split(x);
        *self.memory.borrow_mut() = Memory::default();
        let phase = if phase < self.described { phase } else { self.driven() };
        let told = self.controller.borrow_mut().at_event(&Observation::new(time, phase, q, v));
        if let (Err(refusal), None) = (told, self.refusal.get()) {
            self.refusal.set(Some((phase, time, refusal)));
        }
    }

    fn change(
        &self,
        phase: usize,
        time: f64,
        x: &mut [f64],
        impulse: &mut Vec<f64>,
    ) -> Result<Passage, Violation> {
        let (spec, functions) = &self.phases[phase];
        let mut held = Vec::new();
        *self.memory.borrow_mut() = Memory::default();
        if let (Some(impact), Some(landing)) = (functions.impact, &spec.impact) {
            let before = x.to_vec();
            let reached = self.reached.get();
            self.reach(spec, &landing.standing, x);
            let (q, v) = x.split_at_mut(self.model.nq());
            let mut out = Vec::new();
            self.call(impact, &State::new().with(Argument::Q, q).with(Argument::V, v), &mut out);
            impulse.extend_from_slice(&out[v.len()..]);
            v.copy_from_slice(&out[..v.len()]);
            let found = self.broken_by_impact(phase, time, (q, v), (&landing.rows, impulse));
            if let Some(found) = found {
                x.copy_from_slice(&before);
                self.reached.set(reached);
                return self.goes_on(phase, time, x, impulse, found);
            }
            held.clone_from(&landing.standing);
        }
        if spec.relabel {
            self.exchange(x);
        }
        self.begin_phase(spec.next, time, x);
        Ok(Passage { to: spec.next, exchanged: spec.relabel, held, planned: true })
    }

    fn goes_on(
        &self,
        phase: usize,
        time: f64,
        x: &mut [f64],
        impulse: &mut Vec<f64>,
        violation: Violation,
    ) -> Result<Passage, Violation> {
        impulse.clear();
        self.follow(phase, time, x, impulse).unwrap_or(Err(violation))
    }
}

impl PhasedRobot<'_> {
    /// Where a foot reaches a new foothold: from here on heights are those above it.
    pub(super) fn reach(&self, spec: &PhaseSpec, landing: &[usize], x: &mut [f64]) {
        let new: Vec<usize> =
            landing.iter().copied().filter(|point| !spec.standing.contains(point)).collect();
        if !self.rises.is_empty() && !new.is_empty() && !self.stands_already(&spec.standing, &new) {
            x[1] -= self.ground()[1];
            self.reached.set(self.reached.get() + 1);
        }
    }

    /// Left and right exchange their roles.
    pub(super) fn exchange(&self, x: &mut [f64]) {
        let Some([configuration, velocity]) = self.relabelled else { return };
        let (q, v) = x.split_at_mut(self.model.nq());
        let mut out = Vec::new();
        self.call(configuration, &State::new().with(Argument::Q, q), &mut out);
        q.copy_from_slice(&out);
        self.call(velocity, &State::new().with(Argument::V, v), &mut out);
        v.copy_from_slice(&out);
        self.swapped.set(!self.swapped.get());
    }
}
