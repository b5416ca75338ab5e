//! A first look at a log of drives: which motion, how fast motors turn, how far springs are stretched.
use super::super::reading::Reading;
use super::super::survey::Survey;
use super::driven::Driven;
use super::plan::{Columns, observed};
use super::signals::{Chunk, Making, each};
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};

/// Positions are kept this far apart, s: enough to know a motion again.
const GRID: f64 = 0.01;
/// Fewer samples tell nothing.
const FEWEST: usize = 50;

/// What a log shows of drives, without its samples.
#[derive(Debug, Clone)]
pub struct Look {
    /// Motion, sampling, warnings; `effort` says whose row can be used.
    pub survey: Survey,
    /// By joint.
    pub columns: Vec<Columns>,
    /// By drive; nothing where the log does not show it.
    pub(super) drives: Vec<Seen>,
}

/// What was seen of one drive.
#[derive(Debug, Clone, Default)]
pub struct Seen {
    /// Usable samples.
    pub samples: usize,
    /// Largest speed of the motor shaft, rad/s.
    pub speed: f64,
    /// Of the joint's angle, rad.
    pub angle: Extent,
    /// Of the motor's current, A.
    pub current: Extent,
    /// Of the spring's elongation, m.
    pub elongation: Extent,
    /// Motor angle over joint angle.
    pub line: Line,
}

/// Smallest and largest of some values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Extent {
    pub low: f64,
    pub high: f64,
}

impl Default for Extent {
    fn default() -> Self {
        Self { low: f64::INFINITY, high: f64::NEG_INFINITY }
    }
}

impl Extent {
    fn take(&mut self, x: f64) {
        (self.low, self.high) = (self.low.min(x), self.high.max(x));
    }

    /// Largest size.
    pub fn size(&self) -> f64 {
        self.low.abs().max(self.high.abs())
    }

    /// From smallest to largest; 0 for nothing.
    pub fn width(&self) -> f64 {
        (self.high - self.low).max(0.0)
    }
}

/// Sums for a straight line, about the first point so that large angles keep their digits.
#[derive(Debug, Clone, Copy, Default)]
pub struct Line {
    origin: Option<[f64; 2]>,
    count: f64,
    sums: [f64; 2],
    products: [f64; 3],
}

impl Line {
    fn take(&mut self, x: f64, y: f64) {
        let origin = *self.origin.get_or_insert([x, y]);
        let (x, y) = (x - origin[0], y - origin[1]);
        self.count += 1.0;
        self.sums = [self.sums[0] + x, self.sums[1] + y];
        let [xx, xy, yy] = self.products;
        self.products = [xx + x * x, xy + x * y, yy + y * y];
    }

    /// Slope of y over x and their correlation; `None` if either stands still.
    pub fn slope(&self) -> Option<[f64; 2]> {
        let n = self.count.max(1.0);
        let [x, y] = self.sums;
        let [xx, xy, yy] = self.products;
        let (vx, vy, c) = (xx - x * x / n, yy - y * y / n, xy - x * y / n);
        (vx > 1e-12 && vy > 1e-12).then(|| [c / vx, c / (vx * vy).sqrt()])
    }
}

/// Looks at a log.
///
/// # Errors
/// Those of the reader; a log without a whole series elastic drive, or with hardly a sample.
pub fn look(reading: &Reading<'_>, layout: &JointLayout, drives: &[Driven<'_>]) -> Result<Look, Diagnostics> {
    let joints = layout.joints.len();
    let mut survey = Survey { speed: vec![0.0; joints], ..Survey::default() };
    survey.motion.positions = vec![Vec::new(); joints];
    let mut seen = vec![Seen::default(); drives.len()];
    let slow = vec![0.0; drives.len()];
    let making = Making { layout, drives, slow: &slow, split: false };
    let mut visit = |chunk: &Chunk, _: Option<&Chunk>| {
        note_motion(&mut survey, chunk, layout);
        for ((seen, driven), motor) in seen.iter_mut().zip(drives).zip(&chunk.motors) {
            for (i, motion) in motor.motion.iter().enumerate() {
                let q = chunk.q[i * (layout.base.nq() + joints) + layout.base.nq() + driven.joint];
                seen.samples += 1;
                seen.speed = seen.speed.max(motion[1].abs());
                seen.angle.take(q);
                seen.current.take(motor.current[i]);
                motor.elongation.get(i).iter().for_each(|x| seen.elongation.take(**x));
                seen.line.take(q, motion[0]);
            }
        }
    };
    let head = each(reading, &making, &mut visit)?;
    survey.effort = observed(&head.plan.joints, drives);
    (survey.step, survey.cutoff_hz) = (head.step, head.cutoff_hz);
    (survey.assumptions, survey.warnings) = (head.plan.assumptions, head.plan.warnings);
    if survey.samples < FEWEST {
        let message = format!("only {} samples of the log can be used", survey.samples);
        let error = Diagnostic::error(message).in_file(reading.log.path());
        let warnings = survey.warnings.into_iter();
        return Err(Diagnostics(
            warnings.chain([error.help("at least a few seconds of motion are needed")]).collect(),
        ));
    }
    Ok(Look { survey, columns: head.plan.joints, drives: seen })
}

fn note_motion(survey: &mut Survey, chunk: &Chunk, layout: &JointLayout) {
    let joints = layout.joints.len();
    let (bq, bv) = (layout.base.nq(), layout.base.nv());
    survey.samples += chunk.len();
    for (i, &time) in chunk.time.iter().enumerate() {
        let v = &chunk.v[i * (bv + joints) + bv..][..joints];
        survey.speed.iter_mut().zip(v).for_each(|(most, v)| *most = most.max(v.abs()));
        if survey.motion.time.last().is_none_or(|last| time - last >= 0.999 * GRID) {
            survey.motion.push(time, &chunk.q[i * (bq + joints) + bq..][..joints]);
        }
    }
}
