//! A quadruped that stands on four points and logs nothing but their forces: these act at the points, and tell what the legs do not.
use crate::cli::{bipedc, scratch, text};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// The quadruped of the scoreboard, free in space, with four feet of one point.
fn quadruped(folder: &Path) -> PathBuf {
    let robot = folder.join("robot");
    std::fs::create_dir_all(&robot).unwrap();
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/hidden_effects/robots/quadruped");
    std::fs::copy(root.join("robot.urdf"), robot.join("robot.urdf")).unwrap();
    let mut description = "[base]\nkind = \"floating\"\nroot = \"trunk\"\n".to_owned();
    for (end, side) in legs() {
        let foot = format!("{end}_{side}");
        write!(
            description,
            "[feet.{foot}]\nlink = \"{foot}_lower\"\nside = \"{side}\"\npoints.tip = [0.0, 0.0, -0.2]\n"
        )
        .unwrap();
    }
    std::fs::write(robot.join("biped.toml"), description).unwrap();
    robot
}

fn legs() -> impl Iterator<Item = (&'static str, &'static str)> {
    ["front", "rear"].into_iter().flat_map(|end| ["left", "right"].map(|side| (end, side)))
}

/// All legs bend and stretch alike, thighs with half the angle of calves, so that feet stay where they are.
fn scenario(seed: u32, rate: f64) -> String {
    let mut told = format!(
        "duration = 8.0\nstep = 0.001\nlog_step = 0.004\nseed = {seed}\n[control]\nstiffness = 600.0\ndamping = 8.0\nservo = \"drive\"\n\
         [sensors]\nposition_noise = 2e-5\neffort_noise = 0.02\n\
         [[effect]]\nkind = \"payload\"\nlink = \"trunk\"\nmass = 0.8\nx = 0.05\ny = 0.02\nz = 0.06\n"
    );
    for (end, side) in legs() {
        for (joint, middle, times) in [("thigh", 0.75, 1.0), ("calf", -1.5, -2.0)] {
            let [a, b] = [0.08, 0.05].map(|size| times * size);
            let (f, g) = (0.5 * rate, 0.83 * rate);
            writeln!(
                told,
                "[joint.{end}_{side}_{joint}]\nposition = {middle}\nsines = [[{a}, {f}, 0.0], [{b}, {g}, 1.1]]"
            )
            .unwrap();
        }
    }
    told
}

/// Without torques, centres of pressure and what corners tell.
fn forces_alone(log: &Path) {
    let all = std::fs::read_to_string(log).unwrap();
    let header: Vec<&str> = all.lines().next().unwrap().split(',').collect();
    let is_kept = |name: &str| ["/torque/", "/cop/", "/tip/"].iter().all(|part| !name.contains(part));
    let kept: Vec<usize> = (0..header.len()).filter(|column| is_kept(header[*column])).collect();
    assert!(header.len() > kept.len() + 20);
    let row = |line: &str| {
        let cells: Vec<&str> = line.split(',').collect();
        kept.iter().map(|column| cells[*column]).collect::<Vec<_>>().join(",")
    };
    std::fs::write(log, all.lines().map(row).collect::<Vec<_>>().join("\n")).unwrap();
}

/// Before: "no foot has forces in the log".
#[test]
fn forces_of_points_are_enough() {
    let folder = scratch("point-feet");
    let robot = quadruped(&folder);
    let [train, judge] = [(1, 1.0), (2, 0.8)].map(|(seed, rate)| {
        let [file, log] = ["toml", "csv"].map(|end| folder.join(format!("{seed}.{end}")));
        std::fs::write(&file, scenario(seed, rate)).unwrap();
        bipedc(&["simulate", text(&robot), "--scenario", text(&file), "--out", text(&log)]).ok();
        forces_alone(&log);
        log
    });
    let run = ["diagnose", text(&robot), text(&train), "--validate", text(&judge), "--json"];
    let found = bipedc(&run).ok().json();
    let [effect] = &found["effects"].as_array().unwrap()[..] else { panic!("{}", found["effects"]) };
    assert_eq!([&effect["kind"], &effect["link"]], ["payload", "trunk"]);
    // A trunk that hardly leans tells little of how high it is.
    for (name, value) in [("mass", 0.8), ("x", 0.05), ("y", 0.02)] {
        let told = effect["parameters"][name].as_f64().unwrap();
        assert!((told - value).abs() < 0.02 * value.max(0.1), "{name} {told}");
    }
    assert_eq!(found["unexplained"], false, "{}", found["summary"]);
    let assumed = found["assumptions"].to_string();
    assert!(assumed.contains("with one point") && assumed.contains("rear_right"), "{assumed}");
    assert!(found["rows"]["base/moment/z"].is_object(), "a point carries no moment: all six rows tell");
}
