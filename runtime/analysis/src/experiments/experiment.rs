//! Measurements as the diagnosis sees them: residuals, and how effects would change them.
use crate::measure::JointPositions;
use crate::robot::link_inertias::CadError;
use crate::robot::{InertialParameters, LinkInertias};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, Evidence, Kind, Location, sought};
use serde::Serialize;

/// What kind of quantity a row is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Channel {
    /// Joint torque, N m (prismatic: N).
    Effort,
    /// Force rows of a moving base: what no actuator can give, N, world axes.
    BaseForce,
    /// Moment rows of a moving base, N m, base axes.
    BaseMoment,
    /// Centre of pressure, m, in the frame of the stance sole.
    Cop,
    /// Height of a loaded sole's corner less its mean over the stance, m.
    Sole,
    /// Motor angle minus joint angle, rad.
    Transmission,
    /// Generalised velocity just after an impact, m/s and rad/s.
    PostImpactVelocity,
}

impl Channel {
    /// As in JSON: `base_force`.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Effort => "effort",
            Self::BaseForce => "base_force",
            Self::BaseMoment => "base_moment",
            Self::Cop => "cop",
            Self::Sole => "sole",
            Self::Transmission => "transmission",
            Self::PostImpactVelocity => "post_impact_velocity",
        }
    }
    /// Unit of a root mean square over the rows of this kind.
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Effort | Self::BaseMoment => "N m",
            Self::BaseForce => "N",
            Self::Cop | Self::Sole => "m",
            Self::Transmission => "rad",
            Self::PostImpactVelocity => "m/s, rad/s",
        }
    }
}

/// One measured scalar over all samples.
#[derive(Debug, Clone, PartialEq)]
pub struct Row {
    /// Such as `left_knee_pitch`, `cop/x`, `base/force/z`.
    pub name: String,
    /// What it is.
    pub channel: Channel,
    /// Of its values.
    pub unit: &'static str,
    /// The joint, for rows that belong to one.
    pub joint: Option<String>,
    /// Standard deviation of the measurement's noise as seen in the residual, estimated or given; > 0.
    pub noise: f64,
}

/// How the prediction of one row changes with the inertial parameters of the bodies.
///
/// Only the bodies that matter to the row are kept.
#[derive(Debug, Clone, Default)]
pub struct Inertial {
    /// Indices of the inertial parameters (ten per body, see `inertial_parameters`), increasing.
    pub columns: Vec<usize>,
    /// `samples × columns.len()`, sample after sample.
    pub values: Vec<f64>,
}

impl Inertial {
    /// Some of the samples.
    pub(crate) fn at(&self, samples: &[usize]) -> Self {
        let width = self.columns.len();
        let picked = samples.iter().flat_map(|&i| &self.values[i * width..(i + 1) * width]);
        Self { columns: self.columns.clone(), values: picked.copied().collect() }
    }
}

/// Measurements, the nominal model's prediction of them, and how effects change it.
///
/// A *residual* is measured minus predicted. All of it lives on one list of samples.
pub trait Experiment: Send + Sync {
    /// The measured rows.
    fn rows(&self) -> &[Row];

    /// Times of the samples, s; numbers of postures or impacts in tables.
    fn time(&self) -> &[f64];

    /// Measured minus nominal prediction of a row, one value per sample.
    fn residual(&self, row: usize) -> &[f64];

    /// What was measured, one value per sample; `None`: only the residual is known. For reports.
    fn measured(&self, _row: usize) -> Option<Vec<f64>> {
        None
    }

    /// Samples at which a joint sticks, so that its row bounds a torque and tells none: one flag each; empty: nowhere.
    fn sticks(&self, _row: usize) -> &[bool] {
        &[]
    }
    /// Samples at which something shakes the robot, so that no row tells anything ([`Experiment::sticks`] has them too): one flag each;
    /// empty: nowhere.
    fn shaken(&self) -> Vec<bool> {
        Vec::new()
    }

    /// Effects of the description in joints, which the model has already.
    fn described(&self) -> &[Effect] {
        &[]
    }

    /// Standard deviation of what the noise of the measured motion makes of a row, through filter and model, where it is not in the row's
    /// own [`Row::noise`].
    fn motion_noise(&self, _row: usize) -> f64 {
        0.0
    }

    /// The part of a row's own [`Row::noise`] that is in its signals too: what the noise of feet's sensors, base and motion makes of the model's side.
    /// Signals tell it, though it is nothing but noise.
    fn noise_in_signals(&self, _row: usize) -> f64 {
        0.0
    }

    /// What nobody sees of joints that rest within a step of their encoders, in a row: the most that their angles, being elsewhere in it, make, and what motions
    /// within it make that are as quick as those of the joints that move (root mean square).
    fn within_steps(&self, _row: usize) -> [f64; 2] {
        [0.0; 2]
    }

    /// Over how many samples, on either side, the filter of a joint's motion smears a jump of its acceleration; 0: none.
    fn smeared(&self) -> usize {
        0
    }

    /// Samples at which effects have a link on its way between the stops of a play behind a motor, whose angle alone is measured: one flag
    /// each; empty: nowhere.
    fn crossings(&self, _effects: &[Effect]) -> Vec<bool> {
        Vec::new()
    }

    /// Part of the samples that lie beside impacts at which the motion is cut, where the filter has one side to look at.
    fn beside_impacts(&self) -> f64 {
        0.0
    }

    /// The nominal residual minus the residual under the effects, for the rows that change: what the effects
    /// together explain. Effects that do not apply change nothing.
    fn response(&self, effects: &[Effect]) -> Vec<(usize, Vec<f64>)>;

    /// Kinds and places that make sense here and that the measurements could show.
    fn candidates(&self) -> Vec<(&'static Kind, Location)>;

    /// Values from which the search for an effect's parameters should start, where the measurements tell them at sight:
    /// the value at which a sensor stays. `None`: the usual starts.
    fn guess(&self, _kind: &'static Kind, _place: &Location) -> Option<Effect> {
        None
    }

    /// Number of inertial parameters of the model, ten per body; 0 if they play no part.
    fn inertial_count(&self) -> usize {
        0
    }

    /// Nominal inertial parameters: mass, first moments, inertia about the frame's origin, per body.
    fn inertial_parameters(&self) -> &InertialParameters {
        InertialParameters::none()
    }

    /// Derivative of a row's prediction by the inertial parameters; `None` if it has none.
    fn inertial(&self, _row: usize) -> Option<&Inertial> {
        None
    }

    /// The same of all rows, at some samples (increasing) alone.
    fn inertial_at(&self, samples: &[usize]) -> Vec<Option<Inertial>> {
        (0..self.rows().len()).map(|row| self.inertial(row).map(|inertial| inertial.at(samples))).collect()
    }

    /// One of [`Self::signals`] by its name.
    fn signal(&self, row: usize, name: &str) -> Option<Vec<f64>> {
        let mut signals = self.signals(row);
        let at = signals.iter().position(|(known, _)| known == name)?;
        Some(signals.swap_remove(at).1)
    }

    /// Signals that a row's residual may go with, by name, one value per sample: the joint's position, velocity and
    /// load first, then others. They serve to say whether something unexplained is left, and what it goes with.
    fn signals(&self, _row: usize) -> Vec<(String, Vec<f64>)> {
        Vec::new()
    }

    /// What the robot does at the samples, by name (`double support`, `just after impact`), where the measurements
    /// tell: one flag per sample. They need not exclude one another.
    fn phases(&self) -> Vec<(String, Vec<bool>)> {
        Vec::new()
    }

    /// Where to start looking for the parameter of a kind that does not enter linearly; `None`: the kind's own seeds.
    fn seeds(&self, _kind: &'static Kind, _location: &Location) -> Option<Vec<f64>> {
        None
    }

    /// The links behind the inertial parameters; `None` if these play no part.
    fn link_inertias(&self) -> Option<&LinkInertias> {
        None
    }

    /// Where the joint of a place slides: a small part of its usual speed, m/s, over which friction may change its sign.
    fn slides(&self, _place: &Location) -> Option<f64> {
        None
    }

    /// By how much torques at the joint of a place, or masses of the robot, are larger than those of robots of which effects have usual sizes;
    /// at least 1.
    fn heaviness(&self, _place: &Location) -> f64 {
        1.0
    }

    /// How many times as slow as usual the joint of a place moves and accelerates, each at least 1.
    fn slowness(&self, _place: &Location) -> [f64; 2] {
        [1.0; 2]
    }

    /// A small part of the torque that the joint of a place usually transmits, N m (N), below which play may be anywhere between its stops.
    fn small_load(&self, _place: &Location) -> Option<f64> {
        None
    }

    /// Directions of usual CAD errors in the space of the inertial parameters, each one standard deviation long:
    /// index of the body, ten numbers.
    fn cad_directions(&self, error: &CadError) -> Vec<(usize, [f64; 10])> {
        let directions = self.link_inertias().map_or_else(Vec::new, |links| links.cad_directions(error));
        directions.into_iter().map(|(_, body, direction)| (body, direction)).collect()
    }

    /// What an effect on a link adds to the inertial parameters; empty if inertial parameters play no part.
    fn inertial_change(&self, effect: &Effect) -> InertialParameters {
        let of = |links: &LinkInertias| links.change(std::slice::from_ref(effect));
        self.link_inertias().map_or_else(InertialParameters::default, of)
    }

    /// Names of the bodies' main links, one per ten inertial parameters.
    fn bodies(&self) -> &[String] {
        self.link_inertias().map_or(&[], |links| &links.bodies)
    }

    /// What is wrong or odd with the data themselves, before anything is searched for: mixed-up channels, joints that
    /// hardly move. Errors mean that nothing could be concluded.
    fn check(&self) -> Vec<Diagnostic> {
        Vec::new()
    }

    /// How long the samples are of that count, s; `None` in tables.
    fn duration(&self) -> Option<f64> {
        None
    }

    /// Names of the joints of which efforts could have been compared, had they been seen: more than there are rows of efforts where the
    /// log does not tell of all.
    fn joints(&self) -> Vec<&str> {
        Vec::new()
    }

    /// How the joints moved, for telling whether motions repeat; empty in tables.
    fn motion(&self) -> JointPositions {
        JointPositions::default()
    }
}

/// The kinds that a search looks for in such evidence, each at the places where it may show.
pub(crate) fn sought_at(
    evidence: Evidence,
    places: impl Fn(&'static Kind) -> Vec<Location>,
) -> Vec<(&'static Kind, Location)> {
    sought(evidence).flat_map(|kind| places(kind).into_iter().map(move |place| (kind, place))).collect()
}
