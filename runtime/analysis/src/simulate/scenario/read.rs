//! From the file to a checked scenario.
use super::file::{Control, File, Number};
use super::reading::{POSITIVE, Reading};
use super::{Scenario, effects};
use crate::simulate::{Plant, Tolerance};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::Effect;
use bipedc_effects::input;
use std::path::Path;

/// Steps of a run: more are a mistake.
const MOST_STEPS: f64 = 1e9;

impl Scenario {
    /// Reads a scenario file for this robot.
    ///
    /// # Errors
    /// Everything that has no meaning, with line and column.
    pub fn open(path: &Path, plant: &Plant) -> Result<Self, Diagnostics> {
        let text = input::read_to_string(path).map_err(|e| {
            Diagnostics(vec![
                Diagnostic::error(format!("cannot read the scenario: {e}"))
                    .in_file(path)
                    .help("docs/simulation.md shows a first one"),
            ])
        })?;
        Self::parse(path, &text, plant)
    }

    /// The same from a text; `path` is for messages, and trajectories are looked for beside it.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn parse(path: &Path, text: &str, plant: &Plant) -> Result<Self, Diagnostics> {
        let mut reading = Reading::new(path, text);
        let Some(file) = reading.file(text) else { return Err(reading.failed()) };
        let scenario = reading.scenario(&file, plant);
        reading.finish(scenario)
    }
}

impl Reading<'_> {
    fn scenario(&mut self, file: &File, plant: &Plant) -> Scenario {
        if file.duration.is_none() {
            self.missing("duration", "write duration = 10.0 (s) above all tables");
        }
        let duration = self.number("duration", file.duration.as_ref(), 1.0, POSITIVE, "s");
        let step = self.number("step", file.step.as_ref(), 1e-3, POSITIVE, "s");
        let event_driven = self.is_event_driven(file, plant);
        let (step, log_every) = match event_driven {
            true => (self.number("log_step", file.log_step.as_ref(), 0.005, POSITIVE, "s"), 1),
            false => (step, self.log_every(file.log_step.as_ref(), step)),
        };
        self.check_steps(file, (duration, step), event_driven);
        let relative = self.number("residual", file.residual.as_ref(), 1e-8, (1e-14, 1e-2), "1");
        let none = Control::default();
        let control = file.control.as_ref().unwrap_or(&none);
        for (name, joint) in &file.joint {
            if plant.joint(name).is_none() {
                self.no_joint(joint.span().start, name, plant);
            }
        }
        let mut initial = self.initial(file, plant);
        let trajectory = control.trajectory.as_ref().and_then(|name| self.trajectory(name, plant));
        let servos = self.servos(file, control, trajectory.as_ref(), plant, &mut initial);
        let effects = self.effects(file, plant, event_driven);
        let events = event_driven.then(|| self.events(file));
        let gait = self.gait(file, control, plant);
        let outputs = if gait.is_some() { None } else { self.outputs(control, plant, &servos) };
        Scenario {
            duration,
            step,
            log_every,
            seed: file.seed,
            tolerance: Tolerance { relative, ..Tolerance::default() },
            initial,
            servos,
            trajectory: control.trajectory.as_ref().map(|name| self.beside(name.get_ref())),
            ground: self.ground(file.ground.as_ref().map(|soil| soil.get_ref())),
            heights: self.heights(file, plant),
            shapes: self.shapes(file.ground.as_ref().map(|soil| soil.get_ref()), plant),
            joint_stops: control.joint_stops.unwrap_or(true),
            sensors: self.sensors(file.sensors.as_ref()),
            effects,
            pushes: self.pushes(file, plant, event_driven),
            payloads: self.payloads(file, plant, event_driven),
            rises: self.rises(file, plant, event_driven),
            events,
            phase: self.first_phase(file, plant, event_driven || outputs.is_some() || gait.is_some()),
            walking: self.footstep_walk(
                file,
                plant,
                (event_driven || outputs.is_some() || gait.is_some(), step),
            ),
            outputs,
            gait,
            world: self.world(file),
            actuators: self.motors(file, plant),
            imu: file.imu.as_ref().and_then(|table| self.imu(table, plant)),
            inside: self.choice("servo", control.servo.as_ref(), ["held", "drive"]) == 1,
        }
    }

    /// Neither too many nor too long.
    fn check_steps(&mut self, file: &File, (duration, step): (f64, f64), event_driven: bool) {
        if duration / step > MOST_STEPS {
            let help = "shorten `duration`, or lengthen `step` or `log_step`";
            let at = file.duration.as_ref().map_or(0, |found| found.span().start);
            self.wrong::<()>(at, "more than a thousand million steps", help);
        }
        if !event_driven && step > duration {
            let at = file.step.as_ref().or(file.duration.as_ref()).map_or(0, |found| found.span().start);
            let message = format!("a step of {step} s is longer than the whole run of {duration} s");
            self.wrong::<()>(at, message, "shorten `step`, or lengthen `duration`");
        }
    }

    fn effects(&mut self, file: &File, plant: &Plant, event_driven: bool) -> Vec<Effect> {
        let effects = file.effect.iter().filter_map(|table| effects::effect(self, plant, table));
        let effects: Vec<Effect> = effects.map(effects::with_settings).collect();
        if event_driven {
            let places: Vec<usize> = file.effect.iter().map(|table| table.span().start).collect();
            effects.iter().zip(places).for_each(|(effect, at)| self.refuse_effect(effect, at));
        }
        effects
    }

    fn log_every(&mut self, log_step: Option<&Number>, step: f64) -> usize {
        let wanted = self.number("log_step", log_step, step, POSITIVE, "s");
        let every = (wanted / step).round();
        if !(1.0..1e9).contains(&every) || (every * step - wanted).abs() > 1e-9 * wanted {
            let at = log_step.map_or(0, |found| found.span().start);
            let help = format!("write a multiple of {step} s");
            self.wrong::<()>(at, format!("`log_step` = {wanted} s is no multiple of the step"), help);
            return 1;
        }
        every as usize
    }
}
