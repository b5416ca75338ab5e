//! What can be wrong with readings: seeded, for a while, then something else.
use bipedc_effects::random::Random;
use tulip_controller::walking::{JOINTS, Sensors, Velocity};

/// One of so many whole numbers from 0.
pub fn below(random: &mut Random, count: usize) -> usize {
    (random.bits() % count as u64) as usize
}

/// No number, beyond all ranges, or nearly anything.
pub fn nonsense(random: &mut Random) -> f64 {
    const ODD: [f64; 8] = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e308, -1e308, 1e-310, -0.0, f64::MAX];
    match below(random, 3) {
        0 => ODD[below(random, ODD.len())],
        1 => f64::NAN,
        _ => random.symmetric() * 10.0_f64.powf(12.0 * random.symmetric()),
    }
}

/// What is wrong for a while.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Wrong {
    Nothing,
    /// One number of all, in this place, is nonsense.
    Number(usize),
    /// All are.
    Everything,
    /// Encoder and velocity of joints stay as they were: of one, or of all.
    Frozen(Option<usize>),
    /// An encoder is off by so much (rad).
    Jumped(usize, f64),
    /// No reading of a foot, or of both.
    Dropped(Option<usize>),
    /// Loads stay as they were.
    StuckLoads,
    /// The inertial unit says the same again and again.
    StuckUnit,
    /// Time stands still.
    Still,
    /// The clock is off by so much, s.
    Clock(f64),
    /// Who commands the walk says nonsense.
    Command,
}

impl Wrong {
    pub fn random(random: &mut Random) -> Self {
        let joint = below(random, JOINTS);
        match below(random, 12) {
            0 => Self::Number(below(random, NUMBERS)),
            1 => Self::Everything,
            2 => Self::Frozen(Some(joint)),
            3 => Self::Frozen(None),
            4 => Self::Jumped(joint, 3.0 * random.symmetric()),
            5 => Self::Dropped([None, Some(0), Some(1)][below(random, 3)]),
            6 => Self::StuckLoads,
            7 => Self::StuckUnit,
            8 => Self::Still,
            9 => Self::Clock(10.0_f64.powf(3.0 * random.symmetric()) * random.symmetric().signum()),
            10 => Self::Command,
            _ => Self::Number(1 + joint),
        }
    }

    /// Corrupts a reading; `before`: what was read as it began.
    pub fn corrupt(
        self,
        random: &mut Random,
        before: &Sensors,
        sensors: &mut Sensors,
        wanted: &mut Velocity<f64>,
    ) {
        match self {
            Self::Nothing => {}
            Self::Number(place) => *number(sensors, place) = nonsense(random),
            Self::Everything => (0..NUMBERS).for_each(|place| *number(sensors, place) = nonsense(random)),
            Self::Frozen(which) => {
                for joint in (0..JOINTS).filter(|joint| which.is_none_or(|which| which == *joint)) {
                    sensors.joint_position[joint] = before.joint_position[joint];
                    sensors.joint_velocity[joint] = before.joint_velocity[joint];
                }
            }
            Self::Jumped(joint, by) => sensors.joint_position[joint] += by,
            Self::Dropped(which) => {
                for foot in (0..2).filter(|foot| which.is_none_or(|which| which == *foot)) {
                    (sensors.load[foot], sensors.center[foot]) = (f64::NAN, [f64::NAN; 2]);
                }
            }
            Self::StuckLoads => (sensors.load, sensors.center) = (before.load, before.center),
            Self::StuckUnit => {
                sensors.angular_velocity = before.angular_velocity;
                sensors.specific_force = before.specific_force;
            }
            Self::Still => sensors.time = before.time,
            Self::Clock(by) => sensors.time += by,
            Self::Command => {
                let mut odd = || nonsense(random);
                *wanted = Velocity { forward: odd(), left: odd(), turning: odd() };
            }
        }
    }
}

/// Of a reading.
const NUMBERS: usize = 1 + 2 * JOINTS + 6 + 2 + 4;

/// One of them: time, positions, velocities, the unit, loads, centres.
fn number(sensors: &mut Sensors, place: usize) -> &mut f64 {
    let Sensors {
        time, joint_position, joint_velocity, angular_velocity, specific_force, load, center, ..
    } = sensors;
    let all = std::iter::once(time).chain(joint_position).chain(joint_velocity).chain(angular_velocity);
    let mut all = all.chain(specific_force).chain(load).chain(center.iter_mut().flatten());
    all.nth(place).expect("there are as many")
}
