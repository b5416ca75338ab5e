//! Feet as tools that read measurements know them.
use bipedc_analysis::robot::Foot;
use bipedc_compiler::compile::{distinct, identifier};
use bipedc_compiler::description::model::RobotDescription;

/// All feet with their corners, in the order of the description.
pub fn feet(description: &RobotDescription) -> Vec<Foot> {
    let feet = description.feet.iter();
    // As functions about these links are named when they are asked for in this order.
    let mut links: Vec<&str> = Vec::new();
    feet.clone()
        .for_each(|foot| links.extend((!links.contains(&foot.link.as_str())).then_some(foot.link.as_str())));
    let frames = distinct(links.iter().map(|link| identifier(link)));
    let frame = |link: &str| links.iter().position(|other| *other == link).map(|k| frames[k].clone());
    feet.map(|foot| Foot {
        name: foot.name.clone(),
        frame: frame(&foot.link).unwrap_or_default(),
        side: foot.side,
        corners: foot.points.clone(),
    })
    .collect()
}
