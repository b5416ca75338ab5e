//! Robots, random states, and functions evaluated in process.
use bipedc_compiler::derive::{InertiaMode, RobotModel};
use bipedc_compiler::description::model::{Base, Contact, ContactPart, Foot, RobotDescription};
use bipedc_compiler::expression::{Graph, Sym};
use bipedc_compiler::program::{Evaluator, Operations, Order, Program, lower};
use bipedc_compiler::tree::{BaseKind, Tree};
use bipedc_runtime::{Argument, State};
use std::path::PathBuf;

pub const ROBOTS: [&str; 6] = ["three_link", "five_link", "seven_link", "biped_3d", "tulip", "tulip_v1_leg"];
pub const PLANAR: [&str; 3] = ["three_link", "five_link", "seven_link"];
pub const SEED: u64 = 20_261_121;

pub fn project() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

pub fn robot(name: &str) -> RobotDescription {
    let folder = project().join("robots").join(name);
    bipedc_compiler::description::read(&folder).unwrap_or_else(|e| panic!("{e}")).0
}

/// The tree on its root link: floating, planar or fixed.
pub fn tree(description: &RobotDescription, kind: &str) -> Tree {
    let root = description.root_link.clone();
    let base = match kind {
        "planar" => Base::Planar { root },
        "fixed" => Base::Fixed { link: root },
        _ => Base::Floating { root },
    };
    Tree::new(description, &base).unwrap()
}

/// `right_foot` (flat), `right_foot/front` (an edge) or `right_foot/toe` (a point).
pub fn contact(feet: &[Foot], text: &str) -> Contact {
    let (foot, part) = text.split_once('/').unwrap_or((text, ""));
    let found = feet.iter().find(|f| f.name == foot || f.link == foot).unwrap();
    let part = if part.is_empty() {
        ContactPart::Flat
    } else if found.edges.iter().any(|edge| edge.name == part) {
        ContactPart::Edge(part.to_owned())
    } else {
        ContactPart::Point(part.to_owned())
    };
    Contact { foot: found.name.clone(), part }
}

/// Several quantities of one model as one program.
pub struct Function {
    program: Program,
    lengths: Vec<usize>,
}

impl Function {
    pub fn derive(
        tree: &Tree,
        outputs: impl for<'g, 't> FnOnce(&RobotModel<'g, 't>) -> Vec<Vec<Sym<'g>>>,
    ) -> Self {
        let graph = Graph::new();
        let model = RobotModel::new(&graph, tree, InertiaMode::Folded);
        let parts = outputs(&model);
        let all: Vec<_> = parts.iter().flatten().map(|x| x.expr).collect();
        Self {
            program: lower(&graph, &all, Order::Derivation),
            lengths: parts.iter().map(Vec::len).collect(),
        }
    }

    pub fn operations(&self) -> Operations {
        Operations::of(&self.program)
    }

    pub fn call(&self, arguments: &[(Argument, &[f64])]) -> Vec<Vec<f64>> {
        let evaluator = Evaluator::new(&self.program);
        let state = arguments.iter().fold(State::new(), |state, &(a, x)| state.with(a, x));
        let mut out = vec![f64::NAN; evaluator.outputs()];
        evaluator.run(&state, &mut evaluator.workspace::<f64>(), &mut out);
        let mut rest = out.as_slice();
        self.lengths
            .iter()
            .map(|&n| {
                let (part, after) = rest.split_at(n);
                rest = after;
                part.to_vec()
            })
            .collect()
    }
}

/// xorshift64*, the same on every machine.
pub struct Random(u64);

impl Random {
    pub fn new(seed: u64) -> Self {
        println!("seed {seed}");
        Self(seed)
    }
    /// Uniform in -scale..scale.
    pub fn number(&mut self, scale: f64) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        let bits = self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11;
        scale * (2.0 * bits as f64 / (1u64 << 53) as f64 - 1.0)
    }
    pub fn vector(&mut self, n: usize, scale: f64) -> Vec<f64> {
        (0..n).map(|_| self.number(scale)).collect()
    }
    pub fn configuration(&mut self, tree: &Tree) -> Vec<f64> {
        let mut q = self.vector(tree.nq, 1.0);
        if tree.base == BaseKind::Floating {
            let norm = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
            q[3..7].iter_mut().for_each(|x| *x /= norm);
        }
        q
    }
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// Rows times vector.
pub fn times(rows: &[Vec<f64>], x: &[f64]) -> Vec<f64> {
    rows.iter().map(|row| dot(row, x)).collect()
}

/// Transposed rows times vector.
pub fn transposed_times(rows: &[Vec<f64>], x: &[f64], n: usize) -> Vec<f64> {
    (0..n).map(|k| rows.iter().zip(x).map(|(row, y)| row[k] * y).sum()).collect()
}

/// A flat list as rows of `n`.
pub fn rows(flat: &[f64], n: usize) -> Vec<Vec<f64>> {
    flat.chunks(n).map(<[f64]>::to_vec).collect()
}

pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Largest difference relative to the largest expected element (at least 1).
pub fn error(actual: &[f64], expected: &[f64]) -> f64 {
    assert_eq!(actual.len(), expected.len());
    let scale = expected.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    actual.iter().zip(expected).fold(0.0, |m: f64, (a, e)| {
        assert!(a.is_finite(), "{a}");
        m.max((a - e).abs() / scale)
    })
}

/// Remembers the worst error of each kind, prints it and fails above its tolerance.
#[derive(Default)]
pub struct Worst(Vec<(String, f64)>);

impl Worst {
    pub fn note(&mut self, what: &str, actual: &[f64], expected: &[f64]) {
        let found = error(actual, expected);
        match self.0.iter_mut().find(|(name, _)| name == what) {
            Some((_, worst)) => *worst = worst.max(found),
            None => self.0.push((what.to_owned(), found)),
        }
    }
    pub fn check(&self, tolerance: f64) {
        assert!(!self.0.is_empty());
        for (what, worst) in &self.0 {
            println!("{what}: {worst:.1e}");
        }
        for (what, worst) in &self.0 {
            assert!(*worst <= tolerance, "{what}: {worst:.1e} > {tolerance:.0e}");
        }
    }
}
