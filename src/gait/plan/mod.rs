//! Plans of a gait: the fewest steps to a speed (thesis 6.23, figures 7.3 and 7.6).
mod energies;
mod figure;
mod phased;
mod text;

use super::choice::not_chosen;
use super::over::{Over, Range};
use super::{Assignment, GaitBench, Parametrised, impossible_speed};
use crate::progress::Run;
use bipedc_analysis::gait::{Assumptions, Choices, Plan, PlannedStep, Unreached, Watch};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::magnitude;
use serde::Serialize;
use std::collections::BTreeMap;

/// Most combinations of values that a plan may choose from.
pub const MOST_CHOICES: usize = 500;
/// Values of each parameter if nothing else is asked for, by the number of parameters.
const VALUES: [usize; 3] = [41, 13, 6];
/// Most steps of a plan.
pub const MOST_STEPS: usize = 100;

/// What plans are asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PlanOptions {
    /// Speeds φ̇_m of the present step, per s; a plan each.
    pub from_speeds: Vec<f64>,
    /// The wished speed, per s; 0: to rest at the dead centre.
    pub to: f64,
    /// Parameters that no step changes, where they are not the gait's own.
    pub set: Vec<Assignment>,
    /// Parameters of the present step, where they are not the gait's own.
    pub from: Vec<Assignment>,
    /// Parameters that steps choose, with the values that ends of ways have; none: all that are not set, within their bounds.
    pub over: Vec<Over>,
    /// Most steps.
    pub most: usize,
    /// Every step is taken as one among its own kind, as the thesis does.
    pub alike: bool,
    /// What has to hold in every step beside that it passes its dead centre.
    pub assume: Assumptions,
}

/// Plans from several speeds to one. As text and as JSON they are what `bipedc gait steps` and `bipedc gait capture` print.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Plans {
    /// Name of the gait.
    pub gait: String,
    /// Of the robot.
    pub robot: String,
    /// Unit of all speeds.
    pub speed_unit: String,
    /// The wished speed.
    pub to: f64,
    /// Every step is taken as one among its own kind.
    pub alike: bool,
    /// Parameters of the present step; none count if steps are alike.
    pub from: BTreeMap<String, f64>,
    /// Parameters that steps choose.
    pub choices: Vec<Choice>,
    /// No plan is missing.
    pub complete: bool,
    /// One for each speed.
    pub plans: Vec<SpeedPlan>,
    /// What lies beyond its bounds.
    #[serde(skip)]
    pub messages: Vec<Diagnostic>,
}

/// A parameter that each step chooses.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Choice {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Smallest and largest value.
    pub bounds: [f64; 2],
    /// Number of values that ends of ways have.
    pub values: usize,
}

/// The way from one speed.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SpeedPlan {
    /// φ̇_m of the present step.
    pub from_speed: f64,
    /// The fewest steps; none: the speed is not reached.
    pub steps: Option<usize>,
    /// Why it is not.
    pub reason: Option<String>,
    /// The same in one word.
    pub reason_code: Option<&'static str>,
    /// Step after step.
    pub plan: Vec<StepOfPlan>,
    /// Lowest and highest speed after one step, after two, ….
    pub reach: Vec<[f64; 2]>,
}

/// A step of a plan.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepOfPlan {
    /// Of all parameters.
    pub parameters: BTreeMap<String, f64>,
    /// φ̇_m.
    pub speed: f64,
    /// E, (kg m²/s)².
    pub energy: f64,
}

impl GaitBench {
    /// The fewest steps from each speed to the wished one.
    ///
    /// # Errors
    /// Parameters that the gait does not have, ranges and speeds that are none, too many choices; a present step that is none.
    pub fn plans(&self, options: &PlanOptions, run: &Run<'_>) -> Result<Plans, Diagnostics> {
        if self.depends_on_start() {
            let message =
                format!("the gait `{}` has no plans: what it wants depends on phase_start", self.gait.name);
            let help = "then the end of a step depends on all steps before it; write its formulas with phase and phase_end alone";
            return Err(Diagnostic::error(message).help(help).into());
        }
        self.check_assumptions(options.assume)?;
        let (choices, now) = self.choices(options)?;
        let model = self.model()?;
        let kept = model.keeping(options.assume);
        let most = options.most.clamp(1, MOST_STEPS);
        let plans = if options.alike {
            let alike = run.progress.counted("steps of all choices", |advance| {
                model.alike(&choices, kept, &Watch { advance, stop: run.stop })
            });
            alike.map(|alike| self.each_plan(options, run, |speed| Some(alike.plan(speed, options.to, most))))
        } else {
            let reach = run.progress.counted("steps between choices", |advance| {
                model.reach(&now, &choices, kept, &Watch { advance, stop: run.stop })
            });
            let reach = reach.map_err(|why| {
                Diagnostic::error(format!("the present step is none: {why}"))
                    .help("name other parameters of the present step by --from")
            })?;
            reach.map(|reach| self.each_plan(options, run, |speed| Some(reach.plan(speed, options.to, most))))
        };
        Ok(self.planned(options, (&choices, &now), plans.unwrap_or_default()))
    }
}

/// What plans of all gaits have in common.
trait Planning: Parametrised {
    fn planned(
        &self,
        options: &PlanOptions,
        (choices, now): (&Choices, &[f64]),
        plans: Vec<SpeedPlan>,
    ) -> Plans {
        let mut messages = self.outside(now, " of the present step");
        messages.extend(self.outside(&choices.values, ""));
        Plans {
            gait: self.gait_name().to_owned(),
            robot: self.robot_name().to_owned(),
            speed_unit: self.speed_unit(),
            to: options.to,
            alike: options.alike,
            from: self.named(now),
            choices: choices.axes.iter().map(|(index, values)| self.choice(*index, values)).collect(),
            complete: plans.len() == options.from_speeds.len(),
            plans,
            messages,
        }
    }

    fn each_plan(
        &self,
        options: &PlanOptions,
        run: &Run<'_>,
        plan: impl Fn(f64) -> Option<Plan>,
    ) -> Vec<SpeedPlan> {
        let count = options.from_speeds.len();
        run.progress.counted("planning", |advance| {
            let mut plans = Vec::with_capacity(count);
            for &speed in &options.from_speeds {
                if (run.stop)() {
                    break;
                }
                let Some(found) = plan(speed) else { break };
                plans.push(self.speed_plan(speed, options.to, found));
                advance(plans.len() as f64 / count as f64);
            }
            plans
        })
    }

    fn speed_plan(&self, from_speed: f64, to: f64, plan: Plan) -> SpeedPlan {
        let unit = self.speed_unit();
        let step = |PlannedStep { parameters, speed, energy }: &PlannedStep| StepOfPlan {
            parameters: self.named(parameters),
            speed: *speed,
            energy: *energy,
        };
        let steps = plan.steps.as_ref().map(Vec::len).ok();
        let why = plan.steps.as_ref().err();
        SpeedPlan {
            from_speed,
            steps,
            reason: why.map(|why| in_words(why, to, &unit)),
            reason_code: why.map(Unreached::code),
            plan: plan.steps.iter().flatten().map(step).collect(),
            reach: plan.reach,
        }
    }

    /// What steps choose from, and the parameters of the present one.
    fn choices(&self, options: &PlanOptions) -> Result<(Choices, Vec<f64>), Diagnostics> {
        self.check_speeds(&options.from_speeds)?;
        if !(0.0..=magnitude::LARGEST).contains(&options.to) {
            let help = format!("write a speed at mid-stance, 0 or more, in {}", self.speed_unit());
            return Err(Diagnostic::error(impossible_speed(options.to)).help(help).into());
        }
        let values = self.with(&self.defaults(), &options.set)?;
        let now = self.with(&values, &options.from)?;
        let fixed: Vec<&str> = options.set.iter().map(|(name, _)| name.as_str()).collect();
        let over = if options.over.is_empty() { self.free(&fixed)? } else { options.over.clone() };
        let axes = self.axes(&over, &fixed)?;
        let count = axes.iter().fold(1_usize, |count, (_, values)| count.saturating_mul(values.len()));
        if count > MOST_CHOICES {
            let message = format!("{count} combinations of parameters are too many");
            let help = format!("give fewer values to --over: at most {MOST_CHOICES} combinations in all");
            return Err(Diagnostic::error(message).help(help).into());
        }
        Ok((Choices { values, axes }, now))
    }

    /// All parameters that are not fixed, over their bounds.
    fn free(&self, fixed: &[&str]) -> Result<Vec<Over>, Diagnostic> {
        let free = self.parameters().iter().filter(|parameter| !fixed.contains(&parameter.name.as_str()));
        // Bounds of one value leave nothing to choose.
        let free: Vec<_> = free.filter(|parameter| parameter.bounds[0] < parameter.bounds[1]).collect();
        let Some(&count) = VALUES.get(free.len().wrapping_sub(1)) else {
            return Err(not_chosen(free.len(), "name one to three of them by --over NAME=A:B:N"));
        };
        let over = |parameter: &&bipedc_compiler::description::gait::GaitParameter| {
            let [low, high] = parameter.bounds;
            Over { name: parameter.name.clone(), range: Range { low, high, count } }
        };
        Ok(free.iter().map(over).collect())
    }

    fn choice(&self, index: usize, values: &[f64]) -> Choice {
        let parameter = self.parameter(index);
        let ends = [values.first(), values.last()].map(|x| x.copied().unwrap_or(f64::NAN));
        Choice {
            name: parameter.name.clone(),
            unit: parameter.unit.clone(),
            bounds: ends,
            values: values.len(),
        }
    }
}

impl<B: Parametrised> Planning for B {}

fn in_words(why: &Unreached, to: f64, unit: &str) -> String {
    match why {
        Unreached::Falls(0) => {
            "every first step within the ranges falls back before its dead centre".to_owned()
        }
        Unreached::Falls(1) => "after one step every further one falls back".to_owned(),
        Unreached::Falls(count) => format!("after {count} steps every further one falls back"),
        Unreached::NotKept(0) => {
            "every first step within the ranges falls back or breaks what is assumed".to_owned()
        }
        Unreached::NotKept(1) => {
            "after one step every further one falls back or breaks what is assumed".to_owned()
        }
        Unreached::NotKept(count) => {
            format!("after {count} steps every further one falls back or breaks what is assumed")
        }
        Unreached::NotMade(0, _, why) => format!("no first step within the ranges is made: {why}"),
        Unreached::NotMade(1, _, why) => format!("after one step no further one is made: {why}"),
        Unreached::NotMade(count, _, why) => format!("after {count} steps no further one is made: {why}"),
        Unreached::TooFast(high) => {
            format!("{to} {unit} is too fast: steps within the ranges reach {high:.6} {unit} at most")
        }
        Unreached::TooSlow(low) => {
            format!("{to} {unit} is too slow: steps within the ranges reach {low:.6} {unit} at least")
        }
        Unreached::NoWay => format!(
            "speeds on both sides of {to} {unit} can be reached, but every way between them has a step that is not possible"
        ),
    }
}
