//! Feasible postures to start from (thesis 5.4.1, steps 1 to 5).
use super::ground::Conditions;
use super::standing::{StanceModel, rotation_vector};
use super::surface::closed;
use crate::polygon::Polygon;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::random::Random;
use nalgebra::{DMatrix, DVector, Rotation3, Vector3};

/// Attempts per posture before another placement is tried, and placements per wanted one.
const ATTEMPTS: usize = 60;
const PLACEMENTS: usize = 400;
/// Newton steps of the inverse kinematics.
const STEPS: usize = 40;
/// Placements reach this far, in parts of the height of the centre of mass: forth and back, to the side.
const REACH: [f64; 2] = [0.3, 0.35];
/// Largest angle between the soles, rad.
const YAW: f64 = 0.5;
/// Angles of the torso, rad: roll, pitch, yaw.
const LEAN: [f64; 3] = [0.35, 0.5, 0.35];
/// Height of the centre of mass in parts of that with all joints at zero.
const HEIGHTS: (f64, f64) = (0.7, 0.99);

/// A foot placement with its postures.
pub type Placed = ([f64; 3], Vec<Vec<f64>>);

/// So many postures on so many placements, all of which keep the conditions.
///
/// # Errors
/// None was found within the attempts: limits, margins or feet leave no room.
pub fn feasible(
    standing: &StanceModel<'_>,
    conditions: &Conditions,
    (postures, placements): (usize, usize),
    random: &mut Random,
    stop: &dyn Fn() -> bool,
) -> Result<Vec<Placed>, Diagnostic> {
    let mut found: Vec<Placed> = Vec::new();
    let scene = Scene::new(standing);
    for _ in 0..PLACEMENTS * placements {
        let wanted = postures / placements + usize::from(found.len() < postures % placements);
        let placement = scene.placement(random);
        if conditions.placement(standing, &placement).0 <= 0.0 {
            continue;
        }
        let own = scene.postures(conditions, &placement, wanted, random);
        if own.len() == wanted {
            found.push((placement, own));
        }
        if found.len() == placements {
            return Ok(found);
        }
        if stop() {
            break;
        }
    }
    Err(Diagnostic::error(format!(
        "only {} of {placements} foot placements with {} postures each were found",
        found.len(),
        postures.div_ceil(placements)
    ))
    .help("lower --margin, --stability or --gap, allow smaller errors (--mass-error, --center-error), widen the joints' limits, or ask for fewer postures"))
}

/// What targets are drawn from.
struct Scene<'s, 'm> {
    standing: &'s StanceModel<'m>,
    /// Height of the centre of mass with all joints at zero, m.
    height: f64,
    /// Distance between the soles then, m, signed.
    side: f64,
}

/// Where a posture should be.
struct Target {
    placement: [f64; 3],
    center: Vector3<f64>,
    torso: Rotation3<f64>,
}

impl<'s, 'm> Scene<'s, 'm> {
    fn new(standing: &'s StanceModel<'m>) -> Self {
        let bodies = standing.bodies(&vec![0.0; standing.joints()]);
        let (center, _) = standing.center(&bodies, &standing.parts.parameters);
        let side = bodies.frame(&standing.parts.soles[1].place).0.y;
        Self { standing, height: center.z, side }
    }

    fn placement(&self, random: &mut Random) -> [f64; 3] {
        let outwards = self.side.signum() * REACH[1] * self.height * (0.5 + 0.5 * random.symmetric());
        [REACH[0] * self.height * random.symmetric(), 0.7 * self.side + outwards, YAW * random.symmetric()]
    }

    fn postures(
        &self,
        conditions: &Conditions,
        placement: &[f64; 3],
        wanted: usize,
        random: &mut Random,
    ) -> Vec<Vec<f64>> {
        let mut found: Vec<Vec<f64>> = Vec::new();
        for attempt in 0..ATTEMPTS * wanted {
            // A placement without any posture is given up soon.
            if attempt >= ATTEMPTS && found.is_empty() {
                break;
            }
            let target = self.target(conditions, placement, random);
            let start: Vec<f64> = match found.last() {
                Some(last) => last.clone(),
                None => conditions
                    .limits
                    .iter()
                    .map(|(low, high)| 0.5 * (low + high) + 0.25 * (high - low) * random.symmetric())
                    .collect(),
            };
            let Some(q) = target.and_then(|target| self.reached(&target, start)) else { continue };
            if conditions.kept(self.standing, &q, placement) {
                found.push(q);
            }
            if found.len() == wanted {
                break;
            }
        }
        found
    }

    /// A centre of mass within the support and a torso that leans a little.
    fn target(&self, conditions: &Conditions, placement: &[f64; 3], random: &mut Random) -> Option<Target> {
        let corners = self.standing.corners(placement).concat();
        let weights: Vec<f64> =
            corners.iter().map(|_| -(0.5 + 0.5 * random.symmetric()).max(1e-12).ln()).collect();
        let total: f64 = weights.iter().sum();
        let mean = |axis: usize| corners.iter().zip(&weights).map(|(c, w)| c[axis] * w / total).sum::<f64>();
        let (x, y) = (mean(0), mean(1));
        if Polygon::hull(&corners).inside([x, y]) < conditions.stability {
            return None;
        }
        let part = HEIGHTS.0 + (HEIGHTS.1 - HEIGHTS.0) * (0.5 + 0.5 * random.symmetric());
        let [roll, pitch, yaw] = LEAN.map(|most| most * random.symmetric());
        let torso = Rotation3::from_euler_angles(roll, pitch, 0.5 * placement[2] + yaw);
        Some(Target { placement: *placement, center: Vector3::new(x, y, part * self.height), torso })
    }

    /// Inverse kinematics by damped Newton steps, then exactly onto the surface.
    fn reached(&self, target: &Target, start: Vec<f64>) -> Option<Vec<f64>> {
        let (standing, n) = (self.standing, self.standing.joints());
        let parts = &standing.parts;
        let mut q = start;
        for _ in 0..STEPS {
            let bodies = standing.bodies(&q);
            let (center, rates) = standing.center(&bodies, &parts.parameters);
            let (_, torso) = bodies.frame(&parts.torso);
            let turn = rotation_vector(&(torso * target.torso.matrix().transpose()));
            let missed = standing.missed(&bodies, &target.placement);
            let away = center - target.center;
            let mut right = DVector::zeros(12);
            right.rows_mut(0, 6).copy_from(&missed);
            right.rows_mut(6, 3).copy_from(&away);
            right.rows_mut(9, 3).copy_from(&turn);
            if right.amax() < 1e-6 {
                break;
            }
            let mut jacobian = DMatrix::zeros(12, n);
            jacobian.rows_mut(0, 6).copy_from(&standing.jacobian(&bodies, &parts.soles[1].place));
            for (joint, rate) in rates.iter().enumerate() {
                jacobian.fixed_view_mut::<3, 1>(6, joint).copy_from(rate);
            }
            jacobian.rows_mut(9, 3).copy_from(&standing.jacobian(&bodies, &parts.torso).rows(3, 3));
            let mut square = &jacobian * jacobian.transpose();
            // What cannot be reached, for want of joints, is reached as far as it goes.
            (0..12).for_each(|k| square[(k, k)] += 1e-6);
            let step = jacobian.tr_mul(&square.cholesky()?.solve(&right));
            let scale = (0.3 / step.amax().max(1e-300)).min(1.0);
            q.iter_mut().zip(step.iter()).for_each(|(q, step)| *q -= scale * step);
            if q.iter().any(|q| q.is_nan() || q.abs() >= 10.0) {
                return None;
            }
        }
        closed(standing, &q, &target.placement)
    }
}
