//! Errors and warnings about what a user wrote or measured, kept as data until they are shown.
use std::fmt;
use std::path::{Path, PathBuf};

/// How bad it is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// The input is usable; the user should know.
    Warning,
    /// The input has no meaning.
    Error,
}

/// One message: where, what is wrong, what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostic {
    /// Error or warning.
    pub severity: Severity,
    /// The file, if it came from one.
    pub file: Option<PathBuf>,
    /// Line and column, from 1 (column 0: unknown).
    pub position: Option<(usize, usize)>,
    /// What was wrong: names the thing, what was expected, what was found.
    pub message: String,
    /// What to do.
    pub help: Option<String>,
}

impl Diagnostic {
    /// An error without a place yet.
    pub fn error(message: impl Into<String>) -> Self {
        Self { severity: Severity::Error, file: None, position: None, message: message.into(), help: None }
    }
    /// A warning without a place yet.
    pub fn warning(message: impl Into<String>) -> Self {
        Self { severity: Severity::Warning, ..Self::error(message) }
    }
    /// In this file.
    pub fn in_file(mut self, file: &Path) -> Self {
        self.file = Some(file.to_path_buf());
        self
    }
    /// In this file unless it names another already.
    pub fn or_in_file(self, file: &Path) -> Self {
        if self.file.is_some() { self } else { self.in_file(file) }
    }
    /// At this line and column, from 1.
    pub fn at(mut self, line: usize, column: usize) -> Self {
        self.position = Some((line, column));
        self
    }
    /// With advice.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The message alone, behind the file's name and the line it is about: for lists that are not printed as messages are.
    pub fn placed(&self) -> String {
        let Some(name) = self.file.as_ref().and_then(|file| file.file_name()) else {
            return self.message.clone();
        };
        let line = self.position.map_or_else(String::new, |(line, _)| format!(":{line}"));
        format!("{}{line}: {}", name.display(), self.message)
    }

    /// The same with what to do about it.
    pub fn advised(&self) -> String {
        let placed = self.placed();
        self.help.as_ref().map_or_else(|| placed.clone(), |help| format!("{placed}. To mend it: {help}"))
    }
}

impl fmt::Display for Diagnostic {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let kind = match self.severity {
            Severity::Warning => "warning",
            Severity::Error => "error",
        };
        write!(f, "{kind}: {}", self.message)?;
        if let Some(file) = &self.file {
            write!(f, "\n  --> {}", file.display())?;
            if let Some((line, column)) = self.position {
                write!(f, ":{line}")?;
                if column > 0 {
                    write!(f, ":{column}")?;
                }
            }
        }
        if let Some(help) = &self.help {
            write!(f, "\nhelp: {help}")?;
        }
        Ok(())
    }
}

/// Everything found wrong in one stage; at least one of them is an error.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Diagnostics(pub Vec<Diagnostic>);

impl fmt::Display for Diagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, diagnostic) in self.0.iter().enumerate() {
            if i > 0 {
                f.write_str("\n\n")?;
            }
            diagnostic.fmt(f)?;
        }
        Ok(())
    }
}

impl std::error::Error for Diagnostics {}

impl From<Diagnostic> for Diagnostics {
    fn from(diagnostic: Diagnostic) -> Self {
        Self(vec![diagnostic])
    }
}

/// Line and column (from 1) of a byte offset in a text.
pub fn line_and_column(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    (line, before.rsplit('\n').next().unwrap_or("").chars().count() + 1)
}

/// Up to `most` names in backquotes, separated by commas; the rest as a count.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>, most: usize) -> String {
    let names: Vec<_> = names.into_iter().collect();
    let shown: Vec<_> = names.iter().take(most).map(|n| format!("`{}`", shorten(n))).collect();
    let rest = names.len().saturating_sub(most);
    if rest > 0 { format!("{} and {rest} more", shown.join(", ")) } else { shown.join(", ") }
}

/// The text cut to 60 characters, so that a huge field does not fill a message.
pub fn shorten(text: &str) -> String {
    if text.chars().count() <= 60 {
        return text.to_owned();
    }
    text.chars().take(57).chain("...".chars()).collect()
}
