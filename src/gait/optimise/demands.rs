//! What is asked of a gait beside its mechanics.

/// Speed, margins and fineness.
#[derive(Debug, Clone, PartialEq)]
pub struct Demands {
    /// Mean walking speed, m/s.
    pub speed: f64,
    /// Coulomb's coefficient that forces and impulses stay below.
    pub friction: f64,
    /// Smallest vertical force on a foot that holds, N.
    pub push: f64,
    /// Distance of the centre of pressure from the ends of a sole, m.
    pub zmp: f64,
    /// Height of feet in the air, m.
    pub clearance: f64,
    /// Part of the torque limits of the URDF that is used.
    pub effort: f64,
    /// Distance from the limits of joints, rad or m.
    pub joint: f64,
    /// Smallest vertical impulse on each foot that an impact holds, N s.
    pub impulse: f64,
    /// Smallest upward velocity of a point that an impact lets go, m/s.
    pub lift_off: f64,
    /// Slowest and fastest vertical landing of a point, m/s.
    pub landing: [f64; 2],
    /// Longest step, as a part of the base's height.
    pub longest_step: f64,
    /// Intervals of a step; each phase has as many of them as it takes of the first guess, at least 6.
    pub intervals: usize,
}

impl Demands {
    /// At a speed, everything else as usual.
    pub fn new(speed: f64) -> Self {
        Self {
            speed,
            friction: 0.5,
            push: 5.0,
            zmp: 0.012,
            clearance: 0.012,
            effort: 0.9,
            joint: 0.02,
            impulse: 0.15,
            lift_off: 0.05,
            landing: [0.2, 1.0],
            longest_step: 0.75,
            intervals: 24,
        }
    }
}
