//! Logs whose own blocks judge: which joints these blocks do not show.
use crate::diagnose::engine::equations::regression::is_held_out;
use crate::experiments::{Channel, Experiment};

/// Of a joint's squared speeds the blocks that judge have a third. Less than this part of them tells nothing of the joint.
const SHOWN: f64 = 0.03;

/// A warning about joints that move almost only in the blocks that teach, or only in those that judge, as joints may that move one after the
/// other.
pub(crate) fn unshown(log: &dyn Experiment) -> Option<String> {
    let rows = log.rows().iter().enumerate().filter(|(_, row)| row.channel == Channel::Effort);
    let names: Vec<&str> = rows.filter(|(row, _)| is_unshown(log, *row)).map(|(_, row)| &*row.name).collect();
    let verb = if names.len() == 1 { "moves" } else { "move" };
    let list = names.join(", ");
    (!names.is_empty()).then(|| {
        format!("{list} {verb} almost only in the parts of this log that teach, or only in those that judge: what acts there is not judged, or not found; give another log with --validate")
    })
}

fn is_unshown(log: &dyn Experiment, row: usize) -> bool {
    let Some(speeds) = log.signal(row, "velocity") else { return false };
    let squares = |judges: bool| -> f64 {
        let blocks = speeds.iter().enumerate().filter(|(i, _)| is_held_out(*i, speeds.len()) == judges);
        blocks.map(|(_, speed)| speed * speed).sum()
    };
    let (judge, teach) = (squares(true), squares(false));
    judge + teach > 0.0 && judge.min(teach) < SHOWN * (judge + teach)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::Row;
    use bipedc_effects::effect::{Effect, Kind, Location};

    /// Joints that each move in some part of a log.
    struct Turns {
        rows: Vec<Row>,
        speeds: Vec<Vec<f64>>,
        zeros: Vec<f64>,
    }

    impl Turns {
        fn new(parts: &[[f64; 2]]) -> Self {
            const SAMPLES: usize = 900;
            let row = |joint: usize| Row {
                name: format!("joint_{joint}"),
                channel: Channel::Effort,
                unit: "N m",
                joint: Some(format!("joint_{joint}")),
                noise: 0.1,
            };
            let speed = |[from, to]: [f64; 2], i: usize| {
                let part = i as f64 / SAMPLES as f64;
                // Noise is everywhere.
                0.001 * (i as f64 * 12.9898).sin()
                    + if (from..to).contains(&part) { (i as f64).sin() } else { 0.0 }
            };
            Self {
                rows: (0..parts.len()).map(row).collect(),
                speeds: parts.iter().map(|part| (0..SAMPLES).map(|i| speed(*part, i)).collect()).collect(),
                zeros: vec![0.0; SAMPLES],
            }
        }
    }

    impl Experiment for Turns {
        fn rows(&self) -> &[Row] {
            &self.rows
        }
        fn time(&self) -> &[f64] {
            &self.zeros
        }
        fn residual(&self, _row: usize) -> &[f64] {
            &self.zeros
        }
        fn response(&self, _effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
            Vec::new()
        }
        fn candidates(&self) -> Vec<(&'static Kind, Location)> {
            Vec::new()
        }
        fn signals(&self, row: usize) -> Vec<(String, Vec<f64>)> {
            vec![("velocity".to_owned(), self.speeds[row].clone())]
        }
    }

    #[test]
    fn joints_that_move_in_turns_are_named() {
        // All of it, between two blocks that judge, within one that judges, and never.
        let log = Turns::new(&[[0.0, 1.0], [0.23, 0.43], [0.12, 0.21], [0.0, 0.0]]);
        let said = unshown(&log).unwrap();
        assert!(said.starts_with("joint_1, joint_2 move almost only in the parts"), "{said}");
        assert_eq!(unshown(&Turns::new(&[[0.0, 1.0], [0.1, 0.5]])), None);
    }
}
