//! Contacts that are not those of the order of phases: early and late landings, feet that lift or tip before their phase ends, several
//! contacts at once. The walk goes on with the contacts that there are, in the phase that has them, as it is or with its sides exchanged.
//!
//! Which contacts hold is what the laws of contact allow (Signorini's conditions, of impulses where something strikes, plastic impacts): the
//! ground pushes on what holds, and what does not hold does not go into the ground. Contacts that no phase has, such as the heel alone, are
//! passed under the torques of the phase before, until some phase has them again.
use super::integrate::{Passage, Violation};
use super::robot::PhasedRobot;
use super::spec::PhaseSpec;
use super::support::{Load, Row, inside};
use crate::robot::BaseKind;
use bipedc_runtime::model::{Argument, State};

/// Points in the air so close to the ground may be part of an impact, m.
const TOUCHING: f64 = 1e-6;
/// Vertical speeds that are rounding, m/s: contacts at rest drift by so much while a phase is integrated.
const STILL: f64 = 1e-6;
/// Forces (N) and impulses (N s) that are rounding.
const ROUNDING: [f64; 2] = [1e-6, 1e-6];
/// Distances that are rounding, m.
const CLOSE: f64 = 1e-9;

impl PhasedRobot<'_> {
    /// Whether phases follow the contacts.
    pub(super) fn follows(&self) -> bool {
        self.assumptions.follows == Some(true) && self.phases.len() > self.described
    }

    /// What follows where an assumption of the phase does not hold: `None` if it is not about contacts, or no contacts are left.
    pub(super) fn follow(
        &self,
        phase: usize,
        time: f64,
        x: &mut [f64],
        impulse: &mut Vec<f64>,
    ) -> Option<Result<Passage, Violation>> {
        if !self.follows() {
            return None;
        }
        let spec = self.phases[phase].0.clone();
        let landed = self.landed(&spec, x);
        let (kept, held) = if landed.is_empty() {
            (self.still_held(phase, time, x), Vec::new())
        } else {
            let kept = match self.struck(&spec, time, (x, &landed), impulse)? {
                Ok(kept) => kept,
                Err(violation) => return Some(Err(violation)),
            };
            (kept.clone(), kept)
        };
        let same = held.is_empty() && kept.len() == spec.standing.len();
        if kept.is_empty() || same {
            return None;
        }
        let (to, exchanged) = self.phase_of(&kept)?;
        if exchanged {
            self.exchange(x);
        }
        if to < self.described {
            self.begin_phase(to, time, x);
        }
        Some(Ok(Passage { to, exchanged, held, planned: false }))
    }

    /// Points in the air that have come to the ground and go into it.
    fn landed(&self, spec: &PhaseSpec, x: &[f64]) -> Vec<usize> {
        let (q, v) = self.split(x);
        let speeds = self.normal_speeds(q, v);
        let air = self.in_the_air(spec, q, &mut self.work.borrow_mut());
        let lands = |&(point, height): &(usize, f64)| height <= TOUCHING && speeds[point] < 0.0;
        air.into_iter().filter(lands).map(|(point, _)| point).collect()
    }

    /// After an impact: what holds. Velocities are those just after it. `None`: no contacts obey the laws of contact.
    fn struck(
        &self,
        spec: &PhaseSpec,
        time: f64,
        (x, landed): (&mut [f64], &[usize]),
        impulse: &mut Vec<f64>,
    ) -> Option<Result<Vec<usize>, Violation>> {
        let mut closed: Vec<usize> = spec.standing.iter().chain(landed).copied().collect();
        closed.sort_unstable();
        let mut sets: Vec<usize> = (self.described..self.phases.len()).collect();
        sets.retain(|&set| self.phases[set].0.standing.iter().all(|point| closed.contains(point)));
        sets.sort_by_key(|&set| std::cmp::Reverse(self.phases[set].0.standing.len()));
        let (q, v) = self.split(x);
        let mut out = Vec::new();
        for set in sets {
            let (of, functions) = &self.phases[set];
            let (Some(map), Some(landing)) = (functions.impact, &of.impact) else { continue };
            self.call(map, &State::new().with(Argument::Q, q).with(Argument::V, v), &mut out);
            let (after, impulses) = out.split_at(v.len());
            let free = closed.iter().filter(|point| !of.standing.contains(point));
            let speeds = self.normal_speeds(q, after);
            let leave = free.into_iter().all(|&point| speeds[point] >= -STILL);
            if !leave || !self.all_push(of, &landing.rows, q, impulses) {
                continue;
            }
            if let Some(slips) = self.slips(spec, time, &landing.rows, impulses) {
                return Some(Err(slips));
            }
            impulse.extend_from_slice(impulses);
            let (after, standing) = (after.to_vec(), of.standing.clone());
            self.reach(spec, landed, x);
            x[self.model.nq()..].copy_from_slice(&after);
            return Some(Ok(standing));
        }
        None
    }

    /// Whether the ground pushes on every foot of a set, inside its sole.
    fn all_push(&self, of: &PhaseSpec, rows: &[Row], q: &[f64], impulses: &[f64]) -> bool {
        let work = &mut self.work.borrow_mut();
        (0..self.feet.len()).all(|foot| {
            let sole = self.sole(foot, &of.standing);
            let load = Load::of(foot, rows, impulses);
            if sole.is_empty() || !load.flat {
                return sole.is_empty() || load.force[2] >= -ROUNDING[1];
            }
            let (place, points, _) = self.pressure(q, &load, &sole, work);
            let value = inside(place, &points, self.base == BaseKind::Planar);
            load.force[2] >= -ROUNDING[1] && (value >= -CLOSE || value * load.force[2] >= -ROUNDING[1])
        })
    }

    /// What is left of the contacts of a phase whose feet are pulled, tip, or slip under next to no load.
    fn still_held(&self, phase: usize, time: f64, x: &[f64]) -> Vec<usize> {
        let spec = &self.phases[phase].0;
        let forces = self.forces(phase, time, x);
        let (q, _) = self.split(x);
        let work = &mut self.work.borrow_mut();
        let mut kept = Vec::new();
        for foot in 0..self.feet.len() {
            let sole = self.sole(foot, &spec.standing);
            let load = Load::of(foot, &spec.rows, &forces);
            if sole.is_empty() || load.force[2] < -ROUNDING[0] || self.slips_off(&load) {
                continue;
            }
            if !load.flat {
                kept.extend(sole);
                continue;
            }
            let (place, points, _) = self.pressure(q, &load, &sole, work);
            let outside = inside(place, &points, self.base == BaseKind::Planar);
            if outside >= -CLOSE {
                kept.extend(sole);
                continue;
            }
            // It tips about the points that are nearest to the centre of pressure.
            let distance = |point: &[f64; 2]| (point[0] - place[0]).hypot(point[1] - place[1]);
            let nearest = points.iter().map(distance).fold(f64::INFINITY, f64::min);
            let near = sole.iter().zip(&points).filter(|(_, place)| distance(place) <= nearest + CLOSE);
            kept.extend(near.map(|(point, _)| *point));
        }
        kept
    }

    /// Whether a foot slips that carries next to nothing: it is let go.
    fn slips_off(&self, load: &Load) -> bool {
        let light = self.assumptions.light * self.weight;
        let held = self.assumptions.friction * load.force[2].max(0.0);
        load.force[2] < light && load.force[0].hypot(load.force[1]) > held + light
    }

    /// The phase that has these contacts, as it is or with its sides exchanged, else the set of them.
    fn phase_of(&self, kept: &[usize]) -> Option<(usize, bool)> {
        let with = |points: &[usize], among: std::ops::Range<usize>| {
            among.into_iter().find(|&k| same(&self.phases[k].0.standing, points))
        };
        let described = 0..self.described;
        if let Some(found) = with(kept, described.clone()) {
            return Some((found, false));
        }
        if !self.mirrored.is_empty() {
            let other: Vec<usize> = kept.iter().map(|&point| self.mirrored[point]).collect();
            if let Some(found) = with(&other, described) {
                return Some((found, true));
            }
        }
        with(kept, self.described..self.phases.len()).map(|found| (found, false))
    }
}

/// Whether two sets of points are the same.
fn same(one: &[usize], other: &[usize]) -> bool {
    one.len() == other.len() && one.iter().all(|point| other.contains(point))
}
