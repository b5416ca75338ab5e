//! How far something long is, for whoever waits for it, and whether to go on.

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

    /// Work that tells which part of it is done.
    pub fn counted<T>(&self, name: &str, work: impl FnOnce(&dyn Fn(f64)) -> T) -> T {
        self.begin(name, true);
        let result = work(&|part| self.advance(part));
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
