//! What a simulation knows of a robot besides its model.
use crate::robot::{Foot, JointLayout};
use bipedc_effects::drive::Drive;
use bipedc_effects::effect::Effect;

/// Names, places and limits of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Plant {
    /// Joints in the order of `v`, and the base before them.
    pub layout: JointLayout,
    /// In the order of the model's contact points.
    pub feet: Vec<Foot>,
    /// Links that touch the ground with their shapes as feet do with their corners: their points come after those of the feet.
    pub shapes: Vec<Foot>,
    /// Names of the links.
    pub links: Vec<String>,
    /// By joint, rad or m; where the URDF states them.
    pub position_limits: Vec<Option<[f64; 2]>>,
    /// By joint, rad/s or m/s.
    pub velocity_limits: Vec<Option<f64>>,
    /// By joint, N m or N.
    pub effort_limits: Vec<Option<f64>>,
    /// Effects of the description: known ones.
    pub effects: Vec<Effect>,
    /// Names of the phases, in their order.
    pub phases: Vec<String>,
    /// Joints with actuators, by index.
    pub actuated: Vec<usize>,
    /// By joint, drives of the description.
    pub drives: Vec<Option<Drive>>,
    /// World axes, m/s².
    pub gravity: [f64; 3],
}

impl Plant {
    /// Index of a joint.
    pub fn joint(&self, name: &str) -> Option<usize> {
        self.layout.joints.iter().position(|joint| joint.name == name)
    }

    /// Names of the joints.
    pub fn joint_names(&self) -> impl Iterator<Item = &str> + Clone {
        self.layout.joints.iter().map(|joint| joint.name.as_str())
    }

    /// Number of contact points that belong to feet: the first ones of the model.
    pub fn points_of_feet(&self) -> usize {
        self.feet.iter().map(|foot| foot.corners.len()).sum()
    }

    /// `foot/corner` of a contact point of the model.
    pub fn point_name(&self, point: usize) -> String {
        let all = self
            .feet
            .iter()
            .chain(&self.shapes)
            .flat_map(|foot| foot.corners.iter().map(move |corner| (foot, corner)));
        let named = all.map(|(foot, corner)| format!("{}/{}", foot.name, corner.name)).nth(point);
        named.unwrap_or_else(|| format!("contact point {point}"))
    }
}
