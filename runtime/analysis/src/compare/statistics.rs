//! Sums from which root mean squares are formed.

/// Errors of one channel under one cut-off.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(super) struct Sums {
    pub samples: usize,
    pub error_squares: f64,
    pub max_error: f64,
    pub logged_squares: f64,
}

impl Sums {
    pub fn add(&mut self, logged: f64, predicted: f64) {
        let error = logged - predicted;
        self.samples += 1;
        self.error_squares += error * error;
        // NaN must not vanish in a maximum.
        if error.is_nan() || error.abs() > self.max_error {
            self.max_error = error.abs();
        }
        self.logged_squares += logged * logged;
    }

    pub fn merged(mut self, other: &Self) -> Self {
        self.samples += other.samples;
        self.error_squares += other.error_squares;
        self.max_error = self.max_error.max(other.max_error);
        self.logged_squares += other.logged_squares;
        self
    }

    /// Root mean square of the error; 0 without samples.
    pub fn rms(&self) -> f64 {
        (self.error_squares / self.samples.max(1) as f64).sqrt()
    }

    /// Root mean square of what was logged; 0 without samples.
    pub fn logged_rms(&self) -> f64 {
        (self.logged_squares / self.samples.max(1) as f64).sqrt()
    }

    /// rms of the error / rms of what was logged; `None` if nothing but zeros was logged.
    pub fn relative(&self) -> Option<f64> {
        (self.logged_squares > 0.0).then(|| (self.error_squares / self.logged_squares).sqrt())
    }
}

/// Geometric mean of errors but those that are 0 (a joint that nothing moves must not outweigh all others) or not finite; 0 without any.
pub fn geometric_mean(errors: impl Iterator<Item = f64>) -> f64 {
    let logarithms = errors.map(f64::ln).filter(|ln| ln.is_finite());
    let (sum, count) = logarithms.fold((0.0, 0.0_f64), |(sum, n), ln| (sum + ln, n + 1.0));
    if count > 0.0 { (sum / count).exp() } else { 0.0 }
}
