//! What every compiled robot must satisfy, tried at a few random states before anybody relies on it.
//!
//! The inverse dynamics is the plainest recursion of all; everything else has to agree with it: the mass matrix is its
//! slope along accelerations, the forward dynamics undoes it, and the derivatives of both are those of dual numbers. A
//! disagreement is a mistake of this compiler, and says so. Rounding is 1e-9 and less, mistakes have been 1e-3 and more.
use crate::compile::{CompiledModel, Function, FunctionRequest, compile};
use crate::description::model::RobotDescription;
use crate::program::{Dual, Evaluator};
use crate::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::random::Random;
use bipedc_runtime::{Argument, Real, State};

/// Random states of each robot.
const STATES: usize = 2;
/// A row may miss by this much of the sum of its terms' magnitudes …
const TOLERANCE: f64 = 1e-6;
/// … or of the largest row's, for rows whose terms vanish.
const DUST: f64 = 1e-11;

/// The functions that are checked; the first one is what they are checked against.
const CHECKED: [&str; 7] = [
    "inverse_dynamics",
    "mass_matrix",
    "bias",
    "gravity",
    "forward_dynamics",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
];

/// Tries the identities on the functions of `compiled` that they are about; of a robot with effects on its rigid bodies, and
/// the way there and back with the effects.
///
/// # Errors
/// A function that contradicts the inverse dynamics: a mistake of this compiler. Also what [`crate::compile::compile`] refuses.
pub fn self_check(description: &RobotDescription, compiled: &CompiledModel) -> Result<(), Diagnostic> {
    let has = |name: &str| compiled.functions.iter().any(|f| f.name == name);
    let present: Vec<&str> = CHECKED[1..].iter().copied().filter(|name| has(name)).collect();
    if present.is_empty() {
        return Ok(());
    }
    if description.effects.is_empty() {
        return Checked::new(description, compiled, &present)?.check(&present);
    }
    if present.contains(&"forward_dynamics") {
        Checked::new(description, compiled, &["forward_dynamics"])?.check(&["forward_dynamics"])?;
    }
    let rigid = description.clone().without_effects();
    let tree = Tree::new(&rigid, &rigid.base)?;
    let mut compiled = compile(&rigid, &tree, &[request(CHECKED[0])])?;
    for name in &present {
        // Without a rotor's inertia there may be no forward dynamics.
        compiled
            .functions
            .extend(compile(&rigid, &tree, &[request(name)]).into_iter().flat_map(|c| c.functions));
    }
    let there = |name: &&str| compiled.functions.iter().any(|f| f.name == **name);
    let present: Vec<&str> = present.into_iter().filter(there).collect();
    Checked::new(&rigid, &compiled, &present)?.check(&present)
}

fn request(name: &str) -> FunctionRequest {
    FunctionRequest::of_robot(name)
}

/// A robot's functions, ready to be called.
struct Checked<'a> {
    robot: &'a str,
    tree: &'a Tree,
    parameters: usize,
    /// In the order of [`CHECKED`].
    functions: Vec<Option<Evaluator>>,
    rows: Vec<String>,
}

/// Arguments of a call, indexed by [`Argument`].
type Values<R> = [Vec<R>; Argument::COUNT];

impl<'a> Checked<'a> {
    fn new(
        description: &RobotDescription,
        compiled: &'a CompiledModel,
        present: &[&str],
    ) -> Result<Self, Diagnostic> {
        let tree = &compiled.tree;
        let find = |name: &str| compiled.functions.iter().find(|f| f.name == name);
        let evaluator = |f: &Function| Evaluator::new(&f.program);
        let needed = |name: &str| {
            name == "inverse_dynamics"
                || present.contains(&name)
                || (name == "forward_dynamics" && present.contains(&"forward_dynamics_derivatives"))
        };
        let functions = CHECKED
            .iter()
            .map(|name| match find(name) {
                _ if !needed(name) => Ok(None),
                Some(function) => Ok(Some(evaluator(function))),
                // Where no inertia resists a joint there is no forward dynamics.
                None => Ok(compile(description, tree, &[request(name)])
                    .ok()
                    .and_then(|compiled| compiled.functions.first().map(evaluator))),
            })
            .collect::<Result<Vec<_>, Diagnostic>>()?;
        let parameters = compiled.run_time_parameters;
        Ok(Self { robot: &compiled.name, tree, parameters, functions, rows: tree.row_names() })
    }

    fn check(&self, present: &[&str]) -> Result<(), Diagnostic> {
        let mut random = Random::new(0x5eed);
        for _ in 0..STATES {
            let values = self.state(&mut random);
            for name in present {
                self.check_one(name, &values, &mut random)?;
            }
        }
        Ok(())
    }

    fn check_one(&self, name: &str, values: &Values<f64>, random: &mut Random) -> Result<(), Diagnostic> {
        match name {
            "mass_matrix" => self.slope(name, 0, values, Argument::A, random),
            "bias" => self.equal(name, &with_zero(values, &[Argument::A])),
            "gravity" => self.equal(name, &with_zero(values, &[Argument::A, Argument::V])),
            "inverse_dynamics_derivatives" => {
                let blocks = [Argument::Q, Argument::V, Argument::A];
                blocks
                    .iter()
                    .enumerate()
                    .try_for_each(|(k, &argument)| self.slope(name, k, values, argument, random))
            }
            "forward_dynamics" => self.there_and_back(name, values),
            _ => self.forward_slopes(name, values, random),
        }
    }

    /// Everything random; the quaternion has length one.
    fn state(&self, random: &mut Random) -> Values<f64> {
        let mut values = Argument::ALL.map(|argument| {
            let (length, scale) = match argument {
                Argument::Q => (self.tree.nq, 2.0),
                Argument::V => (self.tree.nv, 2.0),
                Argument::A => (self.tree.nv, 5.0),
                Argument::Tau => (self.tree.nv, 20.0),
                Argument::Forces => (3 * self.tree.points.len(), 20.0),
                Argument::Parameters => (self.parameters, 1.0),
                Argument::MotorQ | Argument::MotorV | Argument::MotorA => (self.tree.joints.len(), 2.0),
            };
            (0..length).map(|_| scale * random.symmetric()).collect::<Vec<f64>>()
        });
        if self.tree.base == BaseKind::Floating {
            let quaternion = &mut values[Argument::Q as usize][3..7];
            let norm = quaternion.iter().map(|x| x * x).sum::<f64>().sqrt();
            quaternion.iter_mut().for_each(|x| *x /= norm);
        }
        values
    }

    /// Column after column; `None` if the function was not compiled.
    fn call<R: Real>(&self, name: &str, values: &Values<R>) -> Option<Vec<R>> {
        let place = CHECKED.iter().position(|other| *other == name)?;
        let evaluator = self.functions[place].as_ref()?;
        let state = Argument::ALL
            .iter()
            .zip(values)
            .fold(State::new(), |state, (&argument, list)| state.with(argument, list));
        let mut out = vec![R::constant(0.0); evaluator.outputs()];
        evaluator.run(&state, &mut evaluator.workspace(), &mut out);
        Some(out)
    }

    /// Slope of the inverse dynamics along a velocity (for `Q`) or a change of another argument.
    fn inverse_slope(&self, values: &Values<f64>, argument: Argument, direction: &[f64]) -> Vec<f64> {
        let mut moving: Values<Dual> =
            values.each_ref().map(|list| list.iter().map(|&x| Dual(x, 0.0)).collect());
        let rates = match argument {
            Argument::Q => self.tree.configuration_rate(&values[Argument::Q as usize], direction),
            _ => direction.to_vec(),
        };
        for (x, rate) in moving[argument as usize].iter_mut().zip(rates) {
            x.1 = rate;
        }
        self.call(CHECKED[0], &moving).unwrap_or_default().iter().map(|x| x.1).collect()
    }

    /// The block of a matrix, times a random direction, is a slope of the inverse dynamics.
    fn slope(
        &self,
        name: &str,
        block: usize,
        values: &Values<f64>,
        argument: Argument,
        random: &mut Random,
    ) -> Result<(), Diagnostic> {
        let Some(matrix) = self.call(name, values) else { return Ok(()) };
        let n = self.tree.nv;
        let direction = self.direction(random);
        let (sum, size) = times(&matrix[block * n * n..][..n * n], &direction);
        let expected = self.inverse_slope(values, argument, &direction);
        self.judge(name, &sum, &expected, &size)
    }

    fn direction(&self, random: &mut Random) -> Vec<f64> {
        (0..self.tree.nv).map(|_| random.symmetric()).collect()
    }

    /// A function equals the inverse dynamics at this state.
    fn equal(&self, name: &str, values: &Values<f64>) -> Result<(), Diagnostic> {
        let (Some(got), Some(expected)) = (self.call(name, values), self.call(CHECKED[0], values)) else {
            return Ok(());
        };
        self.judge(name, &got, &expected, &magnitudes(&expected))
    }

    /// The inverse dynamics at the acceleration of the forward dynamics is the torque it was given.
    fn there_and_back(&self, name: &str, values: &Values<f64>) -> Result<(), Diagnostic> {
        let Some(moving) = self.accelerated(values) else { return Ok(()) };
        let tau = &values[Argument::Tau as usize];
        let found = self.call(CHECKED[0], &moving).unwrap_or_default();
        let size = self.inertial_size(values, &moving[Argument::A as usize]);
        let size: Vec<f64> = size.iter().zip(tau).map(|(x, t)| x + t.abs()).collect();
        self.judge(name, &found, tau, &size)
    }

    /// D ∂q̈ + ∂τ at that acceleration = 0 along positions and velocities, D ∂q̈/∂τ = 1.
    fn forward_slopes(
        &self,
        name: &str,
        values: &Values<f64>,
        random: &mut Random,
    ) -> Result<(), Diagnostic> {
        let (Some(matrix), Some(moving)) = (self.call(name, values), self.accelerated(values)) else {
            return Ok(());
        };
        let n = self.tree.nv;
        for (block, argument) in [Argument::Q, Argument::V, Argument::Tau].into_iter().enumerate() {
            let direction = self.direction(random);
            let (change, _) = times(&matrix[block * n * n..][..n * n], &direction);
            if !change.iter().all(|x| x.is_finite()) {
                return Ok(());
            }
            let driven = self.inverse_slope(&moving, Argument::A, &change);
            let expected: Vec<f64> = match argument {
                Argument::Tau => direction,
                _ => self.inverse_slope(&moving, argument, &direction).iter().map(|x| -x).collect(),
            };
            let size = self.inertial_size(values, &change);
            let size: Vec<f64> = size.iter().zip(&expected).map(|(x, e)| x + e.abs()).collect();
            self.judge(name, &driven, &expected, &size)?;
        }
        Ok(())
    }

    /// The state at the acceleration of the forward dynamics; `None` where it is not finite: the mass matrix is singular.
    fn accelerated(&self, values: &Values<f64>) -> Option<Values<f64>> {
        let a = self.call("forward_dynamics", values)?;
        let mut moving = values.clone();
        a.iter().all(|x| x.is_finite()).then(|| {
            moving[Argument::A as usize] = a;
            moving
        })
    }

    /// Σ |D_ij x_j| + |H_i|: what rounding is measured by.
    fn inertial_size(&self, values: &Values<f64>, x: &[f64]) -> Vec<f64> {
        let still = self.call(CHECKED[0], &with_zero(values, &[Argument::A])).unwrap_or_default();
        let mut size = magnitudes(&still);
        for (k, &factor) in x.iter().enumerate() {
            let unit: Vec<f64> = (0..x.len()).map(|i| f64::from(u8::from(i == k))).collect();
            let column = self.inverse_slope(values, Argument::A, &unit);
            size.iter_mut().zip(column).for_each(|(sum, d)| *sum += (d * factor).abs());
        }
        size
    }

    fn judge(&self, name: &str, got: &[f64], expected: &[f64], size: &[f64]) -> Result<(), Diagnostic> {
        let largest = size.iter().chain(expected).fold(0.0_f64, |m, x| m.max(x.abs()));
        for (row, ((&a, &b), &size)) in got.iter().zip(expected).zip(size).enumerate() {
            // Written so that a result that is no number fails too.
            let close = (a - b).abs() <= TOLERANCE * size.max(b.abs()) + DUST * largest;
            if close || !b.is_finite() {
                continue;
            }
            return Err(Diagnostic::error(format!(
                "this is a bug of bipedc, not of your robot: `{name}` of `{}` contradicts the inverse dynamics: row `{}` is {a:e} instead of {b:e} at a random state",
                self.robot, self.rows[row]
            ))
            .help("nothing was written; please report it together with the URDF and biped.toml"));
        }
        Ok(())
    }
}

fn magnitudes(list: &[f64]) -> Vec<f64> {
    list.iter().map(|x| x.abs()).collect()
}

/// The same state with some arguments zero.
fn with_zero(values: &Values<f64>, arguments: &[Argument]) -> Values<f64> {
    let mut out = values.clone();
    for &argument in arguments {
        out[argument as usize].fill(0.0);
    }
    out
}

/// A matrix (column after column) times a vector, and the sums of the terms' magnitudes.
fn times(columns: &[f64], x: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let n = x.len();
    let sum = |r: usize, f: fn(f64) -> f64| (0..n).map(|c| f(columns[c * n + r] * x[c])).sum::<f64>();
    ((0..n).map(|r| sum(r, |y| y)).collect(), (0..n).map(|r| sum(r, f64::abs)).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Robot;
    use crate::program::Operand;
    use std::path::Path;

    fn compiled(names: &[&str]) -> (Robot, CompiledModel) {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../robots/five_link");
        let robot = Robot::read(&folder).unwrap();
        let requests: Vec<FunctionRequest> = names.iter().map(|name| request(name)).collect();
        let compiled = robot.compile_only(&requests).unwrap();
        (robot, compiled)
    }

    /// Each function, spoilt in its last element that is computed, is found.
    #[test]
    fn a_wrong_program_is_found() {
        for name in &CHECKED[1..] {
            let (robot, mut compiled) = compiled(&[name]);
            self_check(&robot.description, &compiled).unwrap();
            let outputs = &mut compiled.functions[0].program.outputs;
            let last = outputs.iter().rposition(|o| matches!(o, Operand::Value(_))).unwrap();
            outputs[last] = Operand::Constant(0.3);
            let error = self_check(&robot.description, &compiled).unwrap_err().to_string();
            assert!(error.contains("bug of bipedc") && error.contains(name), "{error}");
        }
    }
}
