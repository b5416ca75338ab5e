//! Smooth nonlinear programs, large and sparse: an interior point method with exact second derivatives.
//!
//! minimise f(x) with l ≤ c(x) ≤ u and x within bounds. The method is that of Wächter and Biegler (2006): logarithmic barriers, a filter
//! in place of a merit function, second-order corrections, inertia made right by regularisation. Where only tiny steps are acceptable, full ones are taken for a while (a watchdog). Where none is,
//! the constraints alone are made smaller by damped Gauss–Newton steps; where even that ends, the program is infeasible as far as this method
//! can see, and [`Solution::violations`] says which constraints are.
mod dense;
mod factor;
mod filter;
mod interior_point;
mod iterate;
mod kkt;
mod line_search;
mod restoration;
mod scaling;
mod side_by_side;
mod stack;
mod symbolic;
#[cfg(test)]
mod tests;
mod tiles;

pub use interior_point::InteriorPoint;
pub use side_by_side::side_by_side;

/// What is to be minimised. Rows and columns are counted from 0; structures may name an element twice: its values add up.
pub trait Program {
    /// Smallest and largest value of each variable, −∞ and ∞ where there is none; smallest below largest.
    fn bounds(&self) -> Vec<[f64; 2]>;
    /// Smallest and largest value of each constraint; equal ones make an equation.
    fn limits(&self) -> Vec<[f64; 2]>;
    /// f.
    fn objective(&self, x: &[f64]) -> f64;
    /// ∇f.
    fn gradient(&self, x: &[f64], gradient: &mut [f64]);
    /// c.
    fn constraints(&self, x: &[f64], values: &mut [f64]);
    /// Row and column of each element of ∂c/∂x.
    fn jacobian_structure(&self) -> Vec<[usize; 2]>;
    /// ∂c/∂x, in the order of its structure.
    fn jacobian(&self, x: &[f64], values: &mut [f64]);
    /// Row and column of each element of the Lagrangian's second derivatives; one of two that mirror each other.
    fn hessian_structure(&self) -> Vec<[usize; 2]>;
    /// `weight` ∇²f + Σ multiplierᵢ ∇²cᵢ, in the order of its structure.
    fn hessian(&self, x: &[f64], weight: f64, multipliers: &[f64], values: &mut [f64]);
}

/// What minimises a [`Program`].
pub trait Minimiser {
    /// From a first guess; `watch` is told after every iteration and may end the search by `false`.
    fn minimise(
        &self,
        program: &dyn Program,
        start: &Start<'_>,
        watch: &mut dyn FnMut(&Iteration) -> bool,
    ) -> Solution;
}

/// Where a search begins.
#[derive(Debug, Clone, Copy)]
pub struct Start<'a> {
    /// Variables.
    pub x: &'a [f64],
    /// Of a neighbouring program that was solved before: its variables take the place of `x`.
    pub central: Option<&'a Central>,
}

/// A place on the central path of a program: with this barrier, the minimum.
///
/// A neighbour is begun from such a place and not from the minimum itself: there what is at its limit is as good as on it, and the least step that the neighbour
/// asks for ends there.
#[derive(Debug, Clone, PartialEq)]
pub struct Central {
    /// The barrier's parameter.
    pub barrier: f64,
    /// Variables.
    pub x: Vec<f64>,
    /// Multipliers of the constraints.
    pub multipliers: Vec<f64>,
}

/// How far a search is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Iteration {
    /// Counted from 1.
    pub number: usize,
    /// f.
    pub objective: f64,
    /// Largest violation of a constraint, in its own unit.
    pub violation: f64,
    /// Largest element of the Lagrangian's gradient, scaled.
    pub stationarity: f64,
    /// The barrier's parameter.
    pub barrier: f64,
    /// Whether constraints alone are made smaller.
    pub restoring: bool,
    /// Length of the step, up to 1.
    pub step: f64,
    /// What was added to the Hessian's diagonal.
    pub regularisation: f64,
}

/// How a search ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// All conditions of a minimum hold within the tolerance.
    Minimum,
    /// All constraints hold; the search ended before those of a minimum did.
    Feasible,
    /// Constraints contradict each other near the last place, or no step makes them smaller.
    Infeasible,
    /// As many iterations as were allowed.
    Iterations,
    /// Stopped from outside.
    Stopped,
}

/// What a search found.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// How it ended.
    pub ending: Ending,
    /// Variables.
    pub x: Vec<f64>,
    /// Multipliers of the constraints.
    pub multipliers: Vec<f64>,
    /// The last place on the central path with no smaller barrier than that of [`InteriorPoint::central`], if the search came by one.
    pub central: Option<Central>,
    /// f.
    pub objective: f64,
    /// Iterations.
    pub iterations: usize,
    /// Constraints that do not hold within the tolerance, the worst first: index and by how much (signed: negative, below its limit).
    pub violations: Vec<(usize, f64)>,
}
