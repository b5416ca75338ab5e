//! What a walk chooses the parameters of its steps by: computed once, for all walks of a scenario.
use super::Scene;
use super::gait::{ChosenFrom, GaitDriver, Walker};
use crate::gait::choice::{
    Choosing, Foresight, KnownRobot, Passed, PhasedChooser, PhasedChoosing, Present, StepPart, StepSpeed,
    chooser,
};
use crate::gait::{Chain, Refused};
use crate::progress::Run;
use bipedc_analysis::gait::{Chooser, GaitModel, Watch};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_runtime::control::Controller;

/// Of a gait of one phase or of several.
pub(super) enum Choosers<'c, 'f> {
    OnePhase(&'c GaitModel<'c>, Chooser<'c, 'c>),
    Phased(&'c Foresight<'f>, PhasedChooser<'c, 'f>),
}

/// What was chosen in a walk.
pub(super) struct Walked {
    /// Step after step.
    pub steps: Vec<StepSpeed>,
    /// Parts of steps with their parameters, in order of time.
    pub parts: Vec<StepPart>,
}

fn interrupted() -> Diagnostic {
    Diagnostic::error("interrupted before the walk began")
}

impl Scene {
    /// Computes what parameters are chosen by, and does something with it.
    ///
    /// # Errors
    /// There is nothing to choose; an interruption; those of the work.
    pub(super) fn with_choosers<T>(
        &self,
        gait: &Walker,
        run: &Run<'_>,
        work: impl FnOnce(&Choosers<'_, '_>) -> Result<T, Diagnostics>,
    ) -> Result<T, Diagnostics> {
        let wished = gait.wishes.as_ref().ok_or_else(interrupted)?;
        match (&wished.from, gait.one_phase(), gait.phased()) {
            (ChosenFrom::OnePhase(settings), Some((bench, _)), _) => {
                let model = bench.model()?;
                let chooser = chooser(&model, settings.clone(), run).ok_or_else(interrupted)?;
                work(&Choosers::OnePhase(&model, chooser))
            }
            (ChosenFrom::Phased(settings, known), _, Some((bench, controller))) => {
                let known = self.known(known);
                let foresight = Foresight::new(bench, known, controller.clone());
                let chain = foresight.chain()?;
                let from = passed(&chain, &settings.usual, mean(&wished.speeds))
                    .map_err(|why| Diagnostic::error(format!("the usual parameters make no step: {why}")))?;
                let chooser = run.progress.counted("steps to choose from", |advance| {
                    let watch = Watch { advance, stop: run.stop };
                    PhasedChooser::new(&foresight, settings.clone(), &from, &watch)
                })?;
                work(&Choosers::Phased(&foresight, chooser.ok_or_else(interrupted)?))
            }
            _ => Err(interrupted().into()),
        }
    }

    /// The robot as its description has it, with what this scenario assumes.
    fn known<'k>(&'k self, walker: &'k super::Walker) -> KnownRobot<'k> {
        let stops = if self.scenario.joint_stops { self.plant.position_limits.clone() } else { Vec::new() };
        KnownRobot {
            model: &walker.model,
            base: walker.base,
            feet: &walker.feet,
            phases: &walker.phases,
            stops,
            assumptions: self.scenario.events.as_ref().map(|events| events.assumptions).unwrap_or_default(),
        }
    }
}

impl Choosers<'_, '_> {
    /// Walks with parameters that are chosen; `walk` is given the controller, and the parameters that hold at any time.
    ///
    /// # Errors
    /// A function is missing: a fault of the compiler.
    pub fn walk<T>(
        &self,
        gait: &Walker,
        walk: impl FnOnce(&mut dyn Controller<f64>, Present) -> T,
    ) -> Result<(T, Walked), Diagnostic> {
        let wishes = gait.wishes.as_ref().map_or(&[][..], |wishes| &wishes.speeds[..]);
        let named = (gait.names(), gait.values());
        match (self, &gait.controller) {
            (Self::OnePhase(model, chooser), GaitDriver::OnePhase(controller)) => {
                let controller = controller.as_ref().clone();
                let mut choosing = Choosing::new(controller, (model, chooser), named, wishes);
                let present = choosing.present();
                let walked = walk(&mut choosing, present);
                let parts = choosing.take_parts();
                Ok((walked, Walked { steps: choosing.steps(), parts }))
            }
            (Self::Phased(foresight, chooser), GaitDriver::Phased(controller)) => {
                let controller = controller.as_ref().clone();
                let chain = foresight.chain()?;
                let mut choosing = PhasedChoosing::new(controller, (&chain, chooser), named, wishes)?;
                let present = choosing.present();
                let walked = walk(&mut choosing, present);
                let parts = choosing.take_parts();
                Ok((walked, Walked { steps: choosing.steps(), parts }))
            }
            _ => Err(Diagnostic::error("there is nothing to choose")),
        }
    }
}

/// The whole robot at the dead centre of a step with these parameters.
fn passed(chain: &Chain<'_>, values: &[f64], speed: f64) -> Result<Passed, Refused> {
    let stance = chain.mid_stance(values, speed)?;
    Ok(Passed { v: stance.velocity(), q: stance.q, speed })
}

fn mean(speeds: &[f64]) -> f64 {
    speeds.iter().sum::<f64>() / speeds.len().max(1) as f64
}
