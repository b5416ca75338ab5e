//! What walks are to keep, as it was asked or follows from the robot's size.
use crate::gait::optimise::{Demands, Wishes, size};
use bipedc_compiler::compile::Collocation;
use bipedc_effects::diagnostic::Diagnostic;
use serde::Serialize;
use std::fmt;

/// What every walk of a search is to keep. As text it is the first line of what `bipedc gait optimise` prints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Wished {
    /// Of the robot, kg.
    pub mass: f64,
    /// Of its base above the ground, joints at ease, m.
    pub height: f64,
    /// Size of gravity, m/s².
    pub gravity: f64,
    /// Coulomb's coefficient that forces and impulses stay below.
    pub friction: f64,
    /// Height of feet in the air, m.
    pub clearance: f64,
    /// Distance of the centre of pressure from the ends of a sole, m.
    pub zmp: f64,
    /// Smallest vertical impulse on each foot that an impact holds, N s.
    pub impulse: f64,
    /// Which of them nobody asked for: they follow from mass and height.
    pub by_size: Vec<&'static str>,
}

impl Wished {
    pub(super) fn new(of: &Collocation, wishes: &Wishes) -> Self {
        let [mass, height, gravity] = size(of);
        let Demands { friction, clearance, zmp, impulse, .. } = wishes.demands(1.0, size(of));
        let said =
            [("clearance", wishes.clearance), ("zmp", wishes.zmp), ("impulse", wishes.impulse)].into_iter();
        let by_size = said.filter(|(_, value)| value.is_none()).map(|(name, _)| name).collect();
        Self { mass, height, gravity, friction, clearance, zmp, impulse, by_size }
    }
}

/// Speeds below which searches take long and often find no walk, over √(g h): of steps of one phase and of several. The seven-link robot walked at 0.077 and
/// was not found at 0.038, the five-link robot walked at 0.0036 and a lizard of 0.26 m missed its speed by a third at 0.006.
const SLOW: [f64; 2] = [0.01, 0.07];
/// A good speed to begin with, the same way.
const USUAL: f64 = 0.2;

impl Wished {
    /// Said of a speed (m/s) that will hardly be walked at.
    pub(super) fn slow(&self, of: &Collocation, speed: f64) -> Option<Diagnostic> {
        let fall = (self.gravity * self.height).sqrt();
        let least = SLOW[usize::from(of.phases.len() > 1)] * fall;
        let message = format!(
            "{speed} m/s is slow for a robot with its base at {:.3} m: below some {least:.3} m/s a search takes long and often finds no walk",
            self.height
        );
        let help = format!(
            "begin near {:.2} m/s, and go down from there by several speeds of one command: each search begins where the one before ended",
            USUAL * fall
        );
        (speed < least).then(|| Diagnostic::warning(message).help(help))
    }
}

impl fmt::Display for Wished {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { mass, height, friction, clearance, zmp, impulse, by_size, .. } = self;
        let size = |name: &str| if by_size.contains(&name) { " *" } else { "" };
        writeln!(
            f,
            "asked of a walk: friction {friction}, clearance {clearance:.4} m{}, zmp {zmp:.4} m{}, impulse {impulse:.4} N s{}",
            size("clearance"),
            size("zmp"),
            size("impulse")
        )?;
        if by_size.is_empty() {
            return Ok(());
        }
        let options: Vec<String> = by_size.iter().map(|name| format!("--{name}")).collect();
        writeln!(
            f,
            "* by the robot's size, {mass:.3} kg and its base {height:.3} m above the ground; {} ask for other values",
            options.join(", ")
        )
    }
}
