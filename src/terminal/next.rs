//! Commands that go on from a result, as they are typed.
use bipedc_analysis::report::NextStep;
use std::path::Path;

/// A command in the making.
pub struct Typed(String);

impl Typed {
    /// `bipedc NAME`.
    pub fn command(name: &str) -> Self {
        Self(format!("bipedc {name}"))
    }

    /// A file or folder.
    pub fn path(self, path: &Path) -> Self {
        Self(format!("{} {}", self.0, quoted(&path.display().to_string())))
    }

    /// An option with its value, if it was given.
    pub fn option(self, name: &str, value: Option<&impl ToString>) -> Self {
        match value {
            Some(value) => Self(format!("{} {name} {}", self.0, quoted(&value.to_string()))),
            None => self,
        }
    }

    /// The same for files.
    pub fn file(self, name: &str, path: Option<&Path>) -> Self {
        self.option(name, path.map(|path| path.display().to_string()).as_ref())
    }

    /// What needs no quotation marks.
    pub fn words(self, words: &str) -> Self {
        Self(self.0 + words)
    }

    /// And why one would type it.
    pub fn because(self, why: &str) -> NextStep {
        NextStep { why: why.to_owned(), command: self.0 }
    }
}

/// A word that a shell leaves as it is.
fn quoted(word: &str) -> String {
    let plain = |letter: char| letter.is_alphanumeric() || "_-./=,:+@%".contains(letter);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', r"'\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shells_get_back_what_was_typed() {
        let command = Typed::command("compare")
            .path(Path::new("my robot"))
            .option("--from", Some(&1.5))
            .file("--mapping", Some(Path::new("it's.toml")))
            .option("--to", None::<&f64>);
        assert_eq!(
            command.because("").command,
            r"bipedc compare 'my robot' --from 1.5 --mapping 'it'\''s.toml'"
        );
    }
}
