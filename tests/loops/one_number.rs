//! One number: what `diagnose` states as the held-out error is what `amend` prints and notes, what the comment in the description
//! says, what `history` shows and what `compare` measures with the amended description on the same log.
use super::simulated::Hidden;
use crate::loops::cli::{bipedc, scratch, text};
use serde_json::Value;
use std::io::Read as _;
use std::path::{Path, PathBuf};

/// A robot that may be amended, its logs, and further words for every command.
struct Case {
    robot: PathBuf,
    train: PathBuf,
    judge: PathBuf,
    base: &'static [&'static str],
}

impl Case {
    /// Another simulator's logs.
    fn example(name: &str) -> Self {
        let robot = scratch(&format!("one_number_{name}"));
        for file in ["robot.urdf", "biped.toml"] {
            std::fs::copy(Path::new("robots/tulip").join(file), robot.join(file)).unwrap();
        }
        let log = |file: &str| Path::new("tests/data/examples").join(name).join(file);
        Self { robot, train: log("train.csv.gz"), judge: log("validation.csv.gz"), base: &[] }
    }

    /// The halves of a log made with Pinocchio.
    fn arm() -> Self {
        let (robot, data) = (scratch("one_number_arm"), Path::new("tests/data/identify"));
        for file in ["robot.urdf", "biped.toml"] {
            std::fs::copy(data.join("arm").join(file), robot.join(file)).unwrap();
        }
        let mut whole = String::new();
        let file = std::fs::File::open(data.join("0.csv.gz")).unwrap();
        flate2::read::GzDecoder::new(file).read_to_string(&mut whole).unwrap();
        let lines: Vec<&str> = whole.lines().collect();
        let half = |name: &str, rows: &[&str]| {
            let file = robot.join(name);
            std::fs::write(&file, [&lines[..1], rows].concat().join("\n")).unwrap();
            file
        };
        let (first, second) = lines[1..].split_at(lines.len() / 2);
        let (train, judge) = (half("train.csv", first), half("judge.csv", second));
        Self { robot, train, judge, base: &[] }
    }

    /// Our own.
    fn simulated(name: &str, effects: &str) -> Self {
        let Hidden { robot, train, judge } = Hidden::simulated(name, effects);
        Self { robot, train, judge, base: &["--base", "fixed"] }
    }

    fn run(&self, words: &[&str]) -> crate::cli::Run {
        bipedc(&[words, self.base].concat()).ok()
    }

    fn compared(&self) -> f64 {
        let compared = self.run(&["compare", text(&self.robot), text(&self.judge), "--json"]).json();
        compared["rms"].as_f64().unwrap()
    }

    fn diagnosed(&self, inertial: &str) -> Value {
        let logs = [text(&self.train), "--validate", text(&self.judge)];
        let words = [&["diagnose", text(&self.robot)], &logs[..], &["--inertial", inertial, "--json"]];
        self.run(&words.concat()).json()
    }

    /// One diagnosis, and everything that speaks of it.
    fn check(&self, inertial: &str) -> (Value, f64) {
        let before = std::fs::read_to_string(self.robot.join("biped.toml")).unwrap();
        let answer = self.diagnosed(inertial);
        let fall = &answer["rms"]["effort"];
        let (was, is) = (fall["before"].as_f64().unwrap(), fall["after"].as_f64().unwrap());
        let file = self.robot.join("diagnosis.json");
        std::fs::write(&file, answer.to_string()).unwrap();

        let amend = ["amend", text(&self.robot), "--from", text(&file), "--json"];
        let step = bipedc(&amend).ok().json();
        assert_eq!(step["errors"][0]["held_out"], serde_json::json!({"before": was, "after": is}));
        let history = bipedc(&["history", text(&self.robot), "--json"]).ok().json();
        let stairs = history["stairs"].as_array().unwrap();
        assert_eq!((&stairs[0]["before"], &stairs[stairs.len() - 1]["after"]), (&was.into(), &is.into()));
        for pair in stairs.windows(2) {
            assert_eq!(pair[0]["after"], pair[1]["before"], "{stairs:?}");
        }
        let compared = self.compared();
        println!("{}, {inertial}: {was:.4} -> {is:.4}, compared {compared:.4} N m", self.robot.display());
        assert!((compared / is - 1.0).abs() < 1e-6, "{inertial}: {is} is said, {compared} is so");
        let toml = std::fs::read_to_string(self.robot.join("biped.toml")).unwrap();
        let said = toml.rsplit("held-out effort ").next().unwrap().split(" → ").nth(1).unwrap();
        let said: f64 = said.split(' ').next().unwrap().parse().unwrap();
        assert!((said / is - 1.0).abs() < 1e-3, "{said} stands in the comment, {is} is so");

        bipedc(&["amend", text(&self.robot), "--undo"]).ok();
        assert_eq!(std::fs::read_to_string(self.robot.join("biped.toml")).unwrap(), before);
        (answer, is)
    }

    /// The loop by itself ends at the error of its last step.
    fn explained(&self, inertial: &str) -> f64 {
        let logs = [text(&self.train), "--validate", text(&self.judge), "--until-explained"];
        self.run(&[&["diagnose", text(&self.robot)], &logs[..], &["--inertial", inertial]].concat());
        let history = bipedc(&["history", text(&self.robot), "--json"]).ok().json();
        let last = history["stairs"].as_array().unwrap().last().unwrap()["after"].as_f64().unwrap();
        let compared = self.compared();
        println!("{}, {inertial}: explained to {last:.4}, compared {compared:.4}", self.robot.display());
        assert!((compared / last - 1.0).abs() < 1e-6, "{last} is said, {compared} is so");
        last
    }
}

/// Forces under the feet alone: one body before corrections of links, which say the same in other words and are named; weighing tells.
#[test]
#[ignore = "takes long"]
fn a_body_and_what_corrections_would_be() {
    let case = Case::example("swaying");
    let logs = [text(&case.train), "--validate", text(&case.judge), "--channels", "base_force,base_moment"];
    let answer = case.run(&[&["diagnose", text(&case.robot)], &logs[..], &["--json"]].concat()).json();
    let found = answer["effects"].as_array().unwrap();
    assert!(found.len() == 1 && found[0]["kind"] == "payload" && found[0]["link"] == "torso", "{found:#?}");
    assert_eq!(corrections(&answer), 0);
    let groups = answer["indistinguishable"].as_array().unwrap();
    let kinds = |side: &Value| {
        let kind = |effect: &Value| effect["kind"].as_str().unwrap().to_owned();
        side.as_array().unwrap().iter().map(kind).collect::<Vec<_>>()
    };
    let is_corrected = |group: &&Value| {
        kinds(&group[0]) == ["payload"] && kinds(&group[1]).iter().all(|kind| kind == "inertial_correction")
    };
    assert_eq!(groups.iter().filter(is_corrected).count(), 1, "{groups:#?}");
    let summary = answer["summary"].as_str().unwrap();
    assert!(
        summary.contains("Inertial correction at torso. To tell them apart: Weigh the robot"),
        "{summary}"
    );
    assert!(!summary.contains("inf"), "{summary}");
}

/// Logs on feet have a cut-off of their own, which follows from the log that is compared. Another simulator's, whose first sample is a
/// jolt of 2 kN m: what was hidden is all that is found, and everything speaks of the same errors.
#[test]
#[ignore = "takes long"]
fn on_feet() {
    let case = Case::example("swaying");
    let answer = case.diagnosed("none");
    println!("{}", answer["summary"]);
    let found = answer["effects"].as_array().unwrap();
    assert_eq!(found.len(), 1, "{found:#?}");
    assert_eq!((&found[0]["kind"], &found[0]["link"]), (&"payload".into(), &"torso".into()));
    for (parameter, hidden) in [("mass", 0.9), ("x", 0.07), ("y", -0.03), ("z", 0.3)] {
        let [low, high] = [0, 1].map(|end| found[0]["ci95"][parameter][end].as_f64().unwrap());
        assert!(low <= hidden && hidden <= high, "{parameter}: {low} to {high} for {hidden}");
    }
    let file = case.robot.join("diagnosis.json");
    std::fs::write(&file, answer.to_string()).unwrap();
    bipedc(&["amend", text(&case.robot), "--from", text(&file)]).ok();
    let compared = case.run(&["compare", text(&case.robot), text(&case.judge), "--json"]).json();
    let history = bipedc(&["history", text(&case.robot), "--json"]).ok().json();
    for (kind, fall) in answer["rms"].as_object().unwrap() {
        let (said, is) = (fall["after"].as_f64().unwrap(), compared["kinds"][kind]["rms"].as_f64().unwrap());
        assert!((is / said - 1.0).abs() < 1e-6, "{kind}: {said} is said, {is} is so");
    }
    let last = history["stairs"].as_array().unwrap().last().unwrap()["after"].as_f64().unwrap();
    let kinds = compared["kinds"].as_object().unwrap();
    assert!(
        kinds.values().any(|kind| (kind["rms"].as_f64().unwrap() / last - 1.0).abs() < 1e-6),
        "{last} in {kinds:?}"
    );
}

fn corrections(answer: &Value) -> usize {
    answer["inertial_corrections"].as_array().unwrap().len()
}

#[test]
#[ignore = "takes long"]
fn with_a_hidden_payload() {
    let payload =
        "[[effect]]\nkind = \"payload\"\nlink = \"left_tibia\"\nmass = 0.8\nx = 0.05\ny = 0.0\nz = -0.1\n";
    let case = Case::simulated("one_number", payload);
    let (free, error) = case.check("free");
    assert!(corrections(&free) > 0, "inertias that are free are written");
    let noise = free["rms"]["effort"]["noise"].as_f64().unwrap();
    assert!(error < 1.5 * noise, "{error} with free inertias, noise {noise}");
    case.check("none");
    case.check("prior");
    case.explained("free");
}

#[test]
#[ignore = "takes long"]
fn with_friction_by_other_simulators() {
    Case::example("coulomb").check("free");
    for inertial in ["free", "prior", "none"] {
        Case::arm().check(inertial);
    }
    Case::arm().explained("prior");
}

/// Masses and inertias of two links are not the description's: what was fitted is written, such as bodies can have it.
#[test]
#[ignore = "takes long"]
fn with_other_inertias() {
    let other = |link: &str, rest: &str| {
        format!("[[effect]]\nkind = \"inertial_correction\"\nlink = \"{link}\"\n{rest}\n")
    };
    let hidden = other("left_femur", "mass = 0.5\nx = 0.01\nz = -0.02\niyy = 0.02")
        + &other("right_tibia", "mass = -0.2\nz = 0.015\niyy = -0.005")
        + "[[effect]]\nkind = \"viscous_friction\"\njoint = \"left_knee_pitch\"\ndamping = 0.6\n";
    let case = Case::simulated("one_number_inertias", &hidden);
    let (free, error) = case.check("free");
    let noise = free["rms"]["effort"]["noise"].as_f64().unwrap();
    assert!(corrections(&free) >= 2 && error < 1.2 * noise, "{error} with free inertias, noise {noise}");
    assert_eq!(free["effects"][0]["kind"], "viscous_friction", "{}", free["summary"]);
    for found in free["inertial_corrections"].as_array().unwrap() {
        assert_eq!(found["parameters"].as_object().unwrap().len(), 10);
        assert_eq!(found["ci95"].as_object().unwrap().len(), 10);
    }
    let (prior, _) = case.check("prior");
    assert!(corrections(&prior) > 0);
    case.explained("free");
    // Bodies of the amended robot can exist, and nothing is left to be found.
    let check = bipedc(&["check", text(&case.robot)]).ok();
    assert!(check.out.contains("physically consistent"), "{}", check.out);
    assert_eq!(case.diagnosed("none")["effects"].as_array().unwrap().len(), 0);
}

/// All links of both legs are others: each could do most of what its neighbour does, and all are needed.
#[test]
#[ignore = "takes long"]
fn with_other_inertias_of_all_links() {
    let hidden = [
        ("left_femur", 0.9, -0.02),
        ("left_tibia", 0.6, 0.02),
        ("right_femur", -0.8, 0.015),
        ("right_tibia", 0.5, -0.03),
    ];
    let other = |(link, mass, z): (&str, f64, f64)| {
        format!("[[effect]]\nkind = \"inertial_correction\"\nlink = \"{link}\"\nmass = {mass}\nz = {z}\n")
    };
    let case = Case::simulated("one_number_links", &hidden.map(other).concat());
    let (free, error) = case.check("free");
    let noise = free["rms"]["effort"]["noise"].as_f64().unwrap();
    assert!(corrections(&free) == 4 && error < 1.1 * noise, "{error} with free inertias, noise {noise}");
    for found in free["inertial_corrections"].as_array().unwrap() {
        let (_, mass, _) = hidden.iter().find(|(link, ..)| found["link"] == *link).unwrap();
        let end = |k: usize| found["ci95"]["mass"][k].as_f64();
        assert!(end(0).is_none_or(|low| low < *mass) && end(1).is_none_or(|high| mass < &high), "{found}");
    }
    case.explained("free");
}

/// Effects that turn joints or the base beside those that act on what is turned: a search and a comparison have the same model of them.
#[test]
fn of_effects_that_meet() {
    let case = Case::example("rotor_inertia");
    let effects = [
        ("gravity_tilt", "", "roll = -0.1\npitch = 0.05"),
        ("payload", "link = \"left_lower_leg\"", "mass = 0.5\nx = 0.1\ny = -0.1\nz = -0.1"),
        ("com_offset", "link = \"right_upper_leg\"", "x = 0.02\ny = 0.01\nz = -0.02"),
        ("inertial_correction", "link = \"left_upper_leg\"", "mass = -0.3\nz = 0.01\niyy = 0.01"),
        ("encoder_offset", "joint = \"left_knee_pitch\"", "offset = 0.05"),
        ("parallel_spring", "joint = \"left_knee_pitch\"", "stiffness = 20.0\nrest_angle = 0.1"),
        (
            "torque_ripple",
            "joint = \"left_knee_pitch\"",
            "amplitude = 0.3\nperiods_per_turn = 4\nphase = 0.3",
        ),
    ];
    let described =
        effects.map(|(kind, place, values)| format!("\n[[effect]]\nkind = \"{kind}\"\n{place}\n{values}\n"));
    let toml = case.robot.join("biped.toml");
    let bare = std::fs::read_to_string(&toml).unwrap();
    std::fs::write(&toml, bare + &described.concat()).unwrap();
    let [robot, log] = [text(&case.robot), text(&case.judge)];
    let same = ["--cutoff", "6.3", "--json"];
    let compared = case.run(&[&["compare", robot, log], &same[..]].concat()).json();
    let words = [
        "diagnose",
        robot,
        text(&case.train),
        "--validate",
        log,
        "--inertial",
        "none",
        "--most",
        "0",
        "--anyway",
    ];
    let answer = case.run(&[&words[..], &same[..]].concat()).json();
    for channel in compared["channels"].as_array().unwrap().iter().filter(|c| c["kind"] == "effort") {
        let (name, is) = (channel["name"].as_str().unwrap(), channel["rms"].as_f64().unwrap());
        let said = answer["rows"][name]["before"].as_f64().unwrap();
        println!("{name}: {said} in a search, {is} compared");
        assert!((said / is - 1.0).abs() < 1e-6, "{name}: {said} in a search, {is} compared");
    }
}

/// Drives that turn together: what an identification finds of them is written, says what it measured, and is left in nothing.
#[test]
fn of_coupled_drives() {
    let coupling = |joint: &str, other: &str| {
        format!(
            "[[effect]]\nkind = \"coupling\"\njoint = \"{joint}\"\nother_joint = \"{other}\"\ninertia = 0.0\ndamping = 0.6\n\
             coulomb = 0.8\nstiffness = 0.0\ndifferential = 1.0\n"
        )
    };
    let [hip, knee] = ["left_hip_pitch", "left_knee_pitch"];
    let case = Case::simulated("one_number_coupled", &[coupling(hip, knee), coupling(knee, hip)].concat());
    let nothing = case.compared();
    let toml = case.robot.join("biped.toml");
    let described = std::fs::read_to_string(&toml).unwrap();
    std::fs::write(&toml, [described.as_str(), &coupling(hip, knee), &coupling(knee, hip)].concat()).unwrap();
    let truth = case.compared();
    std::fs::write(&toml, described).unwrap();
    let file = case.robot.join("identified.json");
    let words = ["identify", text(&case.robot), text(&case.train), "--validate", text(&case.judge), "--json"];
    let coupled = ["--coupled", &format!("{hip},{knee}")];
    std::fs::write(&file, case.run(&[&words[..], &coupled].concat()).out).unwrap();
    let step = bipedc(&["amend", text(&case.robot), "--from", text(&file), "--json"]).ok().json();
    let written = step["changes"].as_array().unwrap().iter().map(|change| &change["effect"]);
    let written: Vec<&Value> = written.filter(|effect| effect["kind"] == "coupling").collect();
    assert_eq!(written.len(), 2, "{step:#}");
    for effect in written {
        let value = |name: &str| effect["parameters"][name].as_f64().unwrap_or(0.0);
        let off = [value("damping") / 0.6 - 1.0, value("coulomb") / 0.8 - 1.0];
        assert!(off.iter().all(|off| off.abs() < 0.02), "{effect:#}");
        assert!(value("stiffness") == 0.0 && value("inertia").abs() < 0.002, "{effect:#}");
    }
    let (is, compared) = (step["errors"][0]["held_out"]["after"].as_f64().unwrap(), case.compared());
    println!(
        "coupled drives: {nothing:.4} -> {is:.4}, compared {compared:.4}, with the true ones {truth:.4} N m"
    );
    assert!((compared / is - 1.0).abs() < 1e-9 && compared < 1.02 * truth && compared < 0.1 * nothing);
}

/// Masses, friction and offsets of an identification are written as a whole, with the error that a comparison measures.
#[test]
#[ignore = "takes long"]
fn of_an_identification() {
    let case = Case::arm();
    let before = std::fs::read_to_string(case.robot.join("biped.toml")).unwrap();
    let file = case.robot.join("identified.json");
    let identify = |more: &[&str]| {
        let logs = [text(&case.train), "--validate", text(&case.judge), "--json"];
        let words = [&["identify", text(&case.robot)], &logs[..], more].concat();
        std::fs::write(&file, bipedc(&words).ok().out).unwrap();
    };
    let amend = ["amend", text(&case.robot), "--from", text(&file), "--json"];
    for more in [&[][..], &["--coupled", "shoulder,elbow"], &["--friction", "viscous"]] {
        identify(more);
        let step = bipedc(&amend).ok().json();
        let kinds = |kind: &str| {
            let changes = step["changes"].as_array().unwrap().iter();
            changes.filter(|change| change["effect"]["kind"] == kind).count()
        };
        // The bodies are those of the description, and the joints are not coupled: what is zero within its error bars is not written.
        assert_eq!((kinds("inertial_correction"), kinds("coupling")), (0, 0), "{more:?}");
        let fall = &step["errors"][0]["held_out"];
        let (was, is, compared) =
            (fall["before"].as_f64().unwrap(), fall["after"].as_f64().unwrap(), case.compared());
        println!("identified {more:?}: {was:.4} -> {is:.4}, compared {compared:.4} N m");
        assert!((compared / is - 1.0).abs() < 1e-9 && is < 0.6 * was, "{is} is said, {compared} is so");
        if more.is_empty() {
            let toml = std::fs::read_to_string(case.robot.join("biped.toml")).unwrap();
            assert!(
                toml.contains("kind = \"coulomb_friction\"\njoint = \"shoulder\"\ntorque = 1.5"),
                "{toml}"
            );
            let diagnosed = case.diagnosed("none");
            assert_eq!(diagnosed["effects"].as_array().unwrap().len(), 0, "{}", diagnosed["summary"]);
        }
        bipedc(&["amend", text(&case.robot), "--undo"]).ok();
        assert_eq!(std::fs::read_to_string(case.robot.join("biped.toml")).unwrap(), before);
    }
    identify(&[]);
    let payload = [
        "amend",
        text(&case.robot),
        "--effect",
        "payload",
        "--link",
        "fore",
        "--set",
        "mass=0.1,x=0,y=0,z=0",
    ];
    bipedc(&payload).ok();
    bipedc(&amend).fails_with(&["looked at the rigid robot", "Payload at fore", "--remove"]);
    bipedc(&[&amend[..4], &["--only", "1"]].concat()).fails_with(&["taken as a whole"]);
}
