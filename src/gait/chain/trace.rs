//! Energies along a step of several phases.
use super::hop::{Hop, MidStance};
use super::{Chain, PhaseEnergy};

/// Steps of the quadrature in each phase.
const STEPS: usize = 128;
/// How far beyond its end a phase may go, of its length.
const BEYOND: f64 = 0.3;

/// Energies of one phase.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseTrace {
    /// Time (s) with K = φ̇²/(2ψ) and P (6.32), (unit of φ/s)².
    pub points: Vec<(f64, [f64; 2])>,
}

impl PhaseTrace {
    /// The same so many seconds later.
    pub(in crate::gait) fn later(mut self, by: f64) -> Self {
        self.points.iter_mut().for_each(|(time, _)| *time += by);
        self
    }
}

impl Chain<'_> {
    /// A step from mid-stance with the energies of its phases. Where torques are held to limits, K + P does not stay what it is.
    pub(in crate::gait) fn traced_hop(&self, from: &MidStance, values: &[f64]) -> (Hop, Vec<PhaseTrace>) {
        let mut traces: Vec<PhaseTrace> = Vec::new();
        let mut energy: Option<PhaseEnergy> = None;
        let hop = self.hop_watched(from, values, &mut |phase, time, [phi, rate], begins| {
            if begins {
                let end = self.end_of_present();
                let most = end + BEYOND * (end - phi);
                // Beyond its end a phase may have no postures.
                let along = |to: f64| PhaseEnergy::new(self, phase, [phi, to], STEPS).ok();
                // The step goes on as if nobody had looked.
                let own = self.present.borrow().clone();
                energy = along(most).or_else(|| along(end));
                self.present.replace(own);
                traces.push(PhaseTrace { points: Vec::new() });
            }
            if let (Some(trace), Some([psi, potential])) =
                (traces.last_mut(), energy.as_ref().map(|energy| energy.at(phi)))
            {
                trace.points.push((time, [0.5 * rate * rate / psi, potential]));
            }
        });
        (hop, traces)
    }
}
