//! The whole hybrid model on the constraint surface: event-driven simulation under virtual constraints that are interpreted from
//! formulas, against what the zero dynamics say of it.
use super::{bent, gait, relative, robot};
use bipedc::gait::{GaitBench, StepOptions};
use bipedc::simulation::{in_world, plant, true_walker};
use bipedc_analysis::gait::Course;
use bipedc_analysis::simulate::phases::{WalkEnd, WalkSummary};
use bipedc_analysis::simulate::{Run, Sample, Scenario};
use bipedc_runtime::control::{Borrowed, Controller};
use std::fmt::Write;
use std::path::Path;

/// A robot's gait as a scenario says it.
pub(super) struct Gaited {
    pub(super) folder: &'static str,
    /// Joints in the order of q after the base.
    pub(super) joints: &'static [&'static str],
    /// φ, as a formula of the scenario.
    variable: &'static str,
    /// Name and controlled quantity of each output; `WANTED` stands for h_d, with `s` for the phase and `end` for φ₋.
    outputs: &'static [(&'static str, &'static str)],
    /// Names of the gait parameters, in the order of the file.
    parameters: &'static [&'static str],
    /// φ and φ̇ of a state whose stance leg comes first.
    pub(super) phase: fn(&[f64]) -> f64,
    pub(super) gravity: &'static str,
    pub(super) effects: &'static str,
}

pub(super) const THREE: Gaited = Gaited {
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

pub(super) const FIVE: Gaited = Gaited {
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

/// A step as a scenario says it.
struct Wanted<'c> {
    values: &'c [f64],
    course: &'c Course<'c, 'c>,
}

impl Wanted<'_> {
    /// Numbers by name, each with this ending.
    fn parameters(&self, gaited: &Gaited, ending: &str) -> String {
        let [start, end] = self.course.ends();
        let mut text = format!("start{ending} = {start:?}\nend{ending} = {end:?}\n");
        for (name, value) in gaited.parameters.iter().zip(self.values) {
            if *name != "step_length" {
                writeln!(text, "{name}{ending} = {value:?}").unwrap();
            }
        }
        let matching = &self.course.arguments(start)[3 + self.values.len()..];
        for (index, pair) in matching.chunks_exact(2).enumerate() {
            let [value, slope] = [pair[0], pair[1]];
            writeln!(text, "value_{index}{ending} = {value:?}\nslope_{index}{ending} = {slope:?}").unwrap();
        }
        text
    }

    /// An output as a formula of these numbers.
    fn output(&self, gaited: &Gaited, index: usize, ending: &str) -> String {
        let (controlled, wanted) = gaited.outputs[index];
        let mut wanted = wanted.to_owned();
        for name in gaited.parameters.iter().chain(&["end"]) {
            wanted = wanted.replace(name, &format!("{name}{ending}"));
        }
        let length = format!("(end{ending} - start{ending})");
        let part = format!("((line - start{ending}) / {length})");
        format!(
            "{controlled} - ({wanted}) - (value_{index}{ending} * (1 + 2 * {part}) \
             + slope_{index}{ending} * {length} * {part}) * (1 - {part})^2"
        )
    }
}

/// A scenario that begins on the surface at φ₊ with this energy and takes two steps. Which one it is tells the place of the foot that
/// stands: a step ahead in the second.
fn scenario(gaited: &Gaited, [first, second]: [&Wanted<'_>; 2], energy: f64) -> String {
    let start = first.course.start;
    let point = first.course.surface(start).unwrap();
    let rate = first.course.rates(start, energy).unwrap()[0];
    let length = first.values[0];
    let mut text = format!(
        "method = \"event_driven\"\nduration = 10.0\nsteps = 2\nlog_step = 0.002\nrelative_tolerance = 1e-13\n{}\
         [assumptions]\nfriction = 100.0\nscuffing = false\npushing = false\nsecond_impact = false\nlevel = 1.0\n\
         step_length = {length}\n[initial]\nbase_rotation = [{:?}]\nbase_angular_velocity = [{:?}]\n[joint]\n",
        gaited.gravity,
        point.q[2],
        point.slope[2] * rate
    );
    for (index, joint) in gaited.joints.iter().enumerate() {
        let (q, v) = (point.q[3 + index], point.slope[3 + index] * rate);
        writeln!(text, "{joint} = {{ position = {q:?}, velocity = {v:?} }}").unwrap();
    }
    text += "[control]\neffort_limits = false\njoint_stops = false\n[control.feedback]\nlaw = \"pd\"\n";
    text += "stiffness = 400.0\ndamping = 40.0\n[control.parameters]\n";
    text += &(first.parameters(gaited, "_a") + &second.parameters(gaited, "_b"));
    writeln!(text, "[control.quantities]\nline = \"{}\"", gaited.variable).unwrap();
    // The walk begins with the base at 0, not the foot.
    let foot = -point.q[0];
    writeln!(text, "later = \"clip((right_foot_point_foot_x - {foot:?}) / {length}, 0, 1)\"").unwrap();
    for index in 0..gaited.outputs.len() {
        let (a, b) = (first.output(gaited, index, "_a"), second.output(gaited, index, "_b"));
        writeln!(text, "[[control.output]]\nformula = \"(1 - later) * ({a}) + later * ({b})\"").unwrap();
    }
    text + gaited.effects
}

fn walked(folder: &str, text: &str) -> (WalkSummary, Vec<Sample>) {
    walk(folder, text, None)
}

/// Walks under a controller, or else under the scenario's outputs.
pub(super) fn walk(
    folder: &str,
    text: &str,
    controller: Option<&mut dyn Controller<f64>>,
) -> (WalkSummary, Vec<Sample>) {
    let robot = robot(folder);
    let plant = plant(&robot.description, &robot.tree().unwrap()).unwrap();
    let scenario =
        Scenario::parse(Path::new("scenario.toml"), text, &plant).unwrap_or_else(|e| panic!("{e}\n{text}"));
    let robot = in_world(robot, &scenario.world);
    let walker = true_walker(&robot, &scenario.effects, false).unwrap();
    let walking = walker.walking(&plant, &scenario);
    let mut samples = Vec::new();
    let mut run = Run { row: &mut |_| Ok(()), progress: &|_| (), stop: &|| false };
    let mut watch = |sample: &Sample| samples.push(sample.clone());
    let summary = match controller {
        Some(controller) => walking.run_with(Borrowed(controller), &mut run, &mut watch),
        None => walking.run(&mut run, &mut watch),
    };
    (summary.unwrap_or_else(|e| panic!("{e}")), samples)
}

/// The other leg first.
pub(super) fn swapped(x: &[f64]) -> Vec<f64> {
    let half = (x.len() - 3) / 2;
    [&x[..3], &x[3 + half..], &x[3..3 + half]].concat()
}

/// Walks two steps, the second with other parameters; how far the mid-stance speed of the second and all its phase velocities are
/// from those of the zero dynamics.
fn compare(gaited: &Gaited, bench: &GaitBench, [from, to]: [&[f64]; 2], speed: f64) -> [f64; 2] {
    let named = |values: &[f64]| {
        gaited.parameters.iter().map(|name| (*name).to_owned()).zip(values.iter().copied()).collect()
    };
    let stepped = bench
        .step(&StepOptions { speed, set: named(to), from: named(from), ..StepOptions::default() })
        .unwrap()
        .step;
    let model = bench.model().unwrap();
    let now = model.steady_course(from).unwrap();
    let course = model.course(to, &now.landing).unwrap();
    let [first, second] = [Wanted { values: from, course: &now }, Wanted { values: to, course: &course }];
    let text = scenario(gaited, [&first, &second], stepped.energy.unwrap());
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

fn walks_as_said(gaited: &Gaited, bench: &GaitBench, steps: [&[f64]; 2], speed: f64) {
    let [mid_stance, everywhere] = compare(gaited, bench, steps, speed);
    println!("{} {steps:?}: mid-stance {mid_stance:.1e}, everywhere {everywhere:.1e}", gaited.folder);
    assert!(mid_stance < 1e-9 && everywhere < 1e-9, "{steps:?}: {mid_stance:e} {everywhere:e}");
}

#[test]
fn three_link_walks_as_its_zero_dynamics_say() {
    let bench = gait(THREE.folder, "thesis");
    for (values, speed) in [([0.5, -0.5], 1.5), ([0.4, -0.6], 1.2), ([0.7, -0.8], 2.0)] {
        walks_as_said(&THREE, &bench, [&values, &values], speed);
    }
}

#[test]
fn five_link_walks_as_its_zero_dynamics_say() {
    let bench = gait(FIVE.folder, "thesis");
    for (values, speed) in [([0.4, 0.2, 0.3], 1.0), ([0.3, 0.4, 0.15], 1.5), ([0.5, 0.5, 0.1], 1.3)] {
        walks_as_said(&FIVE, &bench, [&values, &values], speed);
    }
}

#[test]
fn steps_with_other_parameters_are_walked_as_said() {
    let [three, five] = [&THREE, &FIVE].map(|gaited| gait(gaited.folder, "thesis"));
    walks_as_said(&THREE, &three, [&[0.5, -0.5], &[0.6, -0.3]], 1.5);
    walks_as_said(&THREE, &three, [&[0.4, -0.6], &[0.7, -0.7]], 1.5);
    walks_as_said(&FIVE, &five, [&[0.4, 0.2, 0.2], &[0.45, 0.4, 0.1]], 1.3);
}

#[test]
fn outputs_that_are_not_affine_walk_as_their_zero_dynamics_say() {
    walks_as_said(&BENT, &bent(), [&[0.5, -0.5], &[0.5, -0.5]], 1.5);
}
