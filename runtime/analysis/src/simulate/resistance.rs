//! Smooth laws of effects at joints, with their slopes: what a step needs to take them at its middle.
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::formula::{Bound, Formula, SMOOTHING};
use bipedc_effects::effect::{Acts, Effect, Simulation, VARIABLES};

/// Default of `smoothing` in users' formulas, rad/s.
const DEFAULT_SMOOTHING: f64 = 0.02;

/// State of a joint and of another one, in the order of [`VARIABLES`].
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Variables {
    /// Position, velocity, acceleration: of the middle of the step, its beginning, the last step.
    pub own: [f64; 3],
    /// Torque on the link in the last step, N m.
    pub load: f64,
    /// Of the other joint.
    pub other: [f64; 2],
}

/// A torque against the motion: `value + velocity (v − v⁻) + acceleration a` around the given state.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Resistance {
    /// Without the part of the acceleration, N m.
    pub value: f64,
    /// Slope, N m s/rad.
    pub velocity: f64,
    /// Slope, kg m².
    pub acceleration: f64,
}

/// A law and its values (variables, then parameters).
#[derive(Debug, Clone)]
pub(super) struct Smooth {
    law: Bound,
    values: Vec<f64>,
    gradient: Vec<f64>,
    /// The other joint of a pair.
    pub other: Option<usize>,
    /// It acts on the motor, at the motor's angle.
    pub on_motor: bool,
}

impl Smooth {
    /// The law of an effect, the library's or the user's own.
    pub fn new(effect: &Effect, other: Option<usize>) -> Result<Self, Diagnostic> {
        let refuse = |why: &str| {
            Err(Diagnostic::error(format!("`{effect}` cannot be simulated: {why}"))
                .help("take it out of the description or the scenario"))
        };
        if effect.kind.law.acts() != Acts::Torque {
            return refuse("nothing is known of its law");
        }
        let Some(text) = effect.law_text() else { return refuse("it has no formula") };
        let Ok(formula) = Formula::parse(text) else { return refuse("its formula does not read") };
        let user = effect.torque.is_some();
        if user && formula.names().iter().any(|name| name == "other_acceleration") {
            return refuse(
                "an acceleration of another joint makes the mass matrix unsymmetric: write two `coupling` effects with equal `inertia`",
            );
        }
        let mut names = VARIABLES.to_vec();
        let mut values = vec![0.0; VARIABLES.len()];
        for name in formula.names().iter().filter(|name| !VARIABLES.contains(&name.as_str())) {
            let known = effect.parameters.contains_key(name) || effect.kind.parameter(name).is_some();
            if !known && name != SMOOTHING {
                return refuse(&format!("its formula has the unknown name `{name}`"));
            }
            names.push(name);
            values.push(if known { effect.value(name) } else { DEFAULT_SMOOTHING });
        }
        let Ok(law) = formula.bind(&names) else { return refuse("its formula has unknown names") };
        let gradient = vec![0.0; values.len()];
        Ok(Self {
            law,
            values,
            gradient,
            other,
            on_motor: effect.kind.simulation == Simulation::MotorFormula,
        })
    }

    /// Around a state.
    pub fn at(&mut self, state: &Variables) -> Resistance {
        let [q, v, a] = state.own;
        let variables = [q, v, a, state.load, state.other[0], state.other[1], 0.0];
        self.values[..VARIABLES.len()].copy_from_slice(&variables);
        let value = self.law.gradient(&self.values, &mut self.gradient);
        let [velocity, acceleration] = [self.gradient[1], self.gradient[2]];
        // A slope against which nothing is damped is left to the held torque.
        Resistance { value: value - acceleration * a, velocity: velocity.max(0.0), acceleration }
    }
}
