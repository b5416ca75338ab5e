//! Filter, spline and resampling against scipy and against functions with known derivatives.
use bipedc_analysis::signal::{Butterworth, Grid, Spline, align_signs, resample, rotate_to_base, rotation};
use serde_json::Value;

fn floats(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect()
}

#[test]
fn zero_phase_filter_equals_scipy() {
    let oracle: Value = serde_json::from_str(include_str!("../support/sosfiltfilt.json")).unwrap();
    let signal: Vec<f64> =
        (0..80).map(f64::from).map(|i| (0.11 * i).sin() + 0.3 * (0.73 * i + 0.4).cos() + 0.002 * i).collect();
    for case in oracle["cases"].as_array().unwrap() {
        let cutoff = case["cutoff_hz"].as_f64().unwrap();
        let filtered = Butterworth::new(cutoff, 250.0).unwrap().zero_phase(&signal);
        for (i, (found, expected)) in filtered.iter().zip(floats(&case["filtered"])).enumerate() {
            assert!((found - expected).abs() < 1e-11, "{cutoff} Hz, sample {i}: {found}, scipy {expected}");
        }
    }
}

#[test]
fn the_spline_differentiates_a_sine() {
    let (step, omega) = (0.004, 2.0 * std::f64::consts::PI * 5.0);
    let samples: Vec<f64> = (0..500).map(|i| (omega * step * f64::from(i)).sin()).collect();
    let spline = Spline::new(&samples, step).unwrap();
    for i in 60..440 {
        let t = step * i as f64;
        // The error of a quintic spline's second derivative falls with the fourth power of the step.
        let expected = [(omega * t).sin(), omega * (omega * t).cos(), -omega * omega * (omega * t).sin()];
        let scales = [1.0, omega, omega * omega];
        let bounds = [1e-13, 1e-7, 1e-6];
        for (k, bound) in bounds.iter().enumerate() {
            let error = (spline.at_sample(i)[k] - expected[k]).abs() / scales[k];
            assert!(error < *bound, "derivative {k} at sample {i}: {error:e}");
            assert!((spline.at(t)[k] - spline.at_sample(i)[k]).abs() < 1e-10 * scales[k] / step);
        }
        let t = t + 0.3 * step;
        assert!((spline.at(t)[0] - (omega * t).sin()).abs() < 1e-7);
        assert!((spline.at(t)[2] + omega * omega * (omega * t).sin()).abs() < 1e-5 * scales[2]);
    }
}

#[test]
fn the_spline_is_exact_for_polynomials_of_degree_five() {
    let p = |x: f64| [x.powi(5) - 2.0 * x * x, 5.0 * x.powi(4) - 4.0 * x, 20.0 * x.powi(3) - 4.0];
    let step = 0.05;
    let samples: Vec<f64> = (0..=80).map(|i| p(step * f64::from(i) - 2.0)[0]).collect();
    let spline = Spline::new(&samples, step).unwrap();
    for t in [1.93, 2.0, 2.01, 2.049] {
        for (found, expected) in spline.at(t).iter().zip(p(t - 2.0)) {
            assert!((found - expected).abs() < 1e-9, "{found} {expected}");
        }
    }
    assert!(Spline::new(&samples[..7], step).is_none());
    for n in 8..40 {
        assert!(Spline::new(&samples[..n], step).unwrap().at_sample(n - 1)[0].is_finite());
    }
}

#[test]
fn cubics_are_resampled_exactly() {
    let f = |t: f64| 1.0 + t * (2.0 - t * (0.5 + 0.1 * t));
    let time: Vec<f64> = (0..50).map(|i| 0.1 * f64::from(i) + 0.04 * f64::from(i * i % 7) / 7.0).collect();
    let values: Vec<f64> = time.iter().map(|t| f(*t)).collect();
    let grid = Grid::covering(0.0, 0.1, time[0], time[49]);
    assert_eq!(grid.time(0), 0.0);
    let even = resample(&time, &values, grid);
    assert_eq!(even.len(), grid.count);
    for (i, value) in even.iter().enumerate() {
        assert!((value - f(grid.time(i))).abs() < 1e-12);
    }
    assert!(resample(&time[..3], &values[..3], grid).is_empty());
}

#[test]
fn angular_velocity_of_two_turns() {
    // R = Rz(a t) Rx(b t): ω in base axes is (b, a sin bt, a cos bt).
    let (a, b, step) = (1.3, 0.7, 0.004);
    let turn = |t: f64| {
        let (sz, cz, sx, cx) =
            ((a * t / 2.0).sin(), (a * t / 2.0).cos(), (b * t / 2.0).sin(), (b * t / 2.0).cos());
        // A length other than one and changing must not matter.
        [cz * sx, sz * sx, sz * cx, cz * cx].map(|c| c * (1.0 + 0.1 * t))
    };
    let mut columns: [Vec<f64>; 4] = Default::default();
    for i in 0..400 {
        let sign = if i % 17 < 8 { 1.0 } else { -1.0 };
        for (column, c) in columns.iter_mut().zip(turn(step * f64::from(i))) {
            column.push(sign * c);
        }
    }
    align_signs(columns.each_mut().map(Vec::as_mut_slice));
    let splines = columns.map(|c| Spline::new(&c, step).unwrap());
    for i in 100..300 {
        let t = step * i as f64;
        let order = |k: usize| std::array::from_fn(|c| splines[c].at_sample(i)[k]);
        let found = rotation(order(0), order(1), order(2)).unwrap();
        let omega = [b, a * (b * t).sin(), a * (b * t).cos()];
        let alpha = [0.0, a * b * (b * t).cos(), -a * b * (b * t).sin()];
        for k in 0..3 {
            assert!((found.velocity[k] - omega[k]).abs() < 1e-9);
            assert!((found.acceleration[k] - alpha[k]).abs() < 1e-7);
        }
        let down = rotate_to_base(found.quaternion, [0.0, 0.0, 1.0]);
        for (found, expected) in down.iter().zip([0.0, (b * t).sin(), (b * t).cos()]) {
            assert!((found - expected).abs() < 1e-9);
        }
    }
    assert!(rotation([0.0; 4], [0.0; 4], [0.0; 4]).is_none());
}
