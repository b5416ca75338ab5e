//! The rows of the program, with the names that a failure is told by.

/// All rows with their limits.
#[derive(Debug, Clone, Default)]
pub(super) struct Rows {
    pub limits: Vec<[f64; 2]>,
    /// What of each row is as much as 1 is of a robot of 20 kg and 0.7 m.
    pub scale: Vec<f64>,
    pub names: Vec<RowName>,
    /// By phase, node and row of the node's function: the row of the program.
    pub nodes: Vec<Vec<Vec<Option<usize>>>>,
    /// By phase and row of the change's function.
    pub changes: Vec<Vec<Option<usize>>>,
    /// By phase: the first row of the equations between nodes, 4 nv for each interval.
    pub between: Vec<usize>,
    /// Sums: row, then variable and factor.
    pub sums: Vec<(usize, Vec<(usize, f64)>)>,
}

/// What a row is about.
#[derive(Debug, Clone, PartialEq)]
pub struct RowName {
    /// What is violated.
    pub what: String,
    /// Phase by index.
    pub phase: usize,
    /// Node; `None`: the change behind the phase, or the whole of it.
    pub node: Option<usize>,
}

impl Rows {
    /// A row of which `unit` is what 1 is of a robot of 20 kg and 0.7 m.
    pub fn add(
        &mut self,
        (what, phase, node): (&str, usize, Option<usize>),
        unit: f64,
        limits: [f64; 2],
    ) -> usize {
        self.limits.push(limits);
        self.scale.push(unit);
        self.names.push(RowName { what: what.to_owned(), phase, node });
        self.limits.len() - 1
    }

    pub fn sum(
        &mut self,
        name: (&str, usize, Option<usize>),
        unit: f64,
        (limits, terms): ([f64; 2], Vec<(usize, f64)>),
    ) {
        let row = self.add(name, unit, limits);
        self.sums.push((row, terms));
    }
}
