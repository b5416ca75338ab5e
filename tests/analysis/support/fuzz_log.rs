//! Any bytes given as a measurement file: an error or a result, never a panic.
//!
//! The body of the fuzz target `log`, here so that a test runs it on the seed corpus.
use bipedc_analysis::compare::compare;
use bipedc_analysis::log::{Mapping, Reader, Table};
use bipedc_analysis::measure::Options;
use bipedc_analysis::robot::{BaseKind, Batch, EvaluationError, InverseDynamics, Joint, JointLayout};
use std::io::Cursor;
use std::path::Path;

/// Efforts are accelerations.
struct Toy(usize);

impl InverseDynamics for Toy {
    fn nq(&self) -> usize {
        self.0 + 1
    }
    fn nv(&self) -> usize {
        self.0
    }
    fn torques(&mut self, batch: &Batch<'_>, tau: &mut [f64]) -> Result<(), EvaluationError> {
        tau.copy_from_slice(batch.a);
        Ok(())
    }
}

/// Reads, tabulates and compares.
pub fn run(data: &[u8]) {
    // Up to a zero byte the input is a mapping file, what follows is the table; without one it is all table.
    let (mapping, table) = match data.iter().position(|b| *b == 0) {
        Some(end) => (std::str::from_utf8(&data[..end]).unwrap_or(""), &data[end + 1..]),
        None => ("", data),
    };
    let Ok(mapping) = Mapping::parse(Path::new("map.toml"), mapping) else { return };
    let open = || Reader::from_source(Path::new("log.csv"), Box::new(Cursor::new(table.to_vec())), &mapping);
    let Ok(reader) = open() else { return };
    let names: Vec<String> = reader.columns().map(|c| c.name.clone()).collect();
    drop(Table::read(reader, &names));
    let joints = ["a", "b"].map(Joint::revolute).to_vec();
    let layout = JointLayout { joints, base: BaseKind::Floating };
    // Short logs of a fuzzer must reach the filter, too.
    let options = Options { trim_s: 0.0, ..Options::default() };
    if let Ok(reader) = open() {
        match compare(&mut Toy(8), &layout, reader, &options) {
            Ok(comparison) => drop(comparison.to_string()),
            Err(errors) => drop(errors.to_string()),
        }
    }
}
