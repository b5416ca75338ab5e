//! Cycles of gaits of several phases.
use super::{CycleOptions, Cycles, Cycling};
use crate::gait::chain::Chains;
use crate::gait::{Parametrised, PhasedBench};
use crate::progress::Run;
use bipedc_analysis::gait::in_parallel;
use bipedc_analysis::simulate::phases::PhaseSpec;
use bipedc_effects::diagnostic::Diagnostics;

impl PhasedBench {
    /// Walking that repeats itself; `specs` are the phases of the robot's description.
    ///
    /// # Errors
    /// Parameters that the gait does not have, numbers and ranges that are none.
    pub fn cycles(
        &self,
        specs: &[PhaseSpec],
        options: &CycleOptions,
        run: &Run<'_>,
    ) -> Result<Cycles, Diagnostics> {
        let chains = Chains::new(self, specs).map_err(|error| error.or_in_file(&self.file))?;
        self.each_cycle(options, run, format!("({})²", self.speed_unit()), |all, watch| {
            let mut found = in_parallel(all.len(), watch, |job| chains.ask(|chain| chain.cycle(&all[job])));
            found.sort_by_key(|(job, _)| *job);
            // What was done behind a gap has no place.
            let in_order = found.into_iter().enumerate().take_while(|(k, (job, _))| k == job);
            in_order.map(|(_, (_, cycle))| cycle.map_err(|why| why.to_string())).collect()
        })
    }
}
