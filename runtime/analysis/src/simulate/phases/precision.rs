//! How exactly phases are integrated, and how closely they are looked at.

/// How exactly to integrate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Precision {
    /// Error per step relative to each component.
    pub relative: f64,
    /// Error per step below which nothing is relative.
    pub absolute: f64,
    /// Largest step, s.
    pub largest_step: f64,
    /// Guards are looked at this often at least, s, and four times per step that is not a hundred times shorter.
    pub largest_look: f64,
    /// Not so often that less than this is between two looks, s: for methods whose steps are short.
    pub shortest_look: f64,
    /// Most steps in one phase.
    pub most_steps: usize,
    /// By which method.
    pub order: Order,
}

/// The method of Dormand and Prince that integrates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Order {
    /// Of order 5, with 6 evaluations per step: for motions whose accelerations have kinks, which no order steps over and which steps that
    /// are rejected find.
    Fifth,
    /// Of order 8, with 11 or 12 evaluations per step.
    #[default]
    Eighth,
}

impl Default for Precision {
    fn default() -> Self {
        Self {
            relative: 1e-12,
            absolute: 1e-12,
            largest_step: 0.02,
            largest_look: 0.01,
            shortest_look: 0.0,
            most_steps: 10_000_000,
            order: Order::Eighth,
        }
    }
}
