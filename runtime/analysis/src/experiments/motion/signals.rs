//! What a row's residual may go with.
use super::experiment::MotionExperiment;
use crate::experiments::Channel;
use crate::experiments::signals::RATE_OF_LOAD;

/// Signals of a joint itself, in the order in which they are told.
const OWN: [&str; 5] = ["position", "velocity", "load", "acceleration", "time"];

impl MotionExperiment<'_> {
    /// Signals of a row, those of its joint; an angle between a motor and its link may also go with how fast the torque between them changes, where what yields damps.
    pub(super) fn signals_of_row(&self, row: usize) -> Vec<(String, Vec<f64>)> {
        let joint = self.joint_of[row];
        let mut signals = self.signals_of(joint);
        if self.rows[row].channel == Channel::Transmission {
            signals.push((RATE_OF_LOAD.to_owned(), self.rate_of_load(joint)));
        }
        signals
    }

    /// By differences of neighbours, N m/s or N/s.
    fn rate_of_load(&self, joint: usize) -> Vec<f64> {
        let load = self.of_load(joint);
        let mut rate = vec![0.0; load.len()];
        for segment in self.recording.segments.iter().filter(|segment| segment.len() > 2) {
            for i in segment.start + 1..segment.end - 1 {
                rate[i] = (load[i + 1] - load[i - 1]) / (2.0 * self.recording.step);
            }
            rate[segment.start] = rate[segment.start + 1];
            rate[segment.end - 1] = rate[segment.end - 2];
        }
        rate
    }

    /// All signals that a joint's rows may go with: its own, then motions of other joints.
    pub(super) fn signals_of(&self, joint: usize) -> Vec<(String, Vec<f64>)> {
        let own = OWN.iter().filter_map(|name| Some(((*name).to_owned(), self.own_signal(joint, name)?)));
        let others = (0..self.layout.joints.len()).filter(|other| *other != joint);
        let of_others = others.flat_map(|other| {
            let name = &self.layout.joints[other].name;
            [
                (format!("{name}/position"), self.of_link(other, 0).to_vec()),
                (format!("{name}/velocity"), self.of_link(other, 1).to_vec()),
            ]
        });
        own.chain(of_others).collect()
    }

    /// One of them; those of the joint itself are made alone.
    pub(super) fn signal_of(&self, joint: usize, name: &str) -> Option<Vec<f64>> {
        let among_all = || self.signals_of(joint).into_iter().find(|(known, _)| known == name);
        self.own_signal(joint, name).or_else(|| Some(among_all()?.1))
    }

    fn own_signal(&self, joint: usize, name: &str) -> Option<Vec<f64>> {
        let order = match name {
            "load" => return Some(self.of_load(joint).to_vec()),
            "time" => return Some(self.recording.time.clone()),
            "position" => 0,
            "velocity" => 1,
            "acceleration" => 2,
            _ => return None,
        };
        Some(self.of_motor(joint, order).to_vec())
    }
}
