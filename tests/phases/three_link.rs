//! The three-link walker with its published gait and controller (Grizzle, Abba and Plestan, 2001).
use super::{scenario_text, walked};
use bipedc_analysis::simulate::Sample;
use bipedc_analysis::simulate::phases::WalkEnd;

const SCENARIO: &str = "robots/three_link/scenarios/published_gait.toml";

/// Rate of the leg on the ground, rad/s.
fn stance_rate(sample: &Sample) -> f64 {
    let right = sample.forces[0][2] > sample.forces[1][2];
    sample.v[2] + if right { sample.v[3] } else { sample.v[4] }
}

#[test]
fn the_published_speed_comes_out_of_the_scenario() {
    let text = scenario_text(SCENARIO).replace("log_step = 0.005", "log_step = 0.0005");
    let (summary, samples) = walked("robots/three_link", &text).unwrap();
    assert_eq!((summary.end, summary.steps, &summary.verdict), (WalkEnd::Steps, 8, &None));
    let changes = &summary.changes;
    let last = changes.last().unwrap();
    // The rate just before the last impact, along the last two rows before it.
    let before: Vec<&Sample> = samples.iter().filter(|sample| sample.time <= last.time).collect();
    let [a, b] = [before[before.len() - 2], before[before.len() - 1]];
    let slope = (stance_rate(b) - stance_rate(a)) / (b.time - a.time);
    let rate = stance_rate(b) + slope * (last.time - b.time);
    let period = last.time - changes[changes.len() - 2].time;
    let step = &last.impulse[0];
    let ratio = step.x / step.z;
    println!("stance leg before impact {rate:.5} rad/s, step time {period:.6} s, impulse ratio {ratio:.6}");
    assert!((rate - 1.55).abs() < 0.01, "published: 1.55, here {rate}");
    assert!((rate - 1.5499).abs() < 1e-3 && (period - 1.1216).abs() < 1e-4, "{rate} {period}");
    assert!((ratio + 0.59954).abs() < 1e-4, "{ratio}");
    // The steps have the same foot alternately, on the robot as it is.
    let feet: Vec<&str> = changes.iter().map(|change| change.impulse[0].foot.as_str()).collect();
    assert_eq!(feet[..2], ["left_foot", "right_foot"]);
    assert!(feet.windows(2).all(|pair| pair[0] != pair[1]));
}

#[test]
fn outputs_settle_within_the_step() {
    let text = scenario_text(SCENARIO);
    let (_, samples) = walked("robots/three_link", &text).unwrap();
    // Torso and swing leg lie on the published curves before each impact: at the last row before the second one.
    let first = samples.iter().take_while(|sample| sample.forces[0][2] > 0.0).count();
    let sample = &samples[first - 1];
    let (pitch, stance, swing) = (sample.q[2], sample.q[2] + sample.q[3], sample.q[2] + sample.q[4]);
    let torso = 0.512 + stance * (0.073 + stance * (0.035 - 0.819 * stance));
    let landing = std::f64::consts::FRAC_PI_8;
    let rest = stance.powi(2) - landing.powi(2);
    let mirror = rest * (-2.27 + stance * (3.26 + stance * (3.11 + 1.89 * stance)));
    let y = [pitch - torso, stance + swing - mirror];
    println!("outputs at the end of the first step: {y:?}");
    assert!(y.iter().all(|y| y.abs() < 1e-6), "{y:?}");
    // And they were away from them just after the impact before.
    let start = &samples[1];
    let pitch_rate = start.v[2] - (0.073 + 2.0 * 0.035 * stance) * stance_rate(start);
    assert!(pitch_rate.abs() > 0.1, "{pitch_rate}");
}
