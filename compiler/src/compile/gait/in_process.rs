//! A gait for a controller in process.
use super::CompiledGait;
use crate::compile::ProgramModel;
use crate::description::gait::{Gait, GaitParameter};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{self, GaitLayout, StepEnd};
use bipedc_runtime::{Argument, CallError, Model, Signature, State};

/// The programs of a robot with a gait; the same interface as emitted code.
#[derive(Debug, Clone)]
pub struct GaitPrograms {
    model: ProgramModel,
    layout: GaitLayout,
    parameters: Vec<GaitParameter>,
    posture: Vec<f64>,
    effort_limits: Vec<Option<f64>>,
}

impl CompiledGait {
    /// What a controller has to know of the functions.
    ///
    /// # Errors
    /// A function is missing: a fault of the compiler.
    pub fn layout(&self, gait: &Gait) -> Result<GaitLayout, Diagnostic> {
        let place = |name: &str| self.model.functions.iter().position(|function| function.name == name);
        let need = |name: &str| {
            let missing = || Diagnostic::error(format!("the gait `{}` has no function `{name}`", gait.name));
            place(name).ok_or_else(missing)
        };
        Ok(GaitLayout {
            parameters: gait.parameters.len(),
            outputs: gait.phase.outputs.len(),
            controlled: need("controlled")?,
            wanted: need("wanted")?,
            lie_derivatives: need("lie_derivatives")?,
            step_end: match place("step_end") {
                Some(step_end) => StepEnd::Closed(step_end),
                None => StepEnd::Iterated {
                    constraints: need("virtual_constraints")?,
                    jacobian: need("virtual_constraints_jacobian")?,
                    guard: need("guard")?,
                },
            },
            between: gait.phase.guard.between,
            impact_matching: gait.phase.impact_matching,
        })
    }

    /// q where an iteration for the constraint surface begins.
    pub fn posture(&self, gait: &Gait) -> Vec<f64> {
        let mut posture = vec![0.0; self.model.tree.nq];
        for joint in &self.model.tree.joints {
            // On a planar base q and v have the same places.
            posture[joint.v_index] = gait.phase.posture.get(&joint.name).copied().unwrap_or(0.0);
        }
        posture
    }

    /// The largest torques of the joints, in the order of `v`, as far as the URDF says some.
    pub fn effort_limits(&self) -> Vec<Option<f64>> {
        let of_urdf =
            |name: &str| self.description.joints.iter().find(|joint| joint.name == name)?.effort_limit;
        self.model.tree.joints.iter().map(|joint| of_urdf(&joint.name)).collect()
    }
}

impl GaitPrograms {
    /// Prepares them.
    ///
    /// # Errors
    /// As [`CompiledGait::layout`].
    pub fn new(compiled: &CompiledGait, gait: &Gait) -> Result<Self, Diagnostic> {
        Ok(Self {
            layout: compiled.layout(gait)?,
            parameters: gait.parameters.clone(),
            posture: compiled.posture(gait),
            effort_limits: compiled.effort_limits(),
            model: ProgramModel::new(compiled.model.clone()),
        })
    }
}

impl<R> Model<R> for GaitPrograms
where
    ProgramModel: Model<R>,
{
    fn nq(&self) -> usize {
        self.model.nq()
    }
    fn nv(&self) -> usize {
        self.model.nv()
    }
    fn joint_name(&self, index: usize) -> Option<&str> {
        self.model.joint_name(index)
    }
    fn joints(&self) -> usize {
        self.model.joints()
    }
    fn signature(&self, index: usize) -> Option<Signature<'_>> {
        self.model.signature(index)
    }
    fn argument_length(&self, argument: Argument) -> usize {
        self.model.argument_length(argument)
    }
    fn evaluate(&self, function: usize, state: &State<'_, R>, output: &mut [R]) -> Result<(), CallError> {
        self.model.evaluate(function, state, output)
    }
}

impl<R: bipedc_runtime::Real> control::Gait<R> for GaitPrograms
where
    ProgramModel: Model<R>,
{
    type Memory = Vec<R>;

    fn memory(&self) -> Vec<R> {
        vec![R::constant(0.0); self.layout.memory()]
    }
    fn layout(&self) -> GaitLayout {
        self.layout
    }
    fn parameter(&self, index: usize) -> Option<control::GaitParameter<'_>> {
        let GaitParameter { name, unit, default, bounds, .. } = self.parameters.get(index)?;
        Some(control::GaitParameter { name, unit, default: *default, bounds: *bounds })
    }
    fn posture(&self, index: usize) -> f64 {
        self.posture.get(index).copied().unwrap_or(0.0)
    }
    fn effort_limit(&self, joint: usize) -> Option<f64> {
        self.effort_limits.get(joint).copied().flatten()
    }
}
