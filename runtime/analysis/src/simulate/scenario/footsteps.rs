//! `[walking]` of a scenario: a robot that walks by footsteps, at velocities that it is told on the way.
use super::file::{File, Number};
use super::reading::{ANY, NOT_NEGATIVE, Reading};
use crate::robot::BaseKind;
use crate::simulate::Plant;
use std::path::PathBuf;

/// A robot that walks by footsteps.
#[derive(Debug, Clone, PartialEq)]
pub struct FootstepWalk {
    /// From when on (s) it shall walk how fast: forward, to the left (m/s), turning (rad/s); in order of time.
    pub velocities: Vec<(f64, [f64; 3])>,
    /// A file of the form of `walking.toml`; `None`: the robot's own.
    pub settings: Option<PathBuf>,
    /// Folder of the robot as the controller knows it; `None`: as described.
    pub model: Option<PathBuf>,
    /// The controller is told what its sensors measure, not the truth.
    pub measured: bool,
    /// The controller finds out what it carries on its root link.
    pub learns_payload: bool,
    /// What it is told was so many steps ago.
    pub delay: usize,
    /// The scenario says where no joint begins: the robot begins as it stands when it walks.
    pub begins_standing: bool,
    /// Line and column.
    pub position: (usize, usize),
}

impl FootstepWalk {
    /// How fast it shall walk at a time.
    pub fn velocity(&self, time: f64) -> [f64; 3] {
        let past = self.velocities.iter().take_while(|(from, _)| *from <= time);
        past.last().map_or([0.0; 3], |(_, velocity)| *velocity)
    }
}

/// Longer delays (s) are none.
const LONGEST_DELAY: f64 = 0.1;

impl Reading<'_> {
    /// In steps.
    fn delay(&mut self, delay: Option<&Number>, step: f64) -> usize {
        let wanted = self.number("delay", delay, 0.0, (0.0, LONGEST_DELAY), "s");
        let steps = (wanted / step).round();
        if (steps * step - wanted).abs() > 1e-9 {
            let at = delay.map_or(0, |found| found.span().start);
            let help = format!("write a multiple of {step} s");
            self.wrong::<()>(at, format!("`delay` = {wanted} s is no multiple of the step"), help);
        }
        steps as usize
    }

    /// The table `[walking]`, if there is one; `otherwise`: something else says how the robot moves.
    pub(super) fn footstep_walk(
        &mut self,
        file: &File,
        plant: &Plant,
        (otherwise, step): (bool, f64),
    ) -> Option<FootstepWalk> {
        let table = file.walking.as_ref()?;
        let at = table.span().start;
        if otherwise {
            let help = "leave [walking] out, or `gait`, [[control.output]] and method = \"event_driven\"";
            self.wrong::<()>(at, "[walking] says how the robot walks, and something else does too", help);
        }
        if plant.layout.base != BaseKind::Floating {
            let help = "leave [walking] out, or choose --base floating";
            self.wrong::<()>(at, "only a robot on a floating base walks by footsteps", help);
        }
        let table = table.get_ref();
        let mut velocities = Vec::new();
        for speed in &table.velocity {
            let at = speed.span().start;
            let speed = speed.get_ref();
            let time = self.number("time", Some(&speed.time), 0.0, NOT_NEGATIVE, "s");
            let of = |reading: &mut Self, name, found: &Option<_>, unit| {
                reading.number(name, found.as_ref(), 0.0, ANY, unit)
            };
            let velocity = [
                of(self, "forward", &speed.forward, "m/s"),
                of(self, "left", &speed.left, "m/s"),
                of(self, "turning", &speed.turning, "rad/s"),
            ];
            if velocities.last().is_some_and(|(before, _)| *before >= time) {
                self.wrong::<()>(at, "velocities are not in the order of time", "sort them by `time`");
            }
            velocities.push((time, velocity));
        }
        let begins_standing = file.joint.values().all(|joint| joint.get_ref().position.is_none());
        Some(FootstepWalk {
            velocities,
            settings: table.settings.as_ref().map(|name| self.beside(name.get_ref())),
            model: table.model.as_ref().map(|name| self.beside(name.get_ref())),
            measured: self.choice("state", table.state.as_ref(), ["true", "measured"]) == 1,
            learns_payload: table.learn_payload.unwrap_or(false),
            delay: self.delay(table.delay.as_ref(), step),
            begins_standing,
            position: self.place(at),
        })
    }
}
