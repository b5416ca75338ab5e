//! Walkers of few equations, integrated from event to event.
use bipedc_analysis::simulate::phases::{End, Passage, Phased, Precision, Start, Violation, walk};
use nalgebra::Matrix2;

/// Garcia, Chatterjee, Ruina and Coleman (1998): all mass at the hip, almost massless feet, time in √(l/g).
struct Simplest {
    slope: f64,
}

impl Phased for Simplest {
    fn derivative(&self, _: usize, _: f64, x: &[f64], out: &mut [f64]) {
        let [stance, stance_rate, swing, swing_rate] = [x[0], x[1], x[2], x[3]];
        out[0] = stance_rate;
        out[1] = (stance - self.slope).sin();
        out[2] = swing_rate;
        out[3] = out[1] + swing.sin() * (stance_rate * stance_rate - (stance - self.slope).cos());
    }
    fn guard(&self, _: usize, _: f64, x: &[f64]) -> f64 {
        // Negative until the legs are side by side, where the foot would scuff; that does not count.
        2.0 * x[0] - x[2]
    }
    fn violation(&self, _: usize, _: f64, _: &[f64]) -> Option<Violation> {
        None
    }
    fn change(&self, _: usize, _: f64, x: &mut [f64], _: &mut Vec<f64>) -> Result<Passage, Violation> {
        let (stance, rate) = (x[0], x[1]);
        let c = (2.0 * stance).cos();
        x.copy_from_slice(&[-stance, c * rate, -2.0 * stance, c * (1.0 - c) * rate]);
        Ok(0.into())
    }
}

/// After an impact two numbers say everything.
fn section(angle: f64, rate: f64) -> Vec<f64> {
    vec![angle, rate, 2.0 * angle, (1.0 - (2.0 * angle).cos()) * rate]
}

fn stepped(angle: f64, rate: f64) -> ([f64; 2], f64) {
    let start = Start { time: 0.0, phase: 0, x: section(angle, rate) };
    let precision = Precision {
        relative: 1e-13,
        absolute: 1e-14,
        largest_step: 0.1,
        largest_look: 0.1,
        ..Precision::default()
    };
    let done = walk(&Simplest { slope: 0.009 }, start, 20.0, 1, &precision, &mut |_, _, _| ()).unwrap();
    assert_eq!(done.end, End::Changes);
    ([done.last.x[0], done.last.x[1]], done.last.time)
}

#[test]
fn the_simplest_walker_walks_as_published() {
    let known = [0.200_310_900_544_287, -0.199_832_473_004_977];
    let (image, time) = stepped(known[0], known[1]);
    let miss = f64::max((image[0] - known[0]).abs(), (image[1] - known[1]).abs());
    println!("one step returns to {image:.13?}, {miss:.1e} away, after {time:.10}");
    assert!(miss < 1e-11, "{image:?}");
    assert!((time - 3.882_463_753).abs() < 1e-8, "{time}");
    let column = |da: f64, db: f64| {
        let difference = |h: f64| {
            let (plus, minus) = (
                stepped(known[0] + h * da, known[1] + h * db).0,
                stepped(known[0] - h * da, known[1] - h * db).0,
            );
            [0, 1].map(|i| (plus[i] - minus[i]) / (2.0 * h))
        };
        let (fine, coarse) = (difference(1e-4), difference(2e-4));
        [0, 1].map(|i| (4.0 * fine[i] - coarse[i]) / 3.0)
    };
    let (a, b) = (column(1.0, 0.0), column(0.0, 1.0));
    let found = Matrix2::new(a[0], b[0], a[1], b[1]).complex_eigenvalues();
    println!("multipliers {} and {}", found[0], found[1]);
    for z in found.iter() {
        assert!((z.re + 0.190_099_842).abs() < 1e-7 && (z.im.abs() - 0.557_598_774).abs() < 1e-7, "{z}");
    }
}

/// A ball whose every bounce is a change of phase: they follow each other ever faster.
struct Ball;

impl Phased for Ball {
    fn derivative(&self, _: usize, _: f64, x: &[f64], out: &mut [f64]) {
        (out[0], out[1]) = (x[1], -9.81);
    }
    fn guard(&self, _: usize, _: f64, x: &[f64]) -> f64 {
        x[0]
    }
    fn violation(&self, _: usize, _: f64, _: &[f64]) -> Option<Violation> {
        None
    }
    fn change(&self, _: usize, _: f64, x: &mut [f64], _: &mut Vec<f64>) -> Result<Passage, Violation> {
        (x[0], x[1]) = (0.0, -0.7 * x[1]);
        Ok(0.into())
    }
}

#[test]
fn instants_are_found_to_1e_12_s() {
    let start = Start { time: 0.0, phase: 0, x: vec![0.5, 0.0] };
    let done = walk(&Ball, start, 10.0, 12, &Precision::default(), &mut |_, _, _| ()).unwrap();
    let fall = (2.0 * 0.5 / 9.81_f64).sqrt();
    let mut worst = (done.changes[0].time - fall).abs();
    for pair in done.changes.windows(2) {
        // From the speed with which the ball really left the ground.
        let flight = 2.0 * pair[0].after[1] / 9.81;
        worst = worst.max((pair[1].time - pair[0].time - flight).abs());
    }
    println!("instants of {} impacts to {worst:.1e} s", done.changes.len());
    assert!(done.changes.len() == 12 && worst < 1e-12, "{worst}");
}
