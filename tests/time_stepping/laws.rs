//! Energy, momentum and order of convergence of whole robots.
use super::humanoid::{Case, Humanoid, STANDING};
use bipedc_analysis::robot::BaseKind;
use bipedc_analysis::simulate::{Ground, JointLaw, Mechanics, MotionState, Stepper, Tolerance};

/// Energy of TUlip, J.
pub fn energy(mechanics: &Mechanics<'_>, motion: &MotionState) -> f64 {
    let of = |name: &str| mechanics.named(name, &motion.q, &motion.v).unwrap()[0];
    of("kinetic_energy") + of("potential_energy")
}

/// In the air, all joints moving.
fn flying(step: f64, time: f64) -> (MotionState, f64) {
    let mechanics = Mechanics::new(&tulip::Tulip, BaseKind::Floating).unwrap();
    let mut stepper =
        Stepper::new(mechanics, Ground::default(), vec![JointLaw::default(); 12], Tolerance::default())
            .unwrap();
    let mut motion = MotionState { time: 0.0, q: vec![0.0; 19], v: vec![0.0; 18] };
    (motion.q[2], motion.q[6]) = (10.0, 1.0);
    for (i, v) in motion.v.iter_mut().enumerate() {
        *v = (2.7 * i as f64).sin();
    }
    let before = energy(&mechanics, &motion);
    for _ in 0..(time / step).round() as usize {
        stepper.step(&mut motion, &[0.0; 18], step).unwrap();
    }
    let change = energy(&mechanics, &motion) - before;
    (motion, change)
}

#[test]
fn without_contact_energy_is_kept_to_second_order() {
    let (best, _) = flying(3.125e-5, 0.25);
    let mut errors = Vec::new();
    let mut changes = Vec::new();
    for step in [2e-3, 1e-3, 5e-4] {
        let (motion, change) = flying(step, 0.25);
        let apart = motion.q.iter().zip(&best.q).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
        errors.push(apart);
        changes.push(change.abs());
    }
    let orders: Vec<f64> = errors.windows(2).map(|e| f64::log2(e[0] / e[1])).collect();
    println!("errors {errors:?}, orders {orders:.3?}, changes of energy {changes:?} J");
    assert!(orders.iter().all(|order| (order - 2.0).abs() < 0.15), "{orders:?}");
    assert!(changes[2] < 0.3 * changes[1] && changes[2] < 1e-2, "{changes:?}");
}

#[test]
#[ignore = "takes long"]
fn landing_converges_with_the_step() {
    // Impacts make it first order; the finest run is the measure.
    let landed = |step: f64| {
        let mut robot = Humanoid::new(Case { clearance: 0.02, ..STANDING }, 1e-9);
        for _ in 0..(0.2 / step).round() as usize {
            robot.step(step);
        }
        robot.center_of_mass()[2]
    };
    let best = landed(2.5e-5);
    let errors: Vec<f64> = [8e-4, 4e-4, 2e-4].iter().map(|step| (landed(*step) - best).abs()).collect();
    println!("errors of the height {errors:?} m");
    assert!(errors[2] < 1e-4 && errors[2] < 0.5 * errors[0], "{errors:?}");
}

#[test]
fn planar_robots_land_too() {
    let model = seven_link::SevenLink;
    let mechanics = Mechanics::new(&model, BaseKind::Planar).unwrap();
    let law = JointLaw { damping: 3.0, ..JointLaw::default() };
    let mut stepper = Stepper::new(mechanics, Ground::default(), vec![law; 6], Tolerance::default()).unwrap();
    let (nq, nv) = (mechanics.nq(), mechanics.nv());
    let mut motion = MotionState { time: 0.0, q: vec![0.0; nq], v: vec![0.0; nv] };
    let mut gaps = vec![0.0; mechanics.points()];
    mechanics.distances(&motion.q, &mut gaps);
    motion.q[1] = 0.05 - gaps[0];
    for _ in 0..1000 {
        let mut force = vec![0.0; nv];
        for j in 0..6 {
            force[3 + j] = -400.0 * motion.q[3 + j];
        }
        let stepped = stepper.step(&mut motion, &force, 1e-3).unwrap();
        assert!(stepped.solved.residual <= 1e-8, "{stepped:?}");
    }
    mechanics.distances(&motion.q, &mut gaps);
    assert!(gaps.iter().all(|gap| gap.abs() < 2e-3), "{gaps:?}");
    assert!(motion.v.iter().all(|v| v.abs() < 0.05), "{:?}", motion.v);
}
