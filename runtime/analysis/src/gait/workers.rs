//! Work that falls into many parts, on all processors.
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

/// How often the question for an end is asked while nothing else happens.
const PAUSE: Duration = Duration::from_millis(50);

/// Who waits for it.
pub struct Watch<'a> {
    /// Is told which part is done, from 0 to 1.
    pub advance: &'a dyn Fn(f64),
    /// Whether to come to an end.
    pub stop: &'a dyn Fn() -> bool,
}

/// Results of `work(job)` for jobs from 0 to `count`, each with its job, in no order. After the question for an end is answered
/// with yes no job begins.
pub fn in_parallel<T: Send>(
    count: usize,
    watch: &Watch<'_>,
    work: impl Fn(usize) -> T + Sync,
) -> Vec<(usize, T)> {
    let (next, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    let workers = thread::available_parallelism().map_or(1, usize::from).min(count);
    let mut found = Vec::with_capacity(count);
    thread::scope(|scope| {
        let (sender, receiver) = channel();
        for _ in 0..workers {
            let (sender, next, stop, work) = (sender.clone(), &next, &stop, &work);
            scope.spawn(move || {
                while !stop.load(Ordering::Relaxed) {
                    let job = next.fetch_add(1, Ordering::Relaxed);
                    // Nobody listens any more only if the other side ended early.
                    if job >= count || sender.send((job, work(job))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(sender);
        loop {
            match receiver.recv_timeout(PAUSE) {
                Ok(result) => {
                    found.push(result);
                    (watch.advance)(found.len() as f64 / count as f64);
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => break,
            }
            if (watch.stop)() {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
    found
}
