//! A map as a table: one row for each cell and speed. A map that was interrupted goes on from it.
use super::MapAxis;
use bipedc_analysis::gait::{Cell, Reason};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::files::write_with_folders;
use std::fmt::Write;
use std::io::ErrorKind;
use std::path::Path;

/// What the rows of a table stand for.
pub(super) struct Frame<'a> {
    /// Columns, then rows of the map.
    pub axes: [MapAxis; 2],
    pub speeds: &'a [f64],
}

impl Frame<'_> {
    /// Values of both axes and the speed of every cell, in the order of the file.
    fn places(&self) -> impl Iterator<Item = [f64; 3]> + '_ {
        let [columns, rows] = &self.axes;
        let cell = move |y: f64, x: f64| self.speeds.iter().map(move |&speed| [x, y, speed]);
        rows.values.iter().flat_map(move |&y| columns.values.iter().flat_map(move |&x| cell(y, x)))
    }

    fn head(&self, identity: &str) -> [String; 2] {
        let [columns, rows] = &self.axes;
        let names = format!("{},{},speed,next_speed,computed,reason", columns.name, rows.name);
        [format!("# bipedc gait map, request {identity}"), names]
    }
}

/// Writes all cells. Numbers have as many digits as it takes to read them back.
pub(super) fn write(
    path: &Path,
    identity: &str,
    frame: &Frame<'_>,
    cells: &[Cell],
) -> Result<(), Diagnostic> {
    let [request, names] = frame.head(identity);
    let mut text = format!("{request}\n{names}\n");
    for ([x, y, speed], cell) in frame.places().zip(cells) {
        let next = cell.next_speed.map_or_else(String::new, |next| next.to_string());
        let computed = u8::from(!cell.interpolated && cell.reason != Reason::NotComputed);
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{x},{y},{speed},{next},{computed},{}", cell.reason.code());
    }
    write_with_folders(path, &text)
}

/// The cells of a file that a run of the same request left; none without a file.
///
/// # Errors
/// A file of something else, or a damaged one: it is not written over.
pub(super) fn read(path: &Path, identity: &str, frame: &Frame<'_>) -> Result<Vec<Cell>, Diagnostic> {
    // Devices and pipes have nothing to go on from, and reading them may never end.
    if std::fs::metadata(path).is_ok_and(|found| !found.is_file()) {
        return Ok(Vec::new());
    }
    let text = match std::fs::read_to_string(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
        Err(error) => return Err(Diagnostic::error(format!("cannot be read: {error}")).in_file(path)),
        Ok(text) => text,
    };
    // What was made for the file's name alone, such as by mktemp, is no map yet.
    if text.is_empty() {
        return Ok(Vec::new());
    }
    let refuse = |message: &str, line: usize| {
        let help = "a map goes on only from its own file: remove it, or write to another one";
        Err(Diagnostic::error(message).in_file(path).at(line, 1).help(help))
    };
    let mut lines = text.lines();
    for (k, head) in frame.head(identity).iter().enumerate() {
        if lines.next() != Some(head) {
            return refuse("this is not a map of this robot, gait, ranges and speeds", k + 1);
        }
    }
    let mut cells = Vec::new();
    for (k, place) in frame.places().enumerate() {
        let Some(cell) = lines.next().and_then(|line| cell(line, place)) else {
            return refuse("the row of a cell is missing or damaged", k + 3);
        };
        cells.push(cell);
    }
    if lines.next().is_some() {
        refuse("rows follow after the last cell", cells.len() + 3)
    } else {
        Ok(cells)
    }
}

/// The cell of a line, if it is the one of this place.
fn cell(line: &str, place: [f64; 3]) -> Option<Cell> {
    let mut fields = line.split(',');
    for expected in place {
        if fields.next()?.parse::<f64>().ok()? != expected {
            return None;
        }
    }
    let (next, computed) = (fields.next()?, fields.next()?);
    let next_speed =
        if next.is_empty() { None } else { Some(next.parse().ok().filter(|x: &f64| x.is_finite())?) };
    let computed = ["0", "1"].iter().position(|known| *known == computed)? == 1;
    let reason = Reason::of_code(fields.next()?)?;
    let interpolated = !computed && reason != Reason::NotComputed;
    // A step that passes has a speed.
    let whole = fields.next().is_none() && (reason != Reason::Passes || next_speed.is_some());
    whole.then_some(Cell { next_speed, reason, interpolated })
}
