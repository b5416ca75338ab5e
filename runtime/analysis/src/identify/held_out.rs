//! Errors on data that did not teach.

/// Error of a channel on data that were not used, and what there was to explain.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct HeldOutError {
    /// Sum of squared errors.
    pub squares: f64,
    /// Sum of squares of what was measured.
    pub measured: f64,
    /// Rows.
    pub rows: usize,
}

impl HeldOutError {
    /// Root mean square.
    pub fn rms(&self) -> f64 {
        (self.squares / self.rows.max(1) as f64).sqrt()
    }
    /// |error| / |measured|; 0 without a measurement.
    pub fn relative(&self) -> f64 {
        if self.measured == 0.0 { 0.0 } else { (self.squares / self.measured).sqrt() }
    }
    /// Both together.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            squares: self.squares + other.squares,
            measured: self.measured + other.measured,
            rows: self.rows + other.rows,
        }
    }
}
