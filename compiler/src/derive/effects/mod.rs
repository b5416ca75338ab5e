//! Effects at joints in the equations of motion.
//!
//! With L the rigid-body model's torque at a joint (its row of `D a + H − Jᵀ f`), the true torque is
//! `T = L + Σ laws(q, v, a, L)` and the log reports `u = readings(T)`, both in the order of the description.
//! Inverse dynamics goes this way; forward dynamics goes back (`forward`).
mod derivatives;
mod forward;
mod structure;
mod system;

pub use derivatives::{forward_dynamics_derivatives, inverse_dynamics_derivatives};
pub use forward::{Driven, Returned, forward_dynamics};

use crate::derive::RobotModel;
use crate::description::model::RobotDescription;
use crate::expression::{Sloped, Sym, ValuedFormula};
use crate::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::formula::Formula;
use bipedc_effects::effect::{Effect, Law, Simulation};
use bipedc_runtime::Argument;
use std::collections::BTreeMap;

/// What a law's slopes are taken with respect to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Seed {
    /// Position of the joint with this row of `v`.
    Position(usize),
    /// Its velocity.
    Velocity(usize),
    /// Its acceleration.
    Acceleration(usize),
    /// The rigid-body model's torque at the joint itself.
    Load,
}

/// A law with the row of the joint that it is about, and that of its other joint.
#[derive(Debug, Clone)]
struct TorqueLaw {
    text: ValuedFormula,
    other: Option<usize>,
    /// A coupling of the library by everything but the accelerations.
    without_inertia: bool,
}

/// What stands between true and reported torque.
#[derive(Debug, Clone)]
enum Signal {
    /// From the true torque to the reported one, affine.
    Reading(ValuedFormula),
    /// From the reported torque to the true one.
    True(ValuedFormula),
}

/// All laws of one joint.
#[derive(Debug, Clone)]
struct Joint {
    name: String,
    row: usize,
    torques: Vec<TorqueLaw>,
    signals: Vec<Signal>,
    seeds: Vec<Seed>,
}

/// All effects that act in the joints of a robot.
#[derive(Debug, Clone, Default)]
pub struct JointLaws {
    joints: Vec<Joint>,
    /// Why forward dynamics cannot be had, if so.
    nonlinear: Option<Diagnostic>,
    /// By element of `q`.
    offsets: Vec<f64>,
}

/// The state in which laws are evaluated, by row of `v`.
#[derive(Debug, Clone)]
pub struct At<'g> {
    /// v
    pub velocity: Vec<Sym<'g>>,
    /// v̇
    pub acceleration: Vec<Sym<'g>>,
}

impl<'g> At<'g> {
    /// Velocity and acceleration as given where they count, else zero.
    pub fn new(model: &RobotModel<'g, '_>, velocity: bool, acceleration: bool) -> Self {
        let vector = |argument, counts: bool| {
            let element = |k| if counts { model.input(argument, k) } else { model.constant(0.0) };
            (0..model.tree.nv).map(element).collect()
        };
        Self { velocity: vector(Argument::V, velocity), acceleration: vector(Argument::A, acceleration) }
    }
}

impl JointLaws {
    /// The laws of a description on a tree.
    ///
    /// # Errors
    /// A formula that has no value.
    pub fn new(tree: &Tree, description: &RobotDescription) -> Result<Self, Diagnostic> {
        let mut laws = Self { offsets: offsets(tree, description), ..Self::default() };
        for effect in &description.effects {
            laws.add(tree, effect)?;
        }
        laws.joints.sort_by_key(|joint| joint.row);
        structure::check(&mut laws)?;
        Ok(laws)
    }

    /// Whether no joint has a law.
    pub fn is_empty(&self) -> bool {
        self.joints.is_empty()
    }

    /// What logged positions are too large by, by element of `q`; empty without such effects.
    pub fn offsets(&self) -> &[f64] {
        &self.offsets
    }

    fn add(&mut self, tree: &Tree, effect: &Effect) -> Result<(), Diagnostic> {
        let kind = effect.kind;
        let (Some(text), Some(name)) = (effect.law_text(), &effect.location.joint) else { return Ok(()) };
        let problem = |what: String| Diagnostic::error(format!("effect `{effect}`: {what}"));
        let row = |name: &String| {
            let joint = tree.joints.iter().find(|joint| joint.name == *name);
            joint.map(|joint| joint.v_index).ok_or_else(|| problem(format!("there is no joint `{name}`")))
        };
        let formula = Formula::parse(text).map_err(|error| problem(error.to_string()).help(error.help))?;
        let names = formula.names().iter();
        let parameters: BTreeMap<String, f64> =
            names.filter_map(|name| Some((name.clone(), effect.known(name)?))).collect();
        let text = ValuedFormula { formula, parameters };
        let other = effect.location.other_joint.as_ref().map(row).transpose()?;
        let joint = self.joint(name, row(name)?);
        match kind.law {
            Law::Reading(_) => joint.signals.push(Signal::Reading(text)),
            Law::TrueTorque(_) => joint.signals.push(Signal::True(text)),
            _ => {
                let without_inertia = matches!(kind.simulation, Simulation::Coupling { inertia } if effect.value(inertia) == 0.0);
                joint.torques.push(TorqueLaw { text, other, without_inertia });
                joint.watch(other);
            }
        }
        Ok(())
    }

    fn joint(&mut self, name: &str, row: usize) -> &mut Joint {
        let index = self.joints.iter().position(|joint| joint.row == row).unwrap_or_else(|| {
            let seeds = vec![Seed::Load, Seed::Position(row), Seed::Velocity(row), Seed::Acceleration(row)];
            let name = name.to_owned();
            self.joints.push(Joint { name, row, torques: Vec::new(), signals: Vec::new(), seeds });
            self.joints.len() - 1
        });
        &mut self.joints[index]
    }

    /// Reported torques for the rigid-body model's ones, in the order of `v`.
    pub fn report<'g>(&self, model: &RobotModel<'g, '_>, at: &At<'g>, loads: &[Sym<'g>]) -> Vec<Sym<'g>> {
        let mut out = loads.to_vec();
        for joint in &self.joints {
            out[joint.row] = joint.reported(&joint.torque(model, at, loads[joint.row])).value;
        }
        out
    }

    /// By joint with laws: its row, and the slopes of its reported torque.
    pub fn slopes<'g>(
        &self,
        model: &RobotModel<'g, '_>,
        at: &At<'g>,
        loads: &[Sym<'g>],
    ) -> Vec<(usize, Vec<(Seed, Sym<'g>)>)> {
        let slopes = |joint: &Joint| joint.reported(&joint.torque(model, at, loads[joint.row])).slopes;
        let named = |joint: &Joint| joint.seeds.iter().copied().zip(slopes(joint)).collect();
        self.joints.iter().map(|joint| (joint.row, named(joint))).collect()
    }

    /// Inertias that the laws add to the mass matrix: (row, column, kg m²), at rest.
    pub fn inertias<'g>(&self, model: &RobotModel<'g, '_>) -> Vec<(usize, usize, Sym<'g>)> {
        let at = At::new(model, false, false);
        let of = |joint: &Joint| {
            let torque = joint.torque(model, &at, model.constant(0.0));
            let seeds = joint.seeds.iter().zip(torque.slopes);
            let inertia = |(seed, slope): (&Seed, Sym<'g>)| match seed {
                Seed::Acceleration(column) if !slope.is_zero() => Some((joint.row, *column, slope)),
                _ => None,
            };
            seeds.filter_map(inertia).collect::<Vec<_>>()
        };
        self.joints.iter().flat_map(of).collect()
    }

    /// Whether the acceleration of one joint acts on another.
    pub fn couples(&self) -> bool {
        let couples = |joint: &Joint| {
            joint.torques.iter().any(|law| law.other.is_some() && law.uses("other_acceleration"))
        };
        self.joints.iter().any(couples)
    }

    /// Why a function cannot contain the effects; `None`: it can.
    pub fn refusal(&self, function: &str) -> Option<Diagnostic> {
        let forward = function.starts_with("forward_dynamics") || function == "constrained_dynamics";
        if forward && let Some(problem) = &self.nonlinear {
            return Some(problem.clone());
        }
        let symmetric = matches!(function, "constrained_dynamics" | "impact_map" | "mass_matrix_upper");
        (symmetric && self.couples()).then(|| {
            Diagnostic::error(format!("`{function}` cannot contain an effect by which one joint's acceleration acts on another"))
                .help("its mass matrix is no longer symmetric; use forward_dynamics, or set that inertia to 0 (`coupling`)")
        })
    }
}

impl TorqueLaw {
    fn uses(&self, name: &str) -> bool {
        let stands = self.text.formula.names().iter().any(|n| n == name);
        stands && !(self.without_inertia && name.ends_with("acceleration"))
    }
}

/// By element of `q`, empty if all are zero.
fn offsets(tree: &Tree, description: &RobotDescription) -> Vec<f64> {
    let mut offsets = vec![0.0; tree.nq];
    let base = tree.nq - tree.joints.len();
    for effect in &description.effects {
        let encoder = effect.kind.law == Law::EncoderOffset;
        let joint = tree.joints.iter().position(|joint| effect.location.joint.as_ref() == Some(&joint.name));
        if let (true, Some(joint)) = (encoder, joint) {
            offsets[base + joint] += effect.value("offset");
        }
    }
    if offsets.iter().all(|&x| x == 0.0) { Vec::new() } else { offsets }
}

impl Joint {
    /// Adds the other joint's motion to the seeds.
    fn watch(&mut self, other: Option<usize>) {
        let Some(row) = other else { return };
        if !self.seeds.contains(&Seed::Position(row)) {
            self.seeds.extend([Seed::Position(row), Seed::Velocity(row), Seed::Acceleration(row)]);
        }
    }

    fn value<'g>(&self, model: &RobotModel<'g, '_>, at: &At<'g>, seed: Seed, load: Sym<'g>) -> Sloped<'g> {
        let tree = model.tree;
        let value = match seed {
            Seed::Position(row) => model.input(Argument::Q, row + tree.nq - tree.nv),
            Seed::Velocity(row) => at.velocity[row],
            Seed::Acceleration(row) => at.acceleration[row],
            Seed::Load => load,
        };
        let index = self.seeds.iter().position(|other| *other == seed).unwrap_or(0);
        Sloped::seed(value, index, self.seeds.len())
    }

    /// T, with its slopes with respect to the seeds.
    fn torque<'g>(&self, model: &RobotModel<'g, '_>, at: &At<'g>, load: Sym<'g>) -> Sloped<'g> {
        let value = |seed| self.value(model, at, seed, load);
        let mut sum = value(Seed::Load);
        for law in &self.torques {
            let row = self.row;
            let mut variables = vec![
                ("position", value(Seed::Position(row))),
                ("velocity", value(Seed::Velocity(row))),
                ("acceleration", value(Seed::Acceleration(row))),
                ("load", value(Seed::Load)),
            ];
            if let Some(other) = law.other {
                variables.push(("other_position", value(Seed::Position(other))));
                variables.push(("other_velocity", value(Seed::Velocity(other))));
                variables.push(("other_acceleration", value(Seed::Acceleration(other))));
            }
            // Laws without a value were refused when they were read.
            if let Ok(torque) = law.text.of(&variables) {
                sum = sum.plus(&torque);
            }
        }
        sum
    }

    /// What the log reports of a true torque. A drive cannot report more than it is able to give: what clips
    /// the true torque clips the prediction too.
    fn reported<'g>(&self, torque: &Sloped<'g>) -> Sloped<'g> {
        self.signals.iter().fold(torque.clone(), |torque, signal| {
            let (Signal::Reading(text) | Signal::True(text)) = signal;
            text.of(&[("torque", torque.clone()), ("reading", torque.clone())]).unwrap_or(torque)
        })
    }

    /// The true torque of a reported one, with its slope.
    fn truth<'g>(&self, reported: Sym<'g>) -> Sloped<'g> {
        self.signals.iter().rev().fold(Sloped::seed(reported, 0, 1), |torque, signal| match signal {
            Signal::True(text) => text.of(&[("reading", torque.clone())]).unwrap_or(torque),
            Signal::Reading(text) => {
                let zero = Sloped::seed(reported.zero(), 0, 1);
                match text.of(&[("torque", zero)]) {
                    Ok(law) => Sloped {
                        value: (torque.value - law.value) / law.slopes[0],
                        slopes: vec![torque.slopes[0] / law.slopes[0]],
                    },
                    Err(_) => torque,
                }
            }
        })
    }
}
