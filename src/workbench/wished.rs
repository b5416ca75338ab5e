//! What walks are to keep, as it was asked or follows from the robot's size.
use crate::gait::optimise::{Demands, Wishes, size};
use bipedc_compiler::compile::Collocation;
use serde::Serialize;
use std::fmt;

/// What every walk of a search is to keep. As text it is the first line of what `bipedc gait optimise` prints.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Wished {
    /// Of the robot, kg.
    pub mass: f64,
    /// Of its base above the ground, joints at ease, m.
    pub height: f64,
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
        let [mass, height] = size(of);
        let Demands { friction, clearance, zmp, impulse, .. } = wishes.demands(1.0, [mass, height]);
        let said =
            [("clearance", wishes.clearance), ("zmp", wishes.zmp), ("impulse", wishes.impulse)].into_iter();
        let by_size = said.filter(|(_, value)| value.is_none()).map(|(name, _)| name).collect();
        Self { mass, height, friction, clearance, zmp, impulse, by_size }
    }
}

impl fmt::Display for Wished {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { mass, height, friction, clearance, zmp, impulse, by_size } = self;
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
            "* by the robot's size, {mass:.3} kg and its base {height:.3} m above the ground; {} asks for another value",
            options.join(", ")
        )
    }
}
