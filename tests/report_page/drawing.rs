//! The drawing's joints against the derived positions of the links that they carry.
use bipedc::film::poses;
use bipedc::report::drawing::drawing;
use bipedc_compiler::Robot;
use bipedc_compiler::compile::{FunctionRequest, ProgramModel};
use bipedc_compiler::description::model::JointKind;
use bipedc_compiler::tree::BaseKind;
use bipedc_runtime::{Argument, Model, State};
use std::path::Path;

#[test]
#[ignore = "in a browser"]
fn joints_are_where_the_derived_positions_say() {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    for name in ["biped_3d", "five_link", "seven_link", "three_link", "tulip", "tulip_v1_leg"] {
        let robot = Robot::read(&robots.join(name)).unwrap();
        let tree = robot.tree().unwrap();
        let moving = robot.description.joints.iter().filter(|joint| joint.kind != JointKind::Fixed);
        let children: Vec<String> = moving.map(|joint| joint.child.clone()).collect();
        let request =
            |child: &String| FunctionRequest { family: "position".to_owned(), subject: Some(child.clone()) };
        let compiled = robot.compile_only(&children.iter().map(request).collect::<Vec<_>>()).unwrap();
        let model = ProgramModel::new(compiled);
        let angles: Vec<f64> = (0..tree.joints.len()).map(|j| (1.7 * j as f64 + 0.4).sin()).collect();
        let base = tree.nq - angles.len();
        let mut q = vec![0.0; base];
        if tree.base == BaseKind::Floating {
            q[6] = 1.0;
        }
        q.extend(&angles);
        let drawn = drawing(&robot.description, &tree, &angles);
        assert_eq!(drawn.joints.len(), children.len(), "{name}");
        for (function, joint) in drawn.joints.iter().enumerate() {
            let mut position = [0.0; 3];
            model.evaluate(function, &State::new().with(Argument::Q, &q), &mut position).unwrap();
            for (a, b) in position.iter().zip(joint.position) {
                assert!((a - b).abs() < 1e-12, "{name} {}: {position:?} {:?}", joint.name, joint.position);
            }
            let length = joint.axis.iter().map(|x| x * x).sum::<f64>();
            assert!((length - 1.0).abs() < 1e-12);
            assert!(joint.parent.is_none_or(|parent| parent < drawn.joints.len()));
        }
        let heaviest = drawn.bones.iter().map(|bone| bone.mass).fold(0.0, f64::max);
        let links = robot.description.links.iter().filter_map(|link| link.inertial.as_ref());
        assert!(heaviest > 0.0 && heaviest < links.map(|inertial| inertial.mass).sum(), "{name}");
        let soles: Vec<_> = drawn.hulls.iter().filter(|hull| hull.name != "base").collect();
        assert_eq!(soles.len(), robot.description.feet.len(), "{name}");
    }
}

/// Poses of whole configurations, turned bases among them: every link's frame against its derived position and
/// orientation.
#[test]
#[ignore = "in a browser"]
fn poses_are_what_the_derived_functions_say() {
    let robots = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots");
    for (name, kind) in
        [("tulip", "floating"), ("biped_3d", "floating"), ("seven_link", "planar"), ("five_link", "fixed")]
    {
        let robot = Robot::read(&robots.join(name)).unwrap().with_base(kind, None).unwrap();
        let tree = robot.tree().unwrap();
        let moving: Vec<_> = tree.links.iter().filter(|link| link.body.is_some()).collect();
        let request = |family: &str| {
            let family = family.to_owned();
            moving
                .iter()
                .map(move |link| FunctionRequest { family: family.clone(), subject: Some(link.name.clone()) })
        };
        let requests: Vec<FunctionRequest> = request("position").chain(request("rotation")).collect();
        let model = ProgramModel::new(robot.compile_only(&requests).unwrap());
        let mut q: Vec<f64> = (0..tree.nq).map(|i| (1.7 * i as f64 + 0.4).sin()).collect();
        if tree.base == BaseKind::Floating {
            let length = q[3..7].iter().map(|x| x * x).sum::<f64>().sqrt();
            q[3..7].iter_mut().for_each(|x| *x /= length);
        }
        let poses = poses(&tree, &q);
        let state = State::new().with(Argument::Q, &q);
        for (index, link) in moving.iter().enumerate() {
            let (mut position, mut rotation) = ([0.0; 3], [0.0; 9]);
            model.evaluate(index, &state, &mut position).unwrap();
            model.evaluate(moving.len() + index, &state, &mut rotation).unwrap();
            let pose = poses[link.body.unwrap()];
            for axis in [None, Some(0), Some(1), Some(2)] {
                let mut point = [0.0; 3];
                axis.into_iter().for_each(|axis: usize| point[axis] = 1.0);
                let inner = link.placement.then(&bipedc_compiler::tree::Placement::shift(point)).translation;
                // Columns one after the other.
                let expected =
                    [0, 1, 2].map(|i| position[i] + axis.map_or(0.0, |axis| rotation[3 * axis + i]));
                let got = pose.at(inner);
                for (a, b) in got.iter().zip(expected) {
                    assert!((a - b).abs() < 1e-12, "{name} {}: {got:?} {expected:?}", link.name);
                }
            }
        }
    }
}
