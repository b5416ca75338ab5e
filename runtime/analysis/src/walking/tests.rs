use super::footsteps::parse_footsteps;
use super::settings::parse_settings;
use super::*;
use crate::polygon::cross;
use bipedc_effects::random::Random;
use nalgebra::{DMatrix, DVector, Matrix3, Rotation3, Vector3};

fn unit(random: &mut Random) -> f64 {
    random.symmetric()
}

#[test]
fn the_profile_reaches_its_end_at_rest_and_has_its_own_derivatives() {
    assert_eq!(moved([0.2, 0.7], 3.0, 3.0), [0.7, 0.0, moved([0.2, 0.7], 3.0, 3.0)[2]]);
    assert!(moved([0.2, 0.7], 0.0, 3.0)[2].abs() < 1e-15 && moved([0.2, 0.7], 3.0, 3.0)[2].abs() < 1e-14);
    for k in 1..50 {
        let (t, h) = (0.06 * f64::from(k), 1e-5);
        let [before, here, after] = [t - h, t, t + h].map(|t| moved([0.2, 0.7], t, 3.0));
        assert!(((after[0] - before[0]) / (2.0 * h) - here[1]).abs() < 1e-9);
        assert!(((after[1] - before[1]) / (2.0 * h) - here[2]).abs() < 1e-9);
    }
}

#[test]
fn margins_are_distances_to_edges() {
    let square = hull(&[[0.0, 0.0], [2.0, 0.0], [1.0, 0.5], [2.0, 1.0], [0.0, 1.0], [0.0, 0.4]]);
    assert_eq!(square, [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]]);
    assert!((margin(&square, [0.3, 0.6]) - 0.3).abs() < 1e-15);
    assert!((margin(&square, [3.0, 2.0]) + 2.0_f64.sqrt()).abs() < 1e-15);
    let away = hull(&[[3.0, 2.0], [4.0, 2.0], [4.0, 3.0]]);
    assert!((distance(&square, &away) - 2.0_f64.sqrt()).abs() < 1e-15);
    let across = hull(&[[-1.0, 0.4], [3.0, 0.4], [3.0, 0.6], [-1.0, 0.6]]);
    assert_eq!([distance(&square, &across), distance(&square, &square)], [0.0, 0.0]);
}

/// Random polygons: no point of the boundary is nearer than the margin, one is as near.
#[test]
fn margins_agree_with_points_all_along_the_edges() {
    let mut random = Random::new(4);
    for _ in 0..200 {
        let points: Vec<Point> = (0..7).map(|_| [unit(&mut random), unit(&mut random)]).collect();
        let (polygon, point) = (hull(&points), [0.8 * unit(&mut random), 0.8 * unit(&mut random)]);
        let n = polygon.len();
        let mut nearest = f64::INFINITY;
        for k in 0..n {
            let (a, b) = (polygon[k], polygon[(k + 1) % n]);
            for i in 0..=4000 {
                let s = f64::from(i) / 4000.0;
                nearest = nearest
                    .min((a[0] + s * (b[0] - a[0]) - point[0]).hypot(a[1] + s * (b[1] - a[1]) - point[1]));
            }
        }
        let found = margin(&polygon, point);
        assert!((found.abs() - nearest).abs() < 1e-3, "{polygon:?} {point:?}: {found} {nearest}");
        let inside = (0..n).all(|k| cross(polygon[k], polygon[(k + 1) % n], point) >= 0.0);
        assert_eq!(found >= 0.0, inside);
    }
}

#[test]
fn the_pendulum_obeys_its_equation_and_rests_at_both_ends() {
    let (step, omega) = (0.005, 3.9);
    // Stands, goes to one side and to the other, stands elsewhere.
    let zmp: Vec<f64> = (0..800).map(|k| [0.0, 0.08, -0.07, 0.03][k / 200]).collect();
    let (motion, used) = pendulum(&zmp, step, omega, Rest { start: 190, end: 190 });
    for (end, rest) in [(0, 0.0), (799, 0.03)] {
        let [x, v, a] = motion[end];
        assert!((x - rest).abs() < 1e-12 && v.abs() < 1e-11 && a.abs() < 1e-10, "{x} {v} {a}");
    }
    // In between nothing is changed, and each stretch is (6.45).
    for k in 200..599 {
        assert_eq!(used[k], zmp[k]);
    }
    for first in [200, 400] {
        let (p, [x, v, _]) = (zmp[first], motion[first]);
        for (k, [here, _, acceleration]) in motion[first..first + 199].iter().enumerate() {
            let t = k as f64 * step;
            let wished = p + (x - p) * (omega * t).cosh() + v / omega * (omega * t).sinh();
            assert!((here - wished).abs() < 1e-12);
            assert!((acceleration - omega * omega * (here - p)).abs() < 1e-12);
        }
    }
    // Velocities are derivatives where the zero moment point does not jump.
    for k in 202..390 {
        let rate = (motion[k + 1][0] - motion[k - 1][0]) / (2.0 * step);
        assert!((rate - motion[k][1]).abs() < 2e-5);
    }
}

/// ė_o = Lᵀ ω_d − L ω_e, from which (6.52) follows.
#[test]
fn errors_of_orientations_have_the_rate_that_the_compensation_takes() {
    let mut random = Random::new(9);
    for _ in 0..100 {
        let mut vector =
            |size: f64| size * Vector3::new(unit(&mut random), unit(&mut random), unit(&mut random));
        let (here, wished) = (Rotation3::new(vector(0.6)), Rotation3::new(vector(0.6)));
        let (omega_here, omega_wished) = (vector(1.0), vector(1.0));
        let after = |h: f64| {
            let turned = |r: Rotation3<f64>, w: Vector3<f64>| (Rotation3::new(w * h) * r).into_inner();
            turn_error(&turned(here, omega_here), &turned(wished, omega_wished))
        };
        let rate = (after(1e-5) - after(-1e-5)) / 2e-5;
        let l = turn_matrix(&here.into_inner(), &wished.into_inner());
        assert!((rate - (l.transpose() * omega_wished - l * omega_here)).amax() < 1e-9);
    }
    assert_eq!(turn_matrix(&Matrix3::identity(), &Matrix3::identity()), Matrix3::identity());
}

#[test]
fn steps_stay_within_bounds_and_are_exact_where_they_can_be() {
    let mut random = Random::new(2);
    for _ in 0..100 {
        let jacobian = DMatrix::from_fn(6, 6, |i, j| unit(&mut random) + if i == j { 3.0 } else { 0.0 });
        let meant = DVector::from_fn(6, |_, _| unit(&mut random));
        let wide = vec![[-2.0, 2.0]; 6];
        let free = bounded_least_squares(&jacobian, &(&jacobian * &meant), &wide);
        assert!((&free.step - &meant).amax() < 1e-12 && free.held.is_empty() && !free.damped);
        let narrow = vec![[-0.3, 0.4]; 6];
        let held = bounded_least_squares(&jacobian, &(&jacobian * &meant), &narrow);
        assert!(held.step.iter().all(|x| (-0.3..=0.4).contains(x)), "{}", held.step);
        assert_eq!(held.held.is_empty(), meant.iter().all(|x| (-0.3..=0.4).contains(x)));
    }
    // Numbers that are none end.
    let none = DMatrix::from_element(2, 2, f64::NAN);
    assert!(bounded_least_squares(&none, &DVector::zeros(2), &[[-1.0, 1.0]; 2]).damped);
    assert_eq!(straight_direction(&none, 0..2), None);
    // A direction that is not felt: no long step, and the others are right.
    let flat = DMatrix::from_row_slice(2, 2, &[1.0, 0.0, 0.0, 1e-9]);
    let damped = bounded_least_squares(&flat, &DVector::from_vec(vec![0.5, 0.1]), &[[-9.0, 9.0]; 2]);
    assert!(damped.damped && (damped.step[0] - 0.5).abs() < 1e-12 && damped.step[1].abs() < 1e-3);
}

#[test]
fn shared_wrenches_add_up_and_a_foot_lets_go_smoothly() {
    let wrench = [3.0, -2.0, 180.0, 4.0, -9.0, 1.5];
    let centers = [[0.1, -0.08, 0.0], [0.3, 0.09, 0.0]];
    let force = |share: f64| distribute(&wrench, centers, [share, 1.0 - share], 0.12);
    for share in [0.0, 1e-9, 0.2, 0.5, 1.0] {
        let both = force(share);
        assert!((0..6).all(|i| (both[0][i] + both[1][i] - wrench[i]).abs() < 1e-9), "{both:?}");
    }
    assert_eq!(force(0.0)[0], [0.0; 6]);
    assert!(force(1e-9)[0].iter().all(|x| x.abs() < 1e-5));
    let corners = [[0.2, 0.1], [0.2, -0.1], [-0.1, 0.1], [-0.1, -0.1]];
    let forces = corner_forces(&[3.0, -2.0, 100.0, 2.0, -5.0, 0.0], &corners);
    let sum = |of: &dyn Fn(usize) -> f64| (0..4).map(of).sum::<f64>();
    assert!((sum(&|k| forces[k][2]) - 100.0).abs() < 1e-9 && (sum(&|k| forces[k][0]) - 3.0).abs() < 1e-12);
    assert!((sum(&|k| corners[k][1] * forces[k][2]) - 2.0).abs() < 1e-9);
    assert!((sum(&|k| -corners[k][0] * forces[k][2]) + 5.0).abs() < 1e-9);
}

#[test]
fn sequences_lead_and_join() {
    let turn = 15.0_f64.to_radians();
    let of = |advance, even| Sequence { steps: vec![advance; 6], width: 0.2, even }.footsteps();
    let steps = of(Advance { turn: 0.5 * turn, ..Advance::default() }, false);
    let yaws: Vec<f64> = steps.iter().map(|step| (step.sole.yaw / turn).round()).collect();
    assert_eq!((steps[0].foot, yaws), (1, vec![1.0, 1.0, 2.0, 2.0, 3.0, 3.0]));
    let right = of(Advance { sideways: -0.03, ..Advance::default() }, false);
    let at: Vec<f64> = right.iter().map(|step| (step.sole.place[1] * 100.0).round()).collect();
    assert_eq!((right[0].foot, at), (0, vec![-16.0, 4.0, -22.0, -2.0, -28.0, -8.0]));
    let ahead = of(Advance { forward: 0.1, ..Advance::default() }, true);
    let at: Vec<f64> = ahead.iter().map(|step| (step.sole.place[0] * 10.0).round()).collect();
    assert_eq!(at, [1.0, 2.0, 3.0, 4.0, 5.0, 5.0]);
}

/// Everything but the first is refused, and where.
#[test]
fn tables_of_footsteps_are_read_or_refused_with_their_place() {
    let good = "# to the left\nfoot,x,y,yaw,duration\nleft,0,0.2,0.1,\nright,0.1,-0.1,0,0.8\n";
    let steps = parse_footsteps(good).unwrap();
    assert_eq!((steps[0].foot, steps[0].line, steps[0].duration), (1, Some(3), None));
    assert_eq!((steps[1].sole, steps[1].duration), (Sole { place: [0.1, -0.1], yaw: 0.0 }, Some(0.8)));
    for (text, place, words) in [
        ("", None, "no header"),
        ("foot,x,y\n", Some((1, 1)), "columns"),
        ("foot,x,y,yaw\n", None, "no steps"),
        ("foot,x,y,yaw\nmiddle,0,0,0\n", Some((2, 1)), "`middle` is no foot"),
        ("foot,x,y,yaw\nleft,0,zero,0\n", Some((2, 8)), "`zero` is no number"),
        ("foot,x,y,yaw\nleft,0,0,0,1\n", Some((2, 1)), "5 fields"),
        ("foot,x,y,yaw\nleft,0,inf,0\n", Some((2, 8)), "y = inf"),
        ("foot,x,y,yaw,duration\nleft,0,0,0,-1\n", Some((2, 12)), "-1 s"),
    ] {
        let wrong = &parse_footsteps(text).unwrap_err().0[0];
        assert!(wrong.message.contains(words) && wrong.position == place, "{text}: {wrong}");
    }
}

#[test]
fn numbers_of_walks_are_read_or_refused_with_their_place() {
    let stated = parse_settings("margin = 0.02\n[posture]\nneck = 1\n").unwrap();
    assert!(stated.states("margin") && !stated.states("friction") && stated.posture["neck"] == 1.0);
    for (text, place, words) in [
        ("margin = \n", (1, 10), ""),
        ("\nmagrin = 0.1\n", (2, 10), "`magrin`"),
        ("margin = -1\n", (1, 10), "-1"),
        ("margin = \"wide\"\n", (1, 10), "is no number"),
        ("[posture]\nneck = nan\n", (1, 1), "`neck` is no number"),
    ] {
        let wrong = &parse_settings(text).unwrap_err().0[0];
        assert!(wrong.message.contains(words) && wrong.position == Some(place), "{text}: {wrong}");
    }
}

/// Whatever stands in a file: an answer, no panic.
#[test]
fn mutated_files_are_read_or_refused() {
    let mut random = Random::new(77);
    let steps = "foot,x,y,yaw,duration\nleft,0.08,0.09,0.1,0.5\nright,0.15,-0.07,0.2,\n";
    let numbers = "margin = 0.02\nstep_height = 3e-2\n[posture]\nneck = 1\n";
    let pieces = ["", ",", "\n", "nan", "-", "1e999", "[", "\"", "=", "ä", "left", "\0"];
    for _ in 0..4000 {
        for text in [steps, numbers] {
            let mut letters: Vec<char> = text.chars().collect();
            for _ in 0..3 {
                let at = (random.unit() * letters.len() as f64) as usize;
                let end = (at + (random.unit() * 6.0) as usize).min(letters.len());
                let piece = pieces[(random.unit() * pieces.len() as f64) as usize];
                letters.splice(at..end, piece.chars());
            }
            let changed: String = letters.into_iter().collect();
            if let Ok(steps) = parse_footsteps(&changed) {
                assert!(steps.iter().all(|step| step.sole.place[0].is_finite() && step.sole.yaw.is_finite()));
            }
            let _ = parse_settings(&changed);
        }
    }
}
