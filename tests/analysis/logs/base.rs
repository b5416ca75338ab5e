//! Logs of a moving base, and logged velocities.
use crate::logs::support;
use crate::logs::support::reader;
use bipedc_analysis::compare::{Comparison, compare};
use bipedc_analysis::measure::{Options, VelocitySource};
use bipedc_analysis::robot::{BaseKind, Batch, EvaluationError, InverseDynamics, Joint, JointLayout};
use std::fmt::Write;

/// One joint whose effort is a weighted sum of all of v and a, so that an error in any of them shows.
struct Weights(BaseKind);

fn weigh(v: &[f64], a: &[f64]) -> f64 {
    v.iter().chain(a).enumerate().map(|(i, x)| (1.0 + 0.37 * i as f64) * x).sum()
}

impl InverseDynamics for Weights {
    fn nq(&self) -> usize {
        self.0.nq() + 1
    }
    fn nv(&self) -> usize {
        self.0.nv() + 1
    }
    fn torques(&mut self, batch: &Batch<'_>, tau: &mut [f64]) -> Result<(), EvaluationError> {
        let nv = self.nv();
        for (i, tau) in tau.chunks_exact_mut(nv).enumerate() {
            tau.fill(0.0);
            tau[nv - 1] = weigh(&batch.v[i * nv..(i + 1) * nv], &batch.a[i * nv..(i + 1) * nv]);
        }
        Ok(())
    }
}

fn run(base: BaseKind, text: &str, options: &Options) -> Comparison {
    let layout = JointLayout { joints: vec![Joint::revolute("knee")], base };
    compare(&mut Weights(base), &layout, reader(text).unwrap(), options).unwrap()
}

const STEP: f64 = 0.004;
const AXES: [&str; 3] = ["x", "y", "z"];

#[test]
fn a_floating_base() {
    // p = (sin t, cos 2t, t²/2); R = Rz(a t) Rx(b t), so ω = (b, a sin bt, a cos bt) in base axes.
    let (a, b) = (1.3, 0.7);
    let mut text = String::from("time,knee/position,knee/effort");
    AXES.iter().for_each(|k| write!(text, ",base/position/{k}").unwrap());
    ["w", "x", "y", "z"].iter().for_each(|k| write!(text, ",base/orientation/{k}").unwrap());
    for i in 0..1500 {
        let t = STEP * f64::from(i);
        let ((sz, cz), (sx, cx)) = ((a * t).sin_cos(), (b * t).sin_cos());
        let to_base = |w: [f64; 3]| {
            let (x, y) = (cz * w[0] + sz * w[1], cz * w[1] - sz * w[0]);
            [x, cx * y + sx * w[2], cx * w[2] - sx * y]
        };
        let linear = to_base([t.cos(), -2.0 * (2.0 * t).sin(), t]);
        let second = to_base([-t.sin(), -4.0 * (2.0 * t).cos(), 1.0]);
        let omega = [b, a * sx, a * cx];
        let cross = |u: [f64; 3], v: [f64; 3]| {
            [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
        };
        let turned = cross(omega, linear);
        let rates = [linear[0], linear[1], linear[2], omega[0], omega[1], omega[2], 0.3];
        let s = [second[0] - turned[0], second[1] - turned[1], second[2] - turned[2]];
        let seconds = [s[0], s[1], s[2], 0.0, a * b * cx, -a * b * sx, 0.0];
        let effort = weigh(&rates, &seconds);
        let (hz, hx) = ((a * t / 2.0).sin_cos(), (b * t / 2.0).sin_cos());
        // Some recorders flip the sign whenever they like.
        let sign = if i % 7 < 3 { 1.0 } else { -1.0 };
        let [w, x, y, z] = [hz.1 * hx.1, hz.1 * hx.0, hz.0 * hx.0, hz.0 * hx.1].map(|c| sign * c);
        let position = [t.sin(), (2.0 * t).cos(), t * t / 2.0].map(|p| format!("{p}")).join(",");
        write!(text, "\n{t:.3},{},{effort},{position},{w},{x},{y},{z}", 0.3 * t).unwrap();
    }
    let options = Options { trim_s: 1.0, cutoff_hz: Some(25.0), ..Options::default() };
    let comparison = run(BaseKind::Floating, &text, &options);
    assert!(comparison.rms < 1e-5, "{comparison}");
    assert!(comparison.assumptions.iter().any(|a| a.contains("no external forces")));
    let fixed = run(BaseKind::Fixed, &text, &options);
    assert!(fixed.assumptions.iter().any(|a| a.contains("base/... columns are ignored")));
}

#[test]
fn a_planar_base() {
    let mut text =
        String::from("time,knee/position,knee/effort,base/position/x,base/position/z,base/orientation/pitch");
    for i in 0..1000 {
        let t = STEP * f64::from(i);
        let rates = [t.cos(), 2.0 * t, -0.5 * (2.0 * t).sin(), 0.1];
        let seconds = [-t.sin(), 2.0, -(2.0 * t).cos(), 0.0];
        let effort = weigh(&rates, &seconds);
        write!(text, "\n{t:.3},{},{effort},{},{},{}", 0.1 * t, t.sin(), t * t, 0.25 * (2.0 * t).cos())
            .unwrap();
    }
    let options = Options { trim_s: 0.8, cutoff_hz: Some(25.0), ..Options::default() };
    let comparison = run(BaseKind::Planar, &text, &options);
    assert!(comparison.rms < 1e-5, "{comparison}");
}

#[test]
fn an_incomplete_or_senseless_base_is_an_error() {
    let layout = JointLayout { joints: vec![Joint::revolute("knee")], base: BaseKind::Floating };
    let error = |text: &str| {
        compare(&mut Weights(BaseKind::Floating), &layout, reader(text).unwrap(), &Options::default())
            .unwrap_err()
            .to_string()
    };
    let message = error("time,knee/position,knee/effort,base/position/x\n0,1,2,3\n");
    assert!(
        message.contains("log.csv:1") && message.contains("no column `base/position/y`, `base/position/z`"),
        "{message}"
    );
    let mut text = String::from("time,knee/position,knee/effort");
    AXES.iter().for_each(|k| write!(text, ",base/position/{k},base/orientation/{k}").unwrap());
    text.push_str(",base/orientation/w");
    for i in 0..500 {
        write!(text, "\n{},0,0,0,0,0,0,0,0,0", STEP * f64::from(i)).unwrap();
    }
    let message = error(&text);
    assert!(message.contains("base/orientation is no rotation at 0.5 s"), "{message}");
}

#[test]
fn forces_in_the_log_are_mentioned() {
    let log = support::repository("tests/data/examples/swaying/validation.csv.gz");
    let robot = support::rnea::Robot::parse(
        &std::fs::read_to_string(support::repository("robots/tulip/robot.urdf")).unwrap(),
        BaseKind::Floating,
    );
    let layout = support::layout(&robot);
    let mut robot = robot;
    let options = Options { cutoff_hz: Some(10.0), from_s: Some(1.0), to_s: Some(2.0), ..Options::default() };
    let log = bipedc_analysis::log::Log::open(log).unwrap();
    let comparison = bipedc_analysis::compare::compare_file(&mut robot, &layout, &log, &options).unwrap();
    assert!(comparison.warnings[0].to_string().contains("contact forces (`right_foot/force/x`)"));
    assert_eq!(comparison.channels.len(), 12);
}

#[test]
fn logged_velocities_are_used_on_demand() {
    let mut text = String::from("time,knee/position,knee/velocity,knee/effort");
    for i in 0..1000 {
        let t = STEP * f64::from(i);
        // The logged velocity is not that of the logged position.
        write!(
            text,
            "\n{t:.3},0,{},{}",
            (2.0 * t).sin(),
            weigh(&[(2.0 * t).sin()], &[2.0 * (2.0 * t).cos()])
        )
        .unwrap();
    }
    let options = Options {
        velocity: VelocitySource::Logged,
        trim_s: 0.8,
        cutoff_hz: Some(25.0),
        ..Options::default()
    };
    assert!(run(BaseKind::Fixed, &text, &options).rms < 1e-5);
    assert!(
        run(BaseKind::Fixed, &text, &Options { velocity: VelocitySource::Positions, ..options.clone() }).rms
            > 0.5
    );
    let without = text.replace("knee/velocity", "other");
    let comparison = run(BaseKind::Fixed, &without, &options);
    assert!(comparison.warnings[0].to_string().contains("no velocity column for `knee`"));
}
