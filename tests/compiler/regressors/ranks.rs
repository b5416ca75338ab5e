//! The ranks of the regressors of the thesis' robot (5.4) and of a second one.
use crate::compiler::regressors::support::{answer, on_foot, robot};
use bipedc_compiler::exact::{Model, ParameterList, Question};

fn ranks_of_both(name: &str) {
    let robot = robot(name);
    let rank = |question: Question| answer(&robot, &question).rank;
    let com = |rows, flat| rank(on_foot(Model::CenterOfMass, rows, flat));
    assert_eq!(
        [com("x y z", false), com("x y", false), com("x y", true), com("x y z", true)],
        [27, 26, 25, 26]
    );
    let zmp = |rows, flat| rank(on_foot(Model::ZeroMomentPoint, rows, flat));
    assert_eq!([zmp("Mx My Fz", false), zmp("Mx My", false)], [85, 84]);
    assert_eq!([zmp("Mx My Fz", true), zmp("Mx My", true)], [81, 80]);
    assert_eq!(zmp("Fx Fy Fz Mx My Mz", false), 85);
}

#[test]
fn tulip_standing() {
    ranks_of_both("tulip");
}

#[test]
fn biped_3d_standing() {
    ranks_of_both("biped_3d");
}

#[test]
fn tulip_equations_of_motion() {
    let tulip = robot("tulip");
    let rows = |rows: &[&str]| rows.iter().map(|row| (*row).to_owned()).collect::<Vec<_>>();
    let dynamics = Question::new(Model::Dynamics);
    assert_eq!(answer(&tulip, &dynamics).rank, 94);
    assert_eq!(answer(&tulip, &Question { root: Some("right_foot".into()), ..dynamics.clone() }).rank, 94);
    assert_eq!(answer(&tulip, &Question { rows: rows(&["joints"]), ..dynamics.clone() }).rank, 84);
    let bolted = Question { fixed: Some(true), ..dynamics };
    assert_eq!(answer(&tulip, &bolted).rank, 72);
    let energy = Question::new(Model::Energy);
    assert_eq!(answer(&tulip, &energy).rank, 94);
    assert_eq!(answer(&tulip, &Question { root: Some("right_foot".into()), ..energy }).rank, 94);
}

#[test]
fn the_thesis_parameter_lists_have_the_same_rank() {
    let tulip = robot("tulip");
    let sixteen = |rows| {
        let question = on_foot(Model::ZeroMomentPoint, rows, false);
        answer(&tulip, &Question { list: Some(ParameterList::Thesis16), ..question })
    };
    let with_force = sixteen("Mx My Fz");
    assert_eq!((with_force.columns.len(), with_force.appearing(), with_force.rank), (208, 190, 85));
    let moments = sixteen("Mx My");
    assert_eq!((moments.appearing(), moments.rank), (189, 84));
    let mut gone: Vec<&str> = moments.unidentifiable.iter().map(String::as_str).collect();
    gone.retain(|name| name.starts_with("right_ankle"));
    let listed = ["Iyy_com", "Izz_com", "Iyz_com", "m*cx*cx", "m*cy*cz"];
    assert_eq!(gone, listed.map(|name| format!("right_ankle.{name}")));
}

#[test]
fn centre_of_mass_groups_read_as_in_the_thesis() {
    let found = answer(&robot("tulip"), &on_foot(Model::CenterOfMass, "x y", true));
    let texts: Vec<&str> = found.parameters.iter().map(|parameter| parameter.text.as_str()).collect();
    assert!(texts.contains(&"left_upper_leg.m*cz - 0.315 (left_lower_leg + left_ankle + left_foot).m"));
    assert_eq!(found.unidentifiable, ["right_foot.m", "right_foot.m*cz", "left_foot.m*cz"]);
    assert!(found.parameters.iter().flat_map(|p| &p.combination).all(|term| term.exact.is_some()));
    assert!(found.to_string().starts_with("25 base parameters of 52 columns (exact)"));
    let json = serde_json::to_value(&found).unwrap();
    assert_eq!(json["parameters"][24]["unit"], "kg m");
}
