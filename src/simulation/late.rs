//! Readings that come late to a controller.
use bipedc_runtime::control::Observation;
use std::collections::VecDeque;

/// An observation that is kept.
#[derive(Debug, Clone, Default)]
pub(super) struct Told {
    time: f64,
    q: Vec<f64>,
    v: Vec<f64>,
    loads: Vec<f64>,
    centers: Vec<[f64; 2]>,
    inertial: Option<[[f64; 3]; 2]>,
    motors: Vec<f64>,
}

impl Told {
    pub fn observed(&self) -> Observation<'_, f64> {
        let observed = Observation::new(self.time, 0, &self.q, &self.v);
        let observed = observed.with_loads(&self.loads).with_centers(&self.centers).with_motors(&self.motors);
        match self.inertial {
            Some(inertial) => observed.with_inertial(inertial),
            None => observed,
        }
    }
}

/// What was observed in the last steps.
#[derive(Debug, Clone, Default)]
pub(super) struct Late(VecDeque<Told>);

impl Late {
    /// Notes what is observed; what was so many steps ago, or at first.
    pub fn after(&mut self, steps: usize, observed: &Observation<'_, f64>) -> &Told {
        let spare = if self.0.len() > steps { self.0.pop_front() } else { None };
        let mut told = spare.unwrap_or_default();
        (told.time, told.inertial) = (observed.time, observed.inertial);
        told.q.clear();
        told.q.extend(observed.q);
        told.v.clear();
        told.v.extend(observed.v);
        told.loads.clear();
        told.loads.extend(observed.loads);
        told.centers.clear();
        told.centers.extend(observed.centers);
        told.motors.clear();
        told.motors.extend(observed.motors);
        self.0.push_back(told);
        &self.0[0]
    }
}
