//! Velocities as rates of the configuration.
use super::{BaseKind, Tree};

impl Tree {
    /// q̇ (length `nq`) at the configuration `q` under the velocity `v` (length `nv`): of a floating base v begins with the
    /// twist in the base's own axes (m/s, rad/s), q with its position in the world and its quaternion x y z w.
    pub fn configuration_rate(&self, q: &[f64], v: &[f64]) -> Vec<f64> {
        if self.base != BaseKind::Floating {
            return v.to_vec();
        }
        let cross = |a: [f64; 3], b: [f64; 3]| {
            [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
        };
        let (u, w) = ([q[3], q[4], q[5]], q[6]);
        let (linear, angular) = ([v[0], v[1], v[2]], [v[3], v[4], v[5]]);
        // R v = v + 2 (w u × v + u × (u × v)); the quaternion's rate is half of itself times (ω, 0).
        let once = cross(u, linear);
        let twice = cross(u, once);
        let turn = cross(u, angular);
        let mut out: Vec<f64> = (0..3).map(|k| linear[k] + 2.0 * (w * once[k] + twice[k])).collect();
        out.extend((0..3).map(|k| 0.5 * (w * angular[k] + turn[k])));
        out.push(-0.5 * (u[0] * angular[0] + u[1] * angular[1] + u[2] * angular[2]));
        out.extend(&v[6..]);
        out
    }
}
