//! Texts with their line numbers, and the collection of everything found wrong in them.
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, Severity};
use bipedc_effects::spelling;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// A text and where its lines begin, so that a byte offset becomes line and column in logarithmic time.
#[derive(Debug)]
pub(crate) struct SourceText<'a> {
    pub(crate) text: &'a str,
    name: PathBuf,
    line_starts: Vec<usize>,
}

impl<'a> SourceText<'a> {
    pub(crate) fn new(text: &'a str, name: &Path) -> Self {
        let newlines = text.bytes().enumerate().filter(|&(_, byte)| byte == b'\n').map(|(at, _)| at + 1);
        Self { text, name: name.to_path_buf(), line_starts: std::iter::once(0).chain(newlines).collect() }
    }

    /// Line and column (in characters), both from 1.
    pub(crate) fn line_and_column(&self, offset: usize) -> (usize, usize) {
        let line = self.line_starts.partition_point(|&start| start <= offset);
        let start = self.line_starts[line - 1];
        let column = self.text.get(start..offset).map_or(1, |part| part.chars().count() + 1);
        (line, column)
    }

    /// The offset of a line and column as other crates report them.
    pub(crate) fn offset(&self, line: usize, column: usize) -> usize {
        let start = self.line_starts.get(line.saturating_sub(1)).copied().unwrap_or(self.text.len());
        let skipped = self.text.get(start..).unwrap_or("").chars().take(column.saturating_sub(1));
        start + skipped.map(char::len_utf8).sum::<usize>()
    }
}

/// Where in a [`SourceText`] something stands; `None` for things that were not written but assumed.
pub(crate) type Place = Option<usize>;

/// Collects messages about one file.
#[derive(Debug)]
pub(crate) struct Messages<'a> {
    pub(crate) source: SourceText<'a>,
    list: Vec<Diagnostic>,
    /// Where messages stand in the list, by line and column: there are as many as a file has lines, and more.
    at: HashMap<Option<(usize, usize)>, Vec<usize>>,
    errors: usize,
}

impl<'a> Messages<'a> {
    pub(crate) fn new(text: &'a str, name: &Path) -> Self {
        Self { source: SourceText::new(text, name), list: Vec::new(), at: HashMap::new(), errors: 0 }
    }

    pub(crate) fn error(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        self.errors += 1;
        self.push(Diagnostic::error(message), place, help.into());
    }

    pub(crate) fn warning(&mut self, place: Place, message: impl Into<String>, help: impl Into<String>) {
        self.push(Diagnostic::warning(message), place, help.into());
    }

    fn push(&mut self, diagnostic: Diagnostic, place: Place, help: String) {
        let mut diagnostic = diagnostic.in_file(&self.source.name).help(help);
        if let Some(offset) = place {
            let (line, column) = self.source.line_and_column(offset);
            diagnostic = diagnostic.at(line, column);
        }
        // What is read twice is said once.
        let here = self.at.entry(diagnostic.position).or_default();
        if here.iter().all(|&k| self.list[k] != diagnostic) {
            here.push(self.list.len());
            self.list.push(diagnostic);
        }
    }

    /// How many errors were found so far.
    pub(crate) fn errors(&self) -> usize {
        self.errors
    }

    pub(crate) fn into_list(self) -> Vec<Diagnostic> {
        self.list
    }
}

/// The warnings if there are no errors, otherwise everything, in the order of the file.
pub(crate) fn finish(mut list: Vec<Diagnostic>) -> Result<Vec<Diagnostic>, Diagnostics> {
    // A stable sort within each file: the reader of the messages goes through the file from top to bottom.
    list.sort_by(|a, b| (&a.file, a.position).cmp(&(&b.file, b.position)));
    if list.iter().any(|diagnostic| diagnostic.severity == Severity::Error) {
        Err(Diagnostics(list))
    } else {
        Ok(list)
    }
}

/// "did you mean `x`?" or else a list of what there is.
pub fn suggest<'c>(
    written: &str,
    candidates: impl IntoIterator<Item = &'c str> + Clone,
    what: &str,
) -> String {
    spelling::suggest(written, candidates.clone(), || format!("{what}: {}", list_names(candidates)))
}

/// The first names of a list, quoted.
pub(crate) fn list_names<'c>(names: impl IntoIterator<Item = &'c str>) -> String {
    const SHOWN: usize = 12;
    let names: Vec<&str> = names.into_iter().filter(|name| !name.is_empty()).collect();
    if names.is_empty() {
        return "none".into();
    }
    let shown: Vec<String> = names.iter().take(SHOWN).map(|name| format!("`{}`", short(name))).collect();
    let more = if names.len() > SHOWN { format!(", … ({} in all)", names.len()) } else { String::new() };
    shown.join(", ") + &more
}

/// A piece of the user's text fit for a one-line message.
pub(crate) fn short(text: &str) -> String {
    const SHOWN: usize = 80;
    let mut result: String = text.chars().take(SHOWN).map(|c| if c.is_control() { ' ' } else { c }).collect();
    if text.chars().nth(SHOWN).is_some() {
        result.push('…');
    }
    result
}
