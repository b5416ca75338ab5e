//! Drive trains: rotors behind gears, springs in series, passive joints.
use super::super::Context;
use super::super::quantity::Quantity;
use super::forces;
use crate::derive::RobotModel;
use crate::derive::drive::{self, JointTorque};
use crate::description::model::Drive;

type Torques = for<'g, 't> fn(&RobotModel<'g, 't>, &[Drive]) -> Vec<JointTorque<'g>>;

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
