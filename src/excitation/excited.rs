//! A robot ready for the design of motions.
use crate::identification::base_regressor;
use crate::robot::{ProgramRegressor, ProgramTorques, feet, joint_layout};
use bipedc_analysis::identify::excite::{CLEARANCE_FUNCTIONS, Clearance, Limits, Machine};
use bipedc_analysis::identify::joint;
use bipedc_analysis::robot::{BaseKind, JointLayout};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::model::{Joint, JointKind};
use bipedc_compiler::tree::Tree;
use bipedc_effects::diagnostic::Diagnostic;
use std::cell::RefCell;
use std::f64::consts::PI;

/// Everything that the design needs of a robot.
pub struct Excited {
    pub layout: JointLayout,
    pub regressor: ProgramRegressor,
    pub torques: ProgramTorques,
    /// Indices of the joints that move.
    pub moving: Vec<usize>,
    /// Indices of the joints that move or have an actuator.
    pub measured: Vec<usize>,
    /// Positions of those that do not move.
    pub posture: Vec<f64>,
    /// Of the joints that move.
    pub limits: Vec<Limits>,
    /// Feet that are kept apart.
    pub clearance: Option<Clearance>,
    /// What was taken for granted.
    pub assumptions: Vec<String>,
}

impl Excited {
    /// Derives what the moving joints' torques tell; no names: all joints with an actuator. Feet stay `gap` m apart.
    pub fn new(
        robot: &Robot,
        names: &[String],
        acceleration: Option<f64>,
        gap: f64,
    ) -> Result<Self, Diagnostic> {
        let tree = robot.tree()?;
        let layout = joint_layout(&tree)?;
        if layout.base != BaseKind::Fixed {
            return Err(Diagnostic::error("motions are designed for robots whose base is fixed")
                .help("bolt the robot down with --base fixed (and --root LINK)"));
        }
        let moving = moving(&tree, &layout, names)?;
        let measured =
            (0..tree.joints.len()).filter(|j| tree.joints[*j].actuated || moving.contains(j)).collect();
        let rigid = robot.clone().without_effects();
        let (_, regressor) = base_regressor(&rigid.description, &rigid.tree()?, &moving)?;
        let request = FunctionRequest::of_robot("inverse_dynamics");
        let torques = ProgramTorques::new(&robot.compile_only(&[request])?)?;
        let described = |name: &str| robot.description.joints.iter().find(|joint| joint.name == name);
        let mut assumptions = Vec::new();
        let joints: Vec<Option<&Joint>> = layout.joints.iter().map(|j| described(&j.name)).collect();
        let resting = |joint: &Option<&Joint>| {
            let (low, high) = joint.and_then(|j| j.position_limits).unwrap_or((0.0, 0.0));
            if low <= high { 0.0_f64.clamp(low, high) } else { 0.0 }
        };
        let posture = joints.iter().map(resting).collect();
        let limits = moving
            .iter()
            .map(|&k| limits_of(&layout.joints[k].name, joints[k], acceleration, &mut assumptions))
            .collect::<Result<_, _>>()?;
        let clearance = clearance(robot, gap, &mut assumptions)?;
        Ok(Self { layout, regressor, torques, moving, measured, posture, limits, clearance, assumptions })
    }
}

impl Excited {
    /// What moves within which limits.
    pub fn machine(&mut self) -> Machine<'_> {
        Machine {
            layout: &self.layout,
            regressor: &self.regressor,
            dynamics: RefCell::new(&mut self.torques),
            moving: &self.moving,
            posture: &self.posture,
            limits: &self.limits,
            clearance: self.clearance.as_ref(),
        }
    }
}

/// Indices of the named joints; no names: of all with an actuator.
fn moving(tree: &Tree, layout: &JointLayout, names: &[String]) -> Result<Vec<usize>, Diagnostic> {
    let actuated = (0..tree.joints.len()).filter(|&j| tree.joints[j].actuated);
    let mut moving = match names {
        [] => actuated.collect::<Vec<_>>(),
        names => names.iter().map(|name| joint(layout, name)).collect::<Result<_, _>>()?,
    };
    moving.sort_unstable();
    moving.dedup();
    if moving.is_empty() {
        return Err(
            Diagnostic::error("the robot has no joint with an actuator").help("name joints with --joints")
        );
    }
    Ok(moving)
}

/// Soles that are kept apart, if the robot has more than one; what is not kept is said.
fn clearance(
    robot: &Robot,
    gap: f64,
    assumptions: &mut Vec<String>,
) -> Result<Option<Clearance>, Diagnostic> {
    let described = &robot.description.feet;
    if described.len() < 2 || described.iter().any(|foot| foot.points.is_empty()) {
        return Ok(None);
    }
    let requests = CLEARANCE_FUNCTIONS.map(FunctionRequest::of_robot);
    let model = ProgramModel::new(robot.clone().without_effects().compile_only(&requests)?);
    let clearance = Clearance::new(Box::new(model), &feet(&robot.description), gap)?;
    if clearance.is_sagittal() {
        assumptions.push("no joint moves a foot sideways: the feet are not kept apart".to_owned());
        return Ok(None);
    }
    Ok(Some(clearance))
}

/// A joint's limits as described; what is assumed is said.
fn limits_of(
    name: &str,
    joint: Option<&Joint>,
    acceleration: Option<f64>,
    assumptions: &mut Vec<String>,
) -> Result<Limits, Diagnostic> {
    let position = match joint.and_then(|joint| joint.position_limits) {
        Some(limits) => limits,
        None if joint.is_some_and(|joint| joint.kind == JointKind::Prismatic) => {
            return Err(Diagnostic::error(format!("joint `{name}` slides and has no position limits"))
                .help("give it <limit lower=\"…\" upper=\"…\"/> in the URDF"));
        }
        None => {
            assumptions.push(format!("`{name}` has no position limits: -π to π rad"));
            (-PI, PI)
        }
    };
    let mut stated = |what: &str, limit: Option<f64>| {
        limit.unwrap_or_else(|| {
            assumptions.push(format!("`{name}` has no {what} limit: none is kept"));
            f64::INFINITY
        })
    };
    Ok(Limits {
        position,
        velocity: stated("velocity", joint.and_then(|joint| joint.velocity_limit)),
        effort: stated("effort", joint.and_then(|joint| joint.effort_limit)),
        acceleration: acceleration.unwrap_or(f64::INFINITY),
    })
}
