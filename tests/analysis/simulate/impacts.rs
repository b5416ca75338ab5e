//! Impacts: the bouncing ball with its Zeno point, and energy.
use super::Numbers;
use super::bodies::Body;
use bipedc_analysis::simulate::{Cone, Ground, MotionState};

/// Highest point of each flight, and when the ball has come to rest.
fn bounces(step: f64, restitution: f64, drop: f64) -> (Vec<f64>, f64, MotionState) {
    let ball = Body::ball();
    let ground = Ground { normal_restitution: restitution, ..Ground::default() };
    let mut stepper = ball.stepper(ground);
    let mut motion = ball.at(drop);
    let (mut apexes, mut rest) = (Vec::new(), f64::NAN);
    while motion.time < 4.0 {
        let before = motion.v[1];
        stepper.step(&mut motion, &[0.0; 3], step).unwrap();
        if before > 0.0 && motion.v[1] <= 0.0 {
            apexes.push(motion.q[1]);
        }
        if motion.v[1].abs() > 10.0 * step {
            rest = motion.time;
        }
    }
    (apexes, rest, motion)
}

#[test]
fn a_ball_passes_its_zeno_point() {
    let (drop, e) = (0.5, 0.7_f64);
    let fall = (2.0 * drop / 9.81_f64).sqrt();
    let zeno = fall * (1.0 + e) / (1.0 - e);
    let mut errors = Vec::new();
    for step in [1e-3, 2.5e-4, 6.25e-5] {
        let (apexes, rest, last) = bounces(step, e, drop);
        // First order in the step: an impact counts from the middle of its step, at most half a step late.
        let height = |n: usize| drop * e.powi(2 * n as i32);
        let worst = (1..=6).map(|n| (apexes[n - 1] / height(n) - 1.0).abs()).fold(0.0, f64::max);
        println!("step {step}: apexes to {worst:.1e}, at rest after {rest} s, Zeno point {zeno} s");
        assert!((rest - zeno).abs() < 0.1 * zeno * (step / 1e-3).sqrt(), "{rest} {zeno}");
        assert!(last.v[1].abs() < 1e-9 && last.q[1].abs() < 10.0 * step, "{last:?}");
        errors.push(worst);
    }
    assert!(errors[2] < 0.2 * errors[0] && errors[2] < 5e-3, "{errors:?}");
}

/// A brick that touches with some corners, with a random velocity that drives it into the ground.
fn struck(numbers: &mut Numbers, brick: &Body) -> MotionState {
    let mut motion = brick.at(-1.0);
    motion.q[3..6].iter_mut().for_each(|x| *x = 0.1 * numbers.next());
    let length = motion.q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
    motion.q[3..7].iter_mut().for_each(|x| *x /= length);
    motion.v.iter_mut().for_each(|v| *v = 3.0 * numbers.next());
    let turn = brick.rotation(&motion.q);
    let heights = brick.points.iter().map(|p| (turn * nalgebra::Vector3::from(*p)).z);
    // One to several corners are below the ground.
    motion.q[2] = -heights.fold(f64::INFINITY, f64::min) - 0.05 * numbers.next().abs();
    motion
}

#[test]
fn no_impact_makes_energy() {
    let mut brick = Body::brick(false, 0.0);
    brick.gravity = [0.0; 3];
    let mut numbers = Numbers(1);
    let (mut largest, mut closed) = (f64::NEG_INFINITY, [0; 9]);
    for case in 0..600 {
        let e = 0.5 + 0.5 * numbers.next();
        let friction = 1.5 * numbers.next().abs();
        let cone = if case % 3 == 0 { Cone::Pyramid } else { Cone::Round };
        // Equal restitution in all directions (dissipative: Λ·ξ ≤ 0), or none of friction at all.
        let (friction, tangential) = if case % 4 == 0 { (0.0, 0.0) } else { (friction, e) };
        let ground = Ground {
            friction,
            normal_restitution: e,
            tangential_restitution: tangential,
            cone,
            ..Ground::default()
        };
        let mut stepper = brick.stepper(ground);
        let mut motion = struck(&mut numbers, &brick);
        let before = brick.energy(&motion)[0];
        let stepped = stepper.step(&mut motion, &[0.0; 6], 1e-12).unwrap();
        assert!(stepped.solved.converged, "case {case}: {stepped:?}");
        closed[stepped.contacts] += 1;
        let change = brick.energy(&motion)[0] - before;
        assert!((change - stepped.work).abs() < 1e-9 * before, "case {case}: {change} {}", stepped.work);
        largest = largest.max(change / before);
    }
    println!("largest relative change of energy {largest:.1e}; closed corners {closed:?}");
    assert!(largest < 1e-8, "{largest}");
    assert!(closed[1] > 50 && closed[2] > 20 && closed[3..].iter().sum::<i32>() > 20, "{closed:?}");
}

#[test]
fn without_restitution_the_feet_stay() {
    // (4.3) with e = 0 and enough friction: the corners that get an impulse stop.
    let brick = Body::brick(false, 0.0);
    let mut numbers = Numbers(7);
    for _ in 0..50 {
        let mut stepper = brick.stepper(Ground { friction: 100.0, ..Ground::default() });
        let mut motion = struck(&mut numbers, &brick);
        stepper.step(&mut motion, &[0.0; 6], 1e-12).unwrap();
        let turn = brick.rotation(&motion.q);
        for (i, point) in brick.points.iter().enumerate() {
            let impulse = stepper.impulse(i);
            assert!(impulse[2] >= 0.0);
            if impulse[2] > 1e-6 {
                let omega = nalgebra::Vector3::new(motion.v[3], motion.v[4], motion.v[5]);
                let linear = nalgebra::Vector3::new(motion.v[0], motion.v[1], motion.v[2]);
                let velocity = turn * (linear + omega.cross(&nalgebra::Vector3::from(*point)));
                assert!(velocity.z.abs() < 1e-6, "{velocity}");
                let inside = impulse[0].hypot(impulse[1]) < 99.0 * impulse[2];
                assert!(!inside || velocity.norm() < 1e-6, "{velocity}");
            }
        }
    }
}

/// Dropped bricks that bounce and turn: the most that a step's law made, the most that its energy grew by (as parts of the
/// energy at the start), the worst residual, and how many of the steps with contact did not reach the tolerance.
fn bounced([normal, tangential]: [f64; 2], step: f64) -> (f64, f64, f64, [usize; 2]) {
    let (mut made, mut grown, mut worst, mut counts) = (0.0_f64, 0.0_f64, 0.0_f64, [0; 2]);
    for case in 0..20 {
        let brick = Body::brick(false, 0.0);
        let ground = Ground {
            friction: 0.1 + 0.05 * f64::from(case),
            normal_restitution: normal,
            tangential_restitution: tangential,
            ..Ground::default()
        };
        let mut stepper = brick.stepper(ground);
        let mut motion = brick.at(0.2);
        let [a, b] = [0.02 * f64::from(case % 7), 0.013 * f64::from(case % 5)];
        motion.q[3..].copy_from_slice(&[a, b, 0.0, (1.0 - a * a - b * b).sqrt()]);
        (motion.v[0], motion.v[5]) = (0.1 * f64::from(case % 3), 0.3 * f64::from(case % 4));
        let start: f64 = brick.energy(&motion).iter().sum();
        while motion.time < 2.0 {
            let before: f64 = brick.energy(&motion).iter().sum();
            let stepped = stepper.step(&mut motion, &[0.0; 6], step).unwrap();
            let after: f64 = brick.energy(&motion).iter().sum();
            made = made.max(stepped.made / start);
            grown = grown.max((after - before) / start);
            worst = worst.max(stepped.solved.residual);
            counts[0] += usize::from(stepped.contacts > 0 && !stepped.solved.converged);
            counts[1] += usize::from(stepped.contacts > 0);
        }
    }
    println!(
        "{normal} {tangential}, {step} s: made {made:.1e}, grown {grown:.1e}, residual {worst:.1e}, {counts:?}"
    );
    (made, grown, worst, counts)
}

#[test]
fn equal_restitution_makes_no_energy_but_by_the_length_of_the_step() {
    for restitution in [0.5, 0.8] {
        let (made, grown, ..) = bounced([restitution; 2], 1e-3);
        assert!(made == 0.0 && grown < 1e-5, "{restitution}: {made} {grown}");
    }
    // Nothing is lost: errors of first order of impacts of a turning body show.
    let (made, coarse, ..) = bounced([1.0; 2], 1e-3);
    let (_, fine, ..) = bounced([1.0; 2], 1e-4);
    assert!(made < 1e-12 && coarse < 8e-3 && fine < 0.2 * coarse, "{made} {coarse} {fine}");
    let (made, ..) = bounced([0.8, 0.0], 1e-3);
    assert!(made > 1e-6, "Kane and Levinson: {made}");
}

#[test]
fn normal_restitution_alone_is_solved_but_for_few_steps() {
    for restitution in [0.3, 0.5, 0.8] {
        let (_, _, worst, [missed, all]) = bounced([restitution, 0.0], 1e-3);
        assert!(30 * missed < all && worst < 1e-3, "{restitution}: {worst} in {missed} of {all}");
    }
}
