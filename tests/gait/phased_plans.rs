//! Plans of a gait of four phases: why there is none, and the findings of 7.2.2 and 7.3.2 about a robot with feet (docs/reproductions).
use super::{WALKER, gait, phased, relative, robot};
use crate::cli::bipedc;
use bipedc::gait::plan::SpeedPlan;
use bipedc::gait::{ChainOptions, Over, PhasedBench, PlanOptions, Range};
use bipedc::progress::{Run, Silent};
use bipedc::simulation::walker;
use bipedc_analysis::gait::Reason;
use bipedc_analysis::simulate::phases::PhaseSpec;

const RUN: Run<'_> = Run { progress: &Silent, stop: &|| false };

fn opened() -> (PhasedBench, Vec<PhaseSpec>) {
    (phased(WALKER, "adjustable"), walker(&robot(WALKER)).unwrap().phases)
}

fn over(name: &str, low: f64, high: f64, count: usize) -> Over {
    Over { name: name.to_owned(), range: Range { low, high, count } }
}

/// The way from a speed to another.
fn way(of: &(PhasedBench, Vec<PhaseSpec>), [from, to]: [f64; 2], over: Vec<Over>) -> SpeedPlan {
    let options = PlanOptions { from_speeds: vec![from], to, over, most: 12, ..PlanOptions::default() };
    of.0.plans(&of.1, &options, &RUN).unwrap_or_else(|e| panic!("{e}")).plans.remove(0)
}

/// That plans say what the step says with which none of them goes on.
fn same_reason(speed: f64, to: f64, over: Over, code: Reason) {
    let of = opened();
    let set = vec![(over.name.clone(), over.range.low)];
    let step = of.0.step(&of.1, &ChainOptions { speed, set, from: Vec::new() }).unwrap();
    let plan = way(&of, [speed, to], vec![over]);
    assert_eq!((step.reason_code, plan.reason_code), (Some(code), Some(code.code())), "{speed}: {plan:?}");
    let (step, plan) = (step.reason.unwrap(), plan.reason.unwrap());
    let words = if code == Reason::FallsBack { "falls back" } else { &step };
    assert!(plan.contains(words), "{speed}: {plan}; {step}");
}

#[test]
fn plans_have_the_reason_of_the_step() {
    for (speed, to) in [(3.0, 0.0), (1.2, 0.6)] {
        same_reason(speed, to, over("push_off", -2.0, 4.0, 2), Reason::OutputsMissed);
    }
}

#[test]
#[ignore = "takes long"]
fn plans_fall_back_where_the_step_does() {
    same_reason(0.1, 0.0, over("torso_lean", -0.04, -0.03, 2), Reason::FallsBack);
}

/// Figure 7.6 against 7.3: a speed to which the robots with point feet need several steps is one step away with feet, with and without push-off.
#[test]
#[ignore = "takes long"]
fn feet_accelerate_in_fewer_steps_than_points() {
    let of = opened();
    let with = || vec![over("step_length", 0.27, 0.332, 3), over("push_off", -4.0, 8.0, 2)];
    let without = || vec![over("step_length", 0.27, 0.332, 3), over("torso_lean", -0.04, 0.06, 2)];
    for from in [0.2, 0.3, 0.4] {
        for over in [with(), without()] {
            let plan = way(&of, [from, 0.55], over);
            assert_eq!(plan.steps, Some(1), "from {from}: {:?}", plan.reason);
            assert!(relative(plan.plan[0].speed, 0.55) < 1e-6, "{:?}", plan.plan);
        }
    }
    // Of 2 rad/s the same parts as those of 0.55 m/s.
    for (folder, least) in [("robots/three_link", [7, 6, 4]), ("robots/five_link", [9, 8, 6])] {
        let bench = gait(folder, "thesis");
        let options = PlanOptions {
            from_speeds: vec![0.7, 1.1, 1.45],
            to: 2.0,
            alike: true,
            most: 30,
            ..PlanOptions::default()
        };
        let plans = bench.plans(&options, &RUN).unwrap_or_else(|e| panic!("{e}"));
        let steps: Vec<Option<usize>> = plans.plans.iter().map(|plan| plan.steps).collect();
        assert_eq!(steps, least.map(Some), "{folder}");
    }
}

/// Figure 7.10a: from 0.4 m/s by leaning back within the bounds, to rest in one step.
#[test]
#[ignore = "takes long"]
fn one_step_brings_the_robot_with_feet_to_rest() {
    let plan = way(&opened(), [0.4, 0.0], vec![over("torso_lean", -0.04, 0.06, 5)]);
    assert_eq!(plan.steps, Some(1), "{:?}", plan.reason);
    let (speed, lean) = (plan.plan[0].speed, plan.plan[0].parameters["torso_lean"]);
    assert!((0.0..1e-3).contains(&speed), "{speed} m/s are left");
    assert!((-0.033..-0.031).contains(&lean), "{lean} rad");
}

/// Figure 7.10b: one step to the speed that takes the five-link robot two, by push-off or without it; no further step follows at that speed.
#[test]
#[ignore = "takes long"]
fn one_step_brings_the_robot_with_feet_to_the_speed_that_takes_the_five_link_robot_two() {
    let of = opened();
    let both = || vec![over("push_off", -4.0, 8.0, 5), over("torso_lean", -0.04, 0.06, 3)];
    let plan = way(&of, [0.52, 0.683], both());
    assert_eq!(plan.steps, Some(1), "{:?}", plan.reason);
    let of_step = |name: &str| plan.plan[0].parameters[name];
    assert!((3.7..4.1).contains(&of_step("push_off")), "{:?}", plan.plan);
    assert!((0.015..0.025).contains(&of_step("torso_lean")), "{:?}", plan.plan);
    let further = way(&of, [0.683, 0.6], both());
    assert_eq!((further.steps, further.reason_code), (None, Some("outputs_missed")), "{:?}", further.reason);
    let by = |over: Over| way(&of, [0.4, 0.525], vec![over]).steps;
    assert_eq!(by(over("push_off", -4.0, 8.0, 3)), Some(1));
    let without = vec![over("step_length", 0.27, 0.332, 3), over("torso_lean", -0.04, 0.06, 3)];
    assert_eq!(way(&of, [0.4, 0.525], without).steps, Some(1));
}

/// What a parameter does to the square of a speed, between two values.
struct Strength {
    name: &'static str,
    values: [f64; 2],
    /// From one bound to the other.
    range: f64,
    /// Closer together: a cycle is near.
    near: [f64; 2],
}

const STRENGTHS: [Strength; 3] = [
    Strength { name: "step_length", values: [0.332, 0.32], range: 0.062, near: [0.331, 0.329] },
    Strength { name: "torso_lean", values: [-0.02, 0.02], range: 0.10, near: [-0.004, 0.004] },
    Strength { name: "push_off", values: [-2.0, 2.0], range: 12.0, near: [-0.2, 0.2] },
];

/// 7.2.2 has push-off the strongest. Here it is the weakest over the bounds of the gait, and no stronger than the others for the same work.
#[test]
#[ignore = "takes long"]
fn push_off_is_strongest_neither_over_its_bounds_nor_for_its_work() {
    let adjustable = ["robots/seven_link_v1", "--gait", "adjustable", "--json"];
    let asked =
        |kind: &str, more: &[&str]| bipedc(&[&["gait", kind], &adjustable[..], more].concat()).ok().json();
    let next = |name: &str, value: f64| {
        let set = format!("{name}={value}");
        let found = asked("step", &["--speed", "0.35", "--set", &set]);
        found["next_speed"].as_f64().unwrap().powi(2)
    };
    let per_range = |of: &Strength| {
        let [low, high] = of.values;
        (next(of.name, high) - next(of.name, low)) * of.range / (high - low).abs()
    };
    let per_joule = |of: &Strength| {
        let [low, high] = of.near.map(|value| {
            let set = format!("{}={value}", of.name);
            let cycle = &asked("cycle", &["--set", &set])["cycles"][0]["cycle"];
            ["speed", "work"].map(|key| cycle[key].as_f64().unwrap())
        });
        (high[0].powi(2) - low[0].powi(2)) / (high[1] - low[1])
    };
    let [length, lean, push] = STRENGTHS.each_ref().map(per_range);
    assert!(push > 0.3 && lean > 1.2 * push && length > 1.2 * lean, "{length} {lean} {push} (m/s)²");
    let [length, lean, push] = STRENGTHS.each_ref().map(per_joule);
    assert!((1.0..1.1).contains(&(push / length)), "{length} {push} (m/s)²/J");
    assert!((1.0..1.1).contains(&(lean / push)), "{lean} {push} (m/s)²/J");
}
