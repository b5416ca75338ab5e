//! `bipedc inspect`: tables, formulas, base parameters.
use crate::cli;

use cli::bipedc;

#[test]
fn all_functions_with_their_work() {
    let run = bipedc(&["inspect", "robots/five_link"]).ok();
    for words in ["robot `five_link`: nq 7, nv 7", "total", "position_of_right_foot_point_foot", "kg m²"] {
        assert!(run.out.contains(words), "no `{words}` in {}", run.out);
    }
    // What nobody is given unasked is listed with what it is.
    let (table, more) = run.out.split_once("on demand").unwrap();
    assert!(!table.contains("body_jacobian") && more.contains("body_jacobian "), "{}", run.out);
    bipedc(&["inspect", "robots/five_link", "body_jacobian", "--link", "left_tibia"]).ok();
    let value = bipedc(&["inspect", "robots/five_link", "--json"]).ok().json();
    let functions = value["functions"].as_array().unwrap();
    let mass = functions.iter().find(|f| f["name"] == "mass_matrix").unwrap();
    assert_eq!(mass["shape"], serde_json::json!([7, 7]));
    let o = &mass["operations"];
    let count = |key: &str| o[key].as_u64().unwrap();
    let total = count("additions") + count("multiplications") + 2 * count("fused") + count("divisions");
    assert_eq!(count("total"), total);
}

#[test]
fn small_functions_show_their_formulas() {
    let run = bipedc(&["inspect", "robots/three_link", "gravity"]).ok();
    assert!(run.out.contains("base/z = 343.35\n"), "{}", run.out);
    assert!(run.out.contains("sin(left_hip_pitch)") && run.out.contains("base/pitch (N m)"), "{}", run.out);
    let value = bipedc(&["inspect", "robots/three_link", "gravity", "--json"]).ok().json();
    assert_eq!(value["formulas"][0]["row"], "base/z");
    assert_eq!(value["formulas"][0]["formula"], "343.35");
    assert_eq!(value["row_units"][2], "N m");
}

#[test]
fn frames_are_named() {
    let point = ["inspect", "robots/five_link", "position", "--point", "right_foot/point_foot"];
    assert!(bipedc(&point).ok().out.contains("x (m)"));
    bipedc(&["inspect", "robots/five_link", "position"]).fails_with(&["about one frame", "--link NAME"]);
    bipedc(&["inspect", "robots/five_link", "position", "--link", "tors"])
        .fails_with(&["`tors`", "known are: torso"]);
    bipedc(&["inspect", "robots/five_link", "bias", "--link", "torso"]).fails_with(&["not about one frame"]);
}

#[test]
fn unknown_functions_get_a_suggestion() {
    bipedc(&["inspect", "robots/five_link", "mas_matrix"])
        .fails_with(&["`mas_matrix`", "did you mean `mass_matrix`?"]);
}

#[test]
fn base_parameters_of_the_centre_of_mass() {
    let ask = |rows: &'static str, more: &[&'static str]| {
        let fixed = [
            "inspect",
            "robots/tulip",
            "base-parameters",
            "--of",
            "com",
            "--root",
            "right_foot",
            "--rows",
            rows,
        ];
        bipedc(&[&fixed[..], more].concat()).ok()
    };
    let run = ask("x,y,z", &[]);
    assert!(run.out.starts_with("27 base parameters of 52 columns (exact)"), "{}", run.out);
    assert!(run.out.contains("kg m"), "{}", run.out);
    assert_eq!(ask("x,y", &["--json"]).json()["rank"], 26);
    let value = ask("x,y", &["--feet-flat", "--json"]).json();
    assert_eq!(value["rank"], 25);
    assert_eq!(value["parameters"].as_array().unwrap().len(), 25);
}

#[test]
fn base_parameter_options_belong_together() {
    bipedc(&["inspect", "robots/tulip", "base-parameters"]).fails_with(&["base parameters of what?", "--of"]);
    bipedc(&["inspect", "robots/tulip", "--feet-flat"]).fails_with(&["about base parameters"]);
    let run = bipedc(&["inspect", "robots/tulip", "base-parameters", "--of", "com", "--rows", "w"]);
    run.fails_with(&["no row `w`", "rows are: x, y, z"]);
}

#[test]
fn phases_are_named() {
    let value = bipedc(&["inspect", "robots/five_link", "--json"]).ok().json();
    let functions = value["functions"].as_array().unwrap();
    let of_phase =
        functions.iter().find(|f| f["subject"] == "single_support").expect("a function of a phase");
    let name = of_phase["function"].as_str().unwrap();
    bipedc(&["inspect", "robots/five_link", name, "--phase", "single_support"]).ok();
    bipedc(&["inspect", "robots/five_link", name]).fails_with(&["about one phase", "single_support"]);
    bipedc(&["inspect", "robots/five_link", name, "--link", "torso"]).fails_with(&["not about one frame"]);
}
