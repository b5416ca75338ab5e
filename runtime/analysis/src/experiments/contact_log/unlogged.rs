//! What feet do not log of the ground's forces, eliminated from the rows of the joints.
//!
//! A foot that logs its force and the centre of pressure leaves one number open: the moment about the vertical, with
//! which two soles on the ground twist against each other. One that logs the normal forces of its corners alone also leaves the two
//! horizontal forces open, with which two feet push against each other. A joint's row lacks g u, where u is what is open and g the joint's part of the
//! foot's Jacobian: of the moment 1 at a hip yaw of an upright leg, the sine of the lean at a pitch joint. One joint for each number, those
//! that feel them most at all times, tell u; they have no rows of their own then, and of each other joint's row r_j there is
//! left r_j − g_j G_p⁻¹ r_p. That is exact, whatever u was; effects, inertial parameters and noise pass through it as residuals
//! do.
use super::ContactExperiment;
use super::forces::mapped;
use crate::measure::{Missing, Recording};
use crate::robot::feet::Sole;
use nalgebra::{DMatrix, RowDVector, Vector3};

/// A joint tells a number if it feels at least this part of it at all times, of forces of what the joint with the longest lever feels; more than this part of
/// one that no joint tells leaves no row worth having.
const FELT: f64 = 0.3;
/// Several joints tell several numbers if the least felt mixture of them is felt by this part.
const FELT_TOGETHER: f64 = 0.1;
/// Samples at which that is looked at.
const PROBES: usize = 100;

/// What is taken from the rows of joints.
#[derive(Debug, Clone, Default)]
pub(super) struct Elimination {
    /// Joints that tell what is open, one for each number.
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

/// A force or moment of one at a foot's sole, in the axes of the world.
#[derive(Clone, Copy, PartialEq)]
enum Open {
    Force(usize),
    MomentAboutVertical,
}

impl Open {
    /// What a joint may feel of it: all of a moment, of a force the longest lever (m) that there is.
    fn most(self, felt: &Felt) -> f64 {
        match self {
            Self::Force(_) => {
                felt.iter().flatten().fold(f64::MIN_POSITIVE, |most, felt| most.max(felt.abs()))
            }
            Self::MomentAboutVertical => 1.0,
        }
    }

    fn wrench(self) -> (Vector3<f64>, Vector3<f64>) {
        match self {
            Self::Force(axis) => (Vector3::ith_axis(axis).into_inner(), Vector3::zeros()),
            Self::MomentAboutVertical => (Vector3::zeros(), Vector3::z()),
        }
    }
}

/// What the joints feel of a number that is open: by sample, by joint.
type Felt = Vec<Vec<f64>>;

impl ContactExperiment<'_> {
    /// Which joints tell what feet do not log, and what follows for the others. Takes away the efforts of
    /// joints that feel what none tells.
    pub(super) fn unlogged(&self, motion: &mut Recording) -> (Elimination, Vec<Missing>) {
        let (mut pivots, mut told, mut missing) = (Vec::new(), Vec::new(), Vec::new());
        let names: Vec<&str> = self.robot.layout.joints.iter().map(|joint| joint.name.as_str()).collect();
        for foot in 0..self.recording.feet.len() {
            let open = self.open(foot);
            if open.is_empty() {
                continue;
            }
            let felt: Vec<Felt> = open.iter().map(|open| self.felt(foot, *open)).collect();
            let what = self.named(foot, &open);
            let logged: Vec<usize> =
                (0..names.len()).filter(|j| motion.effort[*j].is_some() && !pivots.contains(j)).collect();
            if let Some(tell) = tell(&felt, &logged) {
                let reason = format!("its effort tells {what} not logged");
                missing.extend(
                    tell.iter()
                        .map(|joint| Missing { name: names[*joint].to_owned(), reason: reason.clone() }),
                );
                pivots.extend(tell);
                told.extend(felt);
                continue;
            }
            let feels =
                |joint: usize| felt.iter().any(|felt| felt.iter().any(|felt| felt[joint].abs() > FELT));
            for (joint, name) in names.iter().enumerate() {
                if feels(joint) && motion.effort[joint].take().is_some() {
                    let reason = format!("its effort depends on {what} not logged");
                    missing.push(Missing { name: (*name).to_owned(), reason });
                }
            }
        }
        let samples = if pivots.is_empty() { 0 } else { self.samples() };
        let factors = (0..samples).map(|sample| factors(&pivots, names.len(), |k| &told[k][sample]));
        (Elimination { factors: factors.collect(), pivots }, missing)
    }

    /// What a foot leaves open.
    fn open(&self, foot: usize) -> Vec<Open> {
        let (record, planar) = (&self.recording.feet[foot], self.robot.planar());
        if !record.is_logged {
            return Vec::new();
        }
        let horizontal = if planar { 0..1 } else { 0..2 };
        let is_open = |axis: &usize| record.from_corners || record.columns.force[*axis].is_none();
        let forces = horizontal.filter(is_open).map(Open::Force);
        let moment = (!planar && !record.columns.has_torque(planar)).then_some(Open::MomentAboutVertical);
        forces.chain(moment).collect()
    }

    /// The same in words, with its verb.
    fn named(&self, foot: usize, open: &[Open]) -> String {
        let forces = open.iter().any(|open| *open != Open::MomentAboutVertical);
        let moment = open.contains(&Open::MomentAboutVertical);
        let what = match (forces, moment) {
            (true, true) => "the horizontal forces and the moment about the vertical",
            (true, false) => "the horizontal force",
            _ => "the moment about the vertical",
        };
        let verb = if open.len() > 1 { "which are" } else { "which is" };
        format!("{what} at `{}`, {verb}", self.robot.feet[foot].name)
    }

    /// What each joint feels of an open number at a foot, in parts of the most that any may feel, by sample.
    fn felt(&self, foot: usize, open: Open) -> Felt {
        let nominal = self.change(&[]);
        let (first, logged) = (self.robot.layout.base.nv(), self.recording.logged());
        let none = (Vector3::zeros(), Vector3::zeros());
        let unit = |f: usize, _: &Sole| if f == foot { open.wrench() } else { none };
        let at = |sample: usize| {
            let [q, ..] = self.kinematics(sample, &nominal);
            mapped(&self.robot, &self.calls, &self.feet, &q, &logged, unit).split_off(first)
        };
        let mut felt: Felt = (0..self.samples()).map(at).collect();
        let most = open.most(&felt);
        felt.iter_mut().flatten().for_each(|felt| *felt /= most);
        felt
    }
}

/// The joints that tell all that is open at a foot, as many as there are numbers: those that feel the least felt mixture of them most at all times.
fn tell(felt: &[Felt], logged: &[usize]) -> Option<Vec<usize>> {
    let feels = |joint: &usize| felt.iter().any(|felt| felt.iter().any(|felt| felt[*joint] != 0.0));
    let near: Vec<usize> = logged.iter().copied().filter(feels).collect();
    let samples = felt.first()?.len();
    let least = |joints: &[usize]| {
        let probes = (0..samples).step_by((samples / PROBES).max(1));
        let part = |sample: usize, row: usize, k: usize| felt[k][sample][joints[row]];
        let matrix = |sample| DMatrix::from_fn(joints.len(), felt.len(), |row, k| part(sample, row, k));
        probes.map(|sample| matrix(sample).singular_values().min()).fold(f64::INFINITY, f64::min)
    };
    let sets = subsets(&near, felt.len());
    let ranked = sets.into_iter().map(|set| {
        let least = least(&set);
        (set, least)
    });
    let wanted = if felt.len() > 1 { FELT_TOGETHER } else { FELT };
    ranked.max_by(|a, b| a.1.total_cmp(&b.1)).filter(|(_, least)| *least >= wanted).map(|(set, _)| set)
}

/// All sets of so many of them.
fn subsets(of: &[usize], count: usize) -> Vec<Vec<usize>> {
    match (count, of) {
        (0, _) => vec![Vec::new()],
        (_, []) => Vec::new(),
        (_, [first, rest @ ..]) => {
            let with = subsets(rest, count - 1).into_iter().map(|set| [&[*first], set.as_slice()].concat());
            with.chain(subsets(rest, count)).collect()
        }
    }
}

/// G G_p⁻¹, with what all joints (rows of G) and the pivots (of G_p) feel of what is open; nothing where that is singular.
fn factors<'v>(pivots: &[usize], joints: usize, felt: impl Fn(usize) -> &'v Vec<f64>) -> DMatrix<f64> {
    let count = pivots.len();
    let all = DMatrix::from_fn(joints, count, |joint, k| felt(k)[joint]);
    let own = DMatrix::from_fn(count, count, |row, k| felt(k)[pivots[row]]);
    let mut factors =
        own.try_inverse().map_or_else(|| DMatrix::zeros(joints, count), |inverse| all * inverse);
    // A pivot's row stays, for those that it is taken from.
    pivots.iter().for_each(|pivot| factors.set_row(*pivot, &RowDVector::zeros(count)));
    factors
}
