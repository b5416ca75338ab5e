//! How a kind of effect is searched for: columns that enter linearly, and how parameters follow from their
//! coefficients.
use crate::experiments::{Experiment, Inertial};
use bipedc_effects::effect::{Effect, Location};

/// A column: rows that it touches, with one value per sample.
pub(crate) type Column = Vec<(usize, Vec<f64>)>;

/// Gains nearer to one are one.
const SAME_GAIN: f64 = 0.005;

/// Parameters by name.
pub(crate) type Parameters = Vec<(&'static str, f64)>;

/// A sum of responses: factor and the parameters to respond with.
type Probe = Vec<(f64, Parameters)>;

/// A candidate at a place, with its nonlinear parameters fixed.
#[derive(Debug, Clone)]
pub(crate) struct Form {
    pub kind: &'static str,
    pub location: Location,
    /// Value of the parameter that does not enter linearly.
    pub setting: f64,
    pub search: Search,
    /// Parameters that are not searched for.
    pub fixed: Parameters,
}

/// What enters linearly.
#[derive(Debug, Clone)]
pub(crate) enum Search {
    /// Responses of the experiment.
    Probes(Vec<Probe>),
    /// Directions in the space of the inertial parameters.
    Inertial(Vec<Vec<f64>>),
}

/// Seeds of the nonlinear parameter by kind: where the search starts.
pub(crate) fn settings(kind: &str) -> &'static [f64] {
    match kind {
        "stribeck_friction" => &[0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 2.0],
        "actuator_delay" => &[0.001, 0.004, 0.015],
        "foot_slip" => &[0.08, 0.12, 0.16, 0.2, 0.25, 0.3, 0.4, 0.5, 0.65, 0.8],
        "spin_friction" => &[0.005, 0.01, 0.02, 0.05],
        _ => &[0.0],
    }
}

fn unit(name: &'static str) -> Probe {
    vec![(1.0, vec![(name, 1.0)])]
}

/// A small step, scaled up: the slope at zero.
fn slope(name: &'static str, step: f64) -> Probe {
    vec![(1.0 / step, vec![(name, step)])]
}

/// The probes of kinds that are not on links.
fn probes(kind: &str, setting: f64) -> Option<Vec<Probe>> {
    Some(match kind {
        "viscous_friction" => vec![unit("damping")],
        "coulomb_friction" => vec![unit("torque")],
        "asymmetric_coulomb_friction" => vec![
            vec![(1.0, vec![("positive", 1.0), ("negative", 0.0)])],
            vec![(1.0, vec![("positive", 0.0), ("negative", 1.0)])],
        ],
        "stribeck_friction" => vec![
            vec![(1.0, vec![("coulomb", 1.0), ("static", 0.0), ("stribeck_velocity", setting)])],
            vec![(1.0, vec![("coulomb", 0.0), ("static", 1.0), ("stribeck_velocity", setting)])],
        ],
        "load_dependent_friction" => vec![unit("coefficient")],
        "rotor_inertia" => vec![unit("inertia")],
        "parallel_spring" => vec![
            vec![(1.0, vec![("stiffness", 1.0), ("rest_angle", 0.0)])],
            vec![
                (1.0, vec![("stiffness", 1.0), ("rest_angle", 0.0)]),
                (-1.0, vec![("stiffness", 1.0), ("rest_angle", 1.0)]),
            ],
        ],
        // 1/gain − 1 enters linearly.
        "torque_gain" => vec![vec![(1.0, vec![("gain", 0.5)])]],
        "torque_bias" => vec![unit("bias")],
        "torque_ripple" => [0.0, std::f64::consts::FRAC_PI_2]
            .map(|phase| {
                vec![(1.0, vec![("amplitude", 1.0), ("periods_per_turn", setting), ("phase", phase)])]
            })
            .to_vec(),
        "actuator_delay" => vec![slope("delay", setting)],
        "torque_saturation" | "force_sensor_saturation" => vec![vec![(1.0, vec![("limit", setting)])]],
        "foot_slip" => vec![vec![(1.0, vec![("friction", setting)])]],
        "spin_friction" => vec![vec![(1.0, vec![("radius", setting)])]],
        "encoder_offset" => vec![slope("offset", 1e-4)],
        "gravity_tilt" | "ground_slope" => vec![slope("roll", 1e-4), slope("pitch", 1e-4)],
        "backlash" => vec![unit("gap")],
        "series_elasticity" => vec![unit("stiffness")],
        "coupling" => vec![
            unit("inertia"),
            unit("damping"),
            vec![(1.0, vec![("coulomb", 1.0), ("differential", setting)])],
            unit("stiffness"),
        ],
        "force_sensor_gain" => vec![vec![(1e4, vec![("gain", 1.0001)])]],
        "force_sensor_bias" => vec![unit("x"), unit("y"), unit("z")],
        "impact_restitution" => vec![slope("coefficient", 1e-3)],
        // What enters linearly is 1/k and d/k².
        "ground_compliance" => {
            let soil = |damping: f64| vec![("stiffness", 1.0), ("damping", damping)];
            vec![vec![(1.0, soil(0.0))], vec![(1.0, soil(1.0)), (-1.0, soil(0.0))]]
        }
        "payload" => {
            let mass = 1e-3;
            let at = |x: f64, y: f64, z: f64| vec![("mass", mass), ("x", x), ("y", y), ("z", z)];
            let none = at(0.0, 0.0, 0.0);
            let shifted = |p: Parameters| vec![(1e6, p), (-1e6, none.clone())];
            vec![
                vec![(1.0 / mass, none.clone())],
                // Shifts of a millimetre: what enters linearly is mass times position.
                shifted(at(1e-3, 0.0, 0.0)),
                shifted(at(0.0, 1e-3, 0.0)),
                shifted(at(0.0, 0.0, 1e-3)),
            ]
        }
        "com_offset" => vec![slope("x", 1e-4), slope("y", 1e-4), slope("z", 1e-4)],
        _ => return None,
    })
}

/// Parameters from linear coefficients.
pub(crate) fn recover(kind: &str, setting: f64, c: &[f64]) -> Parameters {
    match (kind, c) {
        ("viscous_friction", [c]) => vec![("damping", *c)],
        ("coulomb_friction", [c]) => vec![("torque", *c)],
        ("asymmetric_coulomb_friction", [p, n]) => vec![("positive", *p), ("negative", *n)],
        ("stribeck_friction", [coulomb, rest]) => {
            vec![("coulomb", *coulomb), ("static", *rest), ("stribeck_velocity", setting)]
        }
        ("load_dependent_friction", [c]) => vec![("coefficient", *c)],
        ("rotor_inertia", [c]) => vec![("inertia", *c)],
        // The second column is the torque of stiffness 1 per rad of rest angle, with its sign turned.
        ("parallel_spring", [k, m]) => vec![("stiffness", *k), ("rest_angle", -m / k)],
        ("torque_gain", [c]) => vec![("gain", 1.0 / (1.0 + c))],
        ("torque_bias", [c]) => vec![("bias", *c)],
        ("torque_ripple", [s, c]) => {
            vec![("amplitude", s.hypot(*c)), ("periods_per_turn", setting), ("phase", c.atan2(*s))]
        }
        ("actuator_delay", [c]) => vec![("delay", *c)],
        ("torque_saturation" | "force_sensor_saturation", [_]) => vec![("limit", setting)],
        ("foot_slip", [_]) => vec![("friction", setting)],
        ("spin_friction", [_]) => vec![("radius", setting)],
        ("encoder_offset", [c]) => vec![("offset", *c)],
        ("gravity_tilt" | "ground_slope", [r, p]) => vec![("roll", *r), ("pitch", *p)],
        ("backlash", [c]) => vec![("gap", *c)],
        ("series_elasticity", [c]) => vec![("stiffness", 1.0 / c)],
        ("coupling", [i, d, c, k]) => {
            let mut all = vec![("inertia", *i), ("damping", *d), ("coulomb", *c), ("stiffness", *k)];
            if setting != 0.0 {
                all.push(("differential", setting));
            }
            all
        }
        ("force_sensor_gain", [c]) => vec![("gain", 1.0 + c)],
        ("force_sensor_bias" | "com_offset", [x, y, z]) => vec![("x", *x), ("y", *y), ("z", *z)],
        ("impact_restitution", [c]) => vec![("coefficient", *c)],
        ("ground_compliance", [c, d]) => vec![("stiffness", 1.0 / c), ("damping", d / (c * c))],
        ("payload", [m]) => vec![("mass", *m)],
        ("payload", [m, x, y, z]) => vec![("mass", *m), ("x", x / m), ("y", y / m), ("z", z / m)],
        ("inertia_error", [xx, xy, xz, yy, yz, zz]) => {
            vec![("ixx", *xx), ("ixy", *xy), ("ixz", *xz), ("iyy", *yy), ("iyz", *yz), ("izz", *zz)]
        }
        _ => Vec::new(),
    }
}

/// A little beyond what is usual may be true, and is flagged then; far beyond it is another cause.
pub(crate) fn within_reach((low, high): (f64, f64), value: f64) -> bool {
    let slack = 0.2 * (high - low);
    let least = if low > 0.0 { 0.8 * low } else { low - slack };
    (least..=high + slack).contains(&value)
}

/// What a kind at a place adds to the rows, per coefficient that enters linearly, with its other parameter at
/// `setting`; `None` for kinds that are not searched for.
pub(crate) fn effect_columns(
    experiment: &dyn Experiment,
    kind: &'static str,
    location: &Location,
    setting: f64,
) -> Option<Vec<Column>> {
    let form = Form::new(experiment, kind, location, setting)?;
    let Search::Inertial(directions) = &form.search else { return Some(form.columns(experiment)) };
    let rows = 0..experiment.rows().len();
    let inertial: Vec<_> = rows.filter_map(|row| Some((row, experiment.inertial(row)?))).collect();
    let along = |direction: &Vec<f64>| {
        let of_row = |(row, inertial): &(usize, &Inertial)| {
            let change: Vec<f64> = inertial.columns.iter().map(|column| direction[*column]).collect();
            let samples = inertial.values.chunks_exact(change.len().max(1));
            (*row, samples.map(|y| y.iter().zip(&change).map(|(y, c)| y * c).sum()).collect())
        };
        inertial.iter().filter(|(_, inertial)| !inertial.columns.is_empty()).map(of_row).collect()
    };
    Some(directions.iter().map(along).collect())
}

impl Form {
    /// All forms of a candidate: one per seed of its nonlinear parameter.
    pub fn all(experiment: &dyn Experiment, kind: &'static str, location: &Location) -> Vec<Self> {
        settings(kind).iter().filter_map(|setting| Self::new(experiment, kind, location, *setting)).collect()
    }

    /// The form with this value of the nonlinear parameter.
    pub fn new(
        experiment: &dyn Experiment,
        kind: &'static str,
        location: &Location,
        setting: f64,
    ) -> Option<Self> {
        let search = match Self::inertial(experiment, kind, location) {
            Some(directions) => Search::Inertial(directions),
            None => Search::Probes(probes(kind, setting)?),
        };
        Some(Self { kind, location: location.clone(), setting, search, fixed: Vec::new() })
    }

    /// A payload at the origin of its link, of which only the mass is searched for: what a scale would show.
    pub fn mass_only(experiment: &dyn Experiment, location: &Location) -> Option<Self> {
        let fixed = vec![("x", 0.0), ("y", 0.0), ("z", 0.0)];
        let parameters = [&[("mass", 1.0)], fixed.as_slice()].concat();
        let direction = experiment.inertial_change(&Effect::new("payload", location.clone(), &parameters));
        let search = Search::Inertial(vec![direction]);
        let of_link = location.link.is_some() && experiment.inertial_count() > 0;
        of_link.then(|| Self { kind: "payload", location: location.clone(), setting: 0.0, search, fixed })
    }

    /// Effects on links change inertial parameters, where these are columns already.
    fn inertial(
        experiment: &dyn Experiment,
        kind: &'static str,
        location: &Location,
    ) -> Option<Vec<Vec<f64>>> {
        location.link.as_ref()?;
        if experiment.inertial_count() == 0 {
            return None;
        }
        let change = |parameters: &[(&str, f64)]| {
            experiment.inertial_change(&Effect::new(kind, location.clone(), parameters))
        };
        let difference = |a: Vec<f64>, b: &[f64], factor: f64| -> Vec<f64> {
            a.iter().zip(b).map(|(a, b)| factor * (a - b)).collect()
        };
        Some(match kind {
            "payload" => {
                let still = change(&[("mass", 1.0)]);
                // Central differences: the quadratic part (mass times squared distance) is left to refinement.
                let moment = |axis: &'static str| {
                    let (far, near) =
                        (change(&[("mass", 1.0), (axis, 0.5)]), change(&[("mass", 1.0), (axis, -0.5)]));
                    difference(far, &near, 1.0)
                };
                vec![still, moment("x"), moment("y"), moment("z")]
            }
            "com_offset" => ["x", "y", "z"]
                .map(|axis| difference(change(&[(axis, 5e-4)]), &change(&[(axis, -5e-4)]), 1e3))
                .to_vec(),
            "inertia_error" => {
                ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|name| change(&[(name, 1.0)])).to_vec()
            }
            _ => return None,
        })
    }

    /// The same form with its directions taken at an estimate, where the kind is not linear: second moments of a
    /// payload grow with the square of its distance. They are homogeneous in mass and first moment, so that
    /// directions times coefficients are the exact change at the estimate itself.
    pub fn linearised(&self, experiment: &dyn Experiment, coefficients: &[f64]) -> Option<Self> {
        let (Search::Inertial(_), "payload", [mass, moments @ ..]) = (&self.search, self.kind, coefficients)
        else {
            return None;
        };
        if *mass < 1e-4 || moments.len() != 3 {
            return None;
        }
        let change = |mass: f64, moments: &[f64]| {
            let at = |k: usize| moments[k] / mass;
            let parameters = [("mass", mass), ("x", at(0)), ("y", at(1)), ("z", at(2))];
            experiment.inertial_change(&Effect::new(self.kind, self.location.clone(), &parameters))
        };
        let slope = |far: Vec<f64>, near: Vec<f64>, step: f64| -> Vec<f64> {
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
        probes.iter().map(|probe| self.column(experiment, probe)).collect()
    }

    fn column(&self, experiment: &dyn Experiment, probe: &Probe) -> Column {
        let mut sum: Column = Vec::new();
        for (factor, parameters) in probe {
            let effect = Effect::new(self.kind, self.location.clone(), parameters);
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

    /// Number of linear coefficients.
    pub fn width(&self) -> usize {
        match &self.search {
            Search::Probes(probes) => probes.len(),
            Search::Inertial(directions) => directions.len(),
        }
    }

    /// Number of parameters that the data decide.
    pub fn parameters(&self) -> usize {
        bipedc_effects::effect::kind(self.kind)
            .map_or(self.width(), |kind| kind.estimated().count().saturating_sub(self.fixed.len()))
    }

    /// The effect with these linear coefficients.
    pub fn effect(&self, coefficients: &[f64]) -> Effect {
        let found = [recover(self.kind, self.setting, coefficients), self.fixed.clone()].concat();
        Effect::new(self.kind, self.location.clone(), &found)
    }

    /// Whether the coefficients make a physically possible effect; else which parameter is impossible.
    pub fn impossible(&self, coefficients: &[f64]) -> Option<String> {
        // The excess over the limit counts once: a factor far from one is another effect.
        if (self.kind.ends_with("_saturation") || matches!(self.kind, "foot_slip" | "spin_friction"))
            && !(0.8..1.25).contains(&coefficients[0])
        {
            return Some("what lies beyond the limit does not fit".to_owned());
        }
        // No sensor's gain is known better than this.
        if let ("torque_gain" | "force_sensor_gain", [c]) = (self.kind, coefficients)
            && c.abs() < SAME_GAIN
        {
            return Some(format!(
                "a gain that differs by {:.2} % is the sensor's tolerance",
                100.0 * c.abs()
            ));
        }
        // A slope over so much delay says nothing of a much smaller or larger one.
        if self.kind == "actuator_delay" && !(0.3..3.0).contains(&(coefficients[0] / self.setting)) {
            return Some(format!("its delay would be {:.3e} s, another than was tried", coefficients[0]));
        }
        if let ("stribeck_friction", [coulomb, rest]) = (self.kind, coefficients)
            && rest < coulomb
        {
            return Some("friction would be smaller at rest than at speed".to_owned());
        }
        let kind = bipedc_effects::effect::kind(self.kind)?;
        recover(self.kind, self.setting, coefficients).iter().find_map(|(name, value)| {
            let parameter = kind.parameter(name)?;
            let possible = parameter.bounds.0 <= *value && *value <= parameter.bounds.1;
            let usual = within_reach(parameter.plausible, *value);
            (!(possible && usual)).then(|| format!("its {name} would be {value:.3e} {}", parameter.unit))
        })
    }
}
