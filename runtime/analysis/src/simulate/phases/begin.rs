//! The state at the beginning of a walk, from what a scenario says of it.
use super::project::Projected;
use super::robot::PhasedRobot;
use crate::robot::BaseKind;
use crate::simulate::plant::Plant;
use crate::simulate::scenario::{Initial, Scenario};
use bipedc_effects::diagnostic::Diagnostic;
use nalgebra::DVector;

/// Rounding of what people write, m and m/s.
const ROUNDING: f64 = 1e-6;

impl PhasedRobot<'_> {
    /// The state at the beginning of a scenario, and how much it was moved so that it stands.
    ///
    /// # Errors
    /// A foot that is not level, or that cannot be at rest.
    pub fn standing(&self, plant: &Plant, scenario: &Scenario) -> Result<(Vec<f64>, Projected), Diagnostic> {
        let given = scenario.events.as_ref().map_or([true; 2], |events| events.given);
        begin(self, plant, &scenario.initial, given, scenario.phase)
    }
}

/// `q` and `v` with the contacts of the phase on the ground and at rest: the base's height and what the scenario does not
/// say of its velocity follow from them. Numbers that miss the contacts by little are moved onto them.
///
/// # Errors
/// A foot that is not level, or that cannot be at rest.
fn begin(
    robot: &PhasedRobot<'_>,
    plant: &Plant,
    initial: &Initial,
    given: [bool; 2],
    phase: usize,
) -> Result<(Vec<f64>, Projected), Diagnostic> {
    let spec = &robot.phases[phase].0;
    let (mut q, mut v) = (initial.q.clone(), initial.v.clone());
    let mut heights = robot.heights(&q);
    let lowest =
        |heights: &[f64]| spec.standing.iter().map(|&point| heights[point]).fold(f64::INFINITY, f64::min);
    if initial.clearance.is_some() && !spec.standing.is_empty() {
        let height = if robot.base == BaseKind::Planar { 1 } else { 2 };
        q[height] -= lowest(&heights);
    }
    let position = robot.project_position(&spec.standing, &mut q);
    heights.copy_from_slice(&robot.heights(&q));
    let (line, column) = initial.position;
    for &point in &spec.standing {
        if heights[point].abs() > ROUNDING {
            let name = plant.point_name(point);
            let message =
                format!("`{name}` stands in phase `{}`, but begins {:.6} m high", spec.name, heights[point]);
            return Err(Diagnostic::error(message).at(line, column).help(
                "level the foot by `base_rotation` and the joints' positions; leave `base_position` out to stand",
            ));
        }
    }
    rest(robot, &spec.standing, &q, &mut v, given);
    let velocity = robot.project_velocity(&spec.standing, &q, &mut v);
    let speed = fastest(robot, &spec.standing, &q, &v);
    if speed > ROUNDING {
        let message = format!("a contact of phase `{}` begins with {speed:.6} m/s", spec.name);
        let help = "leave `base_velocity` and, with flat feet, `base_angular_velocity` out: they follow from the joints'";
        return Err(Diagnostic::error(message).at(line, column).help(help));
    }
    q.extend(v);
    Ok((q, Projected { position, velocity }))
}

/// Chooses the velocities of the base that were not given so that the standing points rest.
fn rest(robot: &PhasedRobot<'_>, standing: &[usize], q: &[f64], v: &mut [f64], given: [bool; 2]) {
    let linear = if robot.base == BaseKind::Planar { 2 } else { 3 };
    let base = v.len() - robot.model.joints();
    let mut free: Vec<usize> = Vec::new();
    if !given[0] {
        free.extend(0..linear);
    }
    // About a single point the robot may turn: then it does as the scenario says, or not at all.
    if !given[1] && standing.len() > 1 {
        free.extend(linear..base);
    }
    if free.is_empty() || standing.is_empty() {
        return;
    }
    free.iter().for_each(|&i| v[i] = 0.0);
    let rows = robot.directions(q, standing);
    let moving = &rows * DVector::from_column_slice(v);
    let svd = rows.select_columns(&free).svd(true, true);
    let least = 1e-9 * svd.singular_values.amax();
    if let Ok(found) = svd.solve(&-moving, least) {
        free.iter().zip(found.iter()).for_each(|(&i, x)| v[i] = *x);
    }
}

/// Largest component of the velocities of some points, m/s.
fn fastest(robot: &PhasedRobot<'_>, standing: &[usize], q: &[f64], v: &[f64]) -> f64 {
    if standing.is_empty() {
        0.0
    } else {
        (robot.directions(q, standing) * DVector::from_column_slice(v)).amax()
    }
}
