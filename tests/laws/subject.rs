//! A robot with some of its functions, in random states, on any scalar.
use super::generator::{Digits, KINDS, Random, robot};
use crate::laws::support::{ROBOTS, project};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel, Scope, entry};
use bipedc_compiler::program::Dual;
use bipedc_compiler::tree::{BaseKind, Tree};
use bipedc_runtime::{Argument, Model, Real, State};

/// Where the random trees and states begin; change it to try others.
pub const SEED: u64 = 20_261_121;
/// Random trees on each kind of base: the first half with exact right angles, the others with some of their
/// digits.
const ROUNDS: u64 = 8;
/// Random states of each robot.
pub const STATES: usize = 3;

/// Arguments of a call, indexed by [`Argument`].
#[derive(Clone, Debug)]
pub struct Values<R>(pub [Vec<R>; Argument::COUNT]);

impl<R: Real> Values<R> {
    pub fn of(&self, argument: Argument) -> &[R] {
        &self.0[argument as usize]
    }
    pub fn with(&self, argument: Argument, values: Vec<R>) -> Self {
        let mut other = self.clone();
        other.0[argument as usize] = values;
        other
    }
    pub fn state(&self) -> State<'_, R> {
        let all = Argument::ALL.iter().zip(&self.0);
        all.fold(State::new(), |state, (&argument, values)| state.with(argument, values))
    }
}

impl Values<f64> {
    /// The same on another scalar, constant.
    pub fn lifted<R: Real>(&self) -> Values<R> {
        Values(self.0.each_ref().map(|list| list.iter().map(|&x| R::constant(x)).collect()))
    }
    /// Moving along the given rates.
    pub fn moving(&self, rates: &[(Argument, Vec<f64>)]) -> Values<Dual<f64>> {
        let mut out = self.lifted::<Dual<f64>>();
        for (argument, list) in rates {
            for (x, &rate) in out.0[*argument as usize].iter_mut().zip(list) {
                x.1 = rate;
            }
        }
        out
    }
}

pub struct Subject {
    /// Says how to make it again.
    pub name: String,
    pub robot: Robot,
    pub model: ProgramModel,
}

impl Subject {
    /// `families` without a subject stand for the robot, for all contact points, or for all phases.
    pub fn new(name: String, robot: Robot, families: &[&str]) -> Self {
        let tree = robot.tree().unwrap_or_else(|e| panic!("{name}: {e}"));
        let mut requests = Vec::new();
        for family in families {
            let request = |subject| FunctionRequest { family: (*family).to_owned(), subject };
            let phases = robot.description.phases.iter();
            match entry(family).unwrap().scope {
                Scope::Frame => requests.extend(tree.links.iter().map(|l| request(Some(l.name.clone())))),
                Scope::Phase => requests.extend(phases.map(|p| request(Some(p.name.clone())))),
                Scope::Impact => requests
                    .extend(phases.filter(|p| !p.impact.is_empty()).map(|p| request(Some(p.name.clone())))),
                _ => requests.push(request(None)),
            }
        }
        let model = robot.compile_only(&requests).unwrap_or_else(|e| panic!("{name}: {e}"));
        Self { name, robot, model: ProgramModel::new(model) }
    }

    pub fn tree(&self) -> &Tree {
        &self.model.compiled().tree
    }
    pub fn nv(&self) -> usize {
        self.tree().nv
    }

    /// Column after column.
    pub fn call<R: Real>(&self, function: &str, values: &Values<R>) -> Vec<R>
    where
        ProgramModel: Model<R>,
    {
        let index = Model::<R>::function(&self.model, function)
            .unwrap_or_else(|| panic!("{}: no function {function}", self.name));
        let shape = Model::<R>::signature(&self.model, index).unwrap();
        let mut out = vec![R::constant(f64::NAN); shape.rows * shape.columns];
        self.model
            .evaluate(index, &values.state(), &mut out)
            .unwrap_or_else(|e| panic!("{}: {function}: {e:?}", self.name));
        out
    }

    /// Everything random; the quaternion has length one.
    pub fn state(&self, random: &mut Random) -> Values<f64> {
        let mut values = Values(Argument::ALL.map(|argument| {
            let scale = match argument {
                Argument::A => 5.0,
                Argument::Tau | Argument::Forces => 20.0,
                _ => 2.0,
            };
            random.vector(Model::<f64>::argument_length(&self.model, argument), scale)
        }));
        if self.tree().base == BaseKind::Floating {
            let quaternion = &mut values.0[Argument::Q as usize][3..7];
            let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
            quaternion.iter_mut().for_each(|x| *x /= norm);
        }
        values
    }

    /// q̇ under the velocity `v`.
    pub fn rate(&self, values: &Values<f64>, v: &[f64]) -> Vec<f64> {
        self.tree().configuration_rate(values.of(Argument::Q), v)
    }

    /// The time derivative of a function of q and v along the motion.
    pub fn time_derivative(&self, function: &str, values: &Values<f64>, a: &[f64]) -> Vec<f64> {
        let q_rate = self.rate(values, values.of(Argument::V));
        let moving = values.moving(&[(Argument::Q, q_rate), (Argument::V, a.to_vec())]);
        self.call(function, &moving).iter().map(|x| x.1).collect()
    }

    pub fn close(&self, what: &str, actual: &[f64], expected: &[f64], tolerance: f64) {
        crate::laws::support::assert_close(&format!("{}: {what}", self.name), actual, expected, tolerance);
    }
}

/// The six robots, and random trees on every kind of base.
pub fn subjects(families: &[&str]) -> Vec<Subject> {
    let mut out = six_robots(families);
    out.extend(random_trees(families));
    out
}

pub fn six_robots(families: &[&str]) -> Vec<Subject> {
    let read = |name: &str| Robot::read(&project().join("robots").join(name)).unwrap();
    ROBOTS.iter().map(|name| Subject::new((*name).to_owned(), read(name), families)).collect()
}

pub fn random_trees(families: &[&str]) -> Vec<Subject> {
    let all = (0..ROUNDS).flat_map(|round| KINDS.into_iter().map(move |kind| (round, kind)));
    all.map(|(round, kind)| {
        let digits = if round < ROUNDS / 2 { Digits::All } else { Digits::Some };
        let name = format!("random tree, seed {}, {kind:?}, digits: {digits:?}", SEED + round);
        Subject::new(name, robot(SEED + round, kind, digits), families)
    })
    .collect()
}

/// Calls `check` with random states of every subject.
pub fn in_random_states(subjects: &[Subject], mut check: impl FnMut(&Subject, &Values<f64>)) {
    let mut random = Random(SEED);
    for layout in subjects {
        for _ in 0..STATES {
            check(layout, &layout.state(&mut random));
        }
    }
}

pub fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}
pub fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}
pub fn three(x: &[f64]) -> [f64; 3] {
    [x[0], x[1], x[2]]
}
pub fn plus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(x, y)| x + y).collect()
}
pub fn minus(a: &[f64], b: &[f64]) -> Vec<f64> {
    a.iter().zip(b).map(|(x, y)| x - y).collect()
}
/// A matrix stored column after column, times a vector.
pub fn times(columns: &[f64], x: &[f64]) -> Vec<f64> {
    let rows = columns.len() / x.len();
    (0..rows).map(|r| (0..x.len()).map(|c| columns[c * rows + r] * x[c]).sum()).collect()
}
/// Its transpose times a vector.
pub fn transposed_times(columns: &[f64], x: &[f64]) -> Vec<f64> {
    columns.chunks(x.len()).map(|column| dot(column, x)).collect()
}
