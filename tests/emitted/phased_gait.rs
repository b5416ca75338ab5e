//! Emitted gaits of several phases and their controller: the same bits as in process, no allocation.
use super::allocation::allocations;
use super::models::seven_link_walker;
use super::states::{Arguments, Random, functions};
use bipedc::gait::PhasedBench;
use bipedc::progress::Silent;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{PhasePrograms, ProgramModel};
use bipedc_runtime::control::{
    Controller, JointCommand, Observation, PhasedController, PhasedGait, held_contacts, phase_surface,
    surface_memory,
};
use bipedc_runtime::{Model, Scalar};
use seven_link_walker::gait_collocated::{ARGUMENTS, CollocatedGait as Seven};
use std::path::Path;

fn bench() -> PhasedBench {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots/seven_link_v1");
    let robot = Robot::read(&path).unwrap_or_else(|e| panic!("{e}"));
    PhasedBench::open(&robot, "collocated", &Silent).unwrap_or_else(|e| panic!("{e}"))
}

#[test]
fn functions_have_the_same_bits() {
    let known = ProgramModel::new(bench().compiled().model.clone());
    let names = functions::<f64>(&Seven);
    assert_eq!(names, functions::<f64>(&known));
    let mut random = Random(5);
    for _ in 0..40 {
        let arguments = Arguments::<f64>::random(&Seven, &mut random);
        for (k, (function, length)) in names.iter().enumerate() {
            let (mut ours, mut theirs) = (vec![f64::NAN; *length], vec![f64::INFINITY; *length]);
            Seven.evaluate(k, &arguments.state(), &mut ours).unwrap();
            known.evaluate(k, &arguments.state(), &mut theirs).unwrap();
            for (a, b) in ours.iter().zip(&theirs) {
                assert!(a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan(), "{function}: {a:e} {b:e}");
            }
        }
    }
}

#[test]
fn what_a_controller_knows_is_the_same() {
    let bench = bench();
    let known = PhasePrograms::new(bench.compiled(), &bench.gait).unwrap();
    assert_eq!(PhasedGait::<f64>::layout(&Seven), PhasedGait::<f64>::layout(&known));
    for k in 0..9 {
        assert_eq!(PhasedGait::<f64>::phase(&Seven, k), PhasedGait::<f64>::phase(&known, k));
        assert_eq!(PhasedGait::<f64>::parameter(&Seven, k), PhasedGait::<f64>::parameter(&known, k));
        assert_eq!(PhasedGait::<f64>::effort_limit(&Seven, k), PhasedGait::<f64>::effort_limit(&known, k));
    }
    assert!(PhasedGait::<f64>::phase(&Seven, 3).is_some() && PhasedGait::<f64>::phase(&Seven, 4).is_none());
}

/// Torques and what is said of them, in all phases at states around the beginning of a step.
fn torques<R: Scalar + Into<f64>, G: PhasedGait<R>>(gait: G) -> Vec<f64> {
    let start = [-0.2378, 0.6529, 0.1159, -0.2838, 0.0419, 0.1260, 0.0824, 0.6380, 0.5573];
    let mut controller = PhasedController::new(gait);
    let (mut random, mut found) = (Random(6), Vec::new());
    for round in 0..80 {
        let mut near = |x: f64, size: f64| R::constant(x + size * random.next());
        let q: Vec<R> = start.iter().map(|&x| near(x, 0.05)).collect();
        let v: Vec<R> = (0..9).map(|k| near(if k == 0 { 0.6 } else { 0.0 }, 0.3)).collect();
        let observed = Observation::new(R::constant(0.0), round % 4, &q, &v);
        let begun = controller.begin_phase(&observed);
        let mut commands = [JointCommand::Off; 6];
        let given = controller.command(&observed, &mut commands);
        assert_eq!(begun, given, "round {round}");
        let zero = R::constant(0.0);
        found.extend(commands.iter().map(|command| command.torque(zero, zero).into()));
        found.extend(controller.arguments().iter().map(|&x| x.into()));
        let status = controller.status();
        found.extend([status.phase, status.rate, status.error].map(Into::into));
        found.extend([status.limits, status.gave_way as usize, status.index].map(|x| x as f64));
    }
    found
}

#[test]
fn controllers_give_the_same_bits() {
    let bench = bench();
    let ours = torques::<f64, _>(Seven);
    let theirs = torques::<f64, _>(PhasePrograms::new(bench.compiled(), &bench.gait).unwrap());
    assert!(ours.iter().any(|x| x.abs() > 1.0));
    assert!(ours.iter().zip(&theirs).all(|(a, b)| a.to_bits() == b.to_bits()));
}

#[test]
fn commands_do_not_allocate() {
    let mut controller = PhasedController::<f64, _>::new(Seven);
    let q = [-0.2378, 0.6529, 0.1159, -0.2838, 0.0419, 0.1260, 0.0824, 0.6380, 0.5573];
    let v = [0.39, 0.0, 0.24, 0.27, 0.29, -0.81, 0.47, -1.46, 2.86];
    let mut commands = [JointCommand::Off; 6];
    let before = allocations();
    for (phase, factor) in [(0, 1.0), (1, 1.0), (2, 1.0), (3, 1.0), (0, 8.0)] {
        let v = v.map(|x| x * factor);
        let observed = Observation::new(0.0, phase, &q, &v);
        controller.begin_phase(&observed).unwrap();
        controller.command(&observed, &mut commands).unwrap();
    }
    assert!(controller.begin_phase(&Observation::new(0.0, 7, &q, &v)).is_err());
    // The surface of the first phase, at another φ than q's.
    let (mut held, mut memory) = ([0.0; 9], [0.0; surface_memory(9)]);
    controller.begin_phase(&Observation::new(0.0, 0, &q, &v)).unwrap();
    let mut arguments = [0.0; ARGUMENTS];
    arguments.copy_from_slice(controller.arguments());
    let count = held_contacts(&Seven, 0, (&q, &arguments), &mut held).unwrap();
    arguments[0] += 0.01;
    let point = phase_surface(&Seven, 0, (&arguments, &held[..count]), &q, &mut memory).unwrap();
    assert!((point.q[0] - q[0] - 0.01).abs() < 1e-9 && (point.slope[0] - 1.0).abs() < 1e-9, "{point:?}");
    assert_eq!(allocations(), before);
}
