//! Rows of a log that stay in memory, so that the file is not read again for them.
use super::in_time::Repairs;
use super::wraps::Unwrapped;
use std::sync::{Arc, Mutex, PoisonError};

/// Most numbers that are kept of a log: 32 MiB. Longer logs are read from the file every time.
const LARGEST: usize = 1 << 22;

/// All rows of a log for one selection of columns.
#[derive(Debug, Default)]
pub(super) struct Kept {
    /// As in [`super::Reader`].
    selected: Vec<usize>,
    /// The line of each row in the file.
    lines: Vec<usize>,
    /// Row after row; NaN where a field was empty.
    values: Vec<f64>,
    /// What was put right in their times.
    pub repairs: Repairs,
    /// And in their angles.
    pub unwrapped: Vec<Unwrapped>,
}

impl Kept {
    /// Nothing yet of these columns.
    pub fn of(selected: &[usize]) -> Self {
        Self { selected: selected.to_vec(), ..Self::default() }
    }

    /// Takes a row as long as the selection; false if the log is too long to be kept.
    pub fn take(&mut self, line: usize, row: &[f64]) -> bool {
        self.lines.push(line);
        self.values.extend_from_slice(row);
        self.lines.len() + self.values.len() <= LARGEST
    }

    /// Line and numbers of a row, counted from 0.
    pub fn row(&self, index: usize) -> Option<(usize, &[f64])> {
        let width = self.selected.len();
        Some((*self.lines.get(index)?, self.values.get(index * width..(index + 1) * width)?))
    }
}

/// What the last reader that came to the end of the log left; all clones of a log share it.
#[derive(Debug, Clone, Default)]
pub(super) struct Shelf(Arc<Mutex<Option<Arc<Kept>>>>);

impl Shelf {
    /// All rows of these columns.
    pub fn get(&self, selected: &[usize]) -> Option<Arc<Kept>> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.as_ref().filter(|kept| kept.selected == selected).map(Arc::clone)
    }

    /// In the place of other columns: what was read last is asked for next.
    pub fn put(&self, kept: Kept) {
        *self.0.lock().unwrap_or_else(PoisonError::into_inner) = Some(Arc::new(kept));
    }
}
