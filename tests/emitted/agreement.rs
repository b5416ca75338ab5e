//! Emitted code and the evaluator agree to the last bit.
use super::models::{
    FiveLinkWithEffects, SplitThreeLink, SplitTulip, ThreeLink, Tulip, TulipLegByLeg, TulipWithEffects,
};
use super::states::{Arguments, Random, functions};
use bipedc_compiler::Robot;
use bipedc_compiler::compile::ProgramModel;
use bipedc_runtime::Model;
use std::path::Path;

const SEED: u64 = 0x0b1b_ed0c;

fn in_process(name: &str) -> ProgramModel {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name);
    let robot = Robot::read(&path).unwrap_or_else(|e| panic!("{e}"));
    ProgramModel::new(robot.compile().unwrap_or_else(|e| panic!("{e}")))
}

/// Equal bits; which NaN it is does not matter.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

fn compare(emitted: &impl Model<f64>, name: &str, states: usize) {
    let evaluated = in_process(name);
    let names = functions(emitted);
    let mut random = Random(SEED);
    for _ in 0..states {
        let arguments = Arguments::<f64>::random(emitted, &mut random);
        for (k, (function, length)) in names.iter().enumerate() {
            let known = Model::<f64>::function(&evaluated, function).unwrap_or_else(|| panic!("{function}"));
            let (mut ours, mut theirs) = (vec![f64::NAN; *length], vec![f64::INFINITY; *length]);
            emitted.evaluate(k, &arguments.state(), &mut ours).unwrap();
            evaluated.evaluate(known, &arguments.state(), &mut theirs).unwrap();
            for (element, (&a, &b)) in ours.iter().zip(&theirs).enumerate() {
                assert!(
                    same(a, b),
                    "{name} {function}[{element}]: {a:e} emitted, {b:e} evaluated (seed {SEED:#x})"
                );
            }
        }
    }
}

#[test]
fn three_link_has_the_same_bits() {
    compare(&ThreeLink, "three_link", 200);
}

#[test]
fn tulip_has_the_same_bits() {
    compare(&Tulip, "tulip", 20);
}

#[test]
fn effects_have_the_same_bits() {
    compare(&FiveLinkWithEffects, "../tests/data/effects/five_link", 100);
    compare(&TulipWithEffects, "../tests/data/effects/tulip", 20);
}

#[test]
fn split_programs_have_the_same_bits() {
    compare(&SplitThreeLink, "three_link", 50);
    compare(&SplitTulip, "tulip", 10);
}

/// Both are those of the evaluator.
#[test]
fn one_leg_after_the_other_has_the_bits_of_both_at_once() {
    compare(&TulipLegByLeg, "tulip", 10);
}

#[test]
fn every_function_is_emitted() {
    let evaluated = in_process("three_link");
    assert_eq!(functions::<f64>(&ThreeLink), functions::<f64>(&evaluated));
    assert_eq!(functions::<f64>(&SplitThreeLink), functions::<f64>(&evaluated));
}

#[test]
fn the_faces_agree() {
    use super::models::three_link;
    use bipedc_runtime::nalgebra::{SMatrix, SVector};
    let q = SVector::<f64, { three_link::NQ }>::from_fn(|k, _| 0.3 * k as f64 - 0.7);
    let by_value = three_link::mass_matrix(&q);
    // What stood there before must not matter.
    let mut in_place = SMatrix::from_element(f64::NAN);
    three_link::mass_matrix_into(&q, &mut in_place);
    assert_eq!(by_value, in_place);
}

/// Entries of packed matrices are those of the dense ones, and all others are 0.
#[test]
fn nonzeros_stand_where_the_pattern_says() {
    use bipedc_runtime::nalgebra::SVector;
    macro_rules! check {
        ($robot:ident::$dense:ident, $nonzeros:ident, $into:ident, $pattern:ident) => {{
            let mut random = Random(SEED);
            let q = SVector::from_fn(|_, _| random.next());
            let (v, a) = (SVector::from_fn(|_, _| random.next()), SVector::from_fn(|_, _| random.next()));
            let (mut dense, entries) = ($robot::$dense(&q, &v, &a), $robot::$nonzeros(&q, &v, &a));
            let mut in_place = entries.map(|_| f64::NAN);
            $robot::$into(&q, &v, &a, &mut in_place);
            assert_eq!(entries, in_place);
            assert_eq!(dense.shape(), ($robot::$pattern.rows, $robot::$pattern.columns));
            assert_eq!(entries.len(), $robot::$pattern.places().count());
            for (place, entry) in $robot::$pattern.places().zip(&entries) {
                let found: f64 = std::mem::replace(&mut dense[place], 0.0);
                assert!(same(found, *entry), "{} {place:?}", stringify!($dense));
            }
            assert!(dense.iter().all(|x| x.to_bits() == 0));
        }};
        ($robot:ident) => {
            check!(
                $robot::inverse_dynamics_regressor,
                inverse_dynamics_regressor_nonzeros,
                inverse_dynamics_regressor_nonzeros_into,
                INVERSE_DYNAMICS_REGRESSOR_SPARSITY
            );
            check!(
                $robot::ground_wrench_regressor,
                ground_wrench_regressor_nonzeros,
                ground_wrench_regressor_nonzeros_into,
                GROUND_WRENCH_REGRESSOR_SPARSITY
            );
        };
    }
    use super::models::three_link;
    check!(three_link);
    check!(tulip);
}
