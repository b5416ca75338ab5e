//! The joint that comes nearest to its velocity limit.

/// The joint that was nearest to its velocity limit, or farthest beyond it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fastest {
    /// By index, as in the plant's layout.
    pub joint: usize,
    /// s
    pub time: f64,
    /// Without its sign, rad/s or m/s.
    pub speed: f64,
    /// The limit less that; negative: beyond it.
    pub margin: f64,
}

impl Fastest {
    /// Takes in a state: `v` ends with the joints, which have these limits. `None`: no joint has one.
    pub fn see(found: &mut Option<Self>, limits: &[Option<f64>], (time, v): (f64, &[f64])) {
        let joints = &v[v.len().saturating_sub(limits.len())..];
        for (joint, (limit, v)) in limits.iter().zip(joints).enumerate() {
            let Some(margin) = limit.map(|limit| limit - v.abs()) else { continue };
            if found.is_none_or(|found| margin < found.margin) {
                *found = Some(Self { joint, time, speed: v.abs(), margin });
            }
        }
    }
}
