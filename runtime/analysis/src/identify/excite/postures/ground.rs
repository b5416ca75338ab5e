//! Conditions of a standing robot, as slack that must stay positive, with derivatives.
use super::standing::{Bodies, StanceModel};
use crate::polygon::{Polygon, left_of};
use crate::robot::InertialParameters;
use bipedc_effects::random::Random;

/// How wrong the assumed parameters may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tolerance {
    /// Part of each body's mass.
    pub mass: f64,
    /// Of each coordinate of a body's centre of mass, m.
    pub center: f64,
    /// Number of robots so perturbed whose centre of pressure must stay inside too.
    pub draws: usize,
}

/// What must be kept.
#[derive(Debug, Clone)]
pub struct Conditions {
    /// Smallest and largest position of each joint, margins taken off.
    pub limits: Vec<(f64, f64)>,
    /// Distance of the expected centre of pressure from the support's edge, m.
    pub stability: f64,
    /// Distance between the soles, m.
    pub gap: f64,
    /// Parameters of robots that are a little different; their centre of pressure must be inside, without a margin.
    pub others: Vec<InertialParameters>,
}

/// What a slack changes with.
#[derive(Debug, Clone, Default)]
pub struct Slope {
    /// By the placement: x, y, yaw.
    pub placement: [f64; 3],
    /// By the joints.
    pub joints: Vec<f64>,
}

/// Slacks are in parts of this length (m) where they are lengths.
const LENGTH: f64 = 0.1;

/// Parameters of robots as different from the described one as the tolerance says.
pub fn perturbed(parameters: &[f64], tolerance: &Tolerance, random: &mut Random) -> Vec<InertialParameters> {
    let body = |own: &[f64], random: &mut Random| {
        let mut own = own.to_vec();
        let heavier = 1.0 + tolerance.mass * random.symmetric();
        own.iter_mut().for_each(|x| *x *= heavier);
        let moved = own[0] * tolerance.center;
        own[1..4].iter_mut().for_each(|x| *x += moved * random.symmetric());
        own
    };
    (0..tolerance.draws)
        .map(|_| {
            parameters.chunks_exact(InertialParameters::PER_BODY).flat_map(|own| body(own, random)).collect()
        })
        .collect()
}

impl Conditions {
    /// Slack of the placement itself, in parts of [`LENGTH`], with its derivative.
    pub fn placement(&self, standing: &StanceModel<'_>, placement: &[f64; 3]) -> (f64, Slope) {
        let corners = standing.corners(placement);
        let Some(gap) = Polygon::hull(&corners[0]).apart(&Polygon::hull(&corners[1])) else {
            return (f64::NEG_INFINITY, Slope::default());
        };
        let (own, other) = if gap.of_first { (0, 1) } else { (1, 0) };
        let [a, b] = gap.edge.map(|k| corners[own][k]);
        let (left, slopes) = left_of(a, b, corners[other][gap.nearest]);
        let mut slope = Slope::default();
        let feet = [own, own, other];
        let points = [a, b, corners[other][gap.nearest]];
        for ((foot, point), by) in feet.into_iter().zip(points).zip(slopes) {
            if foot == 1 {
                add(&mut slope.placement, placement, point, by, -1.0 / LENGTH);
            }
        }
        ((-left - self.gap) / LENGTH, slope)
    }

    /// Visits every slack of a posture with its derivative; stops where `visit` says so.
    pub fn posture(
        &self,
        standing: &StanceModel<'_>,
        (bodies, q): (&Bodies, &[f64]),
        placement: &[f64; 3],
        visit: &mut dyn FnMut(f64, &Slope) -> bool,
    ) -> bool {
        let mut slope = Slope { placement: [0.0; 3], joints: vec![0.0; q.len()] };
        for (joint, (low, high)) in self.limits.iter().enumerate() {
            let room = high - low;
            for (slack, direction) in [(q[joint] - low, 1.0), (high - q[joint], -1.0)] {
                slope.joints[joint] = direction / room;
                if !visit(slack / room, &slope) {
                    return false;
                }
                slope.joints[joint] = 0.0;
            }
        }
        let corners = standing.corners(placement).concat();
        let first = standing.parts.soles[0].corners.len();
        let support = Polygon::hull(&corners);
        let robots = std::iter::once((&standing.parts.parameters, self.stability));
        for (parameters, margin) in robots.chain(self.others.iter().map(|p| (p, 0.0))) {
            let (center, rates) = standing.center(bodies, parameters);
            for [a, b] in support.edges() {
                let points = [support.corners[a], support.corners[b]];
                let (left, slopes) = left_of(points[0], points[1], [center.x, center.y]);
                for (slope, rate) in slope.joints.iter_mut().zip(&rates) {
                    *slope = (slopes[2][0] * rate.x + slopes[2][1] * rate.y) / LENGTH;
                }
                slope.placement = [0.0; 3];
                for ((corner, point), by) in [a, b].into_iter().zip(points).zip(slopes) {
                    if support.sources[corner] >= first {
                        add(&mut slope.placement, placement, point, by, 1.0 / LENGTH);
                    }
                }
                if !visit((left - margin) / LENGTH, &slope) {
                    return false;
                }
            }
        }
        true
    }

    /// Whether everything is kept.
    pub fn kept(&self, standing: &StanceModel<'_>, q: &[f64], placement: &[f64; 3]) -> bool {
        let bodies = standing.bodies(q);
        self.placement(standing, placement).0 > 0.0
            && self.posture(standing, (&bodies, q), placement, &mut |slack, _| slack > 0.0)
    }
}

/// How a corner of the placed sole moves with the placement.
fn add(slope: &mut [f64; 3], placement: &[f64; 3], corner: [f64; 2], by: [f64; 2], factor: f64) {
    slope[0] += factor * by[0];
    slope[1] += factor * by[1];
    slope[2] += factor * (by[1] * (corner[0] - placement[0]) - by[0] * (corner[1] - placement[1]));
}
