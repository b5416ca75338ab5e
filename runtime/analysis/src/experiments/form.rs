//! How a kind of effect is searched for: columns that enter linearly, and how parameters follow from their
//! coefficients.
use crate::experiments::{Experiment, Inertial};
use crate::number::with_unit;
use crate::robot::InertialParameters;
use bipedc_effects::effect::{Effect, Kind, Law, Location, Parameters, Probe, Simulation, kinds};

/// The parameter of the sign of friction, or of the side of play.
const SMOOTHING: &str = "smoothing";

/// By so small a part of another parameter of its unit may a parameter lie below what is possible: it is nothing then.
const SLIGHT: f64 = 0.03;

/// In about so long, s, a load on the ground changes: damping that makes less than [`SLIGHT`] of what the stiffness makes is nothing.
const SWAY: f64 = 0.1;

/// Payloads of which the first moment alone is known are sought from so far out, m: closer ones are then found by steps that
/// double their mass at most.
const FAR: f64 = 1.0;

/// Lighter ones are none, kg.
const LIGHT: f64 = 1e-4;

/// A column: rows that it touches, with one value per sample.
pub(crate) type Column = Vec<(usize, Vec<f64>)>;

/// A candidate at a place, with its nonlinear parameters fixed.
#[derive(Debug, Clone)]
pub(crate) struct Form {
    pub kind: &'static Kind,
    pub location: Location,
    /// Value of the parameter that does not enter linearly.
    pub setting: f64,
    pub search: Search,
    /// Parameters that are not searched for.
    pub fixed: Parameters,
    /// Speed over which friction changes its sign where the joint slides, m/s.
    pub sliding: Option<f64>,
    /// Torque over which play changes its side, N m.
    pub small_load: Option<f64>,
    /// How far parameters may lie beyond what is usual.
    pub reach: Reach,
}

/// What enters linearly.
#[derive(Debug, Clone)]
pub(crate) enum Search {
    /// Responses of the experiment.
    Probes(Vec<Probe>),
    /// Directions in the space of the inertial parameters.
    Inertial(Vec<InertialParameters>),
}

/// How far parameters at a place may lie beyond what is usual.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Reach {
    /// Of torques, forces, inertias and masses, see [`Experiment::heaviness`].
    heaviness: f64,
    /// How far a centre of mass may be from where it should be, m: in so many radii of gyration of its link.
    length: f64,
    /// How many times as slowly as usual the joint moves and accelerates, each at least 1.
    slowness: [f64; 2],
    /// How many times as long as those of usual robots the link is, at least 1.
    longer: f64,
}

impl Reach {
    pub fn of(experiment: &dyn Experiment, place: &Location) -> Self {
        const RADII: f64 = 1.5;
        /// So far from its frame, m, links have their mass on robots whose payloads the library calls usual.
        const EXTENT: f64 = 0.5;
        let links = experiment.link_inertias().map_or(&[][..], |inertias| &inertias.links);
        let own = links.iter().find(|link| place.link.as_ref() == Some(&link.name));
        Self {
            heaviness: experiment.heaviness(place),
            slowness: experiment.slowness(place),
            length: RADII * own.map_or(0.0, |link| link.size()),
            longer: own.map_or(1.0, |link| (link.extent() / EXTENT).max(1.0)),
        }
    }

    /// The range that is usual for a robot of this size.
    pub fn usual(self, effect: &Effect, name: &str) -> (f64, f64) {
        let (low, high) = effect.plausible(name);
        let times = self.times(effect, name);
        (if low > 0.0 { low } else { low * times }, high * times)
    }

    /// How many times as large as for a usual robot a parameter may be.
    fn times(self, effect: &Effect, name: &str) -> f64 {
        let [slower, softer] = self.slowness;
        let unit = effect.unit(name);
        let is = |kind: &Kind| effect.kind == kind;
        let grows = ["N", "kg"].iter().any(|of| unit.starts_with(of));
        match grows {
            true if is(&kinds::VISCOUS_FRICTION) => self.heaviness * slower,
            true if is(&kinds::QUADRATIC_DRAG) => self.heaviness * slower * slower,
            true if is(&kinds::ROTOR_INERTIA) => self.heaviness * softer,
            true => self.heaviness,
            false if is(&kinds::PAYLOAD) && unit == "m" => self.longer,
            false => 1.0,
        }
    }

    /// Whether a value may be true: beyond what is usual it is flagged then, far beyond it is another cause. Effects of many parameters
    /// explain much with values that are none.
    pub fn holds(self, effect: &Effect, name: &str, value: f64) -> bool {
        const FEW: usize = 3;
        let is_center = *effect.kind == kinds::COM_OFFSET;
        let is_simple = effect.kind.estimated().count() <= FEW
            && !is_center
            && !matches!(effect.kind.simulation, Simulation::Coupling { .. });
        let beyond = if is_simple { 1.0 } else { 0.2 };
        let (low, high) = effect.plausible(name);
        let slack = beyond * (high - low);
        let part = match is_center {
            true => (self.length / (high + slack)).max(1.0),
            false => self.times(effect, name),
        };
        let least = if low > 0.0 { low / (1.0 + beyond) } else { (low - slack) * part };
        (least..=(high + slack) * part).contains(&value)
    }
}

/// What a kind at a place adds to the rows, per coefficient that enters linearly, with its other parameter at
/// `setting`; `None` for kinds that are not searched for.
pub(crate) fn effect_columns(
    experiment: &dyn Experiment,
    kind: &'static Kind,
    location: &Location,
    setting: f64,
) -> Option<Vec<Column>> {
    let form = Form::new(experiment, kind, location, setting)?;
    let Search::Inertial(directions) = &form.search else { return Some(form.columns(experiment)) };
    let rows = 0..experiment.rows().len();
    let inertial: Vec<_> = rows.filter_map(|row| Some((row, experiment.inertial(row)?))).collect();
    let along = |direction: &InertialParameters| {
        let of_row = |(row, inertial): &(usize, &Inertial)| {
            let change: Vec<f64> = inertial.columns.iter().map(|column| direction[*column]).collect();
            let samples = inertial.values.chunks_exact(change.len().max(1));
            (*row, samples.map(|y| y.iter().zip(&change).map(|(y, c)| y * c).sum()).collect())
        };
        inertial.iter().filter(|(_, inertial)| !inertial.columns.is_empty()).map(of_row).collect()
    };
    Some(directions.iter().map(along).collect())
}

/// Takes moments of inertia about axes of which the data tell nothing, which a fit leaves as they are, for changed as much as the others: about one axis alone a body's inertia
/// cannot grow for long.
fn complete(found: &mut [(&'static str, f64)]) {
    let diagonal = |name: &str| ["ixx", "iyy", "izz"].contains(&name);
    let told =
        found.iter().filter(|(name, change)| diagonal(name) && *change != 0.0).map(|(_, change)| change);
    let (sum, count) = told.fold((0.0, 0), |(sum, count), change| (sum + change, count + 1));
    if count > 0 {
        let idle = found.iter_mut().filter(|(name, change)| diagonal(name) && *change == 0.0);
        idle.for_each(|(_, change)| *change = sum / f64::from(count));
    }
}

/// Empties columns that are next to nothing beside the largest, of parameters of one unit: a tilt about the axis of the only joint does nothing but what rounding and the
/// square of a small angle do, and a fit would make anything of it.
fn without_slight(columns: &mut [Column]) {
    const SLIGHT: f64 = 1e-8;
    let squares = |column: &Column| column.iter().flat_map(|(_, values)| values).map(|x| x * x).sum::<f64>();
    let largest = columns.iter().map(squares).fold(0.0, f64::max);
    columns.iter_mut().filter(|column| squares(column) < SLIGHT * largest).for_each(Vec::clear);
}

impl Form {
    /// All forms of a candidate: one per seed of its nonlinear parameter.
    pub fn all(experiment: &dyn Experiment, kind: &'static Kind, location: &Location) -> Vec<Self> {
        kind.starts().iter().filter_map(|setting| Self::new(experiment, kind, location, *setting)).collect()
    }

    /// The form with this value of the nonlinear parameter.
    pub fn new(
        experiment: &dyn Experiment,
        kind: &'static Kind,
        location: &Location,
        setting: f64,
    ) -> Option<Self> {
        let search = match Self::inertial(experiment, kind, location) {
            Some(directions) => Search::Inertial(directions),
            None => Search::Probes(kind.probes(setting)?),
        };
        Some(Self {
            kind,
            location: location.clone(),
            setting,
            search,
            fixed: Vec::new(),
            sliding: experiment.slides(location),
            small_load: (kind.law == Law::Backlash).then(|| experiment.small_load(location)).flatten(),
            reach: Reach::of(experiment, location),
        })
    }

    /// A payload at the origin of its link, of which only the mass is searched for: what a scale would show.
    pub fn mass_only(experiment: &dyn Experiment, location: &Location) -> Option<Self> {
        let fixed = vec![("x", 0.0), ("y", 0.0), ("z", 0.0)];
        let parameters = [&[("mass", 1.0)], fixed.as_slice()].concat();
        let direction =
            experiment.inertial_change(&Effect::new(&kinds::PAYLOAD, location.clone(), &parameters));
        let search = Search::Inertial(vec![direction]);
        let of_link = location.link.is_some() && experiment.inertial_count() > 0;
        of_link.then(|| Self {
            kind: &kinds::PAYLOAD,
            location: location.clone(),
            setting: 0.0,
            search,
            fixed,
            sliding: None,
            small_load: None,
            reach: Reach::of(experiment, location),
        })
    }

    /// Effects on links change inertial parameters, where these are columns already.
    fn inertial(
        experiment: &dyn Experiment,
        kind: &'static Kind,
        location: &Location,
    ) -> Option<Vec<InertialParameters>> {
        location.link.as_ref()?;
        if experiment.inertial_count() == 0 {
            return None;
        }
        let change = |parameters: &[(&str, f64)]| {
            experiment.inertial_change(&Effect::new(kind, location.clone(), parameters))
        };
        let difference = |a: InertialParameters, b: &[f64], factor: f64| -> InertialParameters {
            a.iter().zip(b).map(|(a, b)| factor * (a - b)).collect()
        };
        Some(match kind.law {
            Law::Payload => {
                let still = change(&[("mass", 1.0)]);
                // Central differences: the quadratic part (mass times squared distance) is left to refinement.
                let moment = |axis: &'static str| {
                    let (far, near) =
                        (change(&[("mass", 1.0), (axis, 0.5)]), change(&[("mass", 1.0), (axis, -0.5)]));
                    difference(far, &near, 1.0)
                };
                vec![still, moment("x"), moment("y"), moment("z")]
            }
            Law::CenterOfMassOffset => ["x", "y", "z"]
                .map(|axis| difference(change(&[(axis, 5e-4)]), &change(&[(axis, -5e-4)]), 1e3))
                .to_vec(),
            Law::InertiaError => {
                ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|name| change(&[(name, 1.0)])).to_vec()
            }
            _ => return None,
        })
    }

    /// The same form with its directions taken at an estimate, where the kind is not linear: second moments of a
    /// payload grow with the square of its distance. They are homogeneous in mass and first moment, so that
    /// directions times coefficients are the exact change at the estimate itself.
    pub fn linearised(&self, experiment: &dyn Experiment, coefficients: &[f64]) -> Option<Self> {
        let (Search::Inertial(_), Law::Payload, [mass, moments @ ..]) =
            (&self.search, self.kind.law, coefficients)
        else {
            return None;
        };
        let moment = moments.iter().fold(0.0_f64, |sum, x| sum.hypot(*x));
        // Of a link that turns about a fixed axis the first moment alone enters linearly.
        let mass = if *mass == 0.0 { &(moment / FAR) } else { mass };
        if *mass < LIGHT || moments.len() != 3 {
            return None;
        }
        let change = |mass: f64, moments: &[f64]| {
            let at = |k: usize| moments[k] / mass;
            let parameters = [("mass", mass), ("x", at(0)), ("y", at(1)), ("z", at(2))];
            experiment.inertial_change(&Effect::new(self.kind, self.location.clone(), &parameters))
        };
        let slope = |far: InertialParameters, near: InertialParameters, step: f64| -> InertialParameters {
            far.iter().zip(&near).map(|(f, n)| (f - n) / (2.0 * step)).collect()
        };
        let step = 1e-3 * mass;
        let mut directions = vec![slope(change(mass + step, moments), change(mass - step, moments), step)];
        for k in 0..3 {
            let moved = |sign: f64| {
                let mut moments = moments.to_vec();
                moments[k] += sign * step;
                change(*mass, &moments)
            };
            directions.push(slope(moved(1.0), moved(-1.0), step));
        }
        Some(Self { search: Search::Inertial(directions), ..self.clone() })
    }

    /// The columns in an experiment; none for inertial directions.
    pub fn columns(&self, experiment: &dyn Experiment) -> Vec<Column> {
        let Search::Probes(probes) = &self.search else { return Vec::new() };
        let mut columns: Vec<Column> = probes.iter().map(|probe| self.column(experiment, probe)).collect();
        if *self.kind == kinds::GRAVITY_TILT {
            without_slight(&mut columns);
        }
        columns
    }

    fn column(&self, experiment: &dyn Experiment, probe: &Probe) -> Column {
        let mut sum: Column = Vec::new();
        for (factor, parameters) in probe {
            let effect = self.with(parameters);
            for (row, values) in experiment.response(std::slice::from_ref(&effect)) {
                match sum.iter_mut().find(|(r, _)| *r == row) {
                    Some((_, total)) => total.iter_mut().zip(&values).for_each(|(t, v)| *t += factor * v),
                    None => sum.push((row, values.iter().map(|v| factor * v).collect())),
                }
            }
        }
        sum.retain(|(_, values)| values.iter().any(|v| *v != 0.0));
        sum
    }

    /// Whether it is of the effect's kind and at its place.
    pub fn is_of(&self, effect: &Effect) -> bool {
        self.kind == effect.kind && self.location == effect.location
    }

    /// Number of parameters that the data decide.
    pub fn parameters(&self) -> usize {
        self.kind.estimated().count().saturating_sub(self.fixed.len())
    }

    /// The effect with these linear coefficients.
    pub fn effect(&self, coefficients: &[f64]) -> Effect {
        let mut found =
            [self.kind.from_coefficients(self.setting, coefficients), self.fixed.clone()].concat();
        if *self.kind == kinds::INERTIA_ERROR {
            complete(&mut found);
        }
        for (name, value) in &mut found {
            if let Some(parameter) = self.kind.parameter(name) {
                *value = value.clamp(parameter.bounds.0, parameter.bounds.1);
            }
        }
        self.with(&found)
    }

    fn with(&self, parameters: &[(&str, f64)]) -> Effect {
        let mut effect = Effect::new(self.kind, self.location.clone(), parameters);
        if let Some(speed) = self.sliding {
            effect.sliding = true;
            if effect.unit(SMOOTHING) == "m/s" {
                effect.parameters.entry(SMOOTHING.to_owned()).or_insert(speed);
            }
        }
        if let Some(load) = self.small_load {
            effect.parameters.entry(SMOOTHING.to_owned()).or_insert(load);
        }
        effect
    }

    /// Whether the coefficients make a physically possible effect; else which parameter is impossible.
    pub fn impossible(&self, coefficients: &[f64]) -> Option<String> {
        if let Some(why) = (self.kind.search.refused)(self.setting, coefficients) {
            return Some(why);
        }
        let effect = self.effect(coefficients);
        let found = self.kind.from_coefficients(self.setting, coefficients);
        // Friction against one direction alone comes out a little below or above nothing against the other.
        let slight = |unit: &str| {
            if let Law::GroundCompliance = self.kind.law {
                return SLIGHT * SWAY * effect.value("stiffness");
            }
            let alike = found.iter().filter(|(name, _)| effect.unit(name) == unit);
            SLIGHT * alike.fold(0.0, |largest: f64, (_, value)| largest.max(*value))
        };
        found.iter().find_map(|(name, value)| {
            let parameter = self.kind.parameter(name)?;
            if !value.is_finite() {
                return Some(format!("this data does not determine its {name}"));
            }
            let slight = slight(effect.unit(name));
            let possible = parameter.bounds.0 - slight <= *value && *value <= parameter.bounds.1;
            let usual = self.reach.holds(&effect, name, *value);
            let size = with_unit(*value, effect.unit(name));
            match (possible, usual) {
                (true, true) => None,
                (true, false) => Some(format!("its {name} would be {size}, far beyond what is usual")),
                (false, _) => Some(format!("its {name} would be {size}")),
            }
        })
    }
}
