//! Keys of a scenario that say how a robot walks from event to event.
use super::file::{Checks, File};
use super::reading::{ANY, NOT_NEGATIVE, POSITIVE, Reading};
use super::{EventDriven, Push, World};
use crate::robot::BaseKind;
use crate::simulate::phases::Assumptions;
use crate::simulate::{Carried, Plant, PutOn};
use bipedc_effects::effect::{Acts, Effect, Law, Simulation};
use bipedc_effects::spelling::did_you_mean;
use toml::{Spanned, Value};

const METHODS: [&str; 2] = ["time_stepping", "event_driven"];
/// Coulomb's coefficient unless the scenario says otherwise: as in time stepping.
const FRICTION: f64 = 0.8;
/// Rise from a foothold to the next, m.
const HIGHEST_STEP: f64 = 1.0;
/// Of the integration, unless the scenario says otherwise.
const RELATIVE: f64 = 1e-10;

/// Why an effect has no place in event-driven walking.
fn refused(effect: &Effect) -> Option<&'static str> {
    match (effect.kind.law.acts(), effect.kind.simulation) {
        (Acts::Body | Acts::Sensor, _) => None,
        (Acts::Torque, simulation) if simulation.is_smooth() && effect.kind.law != Law::Formula => None,
        (_, Simulation::Dry(_)) => Some("a joint that sticks is an event of its own"),
        _ if effect.kind.law == Law::SpinFriction => Some("a joint that sticks is an event of its own"),
        _ => Some("contacts and drives are ideal there"),
    }
}

impl Reading<'_> {
    /// The method; keys of the other one are refused.
    pub(super) fn is_event_driven(&mut self, file: &File, plant: &Plant) -> bool {
        let event_driven = match file.method.as_ref().map(|method| (method.get_ref().as_str(), method.span()))
        {
            None | Some(("time_stepping", _)) => false,
            Some(("event_driven", span)) => {
                self.can_walk(plant, span.start);
                true
            }
            Some((other, span)) => {
                let help = match did_you_mean(other, METHODS.iter().copied()) {
                    Some(meant) => format!("did you mean \"{meant}\"?"),
                    None => "write method = \"time_stepping\" or \"event_driven\"".to_owned(),
                };
                return self
                    .wrong::<()>(span.start, format!("there is no method \"{other}\""), help)
                    .is_some();
            }
        };
        let at = |found: Option<usize>, key: &'static str| found.map(|at| (at, key));
        let foreign: Vec<(usize, &str)> = if event_driven {
            let control = file.control.as_ref();
            vec![
                at(file.step.as_ref().map(|x| x.span().start), "step"),
                at(file.residual.as_ref().map(|x| x.span().start), "residual"),
                at(file.ground.as_ref().map(|x| x.span().start), "[ground]"),
                at(control.and_then(|c| c.trajectory.as_ref()).map(|x| x.span().start), "trajectory"),
                at(control.and_then(|c| c.servo.as_ref()).map(|x| x.span().start), "servo"),
                at(file.drives.as_ref().map(|x| x.span().start), "drives"),
                at(file.motor.values().next().map(|x| x.span().start), "[motor]"),
                at(file.imu.as_ref().map(|x| x.span().start), "[imu]"),
                at(
                    file.initial
                        .as_ref()
                        .and_then(|i| i.get_ref().clearance.as_ref())
                        .map(|x| x.span().start),
                    "clearance",
                ),
            ]
        } else {
            vec![
                at(file.steps.as_ref().map(|x| x.span().start), "steps"),
                at(file.relative_tolerance.as_ref().map(|x| x.span().start), "relative_tolerance"),
                at(file.assumptions.as_ref().map(|x| x.span().start), "[assumptions]"),
            ]
        }
        .into_iter()
        .flatten()
        .collect();
        for (at, key) in foreign {
            let (message, help) = foreign_key(key, event_driven);
            self.wrong::<()>(at, message, help);
        }
        event_driven
    }

    /// Whether the robot has what phases need.
    fn can_walk(&mut self, plant: &Plant, at: usize) {
        if plant.phases.is_empty() {
            let help = "add [[phase]] tables to biped.toml, or write method = \"time_stepping\"";
            self.wrong::<()>(at, "the robot has no phases", help);
        }
        if plant.layout.base == BaseKind::Fixed {
            let help = "choose --base planar or floating, or write method = \"time_stepping\"";
            self.wrong::<()>(at, "a robot on a fixed base does not walk", help);
        }
        for effect in &plant.effects {
            if let Some(why) = refused(effect) {
                let message = format!(
                    "`{}` of the description cannot be simulated from event to event: {why}",
                    effect.kind
                );
                self.wrong::<()>(at, message, "write method = \"time_stepping\"");
            }
        }
    }

    /// What belongs to event-driven walking alone.
    pub(super) fn events(&mut self, file: &File) -> EventDriven {
        if let Some(steps) = &file.steps
            && *steps.get_ref() == 0
        {
            self.wrong::<()>(
                steps.span().start,
                "`steps` = 0 is not possible",
                "leave it out, or write steps = 10",
            );
        }
        let initial = file.initial.as_ref().map(|start| start.get_ref());
        EventDriven {
            steps: file.steps.as_ref().map(|steps| *steps.get_ref() as usize),
            relative: self.number(
                "relative_tolerance",
                file.relative_tolerance.as_ref(),
                RELATIVE,
                (1e-13, 1e-3),
                "1",
            ),
            assumptions: self.assumptions(file.assumptions.as_ref().map(|checks| checks.get_ref())),
            given: [
                initial.is_some_and(|start| start.base_velocity.is_some()),
                initial.is_some_and(|start| start.base_angular_velocity.is_some()),
            ],
        }
    }

    /// Effects of the scenario that the event-driven method does not know.
    pub(super) fn refuse_effect(&mut self, effect: &Effect, at: usize) {
        if let Some(why) = refused(effect) {
            let message = format!("`{}` cannot be simulated from event to event: {why}", effect.kind);
            self.wrong::<()>(at, message, "leave it out, or write method = \"time_stepping\"");
        }
    }

    fn assumptions(&mut self, checks: Option<&Checks>) -> Assumptions {
        let none = Checks::default();
        let checks = checks.unwrap_or(&none);
        let usual = Assumptions::default();
        let shortest = checks.shortest_step.as_ref();
        Assumptions {
            friction: self.number_or_false("friction", checks.friction.as_ref(), FRICTION, "1"),
            scuffing: self.number_or_false("scuffing", checks.scuffing.as_ref(), usual.scuffing, "m"),
            pushing: checks.pushing.unwrap_or(usual.pushing),
            shortest_step: self.number("shortest_step", shortest, usual.shortest_step, ANY, "m"),
            step_length: checks.step_length.as_ref().and_then(|length| self.step_length(length)),
            second_impact: checks.second_impact.unwrap_or(usual.second_impact),
            level: self.number("level", checks.level.as_ref(), usual.level, NOT_NEGATIVE, "m"),
            light: self.number("light", checks.light.as_ref(), usual.light, (0.0, 0.1), "1"),
            follows: checks.order.as_ref().and_then(|order| self.order(order)),
        }
    }

    /// Whether phases follow the contacts.
    fn order(&mut self, found: &Spanned<String>) -> Option<bool> {
        match found.get_ref().as_str() {
            "contacts" => Some(true),
            "fixed" => Some(false),
            other => {
                let help = "write order = \"contacts\": the walk goes on in the phase that has the contacts; or order = \"fixed\": other contacts \
                            end the run";
                self.wrong(found.span().start, format!("there is no order \"{other}\""), help)
            }
        }
    }

    /// A number, or none: the gait's guard says it.
    fn step_length(&mut self, found: &Spanned<Value>) -> Option<f64> {
        let number = match found.get_ref() {
            Value::String(word) if word == "gait" => return None,
            Value::Float(x) => *x,
            Value::Integer(x) => *x as f64,
            _ => f64::NAN,
        };
        if number > 0.0 && number.is_finite() {
            return Some(number);
        }
        let help = "write a number above 0 in m, or \"gait\": where the gait's guard vanishes";
        self.wrong(found.span().start, "`step_length` is not possible", help)
    }

    /// `false` is infinite: not checked.
    fn number_or_false(&mut self, name: &str, found: Option<&Spanned<Value>>, usual: f64, unit: &str) -> f64 {
        let Some(found) = found else { return usual };
        let number = match found.get_ref() {
            Value::Boolean(false) => return f64::INFINITY,
            Value::Float(x) => *x,
            Value::Integer(x) => *x as f64,
            _ => f64::NAN,
        };
        if number >= NOT_NEGATIVE.0 && number.is_finite() {
            return number;
        }
        let unit = if unit == "1" { String::new() } else { format!(" in {unit}") };
        let help = format!("write a number{unit} that is not negative, or false: not checked");
        self.wrong::<()>(found.span().start, format!("`{name}` is not possible"), help);
        usual
    }

    /// The phase at time 0.
    pub(super) fn first_phase(&mut self, file: &File, plant: &Plant, has_phases: bool) -> usize {
        let named = file.initial.as_ref().and_then(|start| start.get_ref().phase.as_ref());
        let Some(named) = named else { return 0 };
        let at = named.span().start;
        if !has_phases {
            let message =
                "`phase` has no meaning without method = \"event_driven\", `gait` or [[control.output]]";
            self.wrong::<()>(at, message, "leave it out");
            return 0;
        }
        self.phase(plant, named).unwrap_or(0)
    }

    /// Index of a phase by its name.
    pub(super) fn phase(&mut self, plant: &Plant, named: &Spanned<String>) -> Option<usize> {
        let name = named.get_ref();
        let found = plant.phases.iter().position(|phase| phase == name);
        if found.is_none() {
            let help = match did_you_mean(name, plant.phases.iter().map(String::as_str)) {
                Some(meant) => format!("did you mean \"{meant}\"?"),
                None => format!("phases: {}", plant.phases.join(", ")),
            };
            self.wrong::<()>(named.span().start, format!("the robot has no phase `{name}`"), help);
        }
        found
    }

    /// Pushes on the base.
    pub(super) fn pushes(&mut self, file: &File, plant: &Plant, event_driven: bool) -> Vec<Push> {
        let Some(first) = file.push.first().map(|push| push.span().start) else { return Vec::new() };
        if plant.layout.base == BaseKind::Fixed {
            self.wrong::<()>(first, "nobody feels a push on a base that is fixed", "leave [[push]] out");
        } else if event_driven && plant.layout.base == BaseKind::Floating {
            let help = "leave [[push]] out, or choose --base planar or method = \"time_stepping\"";
            self.wrong::<()>(first, "from event to event only robots in the plane are pushed", help);
        }
        let each = file.push.iter().map(|push| {
            let push = push.get_ref();
            if let Some(direction) =
                push.direction.as_ref().filter(|_| plant.layout.base != BaseKind::Floating)
            {
                let help = "leave `direction` out; a negative `impulse` pushes back";
                self.wrong::<()>(direction.span().start, "robots in the plane are pushed along x", help);
            }
            Push {
                time: self.number("time", Some(&push.time), 0.0, NOT_NEGATIVE, "s"),
                duration: self.number("duration", push.duration.as_ref(), 0.1, POSITIVE, "s"),
                impulse: self.number("impulse", Some(&push.impulse), 0.0, ANY, "N s"),
                direction: self.number("direction", push.direction.as_ref(), 0.0, ANY, "rad"),
            }
        });
        each.collect()
    }

    /// Rise of the ground from each foothold to the next, m.
    pub(super) fn rises(&mut self, file: &File, plant: &Plant, event_driven: bool) -> Vec<f64> {
        let Some(found) = &file.footholds else { return Vec::new() };
        let at = found.span().start;
        if !event_driven || plant.layout.base != BaseKind::Planar {
            let help = "use method = \"event_driven\" on --base planar, or `heights` in [ground]";
            self.wrong::<()>(at, "`footholds` are those of robots in the plane, from event to event", help);
        }
        let impossible = |rise: &&f64| rise.is_nan() || rise.abs() > HIGHEST_STEP;
        if let Some(rise) = found.get_ref().iter().find(impossible) {
            let help = format!(
                "write how much higher each foothold is than the one before, within {HIGHEST_STEP} m"
            );
            self.wrong::<()>(at, format!("a foothold of {rise} m"), help);
        }
        found.get_ref().clone()
    }

    /// Masses that are put onto the root link.
    pub(super) fn payloads(&mut self, file: &File, plant: &Plant, event_driven: bool) -> Vec<PutOn> {
        let Some(first) = file.payload.first().map(|payload| payload.span().start) else { return Vec::new() };
        if event_driven || plant.layout.base != BaseKind::Floating {
            let help = "use time stepping on --base floating, or an [[effect]] of kind \"payload\" from the beginning on";
            self.wrong::<()>(first, "nothing can be put onto this robot while it moves", help);
        }
        let each = file.payload.iter().map(|payload| {
            let payload = payload.get_ref();
            let place = self.vector("position", payload.position.as_ref(), 3, "[x, y, z] in m");
            let mass = self.number("mass", Some(&payload.mass), 0.0, POSITIVE, "kg");
            PutOn {
                time: self.number("time", Some(&payload.time), 0.0, NOT_NEGATIVE, "s"),
                carried: Carried::new(mass, [place[0], place[1], place[2]]),
            }
        });
        each.collect()
    }

    /// Gravity and slope.
    pub(super) fn world(&mut self, file: &File) -> World {
        let gravity = self.number("gravity", file.gravity.as_ref(), 9.81, POSITIVE, "m/s²");
        World {
            gravity: file.gravity.as_ref().map(|_| gravity),
            slope: self.number("slope", file.slope.as_ref(), 0.0, (-1.5, 1.5), "rad"),
        }
    }
}

/// What is said about a key of the other method.
fn foreign_key(key: &str, event_driven: bool) -> (String, &'static str) {
    let method = if event_driven { "event_driven" } else { "time_stepping" };
    let help = match key {
        "step" => "the step follows from `relative_tolerance`; rows of the log from `log_step`",
        "[ground]" => {
            "the ground is rigid and does not give back; friction is checked: [assumptions] friction"
        }
        "clearance" => "the contacts of the first phase stand on the ground",
        "residual" | "trajectory" => "leave it out",
        "servo" | "drives" | "[motor]" | "[imu]" => {
            "drives are ideal from event to event: leave it out, or write method = \"time_stepping\""
        }
        _ => "write method = \"event_driven\", or leave it out",
    };
    (format!("`{key}` has no meaning with method = \"{method}\""), help)
}
