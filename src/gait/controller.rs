//! Walking by a gait in process: its controller, and states to begin with.
use super::{Assignment, GaitBench, Parametrised};
use bipedc_compiler::compile::GaitPrograms;
pub use bipedc_compiler::compile::ProgramController;
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_runtime::control::{Feedback, GaitController, Refusal};
use bipedc_runtime::{Argument, Model, State};
use std::borrow::Cow;

impl GaitBench {
    /// The gait's controller (6.3) with these parameters instead of the gait's own; no step has begun.
    ///
    /// # Errors
    /// Parameters that the gait does not have, numbers that are none; a constraint surface without a closed form.
    pub fn controller(
        &self,
        feedback: Feedback<f64>,
        set: &[Assignment],
    ) -> Result<ProgramController, Diagnostics> {
        let values = self.values(set)?;
        let programs = GaitPrograms::new(&self.compiled, &self.gait)
            .map_err(|error| Diagnostics(vec![error.or_in_file(&self.file)]))?;
        let mut controller = GaitController::new(programs, feedback);
        values
            .iter()
            .enumerate()
            .try_for_each(|(index, &value)| controller.ask(index, value))
            .map_err(|refusal: Refusal| Diagnostic::error(refusal.to_string()).in_file(&self.file))?;
        Ok(controller)
    }

    /// The gait's parameters with some of them replaced.
    ///
    /// # Errors
    /// Parameters that the gait does not have, numbers that are none.
    pub fn values(&self, set: &[Assignment]) -> Result<Vec<f64>, Diagnostics> {
        let defaults: Vec<f64> = self.gait.parameters.iter().map(|parameter| parameter.default).collect();
        self.with(&defaults, set)
    }

    /// The gait's guard as a function of q and of the parameters.
    pub fn guard(&self) -> impl Fn(&[f64], &[f64]) -> f64 {
        let model = self.model.clone();
        let first = self.compiled.arguments.parameter(0);
        let empty = vec![0.0; self.compiled.arguments.len()];
        let guard = Model::<f64>::function(&model, "guard");
        move |q, values| {
            let mut arguments = empty.clone();
            arguments[first..][..values.len()].copy_from_slice(values);
            let state = State::new().with(Argument::Q, q).with(Argument::Parameters, &arguments);
            let mut value = [f64::NAN];
            // A refusal would be a fault of ours, seen in the number.
            let known = guard.is_some_and(|guard| model.evaluate(guard, &state, &mut value).is_ok());
            if known { value[0] } else { f64::NAN }
        }
    }

    /// q and v at the beginning of a step that follows others of its own kind and passes its dead centre at this speed (per s):
    /// just after an impact, the foot that stands at the origin, legs named by their roles.
    ///
    /// # Errors
    /// There is no such step.
    pub fn beginning(&self, values: &[f64], speed: f64) -> Result<[Vec<f64>; 2], Diagnostic> {
        let refused = |why: Cow<'_, str>| {
            Diagnostic::error(format!("the gait `{}` has no step at {speed} per s: {why}", self.gait.name))
                .in_file(&self.file)
                .help("`bipedc gait step` says what is possible")
        };
        let model = self.model()?;
        let course = model.steady_course(values).map_err(|why| refused(why.to_string().into()))?;
        let start = course.start;
        let point = course.surface(start).map_err(|why| refused(why.to_string().into()))?;
        let [rate, _] =
            course.rates(start, course.energy(speed)).map_err(|why| refused(why.to_string().into()))?;
        if !(rate > 0.0 && rate.is_finite()) {
            return Err(refused("it would begin at rest, or backwards".into()));
        }
        let velocity = point.slope.iter().map(|slope| slope * rate).collect();
        Ok([point.q, velocity])
    }
}
