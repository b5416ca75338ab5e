//! `bipedc excite ROBOT --separate A B`: the motion that best tells two effects apart.
use bipedc::excitation::SeparateOptions;
use clap::Args;

/// What only the separation of effects has.
#[derive(Args)]
#[command(next_help_heading = "Telling effects apart")]
pub struct SeparateArguments {
    /// Look for the motion that best tells two effects apart (bipedc effects lists them)
    #[arg(long, value_names = ["EFFECT_A", "EFFECT_B"], num_args = 2, conflicts_with = "postures")]
    separate: Vec<String>,
    /// Joint of the effects; two joints: of the first and of the second
    #[arg(long, value_name = "J", value_delimiter = ',', requires = "separate")]
    joint: Vec<String>,
    /// The joint whose motion causes a coupling
    #[arg(long, value_name = "K", requires = "separate")]
    other_joint: Option<String>,
    /// Link of the effects; two links: of the first and of the second
    #[arg(long, value_name = "LINK", value_delimiter = ',', requires = "separate")]
    link: Vec<String>,
    /// Let the bodies' inertial parameters be free too: what they can do tells nothing
    #[arg(long, requires = "separate")]
    beside_bodies: bool,
    /// Standard deviation of a measured torque, N m
    #[arg(long, value_name = "NM", allow_negative_numbers = true, default_value_t = 0.1)]
    noise: f64,
}

impl SeparateArguments {
    /// What is asked for, if two effects were named.
    pub fn options(&self) -> Option<SeparateOptions> {
        let [first, second] = self.separate.as_slice() else { return None };
        Some(SeparateOptions {
            effects: [first.clone(), second.clone()],
            joints: self.joint.clone(),
            other_joint: self.other_joint.clone(),
            links: self.link.clone(),
            beside_bodies: self.beside_bodies,
            noise: self.noise,
        })
    }
}
