//! How the inertial parameters of the bodies enter joint torques.
use super::experiment::MotionExperiment;
use super::under_effects::Inertials;
use crate::experiments::{Channel, Inertial};
use crate::parallel::parallel;
use crate::robot::Trajectory;
use std::sync::{Mutex, PoisonError};

/// Samples that one processor takes at a time.
const CHUNK: usize = 512;

impl MotionExperiment<'_> {
    /// Of all samples, by row.
    pub(super) fn all_inertial(&self) -> &[Option<Inertial>] {
        let trajectory = &self.recording.trajectory;
        self.inertial.get_or_init(|| self.inertial_columns(trajectory, trajectory, &|_| true))
    }

    /// Of some samples: all are not formed for them.
    pub(super) fn inertial_of(&self, samples: &[usize]) -> Vec<Option<Inertial>> {
        let trajectory = &self.recording.trajectory;
        match self.inertial.get() {
            Some(all) => all.iter().map(|inertial| inertial.as_ref().map(|i| i.at(samples))).collect(),
            None => self.inertial_columns(&trajectory.some(samples), trajectory, &|_| true),
        }
    }

    /// Regressor rows of the joints with an effort, without the columns that are zero throughout or not `wanted`.
    /// `all_states`: those that `states` are some of.
    pub(super) fn inertial_columns(
        &self,
        states: &Trajectory,
        all_states: &Trajectory,
        wanted: &dyn Fn(usize) -> bool,
    ) -> Inertials {
        let (nv, base) = (self.rigid.nv, self.layout.base.nv());
        let mut all = self.present_columns(all_states);
        all.iter_mut().flatten().for_each(|inertial| {
            inertial.columns.retain(|column| wanted(*column));
            inertial.values = vec![0.0; states.len() * inertial.columns.len()];
        });
        let rows: Vec<(usize, Vec<usize>)> = all
            .iter()
            .zip(&self.joint_of)
            .filter_map(|(inertial, joint)| Some((base + joint, inertial.as_ref()?.columns.clone())))
            .collect();
        // Row by row what belongs to each chunk of samples.
        let mut chunks: Vec<Vec<&mut [f64]>> =
            (0..states.len().div_ceil(CHUNK)).map(|_| Vec::new()).collect();
        for inertial in all.iter_mut().flatten().filter(|inertial| !inertial.columns.is_empty()) {
            let parts = inertial.values.chunks_mut(CHUNK * inertial.columns.len());
            chunks.iter_mut().zip(parts).for_each(|(chunk, part)| chunk.push(part));
        }
        let chunks: Vec<Mutex<Vec<&mut [f64]>>> = chunks.into_iter().map(Mutex::new).collect();
        parallel(chunks.len(), |k| {
            let mut parts = chunks[k].lock().unwrap_or_else(PoisonError::into_inner);
            let own = k * CHUNK..((k + 1) * CHUNK).min(states.len());
            self.rigid.regressors(&states.part(own), |i, regressor| {
                let told = rows.iter().filter(|(_, columns)| !columns.is_empty());
                for ((at, columns), part) in told.zip(&mut *parts) {
                    let values = &mut part[i * columns.len()..(i + 1) * columns.len()];
                    let entries = columns.iter().map(|column| regressor[column * nv + at]);
                    values.iter_mut().zip(entries).for_each(|(value, entry)| *value = entry);
                }
            });
        });
        all
    }

    /// Which columns a row has is a matter of the tree: a few samples tell.
    fn present_columns(&self, states: &Trajectory) -> Vec<Option<Inertial>> {
        let (nv, base, samples) = (self.rigid.nv, self.layout.base.nv(), states.len());
        let probe: Vec<usize> = (0..4).map(|k| k * (samples - 1) / 3).collect();
        let few = states.some(&probe);
        let mut present = vec![vec![false; self.rigid.parameters]; self.rows.len()];
        self.rigid.regressors(&few.batch(), |_, regressor| {
            for (present, joint) in present.iter_mut().zip(&self.joint_of) {
                for (column, found) in present.iter_mut().enumerate() {
                    *found |= regressor[column * nv + base + joint] != 0.0;
                }
            }
        });
        let of_row = |(row, present): (usize, Vec<bool>)| {
            let columns = (0..present.len()).filter(|column| present[*column]).collect();
            (self.rows[row].channel == Channel::Effort).then(|| Inertial { columns, values: Vec::new() })
        };
        present.into_iter().enumerate().map(of_row).collect()
    }
}
