//! How large and how slow a robot and its joints are beside those of which the library says what is usual.
use super::experiment::MotionExperiment;
use crate::experiments::noise::root_mean_square;
use crate::robot::InertialParameters;
use bipedc_effects::effect::Location;

impl MotionExperiment<'_> {
    /// See [`Experiment::heaviness`](crate::experiments::Experiment::heaviness).
    pub(super) fn times_as_heavy(&self, place: &Location) -> f64 {
        /// Such torques (N m; forces as on a wheel of 0.1 m) and such a mass (kg) are those of robots whose effects the library calls usual.
        const TORQUE: f64 = 30.0;
        const RADIUS: f64 = 0.1;
        const MASS: f64 = 60.0;
        const LARGEST: f64 = 1e3;
        let Some(joint) = self.index(place.joint.as_deref()) else {
            let mass: f64 = self.parameters.iter().step_by(InertialParameters::PER_BODY).sum();
            return (mass / MASS).clamp(1.0, LARGEST);
        };
        let usual = if self.layout.joints[joint].prismatic { TORQUE / RADIUS } else { TORQUE };
        (self.usual_torque(joint) / usual).clamp(1.0, LARGEST)
    }

    /// See [`Experiment::slowness`](crate::experiments::Experiment::slowness).
    pub(super) fn times_as_slow(&self, place: &Location) -> [f64; 2] {
        /// Such speeds and accelerations (rad/s, rad/s²; at a wheel of 0.1 m those of slides) are those of robots whose effects the library calls usual.
        const USUAL: [f64; 2] = [1.0, 5.0];
        const RADIUS: f64 = 0.1;
        const SLOWEST: f64 = 100.0;
        let Some(joint) = self.index(place.joint.as_deref()) else { return [1.0; 2] };
        let part = if self.layout.joints[joint].prismatic { RADIUS } else { 1.0 };
        let slower = |order: usize, usual: f64| {
            let rms = root_mean_square(self.of_motor(joint, order));
            (part * usual / rms.max(f64::MIN_POSITIVE)).clamp(1.0, SLOWEST)
        };
        [slower(1, USUAL[0]), slower(2, USUAL[1])]
    }
}
