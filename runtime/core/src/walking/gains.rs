//! What somebody chooses for a robot that walks.
use super::steps::Stride;

/// How the robot walks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gains<R> {
    /// Steps.
    pub stride: Stride<R>,
    /// Height of the centre of mass above the standing soles, m.
    pub height: R,
    /// How high feet are lifted, m.
    pub lift: R,
    /// Of the zero moment point from the edges of the soles, m.
    pub margin: R,
    /// Of the divergent component, 1/s.
    pub divergent: R,
    /// Natural frequencies of errors, critically damped, rad/s: torso, height, swinging foot, other joints.
    pub torso: R,
    /// See [`Self::torso`].
    pub rise: R,
    /// See [`Self::torso`].
    pub swing: R,
    /// See [`Self::torso`].
    pub posture: R,
    /// Angular acceleration with which the torso takes what the zero moment point cannot: rad/s² per m that it should go beyond the soles, and at most.
    pub hip: [R; 2],
    /// With which soles that stand but move are braked, 1/s.
    pub brake: R,
    /// From standing to the first step, s.
    pub start: R,
    /// With which joints are braked where there are no commands, N m s/rad.
    pub passive: R,
    /// Load (N) from which a foot is on the ground.
    pub touch: R,
    /// Largest horizontal force of the ground per vertical one.
    pub friction: R,
    /// Largest moment about the sole's normal per normal force, m.
    pub turning: R,
    /// Least normal force of a foot that stands, N.
    pub least_load: R,
}
