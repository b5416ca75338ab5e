//! What a log's signals pass on their way to the samples of a recording.
use super::columns::Columns;
use super::products::Products;
use crate::log::Block;
use crate::measure::noise::white_noise;
use crate::measure::slow_noise::slow_noise;
use crate::measure::trajectory::Unusable;
use crate::robot::Robot;
use crate::signal::{Butterworth, Grid, Spline, resample};
use nalgebra::{Rotation3, UnitQuaternion};
use std::borrow::Cow;

/// What stays the same from block to block.
pub(super) struct Passing<'a, 'r> {
    pub robot: &'a Robot<'r>,
    pub columns: &'a Columns,
    pub filter: &'a Butterworth,
    pub products: Option<Products<'r>>,
    pub step: f64,
    pub stride: usize,
    /// Of the filter, Hz.
    pub cutoff_hz: f64,
    /// Samples over which the filter smears a sensor that stays at its limit.
    pub reach: usize,
    /// Of the robot, N.
    pub weight: f64,
    /// At impacts.
    pub cut: bool,
}

/// Roll, pitch, yaw as a quaternion, after the file's columns.
pub(super) fn with_quaternion(columns: &Columns, block: &Block<'_>) -> Option<Vec<Vec<f64>>> {
    let [roll, pitch, yaw] = columns.angles?.map(|c| &block.columns[c]);
    let mut all = block.columns.to_vec();
    let mut quaternion: Vec<Vec<f64>> = vec![Vec::new(); 4];
    for ((roll, pitch), yaw) in roll.iter().zip(pitch).zip(yaw) {
        let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_euler_angles(*roll, *pitch, *yaw));
        quaternion.iter_mut().zip(turn.coords.iter()).for_each(|(column, value)| column.push(*value));
    }
    all.append(&mut quaternion);
    Some(all)
}

impl Passing<'_, '_> {
    /// Standard deviation of the white noise that leaves as much behind the filter as the noise of a column of forces does.
    pub fn noise(&self, block: &Block<'_>, column: &[f64]) -> f64 {
        let white = white_noise(column);
        let slow = slow_noise(&self.evenly(block, column).0, self.step, self.cutoff_hz, white);
        slow.unwrap_or(white)
    }

    /// A column at even times, and the first of these.
    fn evenly<'c>(&self, block: &Block<'_>, column: &'c [f64]) -> (Cow<'c, [f64]>, f64) {
        let [first, .., last] = block.time else { return (column.into(), block.start) };
        if block.uniform {
            return (column.into(), *first);
        }
        let grid = Grid::covering(block.start, self.step, *first, *last);
        (resample(block.time, column, grid).into(), grid.start)
    }

    /// A column filtered, at samples of the block.
    pub fn smooth(&self, block: &Block<'_>, column: &[f64], at: &[usize]) -> Result<Vec<f64>, Unusable> {
        self.through(self.filter, block, column, at)
    }

    /// The same through any filter.
    pub fn through(
        &self,
        filter: &Butterworth,
        block: &Block<'_>,
        column: &[f64],
        at: &[usize],
    ) -> Result<Vec<f64>, Unusable> {
        if column.iter().all(|x| *x == 0.0) {
            return Ok(vec![0.0; at.len()]);
        }
        let (even, start) = self.evenly(block, column);
        let smooth = filter.zero_phase(&even);
        if block.uniform {
            return Ok(at.iter().map(|i| smooth[*i]).collect());
        }
        let spline = Spline::new(&smooth, self.step).ok_or(Unusable::TooFew)?;
        Ok(at.iter().map(|i| spline.at(block.time[*i] - start)[0]).collect())
    }
}
