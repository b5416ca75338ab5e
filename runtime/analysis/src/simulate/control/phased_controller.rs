//! Controllers that know phases, in time stepping: phases are followed, and legs are named by their roles.
use super::tracker::Tracker;
use super::virtual_constraints::{Outputs, VirtualConstraints};
use crate::robot::BaseKind;
use crate::simulate::phases::{Mirror, PhaseSpec};
use crate::simulate::plant::Plant;
use crate::simulate::stepper::{MotionState, Stepper};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use bipedc_runtime::model::Model;

/// A controller of a time-stepped robot that is told in which phase the robot is, and which speaks of legs by their roles
/// (the one that stands, the one that swings) where the phases exchange left and right.
pub struct PhasedController<'a> {
    controller: Box<dyn Controller<f64> + 'a>,
    phases: &'a [PhaseSpec],
    tracker: Tracker<'a>,
    planar: bool,
    places: Vec<f64>,
    along: Vec<f64>,
    impulses: Vec<f64>,
    q: Vec<f64>,
    v: Vec<f64>,
    commands: Vec<JointCommand<f64>>,
    /// The controller has been told of the first phase.
    begun: bool,
}

impl<'a> PhasedController<'a> {
    /// Virtual constraints; `model` has the functions of the phases, `first` is the phase at time 0.
    ///
    /// # Errors
    /// The model lacks a function; the phases exchange legs that do not mirror each other.
    pub fn of_outputs(
        model: &'a dyn Model<f64>,
        plant: &Plant,
        phases: &'a [PhaseSpec],
        outputs: &'a Outputs,
        first: usize,
    ) -> Result<Self, Diagnostic> {
        let names: Vec<&str> = phases.iter().map(|phase| phase.dynamics.as_str()).collect();
        let controller = VirtualConstraints::new(model, plant.layout.base, outputs, &names)?;
        Self::new(model, plant, phases, controller, first)
    }

    /// Any controller, over the scenario's servos: commands that it leaves as they are stay with these.
    ///
    /// # Errors
    /// The phases exchange legs that do not mirror each other, or the model cannot exchange them.
    pub fn new(
        model: &'a dyn Model<f64>,
        plant: &Plant,
        phases: &'a [PhaseSpec],
        controller: impl Controller<f64> + 'a,
        first: usize,
    ) -> Result<Self, Diagnostic> {
        let base = plant.layout.base;
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
            controller: Box::new(controller),
            phases,
            tracker,
            planar,
            places: vec![0.0; next * if planar { 1 } else { 2 }],
            along: vec![0.0; next],
            impulses: vec![0.0; next],
            q: vec![0.0; model.nq()],
            v: vec![0.0; model.nv()],
            commands: vec![JointCommand::Off; model.joints()],
            begun: false,
        })
    }

    /// Before a step: the phase now, and the commands of the joints that it drives, over those that stand there.
    ///
    /// # Errors
    /// The controller refuses the state.
    pub(crate) fn command(
        &mut self,
        stepper: &Stepper<'_>,
        motion: &MotionState,
        time: f64,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Diagnostic> {
        let begins = self.follow(stepper, motion) || !self.begun;
        self.begun = true;
        let phase = self.tracker.phase();
        let mirror = self.tracker.mirror();
        let seen = |joint: usize, command: &JointCommand<f64>| {
            mirror.map_or((joint, *command), |mirror| mirror.command(joint, command))
        };
        for (joint, command) in commands.iter().enumerate() {
            let (role, command) = seen(joint, command);
            self.commands[role] = command;
        }
        let (q, v) = match mirror {
            None => (&motion.q, &motion.v),
            Some(mirror) => {
                mirror.state(&motion.q, &motion.v, (&mut self.q, &mut self.v));
                (&self.q, &self.v)
            }
        };
        let observed = Observation::new(time, phase, q, v);
        let begun = if begins { self.controller.begin_phase(&observed) } else { Ok(()) };
        begun
            .and_then(|()| self.controller.command(&observed, &mut self.commands))
            .map_err(|refusal| refused(refusal, Some(&self.phases[phase].name), motion.time))?;
        for (role, command) in self.commands.iter().enumerate() {
            let (joint, command) = seen(role, command);
            commands[joint] = command;
        }
        Ok(())
    }

    /// Finds the phase at this state; whether it has just begun.
    fn follow(&mut self, stepper: &Stepper<'_>, motion: &MotionState) -> bool {
        stepper.mechanics().positions(&motion.q, &mut self.places);
        let across = if self.planar { 1 } else { 2 };
        for (point, along) in self.along.iter_mut().enumerate() {
            *along = self.places[point * across];
            self.impulses[point] = stepper.impulse(point)[2];
        }
        self.tracker.update(motion.time, stepper.gaps(), &self.along, &self.impulses)
    }
}

/// Why a controlled walk stopped.
pub(crate) fn refused(refusal: Refusal, phase: Option<&str>, time: f64) -> Diagnostic {
    match (refusal, phase) {
        (Refusal::SingularOutputs, Some(phase)) => Diagnostic::error(format!(
            "at {time:.6} s the outputs of phase `{phase}` cannot be driven: their decoupling matrix L_g L_f h is singular"
        ))
        .help("outputs must be independent of each other and each be moved by the actuators; a knee that is stretched is neither"),
        (other, phase) => {
            let phase = phase.map(|phase| format!(" in phase `{phase}`")).unwrap_or_default();
            Diagnostic::error(format!("at {time:.6} s the controller has no command{phase}: {other}"))
        }
    }
}
