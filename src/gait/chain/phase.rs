//! A phase of a chain: what stands, its functions, what ends it.
use super::known::Read;
use super::surface::Surface;
use bipedc_analysis::simulate::phases::PhaseSpec;
use bipedc_runtime::control::{MOST_FEET, StandingFoot};

/// A phase with its functions.
pub(super) struct ChainPhase {
    pub spec: PhaseSpec,
    pub surface: Surface,
    pub dynamics: usize,
    pub impact: Option<usize>,
    pub feet: [Option<StandingFoot>; MOST_FEET],
    /// φ and the outputs, then their rates.
    pub controlled: usize,
    pub outputs: usize,
    pub read: Read,
}

impl ChainPhase {
    /// Positive until the foot whose force ends the phase is let go or tips.
    pub fn ending_force(&self, forces: &[f64]) -> f64 {
        for foot in self.feet.iter().flatten() {
            let push = forces[foot.force[1]];
            if !foot.holds {
                return push;
            }
            let Some(moment) = foot.moment else { continue };
            let pressure = -forces[moment] / push;
            let [rear, front] = foot.sole;
            match foot.level {
                [true, true] => {}
                [false, _] => return pressure - rear,
                [_, false] => return front - pressure,
            }
        }
        f64::INFINITY
    }
}
