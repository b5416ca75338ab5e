//! `excite --postures`: conditions are kept, the search gets better, equal seeds give equal files.
use crate::ground::cli::{Run, bipedc, scratch, text};
use crate::ground::stood::{call, rooted, tulip};
use bipedc::identification::standing::Root;
use bipedc_analysis::polygon::Polygon;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_runtime::nalgebra::{DMatrix, Matrix3, Vector3};
use std::path::Path;

fn excite(out: &Path, more: &[&str]) -> Run {
    bipedc(&[&["excite", "robots/tulip", "--json", "--out", text(out)][..], more].concat())
}

/// Rows of a plan: placement, joints, expected centre of pressure.
fn plan(path: &Path) -> Vec<(usize, Vec<f64>, [f64; 2])> {
    let table = std::fs::read_to_string(path).unwrap();
    let row = |line: &str| {
        let v: Vec<f64> = line.split(',').map(|x| x.parse().unwrap()).collect();
        (v[1] as usize, v[2..14].to_vec(), [v[14], v[15]])
    };
    table.lines().skip(1).map(row).collect()
}

/// Judged with the model's own functions, not with the search's.
#[test]
fn designed_postures_stand_and_tell_more() {
    let folder = scratch("design");
    let (out, svg) = (folder.join("plan.csv"), folder.join("plan.svg"));
    let options = [
        "--postures",
        "20",
        "--placements",
        "4",
        "--starts",
        "1",
        "--evaluations",
        "120",
        "--plot",
        text(&svg),
    ];
    let answer = excite(&out, &options).ok().json();
    let run = &answer["runs"][0];
    let [before, after] = ["before", "after"].map(|k| run[k]["condition_number"].as_f64().unwrap());
    println!("condition number {before} to {after}; {}", answer["least_stability_of_others"]);
    assert!(after < 0.8 * before);
    assert!(std::fs::read_to_string(&svg).unwrap().matches("<circle").count() == 20);

    let rooted = rooted(&tulip(), Root::Link);
    let mut requests = vec![
        FunctionRequest::of_robot("center_of_mass"),
        FunctionRequest::of_robot("center_of_mass_regressor"),
    ];
    for family in ["position", "rotation"] {
        requests.push(FunctionRequest { family: family.to_owned(), subject: Some("left_foot".to_owned()) });
    }
    let model = ProgramModel::new(rooted.robot.compile_only(&requests).unwrap());
    let base = rooted.base(bipedc_compiler::exact::Model::CenterOfMass, &["x", "y"], true).unwrap();
    let leading: Vec<usize> = (0..base.sums.len()).map(|k| base.leading(k).unwrap()).collect();
    let postures = plan(&out);
    let mut stacked = DMatrix::zeros(2 * postures.len(), leading.len());
    for (i, (placement, q, expected)) in postures.iter().enumerate() {
        let foot = Vector3::from_vec(call(&model, "position_of_left_foot", q));
        let turn = Matrix3::from_vec(call(&model, "rotation_of_left_foot", q));
        assert!(foot.z.abs() < 1e-8 && (turn[(2, 2)] - 1.0).abs() < 1e-12, "posture {i}: the sole lies flat");
        let wanted = &answer["placements"][*placement];
        assert!((foot.x - wanted[0].as_f64().unwrap()).abs() < 1e-8);
        let corners = |origin: Vector3<f64>, turn: Matrix3<f64>| -> Vec<[f64; 2]> {
            let corner = |(x, y)| (origin + turn * Vector3::new(x, y, 0.0)).xy().into();
            [(0.15, 0.06), (0.15, -0.06), (-0.09, -0.06), (-0.09, 0.06)].map(corner).to_vec()
        };
        let soles = [corners(Vector3::zeros(), Matrix3::identity()), corners(foot, turn)];
        let [own, other] = soles.each_ref().map(|s| Polygon::hull(s));
        assert!(own.apart(&other).unwrap().distance > 0.02 - 1e-6, "soles are apart");
        let center = call(&model, "center_of_mass", q);
        assert!((center[0] - expected[0]).abs() < 1e-8 && (center[1] - expected[1]).abs() < 1e-8);
        assert!(
            Polygon::hull(&soles.concat()).inside([center[0], center[1]]) > 0.02 - 1e-6,
            "posture {i} stands"
        );
        for (q, joint) in q.iter().zip(&rooted.tree.joints) {
            let described = rooted.robot.description.joints.iter().find(|j| j.name == joint.name).unwrap();
            let (low, high) = described.position_limits.unwrap();
            let unused = 0.025 * (high - low);
            assert!(*q > low + unused - 1e-8 && *q < high - unused + 1e-8, "{}", joint.name);
        }
        let columns = call(&model, "center_of_mass_regressor", q);
        for (c, k) in leading.iter().enumerate() {
            (0..2).for_each(|axis| stacked[(2 * i + axis, c)] = columns[3 * k + axis]);
        }
    }
    let singular = stacked.singular_values();
    assert!(
        (singular.max() / singular.min() / after - 1.0).abs() < 1e-3,
        "{}",
        singular.max() / singular.min()
    );
}

#[test]
fn equal_seeds_give_equal_files() {
    let folder = scratch("design_seeds");
    let file = |name: &str, seed: &str| {
        let out = folder.join(name);
        let options =
            ["--postures", "20", "--placements", "4", "--starts", "1", "--evaluations", "6", "--seed", seed];
        excite(&out, &options).ok();
        std::fs::read(&out).unwrap()
    };
    assert_eq!(file("a.csv", "3"), file("b.csv", "3"));
    assert_ne!(file("a.csv", "3"), file("c.csv", "4"));
}

#[test]
fn what_cannot_be_designed() {
    let folder = scratch("design_refused");
    let out = folder.join("plan.csv");
    let refused = |more: &[&str], words: &[&str]| {
        excite(&out, more).fails_with(words);
        assert!(!out.exists());
    };
    refused(&["--postures", "5"], &["5 postures", "25 parameters", "13"]);
    refused(&["--postures", "20", "--placements", "30"], &["30 placements"]);
    refused(&["--postures", "20", "--stability", "20"], &["--stability", "m"]);
    refused(&["--postures", "20", "--mass-error", "-1"], &["--mass-error"]);
    refused(&["--postures", "20", "--stance", "tail"], &["tail", "right_foot"]);
    refused(
        &["--postures", "13", "--placements", "1", "--stability", "0.3", "--time-limit", "3"],
        &["--stability"],
    );
    bipedc(&["excite", "robots/seven_link", "--postures", "20", "--out", text(&out)])
        .fails_with(&["three dimensions"]);
    bipedc(&["excite", "robots/biped_3d", "--postures", "20", "--out", "/nowhere/plan.csv"])
        .fails_with(&["/nowhere"]);
}
