//! From an identification to a proposal whose error is measured.
use super::Workbench;
use crate::amendment::history::{BeforeAfter, ChannelError};
use crate::amendment::identification::Identification;
use crate::amendment::{Proposal, Proposed, comments};
use crate::comparison;
use bipedc_analysis::compare::Comparison;
use bipedc_analysis::measure;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};

/// A body that is left out because it may be as described must not cost more than this part of the error.
const COST: f64 = 0.01;

/// A log's file, and the filter (Hz) that was asked for.
type On<'a> = (&'a str, Option<f64>);
/// An error, and the filter (Hz) behind which it holds.
type Filtered = (ChannelError, Option<f64>);

impl Workbench {
    /// What an identification proposes, with the error before and after on the log that judged it (else on the first that
    /// taught), as a comparison measures it. What is zero within its error bars is left out, which the note says; a body only if
    /// the error does without it. Where that log cannot be compared the proposal says so and has no error.
    ///
    /// # Errors
    /// As [`Identification::propose`].
    pub fn proposal_of(&self, found: &Identification, origin: &str) -> Result<Proposal, Diagnostic> {
        let mut proposal = found.propose(&self.robot.description, origin)?;
        let Some((file, held_out)) = found.judge() else { return Ok(self.without_nothing(&proposal, false)) };
        proposal = self.without_nothing(&proposal, false);
        let asked_hz = found.cutoff_hz();
        match self.falls(&proposal, (file, asked_hz)) {
            Ok(error) => {
                let (smaller, (mut error, cutoff_hz)) = self.as_good(&proposal, (file, asked_hz), error);
                proposal = smaller;
                proposal.cutoff_hz = cutoff_hz;
                if !held_out {
                    error.training = error.held_out.take();
                }
                proposal.errors.push(error);
            }
            Err(_) => {
                let note = format!("the error is not known: {file} cannot be compared as it stands");
                proposal.note = Some(proposal.note.map_or(note.clone(), |said| format!("{note}; {said}")));
            }
        }
        Ok(proposal)
    }

    /// The same without bodies that may be as described, if the error does without them: numbers of a link that are zero one by
    /// one may count together.
    fn as_good(&self, whole: &Proposal, on: On<'_>, error: Filtered) -> (Proposal, Filtered) {
        let after = |(error, _): &Filtered| error.held_out.map_or(f64::INFINITY, |fall| fall.after);
        let part = self.without_nothing(whole, true);
        match (part.effects.len() < whole.effects.len()).then(|| self.falls(&part, on)) {
            Some(Ok(found)) if after(&found) <= (1.0 + COST) * after(&error) => (part, found),
            _ => (whole.clone(), error),
        }
    }

    /// A proposal without what may be nothing at joints, and at links too if that is wanted.
    fn without_nothing(&self, whole: &Proposal, links: bool) -> Proposal {
        let goes = |proposed: &&Proposed| {
            (links || proposed.effect.location.link.is_none())
                && Identification::may_be_nothing(proposed, &self.robot.description)
        };
        let (out, stays): (Vec<&Proposed>, Vec<&Proposed>) = whole.effects.iter().partition(goes);
        let titles: Vec<String> = out.iter().map(|proposed| comments::title(&proposed.effect)).collect();
        let effects = stays.into_iter().cloned().collect();
        let note = match (&whole.note, titles.join(", ")) {
            (note, titles) if titles.is_empty() => note.clone(),
            (None, titles) => Some(format!("left out, as zero within 95 % intervals: {titles}")),
            (Some(note), titles) => Some(format!("{note}, {titles}")),
        };
        Proposal { effects, note, ..whole.clone() }
    }

    /// The error on a log before and after a proposal, both at the filter that was asked for, else at the one that fits best
    /// after it.
    fn falls(&self, proposal: &Proposal, (file, asked_hz): On<'_>) -> Result<Filtered, Diagnostics> {
        let log = self.log(file)?;
        let at = |cutoff_hz| {
            let reading = measure::Options { cutoff_hz, ..measure::Options::default() };
            comparison::Options { reading, ..comparison::Options::default() }
        };
        let compared = self.with(proposal)?.compare_with(&log, &at(asked_hz))?;
        let cutoff_hz = (compared.cutoff_hz > 0.0).then_some(compared.cutoff_hz);
        let before = self.compare_with(&log, &at(cutoff_hz))?;
        let error = ChannelError {
            channel: "effort".to_owned(),
            unit: compared.unit.clone(),
            held_out: Some(BeforeAfter { before: before.rms, after: compared.rms }),
            training: None,
            noise: noise(&compared),
        };
        Ok((error, cutoff_hz))
    }
}

/// Of all channels together.
fn noise(compared: &Comparison) -> f64 {
    let squares = compared.channels.iter().map(|channel| (channel.samples as f64, channel.noise));
    let (count, sum) =
        squares.fold((0.0, 0.0), |(count, sum), (n, noise)| (count + n, sum + n * noise * noise));
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}
