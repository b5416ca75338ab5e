//! Every mistake in a gait file is named with its place and what to do.
use super::{bent, gait, robot};
use crate::cli::bipedc;
use bipedc::gait::{GaitBench, StepOptions};
use bipedc::progress::Silent;
use std::path::Path;

/// The shipped gait with something replaced.
pub(super) fn changed(folder: &str, from: &str, to: &str) -> String {
    let path = format!("{}/{folder}/gaits/thesis.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    assert!(text.contains(from), "no `{from}` in the gait");
    text.replacen(from, to, 1)
}

pub(super) fn open(name: &str, text: &str) -> Result<GaitBench, bipedc::Diagnostics> {
    GaitBench::parse(&robot("robots/three_link"), Path::new(&format!("{name}.toml")), text, &Silent)
}

const MISTAKES: [(&str, &str, &str, &str); 38] = [
    ("gravity = 9.8", "gravity = -9.8", ":3:11", "a number above 0"),
    ("gravity = 9.8", "gravty = 9.8", ":3:1", "did you mean `gravity`?"),
    ("gravity = 9.8", "gravity = ", "", "broken TOML"),
    ("unit = \"m\"", "unit = \"deg\"", ":6:8", "SI units"),
    ("unit = \"m\"", "unit = \"deg\"", ":6:8", "1 degree is 0.0174533 rad"),
    ("[parameters.step_length]", "[parameters.sqrt]", ":5", "a word of formulas"),
    ("unit = \"m\"", "", ":5:1", "has no `unit`"),
    ("default = 0.5", "default = 1.5", ":8:11", "lies outside its bounds"),
    ("default = 0.5", "", ":5:1", "has no `default`"),
    ("bounds = [0.2, 1.0]", "bounds = [1.0, 0.2]", ":9:10", "smaller number first"),
    ("bounds = [0.2, 1.0]", "bounds = [0.2]", ":9:10", "expected two numbers"),
    ("bounds = [0.2, 1.0]", "bounds = [0.2, 1e400]", ":9", "finite"),
    ("[parameters.step_length]", "[parameters.left_hip_pitch]", ":5", "means something else already"),
    ("stance = \"base_pitch", "stance = \"base_pich", ":20:11", "did you mean `base_pitch`?"),
    ("stance = \"base_pitch", "stance = \"stance", ":20:10", "depends on itself"),
    ("name = \"single_support\"", "name = \"double_support\"", ":24:8", "single_support"),
    ("name = \"single_support\"", "", ":23:1", "has no `name`"),
    ("variable = \"stance\"", "variable = \"stance - torso_lean\"", ":25:22", "the configuration alone"),
    ("variable = \"stance\"", "variable = \"stance +\"", ":25:21", "ends too early"),
    ("variable = \"stance\"", "variable = \"left_foot_point_foot_x\"", ":25:12", "its unit says"),
    ("variable = \"stance\"", "", ":23:1", "has no `variable`"),
    ("guard = {", "gard = {", ":29:1", "did you mean `guard`?"),
    ("- step_length\"", "- torso_lean\"", ":29:18", "the units do not fit"),
    ("between = [0.01, 1.57]", "betwen = [0.01, 1.57]", ":29", "did you mean `between`?"),
    ("wanted = \"-torso_lean\"", "wanted = \"-torso_lean - base_pitch\"", ":35:25", "phase, phase_start"),
    ("wanted = \"-torso_lean\"", "wanted = \"-step_length\"", ":35:10", "is in m"),
    ("wanted = \"-phase\"", "wanted = \"sin(step_length)\"", ":41:10", "takes an angle or a ratio"),
    ("controlled = \"swing\"", "controlled = \"swing - phase\"", ":40:23", "the configuration alone"),
    ("controlled = \"swing\"", "controlled = \"base_pitch\"", ":37:1", "`swing_leg` says nothing new"),
    ("controlled = \"swing\"", "controlled = \"sin(base_pitch)\"", ":37:1", "the joints are not fixed"),
    ("variable = \"stance\"", "variable = \"-stance\"", ":25:12", "the phase variable decreases"),
    ("friction = 0.6", "friction = 0", ":44:12", "a number above 0"),
    ("link = \"right_leg\"", "link = \"right_lag\"", ":49:8", "did you mean `right_leg`?"),
    (
        "[limits]",
        "[[effect]]\nkind = \"viscous_friction\"\njoint = \"left_hip_pitch\"\ndamping = 1.0\n[limits]",
        ":43:1",
        "does not make another body",
    ),
    ("impact_matching = true", "posture = { knee = 0.1 }", ":27:13", "no joint `knee`"),
    ("variable = \"stance\"", "variable = \"0.1 * pi\"", ":25:12", "the same whatever the joints do"),
    ("wanted = \"-torso_lean\"", "wanted = \"1 / (phase - phase)\"", ":31:1", "divides by zero"),
    ("name = \"swing_leg\"", "name = \"torso\"", ":38:8", "another output `torso`"),
];

#[test]
fn mistakes_are_named_with_their_place() {
    for (index, (from, to, place, words)) in MISTAKES.into_iter().enumerate() {
        let text = changed("robots/three_link", from, to);
        let found = match open(&format!("mistake_{index}"), &text) {
            Ok(_) => panic!("{to:?} is no mistake"),
            Err(found) => found.to_string(),
        };
        assert!(found.contains(words), "{to}: no `{words}` in: {found}");
        assert!(found.contains(&format!("mistake_{index}.toml{place}")), "{to}: not at {place}: {found}");
        assert!(found.contains("help: "), "{to}: {found}");
        // A mistake in a parameter is none of the formulas that name it.
        let of_parameter =
            ["unit = \"m\"", "default = ", "bounds = "].iter().any(|key| from.starts_with(key));
        assert!(!of_parameter || found.matches("error: ").count() == 1, "{found}");
    }
}

/// What a file says that changes no step, or hardly can be meant: read all the same, and warned of at its place.
#[test]
fn odd_parameters_are_warned_of() {
    let spare = "[parameters.spare]\nunit = \"rad\"\ndefault = 0.0\nbounds = [-40, 0.3]\n\n[quantities]\n";
    let warned = |text: &str| {
        let found = open("warned", text).unwrap().warnings;
        found.iter().map(ToString::to_string).collect::<Vec<_>>()
    };
    let named = changed("robots/three_link", "[quantities]\n", spare);
    let found = warned(&named);
    assert_eq!(found.len(), 2, "{found:?}");
    let [unused, turns] = [&found[0], &found[1]];
    assert!(
        unused.contains("no formula names the parameter `spare`") && unused.contains(":19:13"),
        "{unused}"
    );
    assert!(turns.contains("more than a turn: is it in degrees?") && turns.contains(":22:10"), "{turns}");
    // By way of a quantity it is used.
    let used = named.replace("[quantities]\n", "[quantities]\nlean = \"-torso_lean - spare\"\n");
    let used = used.replace("wanted = \"-torso_lean\"", "wanted = \"lean\"").replace("-40", "-0.4");
    assert_eq!(warned(&used), Vec::<String>::new());
}

#[test]
fn a_robot_on_another_base_is_refused_in_one_sentence() {
    for base in ["fixed", "floating"] {
        let found = bipedc(&[
            "gait",
            "step",
            concat!(env!("CARGO_MANIFEST_DIR"), "/robots/three_link"),
            "--gait",
            "thesis",
            "--speed",
            "1.5",
            "--base",
            base,
        ]);
        let said = found.fails_with(&["x-z plane", "--base planar"]).err;
        assert_eq!(said.matches("error: ").count(), 1, "{said}");
    }
}

#[test]
fn outputs_are_as_many_as_actuators() {
    let output = "[[phase.output]]\nname = \"torso\"\nunit = \"rad\"\ncontrolled = \"base_pitch\"\nwanted = \"-torso_lean\"\n";
    let fewer = open("fewer", &changed("robots/three_link", output, "")).map(|_| ()).unwrap_err().to_string();
    assert!(fewer.contains("1 outputs for 2 actuators") && fewer.contains(":32:"), "{fewer}");
    let more = open("more", &changed("robots/three_link", output, &format!("{output}{output}")));
    assert!(more.map(|_| ()).unwrap_err().to_string().contains("3 outputs for 2 actuators"));
    let two = changed("robots/three_link", "[limits]", "[[phase]]\nname = \"single_support\"\n[limits]");
    let two = open("two_phases", &two).map(|_| ()).unwrap_err().to_string();
    assert!(two.contains("several phases"), "{two}");
}

/// Feet that can stand flat leave no freedom about a point.
#[test]
fn a_robot_on_flat_feet_is_refused() {
    let text = changed("robots/three_link", "name = \"single_support\"", "name = \"flat_foot\"");
    let robot = robot("robots/seven_link");
    let name = robot.description.phases[0].name.clone();
    let text = text.replace("flat_foot", &name);
    let found = GaitBench::parse(&robot, Path::new("flat.toml"), &text, &Silent);
    let found = found.map(|_| ()).unwrap_err().to_string();
    assert!(found.contains(&format!("phase `{name}`")), "{found}");
}

/// Quantities that name two others each, which do so again: a file of forty lines that would be read for years.
#[test]
fn quantities_are_read_once_each() {
    let mut lines = String::from("a0 = \"base_pitch\"\nb0 = \"base_pitch\"\n");
    for k in 1..60 {
        let before = k - 1;
        lines += &format!("a{k} = \"a{before} + b{before}\"\nb{k} = \"a{before} - 0.5 * b{before}\"\n");
    }
    let text = changed("robots/three_link", "[quantities]\n", &format!("[quantities]\n{lines}"));
    let bench = open("many", &text.replace("controlled = \"base_pitch\"", "controlled = \"a59\""));
    let step =
        bench.unwrap_or_else(|e| panic!("{e}")).step(&StepOptions { speed: 1.5, ..StepOptions::default() });
    assert!(step.unwrap().step.delta.is_some());
}

/// An empty file, and files that are cut anywhere: errors, never a panic.
#[test]
fn cut_files_are_errors() {
    let text = changed("robots/three_link", "gravity", "gravity");
    let refused = |text: &str| open("cut", text).map(|_| ()).unwrap_err();
    assert!(refused("").to_string().contains("[[phase]]"));
    for end in (0..text.len()).step_by(37).filter(|&end| text.is_char_boundary(end)) {
        match open("cut", &text[..end]) {
            // Effects and limits at the end are not needed.
            Ok(_) => assert!(text[end..].find("[[phase.output]]").is_none(), "{end}"),
            Err(found) => assert!(!found.0.is_empty()),
        }
    }
}

/// Outputs that are no sums of joint angles have no closed form: their surface is found by iteration. What they want where the step
/// ends is the same here, so the impact is, too.
#[test]
fn outputs_that_are_not_affine_are_found_by_iteration() {
    let bench = bent();
    assert!(bench.compiled().model.functions.iter().all(|function| function.name != "surface"));
    let straight = gait("robots/three_link", "thesis");
    let options = StepOptions { speed: 1.5, ..StepOptions::default() };
    let (step, same) = (bench.step(&options).unwrap().step, straight.step(&options).unwrap().step);
    for (found, expected) in [(step.phi_end, same.phi_end), (step.delta, same.delta), (step.eta, same.eta)] {
        assert!((found.unwrap() - expected.unwrap()).abs() < 1e-12, "{found:?} {expected:?}");
    }
    // h_p is a cubic of the tangent now: between the ends it is another motion.
    let difference = (step.p_max.unwrap() - same.p_max.unwrap()).abs();
    assert!(step.feasible && difference > 1e-3 && difference < 5.0, "{difference}");
}
