//! `bipedc completions`: what a shell needs to complete commands, options and files.
use crate::Cli;
use crate::terminal::failure::Outcome;
use crate::terminal::output;
use clap::{Args, CommandFactory};
use clap_complete::{Shell, generate};
use serde_json::json;
use std::process::ExitCode;

const EXAMPLES: &str = "\
Examples:
  bipedc completions bash > ~/.local/share/bash-completion/completions/bipedc
  bipedc completions zsh > ~/.zfunc/_bipedc          with ~/.zfunc in fpath
  bipedc completions fish > ~/.config/fish/completions/bipedc.fish

A new shell then completes commands, options, kinds and files at the tabulator key.

JSON: {\"shell\", \"script\"}.";

/// Print a script with which a shell completes commands and options
#[derive(Args)]
#[command(after_help = EXAMPLES)]
pub struct Completions {
    /// Whose script
    #[arg(value_enum)]
    shell: Shell,
    /// Print the script as a string of JSON
    #[arg(long)]
    json: bool,
}

impl Completions {
    /// Prints.
    pub fn run(self) -> Outcome {
        let mut script = Vec::new();
        generate(self.shell, &mut Cli::command(), "bipedc", &mut script);
        let script = String::from_utf8_lossy(&script);
        match self.json {
            true => output::print_json(&json!({ "shell": self.shell.to_string(), "script": script }))?,
            false => output::print(&script)?,
        }
        Ok(ExitCode::SUCCESS)
    }
}
