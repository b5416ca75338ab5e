//! The phase at which a step ends (6.1): where its guard vanishes on the constraint surface.
use super::gait::{Gait, GaitLayout, StepEnd};
use super::surface::{Constraints, Iteration};
use super::zero::first_zero;
use crate::model::{Argument, State};
use crate::real::Scalar;

/// Arguments of a gait's functions and room for an iteration.
pub(super) struct Search<'m, R> {
    /// φ₊, φ₋ and the parameters; no h_p, which has vanished at the end of a step. φ and φ₋ change.
    pub arguments: &'m mut [R],
    /// [`GaitLayout::iteration`] numbers.
    pub iteration: &'m mut [R],
}

impl<R: Scalar> Search<'_, R> {
    /// φ₋: the first phase within the guard's bounds where it vanishes.
    pub fn phase_end(&mut self, gait: &impl Gait<R>, layout: &GaitLayout) -> Option<R> {
        first_zero(layout.between.map(R::constant), |end| self.guard(gait, layout, end))
    }

    /// The guard at φ = φ₋ = `end`.
    pub fn guard(&mut self, gait: &impl Gait<R>, layout: &GaitLayout, end: R) -> Option<R> {
        for place in [0, GaitLayout::END] {
            *self.arguments.get_mut(place)? = end;
        }
        let mut value = [R::constant(0.0)];
        let state = State::new().with(Argument::Parameters, self.arguments);
        match layout.step_end {
            StepEnd::Closed(function) => gait.evaluate(function, &state, &mut value).ok()?,
            StepEnd::Iterated { constraints, jacobian, guard } => {
                let of = Constraints { residual: constraints, jacobian, held: &[] };
                let q = on_surface(gait, of, self.iteration, self.arguments)?;
                gait.evaluate(guard, &state.with(Argument::Q, q), &mut value).ok()?;
            }
        }
        Some(value[0])
    }
}

/// The configuration on the constraint surface, looked for from the gait's posture.
fn on_surface<'m, R: Scalar>(
    gait: &impl Gait<R>,
    of: Constraints<'_, R>,
    memory: &'m mut [R],
    arguments: &[R],
) -> Option<&'m [R]> {
    let n = gait.nq();
    let (q, rest) = memory.split_at_mut_checked(n)?;
    let (origin, rest) = rest.split_at_mut_checked(n)?;
    let (step, rest) = rest.split_at_mut_checked(n)?;
    let (residual, jacobian) = rest.split_at_mut_checked(n)?;
    q.iter_mut().enumerate().for_each(|(index, q)| *q = R::constant(gait.posture(index)));
    let mut iteration = Iteration { q, origin, step, residual, jacobian };
    let found = iteration.run(gait, of, arguments);
    let Iteration { q, .. } = iteration;
    found.then_some(&*q)
}
