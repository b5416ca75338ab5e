//! The functions of a gait at eight phases at once: what a call costs is shared by all of them, and each has the bits of its own
//! call.
use super::course::Course;
use super::functions::GaitModel;
use super::step::Refusal;
use bipedc_runtime::Real;
use bipedc_runtime::lanes::F64x8;
use bipedc_runtime::model::{Argument, State};

/// Phases of one call.
pub(super) const LANES: usize = 8;

impl GaitModel<'_> {
    fn wide_call(&self, function: usize, state: &State<'_, F64x8>) -> Vec<F64x8> {
        let size = self.wide.signature(function).map_or(0, |s| s.rows * s.columns);
        let mut out = vec![F64x8::constant(0.0); size];
        if self.wide.evaluate(function, state, &mut out).is_err() {
            out.fill(F64x8::constant(f64::NAN));
        }
        out
    }

    /// T, T′ and T″ at eight phases, one after the other; `at_end`: of steps that end there. `None`: there is no closed form.
    fn wide_surface(
        &self,
        arguments: &mut [F64x8],
        phases: [f64; LANES],
        at_end: bool,
    ) -> Option<Vec<F64x8>> {
        let function = self.functions.surface?;
        arguments[0] = F64x8::from_array(phases);
        if at_end {
            arguments[2] = arguments[0];
        }
        Some(self.wide_call(function, &State::new().with(Argument::Parameters, arguments)))
    }

    /// The guard of steps that end at these phases; `None`: there is no closed form of the surface.
    pub(super) fn wide_guard(&self, arguments: &[f64], phases: [f64; LANES]) -> Option<[f64; LANES]> {
        let mut arguments = spread(arguments);
        let surface = self.wide_surface(&mut arguments, phases, true)?;
        let q = &surface[..self.size()];
        let state = State::new().with(Argument::Q, q).with(Argument::Parameters, &arguments);
        let guard = self.wide_call(self.functions.guard, &state).first()?.to_array();
        // As in a single call, a posture that is no number has no guard.
        let finite = surface.iter().map(|x| x.to_array().map(f64::is_finite));
        let exists = finite.fold([true; LANES], |all, x| std::array::from_fn(|k| all[k] && x[k]));
        Some(std::array::from_fn(|k| if exists[k] { guard[k] } else { f64::NAN }))
    }

    /// α, β and γ at eight phases; `None`: there is no closed form of the surface.
    fn wide_zero_dynamics(&self, arguments: &[f64], phases: [f64; LANES]) -> Option<[[f64; 3]; LANES]> {
        let surface = self.wide_surface(&mut spread(arguments), phases, false)?;
        let (q, slopes) = surface.split_at(self.size());
        let (slope, curvature) = slopes.split_at(self.size());
        let state = State::new().with(Argument::Q, q).with(Argument::V, slope).with(Argument::A, curvature);
        let found = self.wide_call(self.functions.zero_dynamics, &state);
        let [alpha, beta, gamma] = <[F64x8; 3]>::try_from(found).ok()?.map(F64x8::to_array);
        Some(std::array::from_fn(|k| [alpha[k], beta[k], gamma[k]]))
    }
}

impl Course<'_, '_> {
    /// α, β and γ at many phases (6.6).
    ///
    /// # Errors
    /// There is no such posture.
    pub fn zero_dynamics_at(&self, phases: &[f64]) -> Result<Vec<[f64; 3]>, Refusal> {
        let mut found = Vec::with_capacity(phases.len());
        for some in phases.chunks(LANES) {
            // The last phase fills lanes that would be empty.
            let lanes = std::array::from_fn(|k| some[k.min(some.len() - 1)]);
            let wide = self.gait.wide_zero_dynamics(&self.arguments, lanes);
            for (k, &phase) in some.iter().enumerate() {
                let known = wide.map(|wide| wide[k]).filter(|of| of.iter().all(|x| x.is_finite()));
                // What is no number is asked for again, to hear why.
                found.push(known.map_or_else(|| self.zero_dynamics(phase), Ok)?);
            }
        }
        Ok(found)
    }
}

fn spread(values: &[f64]) -> Vec<F64x8> {
    values.iter().map(|&x| F64x8::constant(x)).collect()
}
