//! The functions of a robot with a gait, by name.
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::lanes::F64x8;
use bipedc_runtime::model::{Argument, Model, State};

/// What a gait is beside its functions.
#[derive(Debug, Clone, PartialEq)]
pub struct GaitSettings {
    /// Number of gait parameters.
    pub parameters: usize,
    /// Number of outputs.
    pub outputs: usize,
    /// φ at which the guard is looked for, smallest and largest.
    pub between: [f64; 2],
    /// Whether h_p takes up what an impact leaves of the outputs and their rates.
    pub impact_matching: bool,
    /// Whether what is wanted depends on φ₊: only then does the end of a step depend on where it began.
    pub depends_on_start: bool,
    /// Name of the impact map in the model.
    pub impact_map: String,
    /// Contact points, by index: the one that stands, the one that lands.
    pub points: [usize; 2],
    /// q where an iteration for the constraint surface begins.
    pub posture: Vec<f64>,
    /// Coulomb's coefficient, if friction is measured against one.
    pub friction: Option<f64>,
    /// Largest torques of the joints, N m, where they have some.
    pub effort_limits: Vec<Option<f64>>,
    /// Stops of the joints, rad or m, where they have some.
    pub position_limits: Vec<Option<[f64; 2]>>,
    /// Largest speeds of the joints, rad/s or m/s, where they have some.
    pub velocity_limits: Vec<Option<f64>>,
}

impl GaitSettings {
    /// Smallest distance of a joint from its stops, rad or m; infinite without stops.
    pub(super) fn spare_joint(&self, q: &[f64]) -> f64 {
        spare_joint(&self.position_limits, q)
    }

    /// The same as a part of half the way between the stops of each joint, 1: in their middle; those that cannot move do not count.
    pub(super) fn spare_part(&self, q: &[f64]) -> f64 {
        let joints = &q[q.len().saturating_sub(self.position_limits.len())..];
        let spare = self.position_limits.iter().zip(joints).filter_map(|(limits, q)| {
            let [low, high] = limits.filter(|[low, high]| low < high)?;
            Some(2.0 * (q - low).min(high - q) / (high - low))
        });
        spare.fold(f64::INFINITY, f64::min)
    }
}

/// Smallest distance of the speeds of joints, the last of v, from their limits, rad/s or m/s; infinite without limits.
pub fn spare_velocity(limits: &[Option<f64>], v: &[f64]) -> f64 {
    let joints = &v[v.len().saturating_sub(limits.len())..];
    let spare = limits.iter().zip(joints).filter_map(|(limit, v)| limit.map(|limit| limit - v.abs()));
    spare.fold(f64::INFINITY, f64::min)
}

/// Smallest distance of joints, the last of q, from their stops, rad or m; infinite without stops.
pub fn spare_joint(limits: &[Option<[f64; 2]>], q: &[f64]) -> f64 {
    let joints = &q[q.len().saturating_sub(limits.len())..];
    let spare =
        limits.iter().zip(joints).filter_map(|(limits, q)| limits.map(|[low, high]| (q - low).min(high - q)));
    spare.fold(f64::INFINITY, f64::min)
}

/// Indices of functions in a model.
#[derive(Debug, Clone, Copy)]
pub(super) struct Functions {
    pub constraints: usize,
    pub jacobian: usize,
    pub slope: usize,
    pub curvature: usize,
    /// T, T′, T″ in closed form.
    pub surface: Option<usize>,
    pub controlled: usize,
    pub wanted: usize,
    pub guard: usize,
    pub zero_dynamics: usize,
    pub inverse_dynamics: usize,
    pub impact_map: usize,
    pub relabelled_configuration: usize,
    pub relabelled_velocity: usize,
    pub heights: usize,
    pub normals: usize,
}

/// A model with the functions of a gait: planar base, q and v alike.
#[derive(Clone)]
pub struct GaitModel<'a> {
    pub(super) model: &'a (dyn Model<f64> + Sync),
    /// The same eight times side by side.
    pub(super) wide: &'a (dyn Model<F64x8> + Sync),
    pub(super) functions: Functions,
    pub(super) settings: GaitSettings,
}

impl<'a> GaitModel<'a> {
    /// Looks the functions up.
    ///
    /// # Errors
    /// The model lacks one.
    pub fn new<M>(model: &'a M, settings: GaitSettings) -> Result<Self, Diagnostic>
    where
        M: Model<f64> + Model<F64x8> + Sync,
    {
        let (model, wide): (&(dyn Model<f64> + Sync), &(dyn Model<F64x8> + Sync)) = (model, model);
        let find = |name: &str| {
            model.function(name).ok_or_else(|| {
                Diagnostic::error(format!("the model has no function `{name}`"))
                    .help("it belongs to a robot with a gait")
            })
        };
        let functions = Functions {
            constraints: find("virtual_constraints")?,
            jacobian: find("virtual_constraints_jacobian")?,
            slope: find("virtual_constraints_slope")?,
            curvature: find("virtual_constraints_curvature")?,
            surface: model.function("surface"),
            controlled: find("controlled")?,
            wanted: find("wanted")?,
            guard: find("guard")?,
            zero_dynamics: find("zero_dynamics")?,
            inverse_dynamics: find("inverse_dynamics")?,
            impact_map: find(&settings.impact_map)?,
            relabelled_configuration: find("relabelled_configuration")?,
            relabelled_velocity: find("relabelled_velocity")?,
            heights: find("contact_distances")?,
            normals: find("contact_normal_directions")?,
        };
        Ok(Self { model, wide, functions, settings })
    }

    /// The same without a closed form of the constraint surface: it is found by iteration.
    #[must_use]
    pub fn iterating(mut self) -> Self {
        self.functions.surface = None;
        self
    }

    /// Length of q and of v.
    pub fn size(&self) -> usize {
        self.model.nv()
    }

    /// The arguments of a gait's functions: φ, φ₊, φ₋, parameters, no h_p.
    pub(super) fn arguments(&self, parameters: &[f64], [start, end]: [f64; 2]) -> Vec<f64> {
        let mut arguments = vec![start, start, end];
        arguments.extend_from_slice(parameters);
        arguments.resize(3 + self.settings.parameters + 2 * self.settings.outputs, 0.0);
        arguments
    }

    /// Calls a function. Lengths come from the model itself; a refusal would be a fault of this crate, seen in the numbers.
    pub(super) fn call(&self, function: usize, state: &State<'_, f64>) -> Vec<f64> {
        let size = self.model.signature(function).map_or(0, |s| s.rows * s.columns);
        let mut out = vec![0.0; size];
        if self.model.evaluate(function, state, &mut out).is_err() {
            out.fill(f64::NAN);
        }
        out
    }

    /// φ and φ̇ first, then h₀ and its rates, at any state.
    pub(super) fn controlled(&self, q: &[f64], v: &[f64]) -> Vec<[f64; 2]> {
        let state = State::new().with(Argument::Q, q).with(Argument::V, v);
        pairs(&self.call(self.functions.controlled, &state))
    }

    /// h_d and its slopes along φ.
    pub(super) fn wanted(&self, arguments: &[f64]) -> Vec<[f64; 2]> {
        pairs(&self.call(self.functions.wanted, &State::new().with(Argument::Parameters, arguments)))
    }

    /// α, β and γ of velocity and acceleration; α alone is the angular momentum about the foot at velocity v.
    pub(super) fn zero_dynamics(&self, q: &[f64], v: &[f64], a: &[f64]) -> [f64; 3] {
        let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::A, a);
        let found = self.call(self.functions.zero_dynamics, &state);
        found.try_into().unwrap_or([f64::NAN; 3])
    }
}

/// The rows of a matrix of two columns.
fn pairs(columns: &[f64]) -> Vec<[f64; 2]> {
    let (first, second) = columns.split_at(columns.len() / 2);
    first.iter().zip(second).map(|(&a, &b)| [a, b]).collect()
}
