//! Derivatives with effects, against dual numbers through the functions themselves.
use super::support::*;
use bipedc_compiler::program::Dual;
use bipedc_effects::effect::{Effect, Location, kinds};

fn moving(values: &Values, argument: usize, k: usize) -> Values<Dual> {
    let lists = [&values.q, &values.v, &values.a, &values.tau, &values.forces];
    let [q, v, a, tau, forces] = [0, 1, 2, 3, 4].map(|i| {
        let rate = |j| if i == argument && j == k { 1.0 } else { 0.0 };
        lists[i].iter().enumerate().map(|(j, &x)| Dual(x, rate(j))).collect()
    });
    Values { q, v, a, tau, forces }
}

fn check(robot: &str, effects: &[Effect]) {
    let functions = [
        "inverse_dynamics",
        "forward_dynamics",
        "inverse_dynamics_derivatives",
        "forward_dynamics_derivatives",
    ];
    let model = compiled(&with(&description(robot), effects), &functions);
    let mut random = Random(29);
    for _ in 0..5 {
        let values = Values::random(&model, &mut random);
        let (nq, nv) = (values.q.len(), values.v.len());
        for (function, derivatives, last) in
            [(functions[0], functions[2], 2), (functions[1], functions[3], 3)]
        {
            let all = call(&model, derivatives, &values);
            for (block, argument) in [0, 1, last].into_iter().enumerate() {
                // The base's tangent space is the rigid model's affair and tested there.
                for k in if nq > nv { 6 } else { 0 }..nv {
                    let element = if argument == 0 { k + nq - nv } else { k };
                    let expected: Vec<f64> = call(&model, function, &moving(&values, argument, element))
                        .iter()
                        .map(|x| x.1)
                        .collect();
                    let column = &all[(block * nv + k) * nv..][..nv];
                    close(
                        column,
                        &expected,
                        1e-9,
                        &format!("{robot} {derivatives} {argument} {k} {}", effects[0]),
                    );
                }
            }
        }
    }
}

#[test]
fn derivatives_follow_the_functions() {
    for (robot, joint, other) in
        [("five_link", "left_knee_pitch", "left_hip_pitch"), ("tulip", "left_knee_pitch", "left_hip_pitch")]
    {
        let mut kinds = joint_effects(joint, other);
        kinds.retain(|e| !e.torque.as_ref().is_some_and(|t| t.contains("cos(load") || t.contains("^-2")));
        // Smooth enough for slopes at random speeds.
        kinds.push(Effect::new(&kinds::TORQUE_SATURATION, Location::joint(joint), &[("limit", 8.0)]));
        if robot == "five_link" {
            kinds.iter().for_each(|effect| check(robot, std::slice::from_ref(effect)));
        }
        kinds.retain(|e| e.kind.name != "torque_saturation");
        check(robot, &kinds);
    }
}
