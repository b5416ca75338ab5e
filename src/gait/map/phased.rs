//! Maps of gaits of several phases (thesis, figure 7.5): each cell is a step that is followed through all phases.
use super::{GaitMap, MapOptions, Mapping};
use crate::gait::chain::{Chains, SpeedAndReason};
use crate::gait::{Parametrised, PhasedBench};
use crate::progress::Run;
use bipedc_analysis::gait::{Cell, MapRequest, Reason, Sparing};
use bipedc_analysis::simulate::phases::PhaseSpec;
use bipedc_effects::diagnostic::Diagnostics;
use std::path::Path;

/// Largest deviation of an interpolated next speed, as a part of the speed of the map.
const TOLERANCE: f64 = 1e-3;

impl PhasedBench {
    /// The next mid-stance speed over two parameters, each computed cell as [`PhasedBench::step`] has it; `specs` are the phases of the
    /// robot's description, `file` as for gaits of one phase. Cells of large maps are interpolated ([`MapOptions::interpolated_from`]) where
    /// that is known to a thousandth of the map's speed; the extremes within the bounds are computed. Computed cells of such maps are integrated
    /// within 3e-9 per step instead of 1e-11, by a method of lower order.
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
        let sparing = self.sparing(&chains, &request, options.interpolated_from);
        let chains = if sparing.interpolates(request.size()) { chains.roughly() } else { chains };
        self.mapped((&request, identity), file, run, |known, watch| {
            request.cells_sparing(&known, &sparing, watch, |to, k| {
                let from = request.from.as_deref().unwrap_or(to);
                cell(chains.speed(from, to, request.speeds[k]))
            })
        })
    }

    fn sparing(&self, chains: &Chains<'_>, request: &MapRequest, from: Option<usize>) -> Sparing {
        let axes = request.axes.each_ref().map(|(parameter, _)| *parameter);
        let phases = axes.map(|parameter| chains.phases_that_read(parameter));
        Sparing {
            tolerance: TOLERANCE,
            from_cells: from.unwrap_or(usize::MAX),
            // Most phases are the same ones for all values of the other axis.
            shared: usize::from(phases[1] > phases[0]),
            bounds: axes.map(|parameter| self.parameter(parameter).bounds),
        }
    }
}

fn cell(found: SpeedAndReason) -> Cell {
    match found {
        Ok((next, broken)) => Cell { reason: broken.unwrap_or(Reason::Passes), ..Cell::passing(next) },
        Err(why) => Cell::failing(why.reason),
    }
}
