//! Which feet carry the robot.
use super::ContactExperiment;
use super::rows::LOADED;

/// A foot that was free for so long strikes when it is loaded again, s.
const FREE_S: f64 = 0.05;
/// An impact is felt for so long, s.
const AFTER_S: f64 = 0.1;

impl ContactExperiment<'_> {
    /// `right_foot alone`, …, `double support`, `no support`, `just after impact`; one flag per sample that counts.
    pub(super) fn support(&self) -> Vec<(String, Vec<bool>)> {
        let r = &self.recording;
        let least = LOADED * self.parameters.mass() * self.gravity.norm();
        let feet: Vec<(&str, Vec<bool>)> = self
            .robot
            .feet
            .iter()
            .zip(&r.feet)
            .filter(|(_, record)| record.is_logged)
            .map(|(foot, record)| (foot.name.as_str(), record.signals.iter().map(|s| s[2] > least).collect()))
            .collect();
        let count = |i: usize| feet.iter().filter(|(_, loaded)| loaded[i]).count();
        let of =
            |chosen: &dyn Fn(usize) -> bool| r.pick(&(0..r.time.len()).map(chosen).collect::<Vec<bool>>());
        let mut out: Vec<(String, Vec<bool>)> = feet
            .iter()
            .map(|(name, loaded)| (format!("{name} alone"), of(&|i| loaded[i] && count(i) == 1)))
            .collect();
        let mut struck = vec![false; r.time.len()];
        for (_, loaded) in &feet {
            self.mark_impacts(loaded, &mut struck);
        }
        out.push(("double support".to_owned(), of(&|i| count(i) > 1)));
        out.push(("no support".to_owned(), of(&|i| count(i) == 0)));
        out.push(("just after impact".to_owned(), of(&|i| struck[i])));
        out
    }

    /// Marks the samples just after a foot was loaded.
    fn mark_impacts(&self, loaded: &[bool], struck: &mut [bool]) {
        let time = &self.recording.time;
        for segment in &self.recording.segments {
            let mut free_since = None;
            let mut strike = f64::NEG_INFINITY;
            for i in segment.clone() {
                match (loaded[i], free_since) {
                    (false, None) => free_since = Some(time[i]),
                    (true, Some(since)) => {
                        if time[i] - since >= FREE_S {
                            strike = time[i];
                        }
                        free_since = None;
                    }
                    _ => {}
                }
                struck[i] |= time[i] - strike <= AFTER_S;
            }
        }
    }
}
