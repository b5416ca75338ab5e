//! Links besides the feet that touch the ground, where a scenario says so.
use crate::film::touching_points;
use bipedc_analysis::robot::Foot;
use bipedc_analysis::simulate::Shapes;
use bipedc_compiler::compile::identifier;
use bipedc_compiler::description::model::{ContactPoint, Foot as DescribedFoot};
use bipedc_compiler::robot::Robot;
use bipedc_effects::diagnostic::Diagnostic;

/// The same robot with contact points on these links, after those of its feet, and what they are called.
///
/// # Errors
/// A link that is a foot, or has no shape.
pub(super) fn touching(robot: &Robot, shapes: &Shapes) -> Result<(Robot, Vec<Foot>), Diagnostic> {
    let is_foot = |link: &str| robot.description.feet.iter().any(|foot| foot.link == link);
    let all = touching_points(robot);
    let wrong = |message: String, help: &str| {
        let (line, column) = shapes.position;
        Diagnostic::error(message).at(line, column).help(help)
    };
    for link in shapes.links.iter().flatten() {
        if is_foot(link) {
            let help = "leave it out: [[foot]] of biped.toml says where it touches the ground";
            return Err(wrong(format!("`{link}` is a foot"), help));
        }
        if !all.iter().any(|(name, points)| name == link && !points.is_empty()) {
            let help = "give it a <collision> or <visual> of the URDF: box, cylinder, sphere, capsule or a mesh that is found";
            return Err(wrong(format!("`{link}` has no shape"), help));
        }
    }
    let wanted = |link: &String| match &shapes.links {
        Some(links) => links.contains(link),
        None => !is_foot(link),
    };
    let (mut robot, mut links) = (robot.clone(), Vec::new());
    for (link, points) in all.into_iter().filter(|(link, _)| wanted(link)) {
        let point = |(k, position)| ContactPoint { name: format!("shape_{}", k + 1), position };
        let corners: Vec<ContactPoint> = points.into_iter().enumerate().map(point).collect();
        // A foot of another link may be called like this one.
        let taken = robot.description.feet.iter().any(|foot| foot.name == link);
        let name = if taken { format!("{link} (shape)") } else { link.clone() };
        links.push(Foot {
            name: name.clone(),
            frame: identifier(&link),
            side: None,
            corners: corners.clone(),
        });
        let edges = Vec::new();
        robot.description.feet.push(DescribedFoot { name, link, side: None, points: corners, edges });
    }
    if links.is_empty() {
        let help = "give links a <collision> or <visual> of the URDF, or leave `shapes` out";
        return Err(wrong("no link but the feet has a shape".to_owned(), help));
    }
    Ok((robot, links))
}
