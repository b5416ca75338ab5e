//! Scenarios that name a gait: shipped ones walk as their zero dynamics say, mistakes are named with their place.
use super::gait;
use crate::cli::{Run, bipedc, scratch, text};
use bipedc::Workbench;
use bipedc::gait::GaitBench;
use bipedc_analysis::gait::Course;
use bipedc_runtime::control::{Controller, JointCommand, Observation, Refusal};
use serde_json::Value;
use std::path::Path;

fn shipped(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

/// A text of a scenario, run.
fn simulate(name: &str, robot: &str, scenario: &str) -> (Run, std::path::PathBuf) {
    let folder = scratch(name);
    let (file, log) = (folder.join("scenario.toml"), folder.join("run.csv"));
    std::fs::write(&file, scenario).unwrap();
    let robot = format!("robots/{robot}");
    (bipedc(&["simulate", &robot, "--scenario", text(&file), "--out", text(&log), "--json"]), log)
}

/// Times of the landings, s.
fn landings(found: &Value) -> Vec<f64> {
    found["changes"].as_array().unwrap().iter().map(|change| change["time"].as_f64().unwrap()).collect()
}

/// How long a step with this energy takes: ∫ dφ/φ̇, by Simpson's rule.
fn duration(course: &Course<'_, '_>, energy: f64) -> f64 {
    const PANELS: usize = 200;
    let [start, end] = course.ends();
    let slowness = |k: usize| {
        let phase = start + (end - start) * k as f64 / PANELS as f64;
        1.0 / course.rates(phase, energy).unwrap()[0]
    };
    let weight = |k: usize| if k == 0 || k == PANELS { 1.0 } else { 2.0 + 2.0 * (k % 2) as f64 };
    (end - start) / (3 * PANELS) as f64 * (0..=PANELS).map(|k| weight(k) * slowness(k)).sum::<f64>()
}

/// When the steps end that begin with this speed at mid-stance.
fn predicted(bench: &GaitBench, set: &[(&str, f64)], speed: f64, steps: usize) -> Vec<f64> {
    let set: Vec<_> = set.iter().map(|(name, value)| ((*name).to_owned(), *value)).collect();
    let model = bench.model().unwrap();
    let course = model.steady_course(&bench.values(&set).unwrap()).unwrap();
    let (mut energy, mut time) = (course.energy(speed), 0.0);
    let mut step = |_| {
        time += duration(&course, energy);
        energy = course.landing.delta * (energy - course.p_minus);
        time
    };
    (0..steps).map(&mut step).collect()
}

fn lands_as_said(name: &str, robot: &str, (set, speed): (&[(&str, f64)], f64)) {
    let (run, _) = simulate(name, robot, &shipped(&format!("robots/{robot}/scenarios/thesis.toml")));
    let found = run.ok().json();
    assert_eq!((&found["verdict"], found["steps"].as_u64()), (&Value::Null, Some(10)), "{found}");
    let wanted = predicted(&gait(&format!("robots/{robot}"), "thesis"), set, speed, 10);
    let off = landings(&found).iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("{robot}: landings of ten steps within {off:.1e} s");
    assert!(off < 1e-6, "{robot}: {off:e}");
}

#[test]
fn scenarios_of_the_thesis_gaits_land_when_the_zero_dynamics_say() {
    lands_as_said("gait_three", "three_link", (&[], 1.7));
    lands_as_said("gait_five", "five_link", (&[("torso_lean", 0.3), ("knee", 0.2)], 1.1));
}

/// Where the scenario says nothing of gravity, it is the gait's.
#[test]
fn gravity_is_that_of_the_gait_unless_it_is_said() {
    let scenario = shipped("robots/three_link/scenarios/thesis.toml");
    let of = |name: &str, gravity: &str| {
        let text = scenario.replace("method =", &format!("{gravity}method ="));
        landings(&simulate(name, "three_link", &text).0.ok().json())
    };
    let own = of("gravity_own", "");
    assert_eq!(own, of("gravity_said", "gravity = 9.8\n"));
    assert_ne!(own, of("gravity_other", "gravity = 9.81\n"));
}

/// Known figures of the published controller: 1.5499 rad/s just before impacts, 1.1216 s, 0.6824 m/s; and the formulas of the other scenario.
#[test]
fn the_published_controller_is_the_gaits() {
    let by_gait = shipped("robots/three_link/scenarios/published_controller.toml")
        .replace("log_step = 0.005", "log_step = 0.0005");
    let (run, log) = simulate("gait_published", "three_link", &by_gait);
    let times = landings(&run.ok().json());
    assert_eq!(times.len(), 8);
    let by_formulas = shipped("robots/three_link/scenarios/published_gait.toml");
    let known = landings(&simulate("gait_formulas", "three_link", &by_formulas).0.ok().json());
    let apart = times.iter().zip(&known).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let period = times[7] - times[6];
    let speed = 2.0 * (std::f64::consts::PI / 8.0).sin() / period;
    let rate = rate_before(&log, times[7]);
    println!("{rate:.5} rad/s, {period:.6} s, {speed:.5} m/s; landings {apart:.1e} s from those of formulas");
    assert!((rate - 1.5499).abs() < 1e-3, "{rate}");
    assert!((period - 1.1216).abs() < 1e-4 && (speed - 0.6824).abs() < 1e-4, "{period} {speed}");
    assert!(apart < 1e-8, "{apart:e}");
}

/// Rate of the stance leg just before a landing, along the last two rows; the eighth step stands on the left leg.
fn rate_before(log: &Path, time: f64) -> f64 {
    let text = std::fs::read_to_string(log).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| names.iter().position(|other| *other == name).unwrap();
    let (pitch, hip) = (column("base/angular_velocity/y"), column("left_hip_pitch/velocity"));
    let rows: Vec<[f64; 2]> = lines
        .map(|line| {
            let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap_or(f64::NAN)).collect();
            [row[0], row[pitch] + row[hip]]
        })
        .filter(|row| row[0] <= time)
        .collect();
    let [a, b] = [rows[rows.len() - 2], rows[rows.len() - 1]];
    b[1] + (b[1] - a[1]) / (b[0] - a[0]) * (time - b[0])
}

/// Times at which the foot that carries changes.
fn changes(log: &Path) -> Vec<f64> {
    let text = std::fs::read_to_string(log).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let column = |name: &str| names.iter().position(|other| *other == name).unwrap();
    let feet = [column("right_foot/force/z"), column("left_foot/force/z")];
    let rows: Vec<(f64, bool)> = lines
        .map(|line| {
            let row: Vec<f64> = line.split(',').map(|x| x.parse().unwrap_or(f64::NAN)).collect();
            (row[0], row[feet[0]] > row[feet[1]])
        })
        .skip(1)
        .collect();
    rows.windows(2).filter(|pair| pair[0].1 != pair[1].1).map(|pair| pair[1].0).collect()
}

/// By time stepping the foot lands where it meets the ground; the shorter the step, the nearer to the zero dynamics.
#[test]
#[ignore = "takes long"]
fn time_stepping_walks_by_a_gait_too() {
    let scenario = shipped("robots/five_link/scenarios/optimised.toml");
    let bench = gait("robots/five_link", "optimised");
    let wanted = predicted(&bench, &[], 0.68, 4);
    let worst = |name: &str, step: &str| {
        let text = scenario
            .replace("step = 0.0001 ", &format!("step = {step} "))
            .replace("log_step = 0.005", "log_step = 0.0002")
            .replace("duration = 3.2", "duration = 2.8");
        let (run, log) = simulate(name, "five_link", &text);
        run.ok();
        let found = changes(&log);
        assert_eq!(found.len(), wanted.len(), "{found:?} {wanted:?}");
        found.iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let (coarse, fine) = (worst("gait_coarse", "0.0002"), worst("gait_fine", "0.00005"));
    println!("landings of four steps within {coarse:.1e} s with steps of 0.2 ms, {fine:.1e} s of 0.05 ms");
    // Rows of the log are 0.2 ms apart.
    assert!(fine < 2e-3 && coarse < 8e-3 && fine < 0.5 * coarse, "{coarse:e} {fine:e}");
}

/// Contacts come and go as the ground has it, and phases follow them: four in each step. `firm` walks as far as from event to event.
#[test]
#[ignore = "takes long"]
fn time_stepping_walks_with_feet_too() {
    let scenario = "duration = 5.0\nstep = 0.0001\nlog_step = 0.005\n[ground]\nfriction = 0.8\n\
                    [initial]\nmid_stance_speed = 0.4\n[control]\ngait = \"firm\"\n";
    let walked = |name: &str, text: &str| {
        let (run, log) = simulate(name, "seven_link_v1", text);
        (run.ok().json(), place(&log))
    };
    let (found, stepped) = walked("gait_stepped", scenario);
    assert_eq!((&found["fall"], found.get("refused")), (&Value::Null, None), "{found}");
    let from_events = scenario.replace("step = 0.0001\n", "").replace("[ground]", "[assumptions]");
    let (_, wanted) = walked("gait_from_events", &format!("method = \"event_driven\"\n{from_events}"));
    println!("5 s of walking: {stepped:.4} m, from event to event {wanted:.4} m");
    assert!((stepped / wanted - 1.0).abs() < 0.02, "{stepped} {wanted}");
}

/// The same of the gaits whose parameters are chosen for each step.
#[test]
#[ignore = "takes long"]
fn time_stepping_walks_by_gaits_with_parameters() {
    let cases = [
        ("five_link", "lifting", "0.711", "[control.parameters]\nknee = 0.3\nlift = 0.6\n"),
        ("seven_link_v1", "adjustable", "0.42", ""),
    ];
    for (robot, gait, speed, parameters) in cases {
        let scenario = |method: &str, world: &str| {
            format!(
                "{method}duration = 12.0\nlog_step = 0.005\n[{world}]\nfriction = 0.8\n[initial]\nmid_stance_speed = {speed}\n[control]\n\
                 gait = \"{gait}\"\n{parameters}"
            )
        };
        let walked = |name: &str, text: &str| {
            let (run, log) = simulate(&format!("{name}_{gait}"), robot, text);
            (run.ok().json(), place(&log))
        };
        let (found, stepped) = walked("gait_stepped", &scenario("step = 0.0001\n", "ground"));
        assert_eq!((&found["fall"], found.get("refused")), (&Value::Null, None), "{found}");
        assert!((found["time"].as_f64().unwrap() - 12.0).abs() < 1e-9, "{found}");
        let (_, wanted) = walked("gait_from_events", &scenario("method = \"event_driven\"\n", "assumptions"));
        println!("{gait}: {stepped:.4} m in 12 s, from event to event {wanted:.4} m");
        assert!((stepped / wanted - 1.0).abs() < 0.02, "{gait}: {stepped} {wanted}");
    }
}

/// How far the base is at the end of a log, from where it began, m.
fn place(log: &Path) -> f64 {
    let text = std::fs::read_to_string(log).unwrap();
    let mut lines = text.lines();
    let column = lines.next().unwrap().split(',').position(|name| name == "base/position/x").unwrap();
    let values: Vec<f64> = lines.map(|line| line.split(',').nth(column).unwrap().parse().unwrap()).collect();
    values.last().unwrap() - values[0]
}

/// A foot that passes through the ground is held by it in time stepping: told before anything is simulated.
#[test]
fn a_gait_that_scuffs_is_refused_in_time_stepping() {
    let scenario = "duration = 1.0\nstep = 0.0005\nlog_step = 0.005\n[ground]\nfriction = 0.8\n\
                    [initial]\nmid_stance_speed = 1.5\n[control]\ngait = \"thesis\"\n";
    let (run, log) = simulate("gait_scuffs", "three_link", scenario);
    run.fails_with(&["0.0040 m below the ground", "event_driven", "scuffing = false"]);
    assert!(!log.exists());
}

/// Where a step begins without a phase variable that grows, as after feet slipped, the run is over: what happened until then is kept.
#[test]
fn a_refusal_keeps_the_log() {
    let scenario = "duration = 1.0\nstep = 0.0005\nlog_step = 0.005\n[ground]\nfriction = 0.1\n\
                    [initial]\nmid_stance_speed = 0.711\n[control]\ngait = \"lifting\"\n\
                    [control.parameters]\nknee = 0.3\nlift = 0.6\n";
    let (run, log) = simulate("gait_refused", "five_link", scenario);
    assert_eq!(run.code, Some(3), "{}", run.err);
    assert!(
        run.err.contains("the phase variable does not grow") && run.err.contains("the log ends there"),
        "{}",
        run.err
    );
    let found = run.json();
    assert!(found["refused"].as_str().unwrap().contains("in phase `single_support`"), "{found}");
    let rows = std::fs::read_to_string(log).unwrap().lines().count();
    assert!((95..115).contains(&rows) && found["rows"] == rows - 1, "{rows}: {found}");
}

/// The same gait from event to event: the ground ends its steps.
#[test]
fn a_gait_that_lifts_its_foot_lands_on_the_ground() {
    let scenario = "method = \"event_driven\"\nduration = 9.0\nsteps = 10\n[assumptions]\nfriction = 0.6\n\
                    [initial]\nmid_stance_speed = 0.8\n[control]\ngait = \"optimised\"\n";
    let found = simulate("gait_lifts", "five_link", scenario).0.ok().json();
    assert_eq!((&found["verdict"], found["steps"].as_u64()), (&Value::Null, Some(10)), "{found}");
    let wanted = predicted(&gait("robots/five_link", "optimised"), &[], 0.8, 10);
    let off = landings(&found).iter().zip(&wanted).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("landings of ten steps within {off:.1e} s");
    assert!(off < 1e-6, "{off:e}");
}

#[test]
fn mistakes_have_their_place() {
    let scenario = shipped("robots/three_link/scenarios/thesis.toml");
    let line = |text: &str, of: &str| text.lines().position(|line| line.starts_with(of)).unwrap() + 1;
    let fails = |from: &str, to: &str, at: &str, words: &[&str]| {
        let text = scenario.replace(from, to);
        assert_ne!(text, scenario, "{from}");
        let (run, _) = simulate("gait_mistakes", "three_link", &text);
        let place = format!("scenario.toml:{}:", line(&text, at));
        run.fails_with(&[words, &[&place]].concat());
    };
    fails("\"thesis\"", "\"thesys\"", "gait", &["no gait `thesys`", "did you mean `thesis`?"]);
    fails("torso_lean =", "torso_laen =", "torso_laen", &["no parameter `torso_laen`", "`torso_lean`?"]);
    fails("torso_lean = -0.5", "torso_lean = inf", "torso_lean", &["not finite"]);
    fails("mid_stance_speed = 1.7", "mid_stance_speed = -1", "mid_stance_speed", &["must be", "above 0"]);
    let joint = "[joint]\nright_hip_pitch = { position = 0.1 }\n[control]";
    fails("[control]", joint, "right_hip_pitch", &["follows from the gait"]);
    let turn = "[initial]\nbase_rotation = [0.1]";
    fails("[initial]", turn, "base_rotation", &["follows from the gait"]);
    let output = "[[control.output]]\nformula = \"base_pitch\"\n[[effect]]";
    fails("[[effect]]", output, "[[control.output]]", &["outputs and quantities of its own"]);
    fails("gait = \"thesis\"", "", "mid_stance_speed", &["is that of a gait", "name a gait"]);
    fails("step_length = \"gait\"", "step_length = \"gate\"", "step_length", &["or \"gait\""]);
    // Parameters of impossible steps: the speed is where it shows.
    fails("step_length = 0.5 ", "step_length = 2.5 ", "mid_stance_speed", &["no step at 1.7 per s", "guard"]);
}

#[test]
fn a_broken_gait_file_is_named_itself() {
    let folder = scratch("gait_broken");
    let gait = shipped("robots/three_link/gaits/thesis.toml").replace("-torso_lean", "-torso_lin");
    std::fs::write(folder.join("mine.toml"), gait).unwrap();
    let scenario = shipped("robots/three_link/scenarios/thesis.toml").replace("\"thesis\"", "\"mine.toml\"");
    std::fs::write(folder.join("scenario.toml"), scenario).unwrap();
    let (file, log) = (folder.join("scenario.toml"), folder.join("run.csv"));
    let run = bipedc(&["simulate", "robots/three_link", "--scenario", text(&file), "--out", text(&log)]);
    run.fails_with(&["mine.toml:", "torso_lin", "did you mean `torso_lean`?"]);
    // A scenario may not write over the gait that it reads.
    let gait = folder.join("mine.toml");
    std::fs::write(&gait, shipped("robots/three_link/gaits/thesis.toml")).unwrap();
    let run = bipedc(&["simulate", "robots/three_link", "--scenario", text(&file), "--out", text(&gait)]);
    run.fails_with(&["the gait"]);
}

/// By time stepping a controller of one's own is told of the beginning, once.
#[test]
fn controllers_are_told_where_a_motion_begins() {
    struct Told(usize);
    impl Controller<f64> for Told {
        fn command(&mut self, _: &Observation<'_, f64>, _: &mut [JointCommand<f64>]) -> Result<(), Refusal> {
            assert_eq!(self.0, 1);
            Ok(())
        }
        fn begin_phase(&mut self, observed: &Observation<'_, f64>) -> Result<(), Refusal> {
            assert_eq!(observed.time, 0.0);
            self.0 += 1;
            Ok(())
        }
    }
    let leg = Workbench::open("robots/tulip_v1_leg").unwrap_or_else(|e| panic!("{e}"));
    let scene = leg.scene("robots/tulip_v1_leg/scenarios/released.toml").unwrap();
    let (mut told, log) = (Told(0), scratch("gait_told").join("run.csv"));
    leg.simulate_with(&scene, &mut told, &log, &Default::default()).unwrap();
    assert_eq!(told.0, 1);
}

#[test]
fn a_step_that_cannot_begin_ends_the_run_with_its_reason() {
    let scenario = shipped("robots/three_link/scenarios/thesis.toml").replace(
        "mid_stance_speed = 1.7              # rad/s",
        "base_angular_velocity = [-1.0]\n[joint]\nright_hip_pitch = { position = -0.3 }",
    );
    let (run, _) = simulate("gait_backwards", "three_link", &scenario);
    run.fails_with(&["at 0.000000 s", "single_support", "phase variable does not grow"]);
}
