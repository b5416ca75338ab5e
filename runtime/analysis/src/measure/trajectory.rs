//! States of the robot at the logged samples of a block.
use crate::log::Block;
use crate::measure::base;
use crate::measure::columns::{JointColumns, Plan};
use crate::measure::directions::Direction;
use crate::parallel::parallel;
use crate::robot::JointLayout;
use crate::signal::{Butterworth, Grid, Spline, align_signs, resample};
use std::ops::Range;

/// So many columns are filtered side by side.
const TOGETHER: usize = 4;

/// The columns of a block on an even grid, before filtering: common to all cut-offs.
pub(crate) struct Even {
    grid: Grid,
    /// One per selected column; empty for those that are not filtered (efforts).
    columns: Vec<Vec<f64>>,
    uniform: bool,
}

/// States of consecutive samples, state after state.
#[derive(Default)]
pub(crate) struct States {
    pub count: usize,
    pub q: Vec<f64>,
    pub v: Vec<f64>,
    pub a: Vec<f64>,
}

/// Why a block gave no states.
pub(crate) enum Unusable {
    /// Fewer samples than a spline needs.
    TooFew,
    /// The logged quaternion is zero at this time (s).
    ZeroQuaternion(f64),
}

impl Even {
    pub fn new(plan: &Plan, block: &Block<'_>, step: f64) -> Self {
        let (first, last) = (block.time[0], block.time[block.time.len() - 1]);
        let grid = if block.uniform {
            Grid { start: first, step, count: block.time.len() }
        } else {
            Grid::covering(block.start, step, first, last)
        };
        let mut raw: Vec<Vec<f64>> = vec![Vec::new(); plan.selected.len()];
        let motion = plan.joints.iter().flat_map(|j| [j.position, j.velocity]).flatten();
        for index in motion.chain(plan.base.iter().flat_map(|b| b.0.iter().copied())) {
            raw[index].clone_from(&block.columns[index]);
        }
        if let Some(Ok(quaternion)) =
            plan.base.as_ref().and_then(|b| b.0.get(3..7).map(<[usize; 4]>::try_from))
            && let Ok(columns) = raw.get_disjoint_mut(quaternion)
        {
            align_signs(columns.map(Vec::as_mut_slice));
        }
        if !block.uniform {
            for column in raw.iter_mut().filter(|c| !c.is_empty()) {
                *column = resample(block.time, column, grid);
            }
        }
        Self { grid, columns: raw, uniform: block.uniform }
    }

    /// Number of samples of the even grid.
    pub fn count(&self) -> usize {
        self.grid.count
    }

    /// Speeds of a joint whose position was logged, filtered, on the even grid; rad/s or m/s.
    pub fn speeds(&self, joint: &JointColumns, filter: &Butterworth) -> Result<Vec<f64>, Unusable> {
        let speeds = |column: usize, derivative: usize| -> Result<Vec<f64>, Unusable> {
            let smooth = filter.zero_phase(&self.columns[column]);
            let spline = Spline::new(&smooth, self.grid.step).ok_or(Unusable::TooFew)?;
            Ok((0..self.grid.count).map(|i| spline.at_sample(i)[derivative]).collect())
        };
        match (joint.velocity, joint.position) {
            (Some(velocity), _) => speeds(velocity, 0),
            (None, Some(position)) => speeds(position, 1),
            (None, None) => Ok(vec![0.0; self.grid.count]),
        }
    }

    /// A signal of the block, filtered and differentiated twice, at the samples `range`.
    pub fn motion_of(
        &self,
        signal: &[f64],
        filter: &Butterworth,
        time: &[f64],
        range: Range<usize>,
    ) -> Result<Vec<[f64; 3]>, Unusable> {
        let smooth = if self.uniform {
            filter.zero_phase(signal)
        } else {
            filter.zero_phase(&resample(time, signal, self.grid))
        };
        let spline = Spline::new(&smooth, self.grid.step).ok_or(Unusable::TooFew)?;
        let at = |i: usize| {
            if self.uniform { spline.at_sample(i) } else { spline.at(time[i] - self.grid.start) }
        };
        Ok(range.map(at).collect())
    }

    /// Appends directions on the even grid, taken at the logged samples of the block.
    pub fn directions_at(&self, found: &Direction, block: &Block<'_>, to: &mut Direction) {
        if self.uniform {
            to.sign.extend_from_slice(&found.sign[block.core.clone()]);
            to.known.extend_from_slice(&found.known[block.core.clone()]);
            return;
        }
        for time in &block.time[block.core.clone()] {
            let at = ((time - self.grid.start) / self.grid.step).clamp(0.0, (self.grid.count - 1) as f64);
            let (before, part) = (at.floor() as usize, at.fract());
            let after = (before + 1).min(self.grid.count - 1);
            to.sign.push((1.0 - part) * found.sign[before] + part * found.sign[after]);
            to.known.push(found.known[before] && found.known[after]);
        }
    }

    /// Of all columns behind a filter; `None` for those that are not filtered, or too short.
    fn splines(&self, filter: &Butterworth) -> Vec<Option<Spline>> {
        let mut splines: Vec<Option<Spline>> = vec![None; self.columns.len()];
        let wanted: Vec<usize> = (0..splines.len()).filter(|i| !self.columns[*i].is_empty()).collect();
        let (groups, rest) = wanted.as_chunks::<TOGETHER>();
        let group = |group: &[usize; TOGETHER]| {
            let filtered = filter.zero_phases(group.map(|i| &*self.columns[i]));
            Spline::all(filtered.each_ref().map(Vec::as_slice), self.grid.step)
        };
        let one = |i: usize| Spline::new(&filter.zero_phase(&self.columns[i]), self.grid.step);
        let found = parallel(groups.len() + rest.len(), |k| match groups.get(k) {
            Some(indices) => group(indices).map_or_else(Vec::new, Vec::from),
            None => one(rest[k - groups.len()]).into_iter().collect(),
        });
        let places = groups.iter().map(|group| &group[..]).chain(rest.iter().map(std::slice::from_ref));
        for (places, found) in places.zip(found) {
            places.iter().zip(found).for_each(|(place, spline)| splines[*place] = Some(spline));
        }
        splines
    }

    /// Filters and differentiates; the states of the samples `range` of the block.
    pub fn states(
        &self,
        plan: &Plan,
        layout: &JointLayout,
        filter: &Butterworth,
        time: &[f64],
        range: Range<usize>,
    ) -> Result<States, Unusable> {
        let splines = self.splines(filter);
        let motion = |column: usize, sample: usize| -> Result<[f64; 3], Unusable> {
            let spline = splines[column].as_ref().ok_or(Unusable::TooFew)?;
            Ok(if self.uniform {
                spline.at_sample(sample)
            } else {
                spline.at(time[sample] - self.grid.start)
            })
        };
        let (bq, bv) = (layout.base.nq(), layout.base.nv());
        let (nq, nv) = (bq + layout.joints.len(), bv + layout.joints.len());
        let count = range.len();
        let mut states =
            States { count, q: vec![0.0; count * nq], v: vec![0.0; count * nv], a: vec![0.0; count * nv] };
        let mut base_motion = Vec::with_capacity(bq);
        for (i, sample) in range.enumerate() {
            let q = &mut states.q[i * nq..(i + 1) * nq];
            let v = &mut states.v[i * nv..(i + 1) * nv];
            let a = &mut states.a[i * nv..(i + 1) * nv];
            match &plan.base {
                None => q[..layout.base.nq()].copy_from_slice(layout.base.rest()),
                Some(columns) => {
                    base_motion.clear();
                    for column in &columns.0 {
                        base_motion.push(motion(*column, sample)?);
                    }
                    base::fill(layout.base, &base_motion, q, v, a)
                        .ok_or(Unusable::ZeroQuaternion(time[sample]))?;
                }
            }
            for (j, columns) in plan.joints.iter().enumerate() {
                let Some(position) = columns.position else { continue };
                [q[bq + j], v[bv + j], a[bv + j]] = motion(position, sample)?;
                if let Some(velocity) = columns.velocity {
                    [v[bv + j], a[bv + j], _] = motion(velocity, sample)?;
                }
            }
        }
        Ok(states)
    }
}
