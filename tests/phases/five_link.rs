//! The five-link walker: event times against a tighter tolerance, and time stepping beside it.
use super::{scenario_text, time_stepped, walked};
use bipedc_analysis::simulate::Sample;
use bipedc_analysis::simulate::phases::WalkEnd;

const FOLDER: &str = "robots/five_link";
const SCENARIO: &str = "robots/five_link/scenarios/gait.toml";
const SLICED: &str = "robots/five_link/scenarios/gait_time_stepping.toml";

#[test]
fn the_shipped_gait_walks_and_settles() {
    let (summary, samples) = walked(FOLDER, &scenario_text(SCENARIO)).unwrap();
    assert_eq!((summary.end, summary.steps), (WalkEnd::Steps, 10), "{:?}", summary.verdict);
    let times: Vec<f64> = summary.changes.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
    let shrink = (times[4] - times[3]) / (times[3] - times[2]);
    let forward = samples.last().unwrap().q[0] - samples[0].q[0];
    println!("step times {times:?}, changes shrink by {shrink:.3}, {forward:.3} m");
    assert!((times[8] - times[7]).abs() < 1e-6 && shrink > 0.3 && shrink < 0.7, "{times:?}");
    assert!((forward - 10.0 * 0.45).abs() < 0.1, "{forward}");
}

#[test]
fn event_times_agree_with_a_hundred_times_tighter_tolerance() {
    let run = |tolerance: &str| {
        let text = scenario_text(SCENARIO);
        let text = format!("relative_tolerance = {tolerance}\n{text}");
        walked(FOLDER, &text).unwrap().0
    };
    for (loose, tight) in [("1e-9", "1e-11"), ("1e-10", "1e-12")] {
        let (a, b) = (run(loose), run(tight));
        assert_eq!(a.changes.len(), b.changes.len());
        let miss = a.changes.iter().zip(&b.changes).map(|(a, b)| (a.time - b.time).abs()).fold(0.0, f64::max);
        println!(
            "{loose} against {tight}: ten landings within {miss:.1e} s ({} and {} evaluations)",
            a.integration.evaluations, b.integration.evaluations
        );
        assert!(miss < 1e-9, "{miss}");
    }
}

/// Place of the hip relative to the foot that stands, m, and the height of the other one.
fn hip_and_swing(sample: &Sample, right_stands: bool) -> (f64, f64) {
    let q = &sample.q;
    let leg = |hip: f64, knee: f64| {
        let (a, b) = (q[2] + hip, q[2] + hip + knee);
        [0.4 * (a.sin() + b.sin()), 0.4 * (a.cos() + b.cos())]
    };
    let (right, left) = (leg(q[3], q[4]), leg(q[5], q[6]));
    let (stance, swing) = if right_stands { (right, left) } else { (left, right) };
    (stance[0], q[1] - swing[1])
}

/// Where a quantity rises (or falls) through zero between two samples, from a time on: part of the way and the later index.
fn crossing(samples: &[Sample], from: usize, quantity: impl Fn(&Sample) -> f64) -> (f64, usize) {
    for i in from.max(1)..samples.len() {
        let (a, b) = (quantity(&samples[i - 1]), quantity(&samples[i]));
        if a > 0.0 && b <= 0.0 {
            return (a / (a - b), i);
        }
    }
    panic!("no crossing after sample {from}");
}

/// Time of the second landing less that of the first, and the speed of the hip above the foot in between.
fn second_step(samples: &[Sample]) -> [f64; 2] {
    let at = |(part, i): (f64, usize), quantity: &dyn Fn(&Sample) -> f64| {
        let (a, b) = (quantity(&samples[i - 1]), quantity(&samples[i]));
        a + part * (b - a)
    };
    // The swing foot begins on the ground: look when it has risen.
    let skip = samples.iter().position(|sample| sample.time > 0.3).unwrap();
    let first = crossing(samples, skip, |sample| hip_and_swing(sample, true).1);
    let middle = crossing(samples, first.1 + 1, |sample| -hip_and_swing(sample, false).0);
    let second = crossing(samples, middle.1, |sample| hip_and_swing(sample, false).1);
    let time = |sample: &Sample| sample.time;
    [at(second, &time) - at(first, &time), at(middle, &|sample| sample.v[0])]
}

#[test]
#[ignore = "takes long"]
fn time_stepping_comes_to_the_event_driven_step_as_its_own_shrinks() {
    let exact = scenario_text(SCENARIO).replace("log_step = 0.005", "log_step = 0.00005");
    let (summary, samples) = walked(FOLDER, &exact.replace("steps = 10", "steps = 3")).unwrap();
    let period = summary.changes[1].time - summary.changes[0].time;
    let speed = second_step(&samples)[1];
    let text = scenario_text(SLICED).replace("duration = 3.0", "duration = 1.35");
    let steps: [f64; 5] = [8e-4, 4e-4, 2e-4, 1e-4, 5e-5];
    let mut errors: Vec<[f64; 2]> = Vec::new();
    for step in steps {
        let text = text.replace("step = 0.0001  ", &format!("step = {step}"));
        let text = text.replace("log_step = 0.005", &format!("log_step = {step}"));
        let found = second_step(&time_stepped(FOLDER, &text));
        let error = [(found[0] - period).abs(), (found[1] - speed).abs()];
        println!(
            "step {step:e} s: step time off by {:.2e} s, mid-stance speed by {:.2e} m/s",
            error[0], error[1]
        );
        errors.push(error);
    }
    let order = |k: usize| {
        let logs: Vec<[f64; 2]> = steps.iter().zip(&errors).map(|(h, e)| [h.ln(), e[k].ln()]).collect();
        let mean = |i: usize| logs.iter().map(|x| x[i]).sum::<f64>() / logs.len() as f64;
        let (x, y) = (mean(0), mean(1));
        let above: f64 = logs.iter().map(|l| (l[0] - x) * (l[1] - y)).sum();
        above / logs.iter().map(|l| (l[0] - x).powi(2)).sum::<f64>()
    };
    println!("period {period:.9} s, speed {speed:.9} m/s; orders {:.2} and {:.2}", order(0), order(1));
    for k in 0..2 {
        assert!(order(k) > 0.8 && errors[4][k] < 0.15 * errors[0][k], "{errors:?}");
    }
}
