//! Effects that make another rigid body, against that body; shifted encoders and a tilted world.
use super::support::*;
use bipedc_compiler::description::model::{Inertial, Pose, RobotDescription};
use bipedc_compiler::tree::Inertia;
use bipedc_effects::effect::{Effect, Location, kinds};

const FUNCTIONS: [&str; 3] = ["inverse_dynamics", "forward_dynamics", "mass_matrix"];

#[test]
fn masses_and_inertias_are_those_of_the_changed_robot() {
    let base = description("tulip");
    let link = "left_foot";
    let index = base
        .links
        .iter()
        .position(|other| other.name == link)
        .unwrap_or_else(|| panic!("{:?}", base.links.iter().map(|l| &l.name).collect::<Vec<_>>()));
    let three = [("x", 0.02), ("y", -0.03), ("z", 0.05)];
    let payload =
        Effect::new(&kinds::PAYLOAD, Location::link(link), &[("mass", 0.7), three[0], three[1], three[2]]);
    let shift = Effect::new(&kinds::COM_OFFSET, Location::link(link), &three);
    let six = [("ixx", 1e-3), ("ixy", 2e-4), ("ixz", -1e-4), ("iyy", 2e-3), ("iyz", 3e-4), ("izz", 5e-4)];
    let error = Effect::new(&kinds::INERTIA_ERROR, Location::link(link), &six);

    // A payload as a link of its own on a fixed joint.
    let mut loaded = base.clone();
    let mut point = loaded.links[index].clone();
    point.name = "load".to_owned();
    let inertial = point.inertial.as_mut().unwrap();
    (inertial.mass, inertial.inertia, inertial.origin) = (0.7, [0.0; 6], Default::default());
    let mut joint = loaded.joints[0].clone();
    joint.name = "load_joint".to_owned();
    joint.kind = bipedc_compiler::description::model::JointKind::Fixed;
    (joint.parent, joint.child) = (link.to_owned(), "load".to_owned());
    joint.origin =
        bipedc_compiler::description::model::Pose { xyz: [0.02, -0.03, 0.05], rpy: [0.3, 0.2, 0.1] };
    loaded.links.push(point);
    loaded.joints.push(joint);

    let mut shifted = base.clone();
    let inertial = shifted.links[index].inertial.as_mut().unwrap();
    for (x, (_, d)) in inertial.origin.xyz.iter_mut().zip(three) {
        *x += d;
    }
    let mut turned = base.clone();
    let inertial = turned.links[index].inertial.as_mut().unwrap();
    assert_eq!(inertial.origin.rpy, [0.0; 3]);
    for (x, (_, d)) in inertial.inertia.iter_mut().zip(six) {
        *x += d;
    }
    for (effect, other) in [(payload, loaded), (shift, shifted), (error, turned)] {
        let (model, expected) =
            (compiled(&with(&base, std::slice::from_ref(&effect)), &FUNCTIONS), compiled(&other, &FUNCTIONS));
        let values = Values::random(&model, &mut Random(21));
        for name in FUNCTIONS {
            close(
                &call(&model, name, &values),
                &call(&expected, name, &values),
                1e-10,
                &format!("{effect} {name}"),
            );
        }
    }
}

/// All ten parameters at once; beside others on the same link every effect changes the link of the URDF, in any order.
#[test]
fn effects_on_one_link_add_up() {
    let base = description("tulip");
    let link = "left_foot";
    let at = |kind, parameters: &[(&'static str, f64)]| Effect::new(kind, Location::link(link), parameters);
    let shift = [("x", 0.02), ("y", -0.03), ("z", 0.05)];
    let six = [("ixx", 1e-3), ("ixy", 2e-4), ("ixz", -1e-4), ("iyy", 2e-3), ("iyz", 3e-4), ("izz", 5e-4)];
    let ten: Vec<_> = [("mass", 0.3)].into_iter().chain(shift).chain(six).collect();
    let correction = at(&kinds::INERTIAL_CORRECTION, &ten);
    let own = |description: &RobotDescription| {
        let link = description.links.iter().find(|other| other.name == link).unwrap();
        Inertia::from_inertial(link.inertial.as_ref().unwrap())
    };
    let mut corrected = base.clone();
    let inertial = corrected.links.iter_mut().find(|other| other.name == link).unwrap().inertial.as_mut();
    let inertial = inertial.unwrap();
    inertial.mass += 0.3;
    inertial.origin.xyz.iter_mut().zip(shift).for_each(|(x, (_, d))| *x += d);
    inertial.inertia.iter_mut().zip(six).for_each(|(x, (_, d))| *x += d);
    let change = own(&corrected).less(&own(&base));

    let mass = ("mass", 0.7);
    let payload = at(&kinds::PAYLOAD, &[mass, ("x", 0.1), ("y", 0.0), ("z", -0.2)]);
    let mut loaded = own(&base).plus(&change);
    let point = Pose { xyz: [0.1, 0.0, -0.2], rpy: [0.0; 3] };
    loaded = loaded.plus(&Inertia::from_inertial(&Inertial { mass: 0.7, origin: point, inertia: [0.0; 6] }));

    let parameters = |effects: &[Effect]| {
        let model = compiled(&with(&base, effects), &["inverse_dynamics"]);
        let values = Values::random(&model, &mut Random(5));
        call(&model, "inverse_dynamics", &values)
    };
    let expected = |inertia: &Inertia| {
        let mut other = base.clone();
        let link = other.links.iter_mut().find(|other| other.name == link).unwrap();
        let c = inertia.first_moment.map(|x| x / inertia.mass);
        let square: f64 = c.iter().map(|x| x * x).sum();
        let about = |r: usize, k: usize| {
            inertia.second_moment[r][k] - inertia.mass * (if r == k { square } else { 0.0 } - c[r] * c[k])
        };
        let inertia_about = [about(0, 0), about(0, 1), about(0, 2), about(1, 1), about(1, 2), about(2, 2)];
        let origin = Pose { xyz: c, rpy: [0.0; 3] };
        link.inertial = Some(Inertial { mass: inertia.mass, origin, inertia: inertia_about });
        let model = compiled(&other, &["inverse_dynamics"]);
        let values = Values::random(&model, &mut Random(5));
        call(&model, "inverse_dynamics", &values)
    };
    close(&parameters(std::slice::from_ref(&correction)), &expected(&own(&corrected)), 1e-10, "alone");
    let both = [payload.clone(), correction.clone()];
    close(&parameters(&both), &expected(&loaded), 1e-10, "after a payload");
    close(&parameters(&[correction, payload]), &expected(&loaded), 1e-10, "before a payload");
}

/// Quaternions x y z w.
fn times(a: [f64; 4], b: &[f64]) -> [f64; 4] {
    let ([x, y, z, w], [p, q, r, s]) = (a, [b[0], b[1], b[2], b[3]]);
    [
        w * p + x * s + y * r - z * q,
        w * q - x * r + y * s + z * p,
        w * r + x * q - y * p + z * s,
        w * s - x * p - y * q - z * r,
    ]
}

#[test]
fn a_tilted_log_is_an_upright_one_of_a_turned_robot() {
    let base = description("tulip");
    let (roll, pitch) = (0.11f64, -0.07f64);
    let tilt = Effect::new(&kinds::GRAVITY_TILT, Location::default(), &[("roll", roll), ("pitch", pitch)]);
    let (rigid, model) = (compiled(&base, &FUNCTIONS), compiled(&with(&base, &[tilt]), &FUNCTIONS));
    let values = Values::random(&model, &mut Random(23));
    let half = |x: f64| ((x / 2.0).sin(), (x / 2.0).cos());
    let ((sr, cr), (sp, cp)) = (half(roll), half(pitch));
    // R_y(pitch) R_x(roll) before the logged orientation.
    let turn = times([0.0, sp, 0.0, cp], &[sr, 0.0, 0.0, cr]);
    let mut truth = values.clone();
    truth.q[3..7].copy_from_slice(&times(turn, &values.q[3..7]));
    for name in FUNCTIONS {
        close(&call(&model, name, &values), &call(&rigid, name, &truth), 1e-12, name);
    }
    let untilted = call(&rigid, "inverse_dynamics", &values);
    let tilted = call(&model, "inverse_dynamics", &values);
    assert!(untilted.iter().zip(&tilted).any(|(x, y)| (x - y).abs() > 1.0));
}

#[test]
fn logged_positions_lose_their_offset_in_every_function() {
    let base = description("five_link");
    let offset = Effect::new(&kinds::ENCODER_OFFSET, Location::joint("left_knee_pitch"), &[("offset", 0.2)]);
    let functions = [
        "inverse_dynamics",
        "forward_dynamics",
        "coriolis_matrix",
        "center_of_mass",
        "inverse_dynamics_derivatives",
        "inverse_dynamics_regressor",
    ];
    let (rigid, model) = (compiled(&base, &functions), compiled(&with(&base, &[offset]), &functions));
    let values = Values::random(&model, &mut Random(25));
    let mut truth = values.clone();
    truth.q[row(&model, "left_knee_pitch")] -= 0.2;
    for name in functions {
        close(&call(&model, name, &values), &call(&rigid, name, &truth), 1e-12, name);
    }
}
