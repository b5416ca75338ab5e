//! Torques of springs and stiff drives over time, for reports.
use super::super::picture::Pictures;
use super::super::reading::Reading;
use super::fold::Folding;
use super::rows::JointRows;
use super::signals::{Chunk, Making, each};
use super::solve::Solved;
use crate::experiments::plotted::Row;
use bipedc_effects::diagnostic::Diagnostics;
use nalgebra::DVector;

/// Samples that are evaluated together.
const BATCH: usize = 256;

/// Torques of a log as the regression saw them, with the springs that were found; samples that do not count are gaps.
///
/// # Errors
/// Those of the reader.
pub fn of_log(
    folding: &Folding<'_, '_>,
    reading: &Reading<'_>,
    solved: &Solved,
    nominal: &DVector<f64>,
) -> Result<Vec<Row>, Diagnostics> {
    let design = folding.design;
    let mut pictures = Pictures::new(design, [nominal, &solved.joints.value]);
    let mut rows = JointRows::new(design, folding.drives);
    let elastic: Vec<usize> = (0..folding.drives.len())
        .filter(|&t| folding.drives[t].drive.is_elastic())
        .filter(|&t| design.channels.iter().any(|c| c.joint == Some(folding.drives[t].joint)))
        .collect();
    let stiffness = |drive: Option<usize>| {
        let k = elastic.iter().position(|t| Some(*t) == drive)?;
        Some(solved.motors[k].value[folding.laws.stiffness()])
    };
    let joints = design.layout.joints.len();
    let (bq, bv) = (design.layout.base.nq(), design.layout.base.nv());
    let making = Making { layout: design.layout, drives: folding.drives, slow: folding.slow, split: false };
    let mut visit = |chunk: &Chunk, _: Option<&Chunk>| {
        let mut columns = Vec::new();
        let mut first = 0;
        while first < chunk.len() && !pictures.is_full() {
            let count = BATCH.min(chunk.len() - first);
            let piece = rows.evaluate(chunk, first..first + count);
            for (index, channel) in design.channels.iter().enumerate() {
                let Some(joint) = channel.joint else { continue };
                rows.columns(index, chunk, &piece, &mut columns);
                let spring = stiffness(rows.drive(channel.joint)).unwrap_or(0.0);
                for i in 0..count {
                    let ([known, per_stiffness], counts) = rows.torque(index, chunk, &piece, i);
                    let torque = if counts { known + spring * per_stiffness } else { f64::NAN };
                    let at = first + i;
                    let state =
                        [chunk.q[at * (bq + joints) + bq + joint], chunk.v[at * (bv + joints) + bv + joint]];
                    pictures.push(
                        index,
                        channel,
                        (&columns, count, i),
                        [chunk.time[at], torque, state[0], state[1]],
                    );
                }
            }
            first += count;
        }
    };
    each(reading, &making, &mut visit)?;
    Ok(pictures.rows(design))
}
