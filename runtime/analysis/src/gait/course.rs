//! One step on the zero dynamics: its energy (6.7–6.13), its dead centre (6.18).
use super::functions::GaitModel;
use super::integral::{Integral, Places};
use super::landing::Landing;
use super::search::zero;
use super::step::Refusal;
use super::surface::SurfacePoint;
use bipedc_runtime::model::{Argument, State};
use std::cell::RefCell;

/// Outputs (m, rad) that are zero but for rounding.
const CLOSE: f64 = 1e-8;

/// Part of the step over which postures are told ahead by their slopes.
const NEARBY: f64 = 0.1;

/// A step from φ₊ to φ₋.
#[derive(Clone)]
pub struct Course<'a, 'm> {
    pub(super) gait: &'m GaitModel<'a>,
    /// How it ends.
    pub landing: Landing,
    /// φ₊.
    pub start: f64,
    /// Arguments of the gait's functions; φ, the first, is any.
    pub(super) arguments: Vec<f64>,
    potential: Integral,
    /// Phase, α and α γ at both ends and wherever the integral asked, from φ₊ to φ₋.
    samples: Vec<[f64; 3]>,
    /// φ_m: where P is largest.
    pub dead_centre: f64,
    /// P at the dead centre, (kg m²/s)².
    pub p_max: f64,
    /// P₋: P at the end.
    pub p_minus: f64,
    /// α at the dead centre, kg m² per unit of φ.
    pub alpha_m: f64,
    /// Where the iteration for the surface was last, and at what phase; before it was anywhere, where the step begins.
    last: RefCell<(f64, SurfacePoint)>,
}

/// Where a step begins, on its constraints or not: h_p takes up what is left.
#[derive(Debug, Clone, Copy)]
pub(super) struct Beginning<'q> {
    /// Legs named by their roles.
    pub q: &'q [f64],
    /// In the unit in which `rate` is the phase velocity.
    pub v: &'q [f64],
    /// φ₊.
    pub start: f64,
    /// φ̇.
    pub rate: f64,
}

impl Landing {
    /// Just after it.
    pub(super) fn beginning(&self) -> Beginning<'_> {
        Beginning { q: &self.q, v: &self.v, start: self.start, rate: self.eta }
    }
}

impl<'a> GaitModel<'a> {
    /// The step with these parameters that begins after a landing.
    ///
    /// # Errors
    /// Why there is none.
    pub fn course(&self, parameters: &[f64], after: &Landing) -> Result<Course<'a, '_>, Refusal> {
        let landing = if after.parameters == parameters && !self.settings.depends_on_start {
            after.clone()
        } else {
            self.landing(parameters, after.start)?
        };
        self.course_to(parameters, after.beginning(), landing)
    }

    /// The rest of a step that takes these parameters in a state (q: nq, v: nv), from its φ on.
    ///
    /// # Errors
    /// Why there is none.
    pub fn course_from(&self, parameters: &[f64], q: &[f64], v: &[f64]) -> Result<Course<'a, '_>, Refusal> {
        let [start, rate] = self.phase_at(q, v);
        let landing = self.landing(parameters, start)?;
        self.course_to(parameters, Beginning { q, v, start, rate }, landing)
    }

    /// φ and φ̇ of a state.
    pub fn phase_at(&self, q: &[f64], v: &[f64]) -> [f64; 2] {
        self.controlled(q, v).first().copied().unwrap_or([f64::NAN; 2])
    }

    /// A state (q: nq, v: nv) with left and right exchanged.
    pub fn relabelled(&self, q: &[f64], v: &[f64]) -> [Vec<f64>; 2] {
        let functions = &self.functions;
        let q = self.call(functions.relabelled_configuration, &State::new().with(Argument::Q, q));
        let v = self.call(functions.relabelled_velocity, &State::new().with(Argument::V, v));
        [q, v]
    }

    /// The angular momentum σ about the foot that stands, kg m²/s.
    pub fn momentum(&self, q: &[f64], v: &[f64]) -> f64 {
        self.zero_dynamics(q, v, v)[0]
    }

    /// The same where its own landing is known.
    pub(super) fn course_to(
        &self,
        parameters: &[f64],
        after: Beginning<'_>,
        landing: Landing,
    ) -> Result<Course<'a, '_>, Refusal> {
        let (start, end) = (after.start, landing.end);
        if !start.is_finite() || !after.rate.is_finite() || start >= end {
            return Err(Refusal::NoPhaseLeft([start, end]));
        }
        let mut arguments = self.arguments(parameters, [start, end]);
        self.match_impact(&mut arguments, &after)?;
        let mut course = Course {
            gait: self,
            landing,
            start,
            arguments,
            potential: Integral::of([0.0, 0.0], |_| Ok::<Places, Refusal>([0.0; 15]))?,
            samples: Vec::new(),
            dead_centre: start,
            p_max: 0.0,
            p_minus: 0.0,
            alpha_m: f64::NAN,
            last: RefCell::new((start, SurfacePoint::at_rest(after.q))),
        };
        let ends = course.samples_at(&[start, end])?;
        let mut samples = vec![ends[0]];
        course.potential = Integral::of([start, end], |places| {
            let found = course.samples_at(places)?;
            samples.extend_from_slice(&found);
            Ok::<_, Refusal>(std::array::from_fn(|k| found[k][2]))
        })?;
        samples.push(ends[1]);
        samples.sort_by(|a, b| a[0].total_cmp(&b[0]));
        course.samples = samples;
        course.p_minus = course.potential.whole();
        course.find_dead_centre()?;
        Ok(course)
    }

    /// A step that follows one with the same parameters, and is followed by one.
    ///
    /// # Errors
    /// Why there is none.
    pub fn steady_course(&self, parameters: &[f64]) -> Result<Course<'a, '_>, Refusal> {
        let landing = self.steady_landing(parameters)?;
        self.course(parameters, &landing)
    }

    /// Value and slope of h_p at φ₊: what is left of the outputs and their rates there (below 6.2). Without it the outputs themselves
    /// have to vanish; their rates are then made to, by torques, which leave the angular momentum as it is.
    fn match_impact(&self, arguments: &mut [f64], after: &Beginning<'_>) -> Result<(), Refusal> {
        let controlled = self.controlled(after.q, after.v);
        let wanted = self.wanted(arguments);
        let first = 3 + self.settings.parameters;
        let mut jump = 0.0_f64;
        for (index, ([value, rate], [goal, slope])) in controlled.iter().skip(1).zip(&wanted).enumerate() {
            // A jump that is no number stays one.
            jump = if jump.is_nan() { jump } else { (value - goal).abs().max(jump) };
            if self.settings.impact_matching {
                arguments[first + 2 * index] = value - goal;
                arguments[first + 2 * index + 1] = rate / after.rate - slope;
            }
        }
        if self.settings.impact_matching || jump <= CLOSE { Ok(()) } else { Err(Refusal::OutputsJump(jump)) }
    }
}

impl Course<'_, '_> {
    /// q, T′ and T″ at a phase.
    ///
    /// # Errors
    /// There is no such posture.
    pub fn surface(&self, phase: f64) -> Result<SurfacePoint, Refusal> {
        let mut arguments = self.arguments.clone();
        arguments[0] = phase;
        let refused = |why| Refusal::NoPosture(phase, why);
        if self.gait.functions.surface.is_some() {
            return self.gait.surface(&arguments, &[]).map_err(refused);
        }
        let near = {
            let (from, point) = &*self.last.borrow();
            let by = phase - from;
            // Far away the tangent leads farther astray than the posture itself.
            let nearby = by.abs() <= NEARBY * (self.landing.end - self.start);
            if nearby { point.ahead(by) } else { point.q.clone() }
        };
        let found = self.gait.surface(&arguments, &near).map_err(refused)?;
        *self.last.borrow_mut() = (phase, found.clone());
        Ok(found)
    }

    /// Arguments of the gait's functions at a phase.
    pub fn arguments(&self, phase: f64) -> Vec<f64> {
        let mut arguments = self.arguments.clone();
        arguments[0] = phase;
        arguments
    }

    /// α, β and γ at a phase (6.6).
    ///
    /// # Errors
    /// There is no such posture.
    pub fn zero_dynamics(&self, phase: f64) -> Result<[f64; 3], Refusal> {
        let point = self.surface(phase)?;
        let found = self.gait.zero_dynamics(&point.q, &point.slope, &point.curvature);
        if found.iter().all(|x| x.is_finite()) { Ok(found) } else { Err(Refusal::NotFinite(phase)) }
    }

    /// α γ, the slope of P.
    fn force(&self, phase: f64) -> Result<f64, Refusal> {
        self.zero_dynamics(phase).map(|[alpha, _, gamma]| alpha * gamma)
    }

    /// P(φ) = ∫ α γ dφ from φ₊ (6.10), (kg m²/s)².
    ///
    /// # Errors
    /// There is no such posture.
    pub fn potential(&self, phase: f64) -> Result<f64, Refusal> {
        self.potential.at(phase, |places| {
            let found = self.samples_at(places)?;
            Ok(std::array::from_fn(|k| found[k][2]))
        })
    }

    /// Each phase with α and α γ.
    fn samples_at(&self, phases: &[f64]) -> Result<Vec<[f64; 3]>, Refusal> {
        let found = self.zero_dynamics_at(phases)?;
        Ok(phases
            .iter()
            .zip(found)
            .map(|(&phase, [alpha, _, gamma])| [phase, alpha, alpha * gamma])
            .collect())
    }

    /// Bound of the error of all values of P.
    pub fn potential_error(&self) -> f64 {
        self.potential.error()
    }

    /// φ₊ and φ₋.
    pub fn ends(&self) -> [f64; 2] {
        [self.start, self.landing.end]
    }

    /// Where P is largest: at an end, or where its slope passes zero downwards.
    fn find_dead_centre(&mut self) -> Result<(), Refusal> {
        let mut best = if self.p_minus > 0.0 { (self.landing.end, self.p_minus) } else { (self.start, 0.0) };
        for pair in self.samples.windows(2) {
            let ([before, _, rising], [after, _, falling]) = (pair[0], pair[1]);
            if rising > 0.0 && falling <= 0.0 {
                let slope = |phase| self.force(phase).unwrap_or(f64::NAN);
                let place = zero(slope, (before, rising), (after, falling));
                let height = self.potential(place)?;
                if height > best.1 {
                    best = (place, height);
                }
            }
        }
        (self.dead_centre, self.p_max) = best;
        self.alpha_m = self.zero_dynamics(self.dead_centre)?[0];
        Ok(())
    }

    /// A place where α vanishes or changes sign: the momentum says nothing of φ̇ there.
    pub fn singular(&self) -> Option<f64> {
        self.samples.iter().find(|[_, alpha, _]| alpha.is_nan() || *alpha <= 0.0).map(|[phase, ..]| *phase)
    }

    /// E of a step that passes its dead centre at this speed (6.12, 6.19).
    pub fn energy(&self, speed: f64) -> f64 {
        0.5 * (self.alpha_m * speed).powi(2) + self.p_max
    }

    /// The speed φ̇_m at the dead centre with this energy; `None`: it does not get there (6.13).
    pub fn speed(&self, energy: f64) -> Option<f64> {
        let kinetic = energy - self.p_max;
        (kinetic > 0.0).then(|| (2.0 * kinetic).sqrt() / self.alpha_m.abs()).filter(|speed| speed.is_finite())
    }

    /// φ̇ and φ̈ at a phase with this energy (6.6, 6.12).
    ///
    /// # Errors
    /// There is no such posture; it does not get there.
    pub fn rates(&self, phase: f64, energy: f64) -> Result<[f64; 2], Refusal> {
        let [alpha, beta, gamma] = self.zero_dynamics(phase)?;
        let kinetic = energy - self.potential(phase)?;
        if kinetic < 0.0 {
            return Err(Refusal::FallsBack { energy, needed: self.p_max });
        }
        let rate = (2.0 * kinetic).sqrt() / alpha;
        Ok([rate, -(beta * rate * rate + gamma) / alpha])
    }
}
