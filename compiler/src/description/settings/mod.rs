//! `biped.toml`: what the URDF cannot say. Every key has a default; `robots/README.md` lists them all.
mod base;
mod drives;
pub(super) mod effects;
mod feet;
mod formula;
mod joints;
mod phases;
mod symmetry;
pub(super) mod table;

use super::geometry::Frame;
use super::model::{
    Base, Foot, Generate, JointDrive, JointKind, Phase, RobotDescription, SymmetricPair, slides,
};
use super::source::{Messages, Place, short, suggest};
use super::urdf::UrdfRobot;
use bipedc_effects::effect::{Effect, Location};
pub(crate) use feet::{SIDES, side_of_name};
pub(crate) use symmetry::mirror_sign;
use table::Section;
use toml::de::DeTable;

/// Keys of the top level, in the order of the documentation.
const KEYS: [&str; 12] = [
    "name",
    "urdf",
    "gravity",
    "base",
    "joints",
    "feet",
    "symmetry",
    "actuation",
    "drives",
    "phase",
    "generate",
    "effect",
];

/// Standard gravity of the robots' descriptions, m/s².
const GRAVITY: [f64; 3] = [0.0, 0.0, -9.81];

/// The file's own name for the URDF beside it.
pub(crate) const DEFAULT_URDF: &str = "robot.urdf";

/// What a description may refer to; `None` while the URDF is unreadable, so that nothing is reported twice.
#[derive(Debug, Clone, Copy)]
pub(in crate::description) struct Known<'r> {
    pub(in crate::description) robot: Option<&'r UrdfRobot>,
}

impl<'r> Known<'r> {
    /// The frames of all links at zero posture; empty without a sound tree.
    pub(super) fn frames(&self) -> Vec<Frame> {
        let frames = || Some(self.robot?.tree.as_ref()?.frames(self.robot?));
        frames().unwrap_or_default()
    }

    /// Whether the joint of a place slides.
    pub(super) fn slides(&self, place: &Location) -> bool {
        self.robot.is_some_and(|robot| slides(&robot.joints, place))
    }

    /// Reports a link that does not exist.
    pub(super) fn check_link(&self, name: &str, place: Place, what: &str, messages: &mut Messages<'_>) {
        let Some(robot) = self.robot else { return };
        // Without a tree there is no root to be the base by default, which is reported already.
        if name.is_empty() && robot.tree.is_none() {
            return;
        }
        if robot.links.iter().all(|link| link.name != name) {
            let names: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
            let message = format!("{what}: the URDF has no link `{}`", short(name));
            messages.error(place, message, suggest(name, names, "links of the URDF"));
        }
    }

    /// Reports a joint that does not exist or does not move.
    pub(super) fn check_joint(&self, name: &str, place: Place, what: &str, messages: &mut Messages<'_>) {
        let Some(robot) = self.robot else { return };
        let moving = || robot.joints.iter().filter(|joint| joint.kind.moves()).map(|j| j.name.as_str());
        match robot.joints.iter().find(|joint| joint.name == name) {
            Some(joint) if joint.kind == JointKind::Fixed && !robot.locked.contains(&joint.name) => {
                let message = format!("{what}: joint `{}` is fixed", short(name));
                messages.error(place, message, suggest(name, moving().collect::<Vec<_>>(), "moving joints"));
            }
            Some(_) => {}
            None => {
                let message = format!("{what}: the URDF has no joint `{}`", short(name));
                messages.error(place, message, suggest(name, moving().collect::<Vec<_>>(), "moving joints"));
            }
        }
    }
}

/// Everything `biped.toml` can say, defaults filled in.
#[derive(Debug)]
struct Settings {
    name: Option<String>,
    gravity: [f64; 3],
    feet: Vec<Foot>,
    base: Base,
    symmetric_joints: Vec<SymmetricPair>,
    actuated_joints: Vec<String>,
    motor_encoders: Vec<String>,
    drives: Vec<JointDrive>,
    phases: Vec<Phase>,
    effects: Vec<Effect>,
    generate: Generate,
}

/// The URDF's file name that `biped.toml` gives, if it is readable and gives one.
pub(crate) fn urdf_name(toml_text: &str) -> Option<String> {
    let (table, _) = DeTable::parse_recoverable(toml_text);
    table.get_ref().get("urdf")?.get_ref().as_str().map(str::to_string)
}

/// Reads `biped.toml` and joins it with the URDF; `None` if the URDF is missing or anything was refused.
pub(crate) fn describe(
    text: &str,
    mut robot: Option<UrdfRobot>,
    messages: &mut Messages<'_>,
) -> Option<RobotDescription> {
    let (table, errors) = DeTable::parse_recoverable(text);
    for error in &errors {
        let at = error.span().map(|span| span.start);
        messages.error(
            at,
            format!("broken TOML: {}", error.message().replace('\n', "; ")),
            "texts stand in quotes, lists in [ ], sections begin with [name]; each key stands once",
        );
    }
    // After a syntax error the recovered table lacks things: only the syntax is worth reporting.
    if !errors.is_empty() {
        return None;
    }
    let top = Section::top(table.get_ref());
    if let Some(robot) = &mut robot {
        joints::lock(&top, robot, messages);
    }
    let mut settings = read_settings(&top, Known { robot: robot.as_ref() }, messages);
    if let Some(robot) = &robot {
        joints::leave_out_locked(&mut settings, &robot.locked, messages);
    }
    let robot = robot?;
    let root = robot.tree.as_ref()?.root;
    if messages.errors() > 0 {
        return None;
    }
    Some(RobotDescription {
        name: settings.name.unwrap_or_else(|| default_name(&robot.name)),
        root_link: robot.links[root].name.clone(),
        links: robot.links,
        joints: robot.joints,
        base: settings.base,
        gravity: settings.gravity,
        feet: settings.feet,
        symmetric_joints: settings.symmetric_joints,
        actuated_joints: settings.actuated_joints,
        motor_encoders: settings.motor_encoders,
        drives: settings.drives,
        phases: settings.phases,
        effects: settings.effects,
        generate: settings.generate,
    })
}

fn default_name(urdf_name: &str) -> String {
    if urdf_name.is_empty() { "robot".into() } else { urdf_name.into() }
}

fn read_settings(top: &Section<'_, '_>, known: Known<'_>, messages: &mut Messages<'_>) -> Settings {
    top.check_keys(&KEYS, messages);
    // Only checked here: whoever reads the files needs it before this.
    let _ = top.string("urdf", messages);
    let name = top.string("name", messages).and_then(|(name, at)| check_name(name, at, messages));
    let gravity = top.get("gravity").and_then(|entry| entry.vector(messages)).unwrap_or(GRAVITY);
    let feet = feet::read_feet(top, known, messages);
    let base = base::read_base(top, known, &feet, messages);
    base::check_motion(top, known, &base, gravity, messages);
    let symmetric_joints = symmetry::read_symmetry(top, known, messages);
    let drives = drives::read_drives(top, known, messages);
    let actuated_joints = drives::read_actuation(top, known, &drives, messages);
    let motor_encoders = joints::read_motor_encoders(top, known, &drives, messages);
    let planar = matches!(base, Base::Planar { .. });
    let phases = phases::read_phases(top, &feet, planar, symmetric_joints.is_empty(), messages);
    let effects = effects::read_effects(top, known, &feet, messages);
    let generate = read_generate(top, messages);
    Settings {
        name,
        gravity,
        feet,
        base,
        symmetric_joints,
        actuated_joints,
        motor_encoders,
        drives,
        phases,
        effects,
        generate,
    }
}

fn check_name(name: String, at: Place, messages: &mut Messages<'_>) -> Option<String> {
    if name.trim().is_empty() || name.chars().any(char::is_control) {
        let help = "write a name such as \"my_robot\", or leave the key out";
        messages.error(at, format!("the name \"{}\" is empty or unprintable", short(&name)), help);
        return None;
    }
    Some(name)
}

fn read_generate(top: &Section<'_, '_>, messages: &mut Messages<'_>) -> Generate {
    let Some(section) = top.section("generate", messages) else { return Generate::default() };
    section.check_keys(&["functions", "frames", "runtime_parameters"], messages);
    let mut names = |key| {
        let names = section.strings(key, messages).unwrap_or_default();
        names.into_iter().map(|(name, _)| name).collect()
    };
    Generate {
        functions: names("functions"),
        frames: names("frames"),
        runtime_parameters: section.boolean("runtime_parameters", messages).unwrap_or_default(),
    }
}

/// Whether a name can become part of a Rust name; reports if not.
pub(in crate::description) fn check_identifier(
    name: &str,
    what: &str,
    at: Place,
    messages: &mut Messages<'_>,
) {
    let good = name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.starts_with(|c: char| c.is_ascii_alphabetic());
    if !good {
        messages.error(
            at,
            format!("the {what} name `{}` is not an identifier", short(name)),
            "use letters, digits and `_`, beginning with a letter",
        );
    }
}
