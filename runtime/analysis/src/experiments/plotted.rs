//! Measured and modelled values over time, with what they may depend on: for plots.
use super::Channel;

/// One measured scalar: what was measured, what was predicted, and how far they are apart.
///
/// [`Row::new`] computes the errors from the series; a caller that judged other samples may overwrite them.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Such as `left_knee_pitch` or `cop/x`.
    pub name: String,
    /// Kind of quantity.
    pub channel: Channel,
    /// Of the measured values.
    pub unit: String,
    /// The joint of the drawing that it belongs to.
    pub joint: Option<String>,
    /// Standard deviation of the measurement's noise; 0 if unknown.
    pub noise: f64,
    /// Root mean square of measured minus nominal.
    pub rms_before: f64,
    /// Root mean square of measured minus amended; `None` without effects.
    pub rms_after: Option<f64>,
    /// Both without the samples at which the joint sticks; `None` where it never does.
    pub rms_moving: [Option<f64>; 2],
    /// Both where nothing jumps and the joint does not stick; `None` where nothing does.
    pub away_from_jumps: [Option<f64>; 2],
    /// `√(rms² − (1.05 noise)²) / (root mean square of the measured values)`: what noise does not account for, as a
    /// fraction. Estimates of noise are good to some 5 %, and a small difference of squares has a large root. Errors are those
    /// without sticking. NaN for heights of soles, which have no size of their own.
    pub unexplained_before: f64,
    /// The same with effects; `None` without effects.
    pub unexplained_after: Option<f64>,
    /// What is structured in the residual, in words; may be empty.
    pub note: String,
    /// The error by what the joint was doing; may be empty.
    pub parts: Vec<RowPart>,
    /// Over time; any length.
    pub series: Series,
}

/// The error of a row over some of its samples.
#[derive(Debug, Clone, PartialEq)]
pub struct RowPart {
    /// Such as `reversing`, `velocity > 0` or `left support`.
    pub name: String,
    /// How many.
    pub samples: usize,
    /// As [`Row::rms_before`].
    pub rms_before: f64,
    /// As [`Row::rms_after`].
    pub rms_after: Option<f64>,
}

impl Row {
    /// A row whose errors are those of its series. Samples that are not finite do not count.
    pub fn new(name: impl Into<String>, channel: Channel, unit: &str, noise: f64, series: Series) -> Self {
        let (before, after) =
            (rms(series.residual()), series.amended.as_ref().map(|_| rms(series.residual_after())));
        let row = Self {
            name: name.into(),
            channel,
            unit: unit.to_owned(),
            joint: None,
            noise: if noise.is_finite() { noise.max(0.0) } else { 0.0 },
            rms_before: before,
            rms_after: after,
            rms_moving: [None; 2],
            away_from_jumps: [None; 2],
            unexplained_before: 0.0,
            unexplained_after: None,
            note: String::new(),
            parts: Vec::new(),
            series,
        };
        row.judged(before, after)
    }

    /// Puts errors that were judged elsewhere in the place of those of the series.
    pub fn judged(mut self, before: f64, after: Option<f64>) -> Self {
        (self.rms_before, self.rms_after) = (before, after);
        self.without_sticking([None; 2])
    }

    /// Errors before and after where nothing jumps: what is left unexplained is theirs.
    pub fn where_nothing_jumps(mut self, away: [Option<f64>; 2]) -> Self {
        self.away_from_jumps = away;
        let moving = self.rms_moving;
        self.without_sticking(moving)
    }

    /// Errors before and after without the samples at which the joint sticks: what is left unexplained is theirs, unless something jumps.
    pub fn without_sticking(mut self, moving: [Option<f64>; 2]) -> Self {
        self.rms_moving = moving;
        let size = rms(self.series.measured.iter().copied()).max(f64::MIN_POSITIVE);
        // A sole on the ground measures a height of nothing: no share of that is left.
        let size = if self.channel == Channel::Sole { f64::NAN } else { size };
        let unexplained =
            |error: f64| (error * error - (NOISE_MARGIN * self.noise).powi(2)).max(0.0).sqrt() / size;
        (self.unexplained_before, self.unexplained_after) =
            (unexplained(self.told_before()), self.told_after().map(unexplained));
        self
    }

    /// The error that is held against the noise.
    pub fn told_before(&self) -> f64 {
        self.away_from_jumps[0].or(self.rms_moving[0]).unwrap_or(self.rms_before)
    }

    /// The same with effects; `None` without effects.
    pub fn told_after(&self) -> Option<f64> {
        self.away_from_jumps[1].filter(|_| self.rms_after.is_some()).or_else(|| self.moving_after())
    }

    /// The error with effects where the joint does not stick; `None` without effects.
    pub fn moving_after(&self) -> Option<f64> {
        self.rms_after.map(|after| self.rms_moving[1].unwrap_or(after))
    }

    /// Belongs to this joint of the drawing.
    pub fn at_joint(mut self, joint: impl Into<String>) -> Self {
        self.joint = Some(joint.into());
        self
    }

    /// Adds the error over the samples that `chosen` says.
    pub fn with_part(mut self, name: impl Into<String>, chosen: impl Fn(usize) -> bool) -> Self {
        let of = |residual: &mut dyn Iterator<Item = f64>| {
            let values = residual.enumerate().filter(|(i, x)| chosen(*i) && x.is_finite()).map(|(_, x)| x);
            let values: Vec<f64> = values.collect();
            (values.len(), rms(values.into_iter()))
        };
        let (samples, rms_before) = of(&mut self.series.residual());
        let rms_after = self.series.amended.as_ref().map(|_| of(&mut self.series.residual_after()).1);
        self.parts.push(RowPart { name: name.into(), samples, rms_before, rms_after });
        self
    }
}

/// By how much an error must exceed the noise to be no noise; see [`Row::unexplained_before`].
const NOISE_MARGIN: f64 = 1.05;

/// Root mean square of the finite values; 0 without any.
fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.filter(|x| x.is_finite()).fold((0.0, 0usize), |(s, n), x| (s + x * x, n + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// Values over time, all equally long (what is longer is cut). NaN leaves a gap.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Series {
    /// s, not decreasing; or numbers of postures or impacts.
    pub time: Vec<f64>,
    /// What the sensor said.
    pub measured: Vec<f64>,
    /// What the nominal model predicts.
    pub nominal: Vec<f64>,
    /// What the model with effects predicts.
    pub amended: Option<Vec<f64>>,
    /// What that model is called; empty: `with effects`.
    pub amended_name: String,
    /// What the residual is plotted against: position, velocity, acceleration, load.
    pub signals: Vec<Signal>,
}

impl Series {
    /// Adds a signal.
    pub fn with(mut self, name: &str, unit: &str, values: Vec<f64>) -> Self {
        self.signals.push(Signal { name: name.to_owned(), unit: unit.to_owned(), values });
        self
    }

    /// Samples that all of it has.
    pub fn len(&self) -> usize {
        let columns = [&self.time, &self.measured, &self.nominal].into_iter().chain(&self.amended);
        columns.chain(self.signals.iter().map(|s| &s.values)).map(Vec::len).min().unwrap_or(0)
    }

    /// Whether there is nothing to show.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What the second model is called.
    pub fn after(&self) -> &str {
        if self.amended_name.is_empty() { "with effects" } else { &self.amended_name }
    }

    /// Measured minus nominal.
    pub fn residual(&self) -> impl Iterator<Item = f64> + '_ {
        self.measured.iter().zip(&self.nominal).map(|(m, p)| m - p)
    }

    /// Measured minus amended; nothing without effects.
    pub fn residual_after(&self) -> impl Iterator<Item = f64> + '_ {
        self.measured.iter().zip(self.amended.iter().flatten()).map(|(m, p)| m - p)
    }
}

/// A quantity that the residual may depend on.
#[derive(Debug, Clone, PartialEq)]
pub struct Signal {
    /// `velocity`
    pub name: String,
    /// `rad/s`
    pub unit: String,
    /// One per sample.
    pub values: Vec<f64>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_follow_from_the_series() {
        let series = Series {
            time: vec![0.0, 1.0, 2.0, 3.0],
            measured: vec![2.0, -2.0, 2.0, f64::NAN],
            nominal: vec![1.0, -1.0, 1.0, 0.0],
            amended: Some(vec![2.0, -2.0, 2.0, 0.0]),
            ..Series::default()
        };
        let row = Row::new("knee", Channel::Effort, "N m", 0.6, series);
        assert_eq!((row.rms_before, row.rms_after), (1.0, Some(0.0)));
        assert!((row.unexplained_before - 0.5 * (1.0f64 - 0.63 * 0.63).sqrt()).abs() < 1e-15);
        assert_eq!(row.unexplained_after, Some(0.0));
        let part = &row.with_part("first half", |i| i < 2).parts[0];
        assert_eq!((part.samples, part.rms_before, part.rms_after), (2, 1.0, Some(0.0)));
    }
}
