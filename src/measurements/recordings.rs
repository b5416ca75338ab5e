//! Logs behind filters that were asked for before: a diagnosis comes back to some cut-offs.
use bipedc_analysis::log::Log;
use bipedc_analysis::measure::{Held, Options, Recording};
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// At most so many numbers are kept (64 MB).
const ROOM: usize = 1 << 23;

/// What was read last, oldest first.
#[derive(Default)]
pub(super) struct Recordings(Mutex<VecDeque<Kept>>);

struct Kept {
    log: Log,
    options: Options,
    held: Arc<Held>,
}

impl Recordings {
    /// The log as these options read it, if it is still there.
    pub fn get(&self, log: &Log, options: &Options) -> Option<Arc<Held>> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let is_it = |kept: &&Kept| kept.log.is_same(log) && kept.options == *options;
        kept.iter().find(is_it).map(|kept| Arc::clone(&kept.held))
    }

    /// Some samples of what was read, which is kept if it is not too long; less is kept of what is old.
    pub fn thinned(&self, log: &Log, options: &Options, held: Held, most: usize) -> Recording {
        if held.numbers() > ROOM {
            return held.into_thinned(most);
        }
        let recording = held.thinned(most);
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        all.push_back(Kept { log: log.clone(), options: options.clone(), held: Arc::new(held) });
        while all.iter().map(|kept| kept.held.numbers()).sum::<usize>() > ROOM {
            all.pop_front();
        }
        recording
    }
}
