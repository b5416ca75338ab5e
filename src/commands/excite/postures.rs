//! `bipedc excite ROBOT --postures N`: static postures on two feet from which first moments can be told.
use bipedc::excitation::{Options, PostureOptions};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::Ledger;
use clap::Args;
use std::path::PathBuf;

/// What only postures have.
#[derive(Args)]
#[command(next_help_heading = "Static postures")]
pub struct PostureArguments {
    /// Design so many static postures with both feet flat instead of a trajectory
    #[arg(long, value_name = "N")]
    postures: Option<usize>,
    /// Foot placements that the postures share [default: a fifth of the postures]
    #[arg(long, value_name = "K", requires = "postures")]
    placements: Option<usize>,
    /// Foot that stays where it is [default: the right one]
    #[arg(long, value_name = "FOOT", requires = "postures")]
    stance: Option<String>,
    /// Least distance of the expected centre of pressure from the edge of the support, m
    #[arg(long, value_name = "M", allow_negative_numbers = true, default_value_t = 0.02)]
    stability: f64,
    /// How wrong the described masses may be, per cent: robots so perturbed must stand too
    #[arg(long, value_name = "PERCENT", allow_negative_numbers = true, default_value_t = 10.0)]
    mass_error: f64,
    /// How wrong the described centres of mass may be, m
    #[arg(long, value_name = "M", allow_negative_numbers = true, default_value_t = 0.01)]
    center_error: f64,
    /// Draw placements and centres of pressure from above
    #[arg(long, value_name = "FILE.svg", requires = "postures")]
    plot: Option<PathBuf>,
}

/// Evaluations of the cost in one start unless somebody says otherwise.
const EVALUATIONS: usize = 2000;

impl PostureArguments {
    /// Notes the drawing among what is written.
    ///
    /// # Errors
    /// It would overwrite an input or another output.
    pub fn note(&self, ledger: &mut Ledger) -> Result<(), Diagnostic> {
        self.plot.as_ref().map_or(Ok(()), |plot| ledger.writes("--plot", plot))
    }

    /// What is asked for, if it is postures; the rest of it as for trajectories.
    pub fn options(&self, motion: &Options, evaluations: Option<usize>) -> Option<PostureOptions> {
        let request = &motion.request;
        Some(PostureOptions {
            postures: self.postures?,
            placements: self.placements,
            stance: self.stance.clone(),
            stability: self.stability,
            mass_error: self.mass_error,
            center_error: self.center_error,
            margin: request.margin,
            gap: motion.gap,
            criterion: request.criterion,
            seed: request.seed,
            starts: request.starts,
            evaluations: evaluations.unwrap_or(EVALUATIONS),
            time_limit: request.time_limit,
            plot: self.plot.clone(),
        })
    }
}
