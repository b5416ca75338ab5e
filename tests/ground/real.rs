//! A real humanoid that walks (`../shared/data/icub_walking`); the data are read in place, without them it says so.
use crate::ground::cli::{bipedc, scratch, text};
use crate::ground::support::project;
use std::fmt::Write as _;

/// Known: 0.84 kg or a vertical gain of 2.5 %, equally good; a tilt of 5.6° and 2.1° or a horizontal bias of -31.6 and
/// 11.9 N, equally good on forces.
#[test]
#[ignore = "takes long"]
fn a_humanoid_whose_ground_forces_have_several_explanations() {
    let data = project().join("../shared/data/icub_walking");
    if !data.join("icub_walking.csv").exists() {
        println!("skipped: {} is not there", data.display());
        return;
    }
    let folder = scratch("icub");
    std::fs::copy(data.join("iCubGenova04.urdf"), folder.join("robot.urdf")).unwrap();
    let (mut description, mut mapping) =
        ("[base]\nkind = \"floating\"\nroot = \"root_link\"\n".to_owned(), String::new());
    for foot in ["l_sole", "r_sole"] {
        let _ = writeln!(description, "[feet.{foot}]\nlink = \"{foot}\"");
        for (end, x) in [("front", 0.12), ("rear", -0.07)] {
            for (side, y) in [("left", 0.045), ("right", -0.045)] {
                let _ = writeln!(description, "points.{end}_{side} = [{x}, {y}, 0.0]");
            }
        }
        for what in ["force", "torque"] {
            let _ = writeln!(mapping, "\"{foot}/{what}\" = {{ frame = \"sole\" }}");
        }
    }
    std::fs::write(folder.join("biped.toml"), description).unwrap();
    std::fs::write(folder.join("icub.toml"), mapping).unwrap();
    let (log, map) = (data.join("icub_walking.csv"), folder.join("icub.toml"));
    let run = bipedc(&[
        "identify",
        text(&folder),
        text(&log),
        "--method",
        "zmp",
        "--mapping",
        text(&map),
        "--cutoff",
        "3",
        "--to",
        "45",
        "--json",
    ]);
    let answer = run.ok().json();
    let ground = &answer["ground"];
    let mass = ground["mass"]["value"].as_f64().unwrap();
    println!("mass {mass} ± {} of {}", ground["mass"]["standard_error"], ground["mass"]["described"]);
    println!("centre {}", ground["center_of_mass"]);
    for channel in answer["channels"].as_array().unwrap() {
        println!("{channel}");
    }
    let causes = ground["confounded"]["causes"].as_array().unwrap();
    causes.iter().for_each(|cause| println!("{cause}"));
    println!("{}", ground["confounded"]["pairs"]);
    assert!((mass - 33.077 - 0.84).abs() < 0.2, "{mass}");
    let name = |k: &serde_json::Value| {
        let cause = &causes[k.as_u64().unwrap() as usize];
        format!("{} {}", cause["kind"].as_str().unwrap(), cause["parameter"].as_str().unwrap())
    };
    let named = |key: &str, a: &str, b: &str| {
        let pairs = ground["confounded"][key].as_array().unwrap().iter();
        let pairs: Vec<[String; 2]> = pairs.map(|p| [name(&p["causes"][0]), name(&p["causes"][1])]).collect();
        println!("{key}: {pairs:?}");
        pairs.iter().any(|p| p.contains(&a.to_owned()) && p.contains(&b.to_owned()))
    };
    assert!(named("pairs", "payload mass", "force_sensor_gain gain"));
    assert!(named("pairs_in_forces", "gravity_tilt pitch", "force_sensor_bias x"));
}
