//! Standing, sticking and sliding.
use super::bodies::Body;
use bipedc_analysis::simulate::{Cone, Ground};

/// Where a brick is after a second on a slope, and how fast.
fn slid(planar: bool, slope: f64, friction: f64, direction: f64, cone: Cone) -> (f64, f64) {
    let mut brick = Body::brick(planar, slope);
    let (down, level) = (brick.gravity[0], brick.gravity[2]);
    brick.gravity = [down * direction.cos(), down * direction.sin(), level];
    let mut stepper = brick.stepper(Ground { friction, cone, ..Ground::default() });
    // A nanometre deep: at a height of zero, rounding decides now and then which corners touch, and the brick falls onto the
    // others, by some 10 µm in a step or two.
    let mut motion = brick.at(0.05 - 1e-9);
    let force = vec![0.0; motion.v.len()];
    for _ in 0..1000 {
        let stepped = stepper.step(&mut motion, &force, 1e-3).unwrap();
        assert!(stepped.solved.residual < 1e-6, "{stepped:?}");
    }
    let at = brick.position(&motion.q);
    let velocity = if planar { motion.v[0] } else { motion.v[0].hypot(motion.v[1]) };
    (at.x.hypot(at.y), velocity)
}

#[test]
fn a_brick_sticks_below_the_friction_limit_and_slides_above_it() {
    let friction = 0.5_f64;
    let limit = friction.atan();
    for planar in [true, false] {
        for direction in [0.0, 0.3, 0.785] {
            if planar && direction != 0.0 {
                continue;
            }
            let (way, speed) = slid(planar, 0.99 * limit, friction, direction, Cone::Round);
            println!("planar {planar}, direction {direction}: stuck to {way:.1e} m, {speed:.1e} m/s");
            assert!(way < 1e-9 && speed < 1e-9, "{way} {speed}");
            let slope = 1.2 * limit;
            let (way, speed) = slid(planar, slope, friction, direction, Cone::Round);
            let a = 9.81 * (slope.sin() - friction * slope.cos());
            println!("  slid {way:.6} m (exact {:.6}), {speed:.6} m/s (exact {a:.6})", 0.5 * a);
            assert!((speed - a).abs() < 1e-2 * a && (way - 0.5 * a).abs() < 1e-2 * a);
        }
    }
}

#[test]
fn the_pyramid_holds_more_along_its_diagonal() {
    let friction = 0.5_f64;
    let slope = (1.3 * friction).atan();
    let diagonal = std::f64::consts::FRAC_PI_4;
    assert!(slid(false, slope, friction, diagonal, Cone::Pyramid).1 < 1e-9, "√2 μ > 1.3 μ");
    assert!(slid(false, slope, friction, 0.0, Cone::Pyramid).1 > 0.5);
    assert!(slid(false, slope, friction, diagonal, Cone::Round).1 > 0.5);
}

#[test]
fn a_standing_brick_stays_and_its_corners_carry_its_weight() {
    let brick = Body::brick(false, 0.0);
    let mut stepper = brick.stepper(Ground::default());
    let mut motion = brick.at(0.05);
    for _ in 0..5000 {
        stepper.step(&mut motion, &[0.0; 6], 1e-3).unwrap();
    }
    assert!((motion.q[2] - 0.05).abs() < 2e-5, "{:?}", motion.q);
    assert!(motion.v.iter().all(|v| v.abs() < 1e-8), "{:?}", motion.v);
    let carried: f64 = (0..8).map(|i| stepper.impulse(i)[2]).sum();
    assert!((carried / 1e-3 - 2.0 * 9.81).abs() < 1e-6, "{carried}");
}

#[test]
fn recovery_pushes_a_body_out_of_the_ground() {
    let brick = Body::brick(false, 0.0);
    let mut stepper = brick.stepper(Ground { recovery: 10.0, ..Ground::default() });
    let mut motion = brick.at(0.045);
    for _ in 0..1000 {
        stepper.step(&mut motion, &[0.0; 6], 1e-3).unwrap();
    }
    // Two time constants per 0.2 s: 5 mm · e⁻¹⁰.
    assert!((motion.q[2] - 0.05).abs() < 1e-6, "{:?}", motion.q);
}
