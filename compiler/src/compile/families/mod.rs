//! Each function of the catalogue in terms of the derivations.
use super::Context;
pub mod contacts;
pub mod drives;
pub mod regressors;

use super::quantity::Quantity;
use crate::derive::base_rows::BaseRows;
use crate::derive::effects::At;
use crate::derive::frames::{frame_pose, jacobian as frame_jacobian, world_poses};
use crate::derive::momentum::Wrench;
use crate::derive::newton_euler::generalised_forces;
use crate::derive::{
    Motions, RobotModel, articulated, composite, coriolis, derivatives, effects, frames, joint_axes,
    momentum as whole,
};
use crate::expression::{Expr, Sym, Vector3};
use crate::program::{Operations, Order, lower};
use crate::tree::{Frame, Tree};
use bipedc_runtime::Argument;

/// Units of generalised forces, by row.
fn force_units(tree: &Tree) -> Vec<String> {
    (0..tree.nv).map(|r| if tree.row_is_linear(r) { "N" } else { "N m" }.to_owned()).collect()
}
/// Units of a configuration, by element.
fn configuration_names(tree: &Tree) -> (Vec<String>, Vec<String>) {
    let names = tree.coordinate_names();
    let base = tree.nq - tree.joints.len();
    let unit = |name: &String| match name.as_str() {
        "base/x" | "base/y" | "base/z" => "m",
        "base/qx" | "base/qy" | "base/qz" | "base/qw" => "1",
        _ => "rad",
    };
    let mut units: Vec<String> = names[..base].iter().map(|name| unit(name).to_owned()).collect();
    units.extend(tree.joints.iter().map(|joint| if joint.prismatic { "m" } else { "rad" }.to_owned()));
    (names, units)
}
/// Units of generalised accelerations, by row.
fn acceleration_units(tree: &Tree) -> Vec<String> {
    (0..tree.nv).map(|r| if tree.row_is_linear(r) { "m/s²" } else { "rad/s²" }.to_owned()).collect()
}

fn forces<'g>(tree: &Tree, values: Vec<Sym<'g>>) -> Quantity<'g> {
    Quantity::named(tree.row_names(), force_units(tree), values)
}

/// Whichever takes the fewest operations.
fn fewest<'g>(candidates: Vec<Vec<Sym<'g>>>) -> Vec<Sym<'g>> {
    let cost = |values: &Vec<Sym<'g>>| {
        let outputs: Vec<Expr> = values.iter().map(|x| x.expr).collect();
        values.first().map_or(0, |x| Operations::of(&lower(x.graph, &outputs, Order::DepthFirst)).total())
    };
    candidates.into_iter().min_by_key(cost).unwrap_or_default()
}

/// In body axes, or in the axes before each joint, which parallel neighbours share.
fn moving<'g>(c: &Context<'g, '_>, motions: Motions) -> Quantity<'g> {
    let in_bodies = generalised_forces(&c.folded, motions, false);
    let in_joints = joint_axes::generalised_forces(&c.folded, motions);
    let loads = fewest(vec![in_bodies, in_joints]);
    let at = At::new(&c.folded, motions.velocity, motions.acceleration);
    forces(c.folded.tree, c.laws.report(&c.folded, &at, &loads))
}

fn cheapest_mass_matrix<'g>(c: &Context<'g, '_>) -> Vec<Vec<Sym<'g>>> {
    let nv = c.folded.tree.nv;
    let flat = |d: Vec<Vec<Sym<'g>>>| d.into_iter().flatten().collect();
    let both = vec![flat(composite::mass_matrix(&c.folded)), flat(joint_axes::mass_matrix(&c.folded))];
    let mut d: Vec<Vec<Sym<'g>>> = fewest(both).chunks(nv.max(1)).map(<[Sym<'g>]>::to_vec).collect();
    for (row, column, inertia) in c.laws.inertias(&c.folded) {
        d[row][column] = d[row][column] + inertia;
    }
    d
}

pub fn inverse_dynamics<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    moving(c, Motions::ALL)
}
pub fn inverse_dynamics_with_forces<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let loads = generalised_forces(&c.folded, Motions::ALL, true);
    let at = At::new(&c.folded, true, true);
    forces(c.folded.tree, c.laws.report(&c.folded, &at, &loads))
}
pub fn bias<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    moving(c, Motions::NO_ACCELERATION)
}
pub fn gravity<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let loads = generalised_forces(&c.folded, Motions::AT_REST, false);
    let at = At::new(&c.folded, false, false);
    forces(c.folded.tree, c.laws.report(&c.folded, &at, &loads))
}

/// Accelerations under `tau` plus what the external forces contribute.
fn accelerations<'g>(c: &Context<'g, '_>, external: bool) -> Quantity<'g> {
    let model = &c.folded;
    let tau: Vec<Sym<'g>> = (0..model.tree.nv).map(|i| model.input(Argument::Tau, i)).collect();
    // At rest and without gravity a robot under forces f needs the torques −Jᵀ f.
    let still = Motions { velocity: false, acceleration: false, gravity: false };
    let needed = if external { generalised_forces(model, still, true) } else { Vec::new() };
    let values = if c.laws.is_empty() {
        let mut tau = tau;
        for (x, h) in tau.iter_mut().zip(needed) {
            *x = *x - h;
        }
        articulated::forward_dynamics(model, &tau)
    } else {
        let mut given = vec![model.constant(0.0); model.tree.nv];
        for (x, h) in given.iter_mut().zip(needed) {
            *x = -h;
        }
        effects::forward_dynamics(model, c.laws, &tau, &given)
    };
    Quantity::named(model.tree.row_names(), acceleration_units(model.tree), values)
}
pub fn forward_dynamics<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    accelerations(c, false)
}
pub fn forward_dynamics_with_forces<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    accelerations(c, true)
}

fn square<'g>(tree: &Tree, d: Vec<Vec<Sym<'g>>>) -> Quantity<'g> {
    let units =
        (0..tree.nv).map(|r| if tree.row_is_linear(r) { "kg, kg m" } else { "kg m, kg m²" }.to_owned());
    let columns = (0..tree.nv).map(|c| d.iter().map(|row| row[c]).collect()).collect();
    Quantity::matrix(tree.row_names(), units.collect(), tree.row_names(), columns)
}
pub fn mass_matrix<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    square(c.folded.tree, cheapest_mass_matrix(c))
}
pub fn mass_matrix_upper<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let mut d = cheapest_mass_matrix(c);
    for (r, row) in d.iter_mut().enumerate() {
        row[..r].fill(c.folded.constant(0.0));
    }
    square(c.folded.tree, d)
}

pub fn kinetic_energy<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    Quantity::scalar("kinetic_energy", "J", whole::kinetic_energy(&c.folded))
}
pub fn potential_energy<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    Quantity::scalar("potential_energy", "J", whole::potential_energy(&c.folded))
}
pub fn center_of_mass<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    Quantity::xyz("m", whole::center_of_mass(&c.folded))
}
pub fn center_of_mass_velocity<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    Quantity::xyz("m/s", whole::center_of_mass_velocity(&c.folded))
}
pub fn center_of_mass_acceleration<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    Quantity::xyz("m/s²", whole::center_of_mass_acceleration(&c.folded))
}
pub fn center_of_mass_motion<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let motion = [center_of_mass(c), center_of_mass_velocity(c), center_of_mass_acceleration(c)];
    let names = ["position", "velocity", "acceleration"].map(str::to_owned).to_vec();
    let rows = ["x", "y", "z"].map(str::to_owned).to_vec();
    Quantity::matrix(
        rows,
        vec!["m, m/s, m/s²".to_owned(); 3],
        names,
        motion.map(|mut q| q.columns.swap_remove(0)).to_vec(),
    )
}
/// The base's rows of the mass matrix, written in either axes.
fn base_rows<'g>(model: &RobotModel<'g, '_>) -> Vec<BaseRows<'g>> {
    if model.tree.trunk().is_none() {
        return Vec::new();
    }
    let both = [composite::mass_matrix(model), joint_axes::mass_matrix(model)];
    both.iter().filter_map(|d| BaseRows::new(model, d)).collect()
}

/// Centre of mass and the columns of its Jacobian, each as cheap as it can be had beside the other.
fn com_and_jacobian<'g>(c: &Context<'g, '_>) -> (Vec<Sym<'g>>, Vec<Sym<'g>>) {
    // Of a mass of one the momentum is the velocity of the centre of mass, and no entry is to be divided.
    let unit = c.folded.of_unit_mass();
    let mut ways = vec![(whole::center_of_mass(&c.folded), whole::center_of_mass_jacobian(&c.folded))];
    for rows in base_rows(&unit) {
        ways.push((rows.center_of_mass(&unit), rows.center_of_mass_jacobian(&unit)));
    }
    let flat = |(com, jacobian): (Vector3<'g>, Vec<Vector3<'g>>)| {
        [com].into_iter().chain(jacobian).flat_map(|column| column.0).collect()
    };
    let mut com: Vec<Sym<'g>> = fewest(ways.into_iter().map(flat).collect());
    let jacobian = com.split_off(3);
    (com, jacobian)
}

pub fn center_of_mass_jacobian<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let (_, jacobian) = com_and_jacobian(c);
    let columns = jacobian.chunks(3).map(<[Sym<'g>]>::to_vec).collect();
    let rows = ["x", "y", "z"].map(str::to_owned).to_vec();
    Quantity::matrix(rows, vec!["m".to_owned(); 3], c.folded.tree.row_names(), columns)
}

pub fn center_of_mass_with_jacobian<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let (com, jacobian) = com_and_jacobian(c);
    let mut columns = vec![com];
    columns.extend(jacobian.chunks(3).map(<[Sym<'g>]>::to_vec));
    let rows = ["x", "y", "z"].map(str::to_owned).to_vec();
    let names = ["position".to_owned()].into_iter().chain(c.folded.tree.row_names()).collect();
    Quantity::matrix(rows, vec!["m".to_owned(); 3], names, columns)
}

const MOMENTUM: [&str; 2] = ["kg m/s", "kg m²/s"];
pub fn momentum<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let w = whole::momentum(&c.folded);
    Quantity::pair(MOMENTUM, w.linear, w.angular)
}
pub fn momentum_rate<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let w = whole::momentum_rate(&c.folded, false);
    Quantity::pair(["N", "N m"], w.linear, w.angular)
}
fn six<'g>(w: Wrench<'g>) -> impl Iterator<Item = Sym<'g>> {
    w.linear.0.into_iter().chain(w.angular.0)
}
pub fn centroidal_momentum<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let model = &c.folded;
    let mut ways = vec![whole::about_center_of_mass(model, whole::momentum(model))];
    ways.extend(base_rows(model).iter().map(|rows| rows.centroidal_momentum(model)));
    let values = fewest(ways.into_iter().map(|w| six(w).collect()).collect());
    let (linear, angular) = values.split_at(3);
    let vector = |x: &[Sym<'g>]| Vector3([x[0], x[1], x[2]]);
    Quantity::pair(MOMENTUM, vector(linear), vector(angular))
}
/// The columns, behind the momentum where that is asked for: of the matrix, or by itself.
fn momentum_columns<'g>(c: &Context<'g, '_>, with_momentum: bool) -> Vec<Vec<Sym<'g>>> {
    let model = &c.folded;
    let mut matrices = vec![whole::centroidal_momentum_matrix(model)];
    matrices.extend(base_rows(model).iter().map(|rows| rows.centroidal_momentum_matrix(model)));
    let mut ways: Vec<Vec<Sym<'g>>> = Vec::new();
    for matrix in matrices {
        let columns = || matrix.iter().flat_map(|&column| six(column));
        if with_momentum {
            let by_itself = whole::about_center_of_mass(model, whole::momentum(model));
            for momentum in [by_itself, whole::momentum_from_matrix(model, &matrix)] {
                ways.push(six(momentum).chain(columns()).collect());
            }
        } else {
            ways.push(columns().collect());
        }
    }
    fewest(ways).chunks(6).map(<[Sym<'g>]>::to_vec).collect()
}
pub fn centroidal_momentum_matrix<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let zero = c.folded.zero3();
    let names = Quantity::pair(["kg, kg m", "kg m, kg m²"], zero, zero);
    let columns = momentum_columns(c, false);
    Quantity::matrix(names.row_names, names.row_units, c.folded.tree.row_names(), columns)
}
pub fn centroidal_momentum_with_matrix<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let zero = c.folded.zero3();
    let names = Quantity::pair(["kg, kg m", "kg m, kg m²"], zero, zero);
    let of = ["momentum".to_owned()].into_iter().chain(c.folded.tree.row_names()).collect();
    Quantity::matrix(names.row_names, names.row_units, of, momentum_columns(c, true))
}
pub fn centroidal_momentum_rate<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let w = whole::about_center_of_mass(&c.folded, whole::momentum_rate(&c.folded, false));
    Quantity::pair(["N", "N m"], w.linear, w.angular)
}
pub fn ground_wrench<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let w = whole::ground_wrench(&c.folded);
    Quantity::pair(["N", "N m"], w.linear, w.angular)
}
pub fn zero_moment_point<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    Quantity::vector(&["x", "y"], "m", whole::zero_moment_point(&c.folded).to_vec())
}

pub fn position<'g>(c: &Context<'g, '_>, frame: &Frame) -> Quantity<'g> {
    Quantity::xyz("m", frame_pose(&c.folded, &world_poses(&c.folded), frame).position)
}
pub fn rotation<'g>(c: &Context<'g, '_>, frame: &Frame) -> Quantity<'g> {
    let r = frame_pose(&c.folded, &world_poses(&c.folded), frame).rotation;
    let axes = ["x", "y", "z"].map(str::to_owned).to_vec();
    let columns = (0..3).map(|k| r.column(k).0.to_vec()).collect();
    Quantity::matrix(axes.clone(), vec!["1".to_owned(); 3], axes, columns)
}
fn of_frame<'g>(c: &Context<'g, '_>, columns: Vec<(Vector3<'g>, Vector3<'g>)>) -> Quantity<'g> {
    let columns = columns.into_iter().map(|(v, w)| v.0.into_iter().chain(w.0).collect()).collect();
    let zero = c.folded.zero3();
    let names = Quantity::pair(["m, 1", "1"], zero, zero);
    Quantity::matrix(names.row_names, names.row_units, c.folded.tree.row_names(), columns)
}
pub fn jacobian<'g>(c: &Context<'g, '_>, frame: &Frame) -> Quantity<'g> {
    let poses = world_poses(&c.folded);
    let position = frame_pose(&c.folded, &poses, frame).position;
    of_frame(c, frame_jacobian(&c.folded, &poses, frame.body, position))
}
pub fn body_jacobian<'g>(c: &Context<'g, '_>, frame: &Frame) -> Quantity<'g> {
    of_frame(c, frames::body_jacobian(&c.folded, frame))
}
pub fn jacobian_rate_times_velocity<'g>(c: &Context<'g, '_>, frame: &Frame) -> Quantity<'g> {
    let six = frames::jacobian_rate_times_velocity(&c.folded, &world_poses(&c.folded), frame);
    let zero = c.folded.zero3();
    let names = Quantity::pair(["m/s²", "rad/s²"], zero, zero);
    Quantity::named(names.row_names, names.row_units, six.to_vec())
}

/// Units of one generalised force by one generalised displacement are mixed; the row's force unit is named.
fn blocks<'g>(tree: &Tree, units: Vec<String>, blocks: &[(&str, Vec<Vec<Sym<'g>>>)]) -> Quantity<'g> {
    let (mut names, mut columns) = (Vec::new(), Vec::new());
    for (prefix, block) in blocks {
        names.extend(tree.row_names().into_iter().map(|name| format!("{prefix}{name}")));
        columns.extend((0..tree.nv).map(|c| block.iter().map(|row| row[c]).collect::<Vec<_>>()));
    }
    Quantity::matrix(tree.row_names(), units, names, columns)
}

pub fn coriolis_matrix<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    blocks(c.folded.tree, force_units(c.folded.tree), &[("", coriolis::coriolis_matrix(&c.folded))])
}
type Rows<'g> = Vec<Vec<Sym<'g>>>;

/// By q and v; by a as well where that differs from the mass matrix.
fn inverse_derivatives<'g>(c: &Context<'g, '_>) -> (Rows<'g>, Rows<'g>, Option<Rows<'g>>) {
    if c.laws.is_empty() {
        let (dq, dv) = derivatives::inverse_dynamics(&c.folded);
        return (dq, dv, None);
    }
    let (dq, dv, da) = effects::inverse_dynamics_derivatives(&c.folded, c.laws);
    (dq, dv, Some(da))
}

fn forward_derivatives<'g>(c: &Context<'g, '_>) -> (Rows<'g>, Rows<'g>, Rows<'g>) {
    if c.laws.is_empty() {
        return derivatives::forward_dynamics(&c.folded);
    }
    effects::forward_dynamics_derivatives(&c.folded, c.laws, &articulated::given_forces(&c.folded))
}

pub fn inverse_dynamics_dq<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    blocks(c.folded.tree, force_units(c.folded.tree), &[("", inverse_derivatives(c).0)])
}
pub fn inverse_dynamics_dv<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    blocks(c.folded.tree, force_units(c.folded.tree), &[("", inverse_derivatives(c).1)])
}
pub fn inverse_dynamics_derivatives<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let (dq, dv, da) = inverse_derivatives(c);
    let da = da.unwrap_or_else(|| composite::mass_matrix(&c.folded));
    blocks(c.folded.tree, force_units(c.folded.tree), &[("q/", dq), ("v/", dv), ("a/", da)])
}
pub fn forward_dynamics_dq<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    blocks(c.folded.tree, acceleration_units(c.folded.tree), &[("", forward_derivatives(c).0)])
}
pub fn forward_dynamics_dv<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    blocks(c.folded.tree, acceleration_units(c.folded.tree), &[("", forward_derivatives(c).1)])
}
pub fn forward_dynamics_dtau<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    blocks(c.folded.tree, acceleration_units(c.folded.tree), &[("", forward_derivatives(c).2)])
}
pub fn forward_dynamics_derivatives<'g>(c: &Context<'g, '_>) -> Quantity<'g> {
    let (dq, dv, dtau) = forward_derivatives(c);
    blocks(c.folded.tree, acceleration_units(c.folded.tree), &[("q/", dq), ("v/", dv), ("tau/", dtau)])
}
