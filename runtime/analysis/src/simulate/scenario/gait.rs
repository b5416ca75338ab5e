//! `gait` of `[control]`: the name of a gait that drives the robot. What the name means is known to whoever has gaits.
use super::file::{Control, File, Number, Start};
use super::reading::{POSITIVE, Reading};
use super::wishes::Wishes;
use crate::simulate::Plant;
use crate::simulate::control::Feedback;
use std::path::PathBuf;

/// A gait that drives the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitControl {
    /// Its name, or the path of its file.
    pub name: String,
    /// Line and column of the name.
    pub position: (usize, usize),
    /// Folder of the robot as the controller knows it; `None`: as it is described.
    pub model: Option<PathBuf>,
    /// Gait parameters that are not the gait's own.
    pub parameters: Vec<GaitValue>,
    /// What makes its outputs vanish, if the scenario says it.
    pub feedback: Option<Feedback>,
    /// Line and column of `step_length = "gait"`, if steps end where the gait's guard vanishes, not where a foot touches the ground.
    pub guarded: Option<(usize, usize)>,
    /// Torques are clamped to the efforts of the URDF.
    pub limited: bool,
    /// The robot begins at the beginning of a step that passes its dead centre at this speed of the phase variable, per s, with line
    /// and column; `None`: where the scenario says.
    pub speed: Option<(f64, (usize, usize))>,
    /// Speeds of further steps, for which parameters are chosen.
    pub wishes: Option<Wishes>,
}

/// A gait parameter with its value, SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitValue {
    /// As the gait calls it.
    pub name: String,
    /// Its value.
    pub value: f64,
    /// Line and column.
    pub position: (usize, usize),
}

impl Reading<'_> {
    /// The gait of `[control]`, if it names one.
    pub(super) fn gait(&mut self, file: &File, control: &Control, plant: &Plant) -> Option<GaitControl> {
        let none = Start::default();
        let start = file.initial.as_ref().map_or(&none, |start| start.get_ref());
        let Some(named) = &control.gait else {
            self.without_gait(file, control, start);
            return None;
        };
        let at = named.span().start;
        if begins_nowhere(file, control) {
            let help = "add [initial] with mid_stance_speed = 0.8: φ̇ at mid-stance, per s, from which a step of the gait begins (`bipedc gait cycle` tells that of \
                        steps that repeat themselves); or the state: base_position, base_velocity, … there, position and velocity in [joint.NAME]";
            self.wrong::<()>(
                at,
                "nothing says where the robot begins, and a gait does not begin at rest",
                help,
            );
        }
        if plant.phases.is_empty() {
            self.wrong::<()>(at, "the robot has no phases", "add [[phase]] tables to biped.toml");
        }
        let outputs = control.output.first().map(|output| output.span().start);
        let quantities = control.quantities.values().next().map(|quantity| quantity.span().start);
        if let Some(at) = outputs.or(quantities) {
            let help = "leave [[control.output]] and [control.quantities] out, or leave `gait` out";
            self.wrong::<()>(at, "a gait has outputs and quantities of its own", help);
        }
        let name = named.get_ref();
        let name = match name.ends_with(".toml") {
            true => self.beside(name).to_string_lossy().into_owned(),
            false => name.clone(),
        };
        Some(GaitControl {
            name,
            position: self.place(at),
            model: control.model.as_ref().map(|name| self.beside(name.get_ref())),
            parameters: self.gait_values(control),
            feedback: control.feedback.as_ref().map(|feedback| self.feedback(Some(feedback))),
            limited: control.effort_limits.unwrap_or(true),
            speed: self.mid_stance_speed(file, start),
            guarded: ends_by_gait(file).map(|at| self.place(at)),
            wishes: self.wishes(file, control),
        })
    }

    fn gait_values(&mut self, control: &Control) -> Vec<GaitValue> {
        let mut found = Vec::new();
        for (name, value) in &control.parameters {
            let (number, at) = (*value.get_ref(), value.span().start);
            if !number.is_finite() {
                self.wrong::<()>(at, format!("`{name}` is not finite"), "write a number");
            }
            found.push(GaitValue { name: name.clone(), value: number, position: self.place(at) });
        }
        found
    }

    /// Keys that mean something only with a gait.
    fn without_gait(&mut self, file: &File, control: &Control, start: &Start) {
        let speeds = control.speeds.as_ref().map(|speeds| (speeds.span().start, "`speeds`"));
        let choice = control.choice.as_ref().map(|choice| (choice.span().start, "[control.choice]"));
        if let Some((at, key)) = speeds.or(choice) {
            let help = "name a gait in [control], or leave it out";
            self.wrong::<()>(at, format!("{key} is about the steps of a gait; there is none"), help);
        }
        if let Some(model) = &control.model {
            let help = "name a gait in [control], or leave it out";
            self.wrong::<()>(
                model.span().start,
                "`model` is what the controller of a gait knows; there is none",
                help,
            );
        }
        if let Some(speed) = &start.mid_stance_speed {
            let help = "name a gait in [control], or leave it out";
            self.wrong::<()>(speed.span().start, "`mid_stance_speed` is that of a gait; there is none", help);
        }
        if let Some(at) = ends_by_gait(file) {
            let help = "write a number in m, or name a gait in [control]";
            self.wrong::<()>(at, "`step_length` is to be that of a gait; there is none", help);
        }
    }

    /// The speed at mid-stance of the first step; then nothing else is said of where the robot begins.
    fn mid_stance_speed(&mut self, file: &File, start: &Start) -> Option<(f64, (usize, usize))> {
        let given = start.mid_stance_speed.as_ref()?;
        let speed = self.number("mid_stance_speed", Some(given), 1.0, POSITIVE, "per s");
        let of_list = |list: &Option<toml::Spanned<Vec<f64>>>| list.as_ref().map(|list| list.span().start);
        let of_number = |number: &Option<Number>| number.as_ref().map(|number| number.span().start);
        let base = [&start.base_position, &start.base_rotation, &start.base_velocity];
        let base = base.into_iter().chain([&start.base_angular_velocity]).find_map(of_list);
        let joints = file.joint.values().map(|joint| joint.get_ref());
        let joints = joints.flat_map(|joint| [&joint.position, &joint.velocity]).find_map(of_number);
        if let Some(at) = base.or(of_number(&start.clearance)).or(joints) {
            let help = "leave it out, or leave `mid_stance_speed` out";
            self.wrong::<()>(at, "where the robot begins follows from the gait and `mid_stance_speed`", help);
        }
        Some((speed, self.place(given.span().start)))
    }
}

/// Whether a gait drives the robot and the scenario says nothing of the state in which it begins.
pub(super) fn begins_nowhere(file: &File, control: &Control) -> bool {
    let said = file.initial.as_ref().is_some_and(|start| {
        let Start {
            base_position,
            base_rotation,
            base_velocity,
            base_angular_velocity,
            clearance,
            mid_stance_speed,
            ..
        } = start.get_ref();
        let vectors = [base_position, base_rotation, base_velocity, base_angular_velocity];
        vectors.into_iter().any(Option::is_some) || clearance.is_some() || mid_stance_speed.is_some()
    });
    let joints = file.joint.values().map(|joint| joint.get_ref());
    let joint = joints.into_iter().any(|joint| joint.position.is_some() || joint.velocity.is_some());
    control.gait.is_some() && control.trajectory.is_none() && !said && !joint
}

/// Place of `step_length = "gait"`.
fn ends_by_gait(file: &File) -> Option<usize> {
    let length = file.assumptions.as_ref()?.get_ref().step_length.as_ref()?;
    (length.get_ref().as_str() == Some("gait")).then_some(length.span().start)
}
