//! Motors, gears and springs between motor and joint (4.26)–(4.33).
//!
//! Arguments `motor_q`, `motor_v`, `motor_a` have one element per joint, in the order of `tree.joints`, at the
//! motor shaft; joints without a series-elastic drive do not read theirs. Results are listed by joint.
//!
//! Coulomb friction is not part of these functions: programs have no sign. It only adds
//! [`coulomb_friction`]` · sign(motor velocity)` to the motor's torque.
use super::composite;
use super::kinematics::Motions;
use super::model::RobotModel;
use super::newton_euler::generalised_forces;
use crate::description::model::JointDrive;
use crate::expression::Sym;
use crate::tree::Tree;
use bipedc_effects::drive::{Drive, Transmission};
use bipedc_runtime::Argument;

/// A torque of one joint or its motor, N m.
#[derive(Debug, Clone, Copy)]
pub struct JointTorque<'g> {
    /// Index into `tree.joints`.
    pub joint: usize,
    /// N m (prismatic joints: N).
    pub torque: Sym<'g>,
}

/// Drives with the index of their joint, in the order of the joints.
fn by_joint<'d>(tree: &Tree, drives: &'d [JointDrive]) -> Vec<(usize, &'d Drive)> {
    let find = |name: &str| drives.iter().find(|driven| driven.joint == name).map(|driven| &driven.drive);
    tree.joints.iter().enumerate().filter_map(|(k, joint)| Some((k, find(&joint.name)?))).collect()
}

/// Rotor inertia reflected through a stiff gear, I_M N², by row of `v`, kg m².
///
/// With a spring in between the rotor moves on its own (4.31) and adds nothing here.
pub fn reflected_inertia(tree: &Tree, drives: &[JointDrive]) -> Vec<f64> {
    let mut out = vec![0.0; tree.nv];
    for (k, drive) in by_joint(tree, drives) {
        if drive.is_stiff() {
            out[tree.joints[k].v_index] = drive.rotor_inertia_at_joint();
        }
    }
    out
}

/// Coulomb friction at the motor shaft, N m, by joint: factor of sign(motor velocity) in (4.26).
pub fn coulomb_friction(tree: &Tree, drives: &[JointDrive]) -> Vec<f64> {
    let mut out = vec![0.0; tree.joints.len()];
    for (k, drive) in by_joint(tree, drives) {
        out[k] = drive.coulomb_friction;
    }
    out
}

/// Mass matrix with the reflected rotor inertias on its diagonal, `nv × nv`.
pub fn mass_matrix<'g>(model: &RobotModel<'g, '_>, drives: &[JointDrive]) -> Vec<Vec<Sym<'g>>> {
    let mut d = composite::mass_matrix(model);
    for (k, inertia) in reflected_inertia(model.tree, drives).into_iter().enumerate() {
        d[k][k] = d[k][k] + inertia;
    }
    d
}

/// Generalised forces that `a` needs, seen from the joints: `D a + H` (4.25), plus for stiff drives rotor
/// inertia and viscous friction reflected through the gear, I_M N² a + F_v N² v, and for passive joints what
/// spring and damper take away (zero where nothing else drives them). Order of `v`.
pub fn inverse_dynamics<'g>(model: &RobotModel<'g, '_>, drives: &[JointDrive]) -> Vec<Sym<'g>> {
    let motions = Motions { velocity: true, acceleration: true, gravity: true };
    let mut tau = generalised_forces(model, motions, false);
    for (k, drive) in by_joint(model.tree, drives) {
        let row = model.tree.joints[k].v_index;
        match drive.transmission {
            Transmission::Stiff => {
                let inertia = model.input(Argument::A, row) * drive.rotor_inertia_at_joint();
                let friction = model.input(Argument::V, row) * drive.viscous_friction_at_joint();
                tau[row] = tau[row] + inertia + friction;
            }
            Transmission::Passive { .. } => tau[row] = tau[row] - passive(model, k, drive),
            Transmission::SeriesElastic { .. } => {}
        }
    }
    tau
}

/// Angle or rate of a joint.
fn joint<'g>(model: &RobotModel<'g, '_>, argument: Argument, k: usize) -> Sym<'g> {
    let base = if argument == Argument::Q { model.tree.nq } else { model.tree.nv } - model.tree.joints.len();
    model.input(argument, base + k)
}

/// −stiffness · q − damping · v
fn passive<'g>(model: &RobotModel<'g, '_>, k: usize, drive: &Drive) -> Sym<'g> {
    let Some([stiffness, damping]) = drive.passive() else { return model.constant(0.0) };
    -(joint(model, Argument::Q, k) * stiffness + joint(model, Argument::V, k) * damping)
}

/// Cable force F_s = k (r_M θ_M / N − r_L θ_L), N (4.28).
fn cable_force<'g>(model: &RobotModel<'g, '_>, k: usize, drive: &Drive) -> Option<Sym<'g>> {
    let Transmission::SeriesElastic { motor_pulley_radius, load_pulley_radius, spring_stiffness } =
        drive.transmission
    else {
        return None;
    };
    let motor =
        model.input(Argument::MotorQ, k) * (spring_stiffness * motor_pulley_radius / drive.gear_ratio);
    Some(motor - joint(model, Argument::Q, k) * (spring_stiffness * load_pulley_radius))
}

/// What springs do on the joints: τ_L = r_L F_s (4.29b) of series-elastic drives, −k q − d q̇ of passive
/// joints. Positive in the joint's positive direction. Stiff drives are not listed: their joint torque does
/// not follow from positions.
pub fn spring_torques<'g>(model: &RobotModel<'g, '_>, drives: &[JointDrive]) -> Vec<JointTorque<'g>> {
    let of = |(k, drive): (usize, &Drive)| {
        let torque = match drive.transmission {
            Transmission::Stiff => return None,
            Transmission::Passive { .. } => passive(model, k, drive),
            Transmission::SeriesElastic { .. } => cable_force(model, k, drive)? * drive.load_radius(),
        };
        Some(JointTorque { joint: k, torque })
    };
    by_joint(model.tree, drives).into_iter().filter_map(of).collect()
}

/// Load of the gear's output, τ_N = r_M F_s (4.29a), of series-elastic drives.
pub fn gear_torques<'g>(model: &RobotModel<'g, '_>, drives: &[JointDrive]) -> Vec<JointTorque<'g>> {
    let of = |(k, drive): (usize, &Drive)| {
        let Transmission::SeriesElastic { motor_pulley_radius, .. } = drive.transmission else { return None };
        Some(JointTorque { joint: k, torque: cable_force(model, k, drive)? * motor_pulley_radius })
    };
    by_joint(model.tree, drives).into_iter().filter_map(of).collect()
}

/// Torque that each motor has to give at its shaft, τ_M, without Coulomb friction.
///
/// Series-elastic: I_M θ̈_M + F_v θ̇_M + τ_N / N (4.31), from the motor's own motion. Stiff: the same with
/// θ_M = N q and τ_N from the inverse dynamics of `q`, `v`, `a` (4.26). Passive joints have no motor.
pub fn motor_torques<'g>(model: &RobotModel<'g, '_>, drives: &[JointDrive]) -> Vec<JointTorque<'g>> {
    let needed = inverse_dynamics(model, drives);
    let of = |(k, drive): (usize, &Drive)| {
        let torque = match drive.transmission {
            Transmission::Passive { .. } => return None,
            Transmission::Stiff => needed[model.tree.joints[k].v_index] / model.constant(drive.gear_ratio),
            Transmission::SeriesElastic { .. } => {
                let inertia = model.input(Argument::MotorA, k) * drive.rotor_inertia;
                let friction = model.input(Argument::MotorV, k) * drive.viscous_friction;
                inertia + friction + cable_force(model, k, drive)? * drive.lever()
            }
        };
        Some(JointTorque { joint: k, torque })
    };
    by_joint(model.tree, drives).into_iter().filter_map(of).collect()
}
