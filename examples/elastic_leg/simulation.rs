//! TUlip's leg with series elastic drives, simulated forwards: controllers, stiction, springs, encoders.
use nalgebra::{SMatrix, SVector};
use std::fmt::Write;
use std::path::Path;

/// Joints of the leg.
pub const JOINTS: [&str; 6] = [
    "right_hip_yaw",
    "right_hip_roll",
    "right_hip_pitch",
    "right_knee_pitch",
    "right_ankle_pitch",
    "right_ankle_roll",
];
/// Drives of the first five joints in their order; ankle roll has a spring and a damper only.
const MOTORS: usize = 5;
/// Of the simulation, s.
const STEP: f64 = 1e-4;
/// Of the log, s.
pub const SAMPLE: f64 = 2e-3;
/// Coulomb friction turns round within this speed of the motor shaft, rad/s.
const EDGE: f64 = 1.0;
/// Bandwidth of the position controllers at the motors, rad/s.
const BANDWIDTH: f64 = 80.0;
/// Inertia that the controllers count on at a motor shaft, kg m².
const EXPECTED: f64 = 1e-5;

/// What drives a joint, in truth.
#[derive(Debug, Clone, Copy)]
pub struct Drive {
    pub gear: f64,
    pub rotor: f64,
    pub torque_constant: f64,
    pub viscous: f64,
    pub coulomb: f64,
    /// Motor pulley, joint pulley (m), stiffness (N/m); stiff without.
    pub spring: Option<[f64; 3]>,
}

/// The joint that no motor drives: stiffness, damping.
const PASSIVE: [f64; 2] = [12.0, 0.05];
/// Counts per turn of motor and joint encoders.
const COUNTS: [f64; 2] = [2000.0, 30000.0];
/// Noise of the current, A.
const CURRENT: f64 = 0.005;

/// Numbers that look random and depend on the seed alone (SplitMix64).
pub struct Random(pub u64);

impl Random {
    /// Even between 0 and 1.
    pub fn even(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    fn normal(&mut self) -> f64 {
        (-2.0 * self.even().max(1e-300).ln()).sqrt() * (std::f64::consts::TAU * self.even()).cos()
    }
}

/// Angles and speeds of joints and of the motors behind springs.
#[derive(Clone, Copy)]
struct State {
    q: SVector<f64, 6>,
    v: SVector<f64, 6>,
    motor: SVector<f64, 5>,
    speed: SVector<f64, 5>,
}

impl State {
    fn moved(&self, rate: &Self, step: f64) -> Self {
        Self {
            q: self.q + rate.q * step,
            v: self.v + rate.v * step,
            motor: self.motor + rate.motor * step,
            speed: self.speed + rate.speed * step,
        }
    }
}

/// A leg that follows sums of sines.
pub struct Leg {
    pub drives: [Drive; MOTORS],
    waves: [[[f64; 3]; 4]; MOTORS],
}

impl Leg {
    /// A motion drawn from a seed.
    pub fn new(drives: [Drive; MOTORS], random: &mut Random) -> Self {
        let sizes = [0.16, 0.14, 0.30, 0.32, 0.26];
        let waves = sizes.map(|size| {
            [(); 4].map(|()| {
                let frequency = 0.15 + 1.05 * random.even();
                [
                    size * (0.4 + 0.6 * random.even()),
                    std::f64::consts::TAU * frequency,
                    std::f64::consts::TAU * random.even(),
                ]
            })
        });
        Self { drives, waves }
    }

    /// What the controller of a joint asks for: angle and speed. The knee is bent.
    fn wanted(&self, joint: usize, t: f64) -> [f64; 2] {
        // The motion swells from rest.
        let part = (t / 1.5).min(1.0);
        let (swell, rate) = (
            part * part * (3.0 - 2.0 * part),
            if part < 1.0 { 6.0 * part * (1.0 - part) / 1.5 } else { 0.0 },
        );
        let [mut x, mut v] = [0.0; 2];
        for [size, w, phase] in self.waves[joint] {
            let (sin, cos) = (w * t + phase).sin_cos();
            x += size * sin;
            v += size * w * cos;
        }
        let middle = if joint == 3 { 0.75 } else { 0.0 };
        [middle + swell * x, swell * v + rate * x]
    }

    /// Motor turns per turn of the joint.
    fn turns(&self, joint: usize) -> f64 {
        let drive = self.drives[joint];
        drive.gear * drive.spring.map_or(1.0, |[motor, load, _]| load / motor)
    }

    /// Angle and speed of a motor: of its own, or with its joint.
    fn shaft(&self, joint: usize, state: &State) -> [f64; 2] {
        match self.drives[joint].spring {
            Some(_) => [state.motor[joint], state.speed[joint]],
            None => [state.q[joint], state.v[joint]].map(|x| x * self.drives[joint].gear),
        }
    }

    /// Torque of a motor: its controller.
    fn torque(&self, joint: usize, t: f64, state: &State) -> f64 {
        let [angle, speed] = self.wanted(joint, t).map(|x| x * self.turns(joint));
        let [own, rate] = self.shaft(joint, state);
        EXPECTED * (BANDWIDTH * BANDWIDTH * (angle - own) + 1.4 * BANDWIDTH * (speed - rate))
    }

    fn rate(&self, t: f64, state: &State) -> State {
        let mut tau = -tulip_v1_leg::bias(&state.q, &state.v);
        let mut mass: SMatrix<f64, 6, 6> = tulip_v1_leg::mass_matrix(&state.q);
        let (mut motor, mut speed) = (SVector::<f64, 5>::zeros(), SVector::<f64, 5>::zeros());
        for (joint, drive) in self.drives.iter().enumerate() {
            let [angle, rate] = self.shaft(joint, state);
            let friction = drive.viscous * rate + drive.coulomb * (rate / EDGE).tanh();
            let left = self.torque(joint, t, state) - friction;
            match drive.spring {
                Some([of_motor, of_load, stiffness]) => {
                    let force = stiffness * (of_motor / drive.gear * angle - of_load * state.q[joint]);
                    tau[joint] += of_load * force;
                    motor[joint] = rate;
                    speed[joint] = (left - of_motor / drive.gear * force) / drive.rotor;
                }
                None => {
                    tau[joint] += drive.gear * left;
                    mass[(joint, joint)] += drive.rotor * drive.gear * drive.gear;
                }
            }
        }
        tau[MOTORS] -= PASSIVE[0] * state.q[MOTORS] + PASSIVE[1] * state.v[MOTORS];
        let a = mass.cholesky().map_or_else(SVector::zeros, |factor| factor.solve(&tau));
        State { q: state.v, v: a, motor, speed }
    }

    fn step(&self, t: f64, state: &State) -> State {
        let half = 0.5 * STEP;
        let a = self.rate(t, state);
        let b = self.rate(t + half, &state.moved(&a, half));
        let c = self.rate(t + half, &state.moved(&b, half));
        let d = self.rate(t + STEP, &state.moved(&c, STEP));
        let sixth = STEP / 6.0;
        state.moved(&a, sixth).moved(&b, 2.0 * sixth).moved(&c, 2.0 * sixth).moved(&d, sixth)
    }

    /// Simulates and writes what sensors show, as `log-format` says: stiff joints by their motors alone.
    ///
    /// # Errors
    /// Files that cannot be written.
    pub fn log(&self, seconds: f64, random: &mut Random, file: &Path) -> std::io::Result<()> {
        let mut out = String::from("time");
        for (joint, drive) in JOINTS.iter().zip(&self.drives) {
            let angle = if drive.spring.is_some() { format!(",{joint}/position") } else { String::new() };
            let _ = write!(out, "{angle},{joint}/motor_position,{joint}/motor_current");
        }
        let _ = writeln!(out, ",{}/position", JOINTS[MOTORS]);
        let mut state = self.start();
        let every = (SAMPLE / STEP).round() as usize;
        for k in 0..=(seconds / STEP).round() as usize {
            let t = STEP * k as f64;
            if k % every == 0 {
                let _ = write!(out, "{t:.4}");
                for (joint, drive) in self.drives.iter().enumerate() {
                    if drive.spring.is_some() {
                        let _ = write!(out, ",{:.7}", rounded(state.q[joint], COUNTS[1]));
                    }
                    let current =
                        self.torque(joint, t, &state) / drive.torque_constant + CURRENT * random.normal();
                    let _ =
                        write!(out, ",{:.5},{current:.4}", rounded(self.shaft(joint, &state)[0], COUNTS[0]));
                }
                let _ = writeln!(out, ",{:.7}", rounded(state.q[MOTORS], COUNTS[1]));
            }
            state = self.step(t, &state);
        }
        std::fs::write(file, out)
    }

    /// At rest where the motion begins, springs without load.
    fn start(&self) -> State {
        let mut state = State {
            q: SVector::zeros(),
            v: SVector::zeros(),
            motor: SVector::zeros(),
            speed: SVector::zeros(),
        };
        for joint in 0..MOTORS {
            state.q[joint] = self.wanted(joint, 0.0)[0];
            state.motor[joint] = self.turns(joint) * state.q[joint];
        }
        state
    }
}

fn rounded(angle: f64, counts: f64) -> f64 {
    let count = std::f64::consts::TAU / counts;
    (angle / count).round() * count
}
