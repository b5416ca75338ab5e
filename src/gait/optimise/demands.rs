//! What is asked of a gait beside its mechanics.

/// What a motion is made small in.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Objective {
    /// The mean squared torque.
    #[default]
    Torque,
    /// The mechanical cost of transport: ∫ Σ \|τ q̇\| dt over weight and distance.
    Transport,
}

/// Speed, margins and fineness.
#[derive(Debug, Clone, PartialEq)]
pub struct Demands {
    /// Mean walking speed, m/s.
    pub speed: f64,
    /// Coulomb's coefficient that forces stay below.
    pub friction: f64,
    /// The same of impulses.
    pub impact_friction: f64,
    /// Smallest vertical force on a foot that holds, N.
    pub push: f64,
    /// Distance of the centre of pressure from the ends of a sole, m.
    pub zmp: f64,
    /// Height of feet in the air, m.
    pub clearance: f64,
    /// Part of the torque limits of the URDF that is used.
    pub effort: f64,
    /// Part of the velocity limits of the URDF that is used.
    pub velocity: f64,
    /// Distance from the limits of joints, rad or m.
    pub joint: f64,
    /// Smallest vertical impulse on each foot that an impact holds, N s.
    pub impulse: f64,
    /// Smallest upward velocity of a point that an impact lets go, m/s.
    pub lift_off: f64,
    /// Slowest and fastest vertical landing of a point, m/s.
    pub landing: [f64; 2],
    /// Smallest downward speed of the base just before the legs are exchanged, m/s; 0: it is not asked for.
    pub sinking: f64,
    /// Longest step, as a part of the base's height.
    pub longest_step: f64,
    /// Intervals of a step; each phase has as many of them as it takes of the first guess, at least 10.
    pub intervals: usize,
    /// What is made small.
    pub objective: Objective,
}

impl Demands {
    /// At a speed, everything else as usual for a robot of some 20 kg and 0.7 m.
    pub fn new(speed: f64) -> Self {
        Self {
            speed,
            friction: 0.5,
            impact_friction: 0.5,
            push: 5.0,
            zmp: 0.012,
            clearance: 0.012,
            effort: 0.9,
            velocity: 0.98,
            joint: 0.02,
            impulse: 0.11,
            lift_off: 0.05,
            landing: [0.2, 1.0],
            sinking: 0.0,
            longest_step: 0.75,
            intervals: 24,
            objective: Objective::Torque,
        }
    }

    /// The same for a robot of this mass (kg) with its base at this height (m) under this gravity (m/s²): smaller ones are asked for less.
    pub fn of_size(speed: f64, [mass, height, gravity]: [f64; 3]) -> Self {
        let usual = Self::new(speed);
        let swing = (gravity * height).sqrt();
        Self {
            push: usual.push.min(0.03 * mass * gravity),
            zmp: usual.zmp.min(0.02 * height),
            clearance: usual.clearance.min(0.02 * height),
            impulse: usual.impulse.min(8.8e-4 * mass * swing),
            lift_off: usual.lift_off.min(0.02 * swing),
            landing: [usual.landing[0].min(0.08 * swing), usual.landing[1].max(0.4 * swing)],
            ..usual
        }
    }
}

/// Most intervals of a step that a search goes on to by itself.
const MOST_INTERVALS: usize = 60;

impl Demands {
    /// More nodes, where a motion was not found or does not walk by its outputs; false: there are many already.
    pub fn finer(&mut self) -> bool {
        self.intervals = self.intervals * 3 / 2;
        self.intervals <= MOST_INTERVALS
    }
}

/// What is wished of a gait as it walks under its own controller; what is `None` follows from the robot's size.
#[derive(Debug, Clone, PartialEq)]
pub struct Wishes {
    /// Coulomb's coefficient that forces and impulses stay below.
    pub friction: f64,
    /// Height of feet in the air, m.
    pub clearance: Option<f64>,
    /// Distance of the centre of pressure from the ends of a sole, m.
    pub zmp: Option<f64>,
    /// Smallest vertical impulse on each foot that an impact holds, N s.
    pub impulse: Option<f64>,
    /// Distance from the stops of joints, rad or m.
    pub joint: f64,
    /// Longest step, as a part of the base's height.
    pub longest_step: f64,
    /// Intervals of a step.
    pub intervals: usize,
    /// What is made small.
    pub objective: Objective,
    /// Largest part of a small deviation that may be left after a step.
    pub multiplier: f64,
}

impl Default for Wishes {
    fn default() -> Self {
        let usual = Demands::new(1.0);
        Self {
            friction: 0.6,
            clearance: None,
            zmp: None,
            impulse: None,
            joint: usual.joint,
            longest_step: usual.longest_step,
            intervals: usual.intervals,
            objective: usual.objective,
            multiplier: 0.8,
        }
    }
}

/// What a search is asked for, of what a walk is to keep: friction of forces and of impulses, impulses, distances. Impacts of walks are those of their motions within
/// some thousandths, forces are not: the controller shares them out anew.
const RESERVE: [f64; 4] = [5.0 / 6.0, 0.98, 1.1, 1.2];

impl Wishes {
    /// What the walk is to keep, of a robot of this mass (kg) with its base at this height (m) under this gravity (m/s²).
    pub fn demands(&self, speed: f64, size: [f64; 3]) -> Demands {
        let sized = Demands::of_size(speed, size);
        let [_, _, impulse, distance] = RESERVE;
        Demands {
            friction: self.friction,
            impact_friction: self.friction,
            clearance: self.clearance.unwrap_or(sized.clearance / distance),
            zmp: self.zmp.unwrap_or(sized.zmp / distance),
            impulse: self.impulse.unwrap_or(sized.impulse / impulse),
            joint: self.joint,
            longest_step: self.longest_step,
            intervals: self.intervals,
            objective: self.objective,
            ..sized
        }
    }
}

impl Demands {
    /// What a first motion is asked for: with less it is found from nearly anywhere, and what is asked for in earnest is then near.
    #[must_use]
    pub fn eased(&self) -> Self {
        Self {
            friction: self.friction.max(0.8),
            impact_friction: self.impact_friction.max(0.8),
            push: 0.2 * self.push,
            zmp: 0.2 * self.zmp,
            clearance: 0.5 * self.clearance,
            impulse: 0.02 * self.impulse,
            lift_off: 0.0,
            landing: [0.25 * self.landing[0], 2.0 * self.landing[1]],
            // Squared torques have no kinks: a motion of least torques is near one of least work.
            objective: Objective::Torque,
            ..self.clone()
        }
    }

    /// With what the controller's walk takes of them, so that about as much is left.
    #[must_use]
    pub fn with_reserve(&self) -> Self {
        let [friction, impact_friction, impulse, distance] = RESERVE;
        Self {
            friction: friction * self.friction,
            impact_friction: impact_friction * self.impact_friction,
            impulse: impulse * self.impulse,
            zmp: distance * self.zmp,
            clearance: distance * self.clearance,
            ..self.clone()
        }
    }
}
