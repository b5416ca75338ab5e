//! Rust as text, formatted while it is written: nothing here is parsed or printed a second time, so that comments stay
//! and lists fill their lines.
use std::fmt::Write as _;

/// Columns of a line.
pub const WIDTH: usize = 120;

/// Lines with their indentation.
#[derive(Debug, Default)]
pub struct Text {
    text: String,
    depth: usize,
}

impl Text {
    /// What was written.
    pub fn finish(self) -> String {
        self.text
    }

    /// One line; empty ones stay empty.
    pub fn line(&mut self, line: &str) {
        if !line.is_empty() {
            let _ = write!(self.text, "{:1$}{line}", "", 4 * self.depth);
        }
        self.text.push('\n');
    }

    /// A line after which everything is indented.
    pub fn open(&mut self, line: &str) {
        self.line(line);
        self.indent();
    }

    /// What follows is indented, as after [`Self::open`].
    pub fn indent(&mut self) {
        self.depth += 1;
    }

    /// What follows is indented as before the last [`Self::open`].
    pub fn unindent(&mut self) {
        self.depth -= 1;
    }

    /// The end of what a line opened.
    pub fn close(&mut self, line: &str) {
        self.unindent();
        self.line(line);
    }

    /// Lines that are written already.
    pub fn lines(&mut self, text: &str) {
        text.lines().for_each(|line| self.line(line));
    }

    /// Whether a line would be short enough here.
    pub fn fits(&self, line: &str) -> bool {
        4 * self.depth + line.chars().count() <= WIDTH
    }

    /// `open item, item close` on one line, or the items filling lines between the two.
    pub fn list(&mut self, open: &str, items: &[String], close: &str) {
        let line = format!("{open}{}{close}", items.join(", "));
        if self.fits(&line) {
            self.line(&line);
            return;
        }
        self.open(open);
        self.filled(("", ""), items.iter().map(|item| format!("{item},")));
        self.close(close);
    }

    /// Words filling lines: what the first line begins with, and the others.
    pub fn filled(&mut self, (first, others): (&str, &str), words: impl Iterator<Item = String>) {
        let mut line: Option<String> = None;
        for word in words {
            let longer = match &line {
                Some(line) => format!("{line} {word}"),
                None => format!("{first}{word}"),
            };
            line = match line {
                Some(full) if !self.fits(&longer) => {
                    self.line(&full);
                    Some(format!("{others}{word}"))
                }
                _ => Some(longer),
            };
        }
        line.iter().for_each(|line| self.line(line));
    }

    /// A paragraph of documentation, or an item of a list, which begins with `- `; `mark` is `///` or `//!`.
    pub fn doc(&mut self, mark: &str, paragraph: &str) {
        let paragraph = harmless(paragraph);
        if paragraph.is_empty() {
            return self.line(mark);
        }
        let indented = if paragraph.starts_with("- ") { "  " } else { "" };
        let (first, others) = (format!("{mark} "), format!("{mark} {indented}"));
        self.filled((&first, &others), unbroken(&paragraph).into_iter());
    }
}

/// The words of a paragraph; those that would make a list or a heading of a line stay with the word before.
fn unbroken(paragraph: &str) -> Vec<String> {
    let begins = |word: &str| word.starts_with(['-', '+', '*', '#', '>', '|', '=']);
    let number = |word: &str| word.trim_end_matches(['.', ')']).parse::<f64>().is_ok();
    let mut words: Vec<String> = Vec::new();
    for word in paragraph.split(' ') {
        match words.last_mut() {
            Some(last) if last == "-" || begins(word) || number(word) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => words.push(word.to_owned()),
        }
    }
    words
}

/// A name from a description as part of a comment: nothing in it ends the line or turns the direction of writing.
pub fn harmless(text: &str) -> String {
    let turns = |c: char| matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    text.chars().map(|c| if c.is_control() || turns(c) { '\u{fffd}' } else { c }).collect()
}

/// A string as it stands in Rust.
pub fn quoted(text: &str) -> String {
    format!("{text:?}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_fill_their_lines() {
        let mut text = Text::default();
        let names: Vec<String> = (0..60).map(|k| format!("t{k}")).collect();
        text.open("{");
        text.list("let (", &names[..3], ");");
        text.list("let (", &names, ");");
        text.close("}");
        let text = text.finish();
        assert!(text.starts_with("{\n    let (t0, t1, t2);\n    let (\n        t0, t1, t2, t3,"), "{text}");
        assert!(text.ends_with(" t59,\n    );\n}\n"), "{text}");
        assert!(text.lines().all(|line| line.len() <= WIDTH) && text.lines().count() == 8, "{text}");
    }

    #[test]
    fn a_name_cannot_leave_its_comment() {
        let mut text = Text::default();
        text.doc("///", "Of `a\nfn evil() {}\r\u{202e}`.");
        assert_eq!(text.finish(), "/// Of `a\u{fffd}fn evil() {}\u{fffd}\u{fffd}`.\n");
    }

    #[test]
    fn items_of_lists_are_indented_and_signs_begin_no_line() {
        let mut text = Text::default();
        text.doc("//!", &format!("- [`name`]: {}", "a - b + c ".repeat(20).trim_end()));
        let text = text.finish();
        let lines: Vec<&str> = text.lines().collect();
        assert!(lines[0].starts_with("//! - [`name`]: a - b") && lines[1].starts_with("//!   "), "{text}");
        assert!(lines[1..].iter().all(|line| line[6..].starts_with(['a', 'b', 'c'])), "{text}");
    }
}
