//! One call of the sharing of the ground's forces: `cargo test --release -p bipedc-runtime --test walking -- --ignored --nocapture`.
use bipedc_runtime::walking::ground_forces::{Limits, Shared, StandingFoot, share_certified};
use bipedc_runtime::walking::space::{Pose, about_z};
use std::hint::black_box;
use std::time::Instant;

/// Random numbers in -1 to 1, the same every time (SplitMix64).
pub struct Numbers(pub u64);

impl Numbers {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }
}

/// TUlip's weight on two soles, the zero moment point between or within them, legs of six joints.
struct Case {
    soles: [Pose<f64>; 2],
    jacobian: [[[f64; 6]; 6]; 2],
    share: f64,
    required: [f64; 6],
    torques: [f64; 12],
}

const WEIGHT: f64 = 150.0;

impl Case {
    /// `spread`: how far from the line between the feet forces act, and how much they are inclined.
    fn random(n: &mut Numbers, spread: f64) -> Self {
        let pose = |x: f64, y: f64, yaw: f64| Pose { position: [x, y, 0.0], turn: about_z(yaw) };
        let soles = [pose(0.1 * n.next(), -0.09, 0.1 * n.next()), pose(0.1 * n.next(), 0.09, 0.1 * n.next())];
        let share = 0.5 + 0.45 * n.next();
        let jacobian = [(); 2]
            .map(|()| [(); 6].map(|()| std::array::from_fn(|k| if k < 3 { 0.3 } else { 1.0 } * n.next())));
        let [x, y] = [0, 1].map(|k| share * soles[0].position[k] + (1.0 - share) * soles[1].position[k]);
        let (x, y) = (x + 0.1 * spread * n.next(), y + 0.04 * spread * n.next());
        let (fx, fy) = (0.2 * spread * WEIGHT * n.next(), 0.2 * spread * WEIGHT * n.next());
        let required = [fx, fy, WEIGHT, y * WEIGHT, -x * WEIGHT, x * fy - y * fx];
        Self { soles, jacobian, share, required, torques: std::array::from_fn(|_| 20.0 * n.next()) }
    }
}

fn timed(name: &str, feet: usize, spread: f64, limit: f64) {
    let mut numbers = Numbers(3);
    let cases: Vec<Case> = (0..1024).map(|_| Case::random(&mut numbers, spread)).collect();
    let joints: [usize; 12] = std::array::from_fn(|k| k);
    let limits = Limits { friction: 0.6, turning: 0.05, least_load: 5.0, torque: &[limit; 12] };
    let mut times = Vec::with_capacity(1_000_000);
    let mut verdicts = [0; 3];
    for k in 0..1_000_000 {
        let case = &cases[k % cases.len()];
        let standing: [StandingFoot<'_, f64>; 2] = std::array::from_fn(|k| StandingFoot {
            sole: case.soles[k],
            extent: [-0.09, 0.15, -0.06, 0.06],
            joints: &joints[6 * k..6 * k + 6],
            jacobian: &case.jacobian[k],
            share: if k == 0 { case.share } else { 1.0 - case.share },
        });
        let mut required = case.required;
        if feet == 1 {
            // Below the right foot.
            required[3] = case.soles[0].position[1] * WEIGHT
                + 0.02 * (required[3] - case.soles[0].position[1] * WEIGHT);
            required[4] = -case.soles[0].position[0] * WEIGHT + 0.1 * required[4];
        }
        let (mut torques, mut wrenches) = (case.torques, [[0.0; 6]; 2]);
        let clock = Instant::now();
        let found = share_certified(
            black_box(&standing[..feet]),
            black_box(required),
            &limits,
            &mut torques,
            &mut wrenches,
        );
        let took = clock.elapsed().as_nanos();
        times.push(u32::try_from(took).unwrap());
        verdicts[match black_box(found).0 {
            Shared::Met => 0,
            Shared::GroundGaveWay { .. } => 1,
            _ => 2,
        }] += 1;
    }
    times.sort_unstable();
    let at = |part: f64| f64::from(times[((times.len() - 1) as f64 * part) as usize]) / 1e3;
    println!(
        "{name:<34} median {:>7.3} µs, 99 % {:>7.3}, 99.99 % {:>7.3}, worst {:>8.1}; met, gave way, clamped: {verdicts:?}",
        at(0.5),
        at(0.99),
        at(0.9999),
        at(1.0)
    );
}

#[test]
#[ignore = "takes long"]
fn how_long_feet_take_to_share() {
    timed("two feet, no limit near", 2, 0.0, 1e3);
    timed("two feet, limits near", 2, 1.0, 60.0);
    timed("two feet, limits contradict", 2, 3.0, 40.0);
    timed("one foot", 1, 0.2, 1e3);
    timed("one foot, limits contradict", 1, 3.0, 20.0);
}
