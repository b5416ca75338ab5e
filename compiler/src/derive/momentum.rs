//! Quantities of the whole robot (4.35–4.42): centre of mass, momentum, energy, zero moment point.
use super::BodyInertia;
use super::composite::{composites, unit_momentum};
use super::frames::world_poses;
use super::kinematics::{Motions, forward};
use super::model::RobotModel;
use super::newton_euler::body_wrenches;
use crate::expression::{Input, Sym, Vector3, replaced};
use crate::tree::JointMotion;
use bipedc_runtime::Argument;

/// A force or linear momentum, and a moment or angular momentum about the world's origin, world axes.
#[derive(Debug, Clone, Copy)]
pub struct Wrench<'g> {
    /// N or kg m/s.
    pub linear: Vector3<'g>,
    /// N m or kg m²/s.
    pub angular: Vector3<'g>,
}

/// Moves body wrenches (about body origins, body axes) to the world's origin and axes and adds them up.
fn sum_in_world<'g>(model: &RobotModel<'g, '_>, mut wrenches: Vec<(Vector3<'g>, Vector3<'g>)>) -> Wrench<'g> {
    let mut sum = (model.zero3(), model.zero3());
    for index in (0..wrenches.len()).rev() {
        let _work = model.work(index, "sums of what it carries");
        let (force, moment) = wrenches[index];
        let (force, moment) = (model.up(index, force), model.up(index, moment));
        let carrier = match model.tree.bodies[index].parent {
            Some(parent) => &mut wrenches[parent],
            None => &mut sum,
        };
        *carrier = (carrier.0 + force, carrier.1 + moment + model.offset(index).cross(force));
    }
    Wrench { linear: sum.0, angular: sum.1 }
}

/// Linear velocity of each body's origin and angular velocity, in its axes.
pub fn velocities<'g>(model: &RobotModel<'g, '_>) -> Vec<(Vector3<'g>, Vector3<'g>)> {
    let mut out: Vec<(Vector3<'g>, Vector3<'g>)> = Vec::new();
    for (index, body) in model.tree.bodies.iter().enumerate() {
        let _work = model.work(index, "velocity");
        if body.motion == JointMotion::Free {
            let first = body.v_index;
            out.push((model.input3(Argument::V, first), model.input3(Argument::V, first + 3)));
            continue;
        }
        let (u, w) = body.parent.map_or((model.zero3(), model.zero3()), |p| out[p]);
        let mut u = model.down(index, u + w.cross(model.offset(index)));
        let mut w = model.down(index, w);
        let rate = model.signed(index, model.input(Argument::V, body.v_index));
        match body.motion {
            JointMotion::Revolute { axis, .. } => w[axis] = w[axis] + rate,
            JointMotion::Prismatic { axis, .. } => u[axis] = u[axis] + rate,
            JointMotion::Free => {}
        }
        out.push((u, w));
    }
    out
}

/// Linear momentum ρ (4.38) and angular momentum σ about the world's origin (4.39).
pub fn momentum<'g>(model: &RobotModel<'g, '_>) -> Wrench<'g> {
    let moving = velocities(model);
    let of_body = |(index, (body, &(u, w))): (usize, (&BodyInertia<'g>, &(Vector3<'g>, Vector3<'g>)))| {
        let _work = model.work(index, "momentum");
        body.momentum(u, w)
    };
    let each = model.inertias.iter().zip(&moving).enumerate().map(of_body).collect();
    sum_in_world(model, each)
}

/// ρ̇ (4.40) and σ̇ (4.41, corrected: p × m p̈ + J ω̇ + ω × J ω); with `gravity`, what the ground has to
/// provide instead.
pub fn momentum_rate<'g>(model: &RobotModel<'g, '_>, gravity: bool) -> Wrench<'g> {
    let moving = forward(model, Motions { velocity: true, acceleration: true, gravity });
    sum_in_world(model, body_wrenches(model, &moving))
}

/// The same about the centre of mass.
pub fn about_center_of_mass<'g>(model: &RobotModel<'g, '_>, about_origin: Wrench<'g>) -> Wrench<'g> {
    let _work = model.work_on_all("moment about the centre of mass");
    let arm = center_of_mass(model);
    Wrench { angular: about_origin.angular - arm.cross(about_origin.linear), ..about_origin }
}

/// Σ mᵢ pᵢ in the world, kg m.
pub fn first_moment<'g>(model: &RobotModel<'g, '_>) -> Vector3<'g> {
    let mut moments: Vec<(Sym<'g>, Vector3<'g>)> =
        model.inertias.iter().map(|body| (body.mass, body.first_moment)).collect();
    let mut sum = model.zero3();
    for index in (0..moments.len()).rev() {
        let _work = model.work(index, "sums of what it carries");
        let (mass, moment) = moments[index];
        let above = model.up(index, moment) + model.offset(index).scale(mass);
        match model.tree.bodies[index].parent {
            Some(parent) => {
                let (m, l) = moments[parent];
                moments[parent] = (m + mass, l + above);
            }
            None => sum = sum + above,
        }
    }
    sum
}

/// Centre of mass in the world (4.35), m.
pub fn center_of_mass<'g>(model: &RobotModel<'g, '_>) -> Vector3<'g> {
    let per_mass = model.constant(1.0) / model.total_mass();
    let moment = first_moment(model);
    let _work = model.work_on_all("centre of mass");
    moment.scale(per_mass)
}

/// Jacobian of the centre of mass with respect to `v`: one column per element of `v`, world axes.
pub fn center_of_mass_jacobian<'g>(model: &RobotModel<'g, '_>) -> Vec<Vector3<'g>> {
    let poses = world_poses(model);
    let composite = composites(model);
    let per_mass = model.constant(1.0) / model.total_mass();
    let mut columns = vec![model.zero3(); model.tree.nv];
    for (index, body) in model.tree.bodies.iter().enumerate() {
        let _work = model.work(index, "Jacobian of the centre of mass");
        let rotation = poses[index].rotation;
        let inertia = &composite[index];
        if body.motion == JointMotion::Free {
            for k in 0..3 {
                let about = model.along(k, model.constant(1.0)).cross(inertia.first_moment);
                columns[body.v_index + k] = rotation.column(k).scale(inertia.mass * per_mass);
                columns[body.v_index + 3 + k] = rotation * about.scale(per_mass);
            }
        } else {
            let (linear, _) = unit_momentum(model, index, inertia);
            columns[body.v_index] = rotation * linear.scale(per_mass);
        }
    }
    columns
}

/// Centroidal momentum per unit of each element of `v`: linear momentum, and angular momentum about the centre of mass, world
/// axes.
pub fn centroidal_momentum_matrix<'g>(model: &RobotModel<'g, '_>) -> Vec<Wrench<'g>> {
    let poses = world_poses(model);
    let composite = composites(model);
    let com = center_of_mass(model);
    let zero = Wrench { linear: model.zero3(), angular: model.zero3() };
    let mut columns = vec![zero; model.tree.nv];
    for (index, body) in model.tree.bodies.iter().enumerate() {
        let _work = model.work(index, "centroidal momentum matrix");
        let inertia = &composite[index];
        let arm = poses[index].position - com;
        let mut column = |k: usize, (linear, angular): (Vector3<'g>, Vector3<'g>)| {
            let linear = poses[index].rotation * linear;
            let angular = poses[index].rotation * angular + arm.cross(linear);
            columns[body.v_index + k] = Wrench { linear, angular };
        };
        if body.motion == JointMotion::Free {
            for k in 0..3 {
                let unit = model.along(k, model.constant(1.0));
                column(k, inertia.momentum(unit, model.zero3()));
                column(3 + k, inertia.momentum(model.zero3(), unit));
            }
        } else {
            column(0, unit_momentum(model, index, inertia));
        }
    }
    // A robot that moves as one without turning does not turn about its centre of mass.
    if let Some(root) = model.tree.bodies.iter().find(|body| body.motion == JointMotion::Free) {
        columns[root.v_index..][..3].iter_mut().for_each(|column| column.angular = model.zero3());
    }
    columns
}

/// Momentum from a matrix of its columns.
pub fn momentum_from_matrix<'g>(model: &RobotModel<'g, '_>, columns: &[Wrench<'g>]) -> Wrench<'g> {
    times_rates(model, |k| columns[k])
}

/// Momentum (kg m/s, kg m²/s) from a column for each element of `v`, about the point and in the axes of the columns.
///
/// Summed limb by limb from its end on: what limbs of the same make add up is computed for both at once.
pub fn times_rates<'g>(model: &RobotModel<'g, '_>, column: impl Fn(usize) -> Wrench<'g>) -> Wrench<'g> {
    let plus =
        |a: Wrench<'g>, b: Wrench<'g>| Wrench { linear: a.linear + b.linear, angular: a.angular + b.angular };
    let zero = Wrench { linear: model.zero3(), angular: model.zero3() };
    let mut carried = vec![zero; model.tree.bodies.len()];
    let mut sum = zero;
    for (index, body) in model.tree.bodies.iter().enumerate().rev() {
        let _work = model.work(index, "centroidal momentum");
        let own = (body.v_index..body.v_index + body.motion.nv()).map(|k| {
            let (rate, column) = (model.input(Argument::V, k), column(k));
            Wrench { linear: column.linear.scale(rate), angular: column.angular.scale(rate) }
        });
        let all = own.fold(carried[index], plus);
        match body.parent {
            Some(parent) => carried[parent] = plus(carried[parent], all),
            None => sum = plus(sum, all),
        }
    }
    sum
}

/// Velocity of the centre of mass, m/s.
pub fn center_of_mass_velocity<'g>(model: &RobotModel<'g, '_>) -> Vector3<'g> {
    momentum(model).linear.scale(model.constant(1.0) / model.total_mass())
}

/// Acceleration of the centre of mass, m/s².
pub fn center_of_mass_acceleration<'g>(model: &RobotModel<'g, '_>) -> Vector3<'g> {
    momentum_rate(model, false).linear.scale(model.constant(1.0) / model.total_mass())
}

/// Kinetic energy (4.36, corrected: ½ Σ (a + b)), J.
pub fn kinetic_energy<'g>(model: &RobotModel<'g, '_>) -> Sym<'g> {
    let twice = model.inertias.iter().zip(velocities(model)).enumerate().fold(
        model.constant(0.0),
        |sum, (index, (body, (u, w)))| {
            let _work = model.work(index, "kinetic energy");
            let (linear, angular) = body.momentum(u, w);
            sum + u.dot(linear) + w.dot(angular)
        },
    );
    twice * 0.5
}

/// Potential energy (4.37), J; zero at the world's origin.
pub fn potential_energy<'g>(model: &RobotModel<'g, '_>) -> Sym<'g> {
    -model.gravity().dot(first_moment(model))
}

/// Force and moment about the world's origin that the ground has to provide for the motion.
pub fn ground_wrench<'g>(model: &RobotModel<'g, '_>) -> Wrench<'g> {
    momentum_rate(model, true)
}

/// The same along a constraint surface, q = T(φ), in parts: times φ̈, times φ̇², and at rest (6.38–6.41); T′ is [`Argument::V`], T″ [`Argument::A`].
///
/// N and N m per squared unit of φ and s², N and N m.
pub fn wrench_along_surface<'g>(model: &RobotModel<'g, '_>) -> [Wrench<'g>; 3] {
    let part = |motions: Motions| sum_in_world(model, body_wrenches(model, &forward(model, motions)));
    let accelerated = part(Motions { velocity: false, acceleration: true, gravity: false });
    let to_velocity = |input: Input| {
        (input.argument == Argument::A).then(|| model.input(Argument::V, input.index as usize))
    };
    let along = |of: Vector3<'g>| {
        let of = replaced(&[of[0], of[1], of[2]], to_velocity);
        Vector3([of[0], of[1], of[2]])
    };
    let accelerated = Wrench { linear: along(accelerated.linear), angular: along(accelerated.angular) };
    [accelerated, part(Motions { gravity: false, ..Motions::ALL }), part(Motions::AT_REST)]
}

/// Zero moment point on the plane z = 0 (4.42): x and y, m. Gravity along −z.
///
/// x = (M g x_com − σ̇_y) / (M g + ρ̇_z), y = (M g y_com + σ̇_x) / (M g + ρ̇_z), written with the ground's
/// wrench.
pub fn zero_moment_point<'g>(model: &RobotModel<'g, '_>) -> [Sym<'g>; 2] {
    let wrench = ground_wrench(model);
    let per_load = model.constant(1.0) / wrench.linear[2];
    [-wrench.angular[1] * per_load, wrench.angular[0] * per_load]
}
