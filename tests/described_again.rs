//! Descriptions that hold the truth, estimated again.
use crate::cli::{bipedc, scratch, text};
use std::path::{Path, PathBuf};

const URDF: &str = r#"<robot name="bow">
<link name="post"/>
<link name="upper"><inertial><origin xyz="0.003 0 0.19"/><mass value="2.9"/><inertia ixx="0.04" ixy="0" ixz="0" iyy="0.041" iyz="0" izz="0.004"/></inertial></link>
<link name="lower"><inertial><origin xyz="0.12 0 0.03"/><mass value="1.5"/><inertia ixx="0.003" ixy="0" ixz="0" iyy="0.011" iyz="0" izz="0.011"/></inertial></link>
<joint name="shoulder" type="revolute"><origin xyz="0 0 0.45"/><parent link="post"/><child link="upper"/><axis xyz="0 1 0"/><limit lower="-6" upper="6" effort="2000" velocity="100"/></joint>
<joint name="elbow" type="revolute"><origin xyz="0 0 0.42"/><parent link="upper"/><child link="lower"/><axis xyz="AXIS"/><limit lower="-6" upper="6" effort="2000" velocity="100"/></joint>
</robot>
"#;

/// An arm of two joints, the second about the axis given, with effects in its description.
fn arm(folder: &Path, name: &str, axis: &str, effects: &str) -> PathBuf {
    let robot = folder.join(name);
    std::fs::create_dir_all(&robot).unwrap();
    std::fs::write(robot.join("robot.urdf"), URDF.replace("AXIS", axis)).unwrap();
    std::fs::write(robot.join("biped.toml"), format!("[base]\nkind = \"fixed\"\n{effects}")).unwrap();
    robot
}

/// Logs of two motions of it.
fn logs(folder: &Path, robot: &Path) -> [PathBuf; 2] {
    [(1, 0.4, 0.8), (2, 0.5, 0.7)].map(|(seed, slow, fast)| {
        let [scenario, log] = ["toml", "csv"].map(|end| folder.join(format!("{seed}.{end}")));
        let told = format!(
            "duration = 12.0\nstep = 0.0005\nlog_step = 0.004\nseed = {seed}\n[control]\nstiffness = 900.0\ndamping = 20.0\nservo = \"drive\"\n\
             [sensors]\nposition_noise = 1e-5\neffort_noise = 0.03\n\
             [joint.shoulder]\nposition = 0.3\nsines = [[0.5, {slow}, 0.4], [0.25, {fast}, 1.3]]\n\
             [joint.elbow]\nposition = 0.2\nsines = [[0.5, {}, 0.9], [0.25, {}, 0.3]]\n",
            slow + 0.1,
            fast - 0.1
        );
        std::fs::write(&scenario, told).unwrap();
        bipedc(&["simulate", text(robot), "--base", "fixed", "--scenario", text(&scenario), "--out", text(&log)]).ok();
        log
    })
}

/// A spring that carries a load. Before: mass 0, the load 14 m away, and an error of 0.87 instead of 0.03 N m.
#[test]
fn what_is_true_stays_where_it_is_estimated_again() {
    let folder = scratch("true-and-estimated-again");
    let effects = "[[effect]]\nkind = \"payload\"\nlink = \"upper\"\nmass = 1.2\nx = -0.028\ny = -0.044\nz = 0.214\n\
                   [[effect]]\nkind = \"parallel_spring\"\njoint = \"shoulder\"\nstiffness = 7.3\nrest_angle = 0.57\n";
    let robot = arm(&folder, "robot", "0 0 1", effects);
    let [train, judge] = logs(&folder, &robot);
    let run = ["diagnose", text(&robot), text(&train), "--validate", text(&judge), "--refit", "--json"];
    let answer = bipedc(&run).ok().json();
    let [was, is] = ["rms_before", "rms_after"].map(|key| answer[key].as_f64().unwrap());
    assert!(is < 1.01 * was && answer["effects"].as_array().unwrap().is_empty(), "{}", answer["summary"]);
    let standing = answer["standing"].as_array().unwrap();
    let value = |kind: &str, name: &str| {
        let one = standing.iter().find(|one| one["kind"] == kind).unwrap();
        one["parameters"][name].as_f64().unwrap()
    };
    for (kind, name, truth) in
        [("payload", "mass", 1.2), ("payload", "z", 0.214), ("parallel_spring", "stiffness", 7.3)]
    {
        assert!((value(kind, name) / truth - 1.0).abs() < 0.1, "{kind} {name}: {}", answer["summary"]);
    }
    // What no datum tells stays as it is described.
    assert_eq!(value("payload", "y").to_bits(), (-0.044_f64).to_bits());
}

/// A load that is described as a tenth of what it is. Before: "nothing is missing that these logs could show", and to go on with the description as it was.
#[test]
fn what_is_better_than_described_is_to_be_written() {
    let folder = scratch("better-than-described");
    let load = |mass: f64| {
        format!(
            "[[effect]]\nkind = \"payload\"\nlink = \"upper\"\nmass = {mass}\nx = -0.028\ny = -0.044\nz = 0.214\n"
        )
    };
    let [train, judge] = logs(&folder, &arm(&folder, "loaded", "0 0 1", &load(1.2)));
    let robot = arm(&folder, "robot", "0 0 1", &load(0.12));
    let page = folder.join("page.html");
    let run = ["diagnose", text(&robot), text(&train), "--validate", text(&judge), "--refit"];
    bipedc(&[&run[..], &["--report", text(&page)]].concat()).ok();
    let told = std::fs::read_to_string(&page).unwrap();
    assert!(!told.contains("Nothing is missing that these logs could show"));
    // Words of a command are marked one by one.
    let words: String =
        told.split('<').filter_map(|mark| mark.split_once('>')).map(|(_, word)| word).collect();
    let words = words.replace("&gt;", ">").replace("&amp;", "&");
    assert!(words.contains("--refit --json > diagnosis.json && bipedc amend"));
    assert!(words.contains("--from diagnosis.json"));
}

/// Of joints that all turn about y the roll of gravity is seen by its cosine alone. Before: a roll of the wrong sign, and an interval without the truth.
#[test]
fn the_sign_of_a_roll_that_nothing_shows_is_open() {
    let folder = scratch("open-roll");
    let tilted = "[[effect]]\nkind = \"gravity_tilt\"\nroll = -0.12\npitch = 0.05\n";
    let [train, judge] = logs(&folder, &arm(&folder, "tilted", "0 1 0", tilted));
    let robot = arm(&folder, "robot", "0 1 0", "");
    let run = ["diagnose", text(&robot), text(&train), "--validate", text(&judge), "--json"];
    let answer = bipedc(&run).ok().json();
    let found = answer["effects"].as_array().unwrap();
    let tilt = found.iter().find(|one| one["kind"] == "gravity_tilt");
    let tilt = tilt.unwrap_or_else(|| panic!("{}", answer["summary"]));
    assert!((tilt["parameters"]["pitch"].as_f64().unwrap() - 0.05).abs() < 0.003, "{tilt}");
    let [low, high] = [0, 1].map(|k| tilt["ci95"]["roll"][k].as_f64().unwrap());
    assert!(low <= -0.12 && (0.12..0.2).contains(&high), "{tilt}");
    assert!(tilt["doubts"].to_string().contains("does not tell the sign of roll"), "{tilt}");
}
