//! One disturbed walk, with fixed and with chosen parameters.
use super::sampled::{Instruments, Sampled};
use crate::gait::choice::Present;
use crate::simulation::choosers::Choosers;
use crate::simulation::gait::Walker as GaitWalker;
use crate::simulation::{Scene, Walker, in_world, walker_for};
use bipedc_analysis::simulate::phases::{LandingGuard, WalkEnd, WalkSummary, Walking};
use bipedc_analysis::simulate::{Push, Run, Scenario, World};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::random::Random;
use bipedc_runtime::control::{Borrowed, Controller};
use serde::Serialize;
use std::cell::RefCell;
use std::rc::Rc;

/// How long a push lasts, s.
const PUSHING: f64 = 0.1;
/// Pushes begin between these times, s.
const PUSHED: [f64; 2] = [0.0, 1.0];
/// Between samples of a controller with noisy, late measurements, s.
const PERIOD: f64 = 1e-3;

/// Relative tolerance of the integration: whether a walk comes to its end depends on what disturbs it, and not on what is so much smaller.
const CLOSE: f64 = 1e-8;

/// Usual pushes, by mass × √(gravity × height of the hips): they change the speed by half of one that is good to begin with.
const PUSH: f64 = 0.1;
/// Usual heights of footholds over that of the hips.
const RISE: f64 = 0.007;

fn in_two_digits(x: f64) -> f64 {
    format!("{x:.1e}").parse().unwrap_or(x)
}

/// A way to disturb a walk.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum DisturbanceKind {
    /// A horizontal push on the base, N s.
    Push,
    /// Masses and inertias of all links, each by its own part, 1.
    Mass,
    /// The ground falls or rises, rad.
    Slope,
    /// Each foothold is higher or lower than the one before, m.
    Height,
    /// Noise of positions (rad, m), ten times that of velocities (per s), in samples of 1 ms.
    Noise,
    /// Measurements are late, s, in samples of 1 ms.
    Delay,
}

impl DisturbanceKind {
    /// All of them.
    pub const ALL: [Self; 6] = [Self::Push, Self::Mass, Self::Slope, Self::Height, Self::Noise, Self::Delay];

    /// As it is asked for.
    pub fn name(self) -> &'static str {
        match self {
            Self::Push => "push",
            Self::Mass => "mass",
            Self::Slope => "slope",
            Self::Height => "height",
            Self::Noise => "noise",
            Self::Delay => "delay",
        }
    }

    /// Unit of its size.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Push => "N s",
            Self::Mass => "1",
            Self::Slope | Self::Noise => "rad",
            Self::Height => "m",
            Self::Delay => "s",
        }
    }

    /// Its size unless another one is asked for, of a robot with this mass (kg) and this height of its hips (m) under this gravity (m/s²): pushes and heights are those of a
    /// robot that is as large, what is measured is measured alike.
    pub fn usual(self, [mass, height, gravity]: [f64; 3]) -> f64 {
        match self {
            Self::Push => in_two_digits(PUSH * mass * (gravity * height).sqrt()),
            Self::Mass => 0.1,
            Self::Slope => 0.02,
            Self::Height => in_two_digits(RISE * height),
            Self::Noise => 1e-3,
            Self::Delay => 2e-3,
        }
    }
}

/// A disturbance of a size: random ones are uniform up to it on both sides, noise has it as its standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Disturbance {
    /// What it does.
    pub kind: DisturbanceKind,
    /// How much.
    pub size: f64,
}

/// How a walk ended: with all its steps, or why not.
pub(super) type Ended = Result<(), String>;

/// What trials share.
pub(super) struct Trial<'t, 'f> {
    pub scene: &'t Scene,
    /// What most disturbances leave as it is: derived once, and machine code in nearly all walks.
    pub walker: &'t Walker,
    pub gait: &'t GaitWalker,
    pub choosers: &'t Choosers<'t, 'f>,
    pub seed: u64,
}

/// What a trial's walk meets.
struct Met {
    /// Of a robot that is disturbed itself.
    walker: Option<Walker>,
    scenario: Scenario,
    instruments: Option<Instruments>,
    seed: u64,
}

impl Trial<'_, '_> {
    /// The walk without any disturbance has to come to its end both ways.
    pub fn undisturbed(&self) -> Result<(), Diagnostics> {
        let met = Met { walker: None, scenario: self.quiet(), instruments: None, seed: 0 };
        for (chosen, words) in [(false, "the parameters of the scenario"), (true, "chosen parameters")] {
            if let Err(why) = self.walk(&met, chosen) {
                let message = format!("with {words} the undisturbed walk does not come to its end: {why}");
                let help = "disturbances tell something of walks that succeed without them: `bipedc simulate` shows this one";
                return Err(Diagnostic::error(message).in_file(&self.scene.file).help(help).into());
            }
        }
        Ok(())
    }

    /// A trial with fixed parameters, then with chosen ones.
    pub fn both(&self, disturbance: &Disturbance, number: usize) -> [Ended; 2] {
        match self.met(disturbance, number) {
            Ok(met) => [false, true].map(|chosen| self.walk(&met, chosen)),
            Err(error) => [0, 1].map(|_| Err(error.message.clone())),
        }
    }

    /// The scenario without rows of a log, integrated as closely as its end needs.
    fn quiet(&self) -> Scenario {
        let mut scenario = self.scene.scenario.clone();
        scenario.step = scenario.duration;
        if let Some(events) = &mut scenario.events {
            events.relative = events.relative.max(CLOSE);
        }
        scenario
    }

    fn met(&self, disturbance: &Disturbance, number: usize) -> Result<Met, Diagnostic> {
        let Disturbance { kind, size } = *disturbance;
        // Of the same seed and number whatever the size, so that sizes can be compared.
        let seed = self.seed.wrapping_mul(0x9e37_79b9).wrapping_add(number as u64);
        let mut random = Random::new(seed);
        let (mut robot, mut scenario, mut instruments) = (None, self.quiet(), None);
        match kind {
            DisturbanceKind::Push => {
                let [first, last] = PUSHED;
                let time = first + (last - first) * random.unit();
                scenario.pushes.push(Push {
                    time,
                    duration: PUSHING,
                    impulse: size * random.symmetric(),
                    direction: 0.0,
                });
            }
            DisturbanceKind::Mass => {
                let mut other = self.scene.robot.clone();
                for inertial in other.description.links.iter_mut().filter_map(|link| link.inertial.as_mut()) {
                    let factor = 1.0 + size * random.symmetric();
                    inertial.mass *= factor;
                    inertial.inertia = inertial.inertia.map(|x| x * factor);
                }
                robot = Some(other);
            }
            DisturbanceKind::Slope => {
                let slope = scenario.world.slope + size * random.symmetric();
                robot = Some(in_world(self.scene.robot.clone(), &World { slope, ..scenario.world }));
            }
            DisturbanceKind::Height => {
                // The same for all sizes: as many as there can be steps.
                let steps = scenario.events.as_ref().and_then(|events| events.steps).unwrap_or(0);
                scenario.rises = (0..=steps).map(|_| size * random.symmetric()).collect();
            }
            DisturbanceKind::Noise => {
                instruments = Some(Instruments { period: PERIOD, late: 0, noise: [size, 10.0 * size] });
            }
            DisturbanceKind::Delay => {
                let late = (size / PERIOD).round() as usize;
                instruments = Some(Instruments { period: PERIOD, late, noise: [0.0; 2] });
            }
        }
        let walker = robot.map(|robot| walker_for(&robot, &scenario, false)).transpose()?;
        Ok(Met { walker, scenario, instruments, seed })
    }

    fn walk(&self, met: &Met, chosen: bool) -> Ended {
        let Self { scene: Scene { plant, .. }, gait, .. } = self;
        let walker = met.walker.as_ref().unwrap_or(self.walker);
        let walking = walker.walking(plant, &met.scenario);
        let walk = |controller: &mut dyn Controller<f64>, present: Present| {
            let ending = gait.ending(present);
            let ending = ending.as_ref().map(|ending| ending as &LandingGuard<'_>);
            ended(met.instrumented(controller, &walking, ending))
        };
        if chosen {
            return self.choosers.walk(gait, walk).map_err(|error| error.message)?.0;
        }
        walk(&mut gait.controller.clone(), Rc::new(RefCell::new(gait.values().to_vec())))
    }
}

impl Met {
    fn instrumented(
        &self,
        controller: &mut dyn Controller<f64>,
        walking: &Walking<'_>,
        ending: Option<&LandingGuard<'_>>,
    ) -> Result<WalkSummary, Diagnostic> {
        // A trial is short: an interruption waits for it.
        let (mut row, progress, stop) = (|_: &[f64]| Ok(()), |_: f64| (), || false);
        let mut run = Run { row: &mut row, progress: &progress, stop: &stop };
        match self.instruments {
            Some(instruments) => {
                let sampled = Sampled::new(Borrowed(controller), instruments, self.seed ^ 0x5eed);
                walking.run_until(sampled, ending, &mut run, &mut |_| ())
            }
            None => walking.run_until(Borrowed(controller), ending, &mut run, &mut |_| ()),
        }
    }
}

/// All steps, or why not.
fn ended(walked: Result<WalkSummary, Diagnostic>) -> Ended {
    match walked {
        Ok(summary) => match (summary.end, summary.verdict) {
            (WalkEnd::Steps, _) => Ok(()),
            (_, Some(verdict)) => Err(format!("{} in `{}`", verdict.meaning, verdict.phase)),
            (WalkEnd::Interrupted, None) => Err("interrupted".to_owned()),
            (_, None) => Err("does not get on".to_owned()),
        },
        // Without time and phase, so that equal reasons are counted together.
        Err(error) => {
            let why = error.message.rsplit(": ").next().unwrap_or_default();
            let timed = why.strip_prefix("at ").and_then(|rest| rest.split_once(" s "));
            Err(timed.map_or(why, |(_, why)| why).to_owned())
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A robot of twice the size has eight times the mass: pushes are eight times √2 as large, heights twice.
    #[test]
    fn usual_sizes_are_those_of_a_robot_as_large() {
        let of = |kind: DisturbanceKind, by: f64| kind.usual([20.0 * by.powi(3), 0.7 * by, 9.81]);
        assert_eq!([of(DisturbanceKind::Push, 1.0), of(DisturbanceKind::Height, 1.0)], [5.2, 0.0049]);
        for by in [0.25, 0.5, 2.0] {
            let push = of(DisturbanceKind::Push, by) / of(DisturbanceKind::Push, 1.0);
            assert!((push / by.powf(3.5) - 1.0).abs() < 0.1, "{push}");
            let height = of(DisturbanceKind::Height, by) / of(DisturbanceKind::Height, 1.0);
            assert!((height / by - 1.0).abs() < 0.1, "{height}");
            for kind in [DisturbanceKind::Mass, DisturbanceKind::Slope, DisturbanceKind::Noise] {
                assert_eq!(of(kind, by), of(kind, 1.0));
            }
        }
    }
}
