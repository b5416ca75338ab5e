//! Virtual constraints in time stepping: phases are followed, torques are held over the step.
use super::controller::{Controller, Outputs};
use super::tracker::Tracker;
use crate::robot::BaseKind;
use crate::simulate::phases::{Mirror, PhaseSpec};
use crate::simulate::plant::Plant;
use crate::simulate::stepper::{Motion, Stepper};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::model::Model;

/// The controller of a time-stepped robot.
pub struct Driven<'a> {
    controller: Controller<'a>,
    phases: &'a [PhaseSpec],
    tracker: Tracker<'a>,
    planar: bool,
    places: Vec<f64>,
    along: Vec<f64>,
    impulses: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    tau: Vec<f64>,
    work: Vec<f64>,
}

impl<'a> Driven<'a> {
    /// `model` has the functions of the phases; `first` is the phase at time 0.
    ///
    /// # Errors
    /// The model lacks a function; the phases exchange legs that do not mirror each other.
    pub fn new(
        model: &'a dyn Model<f64>,
        plant: &Plant,
        phases: &'a [PhaseSpec],
        outputs: &'a Outputs,
        first: usize,
    ) -> Result<Self, Diagnostic> {
        let base = plant.subject.base;
        let names: Vec<&str> = phases.iter().map(|phase| phase.dynamics.as_str()).collect();
        let mirror = if phases.iter().any(|p| p.relabel) { Some(Mirror::new(model, base)?) } else { None };
        let mut next = 0;
        let feet = plant.feet.iter().map(|foot| {
            let own = next..next + foot.corners.len();
            next = own.end;
            own
        });
        let tracker = Tracker::new(phases, mirror, feet.collect(), f64::NEG_INFINITY, first);
        let planar = base == BaseKind::Planar;
        Ok(Self {
            controller: Controller::new(model, base, outputs, &names)?,
            phases,
            tracker,
            planar,
            places: vec![0.0; next * if planar { 1 } else { 2 }],
            along: vec![0.0; next],
            impulses: vec![0.0; next],
            q: vec![0.0; model.nq()],
            v: vec![0.0; model.nv()],
            tau: vec![0.0; model.nv()],
            work: vec![0.0; model.nv()],
        })
    }

    /// Before a step: the phase now, and its torques.
    ///
    /// # Errors
    /// The outputs of the phase cannot be driven.
    pub(crate) fn update(&mut self, stepper: &Stepper<'_>, motion: &Motion) -> Result<(), Diagnostic> {
        stepper.mechanics().positions(&motion.q, &mut self.places);
        let across = if self.planar { 1 } else { 2 };
        for (point, along) in self.along.iter_mut().enumerate() {
            *along = self.places[point * across];
            self.impulses[point] = stepper.impulse(point)[2];
        }
        self.tracker.update(stepper.gaps(), &self.along, &self.impulses);
        let phase = self.tracker.phase();
        match self.tracker.mirror() {
            None => self.controller.torque(phase, &motion.q, &motion.v, &mut self.tau),
            Some(mirror) => {
                mirror.state(&motion.q, &motion.v, (&mut self.q, &mut self.v));
                self.controller.torque(phase, &self.q, &self.v, &mut self.work);
                mirror.velocity(&self.work, &mut self.tau);
            }
        }
        match self.controller.failed() {
            None => Ok(()),
            Some(phase) => Err(cannot_drive(&self.phases[phase].name, motion.time)),
        }
    }

    /// Torque of a joint, N m; `None`: its servo drives it.
    pub(crate) fn torque(&self, joint: usize) -> Option<f64> {
        let first = self.tau.len() - self.controller.joints();
        self.controller.drives(self.tracker.phase()).then(|| self.tau[first + joint])
    }
}

/// Why a walk with outputs stopped.
pub(crate) fn cannot_drive(phase: &str, time: f64) -> Diagnostic {
    Diagnostic::error(format!(
        "at {time} s the outputs of phase `{phase}` cannot be driven: their decoupling matrix L_g L_f h is singular"
    ))
    .help("outputs must be independent of each other and each be moved by the actuators; a knee that is stretched is neither")
}
