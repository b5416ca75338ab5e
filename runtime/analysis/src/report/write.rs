//! Reports as files.
use super::data::Report;
use super::page::render;
use super::svg;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::{Batch, Output, write_with_folders};
use maud::Markup;
use std::path::{Path, PathBuf};

/// Writes the page. Missing folders are made; nobody ever sees half a file.
///
/// # Errors
/// What the file system refuses.
pub fn write(report: &Report, path: &Path) -> Result<(), Diagnostic> {
    write_with_folders(path, &render(report))
}

/// Writes the pictures into a folder: `robot.svg`, `causes.svg`, `staircase.svg`, and per row
/// `<row>.svg` (signal and residual over time) and `<row>_against_<signal>.svg`. Says which files it wrote.
///
/// # Errors
/// What the file system refuses.
pub fn write_svg(report: &Report, folder: &Path) -> Result<Vec<PathBuf>, Diagnostic> {
    let mut pictures = Pictures::into(folder);
    let mut put = |name: String, title: &str, (content, size): (Markup, (f64, f64))| {
        pictures.put(&name, &svg::standalone(title, size, &content))
    };
    let mut names = Names::default();
    if let Some(picture) = svg::named_robot(report) {
        put(names.unique("robot"), &report.title, picture)?;
    }
    if let Some(picture) = report.diagnosis.as_ref().and_then(|d| svg::causes(&d.effects)) {
        put(names.unique("causes"), &report.title, picture)?;
    }
    if let Some(picture) = svg::staircase(&svg::steps(report)) {
        put(names.unique("staircase"), &report.title, picture)?;
    }
    for row in report.rows.iter().filter(|row| !row.series.is_empty()) {
        put(names.unique(&row.name), &row.name, svg::torque_and_residual(row, &report.abscissa))?;
        for signal in &row.series.signals {
            let name = names.unique(&format!("{}_against_{}", row.name, signal.name));
            put(name, &row.name, svg::against(row, signal))?;
        }
    }
    pictures.commit()
}

/// Pictures that go into a folder together.
pub(super) struct Pictures<'a> {
    folder: &'a Path,
    files: Batch,
    paths: Vec<PathBuf>,
}

impl<'a> Pictures<'a> {
    pub fn into(folder: &'a Path) -> Self {
        Self { folder, files: Batch::default(), paths: Vec::new() }
    }

    /// One more, under this name without an ending.
    pub fn put(&mut self, name: &str, picture: &str) -> Result<(), Diagnostic> {
        let path = self.folder.join(format!("{name}.svg"));
        let mut file = Output::create_with_folders(&path)?;
        file.put(picture)?;
        self.files.add(file);
        self.paths.push(path);
        Ok(())
    }

    /// Says which files they are.
    pub fn commit(self) -> Result<Vec<PathBuf>, Diagnostic> {
        self.files.commit()?;
        Ok(self.paths)
    }
}

/// File names that no other picture has.
#[derive(Default)]
struct Names(std::collections::HashSet<String>);

impl Names {
    /// Letters, digits, `_`, `-` and `.` stay; the rest becomes `_`. Equal names are numbered.
    fn unique(&mut self, name: &str) -> String {
        let safe = |c: char| if c.is_alphanumeric() || matches!(c, '_' | '-') { c } else { '_' };
        let name: String = name.chars().take(100).map(safe).collect();
        let mut candidate = name.clone();
        let mut number = 2;
        // Names that differ in case alone are one file on some systems.
        while !self.0.insert(candidate.to_lowercase()) {
            candidate = format!("{name}_{number}");
            number += 1;
        }
        candidate
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::Channel;
    use crate::report::{Row, Series};

    #[test]
    fn names_stay_in_their_folder() {
        let mut names = Names::default();
        assert_eq!(names.unique("../a b"), "___a_b");
        assert_eq!(names.unique("../A b"), "___A_b_2");
    }

    #[test]
    fn pictures_are_well_formed() {
        let folder = std::env::temp_dir().join(format!("bipedc-report-{}", std::process::id()));
        let series = Series {
            time: vec![0.0, 1.0, 2.0],
            measured: vec![0.0, 1.0, f64::NAN],
            nominal: vec![0.5; 3],
            ..Series::default()
        };
        let row =
            Row::new("a<b&\"c\"", Channel::Effort, "N m", 0.1, series.with("load", "N m", vec![1.0; 3]));
        let written = write_svg(&Report { rows: vec![row], ..Report::default() }, &folder).unwrap();
        assert_eq!(written.len(), 2);
        for path in written {
            let text = std::fs::read_to_string(&path).unwrap();
            roxmltree::Document::parse(&text).unwrap();
        }
        std::fs::remove_dir_all(folder).unwrap();
        let error = write(&Report::default(), Path::new("/proc/nowhere/out.html")).unwrap_err();
        assert!(error.to_string().contains("nowhere"), "{error}");
    }
}
