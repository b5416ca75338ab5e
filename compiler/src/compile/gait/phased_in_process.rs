//! A gait of several phases for a controller in process, and what such a controller has to know of it.
use super::phased::CompiledPhases;
use super::phased_surface::held_count;
use crate::compile::ProgramModel;
use crate::description::gait::{GaitParameter, PhasedGait};
use crate::description::model::{Contact, ContactPart, Foot, Phase, RobotDescription};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_runtime::control::{self, MOST_FEET, PhaseLayout, PhaseSurfaceLayout, PhasedLayout, StandingFoot};
use bipedc_runtime::{Argument, CallError, Model, Signature, State};

/// What a foot that is to push carries at least, as a part of the robot's weight.
const LEAST_PUSH: f64 = 0.025;

/// The programs of a robot with a gait of several phases; the same interface as emitted code.
#[derive(Debug, Clone)]
pub struct PhasePrograms {
    model: ProgramModel,
    layout: PhasedLayout,
    phases: Vec<PhaseLayout>,
    parameters: Vec<GaitParameter>,
    effort_limits: Vec<Option<f64>>,
}

impl CompiledPhases {
    /// Sizes of the gait.
    pub fn layout(&self, gait: &PhasedGait) -> PhasedLayout {
        let gravity = self.description.gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        PhasedLayout {
            parameters: gait.parameters.len(),
            joints: self.model.tree.joints.len(),
            phases: gait.phases.len(),
            outputs: gait.phases.iter().map(|phase| phase.outputs.len()).max().unwrap_or(0),
            forces: self.forces.iter().map(Vec::len).max().unwrap_or(0),
            friction: gait.limits.friction,
            least_push: LEAST_PUSH * gravity * self.model.tree.total_mass(),
        }
    }

    /// What a controller has to know of a phase.
    ///
    /// # Errors
    /// A function or phase is missing: a fault of the compiler; more feet stand than a controller has room for.
    pub fn phase(&self, gait: &PhasedGait, index: usize) -> Result<PhaseLayout, Diagnostic> {
        let of = &gait.phases[index];
        let missing = |what: &str| Diagnostic::error(format!("the gait `{}` has no {what}", gait.name));
        let need = |family: &str| {
            let wanted =
                |f: &crate::compile::Function| f.family == family && f.subject.as_ref() == Some(&of.name);
            self.model
                .functions
                .iter()
                .position(wanted)
                .ok_or_else(|| missing(&format!("function `{family}`")))
        };
        let phases = &self.description.phases;
        let number = phases.iter().position(|phase| phase.name == of.name).ok_or_else(|| missing("phase"))?;
        Ok(PhaseLayout {
            phase: number,
            outputs: of.outputs.len(),
            forces: self.forces[index].len(),
            controlled: need("controlled")?,
            wanted: need("wanted")?,
            end: need("phase_end")?,
            feedforward: need("feedforward")?,
            lie_derivatives: need("lie_derivatives")?,
            surface: PhaseSurfaceLayout {
                held: held_count(&self.description, &phases[number]),
                equations: need("surface_equations")?,
                slopes: need("surface_slopes")?,
                rates: need("surface_rates")?,
                curvatures: need("surface_curvatures")?,
            },
            rate_ratio: need("rate_ratio")?,
            impact_matching: of.impact_matching,
            feedback: of.feedback,
            feet: feet(&self.description, &phases[number], &self.forces[index])?,
        })
    }

    /// The largest torques of the joints, in the order of `v`, as far as the URDF says some.
    pub fn effort_limits(&self) -> Vec<Option<f64>> {
        let of_urdf =
            |name: &str| self.description.joints.iter().find(|joint| joint.name == name)?.effort_limit;
        self.model.tree.joints.iter().map(|joint| of_urdf(&joint.name)).collect()
    }
}

/// The feet that stand in a phase; `forces` are the names of its forces.
pub(super) fn feet(
    description: &RobotDescription,
    phase: &Phase,
    forces: &[String],
) -> Result<[Option<StandingFoot>; MOST_FEET], Diagnostic> {
    let mut found = [None; MOST_FEET];
    let mut count = 0;
    for foot in &description.feet {
        let place = |kind: &str| forces.iter().position(|name| *name == format!("{}/{kind}", foot.name));
        let (Some(x), Some(z)) = (place("force/x"), place("force/z")) else { continue };
        let Some(room) = found.get_mut(count) else {
            let message = format!("more than {MOST_FEET} feet stand in phase `{}`", phase.name);
            return Err(Diagnostic::error(message).help("a controller's work and memory are bounded"));
        };
        let kept = kept(description, phase, foot);
        let sole = sole(foot);
        *room = Some(StandingFoot {
            force: [x, z],
            moment: place("moment/y"),
            sole: sole.map(|(x, _)| x),
            holds: kept.as_ref().is_none_or(|kept| !kept.is_empty()),
            level: sole.map(|(_, end)| !kept.as_ref().is_some_and(|kept| kept.contains(&end))),
        });
        count += 1;
    }
    Ok(found)
}

/// Names of the points of a foot that go on standing, where a phase ends by letting some of them go; `None`: it ends otherwise.
fn kept<'d>(description: &'d RobotDescription, phase: &Phase, foot: &'d Foot) -> Option<Vec<&'d str>> {
    let next = description.phases.iter().find(|other| other.name == phase.next)?;
    let after = if phase.impact.is_empty() { &next.contacts } else { &phase.impact };
    let lands = description.feet.iter().any(|foot| {
        let now = standing(foot, &phase.contacts);
        standing(foot, after).iter().any(|point| !now.contains(point))
    });
    let (now, then) = (standing(foot, &phase.contacts), standing(foot, after));
    (!lands && then.len() < now.len()).then_some(then)
}

/// Names of the points of a foot that contacts hold.
pub(super) fn standing<'d>(foot: &'d Foot, contacts: &[Contact]) -> Vec<&'d str> {
    let own = || contacts.iter().filter(|contact| contact.foot == foot.name);
    let holds = |point: &str| {
        own().any(|contact| match &contact.part {
            ContactPart::Flat => true,
            ContactPart::Point(name) => name == point,
            ContactPart::Edge(name) => foot
                .edges
                .iter()
                .any(|edge| edge.name == *name && edge.points.iter().any(|other| other == point)),
        })
    };
    foot.points.iter().map(|point| point.name.as_str()).filter(|name| holds(name)).collect()
}

/// x (from the middle of all points, m) and name of the rearmost and of the foremost point of a sole.
fn sole(foot: &Foot) -> [(f64, &str); 2] {
    let xs = || foot.points.iter().map(|point| point.position[0]);
    let middle = xs().sum::<f64>() / foot.points.len().max(1) as f64;
    let named = || foot.points.iter().map(|point| (point.position[0] - middle, point.name.as_str()));
    let rear = named().min_by(|a, b| a.0.total_cmp(&b.0));
    let front = named().max_by(|a, b| a.0.total_cmp(&b.0));
    [rear.unwrap_or((0.0, "")), front.unwrap_or((0.0, ""))]
}

impl PhasePrograms {
    /// Prepares them.
    ///
    /// # Errors
    /// As [`CompiledPhases::phase`].
    pub fn new(compiled: &CompiledPhases, gait: &PhasedGait) -> Result<Self, Diagnostic> {
        let phases = (0..gait.phases.len()).map(|index| compiled.phase(gait, index));
        Ok(Self {
            layout: compiled.layout(gait),
            phases: phases.collect::<Result<_, _>>()?,
            parameters: gait.parameters.clone(),
            effort_limits: compiled.effort_limits(),
            model: ProgramModel::new(compiled.model.clone()),
        })
    }
}

impl<R> Model<R> for PhasePrograms
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

impl<R: bipedc_runtime::Real> control::PhasedGait<R> for PhasePrograms
where
    ProgramModel: Model<R>,
{
    type Memory = Vec<R>;

    fn memory(&self) -> Vec<R> {
        vec![R::constant(0.0); self.layout.memory()]
    }
    fn layout(&self) -> PhasedLayout {
        self.layout
    }
    fn phase(&self, index: usize) -> Option<PhaseLayout> {
        self.phases.get(index).copied()
    }
    fn parameter(&self, index: usize) -> Option<control::GaitParameter<'_>> {
        let GaitParameter { name, unit, default, bounds, .. } = self.parameters.get(index)?;
        Some(control::GaitParameter { name, unit, default: *default, bounds: *bounds })
    }
    fn effort_limit(&self, joint: usize) -> Option<f64> {
        self.effort_limits.get(joint).copied().flatten()
    }
}
