//! The robot as amended, for other tools: as a URDF, as MJCF.
mod element;
mod mjcf;

pub use mjcf::{ExportedMjcf, mjcf};

use bipedc_compiler::Robot;
use bipedc_compiler::description::{JointDynamics, rewritten};
use bipedc_compiler::tree::as_built;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Acts, Effect, kinds};

/// A URDF, and what it cannot say.
#[derive(Debug, Clone, PartialEq)]
pub struct Exported {
    /// The robot's own text; only the elements of changed links and joints are others.
    pub urdf: String,
    /// Links with other inertias.
    pub links: Vec<String>,
    /// Joints with other damping or friction.
    pub joints: Vec<String>,
    /// Effects that a URDF has no words for.
    pub left_out: Vec<Effect>,
    /// What `<dynamics>` of the URDF say that the model does not have, and that stands as it stood.
    pub kept: Vec<(String, JointDynamics)>,
}

/// Writes what the description's effects make of bodies into `<inertial>`, viscous and dry friction into `<dynamics>`.
///
/// # Errors
/// A URDF that cannot be changed.
pub fn urdf(robot: &Robot) -> Result<Exported, Diagnostic> {
    let description = &robot.description;
    let built = as_built(description);
    let pairs = built.links.iter().zip(&description.links);
    let other = pairs.filter(|(built, given)| built.inertial != given.inertial);
    let inertials: Vec<_> =
        other.filter_map(|(built, _)| Some((built.name.clone(), built.inertial?))).collect();

    let mut dynamics: Vec<(String, JointDynamics)> = Vec::new();
    let mut left_out = Vec::new();
    for effect in &description.effects {
        if effect.kind.law.acts() == Acts::Body {
            continue;
        }
        let said = (effect.location.joint.as_ref()).zip(stated(effect));
        let Some((joint, values)) = said else {
            left_out.push(effect.clone());
            continue;
        };
        match dynamics.iter_mut().find(|(name, _)| name == joint) {
            Some((_, known)) => {
                known.damping = values.damping.or(known.damping);
                known.friction = values.friction.or(known.friction);
            }
            None => dynamics.push((joint.clone(), values)),
        }
    }
    let urdf = rewritten(&robot.sources.urdf_text, &robot.sources.urdf_path, &inertials, &dynamics)?;
    let links = inertials.into_iter().map(|(name, _)| name).collect();
    let kept = kept(robot, &dynamics);
    let joints = dynamics.into_iter().map(|(name, _)| name).collect();
    Ok(Exported { urdf, links, joints, left_out, kept })
}

/// What the URDF states and no effect replaces.
fn kept(robot: &Robot, replaced: &[(String, JointDynamics)]) -> Vec<(String, JointDynamics)> {
    let of_joint = |(joint, stated, _): (String, JointDynamics, _)| {
        let ours =
            replaced.iter().find(|(name, _)| *name == joint).map_or_else(JointDynamics::default, |r| r.1);
        let left = |stated: Option<f64>, ours: Option<f64>| stated.filter(|x| *x != 0.0 && ours.is_none());
        let damping = left(stated.damping, ours.damping);
        let friction = left(stated.friction, ours.friction);
        (damping.is_some() || friction.is_some()).then_some((joint, JointDynamics { damping, friction }))
    };
    robot.sources.stated_dynamics().into_iter().filter_map(of_joint).collect()
}

/// What `<dynamics>` says of an effect.
fn stated(effect: &Effect) -> Option<JointDynamics> {
    let nothing = JointDynamics::default();
    if effect.kind == &kinds::VISCOUS_FRICTION {
        return Some(JointDynamics { damping: Some(effect.value("damping")), ..nothing });
    }
    (effect.kind == &kinds::COULOMB_FRICTION)
        .then(|| JointDynamics { friction: Some(effect.value("torque")), ..nothing })
}
