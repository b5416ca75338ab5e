//! A blow in a log: its samples teach nothing, and that is said.
use crate::cli::{bipedc, scratch, text};
use bipedc_effects::random::Random;
use std::fmt::Write as _;
use std::path::Path;

const URDF: &str = r#"<robot name="arm"><link name="bench"/><link name="arm"><inertial><origin xyz="0 0 -0.2"/>
<mass value="1.5"/><inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="1e-3"/></inertial></link>
<joint name="shoulder" type="revolute"><parent link="bench"/><child link="arm"/><axis xyz="0 1 0"/>
<limit lower="-3" upper="3" effort="50" velocity="20"/></joint></robot>"#;
/// Mass times distance of its centre (kg m), and inertia about the axis (kg m²).
const MOMENT: f64 = 1.5 * 0.2;
const INERTIA: f64 = 0.02 + 1.5 * 0.2 * 0.2;
/// Dry friction, N m.
const FRICTION: f64 = 0.15;

/// Twenty seconds of two sines at 250 Hz; at `blow` (s) a hammer turns the joint by 0.05 rad and back within some 50 ms, of which the
/// drive's sensor feels nothing but its own ringing.
fn log(path: &Path, rates: [f64; 2], blow: Option<f64>, seed: u64) {
    let mut random = Random::new(seed);
    let mut csv = "time,shoulder/position,shoulder/effort\n".to_owned();
    for sample in 0..5000 {
        let time = f64::from(sample) / 250.0;
        let [q, v, a] = [0.6, 0.4].into_iter().zip(rates).fold([0.0; 3], |[q, v, a], (size, rate)| {
            let (sin, cos) = (rate * time).sin_cos();
            [q + size * sin, v + size * rate * cos, a - size * rate * rate * sin]
        });
        let since = blow.map_or(f64::INFINITY, |blow| time - blow);
        let turned = 0.05 * (-(since / 0.02).powi(2)).exp();
        let rings = if (0.0..1.0).contains(&since) {
            40.0 * (-since / 0.03).exp() * (200.0 * since).sin()
        } else {
            0.0
        };
        let torque = INERTIA * a + 9.81 * MOMENT * (q + turned).sin() + FRICTION * v.signum() + rings;
        writeln!(csv, "{time:.3},{:.9},{:.9}", q + turned, torque + 0.01 * random.normal()).unwrap();
    }
    std::fs::write(path, csv).unwrap();
}

#[test]
fn a_blow_is_left_out_and_hides_nothing() {
    let folder = scratch("shaken");
    std::fs::write(folder.join("robot.urdf"), URDF).unwrap();
    std::fs::write(folder.join("biped.toml"), "[base]\nkind = \"fixed\"\n").unwrap();
    let [train, judge] = ["train.csv", "judge.csv"].map(|file| folder.join(file));
    log(&train, [2.9, 5.3], Some(13.0), 1);
    log(&judge, [2.3, 6.7], None, 2);
    let answer = bipedc(&["diagnose", text(&folder), text(&train), "--validate", text(&judge), "--json"]);
    let answer = answer.ok().json();
    let effects = answer["effects"].as_array().unwrap();
    assert_eq!(effects.len(), 1, "{}", answer["summary"]);
    assert_eq!(effects[0]["kind"], "coulomb_friction");
    let found = effects[0]["parameters"]["torque"].as_f64().unwrap();
    assert!((found - FRICTION).abs() < 0.03 * FRICTION, "{found} N m");
    assert_eq!(answer["unexplained"], false, "{}", answer["summary"]);
    let said = |assumptions: &serde_json::Value| {
        let list = assumptions.as_array().unwrap().iter().filter_map(|said| said.as_str());
        list.filter(|said| said.contains("`shoulder` is shaken near 12.9")).count()
    };
    assert_eq!(said(&answer["assumptions"]), 1, "{}", answer["assumptions"]);
    let compared = bipedc(&["compare", text(&folder), text(&train), "--json"]).ok().json();
    assert_eq!(said(&compared["assumptions"]), 1, "{}", compared["assumptions"]);
    let quiet = bipedc(&["compare", text(&folder), text(&judge), "--json"]).ok().json();
    assert_eq!(said(&quiet["assumptions"]), 0, "{}", quiet["assumptions"]);
}
