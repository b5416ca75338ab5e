//! What the two experiments of the thesis' section 4.2 show, measured in our logs.
use super::trials::{Trial, mean, peaks, range};

/// Load above which a foot counts as standing, N.
const LOADED: f64 = 1.0;

/// Height of the axis of the ankle roll above the sole, m.
const ANKLE: f64 = 0.055;

/// A stretch between two changes of the roll's sign.
#[derive(Debug, Clone, Copy)]
pub struct Swing {
    /// s
    pub begin: f64,
    /// Largest roll in it, rad.
    pub roll: f64,
    /// How often the foot that stands in it strikes the ground.
    pub strikes: usize,
}

/// The robot released on its right foot.
#[derive(Debug)]
pub struct Released {
    /// The left foot strikes for the first time, s.
    pub landing: f64,
    /// Furthest travel of the right foot's centre of pressure across the foot until shortly before, m.
    pub pressure_travel: f64,
    /// Of the right ankle roll until then, rad.
    pub ankle_travel: f64,
    /// After the landing, as long as the roll exceeds 2 mrad.
    pub swings: Vec<Swing>,
    /// Roll at which the left leg would be vertical, rad.
    pub upright: f64,
    /// Least distance of the left ankle roll from zero after it adapted to the ground, rad.
    pub left_ankle: f64,
    /// Extremes of the pitch of the torso about its last value, rad.
    pub pitch: Vec<(f64, f64)>,
    /// Part of the time from 3 s on in which both feet stand.
    pub both_stand: f64,
    /// Least and greatest load on the front corners of the right foot from 3 s on, N.
    pub exchanged: [f64; 2],
    /// Largest reading of a corner, N.
    pub largest: f64,
    /// The same less what the horizontal force explains, which acts below the ankle's axis, m.
    pub pressure_unexplained: f64,
}

impl Released {
    pub fn of(trial: &Trial) -> Self {
        let time = trial.time();
        let [roll, pitch, _] = trial.torso();
        let feet = ["right_foot", "left_foot"].map(|foot| trial.column(&format!("{foot}/force/z")));
        let landing = feet[1].iter().position(|f| *f > LOADED).unwrap_or(time.len() - 1);
        // The first tenth of a second is the settling of the posture on its controllers.
        let first = trial.at(0.1)..landing;
        let span = |values: &[f64]| range(values)[1] - range(values)[0];
        let pressure = trial.column("right_foot/cop/y");
        let [across, up] = ["y", "z"].map(|axis| trial.column(&format!("right_foot/force/{axis}")));
        let about_ankle: Vec<f64> =
            (0..time.len()).map(|i| pressure[i] + ANKLE * across[i] / up[i]).collect();
        let ankle = trial.joint("right_ankle_roll");
        let left = trial.joint("left_ankle_roll");
        let last = mean(&pitch[pitch.len() * 9 / 10..]);
        let last_stretch = trial.at(3.0);
        let both = (last_stretch..time.len()).filter(|&i| feet.iter().all(|f| f[i] > LOADED)).count();
        let corners = ["front_left", "front_right", "rear_left", "rear_right"];
        let readings = ["right_foot", "left_foot"]
            .into_iter()
            .flat_map(|f| corners.map(|c| range(&trial.corner(f, c))[1]));
        Self {
            landing: time[landing],
            pressure_travel: span(&pressure[first.clone()]),
            pressure_unexplained: span(&about_ankle[first.clone()]),
            ankle_travel: span(&ankle[first]),
            swings: swings(&time, &roll, &feet, landing),
            upright: -0.3,
            left_ankle: left[landing + trial.at(0.1)..]
                .iter()
                .fold(f64::INFINITY, |least, x| least.min(x.abs())),
            pitch: peaks(&pitch[trial.at(2.5)..], last)
                .into_iter()
                .map(|(i, p)| (time[trial.at(2.5) + i], p))
                .collect(),
            both_stand: both as f64 / (time.len() - last_stretch) as f64,
            exchanged: range(&trial.edge("right_foot", "front")[trial.at(3.0)..]),
            largest: readings.fold(0.0, f64::max),
        }
    }
}

/// From the first change of the roll's sign after the landing.
fn swings(time: &[f64], roll: &[f64], feet: &[Vec<f64>; 2], landing: usize) -> Vec<Swing> {
    let extremes = peaks(&roll[landing..], 0.0);
    let crossing =
        |from: usize| (from..roll.len()).find(|&i| roll[i] * roll[from] < 0.0).unwrap_or(roll.len());
    let mut found = Vec::new();
    for &(peak, roll_there) in &extremes {
        // What is left of the swing before the landing.
        if peak == 0 {
            continue;
        }
        let end = crossing(landing + peak);
        let begin =
            (landing..=landing + peak).rev().find(|&i| roll[i] * roll_there <= 0.0).unwrap_or(landing);
        if roll_there.abs() < 2e-3 {
            break;
        }
        let foot = &feet[usize::from(roll_there < 0.0)];
        let strikes = (begin.max(1)..end).filter(|&i| foot[i] > 0.0 && foot[i - 1] <= 0.0).count();
        found.push(Swing { begin: time[begin], roll: roll_there, strikes });
    }
    found
}

/// The leg that is swung.
#[derive(Debug)]
pub struct Swung {
    /// Change of the torso's roll while the leg speeds up, and between then and the end of its motion, rad.
    pub torso: [f64; 2],
    /// Largest angular velocity of the torso about x while the leg speeds up (towards the leg: negative) and while it slows down, rad/s.
    pub torso_rate: [f64; 2],
    /// Change of the right hip roll while the leg speeds up, rad.
    pub right_hip: f64,
    /// Of the right ankle roll.
    pub right_ankle: f64,
    /// Load on the outer corners of the right foot: before, at most while the leg speeds up, at least while it slows down, N.
    pub outer: [f64; 3],
    /// On the inner ones: before, at least, at most.
    pub inner: [f64; 3],
    /// Of the pressure's centre across the foot, from the ankle to the robot's left, m: before, outermost, innermost after.
    pub pressure: [f64; 3],
}

/// The leg moves from here to there, s.
pub const MOTION: [f64; 2] = [1.0, 1.5];

impl Swung {
    pub fn of(trial: &Trial) -> Self {
        let (start, half, end) =
            (trial.at(MOTION[0]), trial.at(0.5 * (MOTION[0] + MOTION[1])), trial.at(MOTION[1]));
        let [roll, ..] = trial.torso();
        let rate = trial.column("base/angular_velocity/x");
        let (outer, inner) = (trial.edge("right_foot", "right"), trial.edge("right_foot", "left"));
        let pressure = trial.column("right_foot/cop/y");
        // The leg speeds up during the first half of its motion; the robot answers within the first quarter, then its joints swing back.
        let quarter = (start + half) / 2;
        let farthest = |values: &[f64]| {
            let from = values[start];
            let change = values[start..quarter].iter().map(|x| x - from);
            change.fold(0.0, |far: f64, x| if x.abs() > far.abs() { x } else { far })
        };
        Self {
            torso: [farthest(&roll), roll[end] - roll[start]],
            torso_rate: [range(&rate[start..half])[0], range(&rate[half..end + (end - half)])[1]],
            right_hip: farthest(&trial.joint("right_hip_roll")),
            right_ankle: farthest(&trial.joint("right_ankle_roll")),
            outer: [outer[start], range(&outer[start..half])[1], range(&outer[half..end + 50])[0]],
            inner: [inner[start], range(&inner[start..half])[0], range(&inner[half..end + 50])[1]],
            pressure: [
                pressure[start],
                range(&pressure[start..half])[0],
                range(&pressure[half..end + 50])[1],
            ],
        }
    }
}
