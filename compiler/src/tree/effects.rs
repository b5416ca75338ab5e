//! Effects that make the robot another rigid body: masses, inertias and the direction of gravity.
//!
//! They are applied to the description before the tree is built: exact, and without an operation more.
use super::placement::matrix_vector;
use crate::description::model::{Inertial, Link, RobotDescription};
use crate::tree::{Inertia, Rotation};
use bipedc_effects::effect::{Acts, Effect, Law};
use std::borrow::Cow;

/// The robot with the masses, inertias and gravity that it truly has.
pub(super) fn truly_built(description: &RobotDescription) -> Cow<'_, RobotDescription> {
    let changes = |effect: &Effect| matches!(effect.kind.law.acts(), Acts::Body | Acts::Gravity);
    if !description.effects.iter().any(changes) {
        return Cow::Borrowed(description);
    }
    let mut built = description.clone();
    for effect in description.effects.iter().filter(|effect| changes(effect)) {
        if effect.kind.law.acts() == Acts::Gravity {
            built.gravity = tilted(built.gravity, effect);
        }
        let of = effect.location.link.as_ref();
        if let Some(link) = built.links.iter_mut().find(|link| Some(&link.name) == of) {
            change(link, effect);
        }
    }
    Cow::Owned(built)
}

/// Gravity in the axes in which the log gives orientations, m/s².
///
/// The true orientation of the base is R = R_y(pitch) R_x(roll) times the logged one. Seen from the logged
/// world, gravity is therefore Rᵀ g.
fn tilted(gravity: [f64; 3], effect: &Effect) -> [f64; 3] {
    let turn = Rotation::from_rpy([effect.value("roll"), effect.value("pitch"), 0.0]);
    matrix_vector(&turn.inverse().matrix(), gravity)
}

fn change(link: &mut Link, effect: &Effect) {
    let three = ["x", "y", "z"].map(|name| effect.value(name));
    match effect.kind.law {
        Law::Payload => {
            let mass = effect.value("mass");
            let point = Inertial {
                mass,
                origin: crate::description::model::Pose { xyz: three, rpy: [0.0; 3] },
                inertia: [0.0; 6],
            };
            link.inertial = Some(match &link.inertial {
                Some(own) => together(own, &point),
                None => point,
            });
        }
        Law::CenterOfMassOffset => {
            if let Some(inertial) = &mut link.inertial {
                for (x, shift) in inertial.origin.xyz.iter_mut().zip(three) {
                    *x += shift;
                }
            }
        }
        Law::InertiaError => {
            let error = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|name| effect.value(name));
            if let Some(inertial) = &mut link.inertial {
                *inertial = in_link_axes(inertial);
                for (x, error) in inertial.inertia.iter_mut().zip(error) {
                    *x += error;
                }
            }
        }
        // `truly_built` picks those that act in bodies.
        other => debug_assert!(other.acts() != Acts::Body, "{effect} does not change the link"),
    }
}

/// Inertia about the centre of mass in the link's axes.
fn in_link_axes(inertial: &Inertial) -> Inertial {
    let mut turned = *inertial;
    turned.origin.xyz = [0.0; 3];
    let about_center = Inertia::from_inertial(&turned).second_moment;
    turned.origin.xyz = inertial.origin.xyz;
    turned.origin.rpy = [0.0; 3];
    turned.inertia = six(about_center);
    turned
}

fn six(m: [[f64; 3]; 3]) -> [f64; 6] {
    [m[0][0], m[0][1], m[0][2], m[1][1], m[1][2], m[2][2]]
}

/// Both masses as one body.
fn together(a: &Inertial, b: &Inertial) -> Inertial {
    let sum = Inertia::from_inertial(a).plus(&Inertia::from_inertial(b));
    if sum.mass == 0.0 {
        return *a;
    }
    let center = sum.first_moment.map(|x| x / sum.mass);
    // About the centre: what a point mass there would have is taken away.
    let square: f64 = center.iter().map(|x| x * x).sum();
    let mut about = sum.second_moment;
    for (r, row) in about.iter_mut().enumerate() {
        for (c, x) in row.iter_mut().enumerate() {
            let diagonal = if r == c { square } else { 0.0 };
            *x -= sum.mass * (diagonal - center[r] * center[c]);
        }
    }
    let origin = crate::description::model::Pose { xyz: center, rpy: [0.0; 3] };
    Inertial { mass: sum.mass, origin, inertia: six(about) }
}
