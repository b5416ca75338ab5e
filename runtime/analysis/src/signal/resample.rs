//! From unevenly spaced samples to an even grid.

/// Evenly spaced times.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// First time, s.
    pub start: f64,
    /// s
    pub step: f64,
    /// Number of times.
    pub count: usize,
}

impl Grid {
    /// The grid of times `origin + k · step` that lie between `first` and `last`.
    ///
    /// All blocks of a stretch share the origin and hence the grid.
    pub fn covering(origin: f64, step: f64, first: f64, last: f64) -> Self {
        // A hair of slack keeps the first and last sample on the grid in spite of rounding.
        let from = ((first - origin) / step - 1e-6).ceil();
        let to = ((last - origin) / step + 1e-6).floor();
        Self { start: origin + from * step, step, count: (to - from + 1.0).max(0.0) as usize }
    }
    /// The `index`-th time, s.
    pub fn time(&self, index: usize) -> f64 {
        self.start + index as f64 * self.step
    }
}

/// Values at the times of a grid, by the cubic through the four nearest samples.
///
/// `time` increases and has at least four entries (else the result is empty), `values` is as long.
pub fn resample(time: &[f64], values: &[f64], grid: Grid) -> Vec<f64> {
    if time.len() < 4 || values.len() != time.len() {
        return Vec::new();
    }
    let mut right = 0;
    (0..grid.count)
        .map(|i| {
            let t = grid.time(i);
            while right < time.len() && time[right] < t {
                right += 1;
            }
            let from = right.saturating_sub(2).min(time.len() - 4);
            lagrange(&time[from..from + 4], &values[from..from + 4], t)
        })
        .collect()
}

fn lagrange(time: &[f64], values: &[f64], t: f64) -> f64 {
    let mut sum = 0.0;
    for (i, value) in values.iter().enumerate() {
        let others = time.iter().enumerate().filter(|(j, _)| *j != i);
        sum += value * others.map(|(_, tj)| (t - tj) / (time[i] - tj)).product::<f64>();
    }
    sum
}
