//! Robots ready for [`bipedc_analysis::simulate`]: what is built into the true model, and what a simulation knows beside it.
pub mod absolute;
mod balance;
mod choosers;
mod chosen;
mod contact_sets;
mod energies;
mod estimated;
mod exchanged;
mod fastest;
mod footsteps;
mod gait;
mod late;
mod log;
mod returned;
mod robust;
mod run;
mod stepping;
mod told;
mod touching;
mod trial;
mod walking;

pub use chosen::{StepEnergy, WalkedSpeeds};
pub use estimated::EstimateErrors;
pub use fastest::FastestJoint;
pub use footsteps::FootstepSummary;
pub use returned::returned;
pub use robust::{Disturbance, DisturbanceKind, Robust, RobustOptions, Survival, Tried, wilson};
pub use run::{Options, Outcome, Scene, Simulated};
pub use trial::{Trial, WalkedMargins};

use crate::robot::{feet, joint_layout};
use bipedc_analysis::robot::Foot;
use bipedc_analysis::simulate::control::POINT_FUNCTIONS;
use bipedc_analysis::simulate::phases::{Ending, Landing, PhaseSpec, Row, RowKind, Walking};
use bipedc_analysis::simulate::{FUNCTIONS, Plant, Scenario, World};
use bipedc_compiler::compile::{CompiledModel, Function, FunctionRequest, ProgramModel};
use bipedc_compiler::description::model::{
    Contact, ContactPart, Foot as DescribedFoot, Phase, RobotDescription,
};
use bipedc_compiler::robot::Robot;
use bipedc_compiler::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Acts, Effect, Law};
use bipedc_runtime::model::Model;

/// Names, places and limits of a robot.
///
/// # Errors
/// A base that cannot be simulated.
pub fn plant(description: &RobotDescription, tree: &Tree) -> Result<Plant, Diagnostic> {
    if tree.base == BaseKind::Pivot {
        let message = "a robot on a pivot is not simulated: its contact could not let go";
        return Err(Diagnostic::error(message).help("choose another base with --base floating|planar|fixed"));
    }
    let of_urdf = |name: &str| description.joints.iter().find(|joint| joint.name == name);
    Ok(Plant {
        feet: feet(description),
        shapes: Vec::new(),
        links: description.links.iter().map(|link| link.name.clone()).collect(),
        position_limits: description.stops(tree.joints.iter().map(|joint| joint.name.as_str())),
        velocity_limits: description.velocity_limits(tree.joints.iter().map(|joint| joint.name.as_str())),
        effort_limits: tree
            .joints
            .iter()
            .map(|j| of_urdf(&j.name).and_then(|joint| joint.effort_limit))
            .collect(),
        effects: description.effects.clone(),
        phases: description.phases.iter().map(|phase| phase.name.clone()).collect(),
        actuated: actuated(description, tree),
        drives: tree.joints.iter().map(|joint| description.drive(&joint.name).copied()).collect(),
        gravity: description.gravity,
        layout: joint_layout(tree)?,
    })
}

/// The rigid-body functions of the robot as built: with those effects, of the description and hidden ones, that make
/// it another body. The simulation itself adds the others.
///
/// # Errors
/// Functions that cannot be derived.
pub fn true_model(robot: &Robot, hidden: &[Effect]) -> Result<ProgramModel, Diagnostic> {
    model_with(robot, hidden, &[])
}

/// The same with energies and centre of mass: what a film of the simulation shows ([`crate::film::Recorder`]).
///
/// # Errors
/// Functions that cannot be derived.
pub fn filmed_model(robot: &Robot, hidden: &[Effect]) -> Result<ProgramModel, Diagnostic> {
    model_with(robot, hidden, &FILM)
}

fn model_with(robot: &Robot, hidden: &[Effect], more: &[&str]) -> Result<ProgramModel, Diagnostic> {
    Ok(ProgramModel::new(as_built(robot, hidden, false)?.compile_only(&stepping_requests(robot, more)?)?))
}

/// The same with the functions of the phases too: for virtual constraints in time stepping. `film`: with what a film shows.
///
/// # Errors
/// Functions that cannot be derived.
pub fn driven_model(
    robot: &Robot,
    hidden: &[Effect],
    film: bool,
) -> Result<(ProgramModel, Vec<PhaseSpec>), Diagnostic> {
    let robot = as_built(robot, hidden, false)?;
    let mut requests = stepping_requests(&robot, if film { &FILM } else { &[] })?;
    requests.extend(phase_wishes(&robot.description));
    let compiled = robot.compile_only(&distinct(requests))?;
    let phases = phase_specs(&robot.description, &robot.tree()?, &compiled);
    Ok((ProgramModel::new(compiled), phases))
}

/// What a film shows beside poses and forces.
const FILM: [&str; 3] = ["kinetic_energy", "potential_energy", "center_of_mass"];

/// With those effects that make it another body, and, if `smooth`, the smooth ones in its joints.
fn as_built(robot: &Robot, hidden: &[Effect], smooth: bool) -> Result<Robot, Diagnostic> {
    let mut robot = robot.clone();
    robot.description.effects.extend_from_slice(hidden);
    let tree = robot.tree()?;
    let fixed = tree.base == BaseKind::Fixed;
    let plant = plant(&robot.description, &tree)?;
    robot.description.gravity = plant.gravity_on_ground(&plant.effects);
    robot.description.effects.retain(|effect| {
        let kind = effect.kind;
        match kind.law.acts() {
            Acts::Body => true,
            // A free robot is where it is, however the log's axes are turned.
            Acts::Gravity => fixed,
            Acts::Torque => smooth && kind.simulation.is_smooth() && kind.law != Law::Formula,
            _ => false,
        }
    });
    Ok(robot)
}

fn stepping_requests(robot: &Robot, more: &[&str]) -> Result<Vec<FunctionRequest>, Diagnostic> {
    let touches = !robot.description.feet.is_empty() && robot.tree()?.base != BaseKind::Fixed;
    let functions = if touches { &FUNCTIONS[..] } else { &FUNCTIONS[..2] };
    let mut requests: Vec<_> = functions.iter().chain(more).map(|family| request(family, None)).collect();
    if touches {
        requests.extend(sole_wishes(&robot.description));
    }
    Ok(requests)
}

/// How the soles are turned, for the moments on them.
fn sole_wishes(description: &RobotDescription) -> Vec<FunctionRequest> {
    let of = |foot: &DescribedFoot| request("rotation", Some(&foot.link));
    distinct(description.feet.iter().map(of).collect())
}

/// The robot under another gravity, on a slope: gravity is turned instead of the ground.
#[must_use]
pub fn in_world(mut robot: Robot, world: &World) -> Robot {
    let gravity = &mut robot.description.gravity;
    if let Some(size) = world.gravity {
        *gravity = [0.0, 0.0, -size];
    }
    if world.slope != 0.0 {
        let size = gravity.iter().map(|x| x * x).sum::<f64>().sqrt();
        *gravity = [size * world.slope.sin(), 0.0, -size * world.slope.cos()];
    }
    robot
}

/// Joints with actuators, in the order of the description's actuators.
fn actuated(description: &RobotDescription, tree: &Tree) -> Vec<usize> {
    let place = |name: &String| tree.joints.iter().position(|joint| joint.name == *name);
    description.actuated_joints.iter().filter_map(place).collect()
}

/// A robot with phases, for the event-driven simulation.
#[derive(Debug, Clone)]
pub struct Walker {
    /// Constrained dynamics, impacts, contact points.
    pub model: ProgramModel,
    /// The same of the robot with its sides exchanged, where that is another one.
    pub exchanged: Option<ProgramModel>,
    /// In the order of the description.
    pub phases: Vec<PhaseSpec>,
    /// Further sets of contacts, if the walk may follow them.
    pub sets: Vec<PhaseSpec>,
    /// In the order of the model's contact points.
    pub feet: Vec<Foot>,
    /// How it hangs in the world.
    pub base: BaseKind,
}

impl Walker {
    /// What it shall do in a scenario.
    pub fn walking<'a>(&'a self, plant: &'a Plant, scenario: &'a Scenario) -> Walking<'a> {
        let exchanged = self.exchanged.as_ref().map(|model| model as &dyn Model<f64>);
        Walking { model: &self.model, exchanged, phases: &self.phases, sets: &self.sets, plant, scenario }
    }
}

/// The phases of a description with their functions and endings.
///
/// A phase ends when a point reaches the ground that holds just after the change (`impact`, else the next phase's contacts);
/// without such a point, when a foot that stands now is let go, or begins to tip about what remains of it.
///
/// # Errors
/// No phases; a base that has none; functions that cannot be derived.
pub fn walker(robot: &Robot) -> Result<Walker, Diagnostic> {
    walker_with(robot, Vec::new(), false)
}

/// `following`: with all sets of contacts, in the plane.
fn walker_with(
    robot: &Robot,
    mut requests: Vec<FunctionRequest>,
    following: bool,
) -> Result<Walker, Diagnostic> {
    let mut robot = robot.clone();
    let (tree, described) = (robot.tree()?, robot.description.phases.len());
    if described == 0 {
        return Err(Diagnostic::error("the robot has no phases").help("add [[phase]] tables to biped.toml"));
    }
    let planar = tree.base == BaseKind::Planar;
    let sets = if following && planar { contact_sets::sets(&robot.description) } else { Vec::new() };
    robot.description.phases.extend(sets.iter().cloned());
    let (robot, description) = (&robot, &robot.description);
    let base = plant(description, &tree)?.layout.base;
    requests.extend(phase_wishes(description));
    let requests = distinct(requests);
    let compiled = robot.compile_only(&requests)?;
    let mut phases = phase_specs(description, &tree, &compiled);
    let sets = contact_sets::named(phases.split_off(described), &sets);
    let other = exchanged::exchanged(robot)?;
    let exchanged = other.map(|other| other.compile_only(&requests)).transpose()?.map(ProgramModel::new);
    Ok(Walker { phases, sets, feet: feet(description), base, model: ProgramModel::new(compiled), exchanged })
}

/// The same of the robot as built: with hidden effects that make it another body, and smooth ones in its joints.
/// `film`: with what a film shows.
///
/// # Errors
/// As [`walker`].
pub fn true_walker(robot: &Robot, hidden: &[Effect], film: bool) -> Result<Walker, Diagnostic> {
    walker_as_built(robot, hidden, film, false)
}

/// The same for a scenario, which may have its phases follow the contacts.
///
/// # Errors
/// As [`walker`].
pub fn walker_for(robot: &Robot, scenario: &Scenario, film: bool) -> Result<Walker, Diagnostic> {
    let events = scenario.events.as_ref();
    let following = events.is_some_and(|events| events.assumptions.follows == Some(true));
    walker_as_built(robot, &scenario.effects, film, following)
}

fn walker_as_built(
    robot: &Robot,
    hidden: &[Effect],
    film: bool,
    following: bool,
) -> Result<Walker, Diagnostic> {
    let robot = as_built(robot, hidden, true)?;
    let more = if film { stepping_requests(&robot, &FILM)? } else { Vec::new() };
    walker_with(&robot, more, following)
}

/// Every request once.
fn distinct(requests: Vec<FunctionRequest>) -> Vec<FunctionRequest> {
    let mut found: Vec<FunctionRequest> = Vec::with_capacity(requests.len());
    for request in requests {
        let same =
            |other: &FunctionRequest| other.family == request.family && other.subject == request.subject;
        if !found.iter().any(same) {
            found.push(request);
        }
    }
    found
}

/// Functions that phases, their controllers and their verdicts need.
fn phase_wishes(description: &RobotDescription) -> Vec<FunctionRequest> {
    let mut requests: Vec<FunctionRequest> =
        POINT_FUNCTIONS.iter().map(|family| request(family, None)).collect();
    requests.push(request("inverse_dynamics", None));
    requests.extend(sole_wishes(description));
    for phase in &description.phases {
        requests.push(request("constrained_dynamics", Some(&phase.name)));
        if !phase.impact.is_empty() {
            requests.push(request("impact_map", Some(&phase.name)));
        }
    }
    if description.phases.iter().any(|phase| phase.relabel) {
        requests.extend(["relabelled_configuration", "relabelled_velocity"].map(|f| request(f, None)));
    }
    requests
}

fn phase_specs(description: &RobotDescription, tree: &Tree, compiled: &CompiledModel) -> Vec<PhaseSpec> {
    // By subject: names of functions are written small, and numbered where two phases would share one.
    let function = |family: &str, phase: &Phase| -> (String, Vec<Row>) {
        let wanted = |f: &&Function| f.family == family && f.subject.as_ref() == Some(&phase.name);
        let Some(found) = compiled.functions.iter().find(wanted) else { return Default::default() };
        let names = &found.rows[tree.nv.min(found.rows.len())..];
        (found.name.clone(), names.iter().filter_map(|name| row(description, name)).collect())
    };
    let landing = |phase: &Phase| {
        let (map, rows) = function("impact_map", phase);
        Landing { rows, standing: points(description, &phase.impact), map }
    };
    let spec = |phase: &Phase| {
        let (dynamics, rows) = function("constrained_dynamics", phase);
        PhaseSpec {
            rows,
            standing: points(description, &phase.contacts),
            ending: ending(description, phase),
            impact: (!phase.impact.is_empty()).then(|| landing(phase)),
            relabel: phase.relabel,
            next: description.phases.iter().position(|other| other.name == phase.next).unwrap_or(0),
            name: phase.name.clone(),
            dynamics,
        }
    };
    description.phases.iter().map(spec).collect()
}

fn request(family: &str, subject: Option<&str>) -> FunctionRequest {
    FunctionRequest { family: family.to_owned(), subject: subject.map(str::to_owned) }
}

/// `right_foot/force/z` as a row.
fn row(description: &RobotDescription, name: &str) -> Option<Row> {
    let (foot, kind) = name.split_once('/')?;
    let foot = description.feet.iter().position(|other| other.name == foot)?;
    Some(Row { foot, kind: RowKind::named(kind) })
}

/// Indices of the contact points that stand.
fn points(description: &RobotDescription, contacts: &[Contact]) -> Vec<usize> {
    let mut found = Vec::new();
    let mut first = 0;
    for foot in &description.feet {
        for contact in contacts.iter().filter(|contact| contact.foot == foot.name) {
            let stands = |name: &str| match &contact.part {
                ContactPart::Flat => true,
                ContactPart::Point(point) => point == name,
                ContactPart::Edge(edge) => foot
                    .edges
                    .iter()
                    .any(|other| other.name == *edge && other.points.iter().any(|p| p == name)),
            };
            let own = foot.points.iter().enumerate().filter(|(_, point)| stands(&point.name));
            found.extend(own.map(|(index, _)| first + index));
        }
        first += foot.points.len();
    }
    found
}

fn ending(description: &RobotDescription, phase: &Phase) -> Ending {
    let now = points(description, &phase.contacts);
    let next = description.phases.iter().find(|other| other.name == phase.next);
    let after = if phase.impact.is_empty() {
        next.map_or(Vec::new(), |next| points(description, &next.contacts))
    } else {
        points(description, &phase.impact)
    };
    let new: Vec<usize> = after.iter().copied().filter(|point| !now.contains(point)).collect();
    if !new.is_empty() {
        return Ending::Touch(new);
    }
    let mut first = 0;
    for (index, foot) in description.feet.iter().enumerate() {
        let own = first..first + foot.points.len();
        first = own.end;
        let before = now.iter().filter(|point| own.contains(point)).count();
        let kept: Vec<usize> = after.iter().copied().filter(|point| own.contains(point)).collect();
        if kept.len() < before {
            return if kept.is_empty() { Ending::Release(index) } else { Ending::Tip(index, kept) };
        }
    }
    Ending::Never
}
