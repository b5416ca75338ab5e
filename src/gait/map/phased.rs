//! Maps of gaits of several phases (thesis, figure 7.5): each cell is a step that is followed through all phases.
use super::{GaitMap, MapOptions, Mapping};
use crate::gait::PhasedBench;
use crate::gait::chain::Chains;
use crate::progress::Run;
use bipedc_analysis::gait::{Assumptions, Cell};
use bipedc_analysis::simulate::phases::PhaseSpec;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use std::path::Path;

impl PhasedBench {
    /// The next mid-stance speed over two parameters, each cell as [`PhasedBench::step`] has it; `specs` are the phases of the robot's
    /// description, `file` as for gaits of one phase.
    ///
    /// # Errors
    /// Parameters that the gait does not have, ranges and speeds that are none, margins as assumptions; a file that is there and is
    /// not of this map.
    pub fn map(
        &self,
        specs: &[PhaseSpec],
        options: &MapOptions,
        file: Option<&Path>,
        run: &Run<'_>,
    ) -> Result<GaitMap, Diagnostics> {
        let request = self.map_request(options)?;
        if options.assume != Assumptions::default() {
            let message = "maps of several phases have no margins";
            let help = "their controller keeps friction, push and torques itself (docs/gaits.md): leave --assume out";
            return Err(Diagnostic::error(message).help(help).into());
        }
        let identity = self.identity(&request);
        let chains = Chains::new(self, specs);
        self.mapped((&request, identity), file, run, |known, watch| {
            request.cells(known, watch, |to| {
                let from = request.from.as_deref().unwrap_or(to);
                chains.speeds(from, to, &request.speeds).into_iter().map(cell).collect()
            })
        })
    }
}

fn cell(found: Result<f64, crate::gait::Refused>) -> Cell {
    match found {
        Ok(next) => Cell { next_speed: Some(next), reason: bipedc_analysis::gait::Reason::Passes },
        Err(why) => Cell { next_speed: None, reason: why.reason },
    }
}
