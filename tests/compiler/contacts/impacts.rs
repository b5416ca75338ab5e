//! What an impact conserves, and what the exchange of the legs leaves alone.
use super::support::*;
use bipedc_compiler::derive::composite::mass_matrix;
use bipedc_compiler::derive::constraint::Constraints;
use bipedc_compiler::derive::contact::contact_points;
use bipedc_compiler::derive::drive;
use bipedc_compiler::derive::frames::{frame_pose, world_poses};
use bipedc_compiler::derive::impact::{impact_map, impact_map_with};
use bipedc_compiler::derive::momentum::{center_of_mass, kinetic_energy, momentum, potential_energy};
use bipedc_compiler::derive::relabel::Relabelling;
use bipedc_compiler::description::model::{Base, Contact, RobotDescription};
use bipedc_compiler::tree::Tree;
use bipedc_runtime::Argument::{Q, V};

fn kind(name: &str) -> &'static str {
    if PLANAR.contains(&name) { "planar" } else { "floating" }
}

fn walkers() -> impl Iterator<Item = &'static str> {
    ROBOTS.into_iter().filter(|name| *name != "tulip_v1_leg")
}

/// D, J, v⁺, F, then momentum about the origin.
fn impact(tree: &Tree, description: &RobotDescription, contacts: &[Contact]) -> (Function, Function) {
    let map = Function::derive(tree, |model| {
        let c = Constraints::new(model, &description.feet, contacts).unwrap();
        let i = impact_map(model, &c);
        let d = mass_matrix(model).into_iter().flatten().collect();
        vec![d, c.jacobian.into_iter().flatten().collect(), i.velocity, i.impulse]
    });
    let whole = Function::derive(tree, |model| {
        let (m, points) = (momentum(model), contact_points(model));
        let positions = points.tangential.iter().chain(&points.normal).copied().collect();
        vec![m.linear.0.to_vec(), m.angular.0.to_vec(), positions]
    });
    (map, whole)
}

#[test]
fn impacts_change_momentum_by_the_impulse_and_never_add_energy() {
    let mut worst = Worst::default();
    let mut random = Random::new(SEED);
    for name in walkers() {
        let description = robot(name);
        let tree = tree(&description, kind(name));
        for phase in description.phases.iter().filter(|phase| !phase.impact.is_empty()) {
            let (map, _) = impact(&tree, &description, &phase.impact);
            for _ in 0..20 {
                let (q, before) = (random.configuration(&tree), random.vector(tree.nv, 2.0));
                let out = map.call(&[(Q, &q), (V, &before)]);
                let (d, j, after, impulse) =
                    (rows(&out[0], tree.nv), rows(&out[1], tree.nv), &out[2], &out[3]);
                let jump: Vec<f64> = after.iter().zip(&before).map(|(a, b)| a - b).collect();
                let expected = transposed_times(&j, impulse, tree.nv);
                worst.note("D (v+ - v-) = J' F", &times(&d, &jump), &expected);
                worst.note("J v+ = 0", &times(&j, after), &vec![0.0; j.len()]);
                let energy = |v: &[f64]| 0.5 * dot(v, &times(&d, v));
                assert!(energy(after) <= energy(&before) * (1.0 + 1e-12), "{name}");
                // What is lost is the energy of the jump (Carnot's theorem).
                worst.note("energy lost", &[energy(&before) - energy(after)], &[energy(&jump)]);
            }
        }
    }
    worst.check(1e-11);
}

#[test]
fn reflected_rotors_count_in_every_way_of_solving() {
    let mut worst = Worst::default();
    let mut random = Random::new(SEED + 7);
    // The drives of TUlip's first leg on the joints of the same names.
    let drives = robot("tulip_v1_leg").drives;
    let description = robot("tulip");
    let tree = tree(&description, "floating");
    let rotors = drive::reflected_inertia(&tree, &drives);
    assert!(rotors.iter().any(|x| *x > 0.0));
    for contacts in [vec!["right_foot"], vec!["left_foot", "right_foot/rear"], vec!["left_foot/front"]] {
        let contacts: Vec<_> = contacts.iter().map(|text| contact(&description.feet, text)).collect();
        let map = Function::derive(&tree, |model| {
            let c = Constraints::new(model, &description.feet, &contacts).unwrap();
            let i = impact_map_with(model, &c, &rotors);
            let d = drive::mass_matrix(model, &drives).into_iter().flatten().collect();
            vec![d, c.jacobian.into_iter().flatten().collect(), i.velocity, i.impulse]
        });
        for _ in 0..10 {
            let (q, before) = (random.configuration(&tree), random.vector(tree.nv, 2.0));
            let out = map.call(&[(Q, &q), (V, &before)]);
            let (d, j) = (rows(&out[0], tree.nv), rows(&out[1], tree.nv));
            let jump: Vec<f64> = out[2].iter().zip(&before).map(|(a, b)| a - b).collect();
            worst.note("D (v+ - v-) = J' F", &times(&d, &jump), &transposed_times(&j, &out[3], tree.nv));
            worst.note("J v+ = 0", &times(&j, &out[2]), &vec![0.0; j.len()]);
        }
    }
    worst.check(1e-10);
}

#[test]
fn point_impacts_conserve_angular_momentum_about_the_point() {
    let mut worst = Worst::default();
    let mut random = Random::new(SEED + 1);
    for name in walkers() {
        let description = robot(name);
        let tree = tree(&description, kind(name));
        let first = &description.feet[0];
        let touch = contact(&description.feet, &format!("{}/{}", first.name, first.points[0].name));
        let (map, whole) = impact(&tree, &description, &[touch]);
        for _ in 0..20 {
            let (q, before) = (random.configuration(&tree), random.vector(tree.nv, 2.0));
            let out = map.call(&[(Q, &q), (V, &before)]);
            let (m0, m1) = (whole.call(&[(Q, &q), (V, &before)]), whole.call(&[(Q, &q), (V, &out[2])]));
            let n = tree.points.len();
            let p = match kind(name) {
                "planar" => [m0[2][0], 0.0, m0[2][n]],
                _ => [m0[2][0], m0[2][1], m0[2][2 * n]],
            };
            let impulse: Vec<f64> = (0..3).map(|i| m1[0][i] - m0[0][i]).collect();
            let published = if out[3].len() == 2 { vec![out[3][0], 0.0, out[3][1]] } else { out[3].clone() };
            worst.note("momentum change = impulse", &impulse, &published);
            let about_point = |m: &[Vec<f64>]| {
                let shift = cross(p, [m[0][0], m[0][1], m[0][2]]);
                (0..3).map(|i| m[1][i] - shift[i]).collect::<Vec<_>>()
            };
            worst.note("angular momentum about the point", &about_point(&m1), &about_point(&m0));
        }
    }
    worst.check(1e-12);
}

fn relabelled(tree: &Tree, description: &RobotDescription) -> Function {
    let map = Relabelling::new(tree, description).unwrap();
    Function::derive(tree, |model| {
        let q: Vec<_> = (0..model.tree.nq).map(|k| model.input(Q, k)).collect();
        let v: Vec<_> = (0..model.tree.nv).map(|k| model.input(V, k)).collect();
        vec![map.configuration(&q), map.velocity(&v)]
    })
}

/// The robot with its torso's mass in the middle: TUlip's lies 1 mm off.
fn symmetric(name: &str) -> RobotDescription {
    let mut description = robot(name);
    let torso = description.links.iter_mut().find(|link| link.name == "torso").unwrap();
    let inertial = torso.inertial.as_mut().unwrap();
    inertial.origin.xyz[1] = 0.0;
    (inertial.inertia[1], inertial.inertia[4]) = (0.0, 0.0);
    description
}

#[test]
fn relabelling_is_a_mirror() {
    let mut worst = Worst::default();
    let mut random = Random::new(SEED + 2);
    for name in walkers() {
        let description = symmetric(name);
        let tree = tree(&description, kind(name));
        let swap = relabelled(&tree, &description);
        let whole = Function::derive(&tree, |model| {
            let poses = world_poses(model);
            let points = model.tree.points.iter().map(|p| frame_pose(model, &poses, p).position.0);
            let (energy, height) = (kinetic_energy(model), potential_energy(model));
            let com = center_of_mass(model).0.to_vec();
            vec![vec![energy, height], com, points.flatten().collect()]
        });
        for _ in 0..20 {
            let (q, v) = (random.configuration(&tree), random.vector(tree.nv, 2.0));
            let once = swap.call(&[(Q, &q), (V, &v)]);
            let twice = swap.call(&[(Q, &once[0]), (V, &once[1])]);
            worst.note("twice is the identity", &[&twice[0][..], &twice[1]].concat(), &[&q[..], &v].concat());
            let here = whole.call(&[(Q, &q), (V, &v)]);
            let there = whole.call(&[(Q, &once[0]), (V, &once[1])]);
            worst.note("energies", &there[0], &here[0]);
            let mirrored = |x: &[f64]| vec![x[0], -x[1], x[2]];
            worst.note("centre of mass", &there[1], &mirrored(&here[1]));
            let half = here[2].len() / 2;
            for k in (0..half).step_by(3) {
                let partner = half + corner_partner(k / 3, half / 3) * 3;
                worst.note("feet", &there[2][k..k + 3], &mirrored(&here[2][partner..partner + 3]));
            }
        }
    }
    worst.check(1e-12);
}

/// Corners are front_left, front_right, rear_left, rear_right: a mirror exchanges left and right.
fn corner_partner(k: usize, corners: usize) -> usize {
    if corners == 4 { k ^ 1 } else { k }
}

#[test]
fn relabelling_a_pivot_finds_the_pitch_of_the_other_foot() {
    let mut worst = Worst::default();
    let mut random = Random::new(SEED + 3);
    for name in PLANAR {
        let description = robot(name);
        for point in &description.feet[0].points {
            let about = format!("{}/{}", description.feet[0].name, point.name);
            let tree = Tree::new(&description, &Base::Pivot { about }).unwrap();
            let swap = relabelled(&tree, &description);
            let links = [&description.feet[0].link, &description.feet[1].link];
            let pitch = Function::derive(&tree, |model| {
                let poses = world_poses(model);
                let of = |link: &String| frame_pose(model, &poses, model.tree.frame(link).unwrap()).rotation;
                links.iter().map(|link| vec![of(link)[(0, 2)], of(link)[(0, 0)]]).collect()
            });
            for _ in 0..20 {
                let (q, v) = (random.configuration(&tree), random.vector(tree.nv, 2.0));
                let once = swap.call(&[(Q, &q), (V, &v)]);
                let twice = swap.call(&[(Q, &once[0]), (V, &once[1])]);
                worst.note(
                    "twice is the identity",
                    &[&twice[0][..], &twice[1]].concat(),
                    &[&q[..], &v].concat(),
                );
                let (here, there) = (pitch.call(&[(Q, &q)]), pitch.call(&[(Q, &once[0])]));
                worst.note("feet exchange their pitch", &there.concat(), &[&here[1][..], &here[0]].concat());
            }
        }
    }
    worst.check(1e-13);
}

#[test]
fn relabelling_refuses_what_it_cannot_do() {
    let description = robot("biped_3d");
    let refused = |base: Base| {
        let tree = Tree::new(&description, &base).unwrap();
        Relabelling::new(&tree, &description).unwrap_err().to_string()
    };
    let foot = refused(Base::Floating { root: "right_foot".to_owned() });
    assert!(foot.contains("`right_foot`, which belongs to one side"), "{foot}");
    let edge = refused(Base::Pivot { about: "right_foot/front".to_owned() });
    assert!(edge.contains("only if it is planar"), "{edge}");
}
