//! Without contact: energy and order of convergence.
use super::bodies::Body;
use bipedc_analysis::simulate::{Ground, MotionState};

fn tumbled(step: f64, time: f64) -> MotionState {
    let brick = Body::brick(false, 0.0);
    let mut stepper = brick.stepper(Ground::default());
    let mut motion = brick.at(1e3);
    motion.v = vec![0.4, -0.3, 2.0, 1.0, 4.0, -2.0];
    let steps = (time / step).round() as usize;
    for _ in 0..steps {
        stepper.step(&mut motion, &[0.0; 6], step).unwrap();
    }
    motion
}

fn distance(a: &MotionState, b: &MotionState) -> f64 {
    let all = |m: &MotionState| m.q.iter().chain(&m.v).copied().collect::<Vec<_>>();
    all(a).iter().zip(all(b)).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}

#[test]
fn free_flight_converges_with_the_square_of_the_step() {
    let best = tumbled(3.125e-5, 1.0);
    let errors: Vec<f64> = [4e-3, 2e-3, 1e-3].iter().map(|h| distance(&tumbled(*h, 1.0), &best)).collect();
    let orders: Vec<f64> = errors.windows(2).map(|e| (e[0] / e[1]).log2()).collect();
    println!("errors {errors:?}, orders {orders:.3?}");
    assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.1), "{orders:?}");
}

#[test]
fn a_flying_body_keeps_its_energy_and_falls_as_galilei_says() {
    let brick = Body::brick(false, 0.0);
    let start = tumbled(1e-3, 0.0);
    let mut drifts = Vec::new();
    for step in [1e-3, 5e-4] {
        let end = tumbled(step, 2.0);
        let total = |m: &MotionState| brick.energy(m).iter().sum::<f64>();
        drifts.push(((total(&end) - total(&start)) / brick.energy(&start)[0]).abs());
        // The centre of mass does not know of the turning.
        let expected = [0.4 * 2.0, -0.3 * 2.0, 1e3 + 2.0 * 2.0 - 0.5 * 9.81 * 4.0];
        for (i, x) in expected.iter().enumerate() {
            assert!((end.q[i] - x).abs() < 20.0 * step, "{i}: {} {x}", end.q[i]);
        }
    }
    println!("relative drift of the energy in 2 s: {drifts:?}");
    assert!((3.5..4.5).contains(&(drifts[0] / drifts[1])) && drifts[1] < 1e-4, "{drifts:?}");
}
