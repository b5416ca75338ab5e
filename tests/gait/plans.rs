//! `bipedc gait steps` and `bipedc gait capture`: every plan walked again, the fewest steps by other means, stairs.
use super::gait;
use crate::cli::{bipedc, scratch, text};
use bipedc::gait::{Assignment, Assumptions, GaitBench, Over, PlanOptions, Plans, Range, StepOptions};
use bipedc::progress::{Run, Silent};
use roxmltree::Document;
use std::collections::BTreeMap;

fn over(name: &str, low: f64, high: f64, count: usize) -> Over {
    Over { name: name.to_owned(), range: Range { low, high, count } }
}

fn plans(bench: &GaitBench, options: &PlanOptions) -> Plans {
    let run = Run { progress: &Silent, stop: &|| false };
    bench.plans(&PlanOptions { most: 30, ..options.clone() }, &run).unwrap_or_else(|e| panic!("{e}"))
}

fn assignments(values: &BTreeMap<String, f64>) -> Vec<Assignment> {
    values.iter().map(|(name, value)| (name.clone(), *value)).collect()
}

/// Walks every plan by `gait step`, each step after the two before it; how many steps that were.
fn walked_again(bench: &GaitBench, plans: &Plans) -> usize {
    let mut count = 0;
    for plan in &plans.plans {
        // The present step follows its own kind.
        let (mut before, mut from, mut speed) = (plans.from.clone(), plans.from.clone(), plan.from_speed);
        for step in &plan.plan {
            if plans.alike {
                (before, from) = (step.parameters.clone(), step.parameters.clone());
            }
            let asked = StepOptions {
                speed,
                set: assignments(&step.parameters),
                from: assignments(&from),
                before: assignments(&before),
            };
            let found = bench.step(&asked).unwrap().step;
            let next = found.next_speed.unwrap_or_else(|| panic!("{:?} in {plan:#?}", found.reason));
            // Near rest the speed is the root of a difference of energies.
            let rounding = 1e-12 * step.energy.abs();
            assert!(
                (next - step.speed).abs() * (next + step.speed) < rounding,
                "{next} {} in {plan:#?}",
                step.speed
            );
            (before, from, speed) = (from, step.parameters.clone(), step.speed);
            count += 1;
        }
        if plan.steps.is_some() {
            assert!((speed - plans.to).abs() <= 1e-6 * plans.to.max(1.0), "{speed} {}", plans.to);
        }
    }
    count
}

#[test]
#[ignore = "takes long"]
fn plans_walk_as_they_say() {
    let (three, five) = (gait("robots/three_link", "thesis"), gait("robots/five_link", "thesis"));
    let small = vec![over("step_length", 0.2, 1.0, 5), over("torso_lean", -1.0, 0.5, 4)];
    let lengths = vec![over("step_length", 0.2, 1.0, 9)];
    let mut count = 0;
    for to in [0.0, 0.7, 2.0] {
        for over in [&small, &lengths] {
            for alike in [false, true] {
                let options = PlanOptions {
                    from_speeds: vec![0.6, 1.4, 2.9],
                    to,
                    over: over.clone(),
                    alike,
                    ..PlanOptions::default()
                };
                count += walked_again(&three, &plans(&three, &options));
            }
        }
        let options = PlanOptions {
            from_speeds: vec![1.0, 2.5],
            to,
            over: vec![over("step_length", 0.15, 0.7, 4), over("knee", 0.1, 0.6, 3)],
            from: vec![("step_length".to_owned(), 0.3)],
            ..PlanOptions::default()
        };
        count += walked_again(&five, &plans(&five, &options));
    }
    assert!(count > 60, "{count}");
}

/// All ways over few choices, each step by itself (as `gait step` computes it, without margins): lowest and highest speed after each
/// number of steps; a way that falls back in its last step counts as slower than all others.
fn by_hand(bench: &GaitBench, choices: &[Vec<f64>], speed: f64, most: usize) -> Vec<[f64; 2]> {
    let model = bench.model().unwrap();
    let present: Vec<f64> = bench.gait.parameters.iter().map(|parameter| parameter.default).collect();
    let mut ways = vec![(present.clone(), present, speed)];
    let mut found = Vec::new();
    for _ in 0..most {
        let (mut next, mut ends) = (Vec::new(), [f64::INFINITY, f64::NEG_INFINITY]);
        for (before, from, speed) in &ways {
            for to in choices {
                match model.pair(Some(before), from, to).next_speed(*speed) {
                    Ok(reached) => {
                        ends = [ends[0].min(reached), ends[1].max(reached)];
                        next.push((from.clone(), to.clone(), reached));
                    }
                    Err(_) => ends[0] = 0.0,
                }
            }
        }
        found.push(ends);
        ways = next;
    }
    found
}

/// A sequence of numbers from 0 to 1 that looks random.
fn noise(seed: u64) -> impl FnMut() -> f64 {
    let mut state = seed;
    move || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// The number of steps is the first one for which the wished speed lies between the slowest and the fastest of all ways.
#[test]
#[ignore = "takes long"]
fn no_way_over_the_choices_needs_fewer_steps() {
    let bench = gait("robots/three_link", "thesis");
    let mut random = noise(7);
    let (mut reached, mut longer) = (0, 0);
    for _ in 0..25 {
        let (low, high) = (0.25 + 0.2 * random(), 0.55 + 0.35 * random());
        let (speed, to) = (0.5 + 2.0 * random(), 0.3 + 2.5 * random());
        let choices = [low, 0.5 * (low + high), high].map(|length| vec![length, -0.5]);
        let options = PlanOptions {
            from_speeds: vec![speed],
            to,
            over: vec![over("step_length", low, high, 3)],
            ..PlanOptions::default()
        };
        let plan = &plans(&bench, &options).plans[0];
        let ends = by_hand(&bench, &choices, speed, 4);
        let expected = ends.iter().position(|[slow, fast]| (slow..=fast).contains(&&to)).map(|k| k + 1);
        match expected {
            Some(count) => {
                assert_eq!(plan.steps, Some(count), "{speed} to {to}, {low} to {high}: {plan:#?} {ends:?}");
                reached += 1;
                longer += usize::from(count > 1);
            }
            None => assert!(plan.steps.is_none_or(|count| count > 4), "{speed} to {to}: {plan:#?} {ends:?}"),
        }
    }
    assert!(reached >= 8 && longer >= 2, "{reached} {longer}");
}

/// Steps that are alike: the greedy plan against all sequences, each by `gait step`.
#[test]
#[ignore = "takes long"]
fn to_go_as_far_as_possible_is_optimal_where_steps_are_alike() {
    let bench = gait("robots/three_link", "thesis");
    let lengths = [0.2, 0.6, 1.0];
    for (speed, to) in [(1.0, 1.9), (3.0, 1.0), (3.5, 0.6), (2.2, 0.0), (0.8, 1.3), (1.2, 4.0)] {
        let options = PlanOptions {
            from_speeds: vec![speed],
            to,
            over: vec![over("step_length", 0.2, 1.0, 3)],
            alike: true,
            ..PlanOptions::default()
        };
        let plan = &plans(&bench, &options).plans[0];
        let (mut speeds, mut expected) = (vec![speed], None);
        for count in 1..=6 {
            let step = |speed: &f64| {
                let speed = *speed;
                let bench = &bench;
                lengths.map(move |length| {
                    let set = vec![("step_length".to_owned(), length)];
                    bench.step(&StepOptions { speed, set, ..StepOptions::default() }).unwrap().step.next_speed
                })
            };
            let all: Vec<Option<f64>> = speeds.iter().flat_map(step).collect();
            speeds = all.iter().flatten().copied().collect();
            let falls = all.iter().any(Option::is_none);
            let low = if falls { 0.0 } else { speeds.iter().copied().fold(f64::INFINITY, f64::min) };
            if (low..=speeds.iter().copied().fold(0.0, f64::max)).contains(&to) {
                expected = Some(count);
                break;
            }
        }
        assert_eq!(plan.steps.filter(|count| *count <= 6), expected, "{speed} to {to}: {plan:#?}");
    }
}

/// Figure 7.3: the faster a robot is, the more steps it needs to stop; the further a speed is, the more steps it takes.
#[test]
#[ignore = "takes long"]
fn stairs_rise_with_the_distance() {
    let bench = gait("robots/three_link", "thesis");
    let speeds: Vec<f64> = (2..=40).map(|k| 0.1 * f64::from(k)).collect();
    let stairs = |to: f64| {
        let options = PlanOptions { from_speeds: speeds.clone(), to, alike: true, ..PlanOptions::default() };
        let found = plans(&bench, &options);
        walked_again(&bench, &found);
        found.plans.iter().map(|plan| plan.steps).collect::<Vec<_>>()
    };
    let stop: Vec<usize> = stairs(0.0).into_iter().flatten().collect();
    assert!(stop.len() > 30 && stop.windows(2).all(|pair| pair[0] <= pair[1]), "{stop:?}");
    assert!(stop[0] == 1 && stop[stop.len() - 1] >= 2, "{stop:?}");
    let to_two = stairs(2.0);
    let middle = speeds.iter().position(|speed| *speed >= 2.0 - 1e-9).unwrap();
    let known = |range: &[Option<usize>]| range.iter().flatten().copied().collect::<Vec<_>>();
    let (slower, faster) = (known(&to_two[..middle]), known(&to_two[middle + 1..]));
    assert!(slower.windows(2).all(|pair| pair[0] >= pair[1]) && slower[0] >= 3, "{slower:?}");
    assert!(faster.windows(2).all(|pair| pair[0] <= pair[1]) && !faster.is_empty(), "{faster:?}");
}

/// More values for the same ranges find no shorter plans: the ends of what can be reached lie at corners and where few values
/// tell them.
#[test]
fn finer_choices_change_no_number_of_steps() {
    let bench = gait("robots/three_link", "thesis");
    let count = |values: usize| {
        let options = PlanOptions {
            from_speeds: vec![0.7, 1.1, 1.9, 2.6, 3.3],
            to: 1.5,
            over: vec![over("step_length", 0.2, 1.0, values)],
            ..PlanOptions::default()
        };
        plans(&bench, &options).plans.iter().map(|plan| plan.steps).collect::<Vec<_>>()
    };
    assert_eq!(count(9), count(33));
}

fn steps(arguments: &[&str]) -> crate::cli::Run {
    bipedc(&[&["gait", "steps", "robots/three_link", "--gait", "thesis"], arguments].concat())
}

const LENGTHS: [&str; 2] = ["--over", "step_length=0.2:1:5"];

#[test]
fn what_is_not_reached_has_a_reason() {
    let found = |arguments: &[&str]| {
        steps(&[arguments, &["--json"], &LENGTHS].concat()).ok().json()["plans"][0].clone()
    };
    let fast = found(&["--from-speed", "1", "--to", "9"]);
    assert_eq!(
        (&fast["steps"], &fast["reason_code"]),
        (&serde_json::Value::Null, &serde_json::json!("too_fast"))
    );
    assert!(
        fast["reason"].as_str().unwrap().contains("at most") && !fast["reach"].as_array().unwrap().is_empty()
    );
    let falls = found(&["--from-speed", "0.1", "--to", "1", "--from", "torso_lean=0.4"]);
    assert_eq!(falls["reason_code"], "falls_back", "{falls}");
    let same = found(&["--from-speed", "1", "--to", "1"]);
    assert_eq!((&same["steps"], &same["reason"]), (&serde_json::json!(0), &serde_json::Value::Null));
}

#[test]
fn wrong_plans_are_named() {
    for speed in ["0", "-1", "nan"] {
        steps(&[&format!("--from-speed={speed}"), "--to", "1"])
            .fails_with(&["a speed of", "above 0, in rad/s"]);
    }
    for speed in ["-1", "nan", "inf"] {
        steps(&["--from-speed", "1", &format!("--to={speed}")])
            .fails_with(&["a speed of", "0 or more, in rad/s"]);
    }
    for (range, words) in
        [("2:1:5", "the smaller end first"), ("1:2:1", "at least 2"), ("1:2:9999", "at most 2000")]
    {
        steps(&["--from-speed", range, "--to", "1"]).fails_with(&["--from-speed", words]);
    }
    let one = |arguments: &[&str]| steps(&[&["--from-speed", "1", "--to", "2"], arguments].concat());
    one(&["--over", "knee=0:1:3"]).fails_with(&["no parameter `knee`"]);
    one(&["--over", "step_length=0.2:1:3", "--over", "step_length=0.2:1:3"]).fails_with(&["two ranges"]);
    one(&["--over", "step_length=0.2:1:3", "--set", "step_length=0.4"])
        .fails_with(&["fixed and has a range"]);
    one(&["--over", "step_length=0.2:1:600"]).fails_with(&["600 combinations", "at most 500"]);
    one(&["--set", "step_length=0.4", "--set", "torso_lean=0"])
        .fails_with(&["no parameter that could be chosen", "[parameters.NAME]"]);
    one(&["--from", "step_length=2.5"]).fails_with(&["the present step is none", "--from"]);
    for wrong in ["1:2", "x", "1:x:3", "1:2:-1"] {
        assert_eq!(steps(&[&format!("--from-speed={wrong}"), "--to", "1"]).code, Some(2), "{wrong}");
    }
    let text = super::files::changed(
        "robots/three_link",
        "wanted = \"-torso_lean\"",
        "wanted = \"-torso_lean + 0 * phase_start\"",
    );
    let bench = super::files::open("started", &text).unwrap_or_else(|e| panic!("{e}"));
    let options = PlanOptions { from_speeds: vec![1.0], most: 5, ..PlanOptions::default() };
    let refused = bench.plans(&options, &Run { progress: &Silent, stop: &|| false }).unwrap_err().to_string();
    assert!(refused.contains("depends on phase_start"), "{refused}");
}

#[test]
fn files_of_plans_are_whole() {
    let folder = scratch("gait_plan_files");
    let paths = ["plan.svg", "plan.csv", "plan.html"].map(|name| folder.join(name));
    let [svg, csv, page] = &paths;
    let files = ["--svg", text(svg), "--csv", text(csv), "--page", text(page)];
    let read = |path| std::fs::read_to_string(path).unwrap();
    let single = steps(&[&["--from-speed", "2.4", "--to", "1"], &LENGTHS[..], &files].concat()).ok();
    assert!(single.out.contains("rad/s") && single.out.contains("present step"), "{}", single.out);
    Document::parse(&read(svg)).unwrap();
    assert!(read(csv).starts_with("step,speed,step_length,torso_lean\n0,2.4,0.5,-0.5\n1,"), "{}", read(csv));
    assert!(read(page).contains("present step"));
    let capture =
        ["gait", "capture", "robots/three_link", "--gait", "thesis", "--speed", "0.5:3:11", "--alike"];
    let many = bipedc(&[&capture[..], &LENGTHS, &files].concat()).ok();
    assert!(many.out.contains("steps to 0 rad/s"), "{}", many.out);
    Document::parse(&read(svg)).unwrap();
    assert_eq!(read(csv).lines().count(), 12);
    assert!(read(csv).starts_with("from_speed,to,steps,reason\n0.5,0,1,\n"), "{}", read(csv));
}

/// With everything assumed, every step of a plan has margins, by `bipedc gait step`; without, one has not.
#[test]
fn steps_of_plans_keep_what_is_assumed() {
    let bench = gait("robots/three_link", "thesis");
    let assume =
        Assumptions { friction: true, pull: true, torque: true, joints: true, ..Assumptions::default() };
    let lean = vec![("torso_lean".to_owned(), -0.5)];
    let options = PlanOptions { from_speeds: vec![1.0], to: 2.0, set: lean, ..PlanOptions::default() };
    let worst = |plans: &Plans| {
        let (mut before, mut from, mut speed) = (plans.from.clone(), plans.from.clone(), 1.0);
        let mut worst = f64::INFINITY;
        for step in &plans.plans[0].plan {
            let asked = StepOptions {
                speed,
                set: assignments(&step.parameters),
                from: assignments(&from),
                before: assignments(&before),
            };
            let margins = bench.step(&asked).unwrap().step.margins;
            let forces = [margins.friction, margins.impact_friction];
            // As parts of the weight and of the largest effort, nearly.
            let others = [margins.pull, margins.torque, margins.impact_pull].map(|x| x.unwrap() / 100.0);
            worst = forces.map(Option::unwrap).into_iter().chain(others).fold(worst, f64::min);
            (before, from, speed) = (from, step.parameters.clone(), step.speed);
        }
        worst
    };
    let (free, slow) = (plans(&bench, &options), PlanOptions { to: 1.3, ..options.clone() });
    assert!(free.plans[0].steps.is_some() && worst(&free) < -0.01, "{}", worst(&free));
    let kept = plans(&bench, &PlanOptions { assume, ..slow });
    println!("{:?} steps, margins {}, freely {}", kept.plans[0].steps, worst(&kept), worst(&free));
    // Limits are asked for at 49 places of the phase.
    assert!(kept.plans[0].steps.is_some() && worst(&kept) > -2e-3, "{}", worst(&kept));
    // What is not reached without breaking them is said.
    let fast = plans(&bench, &PlanOptions { assume, ..options });
    assert_eq!(fast.plans[0].reason_code, Some("too_fast"));
    let alike = PlanOptions {
        alike: true,
        assume,
        over: vec![over("torso_lean", -1.0, 0.5, 31)],
        ..PlanOptions::default()
    };
    let alike = plans(&bench, &PlanOptions { from_speeds: vec![1.0], to: 1.3, ..alike });
    assert!(alike.plans[0].steps.is_some_and(|steps| steps > 0));
    // A step before which nothing is kept.
    let run = ["gait", "steps", "robots/three_link", "--gait", "thesis", "--from-speed", "9", "--to", "1"];
    let found = bipedc(&[&run[..], &["--assume", "friction,pull,torque", "--json"]].concat()).ok().json();
    assert_eq!(found["plans"][0]["reason_code"], "not_kept");
}
