//! Robots and questions for the tests of base parameters.
#![allow(dead_code, reason = "each test file uses a part")]
use bipedc_compiler::description::{self, model::RobotDescription};
use bipedc_compiler::exact::{BaseParameters, Model, Question};
use bipedc_effects::random::Random;
use std::fmt::Write as _;
use std::path::Path;

/// A robot of the repository.
pub fn robot(name: &str) -> RobotDescription {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name);
    description::read(&path).unwrap_or_else(|errors| panic!("{errors:?}")).0
}

/// A robot given by its URDF alone.
pub fn from_urdf(urdf: &str) -> RobotDescription {
    let name = Path::new("test.urdf");
    description::parse(urdf, name, "", name).unwrap_or_else(|errors| panic!("{errors:?}\n{urdf}")).0
}

/// A question in which the right foot stands on the ground.
pub fn on_foot(of: Model, rows: &str, feet_flat: bool) -> Question {
    let rows = rows.split_whitespace().map(str::to_owned).collect();
    Question { rows, feet_flat, root: Some("right_foot".to_owned()), ..Question::new(of) }
}

/// The answer, which must be quick.
pub fn answer(robot: &RobotDescription, question: &Question) -> BaseParameters {
    let start = std::time::Instant::now();
    let answer = question.answer(robot).unwrap_or_else(|e| panic!("{e:?}"));
    assert!(start.elapsed().as_secs() < 20, "{question:?} took {:?}", start.elapsed());
    answer
}

/// Joints of a random tree.
pub struct Kinds {
    /// Number of turning joints.
    pub revolute: usize,
    /// Number of sliding joints.
    pub prismatic: usize,
    /// Axes and angles are arbitrary instead of right.
    pub odd: bool,
}

/// The URDF of a random tree.
pub fn random_urdf(random: &mut Random, kinds: &Kinds) -> String {
    let mut urdf = String::from("<robot name=\"random\">\n");
    let joints = kinds.revolute + kinds.prismatic;
    for link in 0..=joints {
        let [x, y, z] = [0, 1, 2].map(|_| 0.1 * random.symmetric());
        let _ = writeln!(
            urdf,
            "<link name=\"l{link}\"><inertial><origin xyz=\"{x:.4} {y:.4} {z:.4}\"/><mass value=\"1.5\"/>\
             <inertia ixx=\"0.02\" ixy=\"0.001\" ixz=\"0.002\" iyy=\"0.03\" iyz=\"-0.001\" izz=\"0.025\"/>\
             </inertial></link>"
        );
    }
    for joint in 0..joints {
        let kind = if joint < kinds.revolute { "continuous" } else { "prismatic" };
        let parent = random.bits() as usize % (joint + 1);
        let mut number = || random.symmetric();
        let [x, y, z] = [number(), number(), number()].map(|x| 0.3 * x);
        let (rpy, axis) = if kinds.odd {
            ([number(), number(), number()], [number(), number(), 1.0])
        } else {
            let mut axis = [0.0; 3];
            axis[(number().abs() * 3.0) as usize % 3] = 1.0;
            ([0.0, 0.0, std::f64::consts::FRAC_PI_2], axis)
        };
        let text = |x: [f64; 3]| format!("{} {} {}", x[0], x[1], x[2]);
        let _ = writeln!(
            urdf,
            "<joint name=\"j{joint}\" type=\"{kind}\"><parent link=\"l{parent}\"/><child link=\"l{}\"/>\
             <origin xyz=\"{x:.3} {y:.3} {z:.3}\" rpy=\"{}\"/><axis xyz=\"{}\"/>\
             <limit lower=\"-1\" upper=\"1\" effort=\"1\" velocity=\"1\"/></joint>",
            joint + 1,
            text(rpy),
            text(axis)
        );
    }
    urdf + "</robot>\n"
}
