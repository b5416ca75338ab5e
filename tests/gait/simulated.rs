//! The whole hybrid model on the constraint surface: event-driven simulation under virtual constraints that are interpreted from
//! formulas, against what the zero dynamics say of it.
use super::{bent, gait, relative, robot};
use bipedc::gait::{GaitBench, StepOptions};
use bipedc::simulation::{in_world, plant, true_walker};
use bipedc_analysis::gait::Course;
use bipedc_analysis::simulate::phases::{WalkEnd, WalkSummary, Walking};
use bipedc_analysis::simulate::{Run, Sample, Scenario};
use std::fmt::Write;
use std::path::Path;

/// A robot's gait as a scenario says it.
struct Gaited {
    folder: &'static str,
    /// Joints in the order of q after the base.
    joints: &'static [&'static str],
    /// φ, as a formula of the scenario.
    variable: &'static str,
    /// Name and controlled quantity of each output; `WANTED` stands for h_d, with `s` for the phase and `end` for φ₋.
    outputs: &'static [(&'static str, &'static str)],
    /// Names of the gait parameters, in the order of the file.
    parameters: &'static [&'static str],
    /// φ and φ̇ of a state whose stance leg comes first.
    phase: fn(&[f64]) -> f64,
    gravity: &'static str,
    effects: &'static str,
}

const THREE: Gaited = Gaited {
    folder: "robots/three_link",
    joints: &["right_hip_pitch", "left_hip_pitch"],
    variable: "base_pitch + right_hip_pitch",
    outputs: &[("base_pitch", "-torso_lean"), ("base_pitch + left_hip_pitch", "-line")],
    parameters: &["step_length", "torso_lean"],
    phase: |x| x[2] + x[3],
    gravity: "gravity = 9.8\n",
    effects: "[[effect]]\nkind = \"inertia_error\"\nlink = \"right_leg\"\nixx = -1e-4\nixy = 0.0\nixz = 0.0\niyy = -1e-4\n\
              iyz = 0.0\nizz = -1e-4\n[[effect]]\nkind = \"inertia_error\"\nlink = \"left_leg\"\nixx = -1e-4\nixy = 0.0\n\
              ixz = 0.0\niyy = -1e-4\niyz = 0.0\nizz = -1e-4\n",
};

const FIVE: Gaited = Gaited {
    folder: "robots/five_link",
    joints: &["right_hip_pitch", "right_knee_pitch", "left_hip_pitch", "left_knee_pitch"],
    variable: "base_pitch + right_hip_pitch + 0.5 * right_knee_pitch",
    outputs: &[
        ("base_pitch", "torso_lean"),
        ("right_knee_pitch", "knee * (1 - (line / end)^2)^2"),
        ("base_pitch + left_hip_pitch + 0.5 * left_knee_pitch", "-line"),
        ("left_knee_pitch", "knee * (1 - (line / end)^2)^2"),
    ],
    parameters: &["step_length", "torso_lean", "knee"],
    phase: |x| x[2] + x[3] + 0.5 * x[4],
    gravity: "",
    effects: "",
};

/// Outputs that are no sums of joint angles: their surface is found by iteration.
const BENT: Gaited = Gaited {
    outputs: &[("tan(base_pitch)", "-tan(torso_lean)"), ("sin(base_pitch + left_hip_pitch)", "-sin(line)")],
    ..THREE
};

/// A scenario that begins on the surface at φ₊ with this energy and takes two steps.
fn scenario(gaited: &Gaited, values: &[f64], course: &Course<'_, '_>, energy: f64) -> String {
    let [start, end] = course.ends();
    let point = course.surface(start).unwrap();
    let rate = course.rates(start, energy).unwrap()[0];
    let mut text = format!(
        "method = \"event_driven\"\nduration = 10.0\nsteps = 2\nlog_step = 0.002\nrelative_tolerance = 1e-13\n{}\
         [assumptions]\nfriction = 100.0\nscuffing = false\npushing = false\nsecond_impact = false\nstep_length = {}\n\
         [initial]\nbase_rotation = [{:?}]\nbase_angular_velocity = [{:?}]\n[joint]\n",
        gaited.gravity,
        values[0],
        point.q[2],
        point.slope[2] * rate
    );
    for (index, joint) in gaited.joints.iter().enumerate() {
        let (q, v) = (point.q[3 + index], point.slope[3 + index] * rate);
        writeln!(text, "{joint} = {{ position = {q:?}, velocity = {v:?} }}").unwrap();
    }
    text += "[control]\neffort_limits = false\njoint_stops = false\n[control.feedback]\nlaw = \"pd\"\n";
    text += "stiffness = 400.0\ndamping = 40.0\n[control.parameters]\n";
    writeln!(text, "start = {start:?}\nend = {end:?}").unwrap();
    for (name, value) in gaited.parameters.iter().zip(values) {
        if *name != "step_length" {
            writeln!(text, "{name} = {value:?}").unwrap();
        }
    }
    let matching = &course.arguments(start)[3 + values.len()..];
    for (index, pair) in matching.chunks_exact(2).enumerate() {
        writeln!(text, "value_{index} = {:?}\nslope_{index} = {:?}", pair[0], pair[1]).unwrap();
    }
    writeln!(text, "[control.quantities]\nline = \"{}\"", gaited.variable).unwrap();
    text += "part = \"(line - start) / (end - start)\"\n";
    for (index, (controlled, wanted)) in gaited.outputs.iter().enumerate() {
        let cubic =
            format!("(value_{index} * (1 + 2 * part) + slope_{index} * (end - start) * part) * (1 - part)^2");
        writeln!(text, "[[control.output]]\nformula = \"{controlled} - ({wanted}) - {cubic}\"").unwrap();
    }
    text + gaited.effects
}

fn walked(folder: &str, text: &str) -> (WalkSummary, Vec<Sample>) {
    let robot = robot(folder);
    let plant = plant(&robot.description, &robot.tree().unwrap()).unwrap();
    let scenario =
        Scenario::parse(Path::new("scenario.toml"), text, &plant).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let robot = in_world(robot, &scenario.world);
    let walker = true_walker(&robot, &scenario.effects, false).unwrap();
    let walking =
        Walking { model: &walker.model, phases: &walker.phases, plant: &plant, scenario: &scenario };
    let mut samples = Vec::new();
    let mut run = Run { row: &mut |_| Ok(()), progress: &|_| (), stop: &|| false };
    let summary = walking.run(&mut run, &mut |sample| samples.push(sample.clone())).unwrap();
    (summary, samples)
}

/// The other leg first.
fn swapped(x: &[f64]) -> Vec<f64> {
    let half = (x.len() - 3) / 2;
    [&x[..3], &x[3 + half..], &x[3..3 + half]].concat()
}

/// Walks two steps; how far the mid-stance speed of the second and all its phase velocities are from those of the zero dynamics.
fn compare(gaited: &Gaited, bench: &GaitBench, values: &[f64], speed: f64) -> [f64; 2] {
    let set = gaited.parameters.iter().map(|name| (*name).to_owned()).zip(values.iter().copied()).collect();
    let stepped = bench.step(&StepOptions { speed, set, from: Vec::new() }).unwrap().step;
    let model = bench.model().unwrap();
    let course = model.steady_course(values).unwrap();
    let text = scenario(gaited, values, &course, stepped.energy.unwrap());
    let (summary, samples) = walked(gaited.folder, &text);
    assert_eq!((summary.end, summary.steps), (WalkEnd::Steps, 2), "{:?}", summary.verdict);
    let [landed, last] = [summary.changes[0].time, summary.changes[1].time];
    let energy = stepped.next_energy.unwrap();
    let (mut mid_stance, mut everywhere, mut rows) = (0.0_f64, 0.0_f64, 0);
    for sample in samples.iter().filter(|s| s.time > landed + 1e-9 && s.time < last - 1e-9) {
        let (phase, rate) = ((gaited.phase)(&swapped(&sample.q)), (gaited.phase)(&swapped(&sample.v)));
        everywhere = everywhere.max(relative(rate, course.rates(phase, energy).unwrap()[0]));
        // The same row's speed at the dead centre, where the energy takes it.
        let alpha = course.zero_dynamics(phase).unwrap()[0];
        let own = 0.5 * (alpha * rate).powi(2) + course.potential(phase).unwrap();
        mid_stance = mid_stance.max(relative(course.speed(own).unwrap(), stepped.next_speed.unwrap()));
        rows += 1;
    }
    assert!(rows > 100, "{rows}");
    [mid_stance, everywhere]
}

#[test]
fn three_link_walks_as_its_zero_dynamics_say() {
    let bench = gait(THREE.folder, "thesis");
    for (values, speed) in [([0.5, -0.5], 1.5), ([0.4, -0.6], 1.2), ([0.7, -0.8], 2.0)] {
        let [mid_stance, everywhere] = compare(&THREE, &bench, &values, speed);
        println!("three_link {values:?}: mid-stance {mid_stance:.1e}, everywhere {everywhere:.1e}");
        assert!(mid_stance < 1e-9 && everywhere < 1e-9, "{values:?}: {mid_stance:e} {everywhere:e}");
    }
}

#[test]
fn outputs_that_are_not_affine_walk_as_their_zero_dynamics_say() {
    let bench = bent();
    let [mid_stance, everywhere] = compare(&BENT, &bench, &[0.5, -0.5], 1.5);
    println!(
        "three_link, outputs that are not affine: mid-stance {mid_stance:.1e}, everywhere {everywhere:.1e}"
    );
    assert!(mid_stance < 1e-9 && everywhere < 1e-9, "{mid_stance:e} {everywhere:e}");
}

#[test]
fn five_link_walks_as_its_zero_dynamics_say() {
    let bench = gait(FIVE.folder, "thesis");
    for (values, speed) in [([0.4, 0.2, 0.3], 1.0), ([0.3, 0.4, 0.15], 1.5), ([0.5, 0.5, 0.1], 1.3)] {
        let [mid_stance, everywhere] = compare(&FIVE, &bench, &values, speed);
        println!("five_link {values:?}: mid-stance {mid_stance:.1e}, everywhere {everywhere:.1e}");
        assert!(mid_stance < 1e-9 && everywhere < 1e-9, "{values:?}: {mid_stance:e} {everywhere:e}");
    }
}
