//! What contact laws leave open: how the corners of a flat sole share its load.
use super::bodies::Body;
use bipedc_analysis::simulate::{Cone, Ground, MotionState, Stepper};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Forces on the corners of the sole in the last step, N.
fn loads(stepper: &Stepper<'_>, step: f64) -> Vec<[f64; 3]> {
    (0..4).map(|point| stepper.impulse(point).map(|x| x / step)).collect()
}

/// A brick whose sole is slightly below the ground.
fn lying(brick: &Body) -> MotionState {
    brick.at(0.05 - 1e-9)
}

#[test]
fn a_symmetric_block_stands_on_four_equal_corners() {
    let mut brick = Body::brick(false, 0.0);
    brick.mass = 1.0;
    for step in [1e-3, 1e-4] {
        let mut stepper = brick.stepper(Ground::default());
        let mut motion = lying(&brick);
        for _ in 0..50 {
            let stepped = stepper.step(&mut motion, &[0.0; 6], step).unwrap();
            assert!(stepped.solved.converged, "{stepped:?}");
            for load in loads(&stepper, step) {
                assert!((load[2] - 2.4525).abs() < 1e-5, "{load:?}");
                assert!(load[0].abs() < 1e-5 && load[1].abs() < 1e-5, "{load:?}");
            }
        }
    }
}

/// The forces with the least sum of squares that do the same to the body: `Wᵀ (W Wᵀ)⁻¹ W λ` by the force and moment about the
/// middle of the body.
fn least(brick: &Body, motion: &MotionState, forces: &[[f64; 3]]) -> Vec<f64> {
    let turn: Matrix3<f64> = brick.rotation(&motion.q);
    let wrench = DMatrix::from_fn(6, 12, |row, column| {
        let arm = turn * Vector3::from(brick.points[column / 3]);
        let along = Vector3::from_fn(|i, _| f64::from(u8::from(i == column % 3)));
        if row < 3 { along[row] } else { arm.cross(&along)[row - 3] }
    });
    let given = DVector::from_iterator(12, forces.iter().flatten().copied());
    let sum = &wrench * &given;
    let square = &wrench * wrench.transpose();
    (wrench.transpose() * square.try_inverse().unwrap() * sum).as_slice().to_vec()
}

#[test]
fn loads_that_stick_are_shared_by_least_squares() {
    // On a slope, pushed and turned from the side; not so much that a corner lets go or slips.
    let brick = Body::brick(false, 0.2);
    let force = [0.7, -1.1, -3.0, 0.3, 0.4, 0.05];
    for cone in [Cone::Round, Cone::Pyramid] {
        let mut stepper = brick.stepper(Ground { friction: 1.5, cone, ..Ground::default() });
        let mut motion = lying(&brick);
        for _ in 0..20 {
            stepper.step(&mut motion, &force, 1e-3).unwrap();
        }
        let found = loads(&stepper, 1e-3);
        let expected = least(&brick, &motion, &found);
        for (found, expected) in found.iter().flatten().zip(&expected) {
            assert!((found - expected).abs() < 1e-5, "{cone:?}: {found} {expected}");
        }
    }
}

#[test]
fn no_corner_is_pulled_to_share_a_load() {
    // The load stands at six tenths of the way from the middle to a corner: the plane of least squares alone would pull the
    // opposite corner with a twentieth of the weight.
    let brick = Body::brick(false, 0.0);
    let mut stepper = brick.stepper(Ground::default());
    let mut motion = lying(&brick);
    // The equations of a step take the turning that the moment would give without the ground: little, if it is short.
    let (weight, step) = (19.62, 1e-5);
    let moment = [-0.6 * 0.1 * weight, 0.6 * 0.15 * weight];
    for _ in 0..20 {
        let stepped = stepper.step(&mut motion, &[0.0, 0.0, 0.0, moment[0], moment[1], 0.0], step).unwrap();
        assert!(stepped.solved.converged, "{stepped:?}");
    }
    let vertical: Vec<f64> = loads(&stepper, step).iter().map(|load| load[2]).collect();
    println!("{vertical:?}");
    // Corners (−,−), (+,−), (−,+), (+,+): with (−,−) at zero the three others are determined.
    for (found, part) in vertical.iter().zip([0.0, 0.2, 0.2, 0.6]) {
        assert!((found - part * weight).abs() < 1e-4, "{vertical:?}");
    }
}

/// Place, angle, velocity and angular velocity of a sliding block.
type Slide = [f64; 6];

/// Equal springs below the corners: loads are linear in the place on the sole, and balance gravity and friction's moment
/// about the middle of the body, `height` above.
fn friction(state: &Slide, brick: &Body, (mu, height): (f64, f64)) -> [f64; 3] {
    let [_, _, angle, vx, vy, rate] = *state;
    let (sine, cosine) = angle.sin_cos();
    let arms: Vec<[f64; 2]> = brick.points[..4]
        .iter()
        .map(|p| [cosine * p[0] - sine * p[1], sine * p[0] + cosine * p[1]])
        .collect();
    // Unknown plane of loads n = a + b x + c y: force and both moments, friction included.
    let mut system = Matrix3::zeros();
    for arm in &arms {
        let slip = Vector3::new(vx - rate * arm[1], vy + rate * arm[0], 0.0);
        let pull = -mu * slip / slip.norm();
        // Moments about the middle of the body: r × f with r = (x, y, −height).
        let per_load = [1.0, arm[1] + height * pull.y, -arm[0] - height * pull.x];
        for (i, part) in per_load.iter().enumerate() {
            for (j, of) in [1.0, arm[0], arm[1]].iter().enumerate() {
                system[(i, j)] += part * of;
            }
        }
    }
    let plane = system.try_inverse().unwrap() * Vector3::new(brick.mass * 9.81, 0.0, 0.0);
    let mut sum = [0.0; 3];
    for arm in &arms {
        let load = plane[0] + plane[1] * arm[0] + plane[2] * arm[1];
        let slip = [vx - rate * arm[1], vy + rate * arm[0]];
        let size = slip[0].hypot(slip[1]);
        let pull = slip.map(|s| -mu * load * s / size);
        sum[0] += pull[0] / brick.mass;
        sum[1] += pull[1] / brick.mass;
        sum[2] += (arm[0] * pull[1] - arm[1] * pull[0]) / brick.inertia[2];
    }
    sum
}

/// Its motion until it nearly rests, by the classical method of fourth order.
fn exact(brick: &Body, law: (f64, f64), start: Slide) -> Slide {
    let h = 1e-5;
    let mut state = start;
    let rate = |state: &Slide| {
        let [ax, ay, turning] = friction(state, brick, law);
        [state[3], state[4], state[5], ax, ay, turning]
    };
    let along = |state: &Slide, rate: &Slide, time: f64| -> Slide {
        std::array::from_fn(|i| state[i] + time * rate[i])
    };
    while state[3].hypot(state[4]) + 0.1 * state[5].abs() > 2e-3 {
        let a = rate(&state);
        let b = rate(&along(&state, &a, 0.5 * h));
        let c = rate(&along(&state, &b, 0.5 * h));
        let d = rate(&along(&state, &c, h));
        state = std::array::from_fn(|i| state[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    state
}

/// Yaw and place at rest of a block that slides and turns.
fn stepped(brick: &Body, law: (f64, f64), start: Slide, step: f64) -> [f64; 3] {
    let mut stepper = brick.stepper(Ground { friction: law.0, ..Ground::default() });
    let mut motion = lying(brick);
    (motion.v[0], motion.v[1], motion.v[5]) = (start[3], start[4], start[5]);
    while motion.v.iter().any(|v| v.abs() > 1e-7) {
        stepper.step(&mut motion, &[0.0; 6], step).unwrap();
        assert!(motion.time < 2.0, "{motion:?}");
    }
    [motion.q[0], motion.q[1], 2.0 * motion.q[5].atan2(motion.q[6])]
}

#[test]
fn a_sliding_and_turning_block_converges_to_equal_springs() {
    let brick = Body::brick(false, 0.0);
    let (law, start) = ((0.3, 0.05), [0.0, 0.0, 0.0, 1.0, 0.4, 3.0]);
    let exact = exact(&brick, law, start);
    println!("exact: {exact:?}");
    let mut errors = Vec::new();
    for step in [1e-3, 2.5e-4, 6.25e-5] {
        let found = stepped(&brick, law, start, step);
        let error = (0..3).map(|i| (found[i] - exact[i]).abs()).fold(0.0, f64::max);
        println!("step {step}: {found:?}, off by {error:.1e}");
        errors.push(error);
    }
    assert!(errors[2] < 1e-3 && errors[2] < 0.3 * errors[0], "{errors:?}");
}
