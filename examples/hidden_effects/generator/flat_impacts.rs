//! Velocities of robots in space before and after their right foot strikes the ground flat, turning as it does.
use super::contact::corners;
use super::impacts::{Base, COUNT, Impact, made, measure};
use super::model::{Rigid, read};
use super::random::Random;
use super::truth::{Plan, Truth};
use super::{Failure, Made, draw, failure};
use bipedc_effects::effect::Effect;
use bipedc_runtime::Argument;
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Rotation3, UnitQuaternion, Vector3, Vector6};
use std::path::Path;

/// The base's linear velocity is in world axes, here and in the table.
const FLOATING: Base = Base {
    configuration: &[
        "base/position/x",
        "base/position/y",
        "base/position/z",
        "base/orientation/x",
        "base/orientation/y",
        "base/orientation/z",
        "base/orientation/w",
    ],
    velocity: &[
        "base/linear_velocity/x",
        "base/linear_velocity/y",
        "base/linear_velocity/z",
        "base/angular_velocity/x",
        "base/angular_velocity/y",
        "base/angular_velocity/z",
    ],
};

/// The striking sole in the frame of its link.
struct Sole {
    /// Its middle, m.
    center: Vector3<f64>,
    /// Half its length and half its width, m.
    half: [f64; 2],
}

/// Draws and measures a case.
pub fn generate(plan: &Plan, folder: &Path) -> Result<Made, Failure> {
    let robot = read(folder, false)?;
    let mut random = Random::named(&plan.seed);
    let mut truth = Truth::new(plan);
    truth.rate_hz = 0.0;
    draw::effects(plan, &robot.description, &mut truth, &mut random);
    let functions = [
        "mass_matrix",
        "jacobian:right_foot",
        "position:right_foot",
        "rotation:right_foot",
        "position:left_foot",
    ];
    let rigid = Rigid::new(&robot, &functions)?;
    let points = corners(&robot.description);
    let right: Vec<Vector3<f64>> =
        points.iter().filter(|c| c.foot == "right_foot").map(|c| c.position).collect();
    let sole = Sole::around(&right);
    let mut measured = Vec::new();
    for count in COUNT {
        let run = draw_impacts(&rigid, &sole, &truth.effects, count, &mut random)?;
        measured.push(measure(run, &mut random));
    }
    let strike =
        |impact: &Impact, effects: &[Effect]| strike(&rigid, &sole, &impact.q, &impact.before, effects);
    made(&rigid, &FLOATING, truth, &measured, &strike)
}

impl Sole {
    fn around(corners: &[Vector3<f64>]) -> Self {
        let center = corners.iter().sum::<Vector3<f64>>() / corners.len().max(1) as f64;
        let half = [0, 1].map(|k| corners.iter().map(|c| (c[k] - center[k]).abs()).fold(0.0, f64::max));
        Self { center, half }
    }
}

fn draw_impacts(
    rigid: &Rigid,
    sole: &Sole,
    effects: &[Effect],
    count: usize,
    r: &mut Random,
) -> Result<Vec<Impact>, Failure> {
    let mut out = Vec::new();
    for _ in 0..200 * count {
        if out.len() == count {
            return Ok(out);
        }
        let q = landing(rigid, sole, r)?;
        if rigid.run(rigid.function("position_of_left_foot")?, &[(Argument::Q, &q)])[2] < 0.07 {
            continue;
        }
        let before = approach(rigid, sole, &q, r)?;
        if let Some(after) = strike(rigid, sole, &q, &before, effects)? {
            out.push(Impact { q, before, after });
        }
    }
    Err(failure("too few of the drawn motions strike the ground with a flat foot"))
}

/// A configuration whose right sole lies on level ground.
fn landing(rigid: &Rigid, sole: &Sole, r: &mut Random) -> Result<Vec<f64>, Failure> {
    let mut q = vec![0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    for joint in &rigid.joints {
        q.push(match joint.as_str() {
            // The left foot is in the air.
            "left_knee_pitch" => r.range(0.7, 1.2),
            name if name.contains("knee") => r.range(0.1, 0.6),
            name if name.contains("pitch") => r.range(-0.5, 0.2),
            _ => r.range(-0.2, 0.2),
        });
    }
    let rotation = rigid.run(rigid.function("rotation_of_right_foot")?, &[(Argument::Q, &q)]);
    let heading = Rotation3::from_axis_angle(&Vector3::z_axis(), r.range(-0.5, 0.5));
    let base = heading.matrix() * Matrix3::from_column_slice(&rotation).transpose();
    let base = UnitQuaternion::from_matrix(&base);
    q[3..7].copy_from_slice(base.coords.as_slice());
    let at = rigid.run(rigid.function("position_of_right_foot")?, &[(Argument::Q, &q)]);
    q[0] = -at[0];
    q[1] = -at[1];
    q[2] = -at[2] - sole.center.z;
    Ok(q)
}

/// Velocities (base in world axes) with which the sole comes down and turns.
fn approach(rigid: &Rigid, sole: &Sole, q: &[f64], r: &mut Random) -> Result<Vec<f64>, Failure> {
    let wanted = Vector6::new(
        r.range(-0.1, 0.1),
        r.range(-0.1, 0.1),
        r.range(-0.7, -0.2),
        r.range(-0.1, 0.1),
        r.range(-0.1, 0.1),
        r.sign() * r.range(0.3, 3.0),
    );
    let rates = DVector::from_iterator(rigid.joints.len(), rigid.joints.iter().map(|_| r.range(-0.8, 0.8)));
    let jacobian = jacobian(rigid, sole, q)?;
    let of_base = Matrix6::from_iterator(jacobian.columns(0, 6).iter().copied());
    let rest = jacobian.columns(6, rates.len()) * &rates;
    let rest = Vector6::from_iterator(rest.iter().copied());
    let base = of_base.lu().solve(&(wanted - rest)).ok_or_else(|| failure("a base that cannot move"))?;
    Ok(base.iter().chain(rates.iter()).copied().collect())
}

/// Twist of the middle of the sole (linear first, world axes) per velocity, the base's in world axes.
fn jacobian(rigid: &Rigid, sole: &Sole, q: &[f64]) -> Result<DMatrix<f64>, Failure> {
    let arguments = [(Argument::Q, q)];
    let values = rigid.run(rigid.function("jacobian_of_right_foot")?, &arguments);
    let rotation = rigid.run(rigid.function("rotation_of_right_foot")?, &arguments);
    let at = Matrix3::from_column_slice(&rotation) * sole.center;
    let mut full = DMatrix::from_vec(6, values.len() / 6, values);
    for mut column in full.column_iter_mut() {
        let turning = Vector3::new(column[3], column[4], column[5]);
        let moved = turning.cross(&at);
        (0..3).for_each(|k| column[k] += moved[k]);
    }
    // Columns of the base's linear velocity: from the base's axes to the world's.
    let to_base = base_axes(q).transpose();
    let linear = full.columns(0, 3) * to_base;
    full.columns_mut(0, 3).copy_from(&linear);
    Ok(full)
}

fn base_axes(q: &[f64]) -> Matrix3<f64> {
    let base = UnitQuaternion::from_quaternion(nalgebra::Quaternion::new(q[6], q[3], q[4], q[5]));
    base.to_rotation_matrix().into_inner()
}

/// Velocities after the impact. `None` if the sole would tip: the impulse acts outside of it or pulls.
fn strike(
    rigid: &Rigid,
    sole: &Sole,
    q: &[f64],
    before: &[f64],
    effects: &[Effect],
) -> Result<Option<Vec<f64>>, Failure> {
    let n = before.len();
    let mut mass = DMatrix::from_vec(n, n, rigid.run(rigid.function("mass_matrix")?, &[(Argument::Q, q)]));
    let axes = base_axes(q);
    let right = mass.columns(0, 3) * axes.transpose();
    mass.columns_mut(0, 3).copy_from(&right);
    let left = axes * mass.rows(0, 3);
    mass.rows_mut(0, 3).copy_from(&left);
    let jacobian = jacobian(rigid, sole, q)?;
    let v = DVector::from_column_slice(before);
    let Some(factor) = mass.cholesky() else { return Ok(None) };
    let spread = factor.solve(&jacobian.transpose());
    let Some(inertia) = (&jacobian * &spread).try_inverse() else { return Ok(None) };
    let turned = effects.iter().find(|effect| effect.kind.name == "spin_friction");
    let reach = turned.map_or(f64::INFINITY, |effect| effect.value("radius") * effect.value("friction"));
    let impulse = spinning(&inertia, &(&jacobian * &v), reach);
    let normal = impulse[2];
    let inside = impulse[3].abs() < sole.half[1] * normal && impulse[4].abs() < sole.half[0] * normal;
    if normal <= 0.0 || !inside {
        return Ok(None);
    }
    Ok(Some((v + spread * impulse).as_slice().to_vec()))
}

/// The impulse that stops all but what the ground cannot hold about the vertical. With the sole's inertia A and the
/// turning ω that is left, the impulse is −A (speed − ω e₆): everything is affine in ω. The share about the vertical
/// must lie between −reach and +reach times the normal one, and ω is what is left of its own sign.
fn spinning(inertia: &DMatrix<f64>, speed: &DVector<f64>, reach: f64) -> DVector<f64> {
    let hold = -(inertia * speed);
    let slope = inertia.column(5).into_owned();
    if reach.is_infinite() || hold[5].abs() <= reach * hold[2] {
        return hold;
    }
    // −reach · sign · normal = about the vertical, for the sign of what is left.
    let sign = -hold[5].signum();
    let left = -(hold[5] + sign * reach * hold[2]) / (slope[5] + sign * reach * slope[2]);
    hold + slope * left
}
