//! Jobs that know nothing of each other, on all processors.
use std::sync::Mutex;
use std::thread;

/// Does each job, the first ones first. What a job finds does not depend on how many processors there are.
pub fn side_by_side<T: Send>(jobs: Vec<T>, work: impl Fn(T) + Sync) {
    let workers = thread::available_parallelism().map_or(1, usize::from).min(jobs.len());
    let jobs = Mutex::new(jobs.into_iter());
    // Nothing can panic while the lock is held: it is never poisoned.
    let next = || jobs.lock().ok().and_then(|mut jobs| jobs.next());
    let run = || {
        while let Some(job) = next() {
            work(job);
        }
    };
    thread::scope(|scope| {
        (1..workers).for_each(|_| drop(scope.spawn(run)));
        run();
    });
}
