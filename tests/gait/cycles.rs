//! `bipedc gait cycle`: fixed points of the step, their multiplier, work and what the impact takes.
use super::{gait, relative};
use crate::cli::{bipedc, scratch, text};
use bipedc::gait::{CycleOptions, GaitBench, Over, Range, StepOptions, Stepped};
use bipedc::progress::{Run, Silent};
use bipedc_analysis::gait::Cycle;
use bipedc_runtime::{Argument, Model, State};
use roxmltree::Document;

/// Gaits with values of their parameters.
const GAITS: [(&str, &[(&str, f64)]); 4] = [
    ("robots/three_link", &[]),
    ("robots/three_link", &[("step_length", 0.7), ("torso_lean", -0.9)]),
    ("robots/five_link", &[]),
    ("robots/five_link", &[("step_length", 0.55), ("torso_lean", 0.5), ("knee", 0.6)]),
];

fn set(values: &[(&str, f64)]) -> Vec<(String, f64)> {
    values.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect()
}

fn cycle(bench: &GaitBench, values: &[(&str, f64)]) -> Cycle {
    let options = CycleOptions { set: set(values), over: None };
    let run = Run { progress: &Silent, stop: &|| false };
    bench.cycles(&options, &run).unwrap().cycles[0].cycle.unwrap()
}

#[test]
fn a_cycle_repeats_itself_and_its_multiplier_is_the_slope_of_the_step() {
    for (folder, values) in GAITS {
        let bench = gait(folder, "thesis");
        let found = cycle(&bench, values);
        let next = |speed: f64| {
            let asked = StepOptions { speed, set: set(values), ..StepOptions::default() };
            bench.step(&asked).unwrap().step.next_speed.unwrap()
        };
        assert!(relative(next(found.speed), found.speed) < 1e-12, "{folder}: {found:?}");
        let h = 1e-4;
        let slope = (next(found.speed + h) - next(found.speed - h)) / (2.0 * h);
        assert!((slope - found.multiplier).abs() < 1e-6, "{folder}: {slope} {found:?}");
    }
}

/// On level ground a cycle's torques give what the impact takes: work over the course against energies of the whole robot before
/// and after the impact.
#[test]
fn the_work_of_a_cycle_is_the_energy_that_the_impact_takes() {
    for (folder, values) in GAITS {
        let bench = gait(folder, "thesis");
        let found = cycle(&bench, values);
        let model = bench.model().unwrap();
        let mut parameters: Vec<f64> = bench.gait.parameters.iter().map(|p| p.default).collect();
        for (name, value) in values {
            let index = bench.gait.parameters.iter().position(|p| p.name == *name).unwrap();
            parameters[index] = *value;
        }
        let course = model.steady_course(&parameters).unwrap();
        let landing = &course.landing;
        let energy = landing.delta * course.p_minus / (landing.delta - 1.0);
        let rate = course.rates(landing.end, energy).unwrap()[0];
        let kinetic = |q: &[f64], v: &[f64]| {
            let v: Vec<f64> = v.iter().map(|x| x * rate).collect();
            // v · D v by inverse dynamics: with a = v and no velocity, less gravity.
            let rest = vec![0.0; v.len()];
            let torques = |a: &[f64]| inverse_dynamics(&bench, q, &rest, a);
            let (moving, still) = (torques(&v), torques(&rest));
            0.5 * v.iter().zip(moving.iter().zip(&still)).map(|(v, (m, s))| v * (m - s)).sum::<f64>()
        };
        let lost = kinetic(&landing.before.q, &landing.before.slope) - kinetic(&landing.q, &landing.v);
        println!("{folder}: {} J by torques, {lost} J lost", found.net_work);
        assert!(relative(found.net_work, lost) < 1e-6, "{folder}: {} {lost}", found.net_work);
        assert!(found.work >= found.net_work && found.cost_of_transport > 0.0, "{found:?}");
        assert!(relative(found.walking_speed * found.duration, found.step_length) < 1e-12);
        let asked = parameters[bench.gait.parameters.iter().position(|p| p.name == "step_length").unwrap()];
        assert!((found.step_length - asked).abs() < 1e-9, "{found:?}");
    }
}

fn inverse_dynamics(bench: &GaitBench, q: &[f64], v: &[f64], a: &[f64]) -> Vec<f64> {
    let model = bipedc_compiler::compile::ProgramModel::new(bench.compiled().model.clone());
    let function = Model::<f64>::function(&model, "inverse_dynamics").unwrap();
    let state = State::new().with(Argument::Q, q).with(Argument::V, v).with(Argument::A, a);
    let mut out = vec![0.0; q.len()];
    model.evaluate(function, &state, &mut out).unwrap();
    out
}

/// The step's duration against the phase integrated over time by itself.
#[test]
fn the_duration_of_a_cycle_is_that_of_its_motion() {
    let bench = gait("robots/five_link", "thesis");
    let found = cycle(&bench, &[]);
    let model = bench.model().unwrap();
    let parameters: Vec<f64> = bench.gait.parameters.iter().map(|p| p.default).collect();
    let course = model.steady_course(&parameters).unwrap();
    let energy = course.landing.delta * course.p_minus / (course.landing.delta - 1.0);
    let [start, end] = course.ends();
    let count = 20_000;
    let width = (end - start) / f64::from(count);
    let middle = (0..count).map(|k| start + (f64::from(k) + 0.5) * width);
    let time: f64 = middle.map(|phase| width / course.rates(phase, energy).unwrap()[0]).sum();
    assert!(relative(found.duration, time) < 1e-7, "{} {time}", found.duration);
}

#[test]
fn parameters_without_a_cycle_have_a_reason() {
    let run = |arguments: &[&str]| {
        bipedc(&[&["gait", "cycle", "robots/three_link", "--gait", "thesis"], arguments].concat())
    };
    let found = run(&["--set", "torso_lean=0.4", "--json"]).ok().json();
    let one = &found["cycles"][0];
    assert!(one["cycle"].is_null() && one["reason"].as_str().unwrap().contains("slower"), "{one}");
    assert!(run(&["--set", "torso_lean=0.4"]).ok().out.contains("no cycle: each step is slower"));
    let unreachable = run(&["--set", "step_length=2.5", "--json"]).ok().json();
    assert!(unreachable["cycles"][0]["reason"].as_str().unwrap().contains("guard"), "{unreachable}");
    run(&["--over", "step_length=1:0:4"]).fails_with(&["the smaller end first"]);
    run(&["--over", "step_length=0:1:4", "--set", "step_length=1"]).fails_with(&["fixed and has a range"]);
    run(&["--set", "knee=1"]).fails_with(&["no parameter `knee`"]);
    assert_eq!(run(&["--svg", "x.svg"]).code, Some(2));
}

#[test]
fn lists_of_cycles_are_whole() {
    let folder = scratch("gait_cycles");
    let paths = ["cycles.svg", "cycles.csv", "cycles.html"].map(|name| folder.join(name));
    let [svg, csv, page] = &paths;
    let fixed = ["gait", "cycle", "robots/three_link", "--gait", "thesis", "--over", "torso_lean=-1:0.4:6"];
    let files = ["--svg", text(svg), "--csv", text(csv), "--page", text(page)];
    let printed = bipedc(&[&fixed[..], &files].concat()).ok().out;
    assert!(printed.contains("torso_lean (rad)") && printed.contains('—'), "{printed}");
    let read = |path| std::fs::read_to_string(path).unwrap();
    Document::parse(&read(svg)).unwrap();
    assert_eq!(read(csv).lines().count(), 7);
    assert!(read(page).contains("cost of transport"));
    // A cycle of a list is the cycle alone.
    let list = bipedc(&[&fixed[..], &["--json"]].concat()).ok().json();
    let bench = gait("robots/three_link", "thesis");
    let first = cycle(&bench, &[("torso_lean", -1.0)]);
    assert_eq!(list["cycles"][0]["cycle"]["speed"].as_f64(), Some(first.speed));
    assert_eq!(list["cycles"][0]["cycle"]["cost_of_transport"].as_f64(), Some(first.cost_of_transport));
    // Leaning forward is faster (7.2.1), with --over as with --set.
    let speeds: Vec<f64> = (0..6).filter_map(|k| list["cycles"][k]["cycle"]["speed"].as_f64()).collect();
    assert!(speeds.len() >= 3 && speeds.windows(2).all(|pair| pair[0] > pair[1]), "{speeds:?}");
    let range = Over { name: "torso_lean".to_owned(), range: Range { low: -1.0, high: 0.4, count: 6 } };
    let options = CycleOptions { set: Vec::new(), over: Some(range) };
    let stopped = bench.cycles(&options, &Run { progress: &Silent, stop: &|| true }).unwrap();
    assert!(stopped.cycles.len() <= 6 && stopped.complete == (stopped.cycles.len() == 6));
}

/// Whether a step keeps what cycles assume: feet push and do not slip, torques stay within the efforts.
fn keeps(found: &Stepped) -> bool {
    let margins = found.step.margins;
    let all = [margins.friction, margins.pull, margins.torque, margins.impact_friction, margins.impact_pull];
    all.into_iter().chain([margins.lift_off]).all(|margin| margin.is_some_and(|margin| margin >= 0.0))
}

#[test]
fn steps_keep_everything_between_the_least_and_the_largest_kinetic_energy() {
    for (folder, values) in GAITS {
        let bench = gait(folder, "thesis");
        let found = cycle(&bench, values);
        let step = |speed: f64| {
            bench.step(&StepOptions { speed, set: set(values), ..StepOptions::default() }).unwrap()
        };
        let steady = step(found.speed);
        assert!(relative(found.energy, steady.step.energy.unwrap()) < 1e-12, "{folder}: {found:?}");
        let (Some(low), Some(high)) = (found.k_min, found.k_max) else {
            // No speed keeps everything.
            for k in 1..=12 {
                assert!(!keeps(&step(0.25 * f64::from(k))), "{folder} {values:?}: {k}");
            }
            assert_eq!(found.basin, [None; 2]);
            continue;
        };
        assert_eq!([steady.step.k_min, steady.step.k_max], [Some(low), Some(high)], "{folder}");
        let mut both = [0; 2];
        for k in 1..=60 {
            let next = step(0.06 * f64::from(k));
            let Some(energy) = next.step.next_energy.filter(|_| next.step.feasible) else { continue };
            let kinetic = energy - next.step.p_max.unwrap();
            // Limits are asked for at 49 places of the phase, margins are refined between them.
            if (kinetic - low).abs() < 0.02 * high || (kinetic - high).abs() < 0.02 * high {
                continue;
            }
            let inside = (low..=high).contains(&kinetic);
            both[usize::from(inside)] += 1;
            assert_eq!(keeps(&next), inside, "{folder} {values:?}: {kinetic} of {low} to {high}");
        }
        println!("{folder} {values:?}: {low} to {high}, {both:?} steps out and in");
        assert!(both[1] > 5, "{folder}: {both:?}");
    }
}

#[test]
fn steps_from_the_basin_come_back_to_the_cycle() {
    let mut limited = 0;
    for (folder, values) in GAITS {
        let bench = gait(folder, "thesis");
        let found = cycle(&bench, values);
        let Some(high) = found.basin[1] else { continue };
        limited += 1;
        let low = found.basin[0].unwrap();
        assert!((low..=high).contains(&found.speed), "{found:?}");
        for begin in [low + 0.02 * found.speed, 0.98 * high] {
            let mut speed = begin;
            for _ in 0..60 {
                let next =
                    bench.step(&StepOptions { speed, set: set(values), ..StepOptions::default() }).unwrap();
                assert!(keeps(&next), "{folder} {values:?} from {begin}: {:?}", next.step.margins);
                speed = next.step.next_speed.unwrap();
            }
            let left = (speed - found.speed).abs() / (begin - found.speed).abs();
            assert!(left < 2.0 * found.multiplier.powi(60) + 1e-9, "{folder} {begin}: {speed} {found:?}");
        }
    }
    assert!(limited >= 1);
}

/// On its constraints the whole robot has the multiplier of the zero dynamics; h_p takes up every other deviation within a step.
#[test]
fn the_whole_robot_has_the_multiplier_of_its_zero_dynamics_and_no_other() {
    for folder in ["robots/three_link", "robots/five_link"] {
        let found = bipedc(&["gait", "cycle", folder, "--gait", "thesis", "--json"]).ok().json();
        let of = &found["cycles"][0];
        let all: Vec<[f64; 2]> = serde_json::from_value(of["whole"]["multipliers"].clone()).unwrap();
        let size = |[real, imaginary]: [f64; 2]| real.hypot(imaginary);
        let known = of["cycle"]["multiplier"].as_f64().unwrap();
        println!("{folder}: {known} {all:?}");
        assert!((all[0][0] - known).abs() < 1e-5 && all[0][1].abs() < 1e-5, "{folder}: {known} {all:?}");
        assert!(all[1..].iter().all(|x| size(*x) < 1e-3), "{folder}: {all:?}");
        assert!(of["whole"]["miss"].as_f64().unwrap() < 1e-8, "{of}");
        // Where it begins the zero dynamics' cycle is its own.
        let own = |key: &str| of["whole"]["repeats"][key].as_f64().unwrap();
        assert!(own("off") < 1e-8 && own("miss") < 1e-8, "{of}");
        // All directions in which the foot stays, twice, less that of the motion itself.
        let joints = if folder.ends_with("three_link") { 2 } else { 4 };
        assert_eq!(all.len(), 2 * (joints + 1) - 1);
    }
}

/// Where torques meet their limits the whole robot's cycle is not that of the zero dynamics: Newton's method finds it from there, and a step comes back a million times nearer.
#[test]
#[ignore = "takes long"]
fn newtons_method_finds_the_whole_robots_own_cycle() {
    let found = bipedc(&["gait", "cycle", "robots/seven_link_v1", "--gait", "firm", "--json"]).ok().json();
    let whole = &found["cycles"][0]["whole"];
    let [miss, off, left] =
        [&whole["miss"], &whole["repeats"]["off"], &whole["repeats"]["miss"]].map(|x| x.as_f64().unwrap());
    println!("{whole}");
    assert!(miss > 1e-5 && left < 1e-7, "{whole}");
    // As far as a step misses, over 1 − multiplier at most.
    let largest = whole["multipliers"][0][0].as_f64().unwrap();
    assert!(off > 0.1 * miss && off < 2.0 * miss / (1.0 - largest), "{whole}");
}

/// Of a robot with feet and a tail whose steps are possible up to 0.42 m/s at mid-stance: the guess after the first two steps was beyond, and that was the end of it.
#[test]
#[ignore = "takes long"]
fn a_cycle_near_the_fastest_step_is_found() {
    let found =
        bipedc(&["gait", "cycle", "tests/data/planar/tailed", "--gait", "walk", "--json"]).ok().json();
    let cycle = &found["cycles"][0]["cycle"];
    let [speed, multiplier] = ["speed", "multiplier"].map(|name| cycle[name].as_f64().unwrap());
    // What `gait optimise` walked.
    assert!((speed - 0.413_267).abs() < 1e-5 && (multiplier - 0.412).abs() < 1e-3, "{cycle}");
    let step = ["--gait", "walk", "--speed", "0.43", "--json"];
    let step = bipedc(&[&["gait", "step", "tests/data/planar/tailed"], &step[..]].concat()).ok().json();
    assert_eq!(step["feasible"], false, "{step}");
}
