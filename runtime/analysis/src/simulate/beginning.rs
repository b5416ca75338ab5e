//! How a scenario begins: the robot's first state, and what stands on the ground.
use super::drives::Drives;
use super::ground::{Compliance, Ground};
use super::mechanics::Mechanics;
use super::plant::Plant;
use super::scenario::{Initial, Scenario};
use super::stepper::{MotionState, Stepper};
use super::turned::Turned;
use crate::robot::BaseKind;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Acts, Effect, Law};
use std::ops::Range;

/// Depth by which a contact point may begin below the ground: rounding of what people write, m.
const ROUNDING: f64 = 1e-6;

/// What steps the robot: its ground, soles, motors and coupled drives.
///
/// # Errors
/// Effects that cannot be simulated; a servo inside a drive whose torque is late.
pub(super) fn stepper<'a>(
    (mechanics, plant, scenario): (Mechanics<'a>, &'a Plant, &'a Scenario),
    effects: &[&Effect],
    drives: &Drives,
    motion: &MotionState,
) -> Result<Stepper<'a>, Diagnostic> {
    let laws = drives.laws(plant, scenario.joint_stops);
    let ground = with_effects(scenario.ground, effects);
    let mut stepper = Stepper::new(mechanics, ground, laws, scenario.tolerance)?;
    let flat = points_of_feet(plant).into_iter().filter(|points| points.len() > 2).collect();
    if let Some(turning) = turning(effects).filter(|_| mechanics.tangents() == 2) {
        stepper = stepper.with_soles(flat, turning)?;
    }
    if let Some(heights) = &scenario.heights {
        let planar = plant.layout.base == BaseKind::Planar;
        let start = [motion.q[0], if planar { 0.0 } else { motion.q[1] }];
        stepper = stepper.with_heights(heights.clone(), points_of_feet(plant), start);
    }
    let stepper = stepper.with_coupled(drives.coupled().to_vec())?.with_motors(drives.motors(), motion)?;
    if let Some(late) = (0..mechanics.joints()).find(|j| scenario.inside && drives.is_late(*j)) {
        let name = &plant.layout.joints[late].name;
        return Err(Diagnostic::error(format!(
            "`actuator_delay` at `{name}`: a controller inside the drive is not late"
        ))
        .help("write `servo = \"held\"` under [control]"));
    }
    Ok(stepper)
}

/// The initial state with the height of the base.
pub(super) fn begin(
    mechanics: &Mechanics<'_>,
    plant: &Plant,
    initial: &Initial,
    turned: Turned,
) -> Result<MotionState, Diagnostic> {
    let (mut q, mut v) = (initial.q.clone(), initial.v.clone());
    turned.into_ground(&mut q, &mut v);
    let mut gaps = vec![0.0; mechanics.points()];
    mechanics.distances(&q, &mut gaps);
    let lowest = |gaps: &[f64]| gaps.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1));
    let feet = plant.points_of_feet().min(gaps.len());
    let mut raised = 0.0;
    if let (Some(clearance), Some((_, gap))) = (initial.clearance, lowest(&gaps[..feet])) {
        let height = if plant.layout.base == BaseKind::Planar { 1 } else { 2 };
        raised = clearance - gap;
        q[height] += raised;
    }
    let below = lowest(&gaps).filter(|(_, gap)| gap + raised < -ROUNDING);
    if let Some((point, gap)) = below.filter(|(point, _)| initial.clearance.is_none() || *point >= feet) {
        let message = format!("`{}` begins {:.6} m below the ground", plant.point_name(point), -gap - raised);
        let (line, column) = initial.position;
        let help = if point < feet {
            "raise `base_position`, or write `clearance = 0.0` instead of it"
        } else {
            "list the links that shall touch the ground without this one: shapes = [\"…\"]; or begin higher"
        };
        return Err(Diagnostic::error(message).at(line, column).help(help));
    }
    Ok(MotionState { time: 0.0, q, v })
}

/// Largest moment about the vertical of a flat sole per normal force, m.
fn turning(effects: &[&Effect]) -> Option<f64> {
    let of = |law: Law| effects.iter().rev().find(|effect| effect.kind.law == law).copied();
    let spin = of(Law::SpinFriction)?;
    Some(spin.value("radius") * of(Law::Slip).unwrap_or(spin).value("friction"))
}

/// Contact points of each foot.
fn points_of_feet(plant: &Plant) -> Vec<Range<usize>> {
    let mut first = 0;
    let points = plant.feet.iter().map(|foot| {
        let points = first..first + foot.corners.len();
        first = points.end;
        points
    });
    points.collect()
}

/// The ground as the effects make it.
fn with_effects(mut ground: Ground, effects: &[&Effect]) -> Ground {
    for effect in effects {
        match effect.kind.law {
            Law::GroundCompliance => {
                ground.compliance = Some(Compliance {
                    stiffness: effect.value("stiffness"),
                    damping: effect.value("damping"),
                });
            }
            Law::Restitution => ground.normal_restitution = effect.value("coefficient"),
            Law::Slip => ground.friction = effect.value("friction"),
            // Slopes turn gravity, and turning soles have a law of their own.
            law => debug_assert!(
                law.acts() != Acts::Ground || matches!(law, Law::GroundSlope | Law::SpinFriction)
            ),
        }
    }
    ground
}
