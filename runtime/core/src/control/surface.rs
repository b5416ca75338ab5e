//! The constraint surface q = T(φ) where it has no closed form (6.5), by Newton's method with bounded work.
use super::elimination::solve;
use super::slices::copy;
use crate::model::{Argument, Model, State};
use crate::real::Scalar;

/// Steps of the iteration, and halvings of one of them.
const ITERATIONS: usize = 40;
const HALVINGS: usize = 10;
/// Residuals below so many roundings (m, rad) are those of a solution.
const ROUNDINGS: f64 = 1e3;

/// What vanishes and its slopes, such as `virtual_constraints` and `virtual_constraints_jacobian`.
#[derive(Clone, Copy)]
pub(super) struct Constraints<'h, R> {
    pub residual: usize,
    pub jacobian: usize,
    /// What the first rows are to be instead of zero.
    pub held: &'h [R],
}

/// Room for an iteration: q, where a step began, the step, residuals, and their slopes column after column.
pub(super) struct Iteration<'m, R> {
    pub q: &'m mut [R],
    pub origin: &'m mut [R],
    pub step: &'m mut [R],
    pub residual: &'m mut [R],
    pub jacobian: &'m mut [R],
}

impl<R: Scalar> Iteration<'_, R> {
    /// Moves q to where the constraints with these arguments vanish, starting where it is; `false`: there is no such place nearby.
    pub(super) fn run(&mut self, gait: &impl Model<R>, of: Constraints<'_, R>, arguments: &[R]) -> bool {
        let solved = R::constant(ROUNDINGS * R::EPSILON);
        let Some(mut size) = self.residual_at_q(gait, of, arguments) else { return false };
        for _ in 0..ITERATIONS {
            let state = State::new().with(Argument::Q, self.q).with(Argument::Parameters, arguments);
            if gait.evaluate(of.jacobian, &state, self.jacobian).is_err()
                || !solve(self.jacobian, self.residual)
            {
                return size <= solved;
            }
            match self.descend(gait, (of, arguments), size) {
                Some(smaller) => size = smaller,
                // As good as it gets.
                None => return size <= solved,
            }
        }
        size <= solved
    }

    /// q less the step that stands in `residual`, or a part of it, so that the residual becomes smaller: its size then.
    fn descend(
        &mut self,
        gait: &impl Model<R>,
        (of, arguments): (Constraints<'_, R>, &[R]),
        size: R,
    ) -> Option<R> {
        copy(self.residual, self.step);
        copy(self.q, self.origin);
        let mut part = R::constant(1.0);
        for _ in 0..HALVINGS {
            for ((q, origin), step) in self.q.iter_mut().zip(self.origin.iter()).zip(self.step.iter()) {
                *q = *origin - part * *step;
            }
            if let Some(found) = self.residual_at_q(gait, of, arguments).filter(|found| *found < size) {
                return Some(found);
            }
            part = part * R::constant(0.5);
        }
        copy(self.origin, self.q);
        None
    }

    /// The largest residual at q; `None`: it is no number.
    fn residual_at_q(&mut self, gait: &impl Model<R>, of: Constraints<'_, R>, arguments: &[R]) -> Option<R> {
        let state = State::new().with(Argument::Q, self.q).with(Argument::Parameters, arguments);
        gait.evaluate(of.residual, &state, self.residual).ok()?;
        self.residual.iter_mut().zip(of.held).for_each(|(x, held)| *x = *x - *held);
        let finite = self.residual.iter().all(|x| x.is_finite());
        let largest = self.residual.iter().fold(R::constant(0.0), |m, x| m.larger(x.abs()));
        finite.then_some(largest)
    }
}
