//! On a pendulum with two links, whose regressor fits on a page.

use super::limits::{excess, fine};
use super::*;
use crate::identify::BatchRegressor;
use crate::robot::Trajectory;
use crate::robot::{BaseKind, Batch, EvaluationError, InverseDynamics, Joint, JointLayout};
use std::cell::RefCell;
use std::time::Duration;

const LENGTH: f64 = 0.4;
/// Base parameters: I₁ + m₂l², I₂, m₂c₂, m₁c₁ + m₂l.
const TRUTH: [f64; 4] = [0.5, 0.1, 0.3, 1.2];

struct Pendulum {
    pattern: Vec<Vec<usize>>,
}

impl Pendulum {
    fn new() -> Self {
        Self { pattern: vec![vec![0, 1, 2, 3], vec![1, 2]] }
    }

    /// The two rows at a state.
    fn rows([q, v, a]: [[f64; 2]; 3]) -> [[f64; 4]; 2] {
        let (sum, total) = (q[0] + q[1], a[0] + a[1]);
        let (sin, cos) = q[1].sin_cos();
        let across = LENGTH * (cos * (2.0 * a[0] + a[1]) - sin * (2.0 * v[0] + v[1]) * v[1]);
        let below = LENGTH * (cos * a[0] + sin * v[0] * v[0]);
        let heavy = 9.81 * sum.sin();
        [[a[0], total, across + heavy, 9.81 * q[0].sin()], [0.0, total, below + heavy, 0.0]]
    }

    fn state(batch: &Batch<'_>, i: usize) -> [[f64; 2]; 3] {
        [batch.q, batch.v, batch.a].map(|x| [x[2 * i], x[2 * i + 1]])
    }
}

impl BatchRegressor for Pendulum {
    fn nq(&self) -> usize {
        2
    }
    fn nv(&self) -> usize {
        2
    }
    fn pattern(&self) -> &[Vec<usize>] {
        &self.pattern
    }
    fn evaluate(&self, batch: &Batch<'_>, out: &mut [f64]) {
        for i in 0..batch.count {
            let rows = Self::rows(Self::state(batch, i));
            let entries = self.pattern.iter().zip(rows).flat_map(|(p, row)| p.iter().map(move |k| row[*k]));
            entries.enumerate().for_each(|(k, x)| out[k * batch.count + i] = x);
        }
    }
}

struct Torques;

impl InverseDynamics for Torques {
    fn nq(&self) -> usize {
        2
    }
    fn nv(&self) -> usize {
        2
    }
    fn torques(&mut self, batch: &Batch<'_>, tau: &mut [f64]) -> Result<(), EvaluationError> {
        for i in 0..batch.count {
            let rows = Pendulum::rows(Pendulum::state(batch, i));
            rows.iter().enumerate().for_each(|(k, row)| tau[2 * i + k] = machine::dot(row, &TRUTH));
        }
        Ok(())
    }
}

fn limits(effort: f64) -> [Limits; 2] {
    let of = |low, high| Limits { position: (low, high), velocity: 4.0, acceleration: 15.0, effort };
    [of(-1.0, 0.4), of(-0.2, 1.8)]
}

/// Does something with a machine of these limits.
fn with<T>(limits: &[Limits; 2], work: impl FnOnce(&Machine<'_>) -> T) -> T {
    let layout =
        JointLayout { joints: vec![Joint::revolute("hip"), Joint::revolute("knee")], base: BaseKind::Fixed };
    let (pendulum, mut torques) = (Pendulum::new(), Torques);
    let machine = Machine {
        layout: &layout,
        regressor: &pendulum,
        dynamics: RefCell::new(&mut torques),
        moving: &[0, 1],
        posture: &[0.0, 0.0],
        limits,
        clearance: None,
    };
    work(&machine)
}

fn request() -> Request {
    Request {
        family: Family::Fourier(4),
        duration: 6.0,
        margin: 0.05,
        criterion: Criterion::Condition,
        scaling: Scaling::Unit,
        seed: 1,
        starts: 2,
        evaluations: 60,
        time_limit: None,
    }
}

#[test]
fn gradients_are_those_of_the_cost() {
    with(&limits(8.0), |machine| {
        let basis = Basis::new(Family::Fourier(4), 6.0);
        let x: Vec<f64> = (0..machine.coefficients(&basis)).map(|k| 0.7 * (1.3 * k as f64).cos()).collect();
        let motion = machine.motion(&basis, &x, 40);
        let regression = Regression::new(machine, &mut pseudo(3));
        assert_eq!(regression.unknowns(), 4);
        type Cost<'a> = &'a dyn Fn(&Trajectory) -> (f64, Trajectory);
        let costs: [Cost<'_>; 4] = [
            &|m| regression.cost(m, Criterion::Condition, Scaling::Unit).unwrap(),
            &|m| regression.cost(m, Criterion::Condition, Scaling::Own).unwrap(),
            &|m| regression.cost(m, Criterion::Information, Scaling::Unit).unwrap(),
            &|m| excess(machine, m, 0.05).unwrap(),
        ];
        for (which, cost) in costs.iter().enumerate() {
            let (value, mut slopes) = cost(&motion);
            assert!(value != 0.0, "cost {which} tests nothing");
            for order in 0..3 {
                let scale = slopes.order_mut(order).iter().fold(0.0_f64, |m, x| m.max(x.abs()));
                for at in [3, 20, 41, 66] {
                    let moved = |h: f64| {
                        let mut other = motion.clone();
                        other.order_mut(order)[at] += h;
                        cost(&other).0
                    };
                    let expected = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                    let error = (slopes.order_mut(order)[at] - expected).abs();
                    assert!(
                        error < 1e-5 * scale.max(1e-3),
                        "cost {which} order {order} at {at}: {error} of {scale}"
                    );
                }
            }
        }
    });
}

fn pseudo(mut seed: u64) -> impl FnMut() -> f64 {
    move || {
        seed = seed.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (seed >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

#[test]
fn the_answer_is_better_and_keeps_its_limits() {
    let limits = limits(9.0);
    let (found, peaks) = with(&limits, |machine| {
        let found = design(machine, &request(), &|_| (), &|| false).unwrap();
        let motion = machine.motion(&found.basis, &found.coefficients, 10 * fine(&found.basis));
        (found, peaks(machine, &motion).unwrap())
    });
    assert!(found.after.condition_number < 0.7 * found.before.condition_number, "{found:?}");
    for (peaks, limits) in peaks.iter().zip(limits.map(|l| l.within(0.05))) {
        assert!(peaks.position.0 >= limits.position.0 && peaks.position.1 <= limits.position.1, "{peaks:?}");
        assert!(peaks.velocity <= limits.velocity && peaks.acceleration <= limits.acceleration, "{peaks:?}");
        assert!(peaks.effort <= limits.effort, "{peaks:?}");
    }
}

/// Of one start: no other one is missing then.
#[test]
fn an_early_end_is_told_with_its_reason() {
    let early = |time_limit: Option<Duration>, stop: bool| {
        let request = Request { starts: 1, evaluations: 20, time_limit, ..request() };
        with(&limits(9.0), |machine| design(machine, &request, &|_| (), &|| stop).unwrap().early)
    };
    let hour = Some(Duration::from_secs(3600));
    assert_eq!((early(None, false), early(hour, false)), (None, None));
    assert_eq!(early(Some(Duration::ZERO), false), Some(Early::OutOfTime));
    assert_eq!((early(None, true), early(hour, true)), (Some(Early::Interrupted), Some(Early::Interrupted)));
}

#[test]
#[ignore = "takes long"]
fn a_seed_always_gives_the_same_motion() {
    let of = |seed| {
        with(&limits(9.0), |m| {
            design(m, &Request { seed, ..request() }, &|_| (), &|| false).unwrap().coefficients
        })
    };
    assert_eq!(of(1), of(1));
    assert_ne!(of(1), of(2));
}

#[test]
fn joints_that_do_not_move_leave_fewer_unknowns() {
    let layout =
        JointLayout { joints: vec![Joint::revolute("hip"), Joint::revolute("knee")], base: BaseKind::Fixed };
    let (pendulum, mut torques, limits) = (Pendulum::new(), Torques, limits(9.0));
    // With the knee bent and stiff there are an inertia and two first moments; straight, two parameters.
    for (knee, unknowns) in [(0.7, 3), (0.0, 2)] {
        let machine = Machine {
            layout: &layout,
            regressor: &pendulum,
            dynamics: RefCell::new(&mut torques),
            moving: &[0],
            posture: &[0.0, knee],
            limits: &limits[..1],
            clearance: None,
        };
        assert_eq!(Regression::new(&machine, &mut pseudo(5)).unknowns(), unknowns);
    }
}

#[test]
fn impossible_wishes_are_told() {
    let fails = |limits: &[Limits; 2], request: &Request, words: &str| {
        let error =
            with(limits, |machine| design(machine, request, &|_| (), &|| false).unwrap_err().to_string());
        assert!(error.contains(words), "no `{words}` in {error}");
    };
    let mut bent = limits(0.4);
    bent[0].position = (0.5, 0.6);
    fails(&bent, &request(), "no motion keeps the limits");
    fails(&bent, &request(), "joint `hip` needs");
    let mut wrong = limits(9.0);
    wrong[1].position = (0.3, 0.3);
    fails(&wrong, &request(), "joint `knee`: position limits are 0.3 to 0.3");
    let mut wrong = limits(9.0);
    wrong[0].velocity = 0.0;
    fails(&wrong, &request(), "velocity limit is 0");
    fails(&limits(9.0), &Request { duration: f64::NAN, ..request() }, "duration is NaN");
    fails(&limits(9.0), &Request { family: Family::Fourier(1), ..request() }, "1 harmonics");
    fails(&limits(9.0), &Request { starts: 0, ..request() }, "0 starts");
}
