//! Operation counts of the peers' robots, pinned: a measure of speed without noise.
//!
//! Addition, subtraction, multiplication, division and square root count 1, a fused multiply-add 2, negation
//! and sine or cosine 0. Shared subexpressions count once.
use crate::compiled::support;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::FunctionRequest;
use std::fmt::Write as _;

const FUNCTIONS: [&str; 12] = [
    "inverse_dynamics",
    "mass_matrix",
    "bias",
    "gravity",
    "forward_dynamics",
    "coriolis_matrix",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
    "center_of_mass_with_jacobian",
    "centroidal_momentum",
    "zero_moment_point",
    "inverse_dynamics_regressor",
];

/// Present counts in the order of [`FUNCTIONS`].
const PINNED: [(&str, [usize; 12]); 3] = [
    ("lower12", [1346, 764, 1293, 266, 2900, 2891, 6491, 20165, 417, 970, 1425, 2678]),
    ("rabbit5", [121, 46, 73, 29, 209, 59, 245, 805, 24, 87, 127, 140]),
    ("biped7", [193, 90, 123, 55, 359, 125, 453, 1590, 38, 143, 199, 246]),
];

/// What this compiler promises, whatever is pinned: (robot, function, at most).
const PROMISED: [(&str, &str, usize); 4] = [
    ("lower12", "inverse_dynamics", 1432),
    ("lower12", "mass_matrix", 900),
    ("rabbit5", "inverse_dynamics", 121),
    ("rabbit5", "mass_matrix", 71),
];

fn counts(name: &str) -> [usize; 12] {
    let robot = Robot::read(&support::project().join("benches/robots").join(name)).unwrap();
    let requests = FUNCTIONS.map(FunctionRequest::of_robot);
    let model = robot.compile_only(&requests).unwrap_or_else(|e| panic!("{name}: {e}"));
    std::array::from_fn(|k| model.functions[k].operations.total())
}

#[test]
fn operation_counts_are_as_pinned_and_promised() {
    let (mut differences, mut table) = (String::new(), String::new());
    for (name, pinned) in PINNED {
        let now = counts(name);
        let _ = writeln!(table, "    (\"{name}\", {now:?}),");
        for ((function, now), pinned) in FUNCTIONS.into_iter().zip(now).zip(pinned) {
            if now != pinned {
                let verdict = if now < pinned { "better" } else { "WORSE" };
                let _ =
                    writeln!(differences, "{name} {function}: {now} operations, pinned {pinned}: {verdict}");
            }
            for (_, _, most) in PROMISED.iter().filter(|p| (p.0, p.1) == (name, function)) {
                assert!(now <= *most, "{name} {function}: {now} operations, promised at most {most}");
            }
        }
    }
    assert!(
        differences.is_empty(),
        "operation counts have changed:\n{differences}\
         If that is meant, replace the rows of PINNED in {} by\n{table}",
        file!(),
    );
}

/// Operations of a robot on one foot: (robot, function, phase, today's).
const ON_ONE_FOOT: [(&str, &str, &str, usize); 8] = [
    ("lower12", "constrained_dynamics", "right_support", 4373),
    ("lower12", "constrained_dynamics", "right_point", 3838),
    ("lower12", "impact_map", "right_support", 2969),
    ("lower12", "impact_map", "right_point", 3158),
    ("rabbit5", "constrained_dynamics", "right_support", 226),
    ("rabbit5", "impact_map", "right_support", 182),
    ("biped7", "constrained_dynamics", "right_heel", 438),
    ("biped7", "impact_map", "right_heel", 370),
];

/// With the foot's rows beside those of the base: 4373, 4756, 2971, 3158, 448, 312, 722 and 507.
#[test]
fn operations_on_one_foot_are_as_pinned() {
    for (name, family, phase, pinned) in ON_ONE_FOOT {
        let robot = Robot::read(&support::project().join("benches/robots").join(name)).unwrap();
        let request = FunctionRequest { family: family.to_owned(), subject: Some(phase.to_owned()) };
        let model = robot.compile_only(&[request]).unwrap_or_else(|e| panic!("{name}: {e}"));
        let now = model.functions[0].operations.total();
        assert_eq!(now, pinned, "{name} {family} of {phase}");
    }
}
