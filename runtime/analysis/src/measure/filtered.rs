//! A log cut into blocks for a filter: its sampling step, the cut-off, how far blocks overlap, which samples count.
use crate::log::{Blocks, Kind, Log, Reader, Sampling};
use crate::measure::Options;
use crate::measure::trajectory::Unusable;
use crate::signal::{Butterworth, FilterError, Spline};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::path::Path;

/// Samples that the spline needs beyond the filter's overlap: 0.43⁴⁰ is 2e-15.
pub(crate) const SPLINE_OVERLAP: usize = 40;
/// Cut-off if none is given, Hz.
pub const CUTOFF_HZ: f64 = 10.0;
/// The highest cut-off, as part of the sampling rate.
const HIGHEST: f64 = 0.45;

/// Blocks of a log, and the filter that they are cut for.
pub(crate) struct Filtered {
    /// Median sampling step, s.
    pub step: f64,
    /// Hz
    pub cutoff_hz: f64,
    pub filter: Butterworth,
    pub blocks: Blocks,
}

impl Filtered {
    /// Looks at the first rows of a reader whose columns were selected. The filter works on every `parts`-th sample, and what
    /// it makes passes it again up to `passes` times.
    ///
    /// # Errors
    /// As [`Sampling::probe`]; a cut-off that does not fit the sampling rate.
    pub fn new(
        reader: Reader,
        options: &Options,
        (parts, passes): (usize, usize),
    ) -> Result<Self, Diagnostics> {
        let file = reader.file().to_path_buf();
        let sampling = Sampling::probe(reader)?;
        let step = sampling.step();
        let own = step * parts as f64;
        let cutoff_hz = options.cutoff_hz.unwrap_or(CUTOFF_HZ).min(HIGHEST / own);
        let filter = Butterworth::new(cutoff_hz, 1.0 / own)
            .map_err(|error| no_filter(&[cutoff_hz], &reason(error, 1.0 / own)).in_file(&file))?;
        let blocks = cut(sampling, passes * filter.overlap(), parts, options);
        Ok(Self { step, cutoff_hz, filter, blocks })
    }
}

/// Refuses a cut-off that was asked for where a log's sampling has no such filter: reading takes the nearest that fits, as is right for one
/// that nobody chose. Tables are not filtered.
///
/// # Errors
/// Such a cut-off; those of [`Sampling::probe`].
pub fn has_filter(log: &Log, options: &Options) -> Result<(), Diagnostics> {
    let Some(cutoff_hz) = options.cutoff_hz.filter(|_| log.kind() == Kind::Time) else { return Ok(()) };
    let rate = 1.0 / Sampling::probe(log.rows())?.step();
    let refused = |error| no_filter(&[cutoff_hz], &reason(error, rate)).in_file(log.path());
    Ok(Butterworth::new(cutoff_hz, rate).map(|_| ()).map_err(refused)?)
}

/// Said of cut-offs that no filter can have, all for one reason.
pub(crate) fn no_filter(cutoffs: &[f64], reason: &str) -> Diagnostic {
    Diagnostic::error(format!("the cut-off of {} is {reason}", in_hertz(cutoffs)))
        .help("choose a cut-off between the robot's motion and half the sampling rate")
}

/// Cut-offs in words.
pub(crate) fn in_hertz(cutoffs: &[f64]) -> String {
    cutoffs.iter().map(|cutoff| format!("{cutoff} Hz")).collect::<Vec<_>>().join(", ")
}

/// Why a filter is none at a sampling rate, Hz.
pub(crate) fn reason(error: FilterError, rate: f64) -> String {
    // With digits that say something, however slow.
    let rate = if rate < 1e-3 { format!("{rate:.3e}") } else { format!("{rate:.6}") };
    match error {
        FilterError::OutOfRange => format!("not below half the sampling rate of {rate} Hz by a fiftieth"),
        FilterError::TooLow => format!("less than a ten-thousandth of the sampling rate of {rate} Hz"),
    }
}

/// Blocks for filters that work on every `parts`-th sample and need up to `overlap` of these on either side.
pub(crate) fn cut(sampling: Sampling, overlap: usize, parts: usize, options: &Options) -> Blocks {
    let overlap = parts * (overlap + SPLINE_OVERLAP);
    Blocks::new(sampling, overlap, options.trim_s).between(options.from_s, options.to_s)
}

/// Parts of a white noise's variance that value, first and second derivative of a signal have that was filtered so often.
pub(crate) fn noise_gains(filter: &Butterworth, step: f64, passes: usize) -> [f64; 3] {
    let half = filter.overlap() + SPLINE_OVERLAP;
    let impulse: Vec<f64> = (0..2 * half + 1).map(|i| if i == half { 1.0 } else { 0.0 }).collect();
    let filtered = (0..passes).fold(impulse, |signal, _| filter.zero_phase(&signal));
    let Some(spline) = Spline::new(&filtered, step) else { return [1.0, 0.0, 0.0] };
    let squares = (0..filtered.len()).map(|i| spline.at_sample(i).map(|x| x * x));
    squares.fold([0.0; 3], |sum, more| std::array::from_fn(|k| sum[k] + more[k]))
}

/// The second derivative of what a filter makes of one sample's error, sample after sample; per s².
pub(crate) fn acceleration_response(filter: &Butterworth, step: f64) -> Vec<f64> {
    let half = filter.overlap() + SPLINE_OVERLAP;
    let impulse: Vec<f64> = (0..2 * half + 1).map(|i| if i == half { 1.0 } else { 0.0 }).collect();
    let spline = Spline::new(&filter.zero_phase(&impulse), step);
    spline.map(|s| (0..impulse.len()).map(|i| s.at_sample(i)[2]).collect()).unwrap_or_default()
}

/// Why a block gave no states, in words.
pub(crate) fn unusable(reason: Unusable, file: &Path) -> Diagnostics {
    let error = match reason {
        Unusable::TooFew => Diagnostic::error("a stretch of the log has fewer than 8 samples")
            .help("leave out more at the ends, or record longer"),
        Unusable::ZeroQuaternion(time) => {
            Diagnostic::error(format!("base/orientation is no rotation at {time} s: its quaternion is zero"))
                .help("a unit quaternion x, y, z, w is expected")
        }
    };
    error.in_file(file).into()
}
