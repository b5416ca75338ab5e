//! Velocities of planar robots before and after their right foot strikes the ground.
use super::model::{Rigid, read};
use super::random::Random;
use super::table::Table;
use super::truth::{Plan, Truth};
use super::{Failure, Made, contact, draw};
use bipedc_effects::effect::Effect;
use bipedc_runtime::Argument;
use nalgebra::{DMatrix, DVector, Matrix2, Vector2};
use std::path::Path;

/// Impacts for finding and for judging.
pub(super) const COUNT: [usize; 2] = [60, 30];
/// Standard deviations: m, rad or parts of a quaternion, and m/s or rad/s.
pub(super) const NOISE: [f64; 2] = [2e-5, 0.002];
/// A foot that touches the ground at one point.
const POINT: &str = "right_foot/point_foot";

/// One impact; velocities as the table has them.
pub(super) struct Impact {
    pub q: Vec<f64>,
    pub before: Vec<f64>,
    pub after: Vec<f64>,
}

/// Columns of the base: of its configuration, and of its velocities without `/before` and `/after`.
pub(super) struct Base {
    pub configuration: &'static [&'static str],
    pub velocity: &'static [&'static str],
}

const PLANAR: Base = Base {
    configuration: &["base/position/x", "base/position/z", "base/orientation/pitch"],
    velocity: &["base/linear_velocity/x", "base/linear_velocity/z", "base/angular_velocity/y"],
};

/// Draws and measures a case.
pub fn generate(plan: &Plan, folder: &Path) -> Result<Made, Failure> {
    let robot = read(folder, false)?;
    let mut random = Random::named(&plan.seed);
    let mut truth = Truth::new(plan);
    truth.rate_hz = 0.0;
    draw::effects(plan, &robot.description, &mut truth, &mut random);
    let functions = ["mass_matrix".to_owned(), format!("jacobian:{POINT}"), format!("position:{POINT}")];
    let height = "position:left_foot/point_foot";
    let all: Vec<&str> = functions.iter().map(String::as_str).chain([height]).collect();
    let rigid = Rigid::new(&robot, &all)?;
    let runs: Vec<Vec<Impact>> = COUNT
        .iter()
        .map(|&count| draw_impacts(&rigid, &truth.effects, count, &mut random))
        .collect::<Result<_, _>>()?;
    let measured: Vec<Vec<Impact>> = runs.into_iter().map(|run| measure(run, &mut random)).collect();
    let strike = |impact: &Impact, effects: &[Effect]| strike(&rigid, &impact.q, &impact.before, effects);
    made(&rigid, &PLANAR, truth, &measured, &strike)
}

fn draw_impacts(
    rigid: &Rigid,
    effects: &[Effect],
    count: usize,
    r: &mut Random,
) -> Result<Vec<Impact>, Failure> {
    let mut out = Vec::new();
    let [foot, other] =
        ["right", "left"].map(|side| rigid.function(&format!("position_of_{side}_foot_point_foot")));
    let (foot, other) = (foot?, other?);
    while out.len() < count {
        let mut q = vec![0.0, 0.0, r.range(-0.2, 0.2)];
        for joint in &rigid.joints {
            q.push(if joint.contains("knee") { r.range(0.1, 0.7) } else { r.range(-0.55, 0.45) });
        }
        let mut before = vec![r.range(-0.2, 0.8), r.range(-0.8, -0.2), r.range(-0.4, 0.4)];
        before.extend(rigid.joints.iter().map(|_| r.range(-0.9, 0.9)));
        let at = rigid.run(foot, &[(Argument::Q, &q)]);
        (q[0], q[1]) = (-at[0], -at[2]);
        if rigid.run(other, &[(Argument::Q, &q)])[2] < 0.01 {
            continue;
        }
        if let Some(after) = strike(rigid, &q, &before, effects)? {
            out.push(Impact { q, before, after });
        }
    }
    Ok(out)
}

/// Velocities after the impact. `None` if the foot does not strike, leaves the ground anyway, or slides back.
fn strike(rigid: &Rigid, q: &[f64], before: &[f64], effects: &[Effect]) -> Result<Option<Vec<f64>>, Failure> {
    let n = before.len();
    let arguments = [(Argument::Q, q)];
    let mass = DMatrix::from_vec(n, n, rigid.run(rigid.function("mass_matrix")?, &arguments));
    let full = rigid.run(rigid.function("jacobian_of_right_foot_point_foot")?, &arguments);
    let full = DMatrix::from_vec(full.len() / n, n, full);
    let jacobian = DMatrix::from_fn(2, n, |i, j| full[(2 * i, j)]);
    let v = DVector::from_column_slice(before);
    let speed = &jacobian * &v;
    if !(-1.6..=-0.2).contains(&speed[1]) {
        return Ok(None);
    }
    let Some(inverse) = mass.cholesky() else { return Ok(None) };
    let spread = inverse.solve(&jacobian.transpose());
    let yielding = &jacobian * &spread;
    let yielding = Matrix2::new(yielding[(0, 0)], yielding[(0, 1)], yielding[(1, 0)], yielding[(1, 1)]);
    let bounce = contact::value(effects, "impact_restitution", "coefficient").unwrap_or(0.0);
    let friction = contact::value(effects, "foot_slip", "friction").unwrap_or(f64::INFINITY);
    let Some(impulse) = impulse(&yielding, Vector2::new(speed[0], speed[1]), bounce, friction) else {
        return Ok(None);
    };
    let after = v + spread * DVector::from_column_slice(impulse.as_slice());
    Ok(Some(after.as_slice().to_vec()))
}

/// Tangential and normal impulse: the foot sticks if friction allows, else slides.
fn impulse(yielding: &Matrix2<f64>, speed: Vector2<f64>, bounce: f64, friction: f64) -> Option<Vector2<f64>> {
    let wanted = Vector2::new(-speed[0], -(1.0 + bounce) * speed[1]);
    let stick = yielding.lu().solve(&wanted)?;
    if stick[1] <= 0.0 {
        return None;
    }
    if stick[0].abs() <= friction * stick[1] {
        return Some(stick);
    }
    let slope = friction * stick[0].signum();
    let normal = wanted[1] / (yielding[(1, 0)] * slope + yielding[(1, 1)]);
    let slide = Vector2::new(slope * normal, normal);
    // Friction opposes the sliding that is left.
    let left = speed[0] + yielding[(0, 0)] * slide[0] + yielding[(0, 1)] * slide[1];
    (normal > 0.0 && left * slide[0] <= 0.0).then_some(slide)
}

/// What sensors make of impacts.
pub(super) fn measure(run: Vec<Impact>, r: &mut Random) -> Vec<Impact> {
    let mut blur =
        |values: Vec<f64>, sigma: f64| values.into_iter().map(|x| x + sigma * r.normal()).collect();
    run.into_iter()
        .map(|i| Impact {
            q: blur(i.q, NOISE[0]),
            before: blur(i.before, NOISE[1]),
            after: blur(i.after, NOISE[1]),
        })
        .collect()
}

/// Velocities after an impact from the measured state before; `None` if the foot does not strike.
pub(super) type Strike<'a> = &'a dyn Fn(&Impact, &[Effect]) -> Result<Option<Vec<f64>>, Failure>;

/// The case of measured impacts, the first for finding and the second for judging.
pub(super) fn made(
    rigid: &Rigid,
    base: &Base,
    mut truth: Truth,
    measured: &[Vec<Impact>],
    strike: Strike<'_>,
) -> Result<Made, Failure> {
    truth.metric = "post_impact_velocity".to_owned();
    truth.nominal = error(&measured[1], &[], strike)?;
    truth.oracle = error(&measured[1], &truth.effects, strike)?;
    truth.noise.insert("position".to_owned(), NOISE[0]);
    truth.noise.insert("velocity".to_owned(), NOISE[1]);
    Ok(Made { train: table(rigid, base, &measured[0]), validation: table(rigid, base, &measured[1]), truth })
}

/// Root mean square over all velocities of measured minus predicted, from the measured state before.
fn error(run: &[Impact], effects: &[Effect], strike: Strike<'_>) -> Result<f64, Failure> {
    let (mut sum, mut count) = (0.0, 0.0);
    for impact in run {
        let Some(after) = strike(impact, effects)? else { continue };
        sum += after.iter().zip(&impact.after).map(|(a, b)| (a - b).powi(2)).sum::<f64>();
        count += after.len() as f64;
    }
    Ok((sum / f64::max(count, 1.0)).sqrt())
}

fn table(rigid: &Rigid, base: &Base, run: &[Impact]) -> Table {
    let mut table = Table::default();
    table.push("impact", 0, (0..run.len()).map(|i| i as f64).collect());
    let names = |base: &[&str], what: &str| -> Vec<String> {
        let joints = rigid.joints.iter().map(|joint| format!("{joint}/{what}"));
        base.iter().map(|name| (*name).to_owned()).chain(joints).collect()
    };
    for (i, name) in names(base.configuration, "position").into_iter().enumerate() {
        table.push(name, 6, run.iter().map(|impact| impact.q[i]).collect());
    }
    for after in [false, true] {
        for (i, name) in names(base.velocity, "velocity").into_iter().enumerate() {
            let value = |impact: &Impact| if after { impact.after[i] } else { impact.before[i] };
            let when = if after { "after" } else { "before" };
            table.push(format!("{name}/{when}"), 5, run.iter().map(value).collect());
        }
    }
    table
}
