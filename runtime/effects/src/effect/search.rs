//! How a search for causes tries a kind: columns that enter linearly, and the parameters that follow from their
//! coefficients.
use super::kind::Kind;
use std::fmt;

/// Parameters by name.
pub type Parameters = Vec<(&'static str, f64)>;

/// A sum of responses: factor and the parameters to respond with.
pub type Probe = Vec<(f64, Parameters)>;

/// What a log shows, each by an experiment of its own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Evidence {
    /// Motion of the joints with their torques, or with the angles of their motors.
    Motion,
    /// Walking, with the forces of the ground.
    Contact,
    /// Postures at rest on the ground.
    Postures,
    /// Impacts.
    Impacts,
}

/// How a search tries a kind.
pub struct Search {
    /// Where it is looked for.
    pub sought: &'static [Evidence],
    /// The parameter that does not enter linearly.
    pub nonlinear: Option<&'static str>,
    /// Its values, from which the search starts.
    pub starts: Starts,
    /// What enters linearly.
    pub columns: Columns,
    /// Why coefficients that are within the bounds cannot be meant; with the value of the parameter that does not enter
    /// linearly.
    pub refused: fn(f64, &[f64]) -> Option<String>,
}

/// Values of the parameter that does not enter linearly.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Starts {
    /// All parameters enter linearly.
    None,
    /// These.
    At(&'static [f64]),
    /// Levels that the signal seldom exceeds, and at which it stays; zero where no log tells.
    Limits,
    /// Periods with which the residual repeats with the angle; zero where no log tells.
    Periods,
    /// For a joint's neighbours, which may share a bearing with it, these; for others zero.
    Neighbours(&'static [f64]),
}

/// What enters linearly.
#[derive(Clone, Copy)]
pub enum Columns {
    /// It is not searched for.
    None,
    /// The parameters themselves, each probed at 1.
    Parameters,
    /// The parameters themselves, each probed by so small a step: what responds is linear near zero alone.
    Slopes(f64),
    /// The parameters themselves, as changes of inertial parameters: where these are columns.
    Inertial,
    /// Other combinations.
    Combined {
        /// Of the parameter that does not enter linearly.
        probes: fn(f64) -> Vec<Probe>,
        /// Of the parameter that does not enter linearly, and the coefficients.
        parameters: fn(f64, &[f64]) -> Parameters,
    },
}

impl Search {
    /// By its parameters, which all enter linearly.
    pub const fn linear(sought: &'static [Evidence]) -> Self {
        Self {
            sought,
            nonlinear: None,
            starts: Starts::None,
            columns: Columns::Parameters,
            refused: |_, _| None,
        }
    }

    /// By small steps of its parameters.
    pub const fn slopes(sought: &'static [Evidence], step: f64) -> Self {
        Self {
            sought,
            nonlinear: None,
            starts: Starts::None,
            columns: Columns::Slopes(step),
            refused: |_, _| None,
        }
    }

    /// Not at all.
    pub const fn none() -> Self {
        Self {
            sought: &[],
            nonlinear: None,
            starts: Starts::None,
            columns: Columns::None,
            refused: |_, _| None,
        }
    }
}

impl fmt::Debug for Search {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Search")
            .field("sought", &self.sought)
            .field("starts", &self.starts)
            .finish_non_exhaustive()
    }
}

/// A response at a parameter's value of 1.
pub(super) fn unit(name: &'static str) -> Probe {
    vec![(1.0, vec![(name, 1.0)])]
}

/// A small step, scaled up: the slope at zero.
pub(super) fn slope(name: &'static str, step: f64) -> Probe {
    vec![(1.0 / step, vec![(name, step)])]
}

impl Kind {
    /// What enters linearly, with the parameter that does not at `start`; `None` if responses do not tell.
    pub fn probes(&self, start: f64) -> Option<Vec<Probe>> {
        match self.search.columns {
            Columns::None | Columns::Inertial => None,
            Columns::Parameters => Some(self.estimated().map(|p| unit(p.name)).collect()),
            Columns::Slopes(step) => Some(self.estimated().map(|p| slope(p.name, step)).collect()),
            Columns::Combined { probes, .. } => Some(probes(start)),
        }
    }

    /// Parameters from the coefficients of the [`Kind::probes`]; with fewer coefficients those that they tell.
    pub fn from_coefficients(&self, start: f64, coefficients: &[f64]) -> Parameters {
        match self.search.columns {
            Columns::None => Vec::new(),
            Columns::Parameters | Columns::Slopes(_) | Columns::Inertial => {
                self.estimated().map(|p| p.name).zip(coefficients.iter().copied()).collect()
            }
            Columns::Combined { parameters, .. } => parameters(start, coefficients),
        }
    }

    /// Values from which a search starts, where no log tells better.
    pub fn starts(&self) -> &'static [f64] {
        match self.search.starts {
            Starts::At(values) => values,
            _ => &[0.0],
        }
    }
}
