//! Measured against modelled torques over time, for reports.
use super::design::{Channel, Design, Work};
use super::reading::Reading;
use crate::experiments::Channel as Kind;
use crate::experiments::plotted::{Row, Series};
use crate::measure::Recording;
use bipedc_effects::diagnostic::Diagnostics;
use nalgebra::DVector;

/// Samples that are evaluated together.
const BATCH: usize = 256;
/// Most samples that are kept; a page shows fewer.
const MOST: usize = 100_000;

/// Torques of each channel, measured and by two models: described and estimated.
pub(super) struct Pictures<'a> {
    models: [&'a DVector<f64>; 2],
    series: Vec<Series>,
    states: Vec<[Vec<f64>; 2]>,
}

impl<'a> Pictures<'a> {
    pub fn new(design: &Design<'_>, models: [&'a DVector<f64>; 2]) -> Self {
        let empty =
            Series { amended: Some(Vec::new()), amended_name: "identified".to_owned(), ..Series::default() };
        let count = design.channels.len();
        Self { models, series: vec![empty; count], states: vec![[Vec::new(), Vec::new()]; count] }
    }

    /// Whether enough is kept.
    pub fn is_full(&self) -> bool {
        self.series.iter().any(|series| series.time.len() >= MOST)
    }

    /// A sample of a channel: regressor `columns[k * count + i]`, what was measured, position and velocity of its joint.
    pub fn push(
        &mut self,
        index: usize,
        channel: &Channel,
        columns: (&[f64], usize, usize),
        sample: [f64; 4],
    ) {
        let (values, count, i) = columns;
        let [time, measured, position, velocity] = sample;
        let of = |theta: &DVector<f64>| -> f64 {
            channel.places.iter().enumerate().map(|(k, &place)| theta[place] * values[k * count + i]).sum()
        };
        let series = &mut self.series[index];
        series.time.push(time);
        series.measured.push(measured);
        series.nominal.push(of(self.models[0]));
        series.amended.get_or_insert_default().push(of(self.models[1]));
        self.states[index][0].push(position);
        self.states[index][1].push(velocity);
    }

    /// Rows of a report; channels without a sample are left out.
    pub fn rows(self, design: &Design<'_>) -> Vec<Row> {
        let all = design.channels.iter().zip(self.series).zip(self.states);
        let shown = all.filter(|((_, series), _)| !series.time.is_empty());
        shown
            .map(|((channel, series), [position, velocity])| {
                let units = if channel.unit == "N" { ["m", "m/s"] } else { ["rad", "rad/s"] };
                let series = series.with("velocity", units[1], velocity).with("position", units[0], position);
                let row = Row::new(&channel.name, Kind::Effort, channel.unit, 0.0, series);
                if channel.joint.is_some() { row.at_joint(&channel.name) } else { row }
            })
            .collect()
    }
}

/// Torques of a log of joint torques, filtered as the regression saw them.
pub(super) fn of_log(
    design: &Design<'_>,
    reading: &Reading<'_>,
    fastest: &[f64],
    models: [&DVector<f64>; 2],
) -> Result<Vec<Row>, Diagnostics> {
    let mut pictures = Pictures::new(design, models);
    let mut work = Work::default();
    let mut visit = |recording: &mut Recording| {
        let mut first = 0;
        while first < recording.samples() && !pictures.is_full() {
            let count = BATCH.min(recording.samples() - first);
            add(&mut pictures, design, recording, (first, count), &mut work);
            first += count;
        }
        recording.clear();
        Ok(())
    };
    let directions = design.directions(fastest);
    Recording::each(reading.log, design.layout, &reading.options, Some(&directions), &mut visit)?;
    Ok(pictures.rows(design))
}

fn add(
    pictures: &mut Pictures<'_>,
    design: &Design<'_>,
    recording: &Recording,
    (first, count): (usize, usize),
    work: &mut Work,
) {
    let batch = recording.trajectory.part(first..first + count);
    design.evaluate(&batch, work);
    let mut columns = Vec::new();
    for (index, channel) in design.channels.iter().enumerate() {
        let Some(joint) = channel.joint else { continue };
        let Some(effort) = &recording.effort[joint] else { continue };
        design.rows(index, &batch, Some((&recording.directions, first)), work, &mut columns);
        for i in 0..count {
            let state = recording.trajectory.joints_at(first + i).map(|joints| joints[joint]);
            let sample = [recording.time[first + i], effort[first + i], state[0], state[1]];
            pictures.push(index, channel, (&columns, count, i), sample);
        }
    }
}
