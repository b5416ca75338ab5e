//! Emitted code on several states side by side: in every lane the bits of a call with that lane's state alone, for every function.
#![cfg(test)]
#![deny(warnings)]

#[path = "../emitted/states.rs"]
#[expect(dead_code, reason = "other tests take more of it")]
mod states;

use bipedc_runtime::lanes::{F64x2, F64x4, F64x8};
use bipedc_runtime::{Argument, Model, Real, State};
use states::{Arguments, Random, functions};

/// Equal bits; which NaN it is does not matter.
fn same(a: f64, b: f64) -> bool {
    a.to_bits() == b.to_bits() || (a.is_nan() && b.is_nan())
}

/// Numbers put into lanes, and taken out of them.
type Lanes<L, const N: usize> = (fn([f64; N]) -> L, fn(L) -> [f64; N]);

/// Calls every function with a state of its own in each lane, and with each of them alone.
fn compare<M: Model<f64> + Model<L>, L: Real, const N: usize>(
    model: &M,
    (join, part): Lanes<L, N>,
    rounds: u64,
) {
    let known = functions::<f64>(model);
    assert_eq!(known, functions::<L>(model));
    assert!(!known.is_empty());
    for round in 1..=rounds {
        let mut random = Random(round * 0x9e37_79b9);
        let lanes: [_; N] = std::array::from_fn(|_| Arguments::<f64>::random(model, &mut random));
        let joined = Argument::ALL.map(|argument| {
            let element = |k: usize| join(std::array::from_fn(|lane| lanes[lane].state().get(argument)[k]));
            (0..lanes[0].state().get(argument).len()).map(element).collect::<Vec<L>>()
        });
        let state = Argument::ALL.iter().zip(&joined).fold(State::new(), |s, (&a, list)| s.with(a, list));
        for (k, (name, length)) in known.iter().enumerate() {
            let mut wide = vec![L::constant(0.0); *length];
            model.evaluate(k, &state, &mut wide).unwrap();
            let wide: Vec<[f64; N]> = wide.into_iter().map(part).collect();
            for (lane, alone) in lanes.iter().enumerate() {
                let mut expected = vec![f64::NAN; *length];
                model.evaluate(k, &alone.state(), &mut expected).unwrap();
                for (element, (wide, expected)) in wide.iter().zip(&expected).enumerate() {
                    assert!(
                        same(wide[lane], *expected),
                        "{name}[{element}], lane {lane} of {N}: {:e}, alone {expected:e} (round {round})",
                        wide[lane]
                    );
                }
            }
        }
    }
}

/// In lanes of two, four and eight.
fn all_widths<M>(model: &M, rounds: u64)
where
    M: Model<f64> + Model<F64x2> + Model<F64x4> + Model<F64x8>,
{
    compare(model, (F64x2::from_array, F64x2::to_array), rounds);
    compare(model, (F64x4::from_array, F64x4::to_array), rounds);
    compare(model, (F64x8::from_array, F64x8::to_array), rounds);
}

#[test]
fn planar_robots_have_the_bits_of_each_state_in_every_lane() {
    all_widths(&three_link::ThreeLink, 50);
    all_widths(&seven_link::SevenLink, 50);
}

#[cfg(all_robots)]
#[test]
fn every_robot_has_the_bits_of_each_state_in_every_lane() {
    all_widths(&five_link::FiveLink, 20);
    all_widths(&tulip_v1_leg::TulipV1Leg, 20);
    all_widths(&tulip::Tulip, 5);
    all_widths(&biped_3d::Biped3d, 5);
}
