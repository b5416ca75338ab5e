//! A robot that stands on one foot: the same description with that foot, or a point of its sole, as root.
use super::standing_base;
use crate::robot::link_inertias;
use bipedc_analysis::identify::BaseSet;
use bipedc_analysis::identify::excite::postures::{JointPlace, Place, SolePlace, StandingParts};
use bipedc_analysis::robot::inertial_parameters::parameter_index;
use bipedc_analysis::robot::{AnyModel, LinkInertias};
use bipedc_compiler::Robot;
use bipedc_compiler::description::model::{Base, Foot, JointKind, Side};
use bipedc_compiler::exact::Model;
use bipedc_compiler::tree::Tree;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_runtime::nalgebra::{Matrix3, Vector3};

/// Where the root is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Root {
    /// The foot's link: centres of mass above its frame.
    Link,
    /// A point of its sole: moments about a point of the ground.
    Sole,
}

/// A robot on its standing foot.
pub struct StandingRobot {
    /// With effects.
    pub robot: Robot,
    /// Without.
    pub tree: Tree,
    /// Links behind the parameters.
    pub link_inertias: LinkInertias,
    /// Name of the foot.
    pub stance: String,
    /// Link of the robot that carries its own base: the torso.
    pub torso: String,
    root: String,
}

impl StandingRobot {
    /// Stands a robot on the foot of this name; by default the right one, or the only one.
    ///
    /// # Errors
    /// Planar robots; feet that do not exist or have no corners.
    pub fn new(robot: &Robot, stance: Option<&str>, root: Root) -> Result<Self, Diagnostics> {
        let torso = match &robot.description.base {
            Base::Floating { root } => root.clone(),
            Base::Fixed { link } => link.clone(),
            Base::Planar { .. } | Base::Pivot { .. } => {
                return Err(one(Diagnostic::error(
                    "forces of the ground tell parameters of robots in three dimensions",
                )
                .help("choose the base with --base floating")));
            }
        };
        let foot = chosen(&robot.description.feet, stance).map_err(one)?;
        let root = match (root, foot.points.first()) {
            (Root::Link, _) => foot.link.clone(),
            (Root::Sole, Some(point)) => format!("{}/{}", foot.name, point.name),
            (Root::Sole, None) => {
                return Err(one(Diagnostic::error(format!("foot `{}` has no contact points", foot.name))
                    .help("give the corners of its sole in biped.toml: points.front_left = [x, y, z] …")));
            }
        };
        let stance = foot.name.clone();
        // A root that is a contact point names no link: its body carries the robot just as well.
        let torso = if robot.description.links.iter().any(|link| link.name == torso) {
            torso
        } else {
            robot.description.root_link.clone()
        };
        let robot = robot.clone().with_base("floating", Some(&root)).map_err(one)?;
        let rigid = robot.clone().without_effects();
        let tree = rigid.tree().map_err(one)?;
        let link_inertias = link_inertias(&rigid.description, &tree);
        Ok(Self { robot, tree, link_inertias, stance, torso, root })
    }

    /// Base parameters of rows of the centre of mass or the ground's wrench.
    ///
    /// # Errors
    /// As [`standing_base`].
    pub fn base(&self, of: Model, rows: &[&str], feet_flat: bool) -> Result<BaseSet, Diagnostic> {
        standing_base(&self.robot.description, &self.tree, &self.root, (of, rows), feet_flat)
    }

    /// Bodies whose index, of ten parameters each, the thesis' simplified model (8.3.2) treats alike: torso and feet.
    fn bodies_of(&self) -> (Option<usize>, Vec<usize>) {
        let body = |name: &str| self.link_inertias.link(name).map(|link| link.body);
        let feet = self.robot.description.feet.iter().filter_map(|foot| body(&foot.link)).collect();
        (body(&self.torso), feet)
    }

    /// First moments that the simplified model takes as zero: x and y of limbs, y of feet.
    ///
    /// # Errors
    /// Limbs that do not lie along the z axis of their frames.
    pub fn zeros(&self) -> Result<Vec<usize>, Diagnostic> {
        let (torso, feet) = self.bodies_of();
        let mut zeros = Vec::new();
        for body in (0..self.link_inertias.bodies.len()).filter(|b| Some(*b) != torso) {
            if !feet.contains(&body) {
                self.check_limb(body)?;
                zeros.push(parameter_index(body, 1));
            }
            zeros.push(parameter_index(body, 2));
        }
        Ok(zeros)
    }

    /// What the design of postures needs: `model` is of this robot and has `center_of_mass_regressor`; the columns are
    /// those of the base parameters in `base`. What is assumed of limits is added to `assumptions`.
    ///
    /// # Errors
    /// A robot without exactly two feet with flat soles; sliding joints without limits.
    pub fn parts<'m>(
        &self,
        model: AnyModel<'m>,
        base: &BaseSet,
        assumptions: &mut Vec<String>,
    ) -> Result<StandingParts<'m>, Diagnostic> {
        let feet = &self.robot.description.feet;
        let own = feet.iter().position(|foot| foot.name == self.stance);
        let (Some(own), 2) = (own, feet.len()) else {
            return Err(Diagnostic::error(format!(
                "postures are designed for two feet, and the robot has {}",
                feet.len()
            ))
            .help("describe both feet in biped.toml"));
        };
        let names: Vec<String> = self.tree.joints.iter().map(|joint| joint.name.clone()).collect();
        let joints = names.iter().map(|name| self.joint(name, assumptions)).collect::<Result<_, _>>()?;
        Ok(StandingParts {
            model,
            parameters: self.link_inertias.parameters(),
            joints,
            soles: [self.sole(&feet[own])?, self.sole(&feet[1 - own])?],
            torso: self.place(&self.torso)?,
            columns: (0..base.sums.len()).filter_map(|k| base.leading(k)).collect(),
            names,
        })
    }

    /// The frame of a link in its body.
    fn place(&self, link: &str) -> Result<Place, Diagnostic> {
        let missing = || Diagnostic::error(format!("there is no moving link `{link}`"));
        let link = self.link_inertias.link(link).ok_or_else(missing)?;
        Ok(Place {
            body: link.body,
            rotation: Matrix3::from_fn(|i, j| link.rotation[i][j]),
            translation: Vector3::from(link.translation),
        })
    }

    fn joint(&self, name: &str, assumptions: &mut Vec<String>) -> Result<JointPlace, Diagnostic> {
        let described = self.robot.description.joints.iter().find(|joint| joint.name == name);
        let joint = described.ok_or_else(|| Diagnostic::error(format!("there is no joint `{name}`")))?;
        let prismatic = joint.kind == JointKind::Prismatic;
        let limits = match joint.position_limits {
            Some(limits) if limits.0 < limits.1 => limits,
            _ if prismatic => {
                return Err(Diagnostic::error(format!("joint `{name}` slides and has no position limits"))
                    .help("give it <limit lower=\"…\" upper=\"…\"/> in the URDF"));
            }
            _ => {
                assumptions.push(format!("`{name}` has no position limits: -π to π rad"));
                (-std::f64::consts::PI, std::f64::consts::PI)
            }
        };
        let child = self.place(&joint.child)?;
        let parent = self.place(&joint.parent)?.body;
        Ok(JointPlace { child, parent, axis: Vector3::from(joint.axis), prismatic, limits })
    }

    fn sole(&self, foot: &Foot) -> Result<SolePlace, Diagnostic> {
        let refuse = |what: &str| {
            Err(Diagnostic::error(format!("the sole of `{}` {what}", foot.name)).help(
                "postures need flat soles: three or more points in one plane z of the foot's link frame",
            ))
        };
        let heights = || foot.points.iter().map(|point| point.position[2]);
        let low = heights().fold(f64::INFINITY, f64::min);
        if foot.points.len() < 3 {
            return refuse("has fewer than three corners");
        }
        if heights().any(|z| z - low > 1e-6) {
            return refuse("is not flat");
        }
        let link = self.place(&foot.link)?;
        let translation = link.translation + link.rotation * Vector3::new(0.0, 0.0, low);
        let corners = foot.points.iter().map(|point| [point.position[0], point.position[1]]).collect();
        Ok(SolePlace { place: Place { translation, ..link }, corners })
    }

    /// A limb reaches from joint to joint along z.
    fn check_limb(&self, body: usize) -> Result<(), Diagnostic> {
        let links = self.link_inertias.links.iter().filter(|link| link.body == body);
        for link in links {
            let joints =
                self.robot.description.joints.iter().filter(|j| j.parent == link.name && j.kind.moves());
            for joint in joints {
                let [x, y, z] = joint.origin.xyz;
                let length = (x * x + y * y + z * z).sqrt();
                if length > 0.05 && z.abs() < 0.7 * length {
                    let message = format!(
                        "--symmetric takes `{}` as symmetric about the z axis of its frame, but its joint `{}` lies at ({x}, {y}, {z}) m",
                        link.name, joint.name
                    );
                    return Err(Diagnostic::error(message)
                        .help("leave out --symmetric, or let z of the link frames point along the limbs"));
                }
            }
        }
        Ok(())
    }
}

fn one(diagnostic: Diagnostic) -> Diagnostics {
    Diagnostics(vec![diagnostic])
}

/// The foot of this name, or the default.
pub fn chosen<'d>(feet: &'d [Foot], name: Option<&str>) -> Result<&'d Foot, Diagnostic> {
    let known: Vec<&str> = feet.iter().map(|foot| foot.name.as_str()).collect();
    let help = match known[..] {
        [] => "the description names no feet: add them to biped.toml".to_owned(),
        _ => format!("feet of the robot: {}", known.join(", ")),
    };
    match name {
        Some(name) => feet
            .iter()
            .find(|foot| foot.name == name)
            .ok_or_else(|| Diagnostic::error(format!("the robot has no foot `{name}`")).help(help)),
        None => {
            let right = feet.iter().find(|foot| foot.side == Some(Side::Right));
            let only = if let [only] = feet { Some(only) } else { None };
            right.or(only).ok_or_else(|| {
                Diagnostic::error("which foot stands?").help(format!("name it with --stance; {help}"))
            })
        }
    }
}
