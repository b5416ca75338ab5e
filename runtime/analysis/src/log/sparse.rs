//! Columns that a recorder left empty, or gave up on, while it wrote those of other joints.
use super::fields::split;
use super::file::Log;
use super::header::{Column, Kind};
use super::names::{JOINT_QUANTITIES, joint_of};
use super::value::is_absent;
use bipedc_effects::diagnostic::Diagnostics;
use std::sync::{Arc, OnceLock};

/// Without so large a part of its numbers an effort costs the other joints more samples than it is worth.
const EFFORT: f64 = 0.25;
/// Without an angle nothing is known of a joint's motion, which others feel: only one that is nearly never there goes.
const MOTION: f64 = 0.9;

/// Angles of joints.
const OF_JOINTS: &str = "position";
/// Angles of motors, which stand for those of joints where a joint lacks its own.
const OF_MOTORS: &str = "motor_position";

/// A column with hardly any numbers in rows that have those of other joints.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Sparse {
    field: usize,
    /// Rows without a number.
    pub rows: usize,
    /// Rows that have a number of the same quantity of any joint.
    pub of: usize,
    /// The first line without one, from 1.
    pub line: usize,
}

/// What was found of a file; clones of its log share it.
pub(super) type Found = Arc<OnceLock<Vec<Sparse>>>;

impl Log {
    /// Whether a column is so empty that nothing is gained by it: how empty. The first question costs a pass over the lines.
    pub fn sparse(&self, name: &str) -> Option<&Sparse> {
        let column = self.header().columns.iter().find(|column| column.name == name)?;
        // A file that cannot be read is told of by those who need its rows.
        let found = self.found_sparse().get_or_init(|| find(self).unwrap_or_default());
        found.iter().find(|sparse| sparse.field == column.field)
    }
}

/// Columns of one quantity of all joints.
struct Quantity<'c> {
    columns: Vec<(&'c Column, Sparse)>,
    largest: f64,
    rows: usize,
}

fn find(log: &Log) -> Result<Vec<Sparse>, Diagnostics> {
    if log.kind() != Kind::Time {
        return Ok(Vec::new());
    }
    let columns = &log.header().columns;
    let known = JOINT_QUANTITIES.iter().filter(|quantity| **quantity != OF_MOTORS);
    let mut quantities: Vec<Quantity<'_>> = known.map(|quantity| Quantity::of(quantity, columns)).collect();
    let (mut lines, mut fields, mut whole) = (log.lines()?, Vec::new(), 0);
    while let Some((number, line)) = lines.next()? {
        if !may_lack(line) {
            whole += 1;
        } else if split(line, &mut fields).is_ok() && fields.len() == log.header().fields {
            let absent = |column: &Column| is_absent(&line[fields[column.field].clone()]);
            quantities.iter_mut().for_each(|quantity| quantity.take(number, absent));
        }
    }
    Ok(quantities.into_iter().flat_map(|quantity| quantity.sparse(whole)).collect())
}

/// Whether a field of a line may be empty. Most lines of most logs are numbers alone, which this tells at a glance.
fn may_lack(line: &str) -> bool {
    let mut before = b',';
    for &byte in line.as_bytes() {
        let letter = byte.is_ascii_alphabetic() && !matches!(byte, b'e' | b'E');
        if letter || byte == b'"' || byte == b',' && matches!(before, b',' | b'-') {
            return true;
        }
        before = if byte == b' ' || byte == b'\t' { before } else { byte };
    }
    matches!(before, b',' | b'-')
}

impl<'c> Quantity<'c> {
    fn of(name: &str, columns: &'c [Column]) -> Self {
        let own = |column: &&Column| {
            let quantity =
                column.name.rsplit('/').next().map(|own| if own == OF_MOTORS { OF_JOINTS } else { own });
            joint_of(&column.name).is_some() && quantity == Some(name)
        };
        let new = |column: &'c Column| (column, Sparse { field: column.field, rows: 0, of: 0, line: 0 });
        let largest = if name == OF_JOINTS { MOTION } else { EFFORT };
        Self { columns: columns.iter().filter(own).map(new).collect(), largest, rows: 0 }
    }

    /// Takes a row; rows without any number of this quantity tell nothing of one of them.
    fn take(&mut self, line: usize, absent: impl Fn(&Column) -> bool) {
        if self.columns.iter().all(|(column, _)| absent(column)) {
            return;
        }
        self.rows += 1;
        for (_, sparse) in self.columns.iter_mut().filter(|(column, _)| absent(column)) {
            sparse.rows += 1;
            if sparse.line == 0 {
                sparse.line = line;
            }
        }
    }

    /// Those that are too empty, unless all are: rows may hold one joint each.
    fn sparse(self, whole: usize) -> Vec<Sparse> {
        let (rows, count) = (self.rows + whole, self.columns.len());
        let all = self.columns.into_iter().map(|(_, sparse)| Sparse { of: rows, ..sparse });
        let found: Vec<Sparse> =
            all.filter(|sparse| sparse.rows as f64 > self.largest * rows as f64).collect();
        if found.len() < count { found } else { Vec::new() }
    }
}
