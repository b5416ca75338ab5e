//! Robots of other sizes: what lengths, times, forces and torques are to a robot, so that one and the same robot twice as large is the same problem.
use super::gravity;
use bipedc_compiler::compile::{Collocation, CollocationPhase};
use bipedc_compiler::description::model::JointKind;

/// Factors from a robot of 20 kg whose base is 0.7 m above the ground of the earth, which all absolute numbers of a search are meant for. Length and gravity
/// settle the time (Froude): t = √(length/gravity).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Similarity {
    pub mass: f64,
    pub length: f64,
    pub gravity: f64,
}

/// What a coordinate or a variable is measured in.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Measure {
    /// m
    Length,
    /// rad, or nothing
    Angle,
}

impl Measure {
    /// Of a unit of a gait file.
    pub fn of_unit(unit: &str) -> Self {
        if unit == "m" { Self::Length } else { Self::Angle }
    }

    /// Of each coordinate of the base and of the joints.
    pub fn of_coordinates(of: &Collocation) -> Vec<Self> {
        let mut found = vec![Self::Length; of.tree.nv];
        found[2] = Self::Angle;
        for joint in &of.tree.joints {
            let named = of.description.joints.iter().find(|other| other.name == joint.name);
            let slides = named.is_some_and(|joint| joint.kind == JointKind::Prismatic);
            found[joint.v_index] = if slides { Self::Length } else { Self::Angle };
        }
        found
    }

    /// Of what each force of the ground holds: x and z of a point are lengths, a foot's pitch is an angle.
    pub fn of_forces(phase: &CollocationPhase) -> Vec<Self> {
        let mut found = vec![Self::Length; phase.forces.len()];
        phase.feet.iter().flatten().filter_map(|foot| foot.moment).for_each(|k| found[k] = Self::Angle);
        found
    }
}

impl Similarity {
    /// Of a robot with its base at this height (m).
    pub fn new(of: &Collocation, height: f64) -> Self {
        Self { mass: of.mass / 20.0, length: height / 0.7, gravity: gravity(of) / 9.81 }
    }
    pub fn time(&self) -> f64 {
        (self.length / self.gravity).sqrt()
    }
    pub fn position(&self, of: Measure) -> f64 {
        if of == Measure::Length { self.length } else { 1.0 }
    }
    pub fn velocity(&self, of: Measure) -> f64 {
        self.position(of) / self.time()
    }
    pub fn acceleration(&self, of: Measure) -> f64 {
        self.position(of) * self.gravity / self.length
    }
    /// A force, or the torque about an angle.
    pub fn load(&self, of: Measure) -> f64 {
        self.mass * self.gravity * self.length / self.position(of)
    }
    /// An impulse, or an angular one.
    pub fn impulse(&self, of: Measure) -> f64 {
        self.load(of) * self.time()
    }
}
