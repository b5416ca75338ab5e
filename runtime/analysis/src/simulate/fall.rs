//! Whether a robot fell.
use super::mechanics::{Mechanics, rotate};
use super::plant::Plant;
use super::stepper::{MotionState, Stepper};
use crate::robot::BaseKind;
use serde::Serialize;

/// A base below this part of its height at the start is a fall.
const LOW: f64 = 0.5;
/// As is one that leans more than this, rad.
const LEANING: f64 = 1.0;

/// That a robot fell: the first sign of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Fall {
    /// s
    pub time: f64,
    /// What was seen.
    pub cause: FallCause,
    /// The link that touched the ground.
    pub link: Option<String>,
}

/// What tells a fall.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum FallCause {
    /// A link that is no foot touched the ground.
    Touch,
    /// The root link came below half its height above the soles.
    Height,
    /// The root link leaned by more than 1 rad.
    Lean,
}

impl Fall {
    /// Such as "`torso` touched the ground".
    pub fn words(&self) -> String {
        match (self.cause, &self.link) {
            (FallCause::Touch, Some(link)) => format!("`{link}` touched the ground"),
            (FallCause::Touch, None) => "a link that is no foot touched the ground".to_owned(),
            (FallCause::Height, _) => {
                "the root link came below half its height above the ground at the start".to_owned()
            }
            (FallCause::Lean, _) => "the root link leaned by more than 1 rad".to_owned(),
        }
    }
}

/// Looks at every step until the robot falls.
#[derive(Debug, Clone, Default)]
pub(super) struct FallWatch {
    base: Option<BaseKind>,
    /// Of the root link's origin above the lowest contact point of the feet at the start, m; 0: not looked at.
    height: f64,
    leans: bool,
    /// Contact points of the feet, which come first.
    feet: usize,
    pub fall: Option<Fall>,
}

impl FallWatch {
    /// From the state at the start.
    pub fn new(mechanics: &Mechanics<'_>, plant: &Plant, motion: &MotionState) -> Self {
        let base = plant.layout.base;
        let feet = plant.points_of_feet();
        if !matches!(base, BaseKind::Floating | BaseKind::Planar) || mechanics.points() == 0 {
            return Self::default();
        }
        let mut gaps = vec![0.0; mechanics.points()];
        mechanics.distances(&motion.q, &mut gaps);
        let lowest = gaps.iter().take(feet).copied().fold(f64::INFINITY, f64::min);
        let height = height(base, &motion.q) - lowest;
        // A robot that lies at the start does not fall.
        let leans = lean(base, &motion.q) < LEANING;
        let height = if leans && height.is_finite() { height.max(0.0) } else { 0.0 };
        Self { base: Some(base), height, leans, feet, fall: None }
    }

    /// Looks at the state after a step.
    pub fn see(&mut self, plant: &Plant, motion: &MotionState, stepper: &Stepper<'_>) {
        let Some(base) = self.base.filter(|_| self.fall.is_none()) else { return };
        let touching = (self.feet..stepper.gaps().len()).find(|point| stepper.touches(*point));
        let cause = if touching.is_some() {
            FallCause::Touch
        } else if self.leans && lean(base, &motion.q) > LEANING {
            FallCause::Lean
        } else if self.leans && height(base, &motion.q) < LOW * self.height {
            FallCause::Height
        } else {
            return;
        };
        let link = touching.map(|point| plant.point_name(point));
        let link = link.and_then(|name| Some(name.split_once('/')?.0.to_owned()));
        self.fall = Some(Fall { time: motion.time, cause, link });
    }
}

/// Of the root link's origin above the ground, m.
fn height(base: BaseKind, q: &[f64]) -> f64 {
    q[if base == BaseKind::Planar { 1 } else { 2 }]
}

/// Angle between the root link's z axis and the vertical, rad.
fn lean(base: BaseKind, q: &[f64]) -> f64 {
    if base == BaseKind::Planar {
        return q[2].cos().clamp(-1.0, 1.0).acos();
    }
    let [_, _, up] = rotate([q[3], q[4], q[5], q[6]], [0.0, 0.0, 1.0]);
    up.clamp(-1.0, 1.0).acos()
}
