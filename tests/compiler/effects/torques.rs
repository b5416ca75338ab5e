//! Laws at joints.
use super::support::*;
use bipedc_compiler::compile::ProgramModel;
use bipedc_compiler::description::model::RobotDescription;
use bipedc_effects::effect::{Effect, Location, kinds};
use bipedc_runtime::lanes::F64x4;
use bipedc_runtime::{Argument, Model};

const ROBOTS: [(&str, &str, &str); 3] = [
    ("three_link", "left_hip_pitch", "right_hip_pitch"),
    ("five_link", "left_knee_pitch", "left_hip_pitch"),
    ("tulip", "left_knee_pitch", "left_hip_pitch"),
];

#[test]
fn inverse_dynamics_is_the_rigid_one_and_the_formula() {
    for (robot, joint, other) in ROBOTS {
        let description = description(robot);
        let functions = ["inverse_dynamics", "inverse_dynamics_with_forces", "bias", "gravity"];
        let rigid = compiled(&description, &functions);
        let kinds = joint_effects(joint, other);
        let lists: Vec<Vec<Effect>> = kinds.iter().map(|e| vec![e.clone()]).chain([kinds.clone()]).collect();
        for effects in lists {
            let model = compiled(&with(&description, &effects), &functions);
            let mut random = Random(7);
            for _ in 0..5 {
                let values = Values::random(&model, &mut random);
                let still = Values { a: vec![0.0; values.a.len()], ..values.clone() };
                let rest = Values { v: vec![0.0; values.v.len()], ..still.clone() };
                for (name, at) in [
                    (functions[0], &values),
                    (functions[1], &values),
                    (functions[2], &still),
                    (functions[3], &rest),
                ] {
                    let expected = by_numbers(&model, &effects, at, &call(&rigid, name, at));
                    close(
                        &call(&model, name, at),
                        &expected,
                        1e-12,
                        &format!("{robot} {name} {}", effects[0]),
                    );
                }
            }
        }
    }
}

/// Effects drawn for a robot: up to two per joint, and couplings.
fn drawn(description: &RobotDescription, random: &mut Random, couplings: bool) -> Vec<Effect> {
    let joints: Vec<&str> =
        description.joints.iter().filter(|j| j.kind.moves()).map(|j| j.name.as_str()).collect();
    let mut effects = Vec::new();
    for joint in &joints {
        let other = joints[random.below(joints.len())];
        let mut kinds = joint_effects(joint, other);
        // Formulas that are nonlinear in the load have no way back.
        kinds.retain(|e| !e.torque.as_ref().is_some_and(|t| t.contains("cos(load") || t.contains("^-2")));
        kinds.retain(|e| couplings || (e.kind.name != "coupling" && e.kind.name != "formula"));
        kinds.retain(|e| e.location.other_joint.as_deref() != Some(joint));
        for _ in 0..2 {
            effects.push(kinds.swap_remove(random.below(kinds.len())));
        }
    }
    effects
}

#[test]
fn forward_dynamics_takes_inverse_dynamics_back() {
    let functions = [
        "inverse_dynamics",
        "forward_dynamics",
        "inverse_dynamics_with_forces",
        "forward_dynamics_with_forces",
    ];
    let mut random = Random(11);
    let (mut states, mut misses, mut worst) = (0, 0, 0.0f64);
    for (robot, rounds) in [("three_link", 40), ("five_link", 40), ("tulip", 4)] {
        let description = description(robot);
        for _ in 0..rounds {
            let effects = drawn(&description, &mut random, true);
            let model = compiled(&with(&description, &effects), &functions);
            for _ in 0..25 {
                let values = Values::random(&model, &mut random);
                for pair in functions.chunks(2) {
                    let tau = call(&model, pair[0], &values);
                    let a = call(&model, pair[1], &Values { tau, ..values.clone() });
                    let scale = values.a.iter().fold(1.0f64, |m, x| m.max(x.abs()));
                    let error =
                        a.iter().zip(&values.a).fold(0.0f64, |m, (x, y)| m.max((x - y).abs())) / scale;
                    states += 1;
                    misses += usize::from(error > 1e-8);
                    worst = worst.max(error);
                }
            }
        }
    }
    println!("{misses} of {states} states not taken back within 1e-8, worst {worst:e}");
    assert_eq!(misses, 0, "{misses} of {states}, worst {worst:e}");
}

#[test]
fn feed_forward_with_the_effect_gives_the_wanted_acceleration() {
    let description = description("five_link");
    let friction =
        Effect::new(&kinds::COULOMB_FRICTION, Location::joint("left_knee_pitch"), &[("torque", 0.43)]);
    let functions = ["inverse_dynamics", "forward_dynamics"];
    let rigid = compiled(&description, &functions);
    let truth = compiled(&with(&description, &[friction]), &functions);
    let values = Values::random(&truth, &mut Random(3));
    let accelerate = |controller| {
        call(
            &truth,
            "forward_dynamics",
            &Values { tau: call(controller, "inverse_dynamics", &values), ..values.clone() },
        )
    };
    close(&accelerate(&truth), &values.a, 1e-10, "with the effect");
    let knee = row(&truth, "left_knee_pitch");
    assert!((accelerate(&rigid)[knee] - values.a[knee]).abs() > 0.5, "without the effect");
}

#[test]
fn saturation_clips_both_ways() {
    let description = description("three_link");
    let limit = Effect::new(&kinds::TORQUE_SATURATION, Location::joint("left_hip_pitch"), &[("limit", 2.0)]);
    let functions = ["inverse_dynamics", "forward_dynamics"];
    let (rigid, model) =
        (compiled(&description, &functions), compiled(&with(&description, &[limit]), &functions));
    let hip = row(&model, "left_hip_pitch");
    let mut random = Random(5);
    for _ in 0..20 {
        let values = Values::random(&model, &mut random);
        let mut expected = call(&rigid, "inverse_dynamics", &values);
        expected[hip] = expected[hip].clamp(-2.0, 2.0);
        close(&call(&model, "inverse_dynamics", &values), &expected, 1e-13, "prediction");
        let mut clipped = values.clone();
        clipped.tau[hip] = clipped.tau[hip].clamp(-2.0, 2.0);
        let expected = call(&rigid, "forward_dynamics", &clipped);
        close(&call(&model, "forward_dynamics", &values), &expected, 1e-12, "motion");
    }
}

#[test]
fn mass_matrix_and_bias_make_up_the_torques() {
    for (robot, joint, other) in ROBOTS {
        let description = description(robot);
        // All but load-dependent friction and readings.
        let kinds = ["rotor_inertia", "coupling", "viscous_friction", "stribeck_friction"];
        let effects: Vec<Effect> =
            joint_effects(joint, other).into_iter().filter(|e| kinds.contains(&e.kind.name)).collect();
        let model = compiled(&with(&description, &effects), &["inverse_dynamics", "mass_matrix", "bias"]);
        let values = Values::random(&model, &mut Random(9));
        let (d, h) = (call(&model, "mass_matrix", &values), call(&model, "bias", &values));
        let n = h.len();
        let sum: Vec<f64> =
            (0..n).map(|r| h[r] + (0..n).map(|c| d[c * n + r] * values.a[c]).sum::<f64>()).collect();
        close(&sum, &call(&model, "inverse_dynamics", &values), 1e-12, robot);
    }
}

/// D (v⁺ − v⁻) = Jᵀ F with D as the effects make it; Jᵀ F from the rigid model's torques.
fn check_impact(rigid: &ProgramModel, model: &ProgramModel, values: &Values, robot: &str) {
    let answer = call(model, "impact_map", values);
    let nv = values.v.len();
    let (after, impulse) = answer.split_at(nv);
    let left = model.compiled().tree.points.iter().position(|p| p.name.starts_with("left")).unwrap();
    let mut forces = vec![0.0; values.forces.len()];
    let without =
        call(rigid, "inverse_dynamics_with_forces", &Values { forces: forces.clone(), ..values.clone() });
    (forces[3 * left], forces[3 * left + 2]) = (impulse[0], impulse[1]);
    let with = call(rigid, "inverse_dynamics_with_forces", &Values { forces, ..values.clone() });
    let d = call(model, "mass_matrix", values);
    let row = |r: usize| (0..nv).map(|c| d[c * nv + r] * (after[c] - values.v[c])).sum::<f64>();
    let driven: Vec<f64> = (0..nv).map(|r| without[r] - with[r]).collect();
    close(&(0..nv).map(row).collect::<Vec<_>>(), &driven, 1e-9, &format!("{robot} impact"));
}

#[test]
fn a_standing_foot_feels_the_effects() {
    let mut random = Random(13);
    for (robot, rounds) in [("three_link", 20), ("five_link", 20)] {
        let description = description(robot);
        let rigid = compiled(&description, &["inverse_dynamics_with_forces"]);
        for _ in 0..rounds {
            let effects = drawn(&description, &mut random, false);
            let functions =
                ["inverse_dynamics_with_forces", "constrained_dynamics", "impact_map", "mass_matrix"];
            let model = compiled(&with(&description, &effects), &functions);
            let values = Values::random(&model, &mut random);
            let answer = call(&model, "constrained_dynamics", &values);
            let nv = values.v.len();
            // Forces of the right foot in x and z; points in the order of the feet.
            let (a, lambda) = answer.split_at(nv);
            let points = Model::<f64>::argument_length(&model, Argument::Forces) / 3;
            let right =
                model.compiled().tree.points.iter().position(|p| p.name.starts_with("right")).unwrap();
            let mut forces = vec![0.0; 3 * points];
            (forces[3 * right], forces[3 * right + 2]) = (lambda[0], lambda[1]);
            check_impact(&rigid, &model, &values, robot);
            let moving = Values { a: a.to_vec(), forces, ..values.clone() };
            close(&call(&model, functions[0], &moving), &values.tau, 1e-8, &format!("{robot} {effects:?}"));
        }
    }
}

#[test]
fn lanes_and_floats_follow_the_doubles() {
    let description = description("five_link");
    let effects = drawn(&description, &mut Random(17), true);
    let model = compiled(&with(&description, &effects), &["inverse_dynamics", "forward_dynamics"]);
    let mut random = Random(19);
    let four: Vec<Values> = (0..4).map(|_| Values::random(&model, &mut random)).collect();
    let pack = |f: fn(&Values) -> &Vec<f64>| {
        (0..f(&four[0]).len()).map(|k| F64x4::from_array([0, 1, 2, 3].map(|i| f(&four[i])[k]))).collect()
    };
    let wide: Values<F64x4> = Values {
        q: pack(|v| &v.q),
        v: pack(|v| &v.v),
        a: pack(|v| &v.a),
        tau: pack(|v| &v.tau),
        forces: pack(|v| &v.forces),
    };
    for name in ["inverse_dynamics", "forward_dynamics"] {
        let lanes = call(&model, name, &wide);
        for (i, values) in four.iter().enumerate() {
            let narrow = call(&model, name, values);
            for (x, y) in lanes.iter().zip(&narrow) {
                assert_eq!(x.to_array()[i].to_bits(), y.to_bits(), "{name}");
            }
            let short = |list: &[f64]| list.iter().map(|&x| x as f32).collect::<Vec<_>>();
            let values: Values<f32> = Values {
                q: short(&values.q),
                v: short(&values.v),
                a: short(&values.a),
                tau: short(&values.tau),
                forces: short(&values.forces),
            };
            let floats: Vec<f64> = call(&model, name, &values).into_iter().map(f64::from).collect();
            close(&floats, &narrow, 2e-3, name);
        }
    }
}

#[test]
fn what_has_no_way_back_is_refused() {
    use bipedc_compiler::compile::{FunctionRequest, compile, requested_functions};
    let base = description("five_link");
    let refusal = |text: &str, function: &str| {
        let mut formula =
            Effect::new(&kinds::FORMULA, Location::pair("left_knee_pitch", "left_hip_pitch"), &[]);
        formula.torque = Some(text.to_owned());
        let description = with(&base, &[formula]);
        let tree = bipedc_compiler::tree::Tree::new(&description, &description.base).unwrap();
        let subject = (function == "constrained_dynamics").then(|| "single_support".to_owned());
        let request = FunctionRequest { family: function.to_owned(), subject };
        let answer = compile(&description, &tree, &[request]);
        // By default it is left out and the rest is there.
        if answer.is_err()
            && let Ok(all) = requested_functions(&description, &tree)
        {
            assert!(all.iter().all(|request| request.family != function) && all.len() > 20);
        }
        answer.err().map(|e| e.to_string()).unwrap_or_default()
    };
    assert!(refusal("acceleration^2", "forward_dynamics").contains("not linear in acceleration"));
    assert!(refusal("sin(load)", "forward_dynamics").contains("not linear in acceleration"));
    assert!(refusal("acceleration * abs(load)", "forward_dynamics_derivatives").contains("not linear"));
    assert!(refusal("-1.5 * load", "forward_dynamics").contains("more than the whole load"));
    assert!(refusal("0.1 * other_acceleration", "constrained_dynamics").contains("no longer symmetric"));
    assert!(refusal("position / (velocity - velocity)", "inverse_dynamics").contains("divides by zero"));
    assert!(refusal("exp(1000)", "inverse_dynamics").contains("overflows"));
    assert_eq!(refusal("acceleration^2", "inverse_dynamics"), "");
    assert_eq!(refusal("1e300 * 1e300 * (1e300 * position)", "inverse_dynamics"), "");
    assert_eq!(refusal("0.1 * other_acceleration", "forward_dynamics"), "");
}
