//! Maps of gaits of several phases (thesis, figure 7.5): each cell is a step that is followed through all phases.
use super::{GaitMap, MapOptions, Mapping};
use crate::gait::PhasedBench;
use crate::gait::chain::{Chains, SpeedAndReason};
use crate::progress::Run;
use bipedc_analysis::gait::{Cell, Reason};
use bipedc_analysis::simulate::phases::PhaseSpec;
use bipedc_effects::diagnostic::Diagnostics;
use std::path::Path;

impl PhasedBench {
    /// The next mid-stance speed over two parameters, each cell as [`PhasedBench::step`] has it; `specs` are the phases of the robot's
    /// description, `file` as for gaits of one phase.
    ///
    /// # Errors
    /// Parameters that the gait does not have, ranges and speeds that are none, margins that nothing is known of; a file that is there and is
    /// not of this map.
    pub fn map(
        &self,
        specs: &[PhaseSpec],
        options: &MapOptions,
        file: Option<&Path>,
        run: &Run<'_>,
    ) -> Result<GaitMap, Diagnostics> {
        let request = self.map_request(options)?;
        let identity = self.identity(&request);
        let chains = Chains::new(self, specs)
            .map_err(|error| error.or_in_file(&self.file))?
            .assuming(options.assume)?;
        self.mapped((&request, identity), file, run, |known, watch| {
            request.cells(known, watch, |to| {
                let from = request.from.as_deref().unwrap_or(to);
                chains.speeds(from, to, &request.speeds).into_iter().map(cell).collect()
            })
        })
    }
}

fn cell(found: SpeedAndReason) -> Cell {
    match found {
        Ok((next, broken)) => Cell { next_speed: Some(next), reason: broken.unwrap_or(Reason::Passes) },
        Err(why) => Cell { next_speed: None, reason: why.reason },
    }
}
