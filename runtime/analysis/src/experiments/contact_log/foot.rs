//! What the sensors of one foot reported, as signals that can be filtered.
use super::columns::FootColumns;
use super::passing::Passing;
use crate::log::Block;
use crate::measure::trajectory::Unusable;
use crate::robot::Foot;
use crate::robot::feet::Sole;
use crate::signal::Butterworth;
use nalgebra::Vector3;

/// Signals of a foot, all in the frame of its forces: force; force times each coordinate of the centre of pressure;
/// torque about the sole's origin; the centre of pressure.
///
/// They are filtered as products, so that the moment of a force at a moving centre of pressure stays right.
pub(super) const SIGNALS: usize = 14;

/// What a foot's sensors reported.
#[derive(Debug, Clone, Default)]
pub(super) struct FootRecord {
    pub columns: FootColumns,
    /// Force, moment and centre of pressure are from the corners alone: the horizontal force is not known.
    pub from_corners: bool,
    pub is_logged: bool,
    /// `samples × SIGNALS`.
    pub signals: Vec<[f64; SIGNALS]>,
    /// Noise of the raw signals, as the longest stretch without a gap tells it, and how many samples that has.
    pub noise: [f64; SIGNALS],
    pub heard: usize,
    /// Corner forces along the sole's normal by corner, if all are logged; N.
    pub corners: Vec<Vec<f64>>,
    /// Largest raw reading near each sample, whole foot (z) first, then by corner; N.
    pub peaks: Vec<Vec<f64>>,
}

impl FootRecord {
    pub fn add(
        &mut self,
        passing: &Passing<'_, '_>,
        block: &Block<'_>,
        foot: &Foot,
        at: &[usize],
    ) -> Result<(), Unusable> {
        let raw = self.raw(block, foot);
        if block.time.len() > self.heard {
            self.heard = block.time.len();
            self.noise = std::array::from_fn(|k| passing.noise(block, &raw[k]));
        }
        self.signals.extend(self.filtered(passing, passing.filter, block, foot, at)?);
        let reach = passing.reach;
        self.peaks[0].extend(peaks(&raw[2], at, reach));
        for k in 0..self.corners.len() {
            let Some(column) = self.columns.corners[k] else { continue };
            self.corners[k].extend(passing.smooth(block, &block.columns[column], at)?);
            self.peaks[1 + k].extend(peaks(&block.columns[column], at, reach));
        }
        Ok(())
    }

    /// The signals behind a filter, at samples of the block.
    pub fn filtered(
        &self,
        passing: &Passing<'_, '_>,
        filter: &Butterworth,
        block: &Block<'_>,
        foot: &Foot,
        at: &[usize],
    ) -> Result<Vec<[f64; SIGNALS]>, Unusable> {
        let raw = self.raw(block, foot);
        let smooth = raw.iter().map(|column| passing.through(filter, block, column, at));
        let smooth = smooth.collect::<Result<Vec<_>, _>>()?;
        Ok((0..at.len()).map(|i| std::array::from_fn(|k| smooth[k][i])).collect())
    }

    /// The signals as reported, not filtered.
    pub fn raw(&self, block: &Block<'_>, foot: &Foot) -> [Vec<f64>; SIGNALS] {
        let count = block.time.len();
        let column = |c: Option<usize>| c.map_or_else(|| vec![0.0; count], |c| block.columns[c].clone());
        let mut signals: [Vec<f64>; SIGNALS] = std::array::from_fn(|_| vec![0.0; count]);
        if self.from_corners {
            for (k, corner) in self.columns.corners.iter().enumerate() {
                let place = foot.corner(k);
                for (i, force) in column(*corner).into_iter().enumerate() {
                    signals[2][i] += force;
                    signals[9][i] += place.y * force;
                    signals[10][i] -= place.x * force;
                }
            }
            return signals;
        }
        for k in 0..3 {
            signals[k] = column(self.columns.force[k]);
            signals[9 + k] = column(self.columns.torque[k]);
        }
        let turned = self.has_moment();
        for axis in 0..2 {
            let center = match self.columns.point {
                Some(point) => vec![point[axis]; count],
                None => column(self.columns.cop[axis]),
            };
            for (i, center) in center.into_iter().enumerate() {
                // Without load there is no centre of pressure, and next to no force that needs one.
                let center = if center.is_finite() { center } else { 0.0 };
                signals[12 + axis][i] = center;
                if turned {
                    continue;
                }
                for k in 0..3 {
                    signals[3 + 3 * axis + k][i] = center * signals[k][i];
                }
            }
        }
        signals
    }

    /// Whether the moment was logged, not only where the force acts.
    pub fn has_moment(&self) -> bool {
        self.columns.torque.iter().any(Option::is_some)
    }

    /// Whether force and torque are in the axes of the sole.
    pub fn in_sole(&self) -> bool {
        self.columns.in_sole || self.from_corners
    }

    /// Force and moment about the sole's origin, world axes.
    pub fn wrench(&self, sole: &Sole, s: &[f64; SIGNALS]) -> (Vector3<f64>, Vector3<f64>) {
        let part = |k: usize| {
            let vector = Vector3::new(s[k], s[k + 1], s[k + 2]);
            if self.in_sole() { sole.rotation * vector } else { vector }
        };
        let arm = |axis: usize| sole.rotation.column(axis).into_owned();
        (part(0), part(9) + arm(0).cross(&part(3)) + arm(1).cross(&part(6)))
    }
}

/// Largest values within `reach` samples.
fn peaks(column: &[f64], at: &[usize], reach: usize) -> Vec<f64> {
    let around = |i: usize| &column[i.saturating_sub(reach)..(i + reach + 1).min(column.len())];
    at.iter().map(|i| around(*i).iter().copied().fold(f64::NEG_INFINITY, f64::max)).collect()
}
