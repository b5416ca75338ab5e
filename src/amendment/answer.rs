//! Answers of other commands, as files that a proposal can be made of.
use super::files::read_text;
use super::identification::Identification;
use bipedc_analysis::diagnose::Diagnosis;
use bipedc_effects::diagnostic::Diagnostic;
use serde::de::DeserializeOwned;
use std::path::Path;

/// What somebody found out about a robot.
#[derive(Debug, Clone)]
pub enum Answer {
    /// `bipedc diagnose --json`
    Diagnosis(Box<Diagnosis>),
    /// `bipedc identify --json`
    Identification(Box<Identification>),
}

impl Answer {
    /// Reads a file.
    ///
    /// # Errors
    /// No such file, or the JSON of neither: with its place.
    pub fn read(path: &Path) -> Result<Self, Diagnostic> {
        let Some(text) = read_text(path)? else {
            return Err(Diagnostic::error("there is no such file")
                .in_file(path)
                .help("bipedc diagnose ROBOT LOG.csv --json > diagnosis.json writes one"));
        };
        let value: serde_json::Value = parsed(&text, "diagnosis", path)?;
        if value.get("effects").is_some() {
            return Ok(Self::Diagnosis(parsed(&text, "diagnosis", path)?));
        }
        if value.get("physical").is_some() {
            return Ok(Self::Identification(parsed(&text, "identification", path)?));
        }
        Err(Diagnostic::error(
            "the file is no diagnosis (it has no `effects`) and no identification (`physical`)",
        )
        .in_file(path)
        .help("give the output of bipedc diagnose --json or bipedc identify --json"))
    }
}

fn parsed<T: DeserializeOwned>(text: &str, what: &str, path: &Path) -> Result<T, Diagnostic> {
    serde_json::from_str(text).map_err(|error| {
        Diagnostic::error(format!("the file is no {what}: {error}"))
            .in_file(path)
            .at(error.line(), error.column())
            .help("give the output of bipedc diagnose --json or bipedc identify --json")
    })
}
