//! A controller as a computer runs it: asked at sampling instants, with noisy and late measurements, its torques held in between.
use bipedc_effects::random::Random;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use std::collections::VecDeque;

/// What lies between a robot and its controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Instruments {
    /// Between samples, s.
    pub period: f64,
    /// Samples by which commands are late.
    pub late: usize,
    /// Standard deviations of the noise of q (rad, m) and v (per s).
    pub noise: [f64; 2],
}

/// Runs another controller at sampling instants.
pub(super) struct Sampled<C> {
    inner: C,
    instruments: Instruments,
    random: Random,
    next: f64,
    /// What was measured: time, phase, q, v; the last one is the newest.
    measured: VecDeque<(f64, usize, Vec<f64>, Vec<f64>)>,
    held: Vec<JointCommand<f64>>,
}

impl<C: Controller<f64>> Sampled<C> {
    pub fn new(inner: C, instruments: Instruments, seed: u64) -> Self {
        let (measured, held) = (VecDeque::new(), Vec::new());
        Self { inner, instruments, random: Random::new(seed), next: 0.0, measured, held }
    }

    fn measure(&mut self, observed: &Observation<'_, f64>) {
        let [position, velocity] = self.instruments.noise;
        let mut noisy = |values: &[f64], deviation: f64| -> Vec<f64> {
            values.iter().map(|x| x + deviation * self.random.normal()).collect()
        };
        let (q, v) = (noisy(observed.q, position), noisy(observed.v, velocity));
        self.measured.push_back((observed.time, observed.phase, q, v));
        while self.measured.len() > self.instruments.late + 1 {
            self.measured.pop_front();
        }
        self.next = observed.time + self.instruments.period;
    }

    /// Torques from what was measured last or, late, before.
    fn compute(&mut self, joints: usize) -> Result<(), Refusal> {
        let Some((time, phase, q, v)) = self.measured.front() else { return Err(Refusal::NoStep) };
        self.held.clear();
        self.held.resize(joints, JointCommand::Off);
        self.inner.command(&Observation::new(*time, *phase, q, v), &mut self.held)
    }
}

impl<C: Controller<f64>> Controller<f64> for Sampled<C> {
    fn command(
        &mut self,
        _: &Observation<'_, f64>,
        commands: &mut [JointCommand<f64>],
    ) -> Result<(), Refusal> {
        if self.held.len() != commands.len() {
            self.compute(commands.len())?;
        }
        commands.copy_from_slice(&self.held);
        Ok(())
    }

    /// A landing is noticed at once; what was measured before has the legs' old names.
    fn begin_phase(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        self.measured.clear();
        self.held.clear();
        self.measure(observed);
        let Some((time, phase, q, v)) = self.measured.back().cloned() else { return Ok(()) };
        self.inner.begin_phase(&Observation::new(time, phase, &q, &v))
    }

    fn before_event(&mut self, observed: &Observation<'_, f64>) -> Option<f64> {
        Some(self.next - observed.time)
    }

    fn at_event(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
        let joints = self.held.len();
        self.measure(observed);
        if let Some((time, phase, q, v)) = self.measured.back().cloned() {
            let measured = Observation::new(time, phase, &q, &v);
            if self.inner.before_event(&measured).is_some_and(|before| before <= 0.0) {
                self.inner.at_event(&measured)?;
            }
        }
        if joints > 0 { self.compute(joints) } else { Ok(()) }
    }
}
