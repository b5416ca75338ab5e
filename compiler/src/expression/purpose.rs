//! What expressions are for, so that the code written from them can say so.
use super::Graph;

/// The body and the quantity that a piece of work is about; nothing where nobody said.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Purpose {
    /// Index of the body in the tree; `None` where it is about all of the robot.
    pub body: Option<usize>,
    /// Such as `wrench`; empty where nobody said.
    pub quantity: &'static str,
}

/// As long as it lives, new nodes of the graph are for its purpose.
#[must_use = "a purpose lasts as long as its guard"]
pub struct Work<'g> {
    graph: &'g Graph,
    before: Purpose,
}

impl Graph {
    /// What follows is for this. An expression that exists already keeps its first purpose.
    pub fn work(&self, purpose: Purpose) -> Work<'_> {
        Work { graph: self, before: self.purpose.replace(purpose) }
    }
}

impl Drop for Work<'_> {
    fn drop(&mut self) {
        self.graph.purpose.set(self.before);
    }
}
