//! Calls of a model's functions, looked up by name.
use crate::robot::{BaseKind, JointLayout};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::model::{Argument, Model, State};
use nalgebra::Vector3;

/// A model whose functions can be called from several threads.
pub type AnyModel<'a> = &'a (dyn Model<f64> + Sync);

/// Calls with slices of the right length.
#[derive(Clone, Copy)]
pub(crate) struct ModelCalls<'a> {
    model: AnyModel<'a>,
    pub nq: usize,
    pub nv: usize,
}

impl<'a> ModelCalls<'a> {
    pub fn new(model: AnyModel<'a>) -> Self {
        Self { model, nq: model.nq(), nv: model.nv() }
    }

    /// A function's index.
    pub fn find(&self, name: &str) -> Result<usize, Diagnostic> {
        self.model.function(name).ok_or_else(|| {
            Diagnostic::error(format!("the model has no function `{name}`"))
                .help("add it to what is generated from the description")
        })
    }

    /// Columns of a function's result.
    pub fn columns(&self, function: usize) -> usize {
        self.model.signature(function).map_or(0, |s| s.columns)
    }

    /// A function of the configuration.
    pub fn at(&self, function: usize, q: &[f64], out: &mut [f64]) {
        self.moving(function, q, &[], &[], out);
    }

    /// A function of the motion.
    pub fn moving(&self, function: usize, q: &[f64], v: &[f64], a: &[f64], out: &mut [f64]) {
        let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::A, a);
        // Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
        if self.model.evaluate(function, &state, out).is_err() {
            out.fill(f64::NAN);
        }
    }

    /// The base at the origin, upright; all joints at zero.
    pub fn rest(&self, base: BaseKind) -> Vec<f64> {
        let mut q = base.rest().to_vec();
        q.resize(self.nq, 0.0);
        q
    }
}

/// Gravitational acceleration in world axes (m/s²) and total mass (kg), as the model has them.
///
/// Found from the force that holds the robot up at rest, so that nothing but the model is needed.
pub(crate) fn gravity(calls: &ModelCalls<'_>, base: BaseKind, mass: f64) -> Result<Vector3<f64>, Diagnostic> {
    let function = calls.find("inverse_dynamics")?;
    let still = vec![0.0; calls.nv];
    let mut tau = still.clone();
    calls.moving(function, &calls.rest(base), &still, &still, &mut tau);
    let force = match base {
        BaseKind::Floating => Vector3::new(tau[0], tau[1], tau[2]),
        BaseKind::Planar => Vector3::new(tau[0], 0.0, tau[1]),
        // A fixed base tells nothing of gravity: upright on Earth.
        BaseKind::Fixed | BaseKind::Pivot => return Ok(Vector3::new(0.0, 0.0, -9.81)),
    };
    let gravity = -force / mass;
    if gravity.norm() > 0.0 && gravity.norm().is_finite() {
        return Ok(gravity);
    }
    Err(Diagnostic::error("the model has no weight: forces on its feet tell nothing")
        .help("check the masses and the gravity of the description"))
}

/// The base's rows of `v` in the words of measurements: name after `base/`, whether it is a force row.
pub(crate) fn base_rows(base: BaseKind) -> &'static [(&'static str, bool)] {
    match base {
        BaseKind::Fixed | BaseKind::Pivot => &[],
        BaseKind::Planar => &[("x", true), ("z", true), ("y", false)],
        BaseKind::Floating => {
            &[("x", true), ("y", true), ("z", true), ("x", false), ("y", false), ("z", false)]
        }
    }
}

/// Index of the joint of this name.
pub(crate) fn joint(layout: &JointLayout, name: Option<&str>) -> Option<usize> {
    layout.joints.iter().position(|joint| Some(joint.name.as_str()) == name)
}
