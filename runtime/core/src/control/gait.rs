//! A gait as its controller knows it.
use crate::model::Model;

/// A parameter that is chosen for each step.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaitParameter<'a> {
    /// As the gait file calls it.
    pub name: &'a str,
    /// SI unit.
    pub unit: &'a str,
    /// Where nothing else is asked for.
    pub default: f64,
    /// Smallest and largest value that is meant.
    pub bounds: [f64; 2],
}

/// How a controller finds the phase at which a step ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum StepEnd {
    /// By function `step_end`: the guard on the constraint surface at φ = φ₋.
    Closed(usize),
    /// The surface has no closed form: by iteration, with these functions.
    Iterated {
        /// `virtual_constraints`: what vanishes on the surface.
        constraints: usize,
        /// `virtual_constraints_jacobian`.
        jacobian: usize,
        /// `guard`
        guard: usize,
    },
}

/// Sizes of a gait, and places of its functions in its model.
///
/// The functions take the arguments of a gait in [`crate::Argument::Parameters`]: φ, φ₊, φ₋, the gait parameters, then of each
/// output the value and the slope of h_p at φ₊.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaitLayout {
    /// Number of gait parameters.
    pub parameters: usize,
    /// Number of outputs, and of joints: all of them have actuators.
    pub outputs: usize,
    /// Function `controlled`: φ and h₀ with their rates.
    pub controlled: usize,
    /// Function `wanted`: h_d with its slopes along φ.
    pub wanted: usize,
    /// Function `lie_derivatives`: h, L_f h, L_f² h, then L_g L_f h.
    pub lie_derivatives: usize,
    /// How a step's end is found.
    pub step_end: StepEnd,
    /// φ at which the guard is looked for, smallest and largest.
    pub between: [f64; 2],
    /// Whether h_p takes up what an impact leaves of the outputs and their rates.
    pub impact_matching: bool,
}

impl GaitLayout {
    /// Place of φ₊ in the arguments.
    pub const START: usize = 1;
    /// Place of φ₋.
    pub const END: usize = 2;
    /// Place of the first gait parameter.
    pub const PARAMETERS: usize = 3;

    /// How many arguments the gait's functions take.
    pub const fn arguments(&self) -> usize {
        Self::PARAMETERS + self.parameters + 2 * self.outputs
    }

    /// Length of q: joints, and a base in the plane.
    pub const fn configuration(&self) -> usize {
        self.outputs + 3
    }

    /// Numbers that an iteration for the constraint surface keeps.
    pub(super) const fn iteration(&self) -> usize {
        match self.step_end {
            StepEnd::Closed(_) => 0,
            StepEnd::Iterated { .. } => self.configuration() * (4 + self.configuration()),
        }
    }

    /// Numbers that a controller keeps: two sets of arguments, the parameters of the next step, its functions' results, and what an
    /// iteration needs.
    pub const fn memory(&self) -> usize {
        let results = 2 * (1 + self.outputs) + 2 * self.outputs + self.outputs * (3 + self.outputs);
        2 * self.arguments() + self.parameters + results + self.outputs + self.iteration()
    }
}

/// A robot with a gait: generated code, or programs in process.
///
/// The robot is named as the gait's phase does: the leg that stands first, whichever it is.
pub trait Gait<R>: Model<R> {
    /// Room for numbers: an array in generated code, a vector in process.
    type Memory: AsRef<[R]> + AsMut<[R]>;

    /// [`GaitLayout::memory`] zeros.
    fn memory(&self) -> Self::Memory;

    /// Sizes and places.
    fn layout(&self) -> GaitLayout;

    /// A gait parameter, `None` beyond the last.
    fn parameter(&self, index: usize) -> Option<GaitParameter<'_>>;

    /// Where an iteration for the constraint surface begins: an element of q.
    fn posture(&self, index: usize) -> f64;

    /// The largest torque of a joint, in the order of `v` (N m; N of a prismatic one), if the description says one.
    fn effort_limit(&self, joint: usize) -> Option<f64>;
}
