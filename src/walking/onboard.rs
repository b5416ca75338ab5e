//! What a robot's controller has to know of it to walk on flat feet: its functions, legs, soles, sizes.
use super::legs::Legs;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::model::RobotDescription;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::drive::Drive;
use bipedc_effects::effect::{Law, Simulation};
use bipedc_runtime::Model;
use bipedc_runtime::in_process::AnyModel;
use bipedc_runtime::walking::estimator::Settings;
use bipedc_runtime::walking::robot::{LEG, Leg, MOST_VELOCITIES, WalkingRobot};
use bipedc_runtime::walking::space::Pose;
use bipedc_runtime::walking::steps::Stride;
use bipedc_runtime::walking::{Gains, OnBoardWalker, WalkingController};

/// Functions about the whole robot.
const WHOLE: [&str; 4] = ["mass_matrix", "bias", "center_of_mass", "center_of_mass_velocity"];
/// Functions about the link of a foot.
const FRAME: [&str; 4] = ["position", "rotation", "jacobian", "jacobian_rate_times_velocity"];

/// A robot's controller of walks, with the functions that it calls, in process.
#[derive(Debug, Clone)]
pub struct FootstepWalker {
    model: ProgramModel,
    robot: WalkingRobot<f64>,
    gains: Gains<f64>,
    /// N
    weight: f64,
    /// As it stands when it walks, in the order of `q`.
    pub posture: Vec<f64>,
}

impl FootstepWalker {
    /// Of a robot that walks.
    ///
    /// # Errors
    /// Functions that cannot be derived, legs that have not six joints, too many joints.
    pub fn new(legs: &Legs) -> Result<Self, Diagnostic> {
        let mut requests: Vec<FunctionRequest> = WHOLE.map(FunctionRequest::of_robot).into();
        // One family after the other: emitted code has a module for each.
        for family in FRAME {
            let of =
                |link: &String| FunctionRequest { family: family.to_owned(), subject: Some(link.clone()) };
            requests.extend(legs.links.iter().map(of));
        }
        let model = ProgramModel::new(legs.robot.compile_only(&requests)?);
        let robot = walking_robot(legs, &model)?;
        let links = legs.robot.description.links.iter();
        let mass: f64 = links.filter_map(|link| link.inertial).map(|body| body.mass).sum();
        let weight = legs.kinematics.gravity() * mass;
        let gains = gains(legs, weight);
        Ok(Self { model, robot, gains, weight, posture: legs.posture.clone() })
    }

    /// Height of its centre of mass when it walks, m.
    pub fn height(&self) -> f64 {
        self.gains.height
    }

    /// The functions, the robot, the numbers of its controller.
    pub fn parts(&self) -> (&ProgramModel, &WalkingRobot<f64>, &Gains<f64>) {
        (&self.model, &self.robot, &self.gains)
    }

    /// What its estimator assumes of sensors and ground.
    pub fn estimator(&self) -> Settings<f64> {
        Settings { gravity: self.robot.gravity, ..Settings::of_weight(self.weight) }
    }

    /// Estimator and controller.
    pub fn on_board(&self, settings: Settings<f64>) -> OnBoardWalker<AnyModel<'_>, f64> {
        OnBoardWalker::new(&self.model, self.robot.clone(), self.gains, settings)
    }

    /// The controller.
    pub fn controller(&self) -> WalkingController<AnyModel<'_>, f64> {
        WalkingController::new(&self.model, self.robot.clone(), self.gains)
    }
}

fn walking_robot(legs: &Legs, model: &ProgramModel) -> Result<WalkingRobot<f64>, Diagnostic> {
    let functions = &model.compiled().functions;
    let find = |family: &str, subject: Option<&str>| {
        let found = functions.iter().position(|f| f.family == family && f.subject.as_deref() == subject);
        found.ok_or_else(|| Diagnostic::error(format!("the robot has no function `{family}`")))
    };
    let nv = Model::<f64>::nv(model);
    if nv > MOST_VELOCITIES {
        let message =
            format!("the robot has {} joints; the controller of walks knows {}", nv - 6, MOST_VELOCITIES - 6);
        return Err(Diagnostic::error(message).help("lock some: [joints] locked = { ... } in biped.toml"));
    }
    let leg = |k: usize| {
        let own: Vec<usize> = legs.bodies[k].iter().filter_map(|body| column(legs, *body)).collect();
        let joints: [usize; LEG] = own.as_slice().try_into().map_err(|_| {
            let message = format!(
                "the leg of `{}` has {} joints; the controller of walks knows legs of six",
                legs.feet[k],
                own.len()
            );
            Diagnostic::error(message)
        })?;
        let sole = &legs.soles[k];
        let ends = |i: usize| {
            sole.corners.iter().fold([f64::MAX, f64::MIN], |e, c| [e[0].min(c[i]), e[1].max(c[i])])
        };
        let ([rear, front], [right, left]) = (ends(0), ends(1));
        let rows = |m: &nalgebra::Matrix3<f64>| [0, 1, 2].map(|i| [m[(i, 0)], m[(i, 1)], m[(i, 2)]]);
        let feet = &legs.robot.description.feet;
        Ok::<_, Diagnostic>(Leg {
            position: find(FRAME[0], Some(&legs.links[k]))?,
            rotation: find(FRAME[1], Some(&legs.links[k]))?,
            jacobian: find(FRAME[2], Some(&legs.links[k]))?,
            jacobian_rate: find(FRAME[3], Some(&legs.links[k]))?,
            joints,
            sole: Pose { position: sole.center.into(), turn: rows(&sole.axes) },
            extent: [rear, front, right, left],
            knee: joints[3],
            bends: if legs.posture[joints[3] + 1] < 0.0 { -1.0 } else { 1.0 },
            foot: feet.iter().position(|foot| foot.name == legs.feet[k]).unwrap_or(k),
        })
    };
    let mut torque = [f64::INFINITY; MOST_VELOCITIES];
    let mut posture = [0.0; MOST_VELOCITIES];
    for joint in &legs.joints {
        torque[joint.column - 6] = joint.effort;
        posture[joint.column - 6] = legs.posture[joint.column + 1];
    }
    let [stiffness, motor_inertia] = springs(legs);
    let sensors = legs.feet.each_ref().map(|foot| load_sensor(&legs.robot.description, foot));
    let heading = &legs.heading;
    Ok(WalkingRobot {
        legs: [leg(0)?, leg(1)?],
        mass_matrix: find(WHOLE[0], None)?,
        bias: find(WHOLE[1], None)?,
        center_of_mass: find(WHOLE[2], None)?,
        center_of_mass_velocity: find(WHOLE[3], None)?,
        heading: [0, 1, 2].map(|i| [heading[(i, 0)], heading[(i, 1)], heading[(i, 2)]]),
        lengths: [Model::<f64>::nq(model), nv],
        gravity: legs.kinematics.gravity(),
        torque,
        posture,
        stiffness,
        motor_inertia,
        load_gain: sensors.map(|[gain, _]| gain),
        load_bias: sensors.map(|[_, bias]| bias),
    })
}

/// Of the spring between each joint and its motor, and of that motor: N m/rad, kg m² as seen at the joint.
fn springs(legs: &Legs) -> [[f64; MOST_VELOCITIES]; 2] {
    let description = &legs.robot.description;
    let mut stiffness = [f64::INFINITY; MOST_VELOCITIES];
    let mut inertia = [0.0; MOST_VELOCITIES];
    for joint in &legs.joints {
        let drive = description.drive(&joint.name).filter(|drive| drive.has_motor());
        let mut softness = drive.map_or(0.0, |drive| drive.stiffness_at_joint().recip());
        let mut rotor = drive.map_or(0.0, Drive::rotor_inertia_at_joint);
        for effect in description.effects.iter().filter(|e| e.location.joint.as_ref() == Some(&joint.name)) {
            match (effect.kind.law, effect.kind.simulation) {
                (Law::SeriesElasticity, _) => softness += effect.value("stiffness").recip(),
                (_, Simulation::Inertia(name)) => rotor += effect.value(name),
                _ => {}
            }
        }
        let place = joint.column - 6;
        (stiffness[place], inertia[place]) = (softness.recip(), rotor);
    }
    [stiffness, inertia]
}

/// What a foot's sensor reports per newton of the normal force, and beside it (N).
fn load_sensor(description: &RobotDescription, foot: &str) -> [f64; 2] {
    let mut reported = [1.0, 0.0];
    for effect in &description.effects {
        if effect.location.sensor.as_deref().is_some_and(|sensor| sensor != foot) {
            continue;
        }
        match effect.kind.law {
            Law::ForceSensorGain => reported = reported.map(|part| effect.value("gain") * part),
            Law::ForceSensorBias => reported[1] += effect.value("z"),
            _ => {}
        }
    }
    reported
}

/// Column in `v` of the joint that moves a body.
fn column(legs: &Legs, body: usize) -> Option<usize> {
    let name = &legs.tree.bodies[body].joint;
    legs.joints.iter().find(|joint| joint.name == *name).map(|joint| joint.column)
}

fn gains(legs: &Legs, weight: f64) -> Gains<f64> {
    let settings = &legs.settings;
    let leg = legs.leg_length();
    let gravity = legs.kinematics.gravity();
    let omega = (gravity / settings.com_height).sqrt();
    let half = legs.soles.iter().flat_map(|sole| sole.corners.iter()).map(|c| c[1].abs()).fold(0.0, f64::max);
    let scale = (leg / 0.6).sqrt();
    Gains {
        stride: Stride {
            time: settings.step_time,
            shortest: 0.6 * settings.step_time,
            easy: 0.42 * leg,
            double_support: settings.double_support,
            width: settings.stance_width,
            longest: 0.5 * leg,
            across: [2.0 * half + settings.feet_distance, settings.stance_width + 0.35 * leg],
            largest_turn: 0.35,
            change: 0.1,
            punctual: 1.0,
            strict: 20.0,
            soonest: 0.1,
            patience: 0.3,
            speed: 1.2,
            agility: 60.0,
            omega,
        },
        height: settings.com_height,
        lift: settings.step_height,
        margin: settings.margin,
        divergent: 1.6 * omega,
        // It sinks down rather than drops.
        passive: 0.02 * weight * leg,
        friction: settings.friction,
        turning: 0.5 * half * settings.friction,
        least_load: 0.02 * weight,
        torso: 12.0 / scale,
        rise: 10.0 / scale,
        swing: 25.0 / scale,
        posture: 12.0 / scale,
        hip: [200.0, 40.0],
        brake: 20.0,
        start: settings.step_time,
        touch: 0.1 * weight,
    }
}
