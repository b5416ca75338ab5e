//! What a walk shows: how well joints follow, how the torso moves, how often feet step.
use super::trials::{Trial, mean, range};
use bipedc_runtime::Model;

/// Joints of a leg.
pub const JOINTS: [&str; 6] = ["hip_yaw", "hip_roll", "hip_pitch", "knee_pitch", "ankle_pitch", "ankle_roll"];

/// A joint's way.
#[derive(Debug, Clone)]
pub struct Followed {
    pub joint: String,
    /// Of the wished angle, rad.
    pub range: f64,
    /// Root mean square and largest distance from it, rad.
    pub rms: f64,
    pub largest: f64,
}

#[derive(Debug)]
pub struct Walked {
    /// In the order of right and left leg.
    pub joints: Vec<Followed>,
    /// Least and greatest roll and pitch of the torso, rad.
    pub roll: [f64; 2],
    pub pitch: [f64; 2],
    /// Last yaw, mean of the last half second, rad.
    pub yaw: f64,
    /// How often each foot left the ground for more than half a second.
    pub steps: [usize; 2],
    /// Motion of the torso's origin from the first to the last row, m.
    pub moved: [f64; 2],
    /// Largest vertical force on a foot over the weight.
    pub load: f64,
}

impl Walked {
    /// Joints are compared with the wished angles, of rows of 0.1 s.
    pub fn of(trial: &Trial, wished: &[Vec<f64>]) -> Self {
        let time = trial.time();
        let [roll, pitch, yaw] = trial.torso();
        let names =
            ["right", "left"].into_iter().flat_map(|side| JOINTS.map(|joint| format!("{side}_{joint}")));
        let order: Vec<String> =
            (0..12).filter_map(|j| Some(Model::<f64>::joint_name(&tulip::Tulip, j)?.to_owned())).collect();
        let rows: Vec<usize> =
            (0..wished.len()).map(|k| trial.at(0.1 * k as f64)).filter(|i| *i < time.len()).collect();
        let followed = |joint: String| {
            let column = order.iter().position(|other| *other == joint).unwrap_or(0);
            let reference: Vec<f64> = wished.iter().map(|row| row[column]).collect();
            let here = trial.joint(&joint);
            let missed: Vec<f64> = rows.iter().zip(&reference).map(|(&i, r)| here[i] - r).collect();
            let square = mean(&missed.iter().map(|x| x * x).collect::<Vec<_>>());
            let [low, high] = range(&reference);
            let largest = missed.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
            Followed { joint, range: high - low, rms: square.sqrt(), largest }
        };
        let feet = ["right_foot", "left_foot"].map(|foot| trial.column(&format!("{foot}/force/z")));
        let origin = ["x", "y"].map(|axis| trial.column(&format!("base/position/{axis}")));
        let last = time.len() - 1;
        Self {
            joints: names.map(followed).collect(),
            roll: range(&roll),
            pitch: range(&pitch),
            yaw: mean(&yaw[trial.at(time[last] - 0.5)..]),
            steps: feet.each_ref().map(|force| lifted(force, time[1] - time[0])),
            moved: origin.map(|x| x[last] - x[0]),
            load: feet.iter().map(|f| range(f)[1]).fold(0.0, f64::max) / trial.weight,
        }
    }
}

/// Stretches without force that last longer than half a second.
fn lifted(force: &[f64], row: f64) -> usize {
    let (mut count, mut length) = (0, 0.0);
    for f in force {
        let before = length;
        length = if *f <= 0.0 { length + row } else { 0.0 };
        count += usize::from(before <= 0.5 && length > 0.5);
    }
    count
}
