//! Programs as machine code against the interpreter: the same bits, for one state and for eight side by side.
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{CompiledModel, ProgramModel};
use bipedc_compiler::program::BatchColumns;
use bipedc_effects::random::Random;
use bipedc_runtime::lanes::F64x8;
use bipedc_runtime::{Argument, Model, Real, State};
use std::path::Path;

/// More calls than it takes until there is machine code.
const CALLS: usize = 400;

fn arguments(compiled: &CompiledModel, function: usize) -> Vec<(Argument, Vec<f64>)> {
    let arguments = compiled.functions[function].program.arguments();
    arguments.map(|argument| (argument, vec![0.0; compiled.argument_length(argument)])).collect()
}

/// Most of them ordinary; some without motion, some with what is no number, infinite or a negative zero.
fn fill(values: &mut [(Argument, Vec<f64>)], random: &mut Random, round: usize) {
    for x in values.iter_mut().flat_map(|(_, list)| list) {
        let ordinary = 1.3 * random.normal();
        let rare = random.normal().abs() > 2.0;
        *x = match round % 16 {
            12 => 0.0,
            13 if rare => f64::NAN,
            14 if rare => f64::INFINITY,
            15 if rare => -0.0,
            _ => ordinary,
        };
    }
}

fn state(values: &[(Argument, Vec<f64>)]) -> State<'_, f64> {
    values.iter().fold(State::new(), |state, (argument, list)| state.with(*argument, list))
}

/// Whether this machine runs machine code of ours.
fn here() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::is_x86_feature_detected!("avx");
    #[cfg(not(target_arch = "x86_64"))]
    return false;
}

fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || a.is_nan() && b.is_nan()
}

fn agrees(folder: &str) -> usize {
    let compiled = Robot::read(Path::new(folder)).unwrap().compile().unwrap();
    let model = ProgramModel::new(compiled.clone());
    let mut random = Random::new(7);
    for (index, function) in compiled.functions.iter().enumerate() {
        let evaluator = model.evaluator(index).unwrap();
        let mut values = arguments(&compiled, index);
        let mut workspace = evaluator.workspace();
        let [mut called, mut interpreted] = [vec![0.0; evaluator.outputs()], vec![0.0; evaluator.outputs()]];
        for round in 0..CALLS {
            fill(&mut values, &mut random, round);
            Model::<f64>::evaluate(&model, index, &state(&values), &mut called).unwrap();
            // Until then both are interpreted.
            if round < 290 {
                continue;
            }
            evaluator.run(&state(&values), &mut workspace, &mut interpreted);
            let apart = called.iter().zip(&interpreted).position(|(a, b)| !same(*a, *b));
            assert_eq!(apart, None, "{folder}, {}, call {round}", function.name);
        }
        assert_eq!(evaluator.is_machine_code(), here(), "{folder}, {}", function.name);
        assert_eq!(evaluator.machine_code_bytes() > 0, here(), "{folder}, {}", function.name);
    }
    compiled.functions.len()
}

#[test]
fn functions_of_planar_robots_have_the_interpreters_bits() {
    assert!(agrees("robots/three_link") > 50);
    // Both legs at once.
    assert!(agrees("robots/five_link") > 50);
    // Friction and other laws call functions.
    assert!(agrees("tests/data/effects/five_link") > 50);
}

#[test]
#[ignore = "takes long"]
fn functions_of_all_robots_have_the_interpreters_bits() {
    for folder in ["seven_link", "seven_link_v1", "biped_3d", "tulip", "tulip_v1_leg"] {
        assert!(agrees(&format!("robots/{folder}")) > 50);
    }
    for folder in ["lower12", "biped7", "rabbit5"] {
        assert!(agrees(&format!("benches/robots/{folder}")) > 20);
    }
    // Sliding joints, four legs, arms, many joints.
    for folder in ["arm", "gantry", "scara", "small_biped", "quadruped", "humanoid"] {
        assert!(agrees(&format!("examples/hidden_effects/robots/{folder}")) > 10);
    }
    assert!(agrees("tests/data/effects/tulip") > 0);
}

/// Lanes of eight, interpreted first, then as machine code.
#[test]
fn eight_states_have_the_bits_of_each() {
    let compiled = Robot::read(Path::new("robots/five_link")).unwrap().compile().unwrap();
    let model = ProgramModel::new(compiled.clone());
    let mut random = Random::new(13);
    for (index, function) in compiled.functions.iter().enumerate() {
        let evaluator = model.evaluator(index).unwrap();
        let (mut workspace, mut one) = (evaluator.workspace(), vec![0.0; evaluator.outputs()]);
        let mut eight = vec![F64x8::constant(0.0); evaluator.outputs()];
        for round in 0..110 {
            let lanes: [_; 8] = std::array::from_fn(|lane| {
                let mut values = arguments(&compiled, index);
                fill(&mut values, &mut random, round + lane);
                values
            });
            let wide: Vec<(Argument, Vec<F64x8>)> = (0..lanes[0].len())
                .map(|k| {
                    let element =
                        |i: usize| F64x8::from_array(std::array::from_fn(|lane| lanes[lane][k].1[i]));
                    (lanes[0][k].0, (0..lanes[0][k].1.len()).map(element).collect())
                })
                .collect();
            let state_of_eight =
                wide.iter().fold(State::new(), |state, (argument, list)| state.with(*argument, list));
            Model::<F64x8>::evaluate(&model, index, &state_of_eight, &mut eight).unwrap();
            for (lane, values) in lanes.iter().enumerate() {
                evaluator.run(&state(values), &mut workspace, &mut one);
                let apart = eight.iter().zip(&one).position(|(a, b)| !same(a.to_array()[lane], *b));
                assert_eq!(apart, None, "{}, call {round}, lane {lane}", function.name);
            }
        }
    }
}

#[test]
fn many_states_have_the_bits_of_each() {
    let compiled = Robot::read(Path::new("robots/tulip_v1_leg")).unwrap().compile().unwrap();
    let model = ProgramModel::new(compiled.clone());
    let index = Model::<f64>::function(&model, "inverse_dynamics_regressor").unwrap();
    let (program, nq, nv) =
        (&compiled.functions[index].program, Model::<f64>::nq(&model), Model::<f64>::nv(&model));
    let chosen: Vec<usize> = (0..program.outputs.len() / nv).step_by(3).collect();
    let columns = BatchColumns::new(program, (nq, nv), &chosen);
    // The last eight are not full; there are enough of them for machine code.
    let total = 1003;
    let mut random = Random::new(11);
    let [q, v, a] = [nq, nv, nv].map(|n| (0..total * n).map(|_| random.normal()).collect::<Vec<f64>>());
    let width: usize = columns.pattern().iter().map(Vec::len).sum();
    let mut out = vec![0.0; width * total];
    columns.evaluate(total, [&q, &v, &a], &mut out);
    let evaluator = model.evaluator(index).unwrap();
    let (mut workspace, mut all) = (evaluator.workspace(), vec![0.0; evaluator.outputs()]);
    for sample in 0..total {
        let part = |list: &[f64], n: usize| list[sample * n..][..n].to_vec();
        let values = [(Argument::Q, part(&q, nq)), (Argument::V, part(&v, nv)), (Argument::A, part(&a, nv))];
        evaluator.run(&state(&values), &mut workspace, &mut all);
        let wanted = columns.pattern().iter().enumerate();
        let wanted = wanted.flat_map(|(row, own)| own.iter().map(move |k| (row, *k)));
        for (place, (row, k)) in wanted.enumerate() {
            let (found, wanted) = (out[place * total + sample], all[chosen[k] * nv + row]);
            assert!(same(found, wanted), "sample {sample}, row {row}, column {k}: {found} {wanted}");
        }
    }
}
