//! The loop by itself: diagnose, write one effect after the other into the description, look again.
use super::Workbench;
use crate::amendment::diagnosis::{Selection, propose};
use crate::amendment::{Amended, description_path};
use crate::diagnosis::{self, Diagnosed, Inertial};
use crate::measurements::Log;
use bipedc_analysis::diagnose::Stated;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::Effect;

/// Most searches: what stands changes what is left, but not for ever.
const ROUNDS: usize = 4;

/// What becomes known on the way.
#[derive(Debug, Clone, Copy)]
pub enum Event<'a> {
    /// What is odd about the logs.
    Warnings(&'a [Diagnostic]),
    /// A step that was written.
    Step(&'a Amended),
}

/// A description that was explained as far as it goes.
#[derive(Debug, Clone)]
pub struct Explained {
    /// The last search.
    pub last: Diagnosed,
    /// How many there were.
    pub searches: usize,
}

impl Explained {
    /// Whether the last search found nothing more.
    pub fn is_complete(&self) -> bool {
        self.last.effects.is_empty() && self.last.inertial_corrections.is_empty()
    }
}

impl Workbench {
    /// Amends the description step by step until a diagnosis of what it then says finds nothing more; `tell` hears of every step
    /// and may end it all by an error.
    ///
    /// The last step of a search has the parameters of that search, so that the description becomes what one diagnosis
    /// and one amendment would have made; the steps before it have those that were best without the later effects.
    ///
    /// # Errors
    /// As [`Workbench::diagnose`] and [`Workbench::amend`]; steps that were written stay.
    pub fn explain(
        &self,
        (train, judge): (&Log, Option<&Log>),
        options: &diagnosis::Options,
        tell: &mut dyn FnMut(Event<'_>) -> Result<(), Diagnostics>,
    ) -> Result<Explained, Diagnostics> {
        // Better now than after the search.
        description_path(&self.path)?;
        let mut searches = 0;
        loop {
            let bench = if searches == 0 { self.clone() } else { self.reopened()? };
            let last = bench.diagnose_with(train, judge, options)?;
            if searches == 0 {
                tell(Event::Warnings(&last.warnings))?;
            }
            searches += 1;
            let explained = Explained { last, searches };
            if explained.is_complete() {
                return Ok(explained);
            }
            let last = &explained.last;
            let order: Vec<Effect> = last.steps.iter().map(|step| step.effect.clone()).collect();
            // Inertial corrections belong to all effects together: then there are no steps between.
            let between = if last.inertial_corrections.is_empty() { 1..order.len() } else { 0..0 };
            let options = diagnosis::Options { inertial: Inertial::Known, report: false, ..options.clone() };
            for count in between {
                let (robot, logs) = (&bench.robot, (train, judge));
                let progress = &*self.progress;
                let partial =
                    diagnosis::estimate(robot, (&order[..count], Stated::Start), logs, &options, progress)?;
                self.take(&partial, tell)?;
            }
            self.take(last, tell)?;
            if searches == ROUNDS {
                return Ok(explained);
            }
        }
    }

    /// One step of the history.
    fn take(
        &self,
        answer: &Diagnosed,
        tell: &mut dyn FnMut(Event<'_>) -> Result<(), Diagnostics>,
    ) -> Result<(), Diagnostics> {
        let proposal = propose(answer, &Selection::default(), "diagnose --until-explained")?;
        let amended = self.amend_with(&proposal, false)?;
        tell(Event::Step(&amended))
    }
}
