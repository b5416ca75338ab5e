//! Glitches: positions that leave for a few samples and come back, faster than anything moves.
use super::names::{joint_of, shorten};
use super::wraps::is_turn;
use bipedc_effects::diagnostic::Diagnostic;

/// No joint moves that fast, rad/s or m/s: not there, and not back again.
const FASTEST: f64 = 1000.0;
/// Smaller jumps are a matter of noise, rad or m.
const JUMP: f64 = 0.5;
/// What stays away for more samples is there: an angle that was wrapped, a recording that was put together.
const LONGEST: usize = 5;

/// The position columns of a log, row by row.
#[derive(Default)]
pub(super) struct Spikes {
    columns: Vec<Column>,
    /// Time of the last row.
    time: f64,
}

struct Column {
    /// Its place in a row.
    place: usize,
    name: String,
    last: f64,
    away: Option<Away>,
}

/// Where a position went.
#[derive(Clone, Copy)]
struct Away {
    from: f64,
    to: f64,
    samples: usize,
    line: usize,
    character: usize,
}

impl Spikes {
    /// For rows of these columns, the time first.
    pub(super) fn of(names: &[&str]) -> Self {
        let position = |name: &str| name.ends_with("/position") && joint_of(name).is_some();
        let columns = names.iter().enumerate().filter(|(_, name)| position(name));
        let column = |(place, name): (usize, &&str)| Column {
            place,
            name: (*name).to_owned(),
            last: f64::NAN,
            away: None,
        };
        Self { columns: columns.map(column).collect(), time: f64::NAN }
    }

    /// Takes the next row of a log and tells glitches that it ends. `character` is where a value of the row stands.
    pub(super) fn next(
        &mut self,
        line: usize,
        row: &[f64],
        character: &dyn Fn(usize) -> usize,
    ) -> Vec<Diagnostic> {
        let step = row[0] - self.time;
        self.time = row[0];
        let next = |column: &mut Column| column.next(row[column.place], step, (line, character));
        self.columns.iter_mut().filter_map(next).collect()
    }
}

impl Column {
    fn next(
        &mut self,
        x: f64,
        step: f64,
        (line, character): (usize, &dyn Fn(usize) -> usize),
    ) -> Option<Diagnostic> {
        let from = std::mem::replace(&mut self.last, x);
        // A row before the first one, or without a number, is NaN: nothing is fast then.
        let fast = (x - from).abs() > JUMP.max(FASTEST * step) && !is_turn(x - from);
        let Some(away) = &mut self.away else {
            self.away =
                fast.then(|| Away { from, to: x, samples: 1, line, character: character(self.place) });
            return None;
        };
        let returns = (x - away.from).abs() < 0.5 * (away.to - away.from).abs();
        let found = (fast && returns).then(|| glitch(&self.name, away));
        away.samples += 1;
        if found.is_some() || away.samples > LONGEST {
            self.away = None;
        }
        found
    }
}

fn glitch(name: &str, away: &Away) -> Diagnostic {
    let samples =
        if away.samples == 1 { "one sample".to_owned() } else { format!("{} samples", away.samples) };
    let message = format!(
        "`{}` jumps from {} to {} for {samples}: nothing moves that fast",
        shorten(name),
        away.from,
        away.to
    );
    Diagnostic::error(message)
        .at(away.line, away.character)
        .help("a glitch of the recording: leave the fields empty (their rows are then passed over), or remove the rows")
}
