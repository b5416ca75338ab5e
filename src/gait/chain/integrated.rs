//! A chain as whoever integrates phases sees it.
use super::Chain;
use bipedc_analysis::simulate::phases::{Passage, Phased, Violation};

/// So many changes of the limits that hold torques are followed by long steps again in one phase.
const MOST_KINKS: usize = 200;

impl Phased for Chain<'_> {
    fn derivative(&self, phase: usize, _: f64, x: &[f64], out: &mut [f64]) {
        let found = self.heard(self.motion(phase, [x[0], x[1]]));
        out[0] = x[1];
        out[1] = found.map_or(f64::NAN, |motion| motion.acceleration);
    }

    fn guard(&self, phase: usize, _: f64, x: &[f64]) -> f64 {
        self.heard(self.guarded(phase, [x[0], x[1]])).unwrap_or(f64::NAN)
    }

    fn violation(&self, phase: usize, time: f64, x: &[f64]) -> Option<Violation> {
        if let Some(motion) = self.heard(self.motion(phase, [x[0], x[1]])) {
            let present = &mut *self.present.borrow_mut();
            (present.limited, present.missed) =
                (present.limited | motion.limited, present.missed | motion.missed);
            let before = present.mode.replace(motion.mode);
            present.kinked = before.is_some_and(|before| before != motion.mode) && present.kinks < MOST_KINKS;
            present.kinks += usize::from(present.kinked);
        }
        let spec = &self.phase(phase).ok()?.spec;
        (x[1] <= 0.0).then(|| Violation {
            phase: spec.name.clone(),
            time,
            quantity: "rate of the phase variable".to_owned(),
            value: x[1],
            limit: 0.0,
            unit: "1/s",
            meaning: "the step falls back",
        })
    }

    fn has_kink_behind(&self) -> bool {
        self.present.borrow().kinked
    }

    fn change(&self, phase: usize, time: f64, x: &mut [f64], _: &mut Vec<f64>) -> Result<Passage, Violation> {
        match self.changed(phase, [x[0], x[1]]) {
            Ok((next, state)) => {
                x.copy_from_slice(&state);
                Ok(next.into())
            }
            Err(why) => {
                let quantity = why.to_string();
                self.refusal.borrow_mut().get_or_insert(why);
                let phase = self.phases[phase].as_ref().map_or_else(String::new, |of| of.spec.name.clone());
                Err(Violation {
                    phase,
                    time,
                    quantity,
                    value: x[1],
                    limit: 0.0,
                    unit: "1/s",
                    meaning: "the next phase cannot begin",
                })
            }
        }
    }
}
