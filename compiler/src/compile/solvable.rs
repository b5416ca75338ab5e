//! Which functions a robot has at all: inverses need inertia along every coordinate, means need mass.
use crate::derive::effects::JointLaws;
use crate::derive::unresisted::unresisted;
use crate::derive::{InertiaMode, RobotModel};
use crate::description::model::{Base, Contact, ContactPart, RobotDescription};
use crate::expression::Graph;
use crate::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::Diagnostic;
use std::cell::OnceCell;

/// What stands in the way of functions of one robot; found when first asked for.
pub struct Solvable<'t> {
    description: &'t RobotDescription,
    tree: &'t Tree,
    laws: &'t JointLaws,
    without_inertia: OnceCell<Vec<String>>,
}

impl<'t> Solvable<'t> {
    /// Of a description on a tree.
    pub fn new(description: &'t RobotDescription, tree: &'t Tree, laws: &'t JointLaws) -> Self {
        Self { description, tree, laws, without_inertia: OnceCell::new() }
    }

    /// Rows of `v` along which nothing resists an acceleration, by name; effects with inertia count.
    pub fn without_inertia(&self) -> &[String] {
        self.without_inertia.get_or_init(|| {
            let names = self.tree.row_names();
            let rows = unresisted(self.tree, &added(self.tree, self.laws));
            rows.into_iter().map(|row| names[row].clone()).collect()
        })
    }

    /// Why a function has no value in any state; `None`: it has, or depends on run-time parameters.
    pub fn refusal(&self, function: &str, subject: Option<&str>) -> Option<Diagnostic> {
        if self.description.generate.runtime_parameters {
            return None;
        }
        if divides_by_mass(function) && self.tree.total_mass() == 0.0 {
            return Some(
                Diagnostic::error(format!("`{function}` has no value: nothing that moves has mass"))
                    .help("add <inertial> to links that move, or choose a base that moves with --base"),
            );
        }
        let rows = match function {
            "constrained_dynamics" | "impact_map" => self.without_inertia_on(function, subject),
            _ if function.starts_with("forward_dynamics") => self.without_inertia().to_vec(),
            _ => return None,
        };
        (!rows.is_empty()).then(|| {
            Diagnostic::error(format!("`{function}` has no solution: {}", no_inertia(self.tree, &rows)))
                .help(format!("{}; or leave the function out under [generate]", inertia_help(&rows)))
        })
    }

    /// The same rows in a phase: a free robot that stands on a flat foot hangs on that foot.
    fn without_inertia_on(&self, function: &str, phase: Option<&str>) -> Vec<String> {
        let phase = self.description.phases.iter().find(|other| Some(other.name.as_str()) == phase);
        let contacts = phase.map(|p| if function == "impact_map" { &p.impact } else { &p.contacts });
        let sole = contacts.and_then(|contacts| self.flat(contacts));
        let Some(link) = sole.filter(|_| self.tree.base == BaseKind::Floating) else {
            return self.without_inertia().to_vec();
        };
        // Without the base's six rows; a tree that cannot be built is told where it is asked for.
        let Ok(tree) = Tree::new(self.description, &Base::Fixed { link }) else { return Vec::new() };
        let added = added(self.tree, self.laws).split_off(self.tree.base_nv());
        let names = tree.row_names();
        unresisted(&tree, &added).into_iter().map(|row| names[row].clone()).collect()
    }

    /// The link of the first foot whose whole sole stands.
    fn flat(&self, contacts: &[Contact]) -> Option<String> {
        let flat = contacts.iter().filter(|contact| contact.part == ContactPart::Flat);
        let feet =
            flat.filter_map(|contact| self.description.feet.iter().find(|foot| foot.name == contact.foot));
        feet.filter(|foot| foot.points.len() > 2).map(|foot| foot.link.clone()).next()
    }
}

/// What to do about motions that nothing resists.
pub fn inertia_help(rows: &[String]) -> &'static str {
    if rows.iter().all(|row| row.starts_with("base/")) {
        return "give the links masses and inertias in the URDF that resist it, or fix the base (`[base]`, kind = \"fixed\")";
    }
    "give the links that it moves an inertia about that axis in the URDF, or the joint the inertia of its drive (`[[effect]]`, kind = \"rotor_inertia\")"
}

/// Which motions nothing resists, as a sentence.
pub fn no_inertia(tree: &Tree, rows: &[String]) -> String {
    let linear = |name: &String| {
        tree.row_names().iter().position(|other| other == name).is_some_and(|row| tree.row_is_linear(row))
    };
    let of = |name: &String| match linear(name) {
        true => format!("no mass follows joint `{name}` along its axis"),
        false => format!("no inertia resists joint `{name}` about its axis"),
    };
    let (base, joints): (Vec<&String>, Vec<&String>) = rows.iter().partition(|row| row.starts_with("base/"));
    let quoted: Vec<String> = base.iter().map(|row| format!("`{row}`")).collect();
    let base =
        (!quoted.is_empty()).then(|| format!("nothing resists motions of the base ({})", quoted.join(", ")));
    base.into_iter().chain(joints.into_iter().map(of)).collect::<Vec<_>>().join("; ")
}

fn divides_by_mass(function: &str) -> bool {
    let mean = function.starts_with("center_of_mass") && function != "center_of_mass_regressor";
    mean || function.starts_with("centroidal") || function == "zero_moment_point"
}

/// Inertias that effects add to the diagonal of the mass matrix, by row of `v`. What depends on the state counts as one.
fn added(tree: &Tree, laws: &JointLaws) -> Vec<f64> {
    let mut out = vec![0.0; tree.nv];
    if laws.is_empty() {
        return out;
    }
    let graph = Graph::new();
    let model = RobotModel::new(&graph, tree, InertiaMode::Plain);
    for (row, column, inertia) in laws.inertias(&model) {
        if row == column {
            out[row] += inertia.constant_value().unwrap_or(1.0);
        }
    }
    out
}
