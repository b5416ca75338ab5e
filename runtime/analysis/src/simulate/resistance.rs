//! Smooth laws of effects at joints, with their slopes: what a step needs to take them at its middle.
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::formula::Formula;
use bipedc_effects::effect::{Acts, BoundLaw, Effect, Simulation, VARIABLES};

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

/// A law with room for its slopes.
#[derive(Debug, Clone)]
pub(super) struct Smooth {
    law: BoundLaw,
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
        let law = match BoundLaw::new(text, &VARIABLES, effect) {
            Ok(law) => law,
            Err(why) => return refuse(&why),
        };
        let across = Formula::parse(text)
            .is_ok_and(|formula| formula.names().iter().any(|name| name == "other_acceleration"));
        if effect.torque.is_some() && across {
            return refuse(
                "an acceleration of another joint makes the mass matrix unsymmetric: write two `coupling` effects with equal `inertia`",
            );
        }
        let gradient = vec![0.0; law.width()];
        Ok(Self { law, gradient, other, on_motor: effect.kind.simulation == Simulation::MotorFormula })
    }

    /// Around a state.
    pub fn at(&mut self, state: &Variables) -> Resistance {
        let [q, v, a] = state.own;
        let variables = [q, v, a, state.load, state.other[0], state.other[1], 0.0];
        let value = self.law.gradient(&variables, &mut self.gradient);
        let [velocity, acceleration] = [self.gradient[1], self.gradient[2]];
        // A slope against which nothing is damped is left to the held torque.
        Resistance { value: value - acceleration * a, velocity: velocity.max(0.0), acceleration }
    }
}
