//! The models whose base parameters one asks for by name.
use super::{BaseParameters, ParameterList, StateSpace, base_parameters};
use crate::derive::{InertiaMode, Motions, RobotModel, momentum, newton_euler};
use crate::description::model::{Base, RobotDescription, Side};
use crate::expression::{Expr, Graph, Sym};
use crate::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::Diagnostic;

/// A quantity that is linear in the inertial parameters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Model {
    /// Total mass times centre of mass (4.35) in the frame of the standing root: rows x, y, z.
    CenterOfMass,
    /// The ground's wrench on the standing root about its frame, whose ratios are the zero moment point
    /// (4.42): rows Fx, Fy, Fz, Mx, My, Mz; by default Mx, My, Fz.
    ZeroMomentPoint,
    /// Equations of motion: the rows of the velocity; groups `base` and `joints`; by default all, for a fixed
    /// root the joints.
    Dynamics,
    /// Energy: rows total (default), kinetic, potential.
    Energy,
}

impl std::str::FromStr for Model {
    type Err = Diagnostic;
    /// `com`, `zmp`, `dynamics`, `energy`.
    fn from_str(name: &str) -> Result<Self, Diagnostic> {
        match name {
            "com" => Ok(Self::CenterOfMass),
            "zmp" => Ok(Self::ZeroMomentPoint),
            "dynamics" => Ok(Self::Dynamics),
            "energy" => Ok(Self::Energy),
            _ => Err(Diagnostic::error(format!("`{name}` has no base parameters"))
                .help("models are com, zmp, dynamics, energy")),
        }
    }
}

/// What `bipedc inspect … base-parameters` is asked.
#[derive(Debug, Clone, PartialEq)]
pub struct Question {
    /// The model.
    pub of: Model,
    /// Root link, contact point or foot; by default that of the description, for `com` and `zmp` the right
    /// foot.
    pub root: Option<String>,
    /// Whether the root stands still; by default for `com` and `zmp`, and if the description's base is fixed.
    pub fixed: Option<bool>,
    /// Rows by name; none: the model's default.
    pub rows: Vec<String>,
    /// All feet but the root stay parallel to the ground.
    pub feet_flat: bool,
    /// Parameters per link; by default four for `com` and ten for the others.
    pub list: Option<ParameterList>,
}

impl Question {
    /// The plain question about a model.
    pub fn new(of: Model) -> Self {
        Self { of, root: None, fixed: None, rows: Vec::new(), feet_flat: false, list: None }
    }

    /// Answers it.
    ///
    /// # Errors
    /// Names that do not exist, feet that cannot be kept flat.
    pub fn answer(&self, description: &RobotDescription) -> Result<BaseParameters, Diagnostic> {
        let (base, pinned) = self.base(description);
        let written = Tree::new(description, &base)?;
        let tree = written.structure();
        let mut space = if pinned { StateSpace::pinned(tree) } else { StateSpace::free(tree) };
        if self.feet_flat {
            if description.feet.is_empty() {
                return Err(Diagnostic::error("no feet to keep flat: the description names none")
                    .help("add the feet to biped.toml"));
            }
            let feet = space.movable(description.feet.iter().map(|foot| foot.link.as_str()));
            space = space.with_flat(feet);
        }
        let graph = Graph::exact();
        let model = RobotModel::new(&graph, tree, InertiaMode::Symbolic);
        let rows = self.select(all_rows(&model, self.of), tree, pinned)?;
        let default = if self.of == Model::CenterOfMass {
            ParameterList::FirstMoments
        } else {
            ParameterList::Standard
        };
        base_parameters(&graph, &rows, &space, self.list.unwrap_or(default))
    }

    /// The base to derive with, and whether it stands still.
    ///
    /// A fixed root is a floating one at rest: so its own parameters are among the columns.
    fn base(&self, description: &RobotDescription) -> (Base, bool) {
        let on_ground = matches!(self.of, Model::CenterOfMass | Model::ZeroMomentPoint);
        let own = match &description.base {
            Base::Floating { root } | Base::Planar { root } => root,
            Base::Fixed { link } => link,
            Base::Pivot { about } => about,
        };
        let is_fixed = matches!(description.base, Base::Fixed { .. });
        let right = description.feet.iter().find(|foot| foot.side == Some(Side::Right));
        let foot = right.or(description.feet.first()).filter(|_| on_ground && !is_fixed);
        let default = foot.map_or(own, |foot| &foot.link);
        let pinned = self.fixed.unwrap_or(on_ground || is_fixed);
        let root = self.root.clone().unwrap_or_else(|| default.clone());
        let base = match &description.base {
            Base::Planar { .. } => Base::Planar { root },
            Base::Pivot { .. } if self.root.is_none() && !pinned => description.base.clone(),
            _ => Base::Floating { root },
        };
        (base, pinned)
    }

    fn select(&self, all: Vec<(String, Expr)>, tree: &Tree, pinned: bool) -> Result<Vec<Expr>, Diagnostic> {
        let defaults: &[&str] = match self.of {
            Model::CenterOfMass => &["x", "y", "z"],
            Model::ZeroMomentPoint => &["Mx", "My", "Fz"],
            Model::Dynamics if pinned => &["joints"],
            Model::Dynamics if tree.joints.is_empty() => &["base"],
            Model::Dynamics => &["base", "joints"],
            Model::Energy => &["total"],
        };
        let wanted: Vec<&str> = if self.rows.is_empty() {
            defaults.to_vec()
        } else {
            self.rows.iter().map(String::as_str).collect()
        };
        let joints: Vec<&str> = tree.joints.iter().map(|joint| joint.name.as_str()).collect();
        let mut out = Vec::new();
        for name in wanted {
            let matches = |row: &str| match name {
                "joints" => joints.contains(&row),
                "base" => row.starts_with("base/"),
                _ => row == name,
            };
            let found = all.iter().filter(|(row, _)| matches(row)).map(|&(_, e)| e).collect::<Vec<_>>();
            if found.is_empty() && !(name == "base" && tree.base == BaseKind::Fixed) {
                let known: Vec<&str> = all.iter().map(|(row, _)| row.as_str()).collect();
                return Err(Diagnostic::error(format!("the model has no row `{name}`"))
                    .help(format!("rows are: {}", known.join(", "))));
            }
            out.extend(found);
        }
        Ok(out)
    }
}

/// All rows of a model with their names.
fn all_rows(model: &RobotModel<'_, '_>, of: Model) -> Vec<(String, Expr)> {
    let named = |names: &[&str], rows: &[Sym<'_>]| {
        names.iter().zip(rows).map(|(name, row)| ((*name).to_owned(), row.expr)).collect()
    };
    match of {
        Model::CenterOfMass => named(&["x", "y", "z"], &momentum::first_moment(model).0),
        Model::ZeroMomentPoint => {
            let wrench = momentum::ground_wrench(model);
            let rows = [wrench.linear.0, wrench.angular.0].concat();
            named(&["Fx", "Fy", "Fz", "Mx", "My", "Mz"], &rows)
        }
        Model::Dynamics => {
            let motions = Motions { velocity: true, acceleration: true, gravity: true };
            let forces = newton_euler::generalised_forces(model, motions, false);
            model.tree.row_names().into_iter().zip(forces).map(|(name, row)| (name, row.expr)).collect()
        }
        Model::Energy => {
            let (kinetic, potential) = (momentum::kinetic_energy(model), momentum::potential_energy(model));
            named(&["total", "kinetic", "potential"], &[kinetic + potential, kinetic, potential])
        }
    }
}
