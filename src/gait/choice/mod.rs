//! Parameters of a gait chosen while it walks: at mid-stance, from the measured state, so that the next step has a wished speed (thesis 6.23).
mod foresight;
mod notes;
mod phased;
mod phased_walking;
mod stance;
mod walking;

pub use foresight::{Foresight, KnownRobot, Passed};
pub use notes::{Present, StepPart, StepSpeed};
pub use phased::{PhasedChoices, PhasedChooser};
pub use phased_walking::PhasedChoosing;
pub use walking::Choosing;

use super::{GaitBench, Parametrised, PhasedBench};
use crate::progress::Run;
use bipedc_analysis::gait::{Assumptions, ChoiceSettings, Choices, Chooser, GaitModel, Kept, Watch};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};

/// Values of each parameter on the grid, by the number of parameters, if nothing else is asked for.
const VALUES: [usize; 3] = [31, 9, 5];
/// Part of every limit that is left over unless something else is asked for.
const RESERVE: f64 = 0.05;
/// Most combinations of values.
pub const MOST_CHOICES: usize = 500;

/// What may be chosen for each step.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChoiceOptions {
    /// Parameters with their ranges; `None`: the gait's bounds. No parameters: all of them.
    pub parameters: Vec<(String, Option<[f64; 2]>)>,
    /// Which assumptions steps have to keep, by name; `None`: as many as there are limits for.
    pub keep: Option<Vec<String>>,
    /// Whether joints have stops in this walk.
    pub stops: bool,
    /// Whether this walk ends where a foot in the air scuffs.
    pub scuffing: bool,
    /// Coulomb's coefficient; `None`: that of the gait's limits.
    pub friction: Option<f64>,
    /// Part of every limit that is left over; `None`: a twentieth.
    pub reserve: Option<f64>,
    /// Values of each parameter on the grid that ways of several steps go over.
    pub values: Option<usize>,
}

impl GaitBench {
    /// Whether parameters of the gait can be chosen while it walks.
    ///
    /// # Errors
    /// Why they cannot.
    pub fn choosable(&self) -> Result<(), Diagnostic> {
        let refused = |why: &str, help: &str| {
            let message =
                format!("parameters of the gait `{}` cannot be chosen at mid-stance: {why}", self.gait.name);
            Err(Diagnostic::error(message).help(help))
        };
        if self.depends_on_start() {
            let help = "write its formulas with phase and phase_end alone";
            return refused("what it wants depends on phase_start", help);
        }
        if !self.gait.phase.impact_matching {
            let help = "a gait with impact_matching = true takes other parameters smoothly";
            return refused("without h_p the outputs would jump", help);
        }
        if self.gait.parameters.is_empty() {
            return refused("it has none", "give it [parameters]");
        }
        Ok(())
    }

    /// What choices are made from; the usual parameters are `values`.
    ///
    /// # Errors
    /// Parameters that the gait does not have, or too many; ranges that are none; a limit that the gait does not say.
    pub fn choice_settings(
        &self,
        values: &[f64],
        options: &ChoiceOptions,
    ) -> Result<ChoiceSettings, Diagnostics> {
        self.choosable()?;
        let choices = grid(self, values, options);
        let kept = self.kept(options);
        match (choices, kept) {
            (Ok(choices), Ok(kept)) => Ok(ChoiceSettings { choices, usual: values.to_vec(), kept }),
            (Err(Diagnostics(mut wrong)), kept) => {
                wrong.extend(kept.err());
                Err(Diagnostics(wrong))
            }
            (Ok(_), Err(error)) => Err(error.into()),
        }
    }

    fn kept(&self, options: &ChoiceOptions) -> Result<Kept, Diagnostic> {
        let friction = options.friction.or(self.gait.limits.friction);
        let has = |name: &str, usual: bool| {
            options.keep.as_ref().map_or(usual, |keep| keep.iter().any(|kept| kept == name))
        };
        let assumptions = Assumptions {
            friction: has("friction", friction.is_some()),
            pull: has("pull", true),
            clearance: has("clearance", options.scuffing),
            torque: has("torque", true),
            joints: has("joints", options.stops),
            velocity: has("velocity", false),
        };
        if assumptions.friction && friction.is_none() {
            let message = format!("the gait `{}` says no coefficient of friction to keep", self.gait.name);
            let help = "say `friction`, or leave it out of `keep`";
            return Err(Diagnostic::error(message).help(help));
        }
        let reserve = options.reserve.unwrap_or(RESERVE);
        Ok(Kept { assumptions, friction, reserve, off_stops: reserve })
    }
}

impl PhasedBench {
    /// What choices of a gait of several phases are made from; the usual parameters are `values`. What the walk assumes is kept, whatever it is.
    ///
    /// # Errors
    /// Parameters that the gait does not have, or too many; ranges that are none; limits that are chosen.
    pub fn choice_settings(
        &self,
        values: &[f64],
        options: &ChoiceOptions,
    ) -> Result<PhasedChoices, Diagnostics> {
        if options.keep.is_some() || options.friction.is_some() || options.reserve.is_some() {
            let message = "in a gait of several phases choices keep all that the scenario assumes";
            let help = "leave keep, friction and reserve out of [control.choice]; [assumptions] and the gait's [limits] say what is kept";
            return Err(Diagnostic::error(message).help(help).into());
        }
        if self.gait.parameters.is_empty() {
            let message = format!("the gait `{}` has no parameters to choose", self.gait.name);
            return Err(Diagnostic::error(message).help("give it [parameters]").into());
        }
        Ok(PhasedChoices { choices: grid(self, values, options)?, usual: values.to_vec() })
    }
}

/// The values that parameters are chosen from.
fn grid(of: &impl Parametrised, values: &[f64], options: &ChoiceOptions) -> Result<Choices, Diagnostics> {
    let (mut wrong, mut ranges) = (Vec::new(), Vec::new());
    let all = || of.parameters().iter().map(|parameter| (parameter.name.clone(), None)).collect();
    let named: Vec<(String, Option<[f64; 2]>)> =
        if options.parameters.is_empty() { all() } else { options.parameters.clone() };
    for (name, between) in &named {
        match of.index(name) {
            None => wrong.push(of.unknown(name)),
            Some(index) => {
                let [low, high] = between.unwrap_or(of.parameter(index).bounds);
                // Bounds of one value leave nothing to choose.
                if low < high {
                    ranges.push((index, [low, high]));
                }
            }
        }
    }
    if wrong.is_empty() {
        Ok(combinations(values, &ranges, options.values)?)
    } else {
        Err(Diagnostics(wrong))
    }
}

/// Said where no parameter can be chosen for each step, or too many.
pub(super) fn not_chosen(count: usize, help: &str) -> Diagnostic {
    match count {
        0 => Diagnostic::error("there is no parameter that could be chosen for each step")
            .help("leave out a --set, or give the gait [parameters.NAME] with bounds that its outputs name, such as a lean that is added to them (docs/gaits.md)"),
        _ => Diagnostic::error(format!("{count} parameters could be chosen for each step")).help(help),
    }
}

fn combinations(
    values: &[f64],
    ranges: &[(usize, [f64; 2])],
    count: Option<usize>,
) -> Result<Choices, Diagnostic> {
    let Some(&usual) = VALUES.get(ranges.len().wrapping_sub(1)) else {
        return Err(not_chosen(ranges.len(), "name one to three of them"));
    };
    let count = count.unwrap_or(usual);
    let all = count.saturating_pow(ranges.len() as u32);
    if all > MOST_CHOICES {
        let message = format!("{all} combinations of parameters are too many");
        let help = format!("ask for fewer values: at most {MOST_CHOICES} combinations in all");
        return Err(Diagnostic::error(message).help(help));
    }
    let axis = |&(index, [low, high]): &(usize, [f64; 2])| {
        let last = (count - 1) as f64;
        let at = |k: usize| if k + 1 == count { high } else { low + (high - low) * k as f64 / last };
        (index, (0..count).map(at).collect())
    };
    Ok(Choices { values: values.to_vec(), axes: ranges.iter().map(axis).collect() })
}

/// All steps between the values of a grid; `None`: an end was asked for.
pub fn chooser<'a, 'm>(
    model: &'m GaitModel<'a>,
    settings: ChoiceSettings,
    run: &Run<'_>,
) -> Option<Chooser<'a, 'm>> {
    run.progress.counted("steps between choices", |advance| {
        model.chooser(settings, &Watch { advance, stop: run.stop })
    })
}
