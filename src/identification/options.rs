//! How parameters are estimated.
use bipedc_analysis::identify::physical::Bound;
use bipedc_analysis::identify::{self, ExtraChoice, elastic, joint};
use bipedc_analysis::measure;
use bipedc_analysis::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Kind, kinds};

/// Motors slower than this part of their largest speed do not tell friction.
const SLOW_MOTOR: f64 = 3.0 / 100.0;
/// The slowest filter of rows that can be asked for, Hz: it lasts half a minute.
const SLOWEST: f64 = 0.05;

/// Which measurements tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Method {
    /// Joint torques (thesis 5.2); where the base moves and forces at the feet are logged, the rows of the base.
    #[default]
    Torque,
    /// Motor currents and springs of series elastic drives (thesis 5.3).
    Elastic,
    /// Centres of pressure of postures at rest (thesis 5.4.1).
    Cop,
    /// The ground's forces on a robot in motion (thesis 5.4.2).
    Zmp,
}

/// How residuals count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Estimator {
    /// All alike.
    Ordinary,
    /// Each joint by its own noise.
    #[default]
    Weighted,
    /// As weighted, and large residuals less.
    Huber,
    /// As weighted, with instruments against noisy regressors ([`Method::Elastic`]).
    Instrumental,
}

/// Joints whose effort moves a rotor too.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Rotors {
    /// None of them.
    #[default]
    None,
    /// Every joint.
    All,
    /// Those of these names.
    Of(Vec<String>),
}

/// How parameters are estimated. By default: from joint torques, each by its own noise, beside friction and offset of every joint.
#[derive(Debug, Clone)]
pub struct Options {
    /// Which measurements tell.
    pub method: Method,
    /// How residuals count.
    pub estimator: Estimator,
    /// What joints add: kinds of effects that are offered to identifications ([`identify::offered`]).
    pub friction: Vec<&'static Kind>,
    /// Joints whose effort moves a rotor too.
    pub rotors: Rotors,
    /// Names of two joints whose drives turn together.
    pub coupled: Vec<[String; 2]>,
    /// Filter of positions and efforts (without a cut-off: 10 Hz, but of joint torques as the motion and its noise ask for), and the times between which samples of the logs that teach count.
    pub reading: measure::Options,
    /// Keep every so many-th sample, after a low-pass over regressor and torque.
    pub decimate: usize,
    /// Cut-off of the low-pass over regressor and torque where samples are not decimated, Hz; by default as slow as the encoders' noise
    /// asks for and the motion allows.
    pub rows_hz: Option<f64>,
    /// Samples at which a joint is slower than this part of its largest speed do not count for it; by default 0.1 of joints with dry friction (0.25 of the
    /// usual speed if that is less), for motors of elastic drives 0.03.
    pub slow: Option<f64>,
    /// Motors first, then bodies, or one regression for both ([`Method::Elastic`]).
    pub steps: elastic::Steps,
    /// How much the description counts; by default chosen by folds.
    pub weight: Option<f64>,
    /// What all moving links weigh together, kg.
    pub total_mass: Option<f64>,
    /// What is known beside the data.
    pub bounds: Vec<Bound>,
    /// Foot that stands still ([`Method::Cop`], [`Method::Zmp`]); by default the right one.
    pub stance: Option<String>,
    /// Legs symmetric in x and y, feet in y: fewer parameters ([`Method::Cop`], thesis 8.3.2).
    pub symmetric: bool,
    /// Go on although channels seem to be mixed up.
    pub anyway: bool,
    /// Also fill a report.
    pub report: bool,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            method: Method::Torque,
            estimator: Estimator::Weighted,
            friction: ExtraChoice::default().laws,
            rotors: Rotors::None,
            coupled: Vec::new(),
            reading: measure::Options::default(),
            decimate: 1,
            rows_hz: None,
            slow: None,
            steps: elastic::Steps::Two,
            weight: None,
            total_mass: None,
            bounds: Vec::new(),
            stance: None,
            symmetric: false,
            anyway: false,
            report: false,
        }
    }
}

impl Options {
    /// Refuses numbers that have no meaning.
    pub(super) fn check(&self) -> Result<(), Diagnostic> {
        let refuse = |what: &str, value: f64, help: &str| {
            Err(Diagnostic::error(format!("{what} is {value}")).help(help.to_owned()))
        };
        let is_positive = |value: f64| value.is_finite() && value > 0.0;
        if let Some(cutoff) = self.reading.cutoff_hz.filter(|cutoff| !is_positive(*cutoff)) {
            return refuse("the cut-off of the filter", cutoff, "give a frequency in Hz");
        }
        if let Some(cutoff) =
            self.rows_hz.filter(|cutoff| !(SLOWEST..).contains(cutoff) || !cutoff.is_finite())
        {
            let help = format!(
                "give a frequency in Hz, {SLOWEST} at least: slower filters are longer than logs are"
            );
            return refuse("the cut-off of the rows' filter", cutoff, &help);
        }
        if self.rows_hz.is_some() && self.decimate > 1 {
            let message =
                "rows pass either the filter of their decimation or one with a cut-off of their own";
            return Err(Diagnostic::error(message).help("leave --decimate or --row-cutoff out"));
        }
        if let Some(slow) = self.slow.filter(|slow| !(0.0..0.5).contains(slow)) {
            return refuse("the part of a slow joint's speed", slow, "give a fraction below 0.5");
        }
        let trim = self.reading.trim_s;
        if !(trim.is_finite() && trim >= 0.0) {
            return refuse("what is left out at the ends", trim, "give a time in s");
        }
        match self.weight.filter(|weight| !is_positive(*weight)) {
            Some(weight) => refuse("the weight of the description", weight, "give a positive number"),
            None => Ok(()),
        }
    }

    /// With a cut-off, if there is none.
    pub(super) fn with_cutoff(mut self) -> Self {
        self.reading.cutoff_hz.get_or_insert(measure::CUTOFF_HZ);
        self
    }

    /// With what the joints of this robot add.
    pub(super) fn of_joints(&self, layout: &JointLayout) -> Result<identify::Options, Diagnostic> {
        Ok(identify::Options { extras: self.extras(layout)?, ..self.estimation()? })
    }

    fn extras(&self, layout: &JointLayout) -> Result<ExtraChoice, Diagnostic> {
        let mut choice = ExtraChoice { laws: self.friction.clone(), ..ExtraChoice::none() };
        choice.rotors = match &self.rotors {
            Rotors::None => Vec::new(),
            Rotors::All => (0..layout.joints.len()).collect(),
            Rotors::Of(names) => names.iter().map(|name| joint(layout, name)).collect::<Result<_, _>>()?,
        };
        for [one, other] in &self.coupled {
            let pair = (joint(layout, one)?, joint(layout, other)?);
            if pair.0 == pair.1 {
                return Err(
                    Diagnostic::error(format!("--coupled names `{one}` twice")).help("give two joints")
                );
            }
            choice.coupled.push(pair);
        }
        Ok(choice)
    }

    /// Options that all methods have.
    pub(super) fn estimation(&self) -> Result<identify::Options, Diagnostic> {
        Ok(identify::Options {
            method: match self.estimator {
                Estimator::Ordinary => identify::Method::Ordinary,
                Estimator::Weighted => identify::Method::Weighted,
                Estimator::Huber => identify::Method::Huber,
                Estimator::Instrumental => {
                    return Err(Diagnostic::error("--estimator instrumental is for --method elastic")
                        .help("choose ordinary, weighted or huber"));
                }
            },
            decimate: self.decimate,
            rows_hz: self.rows_hz,
            slow: self.slow,
            weight: self.weight,
            bounds: self.all_bounds(),
            pictures: self.report,
            ..identify::Options::default()
        })
    }

    fn all_bounds(&self) -> Vec<Bound> {
        self.total_mass.map(Bound::TotalMass).into_iter().chain(self.bounds.iter().cloned()).collect()
    }

    /// For series elastic drives.
    pub(super) fn of_drives(&self) -> Result<elastic::Elastic, Diagnostic> {
        let refuse = |option: &str, help: &str| {
            let message = format!("{option} has no meaning with --method elastic");
            Err(Diagnostic::error(message).help(help.to_owned()))
        };
        if self.rotors != Rotors::None {
            return refuse("--rotor", "rotor inertias are taken from the drive trains of biped.toml");
        }
        if !self.coupled.is_empty() {
            return refuse("--coupled", "leave it out: drives act on their own joint");
        }
        if self.decimate > 1 || self.rows_hz.is_some() {
            let option = if self.decimate > 1 { "--decimate" } else { "--row-cutoff" };
            return refuse(option, "leave it out: regressor and torque pass the same filter already");
        }
        let known = [&kinds::VISCOUS_FRICTION, &kinds::COULOMB_FRICTION, &kinds::TORQUE_BIAS];
        if let Some(other) = self.friction.iter().find(|kind| !known.contains(kind)) {
            let help = "the drives of thesis 5.3 have viscous friction, Coulomb friction and an offset";
            return refuse(&format!("--friction {other}"), help);
        }
        let [viscous, coulomb, offset] = known.map(|kind| self.friction.contains(&kind));
        Ok(elastic::Elastic {
            laws: elastic::Laws { viscous, coulomb, offset },
            slow: self.slow.unwrap_or(SLOW_MOTOR),
            steps: self.steps,
            estimator: match self.estimator {
                Estimator::Ordinary => elastic::Estimator::Ordinary,
                Estimator::Weighted => elastic::Estimator::Weighted,
                Estimator::Instrumental => elastic::Estimator::Instrumental,
                Estimator::Huber => {
                    return refuse("--estimator huber", "choose ordinary, weighted or instrumental");
                }
            },
            weight: self.weight,
            bounds: self.all_bounds(),
            anyway: self.anyway,
            pictures: self.report,
        })
    }
}
