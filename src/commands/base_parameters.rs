//! `bipedc inspect ROBOT base-parameters`: which parameters matter, in exact arithmetic.
use crate::terminal::arguments::RobotArguments;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use crate::terminal::progress::spin;
use bipedc_compiler::exact::{Model, ParameterList, Question};
use bipedc_effects::diagnostic::Diagnostic;
use clap::Args;
use std::process::ExitCode;

/// The question about base parameters.
#[derive(Args)]
#[command(next_help_heading = "For `base-parameters`")]
pub struct BaseParametersArguments {
    /// The model whose base parameters are wanted
    #[arg(long, value_name = "MODEL", value_parser = ["com", "zmp", "dynamics", "energy"])]
    of: Option<String>,
    /// Rows of the model: com x,y,z; zmp Fx,Fy,Fz,Mx,My,Mz; dynamics base,joints or single rows; energy
    /// total,kinetic,potential
    #[arg(long, value_name = "ROWS", value_delimiter = ',')]
    rows: Vec<String>,
    /// All feet but the root stay parallel to the ground
    #[arg(long)]
    feet_flat: bool,
    /// Parameters per link [default: 4 for com, else 10]
    #[arg(long, value_name = "LIST", value_parser = ["4", "10", "16"])]
    parameters: Option<String>,
}

impl BaseParametersArguments {
    /// The options mean nothing for other things.
    pub fn refuse(&self) -> Result<(), Diagnostic> {
        if self.of.is_none() && self.rows.is_empty() && !self.feet_flat && self.parameters.is_none() {
            return Ok(());
        }
        Err(Diagnostic::error("--of, --rows, --feet-flat and --parameters are about base parameters")
            .help("bipedc inspect ROBOT base-parameters --of com|zmp|dynamics|energy"))
    }

    /// Answers the question.
    pub fn run(&self, robot: &RobotArguments, json: bool) -> Outcome {
        let Some(of) = &self.of else {
            return Err(Diagnostic::error("base parameters of what?")
                .help("--of com|zmp|dynamics|energy")
                .into());
        };
        // The root is a part of the question; the base's kind is a part of the robot.
        let read =
            RobotArguments { path: robot.path.clone(), base: robot.base.clone(), root: None }.read()?;
        let list = self.parameters.as_deref().map(|list| match list {
            "4" => ParameterList::FirstMoments,
            "16" => ParameterList::Thesis16,
            _ => ParameterList::Standard,
        });
        let question = Question {
            root: robot.root.clone(),
            rows: self.rows.clone(),
            feet_flat: self.feet_flat,
            list,
            ..Question::new(of.parse::<Model>()?)
        };
        let answer = spin("eliminating in exact arithmetic", || question.answer(&read.description))?;
        if json {
            output::print_json(&answer)?;
        } else {
            output::print(&answer.to_string())?;
        }
        Ok(ExitCode::SUCCESS)
    }
}
