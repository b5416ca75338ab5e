//! The same programs on other scalars: `f32`, and lanes.
use super::generator::Random;
use super::subject::*;
use bipedc_runtime::lanes::{F32x4, F64x4};

const FAMILIES: [&str; 10] = [
    "inverse_dynamics",
    "mass_matrix",
    "coriolis_matrix",
    "bias",
    "kinetic_energy",
    "center_of_mass_jacobian",
    "centroidal_momentum",
    "ground_wrench",
    "inverse_dynamics_derivatives",
    "contact_normal_directions",
];

/// Single precision has 2⁻²⁴ = 6e-8 relative; sums of some hundred terms of mixed size lose one or two digits.
const SINGLE: f64 = 1e-5;
/// Solving with the mass matrix multiplies that by its condition: light links on long legs.
const SINGLE_SOLVED: f64 = 1e-3;

fn rounded(values: &Values<f64>) -> Values<f64> {
    Values(values.0.each_ref().map(|list| list.iter().map(|&x| f64::from(x as f32)).collect()))
}

#[test]
#[ignore = "takes long"]
fn single_precision_agrees_with_double() {
    let robots = subjects(&[&FAMILIES[..], &["forward_dynamics"]].concat());
    in_random_states(&robots, |robot, values| {
        // The same inputs for both: only the arithmetic differs.
        let values = rounded(values);
        let single = values.lifted::<f32>();
        let compare = |function: &str, tolerance: f64| {
            let low: Vec<f64> = robot.call(function, &single).into_iter().map(f64::from).collect();
            robot.close(function, &low, &robot.call(function, &values), tolerance);
        };
        FAMILIES.iter().for_each(|function| compare(function, SINGLE));
        compare("forward_dynamics", SINGLE_SOLVED);
    });
}

#[test]
#[ignore = "takes long"]
fn lanes_have_the_bits_of_scalars() {
    let robots = subjects(&[&FAMILIES[..], &["forward_dynamics", "zero_moment_point"]].concat());
    let mut random = Random(SEED);
    for robot in &robots {
        let states = [0; 4].map(|_| robot.state(&mut random));
        let lanes: Values<F64x4> = Values(std::array::from_fn(|argument| {
            let length = states[0].0[argument].len();
            (0..length).map(|k| F64x4::from_array([0, 1, 2, 3].map(|s| states[s].0[argument][k]))).collect()
        }));
        let singles = states.each_ref().map(Values::lifted::<f32>);
        let low: Values<F32x4> = Values(std::array::from_fn(|argument| {
            let length = singles[0].0[argument].len();
            (0..length).map(|k| F32x4::from_array([0, 1, 2, 3].map(|s| singles[s].0[argument][k]))).collect()
        }));
        for function in FAMILIES.into_iter().chain(["forward_dynamics", "zero_moment_point"]) {
            let together = robot.call(function, &lanes);
            let low_together = robot.call(function, &low);
            for lane in 0..4 {
                let bits = |x: &[f64]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                let own: Vec<f64> = together.iter().map(|x| x.to_array()[lane]).collect();
                let alone = robot.call(function, &states[lane]);
                assert_eq!(bits(&own), bits(&alone), "{}: {function}, lane {lane}", robot.name);
                let low_bits = |x: &[f32]| x.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
                let own: Vec<f32> = low_together.iter().map(|x| x.to_array()[lane]).collect();
                let alone = robot.call(function, &singles[lane]);
                assert_eq!(low_bits(&own), low_bits(&alone), "{}: {function}, f32", robot.name);
            }
        }
    }
}
