//! How far something long is, for whoever waits for it, and whether to go on.

use std::cell::Cell;

/// Is told what is being done and how far it is. Stages may lie within one another.
pub trait Progress: Send + Sync {
    /// A stage begins, such as `deriving`. `counted`: which part of it is done will be told.
    fn begin(&self, stage: &str, counted: bool);
    /// This part of the innermost stage is done, from 0 to 1.
    fn advance(&self, part: f64);
    /// The innermost stage is over.
    fn end(&self);
}

/// Shows nothing.
#[derive(Debug, Clone, Copy, Default)]
pub struct Silent;

impl Progress for Silent {
    fn begin(&self, _stage: &str, _counted: bool) {}
    fn advance(&self, _part: f64) {}
    fn end(&self) {}
}

impl dyn Progress + '_ {
    /// Work of unknown length.
    pub fn stage<T>(&self, name: &str, work: impl FnOnce() -> T) -> T {
        self.begin(name, false);
        let result = work();
        self.end();
        result
    }

    /// Work that tells which part of it is done. Whoever waits never hears of less than before: work that has to be done
    /// again, or a search that turns out to be longer, lets the part stand where it was.
    pub fn counted<T>(&self, name: &str, work: impl FnOnce(&dyn Fn(f64)) -> T) -> T {
        self.begin(name, true);
        let most = Cell::new(0.0);
        let result = work(&|part| {
            if part > most.get() {
                most.set(part);
                self.advance(part.min(1.0));
            }
        });
        self.end();
        result
    }
}

/// Work that somebody watches and may end early.
#[derive(Clone, Copy)]
pub struct Run<'a> {
    /// Is told how far it is.
    pub progress: &'a dyn Progress,
    /// Whether to come to an end; what is done so far is kept. Asked again and again from where an early end begins to make
    /// sense.
    pub stop: &'a dyn Fn() -> bool,
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[derive(Default)]
    struct Heard(Mutex<Vec<f64>>);

    impl Progress for Heard {
        fn begin(&self, _stage: &str, _counted: bool) {}
        fn advance(&self, part: f64) {
            self.0.lock().unwrap().push(part);
        }
        fn end(&self) {}
    }

    #[test]
    fn what_is_done_never_becomes_less() {
        let heard = Heard::default();
        (&heard as &dyn Progress).counted("searching", |advance| {
            [0.0, 0.65, 0.60, f64::NAN, 0.68, 0.65, 1.2].into_iter().for_each(advance);
        });
        assert_eq!(*heard.0.lock().unwrap(), [0.65, 0.68, 1.0]);
    }
}
