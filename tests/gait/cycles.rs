//! `bipedc gait cycle`: fixed points of the step, their multiplier, work and what the impact takes.
use super::{gait, relative};
use crate::cli::{bipedc, scratch, text};
use bipedc::gait::{CycleOptions, GaitBench, Over, Range, StepOptions};
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
