//! Feet as tools that read measurements know them.
use super::identifier;
use crate::description::model::{ContactPoint, RobotDescription, Side};
use bipedc_runtime::diagnose::{Corner, Foot};

/// All feet with their corners, in the order of the description.
pub fn feet(description: &RobotDescription) -> Vec<Foot> {
    let corner = |p: &ContactPoint| Corner { name: p.name.clone(), position: p.position };
    let feet = description.feet.iter();
    feet.map(|foot| Foot {
        name: foot.name.clone(),
        frame: identifier(&foot.link),
        left: foot.side.map(|side| side == Side::Left),
        corners: foot.points.iter().map(corner).collect(),
    })
    .collect()
}
