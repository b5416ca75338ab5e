//! A first gait file for a robot that walks in the plane: phases, phase variables and outputs, without curves.
use super::joint_names::JointNames;
use super::legs::{bending, frames};
use super::phase::is_one_point;
use crate::description::geometry::{Frame, Vector, norm, subtract};
use crate::description::model::{
    Base, Contact, ContactPart, Foot, Joint, JointKind, Phase, RobotDescription,
};
use bipedc_effects::diagnostic::Diagnostic;
use std::fmt::Write as _;

/// What is controlled while two feet stand, beside the pitch of the base.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum DoubleSupport {
    /// Height of the base, pitch of the feet on points.
    #[default]
    Height,
    /// Joints between the first and the last of each leg.
    Knees,
}

/// What is wished of a form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct FormWishes {
    /// What is controlled while two feet stand.
    pub double: DoubleSupport,
    /// The controller of a step of one phase keeps to limits of the ground: the phase ends at a φ instead of by a guard.
    pub grounded: bool,
}

/// The text of a gait file whose form `bipedc gait optimise` can fill: a phase for each of the description's, its outputs joints that, with
/// the contacts and φ, fix all others.
///
/// # Errors
/// A base that is not planar; no phases, or such that are no walk; joints without actuators; feet that are on no leg.
pub fn gait_form(of: &RobotDescription, wishes: FormWishes) -> Result<String, Diagnostic> {
    let robot = Walker { double: wishes.double, ..Walker::new(of)? };
    let phases = robot.phases()?;
    let alone = phases.len() == 1;
    // On a flat foot no zero dynamics are made of a step that ends by a guard.
    let on_points = |phase: &&Phase| [&phase.contacts, &phase.impact].iter().all(|on| is_one_point(of, on));
    let guarded = alone && !wishes.grounded && phases.iter().all(on_points);
    let mut text = format!(
        "# The form of a gait of {}: what is controlled over what. Curves are still missing (`wanted = \"0\"`):\n#   bipedc gait optimise ROBOT \
         --gait THIS --speed V --out NEW.toml\n# finds them. docs/gaits.md explains every key. Any formula of joints, base_x, base_z, base_pitch and contact \
         points can be controlled.\n\n",
        of.name
    );
    for phase in &phases {
        robot.write(phase, [alone, guarded], &mut text)?;
    }
    let limits = if guarded { "margins are measured against" } else { "the controller keeps to" };
    let _ =
        writeln!(text, "[limits]\nfriction = 0.6                      # Coulomb's coefficient that {limits}");
    Ok(text)
}

/// Name, unit and formula of an output.
type Output = (String, &'static str, String);

pub(super) struct Walker<'d> {
    pub of: &'d RobotDescription,
    pub double: DoubleSupport,
    /// By link.
    pub frames: Vec<(&'d str, Frame)>,
    /// What formulas call the joints.
    pub names: JointNames,
}

fn refused(message: impl Into<String>, help: &str) -> Diagnostic {
    Diagnostic::error(message.into()).help(help)
}

impl<'d> Walker<'d> {
    fn new(of: &'d RobotDescription) -> Result<Self, Diagnostic> {
        if !matches!(of.base, Base::Planar { .. }) {
            let help = "[base] kind = \"planar\" in biped.toml, if all joints turn about the y axis or slide in the plane of x and z";
            return Err(refused(
                "gaits are those of robots that walk in the plane: the base is not planar",
                help,
            ));
        }
        let moving = || of.joints.iter().filter(|joint| joint.kind.moves());
        if let Some(joint) = moving().find(|joint| !of.actuated_joints.contains(&joint.name)) {
            let help = "add it to [actuation] of biped.toml, or hold it by `locked` in [joints]";
            return Err(refused(format!("joint `{}` has no actuator", joint.name), help));
        }
        Ok(Self { of, double: DoubleSupport::default(), frames: frames(of), names: JointNames::of_robot(of) })
    }

    /// In the order in which they follow each other.
    fn phases(&self) -> Result<Vec<&'d Phase>, Diagnostic> {
        let help = "write [[phase]] tables into biped.toml (robots/README.md); `bipedc init` writes a first sequence for two feet";
        let Some(first) = self.of.phases.first() else {
            return Err(refused("biped.toml has no phases", help));
        };
        let mut found = vec![first];
        loop {
            let next = &found[found.len() - 1].next;
            let next = self.of.phases.iter().find(|phase| phase.name == *next);
            match next {
                Some(next) if next.name == first.name => break,
                Some(next) if found.len() <= self.of.phases.len() => found.push(next),
                _ => return Err(refused("the phases of biped.toml do not come back to the first", help)),
            }
        }
        if !found.iter().any(|phase| phase.relabel) {
            let help = "add relabel = true to the phase after which left and right swap their roles";
            return Err(refused("no phase of biped.toml exchanges the legs: there is no step", help));
        }
        Ok(found)
    }

    fn write(&self, phase: &Phase, [alone, guarded]: [bool; 2], text: &mut String) -> Result<(), Diagnostic> {
        let stands: Vec<(&'d Foot, usize)> = self.standing(&phase.contacts)?;
        let Some(&(stance, _)) = stands.first() else {
            return Err(refused(
                format!("nothing stands in phase `{}`", phase.name),
                "a phase in the air has no gait",
            ));
        };
        let (variable, unit) = match alone {
            true => self.angle(stance).map_or_else(|| (self.place(stance), "m"), |angle| (angle, "rad")),
            false => (self.place(stance), "m"),
        };
        let _ = write!(
            text,
            "[[phase]]\nname = \"{}\"\nvariable = \"{variable}\"\nunit = \"{unit}\"\n",
            phase.name
        );
        if guarded {
            let point =
                |foot: &Foot| foot.points.first().map(|point| format!("{}_{}_z", foot.name, point.name));
            let landing = self.standing(&phase.impact)?;
            let lands = landing.iter().find(|(foot, _)| foot.name != stance.name);
            let (Some(lands), Some(on)) = (lands.and_then(|(foot, _)| point(foot)), point(stance)) else {
                let help = "a phase alone ends by `impact` of the other foot";
                return Err(refused(format!("phase `{}` does not end by a landing", phase.name), help));
            };
            let _ = writeln!(
                text,
                "guard = {{ zero = \"{lands} - {on}\", between = [0.05, 0.5] }}  # found anew"
            );
        } else {
            let stiff = self.feedback();
            let _ = writeln!(
                text,
                "end = 0.0                           # found anew\nfeedback = {{ stiffness = {:?}, damping = {:?} }}  # 1/s², 1/s",
                stiff * stiff,
                2.0 * stiff
            );
        }
        for (name, unit, formula) in self.outputs(&stands) {
            let _ = write!(
                text,
                "\n[[phase.output]]\nname = \"{name}\"\nunit = \"{unit}\"\ncontrolled = \"{formula}\"\nwanted = \"0\"\n"
            );
        }
        text.push('\n');
        Ok(())
    }

    /// Feet that stand, those of the whole sole first, with how many coordinates each is held by.
    fn standing(&self, contacts: &[Contact]) -> Result<Vec<(&'d Foot, usize)>, Diagnostic> {
        let mut found: Vec<(&Foot, usize)> = Vec::new();
        for contact in contacts {
            let foot = self.foot(&contact.foot)?;
            let rows = if contact.part == ContactPart::Flat && foot.points.len() > 1 { 3 } else { 2 };
            match found.iter_mut().find(|(other, _)| other.name == foot.name) {
                Some((_, held)) => *held = 3,
                None => found.push((foot, rows)),
            }
        }
        found.sort_by_key(|&(_, rows)| 3 - rows);
        Ok(found)
    }

    /// What, with the contacts and φ, fixes every joint. On one foot all joints, but for the last of a leg that stands flat. On two feet the pitch and height
    /// of the base, the pitch of each foot that stands on a point, and the joints that are then left: those of no leg, and of legs with more than
    /// three joints those between the first and the last two, or by how much more they bend than the one behind them.
    fn outputs(&self, stands: &[(&'d Foot, usize)]) -> Vec<Output> {
        let of_joint = |joint: &Joint| {
            let name = self.names.of(&joint.name).to_owned();
            (name.clone(), if joint.kind == JointKind::Prismatic { "m" } else { "rad" }, name)
        };
        let mut follow: Vec<&str> = Vec::new();
        let mut found: Vec<Output> = Vec::new();
        if let [(foot, rows)] = stands {
            let last = self.leg(foot).last().map(|joint| joint.name.as_str());
            follow.extend(last.filter(|_| *rows > 2));
        } else if self.double == DoubleSupport::Knees {
            (found, follow) = self.knees(stands);
        } else {
            let height = stands.first().and_then(|(foot, _)| Some((foot, self.foremost(foot)?)));
            let height =
                height.map_or_else(String::new, |(foot, point)| format!("base_z - {}_{point}_z", foot.name));
            found.push(("base_pitch".to_owned(), "rad", "base_pitch".to_owned()));
            found.push(("base_height".to_owned(), "m", height));
            for &(foot, rows) in stands {
                let leg = self.leg(foot);
                let kept = 1..leg.len().saturating_sub(2).max(1);
                let apart = self.bent_apart(&leg);
                let follows = |k: usize| !kept.contains(&k) || !apart.is_empty();
                follow.extend(
                    leg.iter().enumerate().filter(|(k, _)| follows(*k)).map(|(_, j)| j.name.as_str()),
                );
                found.extend(apart);
                if rows == 2 && leg.len() > 2 {
                    found.push((format!("pitch_of_{}", foot.name), "rad", self.pitch(foot)));
                }
            }
        }
        let moving = self.of.joints.iter().filter(|joint| joint.kind.moves());
        found.extend(moving.filter(|joint| !follow.contains(&joint.name.as_str())).map(of_joint));
        found
    }

    /// By how much more each inner joint of a leg of more than three bends than the next one, ankle and hip apart: with that fixed the leg shortens as all of
    /// them bend, and hip and foot settle how far. (With all but one fixed, that one and the hip do not settle the foot's place where the rest of the leg
    /// is in line, which a leg whose knee bends one way and whose hock the other comes to as it walks.) None where limits do not tell the way in which a
    /// joint bends.
    fn bent_apart(&self, leg: &[&Joint]) -> Vec<Output> {
        let inner = leg.get(1..leg.len().saturating_sub(1)).unwrap_or(&[]);
        let ways: Option<Vec<f64>> = inner.iter().map(|joint| bending(joint)).collect();
        let Some(ways) = ways else { return Vec::new() };
        let pair = |(joints, ways): (&[&Joint], &[f64])| {
            let [first, second] = [0, 1].map(|k| self.names.of(&joints[k].name));
            let sign = if ways[0] * ways[1] > 0.0 { '-' } else { '+' };
            (format!("{first}_over_{second}"), "rad", format!("{first} {sign} {second}"))
        };
        inner.windows(2).zip(ways.windows(2)).map(pair).collect()
    }

    /// On two feet: pitch of the base, and of each leg the joints between the first and the last, which are then left; how long a leg is fixes where the
    /// hip is also where the leg is straight, as the hip's height does not fix the leg. Of two feet on points the pitch of the one that came last is left.
    fn knees(&self, stands: &[(&'d Foot, usize)]) -> (Vec<Output>, Vec<&'d str>) {
        let mut found: Vec<Output> = vec![("base_pitch".to_owned(), "rad", "base_pitch".to_owned())];
        let mut follow: Vec<&str> = Vec::new();
        let mut left: isize = 1;
        for &(foot, rows) in stands {
            let leg = self.leg(foot);
            // A foot that stands flat holds its pitch; the first one leaves it to the hip instead.
            left -= isize::from(rows > 2);
            let kept = 1..leg.len().saturating_sub(if left < 0 { 2 } else { 1 }).max(1);
            left = left.max(0);
            let ends = leg.iter().enumerate().filter(|(k, _)| !kept.contains(k));
            follow.extend(ends.map(|(_, joint)| joint.name.as_str()));
        }
        found.extend((left > 0).then(|| self.rest(stands)));
        (found, follow)
    }

    /// What two feet on points leave open: the pitch of the last one, of legs without ankles the height of the base.
    fn rest(&self, stands: &[(&'d Foot, usize)]) -> Output {
        if let Some((foot, _)) = stands.iter().rev().find(|(foot, _)| self.leg(foot).len() > 2) {
            return (format!("pitch_of_{}", foot.name), "rad", self.pitch(foot));
        }
        let first = stands.first().and_then(|(foot, _)| Some((foot, self.foremost(foot)?)));
        let height =
            first.map_or_else(String::new, |(foot, point)| format!("base_z - {}_{point}_z", foot.name));
        ("base_height".to_owned(), "m", height)
    }

    /// Pitch of a foot: that of the base and all joints down to it.
    fn pitch(&self, foot: &Foot) -> String {
        let mut text = "base_pitch".to_owned();
        for joint in self.chain(foot).iter().filter(|joint| joint.kind != JointKind::Prismatic) {
            let sign = self.frame(&joint.child).direction(joint.axis)[1];
            let _ = write!(text, " {} {}", if sign < 0.0 { '-' } else { '+' }, self.names.of(&joint.name));
        }
        text
    }

    fn foremost(&self, foot: &'d Foot) -> Option<&'d str> {
        let x = |point: Vector| self.frame(&foot.link).point(point)[0];
        let first = foot.points.iter().max_by(|a, b| x(a.position).total_cmp(&x(b.position)));
        first.map(|point| point.name.as_str())
    }

    /// The base ahead of the foremost point of a foot.
    fn place(&self, foot: &'d Foot) -> String {
        self.foremost(foot).map_or_else(String::new, |point| format!("base_x - {}_{point}_x", foot.name))
    }

    /// The direction from a point foot to the first joint of its leg, as a sum of angles; none where the base is not the root of the tree.
    fn angle(&self, foot: &Foot) -> Option<String> {
        let Base::Planar { root } = &self.of.base else { return None };
        let leg = self.leg(foot);
        let hip = self.frame(&leg.first()?.child).position;
        let end = self.frame(&foot.link).point(foot.points.first()?.position);
        let along = subtract(end, hip);
        let length = norm([along[0], 0.0, along[2]]);
        if *root != self.of.root_link || length < 1e-6 {
            return None;
        }
        let mut text = "base_pitch".to_owned();
        // A joint that slides makes the leg longer or shorter and leaves its direction.
        for joint in self.chain(foot).into_iter().filter(|joint| joint.kind != JointKind::Prismatic) {
            let frame = self.frame(&joint.child);
            let sign = frame.direction(joint.axis)[1].signum();
            let rest = subtract(end, frame.position);
            let trunk = leg.iter().all(|other| other.name != joint.name);
            let weight = (rest[0] * along[0] + rest[2] * along[2]) / (length * length);
            let weight = if trunk { 1.0 } else { (100.0 * weight).round() / 100.0 };
            let name = self.names.of(&joint.name);
            let _ = match (sign * weight, weight.abs()) {
                (_, 0.0) => Ok(()),
                (x, 1.0) => write!(text, " {} {name}", if x < 0.0 { '-' } else { '+' }),
                (x, size) => write!(text, " {} {size:?} * {name}", if x < 0.0 { '-' } else { '+' }),
            };
        }
        Some(text)
    }

    /// How fast deviations decay, 1/s: twelve times the rate of a pendulum of the robot's height.
    fn feedback(&self) -> f64 {
        let gravity = norm(self.of.gravity).max(0.1);
        (12.0 * (gravity / self.height()).sqrt()).round()
    }

    /// From the feet to the highest first joint of a leg, all joints at zero, m.
    pub(super) fn height(&self) -> f64 {
        let of_leg = |foot: &'d Foot| {
            let hip = self.frame(&self.leg(foot).first()?.child).position;
            let point = self.frame(&foot.link).point(foot.points.first()?.position);
            Some(hip[2] - point[2])
        };
        self.of.feet.iter().filter_map(of_leg).fold(0.05, f64::max)
    }
}
