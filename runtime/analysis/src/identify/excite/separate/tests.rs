//! On one link that turns about y: τ = I_yy a − g (m x cos q + m z sin q).
use super::objective::Apart;
use super::*;
use crate::identify::BatchRegressor;
use crate::identify::excite::search::Objective;
use crate::identify::excite::{Criterion, Family, Limits, Scaling};
use crate::robot::link_inertias::Link;
use crate::robot::{BaseKind, Batch, Joint, ModelTorques};
use bipedc_effects::effect::Location;
use bipedc_runtime::model::{Argument, Arguments, CallError, Signature, State};
use std::cell::RefCell;

const GRAVITY: f64 = 9.81;
/// m x, m z, I_yy.
const TRUTH: [f64; 3] = [0.1, -0.8, 0.3];

struct OneLink;

impl OneLink {
    fn regressor(q: f64, a: f64) -> [f64; 10] {
        let (sin, cos) = q.sin_cos();
        [0.0, -GRAVITY * cos, 0.0, -GRAVITY * sin, 0.0, 0.0, 0.0, a, 0.0, 0.0]
    }
}

impl Model<f64> for OneLink {
    fn nq(&self) -> usize {
        1
    }
    fn nv(&self) -> usize {
        1
    }
    fn joint_name(&self, _: usize) -> Option<&str> {
        Some("hinge")
    }
    fn joints(&self) -> usize {
        1
    }
    fn signature(&self, index: usize) -> Option<Signature<'_>> {
        let name = ["inverse_dynamics", "inverse_dynamics_regressor"].get(index)?;
        let arguments = Arguments::of(&[Argument::Q, Argument::V, Argument::A]);
        Some(Signature { name, arguments, rows: 1, columns: [1, 10][index] })
    }
    fn argument_length(&self, argument: Argument) -> usize {
        usize::from(matches!(argument, Argument::Q | Argument::V | Argument::A))
    }
    fn evaluate(&self, function: usize, state: &State<'_, f64>, output: &mut [f64]) -> Result<(), CallError> {
        let row = Self::regressor(state.get(Argument::Q)[0], state.get(Argument::A)[0]);
        match function {
            0 => output[0] = row[1] * TRUTH[0] + row[3] * TRUTH[1] + row[7] * TRUTH[2],
            _ => output.copy_from_slice(&row),
        }
        Ok(())
    }
}

/// Not asked by this design.
struct NoRegressor;

impl BatchRegressor for NoRegressor {
    fn nq(&self) -> usize {
        1
    }
    fn nv(&self) -> usize {
        1
    }
    fn pattern(&self) -> &[Vec<usize>] {
        &[]
    }
    fn evaluate(&self, _: &Batch<'_>, _: &mut [f64]) {}
}

fn request() -> Request {
    Request {
        family: Family::Fourier(4),
        duration: 6.0,
        margin: 0.05,
        criterion: Criterion::Condition,
        scaling: Scaling::Unit,
        seed: 3,
        starts: 2,
        evaluations: 40,
        time_limit: None,
    }
}

fn of(kind: &str) -> Candidate {
    let location = match bipedc_effects::effect::kind(kind).unwrap().place {
        bipedc_effects::effect::Place::Link => Location::link("arm"),
        _ => Location::joint("hinge"),
    };
    Candidate::new(kind, location).unwrap()
}

fn with<T>(kinds: [&str; 2], beside_bodies: bool, work: impl FnOnce(&Machine<'_>, &Pair<'_>) -> T) -> T {
    let layout = JointLayout { joints: vec![Joint::revolute("hinge")], base: BaseKind::Fixed };
    let one = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let inertia = one.map(|row| row.map(|x| 0.1 * x));
    let arm = Link {
        name: "arm".to_owned(),
        body: 0,
        rotation: one,
        translation: [0.0; 3],
        mass: 2.0,
        center: [0.05, 0.0, -0.4],
        inertia,
    };
    let link_inertias = LinkInertias { links: vec![arm], bodies: vec!["arm".to_owned()] };
    let mut torques = ModelTorques::new(&OneLink).unwrap();
    let limits = [Limits { position: (-1.2, 0.9), velocity: 5.0, acceleration: 20.0, effort: 15.0 }];
    let machine = Machine {
        layout: &layout,
        regressor: &NoRegressor,
        dynamics: RefCell::new(&mut torques),
        moving: &[0],
        posture: &[0.0],
        limits: &limits,
        clearance: None,
    };
    let effects = kinds.map(of);
    let pair = Pair {
        model: &OneLink,
        layout: &layout,
        link_inertias: &link_inertias,
        present: &[],
        measured: &[0],
        effects,
        beside_bodies,
        noise: 0.2,
    };
    work(&machine, &pair)
}

fn designed(kinds: [&str; 2], beside_bodies: bool) -> Result<Separating, String> {
    with(kinds, beside_bodies, |machine, pair| {
        separate(machine, pair, &request(), &|_| (), &|| false).map_err(|e| e.to_string())
    })
}

#[test]
fn gradients_are_those_of_the_cost() {
    let pairs = [
        (["rotor_inertia", "parallel_spring"], false),
        (["viscous_friction", "actuator_delay"], false),
        (["stribeck_friction", "asymmetric_coulomb_friction"], false),
        (["torque_gain", "payload"], false),
        (["parallel_spring", "viscous_friction"], true),
    ];
    for (kinds, beside) in pairs {
        with(kinds, beside, |machine, pair| {
            let bench = Bench::new(machine, pair, 6.0);
            let reduced = reduced(&bench, &request()).unwrap();
            let apart = Apart::new(bench, reduced);
            // In motion at both ends: at rest |sign v| has a kink.
            let basis = Basis::new(Family::Polynomial(6), 6.0);
            let x: Vec<f64> = (0..basis.len()).map(|k| 0.5 * (1.3 * k as f64).cos()).collect();
            let motion = machine.motion(&basis, &x, 21);
            let (_, mut slopes) = apart.cost(&motion).unwrap().unwrap();
            for order in 0..3 {
                // A largest slope of zero has none of its own: such orders play no part in these two.
                let scale = slopes.order_mut(order).iter().fold(1e-6_f64, |m, x| m.max(x.abs()));
                for at in 0..21 {
                    let moved = |h: f64| {
                        let mut other = motion.clone();
                        other.order_mut(order)[at] += h;
                        apart.cost(&other).unwrap().unwrap().0
                    };
                    let expected = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                    let error = (slopes.order_mut(order)[at] - expected).abs();
                    assert!(error < 1e-4 * scale, "{kinds:?} order {order} at {at}: {error} of {scale}");
                }
            }
        });
    }
}

#[test]
fn what_no_motion_can_tell_is_said() {
    let fails = |kinds: [&str; 2], beside: bool, words: &str| {
        let error = designed(kinds, beside).unwrap_err();
        assert!(error.contains(words), "no `{words}` in {error}");
    };
    fails(["rotor_inertia", "inertia_error"], false, "the two change torques in the same 1 way");
    fails(["parallel_spring", "torque_bias"], false, "whatever Bias of the torque signal");
    fails(["coulomb_friction", "stribeck_friction"], false, "whatever Coulomb friction at hinge does");
    fails(["rotor_inertia", "viscous_friction"], true, "bodies' inertial parameters could not");
    fails(["viscous_friction", "viscous_friction"], false, "the same effect twice");
    let held = with(["viscous_friction", "torque_bias"], false, |machine, pair| {
        let elsewhere = Candidate::new("viscous_friction", Location::joint("elbow")).unwrap();
        let pair = Pair { effects: [elsewhere, pair.effects[1].clone()], ..*pair };
        separate(machine, &pair, &request(), &|_| (), &|| false).unwrap_err().to_string()
    });
    assert!(held.contains("changes no measured torque"), "{held}");
}

#[test]
fn what_is_common_does_not_count() {
    let found = designed(["stribeck_friction", "asymmetric_coulomb_friction"], false).unwrap();
    assert_eq!((found.columns, found.common), ([2, 2], 1));
    assert!(found.after.correlation < 0.99, "{found:?}");
    // A shift changes the first moments as a payload does, and the second ones in proportion to one of them: the shift
    // across the arm is common, the one along it shows where the link is accelerated.
    let found = designed(["com_offset", "payload"], false).unwrap();
    assert_eq!((found.columns, found.common), ([2, 2], 1));
}

#[test]
#[ignore = "takes long"]
fn the_answer_tells_the_two_further_apart() {
    for (kinds, beside) in [
        (["rotor_inertia", "parallel_spring"], false),
        (["coulomb_friction", "viscous_friction"], false),
        (["parallel_spring", "payload"], false),
        (["coulomb_friction", "viscous_friction"], true),
    ] {
        let found = designed(kinds, beside).unwrap();
        println!("{kinds:?} {beside}: {:?} {:?}", found.before, found.after);
        assert!(found.after.cost < found.before.cost && found.after.angle > found.before.angle, "{kinds:?}");
        let (sine, rests) = (found.after.angle.sin(), found.after.rests);
        for (rest, size) in rests.iter().zip(found.after.sizes) {
            assert!(*rest <= size * 1.000_001 && (beside || *rest >= 0.999 * sine * size), "{found:?}");
        }
    }
}

#[test]
fn kinds_without_a_meaning_here_are_refused() {
    for (kind, location, words) in [
        ("ground_compliance", Location::default(), "only in contact with the ground"),
        ("force_sensor_gain", Location::sensor("foot"), "only in contact with the ground"),
        ("backlash", Location::joint("hinge"), "motor's angle"),
        ("torque_saturation", Location::joint("hinge"), "begins at a limit"),
        ("point_feet", Location::default(), "about walking"),
        ("formula", Location::joint("hinge"), "no columns"),
        ("payload", Location::joint("hinge"), "`payload` needs a link"),
        ("coupling", Location::joint("hinge"), "two different joints"),
        ("coupling", Location::pair("hinge", "hinge"), "two different joints"),
        ("viscous_friction", Location::default(), "needs a joint"),
        ("elasticness", Location::default(), "no effect `elasticness`"),
    ] {
        let error = Candidate::new(kind, location).unwrap_err().to_string();
        assert!(error.contains(words), "no `{words}` in {error}");
    }
}
