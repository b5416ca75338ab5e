//! Walks with forces of feet, of joints whose motors' angles alone are logged.
use super::without_links;
use crate::cli::{bipedc, scratch, text};
use std::path::{Path, PathBuf};

/// TUlip walks ahead.
const WALK: &str = "duration = 10.0
step = 0.001
log_step = 0.005
seed = SEED
[walking]
velocity = [{ time = 0.5, forward = SPEED }]
[sensors]
position_noise = 1e-4
force_noise = 0.3
effort_noise = 0.05
[[effect]]
kind = \"rotor_inertia\"
joint = \"JOINT\"
inertia = 0.02
[[effect]]
kind = \"KIND\"
joint = \"JOINT\"
PARAMETER = VALUE
";

/// What lies between a motor and its link.
#[derive(Clone, Copy)]
struct Between {
    joint: &'static str,
    kind: &'static str,
    parameter: &'static str,
    value: f64,
}

impl Between {
    /// A log of a walk at this speed (m/s) without the link's angle.
    fn walked(&self, folder: &Path, name: &str, speed: &str, seed: &str) -> PathBuf {
        let here = [("JOINT", self.joint), ("KIND", self.kind), ("PARAMETER", self.parameter)];
        let value = self.value.to_string();
        let all = here.into_iter().chain([("VALUE", value.as_str()), ("SPEED", speed), ("SEED", seed)]);
        let scenario = all.fold(WALK.to_owned(), |scenario, (name, value)| scenario.replace(name, value));
        let [file, log] = ["toml", "csv"].map(|end| folder.join(format!("{name}.{end}")));
        std::fs::write(&file, scenario).unwrap();
        bipedc(&["simulate", "robots/tulip", "--scenario", text(&file), "--out", text(&log)]).ok();
        without_links(&log, self.joint);
        log
    }
}

/// The joint was taken to turn as its motor does: play came out as an encoder's offset or as couplings and moved masses.
#[test]
#[ignore = "takes long"]
fn what_lies_behind_a_motor_is_found_in_a_walk() {
    let play = Between { joint: "left_ankle_pitch", kind: "backlash", parameter: "gap", value: 0.0175 };
    let spring = Between {
        joint: "right_ankle_roll",
        kind: "series_elasticity",
        parameter: "stiffness",
        value: 150.0,
    };
    // Its torque is mostly what the motor itself takes, so that it was missed: a lighter motor and other masses stood instead.
    let stiffer = Between { joint: "left_ankle_roll", value: 200.0, ..spring };
    let seeds = [["41", "72"], ["41", "72"], ["302", "303"]];
    for (between, [one, other]) in [play, spring, stiffer].into_iter().zip(seeds) {
        let folder = scratch(&format!("motor_side_walks_{}_{}", between.kind, between.joint));
        let train = between.walked(&folder, "train", "0.2", one);
        let judge = between.walked(&folder, "judge", "0.15", other);
        let logs = ["diagnose", "robots/tulip", text(&train), "--validate", text(&judge), "--json"];
        let found = bipedc(&logs).ok().json();
        let effects = found["effects"].as_array().unwrap();
        assert_eq!(effects.len(), 2, "{effects:#?}");
        let interval = |kind: &str, name: &str| {
            let mut here = effects.iter().filter(|e| e["kind"] == kind && e["joint"] == between.joint);
            let ends = &here.next().unwrap_or_else(|| panic!("no {kind}: {effects:#?}"))["ci95"][name];
            [0, 1].map(|end| ends[end].as_f64().unwrap())
        };
        let [low, high] = interval(between.kind, between.parameter);
        let truth = between.value;
        assert!(low < truth && truth < high && high - low < 0.3 * truth, "{low} to {high}, {truth}");
        // Known to 5 %, and never surer than right by more than 2 %.
        let [low, high] = interval("rotor_inertia", "inertia");
        assert!(0.018 < low && low < 0.0204 && 0.0196 < high && high < 0.022, "{low} to {high} kg m²");
    }
}
