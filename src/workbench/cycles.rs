//! Cycles of a gait with what steps of the whole robot say of them.
use super::Workbench;
use crate::gait::{AnyBench, Assignment, Cycles};
use crate::simulation;
use bipedc_effects::diagnostic::Diagnostics;

impl Workbench {
    /// Adds to the first of some cycles what steps of the whole robot make of deviations.
    ///
    /// # Errors
    /// Phases that cannot be derived.
    pub fn whole_cycle(&self, gait: &AnyBench, cycles: &mut Cycles) -> Result<(), Diagnostics> {
        let Some(of) = cycles.cycles.first_mut() else { return Ok(()) };
        let Some(cycle) = &of.cycle else { return Ok(()) };
        let set: Vec<Assignment> = of.parameters.clone().into_iter().collect();
        let values = match gait {
            AnyBench::OnePhase(gait) => gait.values(&set)?,
            AnyBench::Phased(gait) => gait.values(&set)?,
        };
        let found = || simulation::returned(&self.robot, gait, &values, cycle.speed);
        of.whole = Some(self.progress.stage("the whole robot", found)?);
        Ok(())
    }
}
