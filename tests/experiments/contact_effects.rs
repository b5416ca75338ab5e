//! Effects on logs with feet on the ground, against logs made with them by other means.
//!
//! The made robot sways by sines. What its base needs is computed from the model's inverse dynamics at the true state
//! (with the regressor where masses differ) and carried by both feet; sensors and encoders then report what they do.
use crate::experiments::support::measured::{Subjects, inertial_error, rms};
use bipedc_analysis::experiments::contact_log::ContactExperiment;
use bipedc_analysis::experiments::{Channel, Experiment};
use bipedc_analysis::log::{Mapping, Reader};
use bipedc_analysis::measure::Options;
use bipedc_effects::effect::{self, Effect, Location, kinds};
use bipedc_runtime::nalgebra::{Matrix3, Rotation3, UnitQuaternion, Vector3};
use bipedc_runtime::{Argument, Model, State};
use std::io::Cursor;
use std::path::Path;
use tulip::Tulip;

const FEET: [&str; 2] = ["right_foot", "left_foot"];
const CORNERS: [(&str, f64, f64); 4] = [
    ("front_left", 0.15, 0.06),
    ("front_right", 0.15, -0.06),
    ("rear_left", -0.09, 0.06),
    ("rear_right", -0.09, -0.06),
];

/// What is made.
#[derive(Clone, Copy, PartialEq)]
enum Feet {
    /// Force and torque at the sole, world axes.
    World,
    /// The same in the sole's axes.
    Sole,
    /// Corner forces of a robot that only slides, upright.
    Corners,
}

fn call(name: &str, [q, v, a]: [&[f64]; 3], size: usize) -> Vec<f64> {
    let mut out = vec![0.0; size];
    let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::A, a);
    Tulip.evaluate(Model::<f64>::function(&Tulip, name).unwrap(), &state, &mut out).unwrap();
    out
}

/// Coordinates at a time: base position, orientation, joints.
fn pose(t: f64, feet: Feet) -> (Vector3<f64>, UnitQuaternion<f64>, Vec<f64>) {
    let wave = |size: f64, hertz: f64, phase: f64| size * (std::f64::consts::TAU * hertz * t + phase).sin();
    let place = Vector3::new(wave(0.03, 0.45, 0.1), wave(0.04, 0.35, 1.0), 0.7 + wave(0.01, 0.6, 2.0));
    if feet == Feet::Corners {
        return (place, UnitQuaternion::identity(), vec![0.0; 12]);
    }
    let turn = UnitQuaternion::from_euler_angles(wave(0.1, 0.5, 0.4), 0.1 + wave(0.1, 0.4, 0.9), 0.5);
    let joints =
        (0..12).map(|j| 0.1 * f64::from(j).cos() + wave(0.15, 0.3 + 0.02 * f64::from(j), f64::from(j)));
    (place, turn, joints.collect())
}

/// The model's q, v, a by central differences of the poses.
fn motion(t: f64, feet: Feet) -> [Vec<f64>; 3] {
    let h = 1e-3;
    let [before, now, after] = [t - h, t, t + h].map(|t| pose(t, feet));
    let turn = now.1.inverse();
    let back = (turn * before.1).scaled_axis();
    let forth = (turn * after.1).scaled_axis();
    let (omega, alpha) = ((forth - back) / (2.0 * h), (forth + back) / (h * h));
    let speed = turn * ((after.0 - before.0) / (2.0 * h));
    let faster = turn * ((after.0 + before.0 - now.0 * 2.0) / (h * h)) - omega.cross(&speed);
    let mut q: Vec<f64> = now.0.iter().chain(now.1.coords.iter()).copied().collect();
    let mut v: Vec<f64> = speed.iter().chain(omega.iter()).copied().collect();
    let mut a: Vec<f64> = faster.iter().chain(alpha.iter()).copied().collect();
    for j in 0..12 {
        let [b, n, f] = [before.2[j], now.2[j], after.2[j]];
        q.push(n);
        v.push((f - b) / (2.0 * h));
        a.push((f - 2.0 * n + b) / (h * h));
    }
    [q, v, a]
}

/// A log in which these parameters differ, the world is tilted, sensors report `report(foot, corner, force)` and the
/// encoder of a joint has an offset.
struct Made<'a> {
    feet: Feet,
    change: Vec<f64>,
    tilt: Matrix3<f64>,
    offset: (usize, f64),
    report: &'a dyn Fn(usize, Option<usize>, Vector3<f64>) -> Vector3<f64>,
    torque_gain: [f64; 2],
}

impl Made<'_> {
    fn plain(feet: Feet) -> Self {
        Self {
            feet,
            change: vec![0.0; 130],
            tilt: Matrix3::identity(),
            offset: (0, 0.0),
            report: &|_, _, f| f,
            torque_gain: [1.0; 2],
        }
    }

    /// The log's text.
    fn text(&self) -> String {
        let joints: Vec<&str> = (0..12).map(|j| Model::<f64>::joint_name(&Tulip, j).unwrap()).collect();
        let mut names = vec!["time".to_owned()];
        names.extend(["x", "y", "z"].map(|a| format!("base/position/{a}")));
        names.extend(["x", "y", "z", "w"].map(|a| format!("base/orientation/{a}")));
        names.extend(joints.iter().map(|j| format!("{j}/position")));
        for foot in FEET {
            if self.feet == Feet::Corners {
                names.extend(CORNERS.map(|(corner, ..)| format!("{foot}/{corner}/force/z")));
            } else {
                for what in ["force", "torque"] {
                    names.extend(["x", "y", "z"].map(|a| format!("{foot}/{what}/{a}")));
                }
            }
        }
        let mut text = names.join(",") + "\n";
        for i in 0..1000 {
            let row = self.row(i as f64 / 200.0);
            text += &row.iter().map(|x| format!("{x:e}")).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text
    }

    fn row(&self, t: f64) -> Vec<f64> {
        let [q, v, a] = motion(t, self.feet);
        // In truth the whole world's pose is turned; what the base feels is in its own axes.
        let turn = UnitQuaternion::from_quaternion(bipedc_runtime::nalgebra::Quaternion::new(
            q[6], q[3], q[4], q[5],
        ));
        let mut true_q = q.clone();
        let tilted = UnitQuaternion::from_matrix(&self.tilt) * turn;
        true_q[3..7].copy_from_slice(tilted.coords.as_slice());
        let mut tau = call("inverse_dynamics", [&true_q, &v, &a], 18);
        let regressor = call("inverse_dynamics_regressor", [&true_q, &v, &a], 18 * 130);
        for (column, change) in regressor.chunks_exact(18).zip(&self.change) {
            tau.iter_mut().zip(column).for_each(|(tau, y)| *tau += y * change);
        }
        let force = turn * Vector3::new(tau[0], tau[1], tau[2]);
        let moment = turn * Vector3::new(tau[3], tau[4], tau[5]);
        let mut out = vec![t];
        let mut logged = q.clone();
        logged[7 + self.offset.0] += self.offset.1;
        out.extend(&logged);
        out.extend(self.ground(&q, force, moment));
        out
    }

    /// Readings that carry a force and a moment about the base's origin.
    fn ground(&self, q: &[f64], force: Vector3<f64>, moment: Vector3<f64>) -> Vec<f64> {
        let base = Vector3::new(q[0], q[1], q[2]);
        let soles = FEET.map(|foot| {
            let rotation =
                Matrix3::from_column_slice(&call(&format!("rotation_of_{foot}"), [q, &[], &[]], 9));
            let origin = Vector3::from_vec(call(&format!("position_of_{foot}"), [q, &[], &[]], 3));
            (origin + rotation * Vector3::new(0.0, 0.0, -0.055), rotation)
        });
        let shares = [0.6, 0.4];
        let carried: Vector3<f64> = (0..2).map(|f| (soles[f].0 - base).cross(&(force * shares[f]))).sum();
        let rest = moment - carried;
        let mut out = Vec::new();
        for f in 0..2 {
            let (mut push, mut twist) = (force * shares[f], rest * shares[f]);
            match self.feet {
                Feet::Corners => {
                    // Uniform, then leaning forwards and sideways: what the moment wants.
                    for (k, (_, x, y)) in CORNERS.iter().enumerate() {
                        let (x, y) = (x - 0.03, *y);
                        let lean =
                            -(twist.y + 0.03 * push.z) * x / (4.0 * 0.0144) + twist.x * y / (4.0 * 0.0036);
                        out.push((self.report)(f, Some(k), Vector3::z() * (push.z / 4.0 + lean)).z);
                    }
                    continue;
                }
                Feet::World => push = (self.report)(f, None, push),
                Feet::Sole => {
                    push = soles[f].1.transpose() * (self.report)(f, None, push);
                    twist = soles[f].1.transpose() * twist;
                }
            }
            out.extend(push.iter());
            out.extend((twist * self.torque_gain[f]).iter());
        }
        out
    }
}

/// Errors of the nominal model and with the effects, in standard deviations of 1 N, 1 N m, 10 mm.
fn errors(subjects: &Subjects, made: &Made<'_>, effects: &[Effect]) -> [f64; 2] {
    with_experiment(subjects, made, |experiment| {
        // These feet move freely: how deep their soles lie says nothing.
        let all = experiment.rows();
        let rows: Vec<usize> = (0..all.len()).filter(|&r| all[r].channel != Channel::Sole).collect();
        [rms(experiment, &rows, &[]), rms(experiment, &rows, effects)]
    })
}

fn with_experiment<T>(
    subjects: &Subjects,
    made: &Made<'_>,
    use_it: impl FnOnce(&ContactExperiment<'_>) -> T,
) -> T {
    let mapping = if made.feet == Feet::Sole {
        FEET.map(|f| {
            format!("\"{f}/force\" = {{ frame = \"sole\" }}\n\"{f}/torque\" = {{ frame = \"sole\" }}\n")
        })
        .concat()
    } else {
        String::new()
    };
    let mapping = Mapping::parse(Path::new("map.toml"), &mapping).unwrap();
    let source = Box::new(Cursor::new(made.text().into_bytes()));
    let reader = Reader::from_source(Path::new("made.csv"), source, &mapping).unwrap();
    let experiment =
        ContactExperiment::from_reader(subjects.robot(&Tulip, &[]), reader, &Options::default()).unwrap();
    use_it(&experiment)
}

/// The filter lets sines below 1 Hz pass but for this (N and N m, out of 186 N).
const FILTER: f64 = 2e-3;

fn check(subjects: &Subjects, made: &Made<'_>, effects: &[Effect]) {
    let [before, after] = errors(subjects, made, effects);
    let names: Vec<String> = effects.iter().map(|e| e.to_string()).collect();
    println!("{}: {before:.5} to {after:.6}", names.join(", "));
    assert!(after < FILTER && before > 20.0 * after, "{names:?}: {before} to {after}");
}

#[test]
#[ignore = "takes long"]
fn without_effects_nothing_is_left_in_any_frame() {
    let subjects = Subjects::named("tulip");
    for feet in [Feet::World, Feet::Sole, Feet::Corners] {
        let [left, _] = errors(&subjects, &Made::plain(feet), &[]);
        println!("{left:e}");
        assert!(left < FILTER);
    }
}

#[test]
#[ignore = "takes long"]
fn masses() {
    let subjects = Subjects::named("tulip");
    for effect in [
        Effect::new(
            &kinds::PAYLOAD,
            Location::link("torso"),
            &[("mass", 0.9), ("x", 0.07), ("y", -0.03), ("z", 0.3)],
        ),
        Effect::new(
            &kinds::COM_OFFSET,
            Location::link("left_lower_leg"),
            &[("x", 0.03), ("y", 0.02), ("z", -0.05)],
        ),
        Effect::new(
            &kinds::INERTIA_ERROR,
            Location::link("torso"),
            &[("ixx", 0.2), ("iyy", 0.3), ("ixz", 0.1)],
        ),
    ] {
        let change = subjects.link_inertias.change(std::slice::from_ref(&effect));
        let made = Made { change: change.to_vec(), ..Made::plain(Feet::World) };
        check(&subjects, &made, std::slice::from_ref(&effect));
        let error = with_experiment(&subjects, &made, |experiment| inertial_error(experiment, &effect));
        assert!(error < 1e-9, "{error}");
        let corners = Made { change: made.change.clone(), ..Made::plain(Feet::Corners) };
        if effect.kind.name != "inertia_error" {
            check(&subjects, &corners, &[effect]);
        }
    }
}

#[test]
#[ignore = "takes long"]
fn joints_and_world() {
    let subjects = Subjects::named("tulip");
    let knee = "right_knee_pitch";
    let index = subjects.layout.joints.iter().position(|j| j.name == knee).unwrap();
    let offset = Effect::new(&kinds::ENCODER_OFFSET, Location::joint(knee), &[("offset", 0.05)]);
    let made = Made { offset: (index, 0.05), ..Made::plain(Feet::Sole) };
    check(&subjects, &made, std::slice::from_ref(&offset));
    let tilt = Effect::new(&kinds::GRAVITY_TILT, Location::default(), &[("roll", 0.05), ("pitch", -0.08)]);
    let turn = Rotation3::new(Vector3::y() * -0.08) * Rotation3::new(Vector3::x() * 0.05);
    let made = Made { tilt: turn.into_inner(), ..Made::plain(Feet::World) };
    check(&subjects, &made, std::slice::from_ref(&tilt));
    let both = Made { tilt: turn.into_inner(), offset: (index, 0.05), ..Made::plain(Feet::Sole) };
    check(&subjects, &both, &[offset, tilt]);
}

#[test]
#[ignore = "takes long"]
fn force_sensors() {
    let subjects = Subjects::named("tulip");
    let gain = |place: Location, gain: f64| Effect::new(&kinds::FORCE_SENSOR_GAIN, place, &[("gain", gain)]);
    let bias = |place: Location, [x, y, z]: [f64; 3]| {
        Effect::new(&kinds::FORCE_SENSOR_BIAS, place, &[("x", x), ("y", y), ("z", z)])
    };
    for feet in [Feet::World, Feet::Sole] {
        let all = Made { report: &|_, _, f| f * 1.1, torque_gain: [1.1; 2], ..Made::plain(feet) };
        check(&subjects, &all, &[gain(Location::default(), 1.1)]);
        let left = |f: usize, _: Option<usize>, x: Vector3<f64>| if f == 1 { x * 0.9 } else { x };
        let left = Made { report: &left, torque_gain: [1.0, 0.9], ..Made::plain(feet) };
        check(&subjects, &left, &[gain(Location::sensor("left_foot"), 0.9)]);
        let shift = Vector3::new(3.0, -2.0, 5.0);
        let right = |f: usize, _: Option<usize>, x: Vector3<f64>| if f == 0 { x + shift } else { x };
        let effect = bias(Location::sensor("right_foot"), [3.0, -2.0, 5.0]);
        check(&subjects, &Made { report: &right, ..Made::plain(feet) }, &[effect]);
    }
    let corner =
        |f: usize, k: Option<usize>, x: Vector3<f64>| if (f, k) == (0, Some(2)) { x * 1.2 } else { x };
    let made = Made { report: &corner, ..Made::plain(Feet::Corners) };
    check(&subjects, &made, &[gain(Location::sensor("right_foot/rear_left"), 1.2)]);
    let corner = |f: usize, k: Option<usize>, x: Vector3<f64>| {
        if (f, k) == (1, Some(0)) { x + Vector3::z() * 4.0 } else { x }
    };
    let made = Made { report: &corner, ..Made::plain(Feet::Corners) };
    check(&subjects, &made, &[bias(Location::sensor("left_foot/front_left"), [0.0, 0.0, 4.0])]);
}

#[test]
#[ignore = "takes long"]
fn a_saturated_corner() {
    let subjects = Subjects::named("tulip");
    let place = Location::sensor("right_foot/front_left");
    let clip = |f: usize, k: Option<usize>, x: Vector3<f64>| {
        if (f, k) == (0, Some(0)) { Vector3::z() * x.z.min(29.0) } else { x }
    };
    let made = Made { report: &clip, ..Made::plain(Feet::Corners) };
    with_experiment(&subjects, &made, |experiment| {
        let rows: Vec<usize> = (0..experiment.rows().len()).collect();
        let guess = experiment.guess(&kinds::FORCE_SENSOR_SATURATION, &place).expect("it stays at its limit");
        assert!((guess.value("limit") - 29.0).abs() < 1e-6);
        let [before, after] = [rms(experiment, &rows, &[]), rms(experiment, &rows, &[guess])];
        println!("saturation: {before} to {after}");
        assert!(after < 0.1 * before);
        let contradicted = Effect::new(&kinds::FORCE_SENSOR_SATURATION, place, &[("limit", 25.0)]);
        assert!(experiment.response(&[contradicted]).is_empty(), "readings above the limit contradict it");
    });
}

#[test]
#[ignore = "takes long"]
fn neutral_parameters_change_nothing() {
    let subjects = Subjects::named("tulip");
    with_experiment(&subjects, &Made::plain(Feet::World), |experiment| {
        for (kind, place) in experiment.candidates() {
            let value = if *kind == kinds::FORCE_SENSOR_GAIN { 1.0 } else { 0.0 };
            let mut effect = Effect::new(kind, place, &[]);
            let names: Vec<String> = effect.kind.estimated().map(|p| p.name.to_owned()).collect();
            effect.parameters.extend(names.into_iter().map(|name| (name, value)));
            let response = experiment.response(std::slice::from_ref(&effect));
            let largest = response.iter().flat_map(|(_, v)| v).fold(0.0_f64, |m, x| m.max(x.abs()));
            assert!(largest < 1e-9, "{effect}: {largest}");
        }
        let nothing = ["foot_slip", "spin_friction", "ground_compliance", "ground_slope", "no_impact"];
        for kind in nothing.map(|name| effect::kind(name).unwrap()) {
            assert!(experiment.response(&[Effect::new(kind, Location::default(), &[])]).is_empty(), "{kind}");
        }
    });
}
