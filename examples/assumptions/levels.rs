//! The four simplifications of the thesis' section 4.2 as models beside the full one.
use super::findings::Released;
use super::rocker::{Landing, Rocked, Rocker};
use super::trials::{Failure, Trial, range, tulip};
use bipedc::simulation::filmed_model;
use bipedc_analysis::robot::BaseKind;
use bipedc_analysis::simulate::{Mechanics, Scenario};
use bipedc_compiler::Robot;

/// What a model says of the release; `None`: it says nothing.
#[derive(Debug, Clone, Default)]
pub struct Answer {
    pub name: &'static str,
    /// The other foot lands, s.
    pub landing: Option<f64>,
    /// Roll velocity just before, rad/s.
    pub rate: Option<f64>,
    /// Energy lost until the next extreme of roll, J.
    pub lost: Option<f64>,
    /// That extreme, rad.
    pub roll: Option<f64>,
    /// From the landing until the first foot stands again, s.
    pub swing: Option<f64>,
    /// Impacts of the foot in that time.
    pub strikes: Option<usize>,
    /// Greatest minus least pitch of the torso, rad.
    pub pitch: f64,
    /// Part of the load that the inner corners of the right foot carry, greatest minus least before the landing.
    pub pressure: Option<f64>,
}

/// Point feet in the stepping direction: all corners on the line below the ankle's axis.
pub fn point_feet(mut robot: Robot) -> Robot {
    let points = robot.description.feet.iter_mut().flat_map(|foot| &mut foot.points);
    points.for_each(|point| point.position[1] = 0.0);
    robot
}

/// The frontal plane alone: no body has a place or a product of inertia before or behind it, the soles reach as far forward as backward.
pub fn frontal_plane(mut robot: Robot) -> Robot {
    for inertial in robot.description.links.iter_mut().filter_map(|link| link.inertial.as_mut()) {
        inertial.origin.xyz[0] = 0.0;
        (inertial.inertia[1], inertial.inertia[2]) = (0.0, 0.0);
    }
    for point in robot.description.feet.iter_mut().flat_map(|foot| &mut foot.points) {
        point.position[0] = 0.12_f64.copysign(point.position[0]);
    }
    robot
}

/// The simulation of a TUlip with the scenario `release`, changed by `edit`.
pub fn simulated(
    name: &'static str,
    robot: &Robot,
    step: f64,
    edit: impl Fn(&mut Scenario),
) -> Result<Answer, Failure> {
    let model = filmed_model(robot, &[]).map_err(|error| error.to_string())?;
    let run = |duration: f64| {
        Trial::run(robot, &model, "release", |s| {
            (s.step, s.log_every, s.duration) = (step, 2, duration);
            edit(s);
        })
    };
    let trial = run(3.0)?;
    let found = Released::of(&trial);
    let first = *found.swings.first().ok_or_else(|| format!("{name}: it does not rock: {found:?}"))?;
    let time = trial.time();
    let landing = trial.at(found.landing);
    let [roll, pitch, _] = trial.torso();
    let extreme = (landing..time.len()).find(|&i| roll[i] == first.roll).unwrap_or(landing);
    let (left, right) = (trial.edge("right_foot", "left"), trial.edge("right_foot", "right"));
    let parts: Vec<f64> = (trial.at(0.1)..landing).map(|i| left[i] / (left[i] + right[i])).collect();
    let [low, high] = range(&pitch[..trial.at(2.0)]);
    let [least, most] = range(&parts);
    Ok(Answer {
        name,
        landing: Some(found.landing),
        rate: Some(trial.column("base/angular_velocity/x")[landing - 1]),
        lost: Some(run(time[extreme])?.lost()),
        roll: Some(first.roll),
        swing: found.swings.get(1).map(|next| next.begin - found.landing),
        strikes: Some(first.strikes),
        pitch: high - low,
        pressure: Some(most - least),
    })
}

/// The robot as one rigid body on its ankles: impacts and all masses, impacts left out, masses in one point.
pub fn rockers() -> Result<[Answer; 3], Failure> {
    let mechanics = Mechanics::new(&tulip::Tulip, BaseKind::Floating).map_err(|error| error.to_string())?;
    let mut q = vec![0.0; 19];
    (q[3], q[6]) = 0.15_f64.sin_cos();
    (q[7 + 1], q[13 + 1]) = (-0.3, 0.3);
    let mass = tulip()?.tree().map_err(|error| error.to_string())?.total_mass();
    let body = Rocker::of(&mechanics, &q, mass)?;
    let answer = |name, Rocked { landing, rate, lost, roll, swing }: Rocked| Answer {
        name,
        landing: Some(landing),
        rate: Some(rate[0]),
        lost: Some(lost),
        roll: Some(roll),
        swing: Some(swing),
        strikes: Some(usize::from(lost > 0.0)),
        ..Answer::default()
    };
    Ok([
        answer("one rigid body on its ankles, plastic impact", body.run(Landing::Plastic, 1e-4)),
        answer("the same without impact", body.run(Landing::Smooth, 1e-4)),
        answer("single mass on its ankles, plastic impact", body.single_mass().run(Landing::Plastic, 1e-4)),
    ])
}

/// Travel of the pressure's centre to the outer side while the leg speeds up, and to the inner side until 50 ms after it stopped, m:
/// of the simulation, and of a single mass that moves like its centre of mass, `y − z ÿ/(g + z̈)`.
pub fn pressure_of_a_leg_swing(trial: &Trial) -> Result<[[f64; 2]; 2], Failure> {
    let mechanics = Mechanics::new(&tulip::Tulip, BaseKind::Floating).map_err(|error| error.to_string())?;
    let time = trial.time();
    let mut columns: Vec<Vec<f64>> = ["position/x", "position/y", "position/z"]
        .into_iter()
        .chain(["orientation/x", "orientation/y", "orientation/z", "orientation/w"])
        .map(|name| trial.column(&format!("base/{name}")))
        .collect();
    for joint in 0..12 {
        let name = bipedc_runtime::Model::<f64>::joint_name(&tulip::Tulip, joint).ok_or("no name")?;
        columns.push(trial.joint(name));
    }
    let centers: Vec<Vec<f64>> = (0..time.len())
        .map(|i| {
            let q: Vec<f64> = columns.iter().map(|column| column[i]).collect();
            mechanics.named("center_of_mass", &q, &[0.0; 18]).ok_or("no centre of mass")
        })
        .collect::<Result<_, _>>()?;
    let h = time[1] - time[0];
    let second = |i: usize, axis: usize| {
        (centers[i + 1][axis] - 2.0 * centers[i][axis] + centers[i - 1][axis]) / (h * h)
    };
    let single: Vec<f64> = (1..time.len() - 1)
        .map(|i| centers[i][1] - centers[i][2] * second(i, 1) / (9.81 + second(i, 2)))
        .collect();
    let full = &trial.column("right_foot/cop/y")[1..];
    let [begin, half, end] = [1.0, 1.25, 1.55].map(|t| trial.at(t));
    let travel = |values: &[f64]| {
        let from = values[begin - 2];
        [range(&values[begin..half])[0] - from, range(&values[half..end])[1] - from]
    };
    Ok([travel(full), travel(&single)])
}
