//! The robot as amended, as MuJoCo's own format.
use super::element::Element;
use bipedc_compiler::Robot;
use bipedc_compiler::description::model::{Base, Inertial, Joint, JointKind, Pose, RobotDescription};
use bipedc_compiler::tree::{Inertia, as_built};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Acts, Effect, kinds};

/// Radius of the spheres that stand for contact points, m: their lowest point is so far below.
const CONTACT_RADIUS: f64 = 0.001;

/// A model for MuJoCo, and what it does not say.
#[derive(Debug, Clone, PartialEq)]
pub struct ExportedMjcf {
    /// The file's text.
    pub mjcf: String,
    /// Effects that are not in it.
    pub left_out: Vec<Effect>,
}

/// Writes links, joints, the effects of bodies, `viscous_friction`, `coulomb_friction`, `rotor_inertia` and `parallel_spring` of
/// joints, contact points as small spheres on a floor, and a motor for every actuated joint.
///
/// # Errors
/// A base that is not the URDF's root.
pub fn mjcf(robot: &Robot) -> Result<ExportedMjcf, Diagnostic> {
    let description = as_built(&robot.description);
    let (passive, left_out) = passive(&robot.description);
    let writer = Writer { description: &description, passive };
    let mut model = Element::new("mujoco").with("model", &description.name);
    model.add(Element::new("compiler").with("angle", "radian").with("autolimits", "true"));
    let gravity = numbers(&description.gravity);
    model.add(Element::new("option").with("timestep", "0.001").with("gravity", &gravity));
    model.add(writer.world()?);
    model.add(writer.motors());
    let note = format!(
        "{} by bipedc: metres, kilograms, seconds, radians; link frames as in the URDF",
        description.name.replace("--", "-")
    );
    Ok(ExportedMjcf { mjcf: format!("<!-- {note} -->\n{}", model.text()), left_out })
}

/// Attributes of a joint that effects become.
#[derive(Debug, Default)]
struct Passive {
    damping: f64,
    friction: f64,
    armature: f64,
    /// Stiffness and angle without torque.
    spring: Option<[f64; 2]>,
}

/// By joint, and the effects that have no attribute.
fn passive(description: &RobotDescription) -> (Vec<(String, Passive)>, Vec<Effect>) {
    let mut all: Vec<(String, Passive)> = Vec::new();
    let mut left_out = Vec::new();
    for effect in &description.effects {
        if effect.kind.law.acts() == Acts::Body {
            continue;
        }
        let Some(joint) = &effect.location.joint else {
            left_out.push(effect.clone());
            continue;
        };
        let at = all.iter().position(|(name, _)| name == joint).unwrap_or_else(|| {
            all.push((joint.clone(), Passive::default()));
            all.len() - 1
        });
        if !all[at].1.take(effect) {
            left_out.push(effect.clone());
        }
    }
    (all, left_out)
}

impl Passive {
    /// Whether there is an attribute for it, and it is free.
    fn take(&mut self, effect: &Effect) -> bool {
        let kind = effect.kind;
        if kind == &kinds::VISCOUS_FRICTION {
            self.damping += effect.value("damping");
        } else if kind == &kinds::COULOMB_FRICTION {
            self.friction += effect.value("torque");
        } else if kind == &kinds::ROTOR_INERTIA {
            self.armature += effect.value("inertia");
        } else if kind == &kinds::PARALLEL_SPRING && self.spring.is_none() {
            self.spring = Some(["stiffness", "rest_angle"].map(|name| effect.value(name)));
        } else {
            return false;
        }
        true
    }
}

struct Writer<'a> {
    description: &'a RobotDescription,
    passive: Vec<(String, Passive)>,
}

impl Writer<'_> {
    fn world(&self) -> Result<Element, Diagnostic> {
        let description = self.description;
        let root = &description.root_link;
        let mut world = Element::new("worldbody");
        // Below a robot on a stand nobody knows where the floor is; its feet would stand in it.
        if !matches!(description.base, Base::Fixed { .. }) {
            let floor = Element::new("geom").with("name", "floor").with("type", "plane");
            let floor = floor.with("size", "0 0 0.05");
            world.add(floor.with("contype", "0").with("conaffinity", "1"));
        }
        let base = self.base()?;
        if root == "world" && base.is_empty() {
            for joint in description.joints.iter().filter(|joint| joint.parent == *root) {
                world.add(self.body(&joint.child, Some(joint), Vec::new()));
            }
        } else {
            world.add(self.body(root, None, base));
        }
        Ok(world)
    }

    /// The joints of the root.
    fn base(&self) -> Result<Vec<Element>, Diagnostic> {
        let refused = |what: &str| {
            let message = format!("MJCF: {what}, and MJCF has its root where the URDF has it");
            Err(Diagnostic::error(message)
                .help("export it with the base `floating`, `planar` or `fixed` at the URDF's root"))
        };
        let along = |name: &str, kind: &str, axis: &str| {
            Element::new("joint").with("name", name).with("type", kind).with("axis", axis)
        };
        match &self.description.base {
            Base::Floating { .. } => Ok(vec![Element::new("freejoint").with("name", "base")]),
            Base::Planar { .. } => Ok(vec![
                along("base_x", "slide", "1 0 0"),
                along("base_z", "slide", "0 0 1"),
                along("base_pitch", "hinge", "0 1 0"),
            ]),
            Base::Fixed { link } if *link == self.description.root_link => Ok(Vec::new()),
            Base::Fixed { link } => refused(&format!("the base is fixed at `{link}`")),
            Base::Pivot { about } => refused(&format!("the base turns about `{about}`")),
        }
    }

    fn body(&self, link: &str, joint: Option<&Joint>, base: Vec<Element>) -> Element {
        let description = self.description;
        let mut body = Element::new("body").with("name", link);
        if let Some(joint) = joint {
            body = placed(body, &joint.origin);
        }
        base.into_iter().for_each(|joint| body.add(joint));
        if let Some(joint) = joint.filter(|joint| joint.kind.moves()) {
            body.add(self.joint(joint));
        }
        let inertial = description.links.iter().find(|other| other.name == link).and_then(|l| l.inertial);
        if let Some(inertial) = inertial.filter(|inertial| inertial.mass > 0.0) {
            body.add(mass(&inertial));
        }
        for foot in description.feet.iter().filter(|foot| foot.link == link) {
            for point in &foot.points {
                let name = format!("{}/{}", foot.name, point.name);
                let sphere = Element::new("geom").with("name", &name).with("type", "sphere");
                let sphere = sphere.with("size", &CONTACT_RADIUS.to_string()).with("mass", "0");
                let sphere = sphere.with("pos", &numbers(&point.position));
                body.add(sphere.with("contype", "1").with("conaffinity", "0"));
            }
        }
        for joint in description.joints.iter().filter(|joint| joint.parent == link) {
            body.add(self.body(&joint.child, Some(joint), Vec::new()));
        }
        body
    }

    fn joint(&self, joint: &Joint) -> Element {
        let kind = if joint.kind == JointKind::Prismatic { "slide" } else { "hinge" };
        let mut element = Element::new("joint").with("name", &joint.name).with("type", kind);
        element = element.with("axis", &numbers(&joint.axis));
        if let Some((low, high)) = joint.position_limits.filter(|(low, high)| low < high) {
            element = element.with("range", &numbers(&[low, high]));
        }
        let Some((_, passive)) = self.passive.iter().find(|(name, _)| *name == joint.name) else {
            return element;
        };
        let values = [
            ("damping", passive.damping),
            ("frictionloss", passive.friction),
            ("armature", passive.armature),
        ];
        for (key, value) in values.into_iter().filter(|(_, value)| *value != 0.0) {
            element = element.with(key, &value.to_string());
        }
        match passive.spring {
            Some([stiffness, rest]) => {
                element.with("stiffness", &stiffness.to_string()).with("springref", &rest.to_string())
            }
            None => element,
        }
    }

    fn motors(&self) -> Element {
        let mut all = Element::new("actuator");
        for name in &self.description.actuated_joints {
            let joint = self.description.joints.iter().find(|joint| joint.name == *name);
            let limit = joint.and_then(|joint| joint.effort_limit);
            let motor = Element::new("motor").with("name", name).with("joint", name);
            all.add(match limit {
                Some(limit) => motor.with("ctrlrange", &numbers(&[-limit, limit])),
                None => motor,
            });
        }
        all
    }
}

fn placed(body: Element, pose: &Pose) -> Element {
    let body = if pose.xyz == [0.0; 3] { body } else { body.with("pos", &numbers(&pose.xyz)) };
    if pose.rpy == [0.0; 3] {
        return body;
    }
    // Roll, pitch and yaw about fixed axes: first roll, then pitch, then yaw.
    let half = pose.rpy.map(|angle| (0.5 * angle).sin_cos());
    let [(sr, cr), (sp, cp), (sy, cy)] = half;
    let quaternion = [
        cr * cp * cy + sr * sp * sy,
        sr * cp * cy - cr * sp * sy,
        cr * sp * cy + sr * cp * sy,
        cr * cp * sy - sr * sp * cy,
    ];
    body.with("quat", &numbers(&quaternion))
}

/// Mass, centre of mass, and inertia about it in the link's axes.
fn mass(inertial: &Inertial) -> Element {
    let turned = Inertial { origin: Pose { xyz: [0.0; 3], ..inertial.origin }, ..*inertial };
    let m = if inertial.origin.rpy == [0.0; 3] {
        let [xx, xy, xz, yy, yz, zz] = inertial.inertia;
        [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]
    } else {
        Inertia::from_inertial(&turned).second_moment
    };
    Element::new("inertial")
        .with("pos", &numbers(&inertial.origin.xyz))
        .with("mass", &inertial.mass.to_string())
        .with("fullinertia", &numbers(&[m[0][0], m[1][1], m[2][2], m[0][1], m[0][2], m[1][2]]))
}

fn numbers(values: &[f64]) -> String {
    values.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}
