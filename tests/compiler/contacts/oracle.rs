//! Contact points, constrained dynamics and impacts against Pinocchio's numbers.
use super::support::*;
use bipedc_compiler::derive::constrained::constrained_dynamics;
use bipedc_compiler::derive::constraint::Constraints;
use bipedc_compiler::derive::contact::contact_points;
use bipedc_compiler::derive::impact::impact_map;
use bipedc_compiler::description::model::{Contact, RobotDescription};
use bipedc_compiler::tree::Tree;
use bipedc_runtime::Argument::{Q, Tau, V};
use flate2::read::GzDecoder;
use serde_json::Value;

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

struct Oracle {
    json: Value,
    joints: Vec<usize>,
}

impl Oracle {
    fn read(file: &str, tree: &Tree) -> Self {
        let path = project().join(format!("tests/data/oracle/{file}.json.gz"));
        let json: Value =
            serde_json::from_reader(GzDecoder::new(std::fs::File::open(path).unwrap())).unwrap();
        let names: Vec<&str> =
            json["joints"].as_array().unwrap().iter().map(|x| x.as_str().unwrap()).collect();
        let at = |name: &String| names.iter().position(|n| n == name).unwrap();
        let joints = tree.joints.iter().map(|joint| at(&joint.name)).collect();
        Self { json, joints }
    }
    /// In our order of joints.
    fn ordered(&self, value: &Value) -> Vec<f64> {
        let x = numbers(value);
        let base = x.len() - self.joints.len();
        (0..base).chain(self.joints.iter().map(|k| base + k)).map(|k| x[k]).collect()
    }
    fn cases(&self) -> &[Value] {
        self.json["cases"].as_array().unwrap()
    }
}

fn all_robots() -> Vec<(String, RobotDescription, Tree)> {
    let mut out = Vec::new();
    for name in ROBOTS {
        let description = robot(name);
        let kind = if name == "tulip_v1_leg" { "fixed" } else { "floating" };
        out.push((name.to_owned(), description.clone(), tree(&description, kind)));
        if PLANAR.contains(&name) {
            out.push((format!("{name}_planar"), description.clone(), tree(&description, "planar")));
        }
    }
    out
}

#[test]
fn contact_points_agree() {
    let mut worst = Worst::default();
    for (file, description, tree) in all_robots() {
        let oracle = Oracle::read(&file, &tree);
        let function = Function::derive(&tree, |model| {
            let c = contact_points(model);
            let flat = |rows: Vec<Vec<_>>| rows.into_iter().flatten().collect::<Vec<_>>();
            let (n, t) = (flat(c.normal_directions), flat(c.tangential_directions));
            vec![c.normal, c.tangential, n, t, c.normal_rate, c.tangential_rate]
        });
        let tangents = if file.ends_with("planar") { 1 } else { 2 };
        let names: Vec<String> = description
            .feet
            .iter()
            .flat_map(|f| f.points.iter().map(move |p| format!("{}/{}", f.link, p.name)))
            .collect();
        for case in oracle.cases() {
            let (q, v) = (oracle.ordered(&case["q"]), oracle.ordered(&case["v"]));
            let out = function.call(&[(Q, &q), (V, &v)]);
            let (normal, tangential) = (rows(&out[2], names.len()), rows(&out[3], tangents * names.len()));
            for (k, name) in names.iter().enumerate() {
                let frame = &case["frames"][name];
                let position = numbers(&frame["position"]);
                let rate = numbers(&frame["jacobian_rate_times_velocity"]);
                let jacobian: Vec<Vec<f64>> =
                    frame["jacobian"].as_array().unwrap().iter().map(|row| oracle.ordered(row)).collect();
                worst.note("distance", &out[0][k..=k], &position[2..3]);
                worst.note("rate w_N", &out[4][k..=k], &rate[2..3]);
                let column: Vec<f64> = normal.iter().map(|row| row[k]).collect();
                worst.note("W_N", &column, &jacobian[2]);
                for axis in 0..tangents {
                    let at = tangents * k + axis;
                    let column: Vec<f64> = tangential.iter().map(|row| row[at]).collect();
                    worst.note("tangential position", &out[1][at..=at], &position[axis..=axis]);
                    worst.note("rate w_T", &out[5][at..=at], &rate[axis..=axis]);
                    worst.note("W_T", &column, &jacobian[axis]);
                }
            }
        }
    }
    worst.check(1e-12);
}

/// J, w, accelerations, λ, velocity after the impact, impulses.
fn phase_function(tree: &Tree, description: &RobotDescription, contacts: &[Contact]) -> (Function, usize) {
    let mut n = 0;
    let function = Function::derive(tree, |model| {
        let c = Constraints::new(model, &description.feet, contacts).unwrap();
        let dynamics = constrained_dynamics(model, &c);
        let impact = impact_map(model, &c);
        n = c.len();
        let jacobian = c.jacobian.iter().flatten().copied().collect();
        vec![jacobian, c.rate, dynamics.acceleration, dynamics.forces, impact.velocity, impact.impulse]
    });
    (function, n)
}

#[test]
fn constrained_dynamics_and_impacts_agree() {
    let mut worst = Worst::default();
    let mut sets = 0;
    for (file, description, tree) in all_robots() {
        let oracle = Oracle::read(&file, &tree);
        let count = oracle.cases()[0]["contact"].as_array().unwrap().len();
        for set in 0..count {
            let names = oracle.cases()[0]["contact"][set]["contacts"].as_array().unwrap();
            let contacts: Vec<Contact> =
                names.iter().map(|name| contact(&description.feet, name.as_str().unwrap())).collect();
            let (function, n) = phase_function(&tree, &description, &contacts);
            for case in oracle.cases() {
                compare(&mut worst, &oracle, case, &case["contact"][set], &function, (&tree, n));
                sets += 1;
            }
        }
    }
    println!("{sets} contact sets");
    assert!(sets > 100);
    worst.check(1e-10);
}

fn compare(
    worst: &mut Worst,
    oracle: &Oracle,
    case: &Value,
    expected: &Value,
    function: &Function,
    (tree, n): (&Tree, usize),
) {
    let q = oracle.ordered(&case["q"]);
    let tau = oracle.ordered(&case["generalized_effort"]);
    let rows_of: Vec<Vec<f64>> =
        expected["rows"].as_array().unwrap().iter().map(|row| oracle.ordered(row)).collect();
    assert_eq!(n, rows_of.len(), "{}", expected["contacts"]);
    let generalised = |multipliers: &Value| transposed_times(&rows_of, &numbers(multipliers), tree.nv);
    let ours = |out: &[Vec<f64>], k: usize| transposed_times(&rows(&out[0], tree.nv), &out[k], tree.nv);

    let impact = &expected["impact"];
    let before = function.call(&[(Q, &q), (V, &oracle.ordered(&case["v"])), (Tau, &tau)]);
    worst.note("velocity after the impact", &before[4], &oracle.ordered(&impact["v_after"]));
    worst.note("generalised impulse", &ours(&before, 5), &generalised(&impact["impulses"]));

    // Only where the velocity satisfies the constraints is the acceleration independent of the rows chosen.
    let dynamics = &expected["dynamics_after_impact"];
    let after = function.call(&[(Q, &q), (V, &oracle.ordered(&dynamics["v"])), (Tau, &tau)]);
    worst.note("acceleration", &after[2], &oracle.ordered(&dynamics["acceleration"]));
    worst.note("generalised contact force", &ours(&after, 3), &generalised(&dynamics["multipliers"]));
    worst.note(
        "J a + w",
        &times(&rows(&after[0], tree.nv), &after[2]),
        &after[1].iter().map(|w| -w).collect::<Vec<_>>(),
    );
}
