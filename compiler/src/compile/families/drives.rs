//! Drive trains: rotors behind gears, springs in series, passive joints.
use super::super::Context;
use super::super::quantity::Quantity;
use super::forces;
use crate::derive::RobotModel;
use crate::derive::drive::{self, JointTorque};
use crate::description::model::JointDrive;
use crate::expression::Sym;
use bipedc_runtime::Argument;

type Torques = for<'g, 't> fn(&RobotModel<'g, 't>, &[JointDrive]) -> Vec<JointTorque<'g>>;

fn by_joint<'g>(c: &Context<'g, '_>, torques: Torques) -> Quantity<'g> {
    let list = torques(&c.folded, &c.description.drives);
    let names = list.iter().map(|t| c.folded.tree.joints[t.joint].name.clone()).collect();
    let units = vec!["N m".to_owned(); list.len()];
    Quantity::named(names, units, list.iter().map(|t| t.torque).collect())
}

pub fn inverse_dynamics<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    forces(c.folded.tree, drive::inverse_dynamics(&c.folded, &c.description.drives))
}
pub fn spring_torques<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    by_joint(c, drive::spring_torques)
}
pub fn gear_torques<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    by_joint(c, drive::gear_torques)
}
pub fn motor_torques<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    by_joint(c, drive::motor_torques)
}

/// Rows: motor torques of the driven joints less what the rotors take (5.10); columns: viscous friction of
/// each motor, then spring stiffness of each elastic drive. Coulomb friction's column would be the sign of
/// the motor's velocity, which is no function of this kind.
pub fn regressor<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let tree = c.folded.tree;
    let zero = c.folded.constant(0.0);
    let place = |of: &JointDrive| tree.joints.iter().position(|joint| joint.name == of.joint);
    let driven: Vec<(usize, &JointDrive)> = c
        .description
        .drives
        .iter()
        .filter(|of| of.drive.has_motor())
        .filter_map(|of| Some((place(of)?, of)))
        .collect();
    let mut names = Vec::new();
    let mut columns = Vec::new();
    let mut push = |name: String, row: usize, value: Sym<'g>| {
        let mut column = vec![zero; driven.len()];
        column[row] = value;
        names.push(name);
        columns.push(column);
    };
    for (row, (joint, of)) in driven.iter().enumerate() {
        push(format!("{}.viscous_friction", of.joint), row, c.folded.input(Argument::MotorV, *joint));
    }
    for (row, (joint, of)) in driven.iter().enumerate().filter(|(_, (_, of))| of.drive.is_elastic()) {
        let lever = of.drive.lever();
        let q_index = tree.nq - tree.joints.len() + joint;
        let motor = c.folded.input(Argument::MotorQ, *joint) * lever;
        let load = c.folded.input(Argument::Q, q_index) * of.drive.load_radius();
        push(format!("{}.spring_stiffness", of.joint), row, (motor - load) * lever);
    }
    let rows = driven.iter().map(|(_, of)| of.joint.clone()).collect();
    Quantity::matrix(rows, vec!["N m".to_owned(); driven.len()], names, columns)
}
