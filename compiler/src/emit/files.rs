//! Writing a package to disk, and comparing it with what stands there.
use super::package::Package;
use std::collections::BTreeSet;
use std::io;
use std::path::{Path, PathBuf};

/// How a folder differs from a package.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Difference {
    /// Files that should be there.
    pub missing: Vec<String>,
    /// Files whose content differs: edited by hand, or stale.
    pub changed: Vec<String>,
    /// Files that should not be there.
    pub extra: Vec<String>,
}

impl Difference {
    /// Whether the folder is exactly the package.
    pub fn is_empty(&self) -> bool {
        self.missing.is_empty() && self.changed.is_empty() && self.extra.is_empty()
    }
}

impl Package {
    /// Writes all files; each appears whole or not at all, and files of an earlier run that are no longer
    /// emitted go.
    ///
    /// # Errors
    /// What the file system refuses, with the path in the message.
    pub fn write(&self, folder: &Path) -> io::Result<()> {
        for (name, content) in &self.files {
            let path = folder.join(name);
            if std::fs::read(&path).is_ok_and(|present| present == content.as_bytes()) {
                continue;
            }
            write_whole(&path, content)?;
        }
        for name in self.compare(folder)?.extra {
            std::fs::remove_file(folder.join(name))?;
        }
        Ok(())
    }

    /// Compares a folder with the package. Only `Cargo.toml` and `src/` count: `target` and lock files are
    /// nobody's output.
    ///
    /// # Errors
    /// What the file system refuses.
    pub fn compare(&self, folder: &Path) -> io::Result<Difference> {
        let mut difference = Difference::default();
        for (name, content) in &self.files {
            match std::fs::read(folder.join(name)) {
                Ok(present) if present == content.as_bytes() => {}
                Ok(_) => difference.changed.push(name.clone()),
                Err(error) if error.kind() == io::ErrorKind::NotFound => {
                    difference.missing.push(name.clone())
                }
                Err(error) => return Err(named(&folder.join(name), &error)),
            }
        }
        let known: BTreeSet<&str> = self.files.keys().map(String::as_str).collect();
        let source = folder.join("src");
        if source.is_dir() {
            for entry in std::fs::read_dir(&source)? {
                let name = format!("src/{}", entry?.file_name().to_string_lossy());
                if name.ends_with(".rs") && !known.contains(name.as_str()) {
                    difference.extra.push(name);
                }
            }
        }
        difference.extra.sort();
        Ok(difference)
    }
}

fn named(path: &Path, error: &io::Error) -> io::Error {
    io::Error::new(error.kind(), format!("{}: {error}", path.display()))
}

/// Writes beside the file and renames, so that nobody ever sees half of it.
///
/// # Errors
/// What the file system refuses, with the path in the message.
pub fn write_whole(path: &Path, content: &str) -> io::Result<()> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(|e| named(folder, &e))?;
    }
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}.tmp", std::process::id()));
    let temporary: PathBuf = path.with_file_name(name);
    std::fs::write(&temporary, content).and_then(|()| std::fs::rename(&temporary, path)).map_err(|error| {
        let _ = std::fs::remove_file(&temporary);
        named(path, &error)
    })
}
