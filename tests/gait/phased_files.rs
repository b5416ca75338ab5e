//! Gait files of several phases: every mistake is named with its place and what to do.
use super::{WALKER, phased, robot};
use crate::cli::{bipedc, scratch, text as path};
use bipedc::Diagnostics;
use bipedc::gait::{GaitBench, PhasedBench};
use bipedc::progress::Silent;
use std::path::Path;

fn shipped() -> String {
    let path = format!("{}/{WALKER}/gaits/collocated.toml", env!("CARGO_MANIFEST_DIR"));
    std::fs::read_to_string(path).unwrap()
}

fn open(name: &str, text: &str) -> Result<PhasedBench, Diagnostics> {
    PhasedBench::parse(&robot(WALKER), Path::new(&format!("{name}.toml")), text, &Silent)
}

fn refused(name: &str, text: &str) -> String {
    open(name, text).map(|_| ()).unwrap_err().to_string()
}

/// What is replaced, by what, where that is said, and in which words.
const MISTAKES: [(&str, &str, &str, &str); 19] = [
    ("name = \"toe_support\"", "name = \"tow_support\"", "did you mean `toe_support`?", "name = \"tow"),
    ("name = \"toe_support\"", "name = \"push_off\"", "is followed by `toe_support`", "name = \"single"),
    ("end = -0.005049219986075076", "", "has no `end`", "[[phase]]"),
    ("end = -0.005049219986075076", "end = \"base_x\"", "the configuration", "\"base_x\""),
    ("end = -0.005049219986075076", "end = \"phase\"", "the phase variable", "\"phase\""),
    ("end = -0.005049219986075076", "end = 1e400", "finite", "1e400"),
    ("unit = \"m\"\nimpact", "unit = \"rad\"\nimpact", "its unit says", "\"base_x"),
    ("stiffness = 2025.0", "stiffness = -2025.0", "a number above 0", "-2025.0"),
    (", damping = 90.0", "", "has no `damping`", "{ stiffness"),
    ("wanted.over = [-0.2384", "wanted.over = [0.2384", "smaller number first", "[0.2384"),
    ("wanted.over = [-0.23841098947075048, -0.005049219986075076]\n", "", "has no `over`", "wanted.bezier"),
    ("wanted.bezier = [", "wanted.bezir = [", "did you mean `bezier`?", "bezir"),
    (
        "wanted.bezier = [",
        "wanted.polynomial = [0.1, 0.2]\nwanted.bezier = [",
        "has `bezier` and `polynomial`",
        "[0.1, 0.2]",
    ),
    ("wanted.bezier = [", "wanted.bezier = [\"a\", ", "expected a number", "\"a\""),
    (
        "at = [\n    -0.23841098947075048",
        "at = [\n    0.23841098947075048",
        "larger than the one before",
        "[\n    0.2384",
    ),
    (
        "[phase.feedforward.torques]\nright_ankle_pitch",
        "[phase.feedforward.torques]\nright_ankel_pitch",
        "no joint",
        "[\n    -1.58",
    ),
    ("right_ankle_pitch = [", "right_ankle_pitch = [1.0, ", "18 torques", "[1.0, "),
    ("impact_matching = true", "impact_matchng = true", "did you mean `impact_matching`?", "impact_matchng"),
    ("impact_matching = true", "guard = { zero = \"base_x\" }", "unknown key `guard`", "guard ="),
];

/// Line and column of a text in another.
fn place(text: &str, words: &str) -> String {
    let at = text.find(words).unwrap_or_else(|| panic!("no `{words}`"));
    let line = text[..at].matches('\n').count() + 1;
    format!(":{line}:")
}

#[test]
fn mistakes_are_named_with_their_place() {
    for (index, (from, to, words, at)) in MISTAKES.into_iter().enumerate() {
        let text = shipped();
        assert!(text.contains(from), "no `{from}` in the gait");
        let text = text.replacen(from, to, 1);
        let found = refused(&format!("mistake_{index}"), &text);
        assert!(found.contains(words), "{to}: no `{words}` in: {found}");
        let place = place(&text, at);
        assert!(found.contains(&format!("mistake_{index}.toml{place}")), "{to}: not at {place}: {found}");
        assert!(found.contains("help: "), "{to}: {found}");
    }
}

/// N − M − 1: what the contacts hold, the outputs and the phase variable are as many as coordinates.
#[test]
fn outputs_fit_what_stands() {
    let text = shipped();
    let numbers: Vec<usize> =
        phased(WALKER, "collocated").gait.phases.iter().map(|phase| phase.outputs.len()).collect();
    assert_eq!(numbers, [5, 6, 4, 3]);
    let output =
        "[[phase.output]]\nname = \"hip\"\nunit = \"m\"\ncontrolled = \"base_z\"\nwanted = \"0.6\"\n\n";
    let after = |phase: &str| {
        let start = text.find(&format!("name = \"{phase}\"")).unwrap();
        let at = start + text[start..].find("[[phase.output]]").unwrap();
        format!("{}{output}{}", &text[..at], &text[at..])
    };
    for (phase, found, held) in
        [("single_support", 6, 3), ("toe_support", 7, 2), ("touch_down", 5, 4), ("push_off", 4, 5)]
    {
        let said = refused("more", &after(phase));
        let wanted = format!("{found} outputs in phase `{phase}`, which leaves room for {}", found - 1);
        assert!(said.contains(&wanted) && said.contains(&format!("hold {held},")), "{said}");
        assert!(said.contains("more.toml:"), "{said}");
    }
}

/// What is only seen in numbers is told with its place, too.
#[test]
fn outputs_that_say_the_same_are_named() {
    let text = shipped();
    let again = text.replacen("controlled = \"left_ankle_pitch\"", "controlled = \"2 * left_knee_pitch\"", 1);
    let file = scratch("phased-files-dependent").join("dependent.toml");
    std::fs::write(&file, &again).unwrap();
    let line = text[..text.find("name = \"swing_ankle\"").unwrap()].matches('\n').count();
    let place = format!("dependent.toml:{line}:1");
    for more in [&["step", "--speed", "0.4"][..], &["cycle"]] {
        let run = bipedc(&[&["gait", more[0], WALKER, "--gait", path(&file)], &more[1..]].concat());
        run.fails_with(&["the output `swing_ankle` says nothing new", "`single_support`", &place, "help: "]);
    }
}

/// A parameter that is refused keeps its unit: formulas of it were said to have others.
#[test]
fn a_refused_parameter_gives_one_error() {
    let text = std::fs::read_to_string("robots/seven_link_v1/gaits/adjustable.toml").unwrap();
    let wrong = text.replacen("default = 0.33\n", "default = 3.3\n", 1);
    assert_ne!(wrong, text);
    let file = scratch("phased-files-refused").join("refused.toml");
    std::fs::write(&file, &wrong).unwrap();
    let run = bipedc(&["gait", "step", WALKER, "--gait", path(&file), "--speed", "0.4"]);
    assert_eq!(run.err.matches("error: ").count(), 1, "{}", run.err);
    run.fails_with(&["`default` of `step_length`, 3.3, lies outside its bounds"]);
}

/// A phase variable that nothing moves left postures open, and a step of it was called not possible without a place.
#[test]
fn a_phase_variable_that_stays_is_an_error_at_its_place() {
    let text = shipped();
    let start = text.find("variable = \"").unwrap();
    let (from, line) = (start + "variable = \"".len(), text[..start].matches('\n').count() + 1);
    let to = from + text[from..].find('"').unwrap();
    let file = scratch("phased-files-still").join("still.toml");
    std::fs::write(&file, format!("{}0 * ({}){}", &text[..from], &text[from..to], &text[to..])).unwrap();
    let run = bipedc(&["gait", "step", WALKER, "--gait", path(&file), "--speed", "0.4"]);
    run.fails_with(&[
        "the phase variable of phase",
        "does not grow",
        &format!("still.toml:{line}:"),
        "help: ",
    ]);
}

/// A gait of four phases has no map; one of one phase is none of several.
#[test]
fn gaits_of_one_and_of_several_phases_are_told_apart() {
    let found = GaitBench::open(&robot(WALKER), "collocated", &Silent).map(|_| ()).unwrap_err().to_string();
    assert!(found.contains("a gait of several phases (4)") && found.contains("collocated.toml:"), "{found}");
    assert!(!found.contains("guard"), "nothing else is said of it: {found}");
    let found = PhasedBench::open(&robot("robots/three_link"), "thesis", &Silent)
        .map(|_| ())
        .unwrap_err()
        .to_string();
    assert!(found.contains("has one phase"), "{found}");
}

/// Files that are cut anywhere: errors, never a panic.
#[test]
fn cut_files_are_errors() {
    let text = shipped();
    let last = text.rfind("[limits]").unwrap();
    for end in (0..last).step_by(331).filter(|&end| text.is_char_boundary(end)) {
        if let Ok(bench) = open("cut", &text[..end]) {
            // Joints without feed-forward are none the worse for it.
            assert!(text[end..].find("[[phase").is_none() && bench.gait.phases.len() == 4, "{end}");
        }
    }
}

/// What moves curves and torques with the parameters has their units and names what it may.
#[test]
fn formulas_that_move_curves_are_checked() {
    let path = format!("{}/{WALKER}/gaits/adjustable.toml", env!("CARGO_MANIFEST_DIR"));
    let text = std::fs::read_to_string(path).unwrap();
    for (index, (from, to, words)) in [
        ("wanted.along = \"touch_down\"", "wanted.along = \"torso_lean\"", "is in rad or a ratio, not in m"),
        ("wanted.plus = \"-torso_lean\"", "wanted.plus = \"step_length\"", "is in m, not in rad or a ratio"),
        ("wanted.plus = \"-torso_lean\"", "wanted.plus = \"base_pitch\"", "belongs to the configuration"),
        ("left_ankle_pitch = \"push_off", "left_ankel_pitch = \"push_off", "no joint `left_ankel_pitch`"),
        (
            "left_ankle_pitch = \"push_off",
            "left_ankle_pitch = \"torso_lean",
            "is in rad or a ratio, not in m^2 kg s^-2",
        ),
        ("along = \"push\"", "along = \"pushing\"", "nothing is called `pushing`"),
    ]
    .into_iter()
    .enumerate()
    {
        assert!(text.contains(from), "no `{from}` in the gait");
        let name = format!("moved_{index}");
        let found = refused(&name, &text.replacen(from, to, 1));
        assert!(found.contains(words) && found.contains(&format!("{name}.toml:")), "{to}: {found}");
        assert!(found.contains("help: "), "{found}");
    }
}

/// Each phase by itself, with the other sign: the message is at its line, and as it stands nothing is said.
#[test]
fn a_phase_variable_that_falls_is_named_with_its_place() {
    let text = shipped();
    let places: Vec<usize> =
        text.match_indices("variable = \"").map(|(at, words)| at + words.len()).collect();
    assert_eq!(places.len(), 4);
    for (index, at) in places.into_iter().enumerate() {
        let end = at + text[at..].find('"').unwrap();
        let turned = format!("{}-({}){}", &text[..at], &text[at..end], &text[end..]);
        let file = scratch("phased-files-falling").join(format!("falls_{index}.toml"));
        std::fs::write(&file, &turned).unwrap();
        let line = text[..at].matches('\n').count() + 1;
        let place = format!("falls_{index}.toml:{line}:");
        for more in [&["step", "--speed", "0.4"][..], &["cycle"]] {
            let run = bipedc(&[&["gait", more[0], WALKER, "--gait", path(&file)], &more[1..]].concat());
            run.fails_with(&["decreases as the robot goes forward", " m per rad", &place, "help: "]);
        }
    }
}
