//! Progress on the error stream, while something long runs.
use bipedc::progress::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::{self, IsTerminal};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// Bars and spinners; invisible unless the error stream is a terminal.
#[derive(Default)]
pub struct Bars(Mutex<Vec<ProgressBar>>);

impl Bars {
    /// The innermost stage stands last.
    fn open(&self) -> MutexGuard<'_, Vec<ProgressBar>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Progress for Bars {
    fn begin(&self, stage: &str, counted: bool) {
        if !io::stderr().is_terminal() {
            return;
        }
        let bar = if counted { ProgressBar::new(1000) } else { ProgressBar::new_spinner() };
        let bar = bar.with_message(stage.to_owned());
        let style = "{msg} [{bar:40}] {percent} % {elapsed}";
        match ProgressStyle::with_template(style) {
            Ok(style) if counted => bar.set_style(style),
            _ => bar.enable_steady_tick(Duration::from_millis(100)),
        }
        self.open().push(bar);
    }

    fn advance(&self, part: f64) {
        if let Some(bar) = self.open().last() {
            bar.set_position((1000.0 * part) as u64);
        }
    }

    fn end(&self) {
        if let Some(bar) = self.open().pop() {
            bar.finish_and_clear();
        }
    }
}

/// A spinner while something runs that knows of no [`Progress`].
pub fn spin<T>(stage: &str, work: impl FnOnce() -> T) -> T {
    let bars: &dyn Progress = &Bars::default();
    bars.stage(stage, work)
}
