//! Single precision and lanes.
use super::models::ThreeLink;
use super::states::{Arguments, Random, functions};
use bipedc_runtime::{Argument, Model, State};

#[test]
fn single_precision_is_close_to_double() {
    let mut random = Random(7);
    for _ in 0..50 {
        let single = Arguments::<f32>::random(&ThreeLink, &mut random);
        let widened: Vec<Vec<f64>> = Argument::ALL
            .iter()
            .map(|&a| single.state().get(a).iter().map(|&x| f64::from(x)).collect())
            .collect();
        let state = Argument::ALL.iter().zip(&widened).fold(State::new(), |s, (&a, x)| s.with(a, x));
        for (k, (name, length)) in functions::<f64>(&ThreeLink).iter().enumerate() {
            let (mut narrow, mut wide) = (vec![0.0f32; *length], vec![0.0f64; *length]);
            ThreeLink.evaluate(k, &single.state(), &mut narrow).unwrap();
            ThreeLink.evaluate(k, &state, &mut wide).unwrap();
            let largest = wide.iter().fold(0.0f64, |m, x| m.max(x.abs()));
            for (a, b) in narrow.iter().zip(&wide) {
                assert!((f64::from(*a) - b).abs() <= 1e-4 * largest, "{name}: {a} in f32, {b} in f64");
            }
        }
    }
}
