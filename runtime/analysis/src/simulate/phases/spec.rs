//! A phase of a description and how it ends.
use super::support::Row;

/// When a phase is over.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Ending {
    /// One of these contact points (indices of the model's) reaches the ground.
    Touch(Vec<usize>),
    /// The ground no longer pushes on this foot.
    Release(usize),
    /// The centre of pressure of this foot reaches these of its points: it begins to tip about them.
    Tip(usize, Vec<usize>),
    /// Nothing ends it.
    Never,
}

/// Of a configuration: positive until a foot is taken to land.
pub type LandingGuard<'a> = dyn Fn(&[f64]) -> f64 + 'a;

/// One phase, its functions by name.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseSpec {
    /// As in the description.
    pub name: String,
    /// `constrained_dynamics_of_…`
    pub dynamics: String,
    /// Its rows after the accelerations.
    pub rows: Vec<Row>,
    /// Contact points that stand.
    pub standing: Vec<usize>,
    /// When it ends.
    pub ending: Ending,
    /// None: velocities do not jump.
    pub impact: Option<Landing>,
    /// Left and right exchange their roles.
    pub relabel: bool,
    /// Index of the phase that follows.
    pub next: usize,
}

/// The impact at the end of a phase.
#[derive(Debug, Clone, PartialEq)]
pub struct Landing {
    /// `impact_map_of_…`
    pub map: String,
    /// Its rows after the velocities.
    pub rows: Vec<Row>,
    /// Contact points that hold just after it.
    pub standing: Vec<usize>,
}
