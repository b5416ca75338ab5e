//! One step of several phases, and what its energies say of the next (6.35–6.37).
use super::{Chain, PhaseEnergy};
use crate::gait::{Assignment, PhasedBench};
use bipedc_analysis::simulate::phases::{Ending, End, PhaseSpec, Precision, Start, walk};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::magnitude;
use bipedc_runtime::{Argument, State};
use serde::Serialize;

/// A step that takes longer than this does not come to its end, s.
const LONGEST: f64 = 20.0;
/// Places at which the end of a phase is looked for.
const LOOKS: usize = 60;

/// What step is asked for.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct ChainOptions {
    /// Speed φ̇_m at the dead centre of the first phase, per s.
    pub speed: f64,
    /// Parameters that are not the gait's own.
    pub set: Vec<Assignment>,
}

/// A phase of a step.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainedPhase {
    /// As the gait calls it.
    pub name: String,
    /// φ₊
    pub phi_start: f64,
    /// φ₋
    pub phi_end: f64,
    /// φ̇₊, per s.
    pub speed_start: f64,
    /// φ̇₋, per s.
    pub speed_end: f64,
    /// s
    pub duration: f64,
    /// ν = K₊ of the next phase over K₋ of this one (6.35).
    pub nu: f64,
    /// P₋, (unit of φ/s)².
    pub p_minus: f64,
    /// Torques were held to a limit on the way: what (6.32) says of ν and P₋ holds without.
    pub limited: bool,
}

/// A step with what comes of it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ChainStep {
    /// φ̇_m of this step, per s.
    pub speed: f64,
    /// φ̇_m of the next step, per s; none if it is not passed.
    pub next_speed: Option<f64>,
    /// φ_m
    pub phi_m: f64,
    /// δ of the step: product of all ν (6.37).
    pub delta: Option<f64>,
    /// P₋ of the step (6.37), (unit of φ/s)².
    pub p_minus: Option<f64>,
    /// E = φ̇₊²/2 where the step begins, (unit of φ/s)².
    pub energy: f64,
    /// The same of the next step.
    pub next_energy: Option<f64>,
    /// s
    pub duration: Option<f64>,
    /// Whether all phases come to their ends and the next step passes its dead centre.
    pub feasible: bool,
    /// Why not.
    pub reason: Option<String>,
    /// In order.
    pub phases: Vec<ChainedPhase>,
    /// Unit of φ.
    #[serde(skip)]
    pub unit: String,
}

impl PhasedBench {
    /// A step that follows one which ended as its own formulas say, and passes the dead centre of its first phase at a speed; `specs`
    /// are the phases of the robot's description.
    ///
    /// # Errors
    /// Parameters that the gait does not have, numbers that are none; no posture at the beginning of the step.
    pub fn step(&self, specs: &[PhaseSpec], options: &ChainOptions) -> Result<ChainStep, Diagnostics> {
        let speed = options.speed;
        if !(speed > 0.0 && speed <= magnitude::LARGEST) {
            let help = "write the speed at mid-stance, above 0, in the unit of the phase variable per second";
            return Err(Diagnostic::error(format!("a speed of {speed} is not possible")).help(help).into());
        }
        let values = self.values(&options.set)?;
        let chain = Chain::new(self, specs, self.controller(None, &options.set)?)
            .map_err(|error| error.or_in_file(&self.file))?;
        let found = chain.nominal(&values).and_then(|[q, direction]| chain.step((&q, &direction), speed));
        Ok(found.map_err(|error| error.or_in_file(&self.file))?)
    }
}

impl Chain<'_> {
    /// q and q̇ (of a step's whole robot, at this φ̇_m) where a step begins that follows one which ended as its own formulas say.
    ///
    /// # Errors
    /// There is no such posture.
    pub fn beginning(&self, values: &[f64], speed: f64) -> Result<[Vec<f64>; 2], Diagnostic> {
        let [q, direction] = self.nominal(values)?;
        let rate = self.first_rate((&q, &direction), speed)?.0;
        Ok([q, direction.iter().map(|slope| slope * rate).collect()])
    }

    /// φ̇₊ of the step that begins at q along a direction (per φ̇) and passes its dead centre at a speed; and φ_m.
    fn first_rate(&self, (q, direction): (&[f64], &[f64]), speed: f64) -> Result<(f64, f64), Diagnostic> {
        let first = self.first()?;
        let [start, _] = self.begin(first, q, direction)?;
        let end = self.present.borrow().controller.status().ends[1];
        let [phi, psi, potential] = PhaseEnergy::new(self, first, [start, end])?.dead_centre();
        // φ̇² = ψ (φ̇₊² − 2 P)
        Ok(((speed * speed / psi + 2.0 * potential).sqrt(), phi))
    }

    fn first(&self) -> Result<usize, Diagnostic> {
        self.bench.compiled.phase(&self.bench.gait, 0).map(|layout| layout.phase)
    }

    fn step(&self, (q, direction): (&[f64], &[f64]), speed: f64) -> Result<ChainStep, Diagnostic> {
        let (rate, phi_m) = self.first_rate((q, direction), speed)?;
        let v: Vec<f64> = direction.iter().map(|slope| slope * rate).collect();
        let mut found = ChainStep {
            speed,
            next_speed: None,
            phi_m,
            delta: None,
            p_minus: None,
            energy: 0.5 * rate * rate,
            next_energy: None,
            duration: None,
            feasible: false,
            reason: None,
            phases: Vec::new(),
            unit: self.bench.gait.phases[0].unit.clone(),
        };
        let mut now = (self.first()?, self.begin(self.first()?, q, &v)?);
        for _ in 0..self.bench.gait.phases.len() {
            match self.one_phase(now.0, now.1)? {
                Ok((phase, next)) => {
                    found.phases.push(phase);
                    now = next;
                }
                Err(why) => {
                    found.reason = Some(why);
                    return Ok(found);
                }
            }
        }
        self.summed(&mut found, now)
    }

    /// δ, P₋ and the speed of the next step.
    fn summed(&self, found: &mut ChainStep, (phase, [start, rate]): (usize, [f64; 2])) -> Result<ChainStep, Diagnostic> {
        let (mut delta, mut p_minus) = (1.0, 0.0);
        for phase in &found.phases {
            p_minus += phase.p_minus / delta;
            delta *= phase.nu;
        }
        (found.delta, found.p_minus) = (Some(delta), Some(p_minus));
        found.next_energy = Some(0.5 * rate * rate);
        found.duration = Some(found.phases.iter().map(|phase| phase.duration).sum());
        let end = self.present.borrow().controller.status().ends[1];
        let [_, psi, potential] = PhaseEnergy::new(self, phase, [start, end])?.dead_centre();
        let square = psi * (rate * rate - 2.0 * potential);
        if square > 0.0 {
            (found.next_speed, found.feasible) = (Some(square.sqrt()), true);
        } else {
            found.reason = Some("the next step falls back before its dead centre".to_owned());
        }
        Ok(found.clone())
    }

    /// A phase to its end, and the beginning of the next; or why it has none.
    #[allow(clippy::type_complexity, reason = "a phase, then the next with its state")]
    fn one_phase(
        &self,
        phase: usize,
        x: [f64; 2],
    ) -> Result<Result<(ChainedPhase, (usize, [f64; 2])), String>, Diagnostic> {
        let name = self.phase(phase)?.spec.name.clone();
        let start = Start { time: 0.0, phase, x: x.to_vec() };
        let precision = Precision { relative: 1e-11, absolute: 1e-11, ..Precision::default() };
        self.present.borrow_mut().limited = false;
        // The energies belong to this phase: they are found before the next one begins.
        let mut ended = None;
        let walked = walk(&Once { chain: self, ended: &mut ended.into() }, start, LONGEST, 1, &precision, &mut |_, _, _| {});
        let _ = (walked, name, &mut ended);
        unimplemented!()
    }
}
