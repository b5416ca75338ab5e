//! Coming down onto hard ground: where it ends, and what it costs.
use super::Numbers;
use super::bodies::Body;
use bipedc_analysis::simulate::{Ground, MotionState};

const STEP: f64 = 1e-3;

/// A brick in the air, tilted in some way and on its way down.
fn thrown(numbers: &mut Numbers, brick: &Body) -> MotionState {
    let mut motion = brick.at(0.25 + 0.05 * numbers.next());
    motion.q[3..6].iter_mut().for_each(|x| *x = 0.2 * numbers.next());
    let length = motion.q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
    motion.q[3..7].iter_mut().for_each(|x| *x /= length);
    motion.v.iter_mut().for_each(|v| *v = 0.5 * numbers.next());
    motion
}

#[test]
fn what_falls_flat_lands_exactly() {
    let brick = Body::brick(false, 0.0);
    let mut stepper = brick.stepper(Ground::default());
    let mut motion = brick.at(0.3);
    let force = vec![0.0; motion.v.len()];
    let (mut impulse, mut lowest) = (0.0, f64::INFINITY);
    while motion.time < 0.5 {
        stepper.step(&mut motion, &force, STEP).unwrap();
        impulse += (0..brick.points.len()).map(|point| stepper.impulse(point)[2]).sum::<f64>();
        lowest = stepper.gaps().iter().copied().fold(lowest, f64::min);
    }
    // By v h = 2.2 mm, where a point has to be below the ground to be seen.
    // What gives way along the normal is a part of 1e-6 of that.
    assert!(lowest > -1e-8, "{lowest}");
    let height = motion.q[2];
    assert!((height - 0.05).abs() < 1e-8, "{height}");
    // All momentum that gravity gave.
    assert!((impulse - brick.mass * 9.81 * motion.time).abs() < 1e-9, "{impulse}");
}

/// Thrown bricks until they rest: the depth (m) of the deepest corner; the largest part of its energy that one gained in a step.
fn thrown_down(step: f64) -> (f64, f64) {
    let mut numbers = Numbers(5);
    let (mut deepest, mut grown) = (0.0_f64, 0.0_f64);
    for case in 0..40 {
        let brick = Body::brick(false, 0.0);
        let friction = 0.1 + 0.02 * f64::from(case);
        let mut stepper = brick.stepper(Ground { friction, ..Ground::default() });
        let mut motion = thrown(&mut numbers, &brick);
        let start: f64 = brick.energy(&motion).iter().sum();
        let (mut pushed, mut fastest, mut lowest) = (Vec::new(), 0.0_f64, 0.0_f64);
        while motion.time < 1.5 {
            let before: f64 = brick.energy(&motion).iter().sum();
            let stepped = stepper.step(&mut motion, &[0.0; 6], step).unwrap();
            let after: f64 = brick.energy(&motion).iter().sum();
            // Impulses of the ground never do work on the brick.
            assert!(stepped.solved.residual <= 1e-8 && stepped.work <= 1e-15, "case {case}: {stepped:?}");
            grown = grown.max((after - before) / start);
            fastest = motion.v[3..].iter().map(|x| x * x).sum::<f64>().max(fastest);
            lowest = stepper.gaps().iter().copied().fold(lowest, f64::min);
            // Who was pushed in the step before has come down since.
            let high = |point: &usize| stepper.gaps()[*point] > 0.5 * step * step * (0.19 * fastest + 9.81);
            assert!(!pushed.iter().any(high), "case {case}: {:?} {:?}", stepper.gaps(), pushed);
            pushed = (0..brick.points.len()).filter(|point| stepper.impulse(*point)[2] > 0.0).collect();
        }
        assert!(motion.v.iter().all(|v| v.abs() < 1e-6), "case {case}: {motion:?}");
        deepest = deepest.max(-lowest);
    }
    println!("step {step} s: deepest {deepest:.1e} m, gain of energy {grown:.1e}");
    (deepest, grown)
}

#[test]
fn corners_come_down_one_by_one_without_sinking_or_making_energy() {
    let [coarse, fine] = [1e-3, 1e-4].map(thrown_down);
    // The curve of a corner's way within a step, `½ h² ω² r`, adds up while a brick rolls over it: of first order, but far below the
    // way of a step, 3 mm.
    assert!(coarse.0 < 1e-4 && fine.0 < 0.2 * coarse.0, "{coarse:?} {fine:?}");
    // What is left is of the time stepping of a body that turns.
    assert!(coarse.1 < 1e-4 && fine.1 < 0.2 * coarse.1, "{coarse:?} {fine:?}");
}

#[test]
fn friction_acts_in_all_of_an_impact() {
    let brick = Body::brick(false, 0.0);
    for height in [0.101, 0.1013, 0.1017, 0.102] {
        let mut stepper = brick.stepper(Ground { friction: 0.3, ..Ground::default() });
        let mut motion = brick.at(height);
        motion.v[0] = 5.0;
        // Slow to turn: it is the sums that count.
        let (mut along, mut normal) = (0.0, 0.0);
        for _ in 0..110 {
            stepper.step(&mut motion, &[0.0; 6], STEP).unwrap();
            for point in 0..8 {
                let [x, _, z] = stepper.impulse(point);
                (along, normal) = (along + x, normal + z);
            }
        }
        assert!((along + 0.3 * normal).abs() < 1e-9, "{along} {normal}");
        let lost = brick.mass * (5.0 - motion.v[0]);
        assert!((lost + along).abs() < 1e-9, "{lost} {along}");
    }
}

#[test]
fn what_rests_at_height_zero_stays() {
    let brick = Body::brick(false, 0.0);
    let mut stepper = brick.stepper(Ground::default());
    for above in [0.0, 1e-12, 1e-9] {
        let mut motion = brick.at(0.05 + above);
        for _ in 0..2000 {
            stepper.step(&mut motion, &[0.0; 6], STEP).unwrap();
        }
        // What gives way, below the weight.
        assert!((motion.q[2] - 0.05).abs() < 1e-10, "{motion:?}");
        assert!(motion.q[..2].iter().chain(&motion.q[3..6]).all(|x| x.abs() < 1e-9), "{motion:?}");
    }
}

#[test]
fn a_rebound_has_the_whole_speed() {
    let brick = Body::brick(false, 0.0);
    let ground = Ground { normal_restitution: 0.5, ..Ground::default() };
    let mut stepper = brick.stepper(ground);
    let mut motion = brick.at(0.1);
    let mut before = 0.0;
    while motion.v[2] <= 0.0 {
        before = motion.v[2];
        stepper.step(&mut motion, &[0.0; 6], STEP).unwrap();
    }
    assert!((motion.v[2] + 0.5 * before).abs() < 1e-12, "{before} {motion:?}");
}
