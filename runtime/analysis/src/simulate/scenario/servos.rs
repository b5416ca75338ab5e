//! `[control]` and `[joint.NAME]` of a scenario: servos, and the motion that they follow.
use super::file::{Control, File, Joint};
use super::gait::begins_nowhere;
use super::reading::{ANY, NOT_NEGATIVE, Reading};
use super::{Initial, JointServo};
use crate::log::{Mapping, Reader, Table};
use crate::simulate::{Plant, Reference, Sine};
use bipedc_effects::diagnostic::Diagnostics;
use bipedc_effects::spelling::suggest;
use toml::Spanned;

impl Reading<'_> {
    /// Controllers by joint; initial positions and velocities go into `initial`.
    pub(super) fn servos(
        &mut self,
        file: &File,
        control: &Control,
        trajectory: Option<&Table>,
        plant: &Plant,
        initial: &mut Initial,
    ) -> Vec<JointServo> {
        let stiffness = self.number("stiffness", control.stiffness.as_ref(), 0.0, NOT_NEGATIVE, "N m/rad");
        let damping = self.number("damping", control.damping.as_ref(), 0.0, NOT_NEGATIVE, "N m s/rad");
        let none = Joint::default();
        let count = plant.layout.joints.len();
        let (first_q, first_v) = (initial.q.len() - count, initial.v.len() - count);
        let mut servos = Vec::with_capacity(count);
        // Then where joints begin follows from the gait.
        let by_gait = file.initial.as_ref().is_some_and(|start| start.get_ref().mid_stance_speed.is_some())
            || begins_nowhere(file, control);
        for (j, joint) in plant.layout.joints.iter().enumerate() {
            let own = file.joint.get(&joint.name).map_or(&none, |own| own.get_ref());
            let from_table = trajectory.and_then(|table| followed(table, &joint.name));
            let begins = from_table.as_ref().map_or([0.0; 2], |reference| reference.at(0.0));
            let position = self.number("position", own.position.as_ref(), begins[0], ANY, "rad");
            let velocity = self.number("velocity", own.velocity.as_ref(), begins[1], ANY, "rad/s");
            if let Some([low, high]) = plant.position_limits[j]
                && control.joint_stops.unwrap_or(true)
                && !by_gait
                && !(low..=high).contains(&position)
            {
                let at = own.position.as_ref().map_or(0, |p| p.span().start);
                let message = format!("`{}` begins at {position} rad, beyond its limits", joint.name);
                self.wrong::<()>(at, message, format!("the URDF allows {low} to {high} rad"));
            }
            initial.q[first_q + j] = position;
            initial.v[first_v + j] = velocity;
            let limit = if control.effort_limits.unwrap_or(true) { plant.effort_limits[j] } else { None };
            servos.push(JointServo {
                stiffness: self.number(
                    "stiffness",
                    own.stiffness.as_ref(),
                    stiffness,
                    NOT_NEGATIVE,
                    "N m/rad",
                ),
                damping: self.number("damping", own.damping.as_ref(), damping, NOT_NEGATIVE, "N m s/rad"),
                limit: limit.unwrap_or(f64::INFINITY),
                reference: self.reference(own, position, from_table),
            });
        }
        servos
    }

    fn reference(&mut self, own: &Joint, position: f64, from_table: Option<Reference>) -> Reference {
        let mean = self.number("reference", own.reference.as_ref(), position, ANY, "rad");
        if let Some(points) = &own.points {
            let list = points.get_ref();
            let fine =
                list.iter().flatten().all(|x| x.is_finite()) && list.windows(2).all(|p| p[0][0] < p[1][0]);
            if !fine || list.is_empty() || own.sines.is_some() {
                let help =
                    "write points = [[time, position], …] with increasing times (s, rad), and no `sines`";
                self.wrong::<()>(points.span().start, "`points` are no motion", help);
                return Reference::Sines { mean, terms: Vec::new() };
            }
            return Reference::through(
                list.iter().map(|p| p[0]).collect(),
                list.iter().map(|p| p[1]).collect(),
            );
        }
        let mut terms = Vec::new();
        if let Some(sines) = &own.sines {
            for &[amplitude, frequency, phase] in sines.get_ref() {
                if ![amplitude, frequency, phase].iter().all(|x| x.is_finite()) || frequency < 0.0 {
                    let help = "write sines = [[amplitude (rad), frequency (Hz), phase (rad)], …]";
                    self.wrong::<()>(sines.span().start, "`sines` are no motion", help);
                }
                terms.push(Sine { amplitude, frequency, phase });
            }
        }
        match from_table {
            Some(reference) if own.reference.is_none() && own.sines.is_none() => reference,
            _ => Reference::Sines { mean, terms },
        }
    }

    /// The table of a trajectory, as `bipedc excite` writes it.
    pub(super) fn trajectory(&mut self, name: &Spanned<String>, plant: &Plant) -> Option<Table> {
        let path = self.beside(name.get_ref());
        let read = || {
            let reader = Reader::open(&path, &Mapping::default())?;
            let names: Vec<String> = reader.columns().map(|column| column.name.to_owned()).collect();
            Ok((Table::read(reader, &names)?, names))
        };
        let rises = |table: &Table| {
            table.column("time").is_some_and(|time| time.windows(2).all(|pair| pair[0] < pair[1]))
        };
        match read() {
            Ok((table, names)) if rises(&table) => match useless_column(&names, plant) {
                None => Some(table),
                Some((why, help)) => {
                    let message = format!("`trajectory`: {}: {why}", path.display());
                    self.wrong(name.span().start, message, help)
                }
            },
            Ok(_) => {
                let message = format!("`trajectory`: the times of {} do not increase", path.display());
                self.wrong(name.span().start, message, "give a log with the column `time` in s")
            }
            Err(Diagnostics(list)) => {
                let why = list.first().map_or_else(String::new, |first| first.message.clone());
                let help = "give a CSV file with columns `time` and `<joint>/position`, beside the scenario";
                self.wrong(name.span().start, format!("`trajectory`: {}: {why}", path.display()), help)
            }
        }
    }
}

/// What is wrong with the columns of a trajectory, and what to do.
fn useless_column(names: &[String], plant: &Plant) -> Option<(String, String)> {
    let mut followed = names.iter().filter_map(|name| name.strip_suffix("/position")).peekable();
    if followed.peek().is_none() {
        return Some((
            "no column `<joint>/position`".to_owned(),
            "give positions in rad over time".to_owned(),
        ));
    }
    for joint in followed {
        if plant.joint(joint).is_none() {
            let help = suggest(joint, plant.joint_names(), || "take the column out".to_owned());
            return Some((format!("the robot has no joint `{joint}`"), help));
        }
    }
    None
}

/// A joint's motion in a trajectory table.
fn followed(table: &Table, joint: &str) -> Option<Reference> {
    let time = table.column("time")?.to_vec();
    let position = table.column(&format!("{joint}/position"))?.to_vec();
    Some(match table.column(&format!("{joint}/velocity")) {
        Some(velocity) => Reference::Points { time, position, velocity: velocity.to_vec() },
        None => Reference::through(time, position),
    })
}
