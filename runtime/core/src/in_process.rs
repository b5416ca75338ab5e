//! Walking of robots whose model stands behind a pointer, compiled with this crate: as far optimised as it is, whatever the caller's crate is.
use crate::control::{Controller, JointCommand, Observation, Refusal};
use crate::model::Model;
use crate::walking::estimator::Sensed;
use crate::walking::{OnBoardWalker, Stepped, WalkingController};

/// A model of which only its functions are known.
pub type AnyModel<'m> = &'m dyn Model<f64>;

/// [`WalkingController::command`](Controller::command).
///
/// # Errors
/// As there.
pub fn command<'m>(
    controller: &mut WalkingController<AnyModel<'m>, f64>,
    observed: &Observation<'_, f64>,
    commands: &mut [JointCommand<f64>],
) -> Result<(), Refusal> {
    controller.command(observed, commands)
}

/// [`OnBoardWalker::step`].
pub fn step<'m>(
    walker: &mut OnBoardWalker<AnyModel<'m>, f64>,
    sensed: &Sensed<'_, f64>,
    commands: &mut [JointCommand<f64>],
) -> Stepped<f64> {
    walker.step(sensed, commands)
}
