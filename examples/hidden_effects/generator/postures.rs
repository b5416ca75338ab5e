//! Static postures on two flat feet: centre of pressure and corner forces.
use super::contact::{Corner, corners, reading, spread};
use super::legs::{FUNCTIONS, Legs};
use super::model::{Rigid, read, with_effects};
use super::random::Random;
use super::sensors::rounded;
use super::table::Table;
use super::truth::{Plan, Truth};
use super::{Failure, Made, draw, failure};
use bipedc_compiler::description::model::RobotDescription;
use bipedc_compiler::robot::Robot;
use bipedc_effects::effect::Effect;
use bipedc_runtime::Argument;
use nalgebra::{Isometry3, Matrix3, Translation3, UnitQuaternion, Vector3};
use std::f64::consts::TAU;
use std::path::Path;

/// Postures for finding and for judging.
const COUNT: [usize; 2] = [90, 45];
/// Standard deviations of averages: force of a corner (N), joint angle (rad).
const NOISE: [f64; 2] = [0.15, 2e-5];

/// One posture. The world's origin lies in the right sole, below the foot's frame.
struct Posture {
    joints: Vec<f64>,
    /// Corners in the world.
    points: Vec<Vector3<f64>>,
    /// Of the corners, N.
    forces: Vec<Vector3<f64>>,
}

/// Where gravity acts.
struct Weight {
    legs_center: super::model::Function,
    mass: f64,
    gravity: Vector3<f64>,
}

impl Weight {
    fn new(rigid: &Rigid, description: &RobotDescription) -> Result<Self, Failure> {
        let masses = description.links.iter().filter_map(|link| link.inertial.as_ref());
        Ok(Self {
            legs_center: rigid.function("center_of_mass")?,
            mass: masses.map(|inertial| inertial.mass).sum(),
            gravity: Vector3::from(description.gravity),
        })
    }
}

fn rigid(robot: &Robot) -> Result<Rigid, Failure> {
    Rigid::new(robot, &[&FUNCTIONS[..], &["center_of_mass"]].concat())
}

/// Draws and measures a case.
pub fn generate(plan: &Plan, folder: &Path) -> Result<Made, Failure> {
    let nominal = read(folder, false)?;
    let mut random = Random::named(&plan.seed);
    let mut truth = Truth::new(plan);
    truth.rate_hz = 0.0;
    draw::effects(plan, &nominal.description, &mut truth, &mut random);
    draw::tilt_is_slope(&mut truth);
    let actual = with_effects(&nominal, &truth.effects)?;
    let corners = corners(&nominal.description);
    let model = rigid(&actual)?;
    let weight = Weight::new(&model, &actual.description)?;
    let runs = COUNT.map(|count| stand(&model, &weight, &corners, count, &mut random));
    let [train, validation] = runs;
    let runs = [train?, validation?].map(|run| measure(plan, run, &truth.effects, &corners, &mut random));
    truth.metric = "cop".to_owned();
    truth.nominal = error(&nominal, &runs[1], &[], &corners)?;
    truth.oracle = error(&actual, &runs[1], &truth.effects, &corners)?;
    truth.noise.insert("corner_force".to_owned(), NOISE[0]);
    truth.noise.insert("position".to_owned(), NOISE[1]);
    let [train, validation] = runs.map(|run| table(&model.joints, &run, &corners));
    Ok(Made { train, validation, truth })
}

fn draw_poses(height: f64, r: &mut Random) -> (Isometry3<f64>, [Isometry3<f64>; 2]) {
    let mut around = |d: f64| r.range(-d, d);
    let right = Isometry3::translation(0.0, 0.0, height);
    let left = Translation3::new(around(0.06), 0.17 + around(0.025), height);
    let left = Isometry3::from_parts(left, UnitQuaternion::from_euler_angles(0.0, 0.0, around(0.2)));
    let base = Translation3::new(0.03 + around(0.04), 0.08 + around(0.04), height + 0.555 + around(0.03));
    let turn = UnitQuaternion::from_euler_angles(around(0.1), around(0.25), around(0.15));
    (Isometry3::from_parts(base, turn), [right, left])
}

fn stand(
    model: &Rigid,
    weight: &Weight,
    corners: &[Corner],
    count: usize,
    random: &mut Random,
) -> Result<Vec<Posture>, Failure> {
    let legs = Legs::new(model)?;
    let height = -corners[0].position.z;
    let guess: Vec<f64> = model.joints.iter().map(|name| bent(name)).collect();
    let mut out = Vec::new();
    for _ in 0..100 * count {
        let (base, feet) = draw_poses(height, random);
        let Ok(q) = legs.place(&base, &feet, &guess) else { continue };
        let center = Vector3::from_vec(model.run(weight.legs_center, &[(Argument::Q, &q)]));
        let force = -weight.mass * weight.gravity;
        let foot = |name: &str| usize::from(name.starts_with("left"));
        let points: Vec<Vector3<f64>> = corners
            .iter()
            .map(|corner| feet[foot(&corner.foot)].transform_point(&corner.position.into()).coords)
            .collect();
        let forces = spread(&points, &vec![1.0; points.len()], force, center.cross(&force));
        let forces: Vec<Vector3<f64>> = forces.chunks_exact(3).map(Vector3::from_column_slice).collect();
        if forces.iter().all(|force| force.z > 2.0) {
            out.push(Posture { joints: q[7..].to_vec(), points, forces });
        }
        if out.len() == count {
            return Ok(out);
        }
    }
    Err(failure("no postures within reach"))
}

/// Slightly bent knees.
pub fn bent(joint: &str) -> f64 {
    match joint {
        _ if joint.ends_with("hip_pitch") => -0.4,
        _ if joint.ends_with("knee_pitch") => 0.8,
        _ if joint.ends_with("ankle_pitch") => -0.4,
        _ => 0.0,
    }
}

fn measure(
    plan: &Plan,
    run: Vec<Posture>,
    effects: &[Effect],
    corners: &[Corner],
    random: &mut Random,
) -> Vec<Posture> {
    let measured = run.into_iter().map(|posture| {
        let joints =
            posture.joints.iter().map(|q| rounded(q + NOISE[1] * random.normal(), TAU / plan.counts));
        let joints = joints.collect();
        let forces = corners.iter().zip(&posture.forces).map(|(corner, force)| {
            let noisy = force + Vector3::from_fn(|_, _| NOISE[0] * random.normal());
            reading(effects, &corner.foot, &corner.name, noisy)
        });
        Posture { joints, forces: forces.collect(), points: posture.points }
    });
    measured.collect()
}

/// Centre of pressure in the right sole, from the sensors' readings.
fn pressure(posture: &Posture) -> [f64; 2] {
    let total: f64 = posture.forces.iter().map(|force| force.z).sum();
    let moment = posture.points.iter().zip(&posture.forces).map(|(point, force)| point.xy() * force.z);
    (moment.sum::<nalgebra::Vector2<f64>>() / total).into()
}

/// The force that the sensor would read without the effects; `None` where it is at its limit.
fn corrected(effects: &[Effect], corner: &Corner, force: Vector3<f64>) -> Option<Vector3<f64>> {
    let mut force = force;
    for effect in effects {
        let place = effect.location.sensor.as_deref();
        if !(place.is_none() || place == Some(&corner.foot) || place == Some(&corner.name)) {
            continue;
        }
        match effect.kind.name {
            "force_sensor_gain" => force /= effect.value("gain"),
            "force_sensor_bias" => force.z -= effect.value("z"),
            "force_sensor_saturation" if force.z >= effect.value("limit") => return None,
            _ => {}
        }
    }
    Some(force)
}

/// Root mean square over x, y and postures of measured minus predicted centre of pressure, m.
fn error(robot: &Robot, run: &[Posture], effects: &[Effect], corners: &[Corner]) -> Result<f64, Failure> {
    let model = rigid(robot)?;
    let weight = Weight::new(&model, &robot.description)?;
    let [position, rotation] =
        [model.function("position_of_right_foot")?, model.function("rotation_of_right_foot")?];
    let (mut sum, mut count) = (0.0, 0.0);
    for posture in run {
        let forces =
            corners.iter().zip(&posture.forces).map(|(corner, force)| corrected(effects, corner, *force));
        let Some(forces) = forces.collect::<Option<Vec<_>>>() else { continue };
        let measured = pressure(&Posture { forces, joints: Vec::new(), points: posture.points.clone() });
        let q = [&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0][..], &posture.joints].concat();
        let arguments = [(Argument::Q, &q[..])];
        let foot = Vector3::from_vec(model.run(position, &arguments));
        let turn = Matrix3::from_vec(model.run(rotation, &arguments));
        let center = Vector3::from_vec(model.run(weight.legs_center, &arguments));
        let center = turn.transpose() * (center - foot) - Vector3::new(0.0, 0.0, corners[0].position.z);
        // Where the line of gravity through the centre of mass meets the sole.
        let expected = center.xy() - weight.gravity.xy() * (center.z / weight.gravity.z);
        sum += (expected.x - measured[0]).powi(2) + (expected.y - measured[1]).powi(2);
        count += 2.0;
    }
    Ok((sum / f64::max(count, 1.0)).sqrt())
}

fn table(joints: &[String], run: &[Posture], corners: &[Corner]) -> Table {
    let mut table = Table::default();
    table.push("posture", 0, (0..run.len()).map(|i| i as f64).collect());
    for (j, joint) in joints.iter().enumerate() {
        table.push(format!("{joint}/position"), 6, run.iter().map(|posture| posture.joints[j]).collect());
    }
    for (i, axis) in ["x", "y"].into_iter().enumerate() {
        table.push(format!("cop/{axis}"), 6, run.iter().map(|posture| pressure(posture)[i]).collect());
    }
    for (i, corner) in corners.iter().enumerate() {
        let name = format!("{}/force/z", corner.name);
        table.push(name, 3, run.iter().map(|posture| posture.forces[i].z).collect());
    }
    table
}
