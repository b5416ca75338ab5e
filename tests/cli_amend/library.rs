//! `bipedc effects`: the library of effects, and the help of the commands around it.
use super::{read, robot};
use crate::cli::{bipedc, text};

#[test]
fn the_library_is_listed() {
    let all = bipedc(&["effects"]).ok();
    for words in ["coulomb_friction", "damping (N m s/rad)", "impact_restitution", "formula"] {
        assert!(all.out.contains(words), "no `{words}` in {}", all.out);
    }
    let one = bipedc(&["effects", "coulomb_friction"]).ok();
    for words in ["torque * sign(velocity)", "viscous_friction", "follows the sign", "[[effect]]", "0 to 30"]
    {
        assert!(one.out.contains(words), "no `{words}` in {}", one.out);
    }
    bipedc(&["effects", "coulom_friction"]).fails_with(&["did you mean `coulomb_friction`?"]);
    let list = bipedc(&["effects", "--json"]).ok().json();
    assert!(list.as_array().unwrap().len() > 30);
    for kind in list.as_array().unwrap() {
        for key in ["kind", "title", "place", "meaning", "law", "symptom", "experiment", "example"] {
            assert!(kind[key].is_string(), "{key} of {kind}");
        }
        assert!(kind["parameters"].is_array() && kind["confounders"].is_array());
    }
}

/// Every example of the library, put into a description, reads.
#[test]
#[ignore = "takes long"]
fn examples_of_all_kinds_read() {
    let folder = robot("effects_examples");
    let before = read(&folder, "biped.toml");
    for kind in bipedc(&["effects", "--json"]).ok().json().as_array().unwrap() {
        let toml = format!("{before}\n{}", kind["example"].as_str().unwrap());
        std::fs::write(folder.join("biped.toml"), toml).unwrap();
        let run = bipedc(&["history", text(&folder)]).ok();
        assert!(run.out.contains("never amended"));
        let run = bipedc(&["check", text(&folder), "--json"]);
        assert_eq!(run.code, Some(0), "{}: {}", kind["kind"], run.err);
        assert!(!run.err.contains("is unusual"), "{}: {}", kind["kind"], run.err);
    }
}

#[test]
fn help_teaches_with_examples() {
    for name in ["amend", "history", "effects"] {
        let run = bipedc(&[name, "--help"]).ok();
        assert!(run.out.contains("Examples:") && run.out.contains(&format!("bipedc {name}")), "{}", run.out);
    }
}
