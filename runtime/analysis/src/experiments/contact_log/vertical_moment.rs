//! Moments about the vertical that feet do not log, eliminated from the rows of the joints.
//!
//! A foot that logs its force and the centre of pressure leaves one number open: the moment M about the vertical, with
//! which two soles on the ground twist against each other. A joint's row lacks g M, where g is the joint's part of the
//! foot's Jacobian: 1 at a hip yaw of an upright leg, the sine of the lean at a pitch joint. One joint per foot, the one
//! that feels M most at all times, tells M; it has no row of its own then, and of each other joint's row r_j there is
//! left r_j − g_j M. That is exact, whatever M was; effects, inertial parameters and noise pass through it as residuals
//! do.
use super::ContactExperiment;
use super::forces::mapped;
use crate::measure::{Missing, Recording};
use crate::robot::feet::Sole;
use nalgebra::{DMatrix, RowDVector, Vector3};

/// A joint tells a moment if it feels at least this part of it at all times; more than this part of a moment that no
/// joint tells leaves no row worth having.
const FELT: f64 = 0.3;

/// What is taken from the rows of joints.
#[derive(Debug, Clone, Default)]
pub(super) struct Elimination {
    /// Joints that tell the moments.
    pub pivots: Vec<usize>,
    /// By sample: joints × pivots, how much of the pivots' rows is taken from each joint's.
    factors: Vec<DMatrix<f64>>,
}

impl Elimination {
    /// What is left of a joint's row; `pivot` gives the rows of the pivots, `None` is one of zeros.
    pub fn rest<'v>(
        &self,
        joint: usize,
        mut row: Vec<f64>,
        pivot: impl Fn(usize) -> Option<&'v [f64]>,
    ) -> Vec<f64> {
        for (k, values) in self.pivots.iter().enumerate().filter_map(|(k, p)| Some((k, pivot(*p)?))) {
            let parts = self.factors.iter().zip(values).map(|(factors, value)| factors[(joint, k)] * value);
            row.iter_mut().zip(parts).for_each(|(x, part)| *x -= part);
        }
        row
    }

    /// What is left of values by joint, at a sample.
    pub fn rest_at(&self, sample: usize, values: &mut [f64]) {
        let Some(factors) = self.factors.get(sample) else { return };
        let of_pivots: Vec<f64> = self.pivots.iter().map(|p| values[*p]).collect();
        for (joint, value) in values.iter_mut().enumerate() {
            *value -= of_pivots.iter().enumerate().map(|(k, x)| factors[(joint, k)] * x).sum::<f64>();
        }
    }
}

impl ContactExperiment<'_> {
    /// Which joints tell the moments that feet do not log, and what follows for the others. Takes away the efforts of
    /// joints that feel a moment that none tells.
    pub(super) fn vertical_moments(&self, motion: &mut Recording) -> (Elimination, Vec<Missing>) {
        let (mut pivots, mut told, mut missing) = (Vec::new(), Vec::new(), Vec::new());
        let names: Vec<&str> = self.robot.layout.joints.iter().map(|joint| joint.name.as_str()).collect();
        for (foot, record) in self.recording.feet.iter().enumerate() {
            let planar = self.robot.planar();
            if !record.is_logged || planar || record.columns.has_torque(planar) {
                continue;
            }
            let felt = self.felt(foot);
            let moment = format!("the moment about the vertical at `{}`", self.robot.feet[foot].name);
            let size = |joint: usize| felt.iter().map(move |sample: &Vec<f64>| sample[joint].abs());
            let least = |joint: usize| size(joint).fold(f64::INFINITY, f64::min);
            let logged = (0..names.len()).filter(|j| motion.effort[*j].is_some() && !pivots.contains(j));
            let best = logged.max_by(|a, b| least(*a).total_cmp(&least(*b)));
            if let Some(pivot) = best.filter(|pivot| least(*pivot) >= FELT) {
                let reason = format!("its effort tells {moment}, which is not logged");
                missing.push(Missing { name: names[pivot].to_owned(), reason });
                pivots.push(pivot);
                told.push(felt);
                continue;
            }
            for (joint, name) in names.iter().enumerate() {
                if size(joint).any(|felt| felt > FELT) && motion.effort[joint].take().is_some() {
                    let reason = format!("its effort depends on {moment}, which is not logged");
                    missing.push(Missing { name: (*name).to_owned(), reason });
                }
            }
        }
        let samples = if pivots.is_empty() { 0 } else { self.samples() };
        let factors = (0..samples).map(|sample| factors(&pivots, names.len(), |foot| &told[foot][sample]));
        (Elimination { factors: factors.collect(), pivots }, missing)
    }

    /// Of a unit moment about the vertical at a foot: what each joint feels, by sample.
    fn felt(&self, foot: usize) -> Vec<Vec<f64>> {
        let nominal = self.change(&[]);
        let (first, logged) = (self.robot.layout.base.nv(), self.recording.logged());
        let unit =
            |f: usize, _: &Sole| (Vector3::zeros(), if f == foot { Vector3::z() } else { Vector3::zeros() });
        let at = |sample: usize| {
            let [q, ..] = self.kinematics(sample, &nominal);
            mapped(&self.robot, &self.calls, &self.feet, &q, &logged, unit).split_off(first)
        };
        (0..self.samples()).map(at).collect()
    }
}

/// G G_p⁻¹, with what all joints (rows of G) and the pivots (of G_p) feel of the moments; nothing where that is singular.
fn factors<'v>(pivots: &[usize], joints: usize, felt: impl Fn(usize) -> &'v Vec<f64>) -> DMatrix<f64> {
    let count = pivots.len();
    let all = DMatrix::from_fn(joints, count, |joint, foot| felt(foot)[joint]);
    let own = DMatrix::from_fn(count, count, |row, foot| felt(foot)[pivots[row]]);
    let mut factors =
        own.try_inverse().map_or_else(|| DMatrix::zeros(joints, count), |inverse| all * inverse);
    // A pivot's row stays, for those that it is taken from.
    pivots.iter().for_each(|pivot| factors.set_row(*pivot, &RowDVector::zeros(count)));
    factors
}
