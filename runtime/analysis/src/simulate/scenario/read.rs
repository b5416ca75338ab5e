//! From the file to a checked scenario.
use super::file::{Control, File, Joint, Number, Senses, Soil, Start};
use super::{Initial, JointServo, Scenario, Sensors, effects};
use crate::log::{Mapping, Reader, Table};
use crate::robot::BaseKind;
use crate::simulate::{Compliance, Cone, EffortSensor, Ground, Plant, Reference, Sine, Tolerance};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::Effect;
use bipedc_effects::spelling::suggest;
use bipedc_effects::{input, magnitude};
use nalgebra::{UnitQuaternion, Vector3};
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Steps of a run: more are a mistake.
const MOST_STEPS: f64 = 1e9;

/// The text, and what was found wrong in it.
pub(super) struct Reading<'a> {
    file: &'a Path,
    text: &'a str,
    errors: Vec<Diagnostic>,
}

impl Reading<'_> {
    /// Notes an error; always `None`.
    pub fn wrong<T>(&mut self, at: usize, message: impl Into<String>, help: impl Into<String>) -> Option<T> {
        let (line, column) = place(self.text, at);
        self.errors.push(Diagnostic::error(message).in_file(self.file).at(line, column).help(help));
        None
    }

    /// Notes that the robot has no such joint.
    pub(super) fn no_joint(&mut self, at: usize, name: &str, plant: &Plant) {
        let otherwise = || format!("joints: {}", plant.joint_names().collect::<Vec<_>>().join(", "));
        let help = suggest(name, plant.joint_names(), otherwise);
        self.wrong::<()>(at, format!("the robot has no joint `{name}`"), help);
    }

    /// A number within bounds, or its default.
    pub(super) fn number(
        &mut self,
        name: &str,
        found: Option<&Number>,
        default: f64,
        range: (f64, f64),
        unit: &str,
    ) -> f64 {
        let Some(found) = found else { return default };
        let value = *found.get_ref();
        if value.is_finite() && value >= range.0 && value <= range.1 {
            return value;
        }
        let unit = if unit == "1" { String::new() } else { format!(" {unit}") };
        let range = match range {
            (low, f64::MAX) if low == f64::MIN_POSITIVE => format!("a number above 0{unit}"),
            (low, f64::MAX) => format!("at least {low}{unit}"),
            (f64::MIN, _) => format!("a finite number{unit}"),
            (low, high) => format!("from {low} to {high}{unit}"),
        };
        self.wrong::<()>(
            found.span().start,
            format!("`{name}` = {value}{unit} is not possible"),
            format!("it must be {range}"),
        );
        default
    }
}

pub(super) const POSITIVE: (f64, f64) = (f64::MIN_POSITIVE, f64::MAX);
pub(super) const NOT_NEGATIVE: (f64, f64) = (0.0, f64::MAX);
pub(super) const ANY: (f64, f64) = (f64::MIN, f64::MAX);

impl Scenario {
    /// Reads a scenario file for this robot.
    ///
    /// # Errors
    /// Everything that has no meaning, with line and column.
    pub fn open(path: &Path, plant: &Plant) -> Result<Self, Diagnostics> {
        let text = input::read_to_string(path).map_err(|e| {
            Diagnostics(vec![
                Diagnostic::error(format!("cannot read the scenario: {e}"))
                    .in_file(path)
                    .help("docs/simulation.md shows a first one"),
            ])
        })?;
        Self::parse(path, &text, plant)
    }

    /// The same from a text; `path` is for messages, and trajectories are looked for beside it.
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn parse(path: &Path, text: &str, plant: &Plant) -> Result<Self, Diagnostics> {
        let file: File = toml::from_str(text).map_err(|e| {
            let (line, column) = place(text, e.span().map_or(0, |span| span.start));
            let message = e.message().lines().next().unwrap_or("broken TOML").to_owned();
            Diagnostics(vec![
                Diagnostic::error(message)
                    .in_file(path)
                    .at(line, column)
                    .help("docs/simulation.md lists all keys"),
            ])
        })?;
        let mut reading = Reading { file: path, text, errors: Vec::new() };
        reading.sizes();
        let scenario = reading.scenario(&file, plant);
        if reading.errors.is_empty() { Ok(scenario) } else { Err(Diagnostics(reading.errors)) }
    }
}

impl Reading<'_> {
    /// Refuses numbers of impossible size wherever they stand.
    fn sizes(&mut self) {
        let Ok(table) = DeTable::parse(self.text) else { return };
        let mut values: Vec<&Spanned<DeValue<'_>>> = table.get_ref().values().collect();
        let mut wrong = Vec::new();
        while let Some(value) = values.pop() {
            let text = match value.get_ref() {
                DeValue::Float(x) => x.as_str(),
                DeValue::Integer(x) => x.as_str(),
                DeValue::Array(list) => {
                    values.extend(list.iter());
                    continue;
                }
                DeValue::Table(table) => {
                    values.extend(table.values());
                    continue;
                }
                _ => continue,
            };
            // Infinities and NaN are told with what is expected there.
            let number = text.parse::<f64>().ok().filter(|x| x.is_finite());
            if let Some((problem, help)) = number.and_then(magnitude::refusal) {
                wrong.push((value.span().start, format!("the number {text} {problem}"), help));
            }
        }
        wrong.sort_by_key(|(at, ..)| *at);
        for (at, message, help) in wrong {
            self.wrong::<()>(at, message, help);
        }
    }

    fn scenario(&mut self, file: &File, plant: &Plant) -> Scenario {
        let duration = self.number("duration", Some(&file.duration), 1.0, POSITIVE, "s");
        let step = self.number("step", file.step.as_ref(), 1e-3, POSITIVE, "s");
        let event_driven = self.is_event_driven(file, plant);
        let (step, log_every) = match event_driven {
            true => (self.number("log_step", file.log_step.as_ref(), 0.005, POSITIVE, "s"), 1),
            false => (step, self.log_every(file.log_step.as_ref(), step)),
        };
        if duration / step > MOST_STEPS {
            let at = file.duration.span().start;
            self.wrong::<()>(
                at,
                "more than a thousand million steps",
                "shorten `duration`, or lengthen `step` or `log_step`",
            );
        }
        if !event_driven && step > duration {
            let at = file.step.as_ref().unwrap_or(&file.duration).span().start;
            let message = format!("a step of {step} s is longer than the whole run of {duration} s");
            self.wrong::<()>(at, message, "shorten `step`, or lengthen `duration`");
        }
        let relative = self.number("residual", file.residual.as_ref(), 1e-8, (1e-14, 1e-2), "1");
        let none = Control::default();
        let control = file.control.as_ref().unwrap_or(&none);
        for (name, joint) in &file.joint {
            if plant.joint(name).is_none() {
                self.no_joint(joint.span().start, name, plant);
            }
        }
        let mut initial = self.initial(file, plant);
        let trajectory = control.trajectory.as_ref().and_then(|name| self.trajectory(name, plant));
        let servos = self.servos(file, control, trajectory.as_ref(), plant, &mut initial);
        let effects = file.effect.iter().filter_map(|table| effects::effect(self, plant, table));
        let effects: Vec<Effect> = effects.map(effects::with_settings).collect();
        if event_driven {
            let places: Vec<usize> = file.effect.iter().map(|table| table.span().start).collect();
            effects.iter().zip(places).for_each(|(effect, at)| self.refuse_effect(effect, at));
        }
        let events = event_driven.then(|| self.events(file));
        let outputs = self.outputs(control, plant, &servos);
        Scenario {
            duration,
            step,
            log_every,
            seed: file.seed,
            tolerance: Tolerance { relative, ..Tolerance::default() },
            initial,
            servos,
            trajectory: control.trajectory.as_ref().map(|name| self.beside(name.get_ref())),
            ground: self.ground(file.ground.as_ref().map(|soil| soil.get_ref())),
            joint_stops: control.joint_stops.unwrap_or(true),
            sensors: self.sensors(file.sensors.as_ref()),
            effects,
            events,
            phase: self.first_phase(file, plant, event_driven || outputs.is_some()),
            outputs,
            world: self.world(file),
            actuators: self.motors(file, plant),
            imu: file.imu.as_ref().and_then(|table| self.imu(table, plant)),
            inside: self.choice("servo", control.servo.as_ref(), ["held", "drive"]) == 1,
        }
    }

    fn log_every(&mut self, log_step: Option<&Number>, step: f64) -> usize {
        let wanted = self.number("log_step", log_step, step, POSITIVE, "s");
        let every = (wanted / step).round();
        if !(1.0..1e9).contains(&every) || (every * step - wanted).abs() > 1e-9 * wanted {
            let at = log_step.map_or(0, |found| found.span().start);
            let help = format!("write a multiple of {step} s");
            self.wrong::<()>(at, format!("`log_step` = {wanted} s is no multiple of the step"), help);
            return 1;
        }
        every as usize
    }

    pub(super) fn vector(
        &mut self,
        name: &str,
        found: Option<&Spanned<Vec<f64>>>,
        size: usize,
        words: &str,
    ) -> Vec<f64> {
        let Some(found) = found else { return vec![0.0; size] };
        let values = found.get_ref();
        if values.len() == size && size > 0 && values.iter().all(|x| x.is_finite()) {
            return values.clone();
        }
        let message = if size == 0 {
            format!("`{name}` has no meaning on this base")
        } else {
            format!("`{name}` = {values:?} is not possible")
        };
        let help = if size == 0 { "leave it out".to_owned() } else { format!("write {words}") };
        self.wrong::<()>(found.span().start, message, help);
        vec![0.0; size]
    }

    fn initial(&mut self, file: &File, plant: &Plant) -> Initial {
        let none = Start::default();
        let start = file.initial.as_ref().map_or(&none, |start| start.get_ref());
        let at = file.initial.as_ref().map_or(0, |start| start.span().start);
        let base = plant.layout.base;
        let joints = plant.layout.joints.len();
        let (linear, angular) = base.axes();
        let (linear, angular) = (linear.len(), angular.len());
        let axes = if linear == 3 { "[x, y, z]" } else { "[x, z]" };
        let turns = if angular == 3 { "[roll, pitch, yaw]" } else { "[pitch]" };
        let position = self.vector("base_position", start.base_position.as_ref(), linear, axes);
        let rotation = self.vector("base_rotation", start.base_rotation.as_ref(), angular, turns);
        let velocity = self.vector("base_velocity", start.base_velocity.as_ref(), linear, axes);
        let turning =
            self.vector("base_angular_velocity", start.base_angular_velocity.as_ref(), angular, turns);
        let clearance = self.number("clearance", start.clearance.as_ref(), 0.0, (0.0, 1e3), "m");
        if let (Some(clearance), Some(_)) = (&start.clearance, &start.base_position) {
            let help = "`clearance` places the lowest contact point, `base_position` the base: keep one";
            self.wrong::<()>(clearance.span().start, "both `clearance` and `base_position` are given", help);
        }
        let (mut q, mut v) = (position, velocity);
        match base {
            BaseKind::Fixed | BaseKind::Pivot => {}
            BaseKind::Planar => {
                q.extend(rotation);
                v.extend(turning);
            }
            BaseKind::Floating => {
                let turn = UnitQuaternion::from_euler_angles(rotation[0], rotation[1], rotation[2]);
                q.extend(turn.coords.iter());
                let own = turn.inverse() * Vector3::new(v[0], v[1], v[2]);
                v = own.iter().copied().chain(turning).collect();
            }
        }
        q.resize(q.len() + joints, 0.0);
        v.resize(v.len() + joints, 0.0);
        let clearance = (start.base_position.is_none() && base != BaseKind::Fixed && !plant.feet.is_empty())
            .then_some(clearance);
        Initial { q, v, clearance, position: place(self.text, at) }
    }

    /// Controllers by joint; initial positions and velocities go into `initial`.
    fn servos(
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
        for (j, joint) in plant.layout.joints.iter().enumerate() {
            let own = file.joint.get(&joint.name).map_or(&none, |own| own.get_ref());
            let from_table = trajectory.and_then(|table| followed(table, &joint.name));
            let begins = from_table.as_ref().map_or([0.0; 2], |reference| reference.at(0.0));
            let position = self.number("position", own.position.as_ref(), begins[0], ANY, "rad");
            let velocity = self.number("velocity", own.velocity.as_ref(), begins[1], ANY, "rad/s");
            if let Some([low, high]) = plant.position_limits[j]
                && control.joint_stops.unwrap_or(true)
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

    /// A file beside the scenario.
    fn beside(&self, name: &str) -> PathBuf {
        self.file.parent().unwrap_or(Path::new("")).join(name)
    }

    /// The table of a trajectory, as `bipedc excite` writes it.
    fn trajectory(&mut self, name: &Spanned<String>, plant: &Plant) -> Option<Table> {
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

    fn ground(&mut self, soil: Option<&Soil>) -> Ground {
        let none = Soil::default();
        let (soil, fine) = (soil.unwrap_or(&none), Ground::default());
        let unit = (0.0, 1.0);
        let cone = match soil.cone.as_ref().map(|cone| cone.get_ref().as_str()) {
            None | Some("round") => Cone::Round,
            Some("pyramid") => Cone::Pyramid,
            Some(other) => {
                let at = soil.cone.as_ref().map_or(0, |cone| cone.span().start);
                self.wrong::<()>(
                    at,
                    format!("there is no cone \"{other}\""),
                    "write \"round\" or \"pyramid\"",
                );
                Cone::Round
            }
        };
        let compliance = match &soil.stiffness {
            Some(stiffness) => Some(Compliance {
                stiffness: self.number("stiffness", Some(stiffness), 1.0, POSITIVE, "N/m"),
                damping: self.number("damping", soil.damping.as_ref(), 0.0, NOT_NEGATIVE, "N s/m"),
            }),
            None => {
                if let Some(damping) = &soil.damping {
                    let at = damping.span().start;
                    self.wrong::<()>(
                        at,
                        "`damping` of a ground without `stiffness`",
                        "add `stiffness` in N/m",
                    );
                }
                None
            }
        };
        Ground {
            friction: self.number("friction", soil.friction.as_ref(), fine.friction, NOT_NEGATIVE, "1"),
            normal_restitution: self.number("restitution", soil.restitution.as_ref(), 0.0, unit, "1"),
            tangential_restitution: self.number(
                "tangential_restitution",
                soil.tangential_restitution.as_ref(),
                0.0,
                (-1.0, 1.0),
                "1",
            ),
            cone,
            compliance,
            recovery: self.number("recovery", soil.recovery.as_ref(), 0.0, NOT_NEGATIVE, "1/s"),
        }
    }

    fn sensors(&mut self, senses: Option<&Senses>) -> Sensors {
        let none = Senses::default();
        let s = senses.unwrap_or(&none);
        let mut of = |name: &str, found: &Option<Number>, unit: &str| {
            self.number(name, found.as_ref(), 0.0, NOT_NEGATIVE, unit)
        };
        Sensors {
            encoder_counts: of("encoder_counts", &s.encoder_counts, "1"),
            position: of("position_noise", &s.position_noise, "rad"),
            velocity: of("velocity_noise", &s.velocity_noise, "rad/s"),
            effort: of("effort_noise", &s.effort_noise, "N m"),
            force: of("force_noise", &s.force_noise, "N"),
            base_position: of("base_position_noise", &s.base_position_noise, "m"),
            base_orientation: of("base_orientation_noise", &s.base_orientation_noise, "rad"),
            base_velocity: of("base_velocity_noise", &s.base_velocity_noise, "m/s"),
            force_limit: of("force_limit", &s.force_limit, "N"),
            velocities: s.velocities.unwrap_or(true),
            current: of("current_noise", &s.current_noise, "A"),
            current_step: of("current_step", &s.current_step, "A"),
            torque: match self.choice("effort", s.effort.as_ref(), ["motor", "joint"]) {
                0 => EffortSensor::Motor,
                _ => EffortSensor::Joint,
            },
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

/// Line and column (from 1) of a byte offset.
fn place(text: &str, offset: usize) -> (usize, usize) {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    (line, before.rsplit('\n').next().unwrap_or("").chars().count() + 1)
}
