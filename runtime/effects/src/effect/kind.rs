//! What defines a kind of effect.

/// A kind of physical effect.
#[derive(Debug)]
pub struct Kind {
    /// As in `biped.toml` and on the command line: `coulomb_friction`.
    pub name: &'static str,
    /// For people: `Coulomb friction`.
    pub title: &'static str,
    /// What it belongs to.
    pub place: Place,
    /// In the order in which tables show them.
    pub parameters: &'static [Parameter],
    /// What it does.
    pub law: Law,
    /// What it is, one sentence.
    pub meaning: &'static str,
    /// What it looks like in a residual, a clause that can follow "the residual".
    pub symptom: &'static str,
    /// What it is easily confused with.
    pub confounders: &'static [Confounder],
    /// The motion that shows it best, an imperative sentence.
    pub experiment: &'static str,
}

/// Another kind that looks the same on poor data.
#[derive(Debug)]
pub struct Confounder {
    /// Name of the kind.
    pub kind: &'static str,
    /// The motion that tells the two apart, an imperative sentence.
    pub experiment: &'static str,
}

/// What an effect belongs to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// `joint = "…"`
    Joint,
    /// `joint = "…"` and `other_joint = "…"`
    JointPair,
    /// `link = "…"`
    Link,
    /// `sensor = "foot"` or `"foot/corner"`; none means all.
    Sensor,
    /// The robot as a whole or the ground: no place.
    Robot,
}

/// One number of an effect.
#[derive(Debug)]
pub struct Parameter {
    /// As in `biped.toml`.
    pub name: &'static str,
    /// SI unit, `1` if it has none.
    pub unit: &'static str,
    /// Estimated from data, or set.
    pub role: Role,
    /// Physically possible values; the estimator stays within.
    pub bounds: (f64, f64),
    /// Usual values; others are flagged.
    pub plausible: (f64, f64),
    /// What it is, a noun phrase.
    pub meaning: &'static str,
}

/// Where a parameter's value comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Role {
    /// From data; must stand in the description.
    Estimated,
    /// A setting with this default; may be left out of the description and is not estimated.
    Setting(f64),
}

/// What an effect does. Formulas are written in the language of [`crate::effect::formula`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Law {
    /// Added to the joint's torque in inverse dynamics. Variables: `position`, `velocity`, `acceleration` of the joint,
    /// `load` (the rigid-body model's torque at the joint, never a measured one), and for pairs `other_position`,
    /// `other_velocity`, `other_acceleration`; the effect's parameters by their names. `sign(x)` is
    /// `tanh(x / smoothing)` with the effect's setting `smoothing`.
    Torque(&'static str),
    /// The torque that the log reports, from the variable `torque`, the true one.
    Reading(&'static str),
    /// The true torque from the reported one, variable `reading`: for laws that cannot be turned around.
    TrueTorque(&'static str),
    /// The reported torque acts later by the parameter `delay`.
    Delay,
    /// The logged joint position is the true one plus the parameter `offset`.
    EncoderOffset,
    /// A point mass on a link.
    Payload,
    /// The link's centre of mass lies elsewhere.
    CenterOfMassOffset,
    /// The link's inertia about its centre of mass differs.
    InertiaError,
    /// The world is turned against what the base orientation says: `R = R_y(pitch) R_x(roll)`.
    GravityTilt,
    /// The ground is turned against level: `R = R_y(pitch) R_x(roll)`.
    GroundSlope,
    /// A spring between motor and link.
    SeriesElasticity,
    /// Play between motor and link.
    Backlash,
    /// Foot force sensors read gain times the force.
    ForceSensorGain,
    /// Foot force sensors read the force plus a constant.
    ForceSensorBias,
    /// Foot force sensors read at most the limit.
    ForceSensorSaturation,
    /// Spring and damper below every corner of the soles.
    GroundCompliance,
    /// Feet bounce.
    Restitution,
    /// Feet slip where the tangential force exceeds friction times normal force.
    Slip,
    /// Feet turn about the vertical where the moment exceeds friction times radius times normal force.
    SpinFriction,
    /// The soles are points (thesis 4.2).
    PointFeet,
    /// Velocities do not jump at impacts (thesis 4.2).
    NoImpact,
    /// All mass is in the centre of mass (thesis 4.2).
    SingleMass,
    /// Sagittal and frontal plane are independent (thesis 4.2).
    DecoupledPlanes,
    /// The user's own formula, kept in the effect; added like [`Law::Torque`].
    Formula,
}

impl Kind {
    /// The parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&'static Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Those that data decide.
    pub fn estimated(&self) -> impl Iterator<Item = &'static Parameter> + use<> {
        self.parameters.iter().filter(|parameter| parameter.role == Role::Estimated)
    }
}

impl Parameter {
    /// A usual value: between the ends of the usual range, geometrically where it spans decades; one digit.
    pub fn example(&self) -> f64 {
        let (low, high) = self.plausible;
        let value: f64 = match (low, high) {
            (low, high) if low < 0.0 => high / 10.0,
            (low, high) if low > 0.0 => (low * high).sqrt(),
            (_, high) => high / 50.0,
        };
        let scale = 10.0_f64.powf(value.abs().log10().floor());
        format!("{:e}", (value / scale).round() * scale)
            .parse::<f64>()
            .map_or(value, |v| (v * 1e9).round() / 1e9)
    }
}
