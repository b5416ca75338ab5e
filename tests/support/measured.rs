//! Robots with measurements: what the experiments need, from a description.
use super::{project, read_robot};
use bipedc::robot::{feet, joint_layout, link_inertias};
use bipedc_analysis::experiments::Experiment;
use bipedc_analysis::robot::{AnyModel, Foot, JointLayout, LinkInertias, Robot};
use bipedc_compiler::Robot as Described;
use bipedc_effects::effect::Effect;
use std::path::PathBuf;

/// All but the model.
pub struct Subjects {
    pub layout: JointLayout,
    pub link_inertias: LinkInertias,
    pub feet: Vec<Foot>,
}

impl Subjects {
    pub fn of(described: &Described) -> Self {
        let tree = described.tree().unwrap();
        Self {
            layout: joint_layout(&tree).unwrap(),
            link_inertias: link_inertias(&described.description, &tree),
            feet: feet(&described.description),
        }
    }

    pub fn named(name: &str) -> Self {
        Self::of(&read_robot(name))
    }

    pub fn robot<'a>(&'a self, model: AnyModel<'a>, effects: &'a [Effect]) -> Robot<'a> {
        Robot { model, layout: &self.layout, link_inertias: &self.link_inertias, feet: &self.feet, effects }
    }
}

pub fn example(name: &str) -> PathBuf {
    project().join("tests/data/examples").join(name)
}

/// Root mean square over these rows, minus what effects explain.
pub fn rms(experiment: &dyn Experiment, rows: &[usize], effects: &[Effect]) -> f64 {
    let response = experiment.response(effects);
    let (mut sum, mut count) = (0.0, 0);
    for &row in rows {
        let explained = response.iter().find(|(r, _)| *r == row).map(|(_, values)| values);
        for (i, residual) in experiment.residual(row).iter().enumerate() {
            sum += (residual - explained.map_or(0.0, |values| values[i])).powi(2);
            count += 1;
        }
    }
    (sum / f64::from(count)).sqrt()
}

/// Largest difference between the derivative by inertial parameters and a response, relative to the response.
pub fn inertial_error(experiment: &dyn Experiment, effect: &Effect) -> f64 {
    let change = experiment.inertial_change(effect);
    let (mut worst, mut scale) = (0.0_f64, 0.0_f64);
    for (row, response) in experiment.response(std::slice::from_ref(effect)) {
        let inertial = experiment.inertial(row).unwrap();
        let width = inertial.columns.len();
        for (i, response) in response.iter().enumerate() {
            let columns = inertial.columns.iter().zip(&inertial.values[i * width..]);
            let linear: f64 = columns.map(|(k, value)| value * change[*k]).sum();
            worst = worst.max((linear - response).abs());
            scale = scale.max(response.abs());
        }
    }
    worst / scale
}
