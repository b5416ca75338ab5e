//! What defines a kind of effect.
use super::relations::Relations;
use super::search::Search;
use super::simulation::Simulation;
use super::sliding::at_sliding;
use std::fmt;
use std::hash::{Hash, Hasher};

/// A kind of physical effect: everything that the tools know of it. Kinds are equal if their names are.
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
    /// How a simulation takes it.
    pub simulation: Simulation,
    /// How a search for causes tries it.
    pub search: Search,
    /// What it has to do with other kinds.
    pub relations: Relations,
    /// How an identification by least squares offers it; `None` if it does not.
    pub identified: Option<Identified>,
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

/// A torque at a joint, linear in one parameter, that an identification estimates beside the bodies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Identified {
    /// On the command line: `viscous`.
    pub option: &'static str,
    /// As an unknown: `viscous_friction`.
    pub unknown: &'static str,
    /// Whether it is estimated unless told otherwise.
    pub by_default: bool,
    /// Whether a negative value has no physical meaning.
    pub positive: bool,
}

/// What a parameter's value says of whether the effect is there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Size {
    /// At this value there is no effect.
    NothingAt(f64),
    /// No value means that there is none, or only an infinite one.
    NeverNothing,
    /// It says where or how, not how much.
    Place,
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
    /// Whether it tells how large the effect is.
    pub size: Size,
    /// Refinement stays within these multiples of the value that a search found, where it may not go all over the bounds.
    pub reach: Option<(f64, f64)>,
    /// Unit at sliding joints where values are the same there, whatever unit that of the joint's position is.
    pub sliding: Option<&'static str>,
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
    /// The link's mass, centre of mass and inertia differ.
    InertialCorrection,
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

/// Where an effect acts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Acts {
    /// In the torque at a joint.
    Torque,
    /// In what the log says of that torque.
    Reading,
    /// In the time at which that torque acts.
    Time,
    /// In what the log says of a joint's position.
    Position,
    /// Between motor and link.
    Transmission,
    /// In a link's mass, centre of mass or inertia.
    Body,
    /// In the direction of gravity.
    Gravity,
    /// Where feet touch the ground.
    Ground,
    /// In what force sensors say.
    Sensor,
    /// In what a model leaves out (thesis 4.2).
    Assumption,
}

impl Law {
    /// Where it acts.
    pub const fn acts(self) -> Acts {
        match self {
            Self::Torque(_) | Self::Formula => Acts::Torque,
            Self::Reading(_) | Self::TrueTorque(_) => Acts::Reading,
            Self::Delay => Acts::Time,
            Self::EncoderOffset => Acts::Position,
            Self::SeriesElasticity | Self::Backlash => Acts::Transmission,
            Self::Payload | Self::CenterOfMassOffset | Self::InertiaError | Self::InertialCorrection => {
                Acts::Body
            }
            Self::GravityTilt => Acts::Gravity,
            Self::GroundSlope
            | Self::GroundCompliance
            | Self::Restitution
            | Self::Slip
            | Self::SpinFriction => Acts::Ground,
            Self::ForceSensorGain | Self::ForceSensorBias | Self::ForceSensorSaturation => Acts::Sensor,
            Self::PointFeet | Self::NoImpact | Self::SingleMass | Self::DecoupledPlanes => Acts::Assumption,
        }
    }
}

impl Kind {
    /// Unit of a parameter at a turning or a sliding joint; `1` for names that it does not know.
    pub fn unit(&'static self, parameter: &str, sliding: bool) -> &'static str {
        self.parameter(parameter).map_or("1", |p| if sliding { p.at_sliding().0 } else { p.unit })
    }

    /// The parameter of this name.
    pub fn parameter(&self, name: &str) -> Option<&'static Parameter> {
        self.parameters.iter().find(|parameter| parameter.name == name)
    }

    /// Those that data decide.
    pub fn estimated(&self) -> impl Iterator<Item = &'static Parameter> + use<> {
        self.parameters.iter().filter(|parameter| parameter.role == Role::Estimated)
    }

    /// Whether its torque depends on the speed of a joint.
    pub fn follows_velocity(&self) -> bool {
        matches!(self.law, Law::Torque(text) if text.contains("velocity"))
    }

    /// The formula of its law, where it has one that the user does not write.
    pub fn formula(&self) -> Option<&'static str> {
        match self.law {
            Law::Torque(text) | Law::Reading(text) | Law::TrueTorque(text) => Some(text),
            _ => None,
        }
    }
}

impl fmt::Debug for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Kind").field(&self.name).finish()
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name)
    }
}

impl PartialEq for Kind {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self, other) || self.name == other.name
    }
}

impl Eq for Kind {}

impl PartialOrd for Kind {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl Ord for Kind {
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        self.name.cmp(other.name)
    }
}

impl Hash for Kind {
    fn hash<H: Hasher>(&self, state: &mut H) {
        self.name.hash(state);
    }
}

/// By its name.
impl serde::Serialize for Kind {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name)
    }
}

/// By its name; names that no kind has are errors.
impl<'de> serde::Deserialize<'de> for &'static Kind {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = String::deserialize(deserializer)?;
        super::kind(&name).ok_or_else(|| serde::de::Error::custom(format!("there is no effect `{name}`")))
    }
}

impl Parameter {
    /// Unit at sliding joints, and a usual value there for the value 1 at turning ones.
    pub(super) fn at_sliding(&self) -> (&'static str, f64) {
        self.sliding.map_or_else(|| at_sliding(self.unit), |unit| (unit, 1.0))
    }

    /// With this unit, and the same values, at sliding joints.
    pub(super) const fn at_sliding_in(self, unit: &'static str) -> Self {
        Self { sliding: Some(unit), ..self }
    }

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
