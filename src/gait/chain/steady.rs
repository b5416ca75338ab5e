//! The whole robot where a step of walking that repeats itself begins, for the example of a generated crate.
use super::{Chain, Refused};
use crate::gait::PhasedBench;
use bipedc_analysis::gait::Reason;
use bipedc_analysis::simulate::phases::{Ending, PhaseSpec};
use bipedc_compiler::emit::{PhasedWalk, WalkedPhase};
use bipedc_compiler::robot::{DerivedGait, RobotGait};

/// Digits of what is written: those behind depend on the processor, and a check of a crate compares its text.
const DIGITS: usize = 7;

impl PhasedBench {
    /// A gait that a robot has derived, if it is of several phases.
    pub fn derived_before(found: &RobotGait) -> Option<Self> {
        let DerivedGait::Phased(of) = &found.derived else { return None };
        let (gait, compiled) = (**of).clone();
        Some(Self { gait, warnings: found.warnings.clone(), file: found.file.clone(), compiled })
    }

    /// What the example of a generated crate walks by, with the gait's own parameters; `specs` are the phases of the robot's description.
    ///
    /// # Errors
    /// Why steps do not come to repeat themselves.
    pub fn walk_of_example(&self, specs: &[PhaseSpec]) -> Result<PhasedWalk, Refused> {
        let controller = self.controller(None, &[]).map_err(|all| match all.0.into_iter().next() {
            Some(why) => Refused { reason: Reason::NotFinite, why },
            None => Refused::new(Reason::NotFinite, "the gait has no controller"),
        })?;
        let chain = Chain::new(self, specs, controller)?;
        let values = self.values(&[]).unwrap_or_default();
        let (begin, speed) = chain.steady(&values)?;
        let mut phases = Vec::new();
        for index in 0..self.gait.phases.len() {
            let spec = &chain.phase(self.compiled.phase(&self.gait, index)?.phase)?.spec;
            phases.push(WalkedPhase {
                dynamics: spec.dynamics.clone(),
                lands: if let Ending::Touch(points) = &spec.ending { points.clone() } else { Vec::new() },
                impact: spec.impact.as_ref().map(|landing| landing.map.clone()),
                exchanges: spec.relabel,
            });
        }
        Ok(PhasedWalk {
            begin: begin.map(|part| part.into_iter().map(short).collect()),
            speed: short(speed),
            phases,
        })
    }
}

impl Chain<'_> {
    /// q and v where a step of the cycle with these parameters begins, and its mean speed (m/s).
    fn steady(&self, values: &[f64]) -> Result<([Vec<f64>; 2], f64), Refused> {
        let (start, _) = self.repeating(values, None)?;
        let first = self.first()?;
        let mut begun = None;
        let hop = self.hop_watched(&start, values, &mut |phase, _, _, begins| {
            if begins && phase == first {
                // The last one: a hop begins at mid-stance.
                begun = Some(self.present.borrow().begun.clone());
            }
        });
        let end = hop.next?;
        let begun = begun.ok_or_else(|| Refused::new(Reason::PhaseWithoutEnd, "no step begins"))?;
        let (q, v) = begun.split_at(begun.len() / 2);
        Ok(([q.to_vec(), v.to_vec()], (end.q[0] - start.q[0]) / hop.duration))
    }
}

/// To a few digits.
fn short(x: f64) -> f64 {
    format!("{x:.0$e}", DIGITS - 1).parse().unwrap_or(x)
}
