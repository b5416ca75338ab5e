//! What the ground's forces say beside the parameters: mass, centre of pressure, causes alike.
use crate::measurements::Measured;
use crate::table::table;
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::identify::cop::{Confounded, PressureErrors};
use bipedc_analysis::identify::physical::Inertia;
use bipedc_analysis::identify::{BaseSet, Identification};
use bipedc_analysis::robot::InertialParameters;
use bipedc_analysis::robot::LinkInertias;
use serde::Serialize;
use std::fmt::Write as _;

/// What the ground's forces tell of the robot as a whole.
#[derive(Debug, Clone, Serialize)]
pub struct Ground {
    /// Foot whose sole frame everything is stated in; absent where the base was logged.
    pub stance: Option<String>,
    /// Of the whole robot.
    pub mass: Mass,
    /// Of the whole robot, in the frame of its root, m.
    pub center_of_mass: Center,
    /// How far centres of pressure are missed, by model; static postures only.
    pub models: Vec<ModelErrors>,
    /// First moments divided by the mass; static postures only.
    pub in_metres: Vec<InMetres>,
    /// What these forces cannot tell apart.
    pub confounded: Confounded,
}

/// Total mass, kg.
#[derive(Debug, Clone, Serialize)]
pub struct Mass {
    /// As estimated or given.
    pub value: f64,
    /// If it was estimated.
    pub standard_error: Option<f64>,
    /// By the description.
    pub described: f64,
    /// Where it comes from, in words.
    pub source: &'static str,
}

/// Centre of mass at the mean of the joint positions.
#[derive(Debug, Clone, Serialize)]
pub struct Center {
    /// By the description.
    pub described: [f64; 3],
    /// Of the physically possible parameters.
    pub estimate: [f64; 3],
}

/// How far one model misses centres of pressure.
#[derive(Debug, Clone, Serialize)]
pub struct ModelErrors {
    /// `description`, `full`, `simplified` or `physical`.
    pub model: &'static str,
    /// How many it has.
    pub parameters: usize,
    /// On the postures that taught.
    pub training: PressureErrors,
    /// On postures that were left out in turn.
    pub held_out: Option<PressureErrors>,
    /// On the table that judges.
    pub validation: Option<PressureErrors>,
}

/// A first moment divided by the robot's mass, m.
#[derive(Debug, Clone, Serialize)]
pub struct InMetres {
    /// Of the sum of parameters.
    pub name: String,
    /// As estimated.
    pub value: f64,
    /// Of the estimate.
    pub standard_error: f64,
    /// By the description.
    pub nominal: f64,
}

/// Ten parameters per body with the links' new inertias.
pub fn parameters(link_inertias: &LinkInertias, links: &[(String, Inertia)]) -> InertialParameters {
    let mut new = link_inertias.clone();
    for link in &mut new.links {
        if let Some((_, inertia)) = links.iter().find(|(name, _)| *name == link.name) {
            link.mass = inertia.mass;
            link.center = inertia.center.into();
            link.inertia = std::array::from_fn(|i| std::array::from_fn(|j| inertia.inertia[(i, j)]));
        }
    }
    new.parameters()
}

/// Values of all base parameters: estimates where the data tell them, else the description's.
pub fn values(base: &BaseSet, found: &Identification, nominal: &[f64]) -> Vec<f64> {
    let nominal = base.values(nominal);
    let estimate = |name: &String| found.parameters.iter().find(|p| p.name == *name).map(|p| p.value);
    base.names.iter().zip(nominal).map(|(name, nominal)| estimate(name).unwrap_or(nominal)).collect()
}

impl Center {
    /// At the mean joint positions.
    pub fn new(measured: &Measured, joints: &[f64], described: &[f64], estimate: &[f64]) -> Self {
        let at = |parameters: &[f64]| measured.center(joints, parameters);
        Self { described: at(described), estimate: at(estimate) }
    }
}

/// Mean positions of the joints over the samples of an experiment.
pub fn mean_joints(experiment: &dyn Experiment, joints: usize) -> Vec<f64> {
    let motion = experiment.motion();
    let mean = |values: &Vec<f64>| values.iter().sum::<f64>() / values.len().max(1) as f64;
    let mut all: Vec<f64> = motion.positions.iter().map(mean).collect();
    all.resize(joints, 0.0);
    all
}

impl Ground {
    /// Words and tables.
    pub(super) fn text(&self) -> String {
        let ground = self;
        let mut out = String::new();
        let mass = &ground.mass;
        let error = mass.standard_error.map_or_else(String::new, |e| format!(" ± {e:.4}"));
        let _ = writeln!(
            out,
            "\nmass {:.4}{error} kg ({}); described {:.4} kg",
            mass.value, mass.source, mass.described
        );
        let [a, b] = [&ground.center_of_mass.estimate, &ground.center_of_mass.described]
            .map(|c| c.map(|x| format!("{x:.4}")).join(", "));
        let _ = writeln!(
            out,
            "centre of mass at the mean of the joint positions, root's frame: ({a}) m; described ({b}) m"
        );
        out.push_str(&ground.errors());
        for cause in &ground.confounded.causes {
            let _ = writeln!(
                out,
                "alone, {} explains {:.0} % of the described model's squared error ({})",
                cause.words(),
                100.0 * cause.explains,
                cause.rows.join(", ")
            );
        }
        let confounded = &ground.confounded;
        let forces_alone = confounded
            .pairs_in_forces
            .iter()
            .filter(|p| confounded.pairs.iter().all(|q| q.causes != p.causes));
        let pairs = confounded.pairs.iter().map(|pair| ("cannot be told apart", pair));
        for (words, pair) in
            pairs.chain(forces_alone.map(|pair| ("forces alone cannot tell apart, moments can", pair)))
        {
            let [a, b] = pair.causes.map(|k| confounded.causes[k].words());
            let _ = writeln!(out, "{words} (likeness {:+.3}): {a}, or {b}", pair.likeness);
        }
        out
    }

    fn errors(&self) -> String {
        if self.models.is_empty() {
            return String::new();
        }
        let figures = |e: &PressureErrors| {
            format!("{:.2} / {:.2} / {:.2}", 1e3 * e.mean, 1e3 * e.standard_deviation, 1e3 * e.max)
        };
        let maybe = |e: &Option<PressureErrors>| e.as_ref().map_or_else(|| "-".to_owned(), figures);
        let rows = self.models.iter().map(|m| {
            vec![
                m.model.to_owned(),
                m.parameters.to_string(),
                figures(&m.training),
                maybe(&m.held_out),
                maybe(&m.validation),
            ]
        });
        let head =
            ["centre of pressure, mm: mean / s.d. / max", "parameters", "training", "held out", "validation"];
        format!("\n{}", table(&head, rows.collect(), 1))
    }
}
