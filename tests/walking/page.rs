//! `docs/walking.md` is true: it lists every number, and every column of a plan.
use bipedc_analysis::walking::Settings;

const PAGE: &str = include_str!("../../docs/walking.md");

#[test]
fn the_page_has_every_number_with_its_unit_and_meaning() {
    for (name, unit, _, meaning) in Settings::KEYS {
        let row = PAGE.lines().find(|line| line.starts_with(&format!("| `{name}` |")));
        let row = row.unwrap_or_else(|| panic!("no row of `{name}`"));
        assert!(row.contains(&format!("| {unit} |")) && row.contains(meaning), "{row}: {meaning}");
    }
}

#[test]
fn the_page_has_every_column_of_a_plan() {
    let robot = bipedc::Robot::read("robots/tulip".as_ref()).unwrap_or_else(|e| panic!("{e}"));
    let path = bipedc::walking::Path::Forward(None, 1);
    let stated = Default::default();
    let options = bipedc::walking::Options { method: bipedc::walking::Method::Static, path, stated };
    let run = bipedc::progress::Run { progress: &bipedc::progress::Silent, stop: &|| false };
    let plan = bipedc::walking::plan(&robot, &options, &run).unwrap_or_else(|e| panic!("{e}"));
    for column in plan.columns() {
        let general = column.replace("right_foot", "<foot>").replace("left_foot", "<foot>");
        let joint = general
            .split_once('/')
            .filter(|(of, _)| of.ends_with("_pitch") || of.ends_with("_roll") || of.ends_with("_yaw"));
        let name = joint.map_or(general.clone(), |(_, what)| format!("<joint>/{what}"));
        let family = name.rsplit_once('/').map_or(name.as_str(), |(family, _)| family);
        assert!(
            PAGE.contains(&format!("`{name}`")) || PAGE.contains(&format!("`{family}/x`")),
            "{column}: {name}"
        );
    }
}
