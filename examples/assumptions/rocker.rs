//! The robot as a rigid body that rocks from one ankle to the other in the frontal plane.
use super::trials::Failure;
use bipedc_analysis::simulate::Mechanics;
use bipedc_runtime::nalgebra::{DVector, Vector2};

/// Half the angle between the legs, rad.
const APART: f64 = 0.3;

/// A body about the axis of one ankle; the other one mirrors it.
#[derive(Debug, Clone, Copy)]
pub struct Rocker {
    /// kg
    mass: f64,
    /// About the ankle's axis, without the foot that stands, kg m².
    inertia: f64,
    /// From the axis to the centre of mass in the posture of the start, y to the left and z up, m.
    arm: Vector2<f64>,
    /// From one axis to the other there.
    other: Vector2<f64>,
}

/// What happens at the landing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Landing {
    /// The velocity goes on about the other ankle.
    Smooth,
    /// Angular momentum about the axis that lands is kept, the other foot lets go.
    Plastic,
}

/// How it goes.
#[derive(Debug, Clone, Copy)]
pub struct Rocked {
    /// s
    pub landing: f64,
    /// Roll velocity before and after, rad/s.
    pub rate: [f64; 2],
    /// J
    pub lost: f64,
    /// Largest roll on the other foot, rad.
    pub roll: f64,
    /// From the landing until the first foot lands again, s.
    pub swing: f64,
}

impl Rocker {
    /// The rigid body that the robot is in this posture, from its kinetic energy when it turns about the right ankle's axis; the foot
    /// stays where it is.
    pub fn of(mechanics: &Mechanics<'_>, q: &[f64], mass: f64) -> Result<Self, Failure> {
        let zero = vec![0.0; mechanics.nv()];
        let named =
            |name: &str, v: &[f64]| mechanics.named(name, q, v).ok_or_else(|| format!("no function {name}"));
        let place = |name: &str| -> Result<Vector2<f64>, Failure> {
            let at = named(name, &zero)?;
            Ok(Vector2::new(at[1], at[2]))
        };
        let (axis, left) = (place("position_of_right_foot")?, place("position_of_left_foot")?);
        let center = place("center_of_mass")?;
        let base = Vector2::new(q[1], q[2]);
        // Turning about world x with 1 rad/s: the origin of the torso moves across the line to the axis.
        let (lever, roll) = (base - axis, 2.0 * q[3].atan2(q[6]));
        let world = Vector2::new(-lever.y, lever.x);
        let (s, c) = roll.sin_cos();
        let mut v = DVector::zeros(mechanics.nv());
        (v[1], v[2], v[3]) = (c * world.x + s * world.y, -s * world.x + c * world.y, 1.0);
        // The right foot stands still.
        v[6 + 5] = -1.0;
        let energy = named("kinetic_energy", v.as_slice())?[0];
        Ok(Self { mass, inertia: 2.0 * energy, arm: center - axis, other: left - axis })
    }

    /// The same mass in one point.
    pub fn single_mass(self) -> Self {
        Self { inertia: self.mass * self.arm.norm_squared(), ..self }
    }

    /// Angle by which the body turns from the start until the other foot lands, rad.
    fn way(&self) -> f64 {
        // Both axes level.
        -self.other.y.atan2(self.other.x)
    }

    /// Released at rest, by a Runge-Kutta method at this step (s).
    pub fn run(&self, landing: Landing, step: f64) -> Rocked {
        // The turn from the start is negative: towards the left.
        let gravity = |turn: f64| {
            let (s, c) = turn.sin_cos();
            let across = c * self.arm.x - s * self.arm.y;
            -9.81 * self.mass * across / self.inertia
        };
        let way = self.way();
        let (landed, [_, rate], _) = swing([0.0, 0.0], &gravity, |[turn, _]| turn <= way, step);
        let after = match landing {
            Landing::Smooth => rate,
            Landing::Plastic => rate * self.kept(way),
        };
        let lost = 0.5 * self.inertia * (rate * rate - after * after);
        // About the other ankle the body is its mirror: angle and velocity change their sign.
        let mirrored = [way, -after];
        let (swung, _, extreme) = swing(mirrored, &gravity, |[turn, rate]| turn <= way && rate < 0.0, step);
        Rocked { landing: landed, rate: [rate, after], lost, roll: -(APART + extreme), swing: swung }
    }

    /// Velocity after a plastic landing over that before: angular momentum about the axis that lands.
    fn kept(&self, way: f64) -> f64 {
        let (s, c) = way.sin_cos();
        let turned = |a: Vector2<f64>| Vector2::new(c * a.x - s * a.y, s * a.x + c * a.y);
        let (arm, other) = (turned(self.arm), turned(self.other));
        let about_center = self.inertia - self.mass * self.arm.norm_squared();
        (about_center + self.mass * arm.dot(&(arm - other)))
            / (about_center + self.mass * (arm - other).norm_squared())
    }
}

/// Until `done`: time, state, and the largest angle.
fn swing(
    start: [f64; 2],
    gravity: &dyn Fn(f64) -> f64,
    done: impl Fn([f64; 2]) -> bool,
    step: f64,
) -> (f64, [f64; 2], f64) {
    let (mut state, mut time, mut extreme) = (start, 0.0, start[0]);
    let slope = |[turn, rate]: [f64; 2]| [rate, gravity(turn)];
    // Ten seconds are more than any fall takes.
    while time < 10.0 {
        let add = |[a, b]: [f64; 2], [c, d]: [f64; 2], h: f64| [a + h * c, b + h * d];
        let k1 = slope(state);
        let k2 = slope(add(state, k1, 0.5 * step));
        let k3 = slope(add(state, k2, 0.5 * step));
        let k4 = slope(add(state, k3, step));
        state = [0, 1].map(|i| state[i] + step / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
        time += step;
        extreme = extreme.max(state[0]);
        if done(state) {
            break;
        }
    }
    (time, state, extreme)
}
