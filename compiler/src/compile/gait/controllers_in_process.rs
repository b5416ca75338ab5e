//! Controllers of gaits in process, compiled with this crate: what callers link is as far optimised as it is, whatever their own crate is.
use super::{GaitPrograms, PhasePrograms};
use bipedc_runtime::control::{
    Controller, GaitController, JointCommand, Observation, PhasedController, Refusal,
};

/// A robot's controller by a gait of one phase that runs as programs.
pub type ProgramController = GaitController<f64, GaitPrograms>;

/// The same by a gait of several phases.
pub type PhasedProgramController = PhasedController<f64, PhasePrograms>;

impl GaitPrograms {
    /// [`Controller::begin_phase`].
    ///
    /// # Errors
    /// As there.
    pub fn begin_phase(
        controller: &mut ProgramController,
        observed: &Observation<'_, f64>,
    ) -> Result<(), Refusal> {
        controller.begin_phase(observed)
    }

    /// [`Controller::command`].
    ///
    /// # Errors
    /// As there.
    pub fn command(
        controller: &mut ProgramController,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        controller.command(observed, commands)
    }
}

impl PhasePrograms {
    /// [`Controller::begin_phase`].
    ///
    /// # Errors
    /// As there.
    pub fn begin_phase(
        controller: &mut PhasedProgramController,
        observed: &Observation<'_, f64>,
    ) -> Result<(), Refusal> {
        controller.begin_phase(observed)
    }

    /// [`Controller::command`].
    ///
    /// # Errors
    /// As there.
    pub fn command(
        controller: &mut PhasedProgramController,
        observed: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        controller.command(observed, commands)
    }
}
