//! The passive compass gait on 3 degrees (Goswami, Thuilot and Espiau, 1998): fixed point, period and multipliers.
use super::{passive, phased, ready};
use bipedc_analysis::simulate::phases::{Assumptions, End, PhasedRobot, Precision, Start, walk};
use bipedc_runtime::nalgebra::{Matrix3, Vector3};
use std::f64::consts::PI;

const SLOPE: f64 = PI / 60.0;

/// After an impact, from the stance foot: stance leg against the slope's normal, rates of stance and swing leg; the swing
/// leg mirrors the stance leg. rad, rad/s.
type Section = Vector3<f64>;

/// q and v with the right foot at the origin.
fn standing(section: &Section) -> Vec<f64> {
    let [angle, stance, swing] = [section[0], section[1], section[2]];
    let (s, c) = angle.sin_cos();
    vec![s, c, angle, -2.0 * angle, stance * c, -stance * s, stance, swing - stance]
}

fn robot(walker: &bipedc::simulation::Walker) -> PhasedRobot<'_> {
    // Without knees the swing foot passes through the ground.
    let assumptions = Assumptions { scuffing: f64::INFINITY, shortest_step: 0.05, ..Assumptions::default() };
    phased(walker, assumptions, passive)
}

/// One step: the section after it, its time and length.
fn stepped(robot: &PhasedRobot<'_>, section: &Section) -> (Section, f64, f64) {
    let start = Start { time: 0.0, phase: 0, x: standing(section) };
    let done = walk(robot, start, 5.0, 1, &Precision::default(), &mut |_, _, _| ()).unwrap();
    assert_eq!(done.end, End::Changes);
    let x = &done.last.x;
    // The left leg stands now.
    let length = f64::hypot(x[0] - (x[2] + x[3]).sin(), x[1] - (x[2] + x[3]).cos());
    (Section::new(x[2] + x[3], x[6] + x[7], x[6]), done.last.time, length)
}

/// Literature and two recomputations agree on these: angles against the vertical, then rates.
const KNOWN: [f64; 4] = [-0.218_668_802_939, 0.323_388_558_059, 1.092_383_589_884, 0.377_373_948_907];

#[test]
fn the_fixed_point_has_the_known_digits() {
    let walker = ready("tests/data/simulate/compass");
    let robot = robot(&walker);
    // Newton's method on the return map, from a rounded start.
    let mut section = Section::new(-0.27, 1.09, 0.38);
    for _ in 0..8 {
        let (image, ..) = stepped(&robot, &section);
        let jacobian = slope(&robot, &section) - Matrix3::identity();
        section -= jacobian.lu().solve(&(image - section)).unwrap();
    }
    let (image, time, length) = stepped(&robot, &section);
    assert!((image - section).amax() < 1e-11, "{}", image - section);
    let found = [section[0] + SLOPE, -section[0] + SLOPE, section[1], section[2]];
    let miss = found.iter().zip(KNOWN).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    println!("fixed point {found:.12?}, {miss:.1e} from the known one; T = {time:.12} s, {length:.10} m");
    assert!(miss < 1e-9, "{found:?}");
    assert!((time - 0.734_346_391_2).abs() < 1e-9 && (length - 0.535_445_42).abs() < 1e-8, "{time} {length}");
}

/// Derivative of the return map: central differences, extrapolated.
fn slope(robot: &PhasedRobot<'_>, section: &Section) -> Matrix3<f64> {
    let difference = |axis: usize, h: f64| {
        let mut unit = Section::zeros();
        unit[axis] = h;
        (stepped(robot, &(section + unit)).0 - stepped(robot, &(section - unit)).0) / (2.0 * h)
    };
    let columns = [0, 1, 2].map(|axis| (4.0 * difference(axis, 1e-4) - difference(axis, 2e-4)) / 3.0);
    Matrix3::from_columns(&columns)
}

#[test]
fn the_multipliers_have_the_known_digits() {
    let walker = ready("tests/data/simulate/compass");
    let robot = robot(&walker);
    let section = Section::new(KNOWN[0] - SLOPE, KNOWN[2], KNOWN[3]);
    let mut found: Vec<[f64; 2]> =
        slope(&robot, &section).complex_eigenvalues().iter().map(|z| [z.re, z.im]).collect();
    found.sort_by(|a, b| a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1])));
    let known = [[-0.199_726_127, -0.544_476_062], [-0.199_726_127, 0.544_476_062], [0.131_572_624, 0.0]];
    let miss =
        found.iter().flatten().zip(known.iter().flatten()).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    println!("multipliers {found:.9?}, {miss:.1e} from the known ones");
    assert!(miss < 1e-7, "{found:?}");
}

#[test]
fn many_steps_stay_on_the_gait_and_energy_is_kept_in_between() {
    let walker = ready("tests/data/simulate/compass");
    let robot = robot(&walker);
    let section = Section::new(KNOWN[0] - SLOPE + 1e-3, KNOWN[2], KNOWN[3]);
    let start = Start { time: 0.0, phase: 0, x: standing(&section) };
    let mut drift = 0.0_f64;
    let mut energy = None;
    let mut last = 0;
    let done = walk(&robot, start, 60.0, 40, &Precision::default(), &mut |_, phase, x| {
        // Legs as point masses, hip as another; gravity along the slope's axes.
        let present = total_energy(x);
        if phase != last {
            energy = None;
        }
        last = phase;
        drift = drift.max((present - *energy.get_or_insert(present)).abs());
    })
    .unwrap();
    assert_eq!(done.end, End::Changes);
    let times: Vec<f64> = done.changes.windows(2).map(|pair| pair[1].time - pair[0].time).collect();
    let period = times[times.len() - 1];
    println!("after 40 steps T = {period:.10} s; energy drifts by {drift:.1e} J within steps");
    // The disturbance dies out with the largest multiplier: 0.58⁴⁰ = 3e-10.
    assert!((period - 0.734_346_391_2).abs() < 1e-8, "{period}");
    assert!(drift < 1e-7, "{drift}");
    assert!(robot.heights(&done.last.x[..4]).iter().any(|height| height.abs() < 1e-9));
}

fn total_energy(x: &[f64]) -> f64 {
    let (right, left) = (x[2], x[2] + x[3]);
    let (turn, other) = (x[6], x[6] + x[7]);
    let hip = [x[0], x[1], x[4], x[5]];
    let leg = |angle: f64, rate: f64| {
        [
            x[0] - 0.5 * angle.sin(),
            x[1] - 0.5 * angle.cos(),
            x[4] - 0.5 * rate * angle.cos(),
            x[5] + 0.5 * rate * angle.sin(),
        ]
    };
    let of = |mass: f64, p: [f64; 4]| {
        let height = -p[0] * SLOPE.sin() + p[1] * SLOPE.cos();
        mass * (0.5 * (p[2] * p[2] + p[3] * p[3]) + 9.81 * height)
    };
    of(10.0, hip) + of(5.0, leg(right, turn)) + of(5.0, leg(left, other))
}
