//! From an identification to a proposal whose error is measured.
use super::Workbench;
use crate::amendment::Proposal;
use crate::amendment::history::{BeforeAfter, ChannelError};
use crate::amendment::identification::Identification;
use crate::comparison;
use bipedc_analysis::compare::Comparison;
use bipedc_analysis::measure;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};

impl Workbench {
    /// What an identification proposes, with the error before and after on the log that judged it (else on the first that
    /// taught), as a comparison measures it. Where that log cannot be compared the proposal says so and has no error.
    ///
    /// # Errors
    /// As [`Identification::propose`].
    pub fn proposal_of(&self, found: &Identification, origin: &str) -> Result<Proposal, Diagnostic> {
        let mut proposal = found.propose(&self.robot.description, origin)?;
        let Some((file, held_out)) = found.judge() else { return Ok(proposal) };
        match self.falls(&proposal, file) {
            Ok(mut error) => {
                if !held_out {
                    error.training = error.held_out.take();
                }
                proposal.errors.push(error);
            }
            Err(_) => {
                let note = format!("the error is not known: {file} cannot be compared as it stands");
                proposal.note = Some(note);
            }
        }
        Ok(proposal)
    }

    /// The error on a log before and after a proposal, both at the filter that fits best after it.
    fn falls(&self, proposal: &Proposal, file: &str) -> Result<ChannelError, Diagnostics> {
        let log = self.log(file)?;
        let compared = self.with(proposal)?.compare(&log)?;
        let cutoff_hz = (compared.cutoff_hz > 0.0).then_some(compared.cutoff_hz);
        let reading = measure::Options { cutoff_hz, ..measure::Options::default() };
        let before = self.compare_with(&log, &comparison::Options { reading, ..Default::default() })?;
        Ok(ChannelError {
            channel: "effort".to_owned(),
            unit: compared.unit.clone(),
            held_out: Some(BeforeAfter { before: before.rms, after: compared.rms }),
            training: None,
            noise: noise(&compared),
        })
    }
}

/// Of all channels together.
fn noise(compared: &Comparison) -> f64 {
    let squares = compared.channels.iter().map(|channel| (channel.samples as f64, channel.noise));
    let (count, sum) =
        squares.fold((0.0, 0.0), |(count, sum), (n, noise)| (count + n, sum + n * noise * noise));
    if count > 0.0 { (sum / count).sqrt() } else { 0.0 }
}
