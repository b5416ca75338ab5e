//! Effects that make the robot another rigid body: masses, inertias and the direction of gravity.
//!
//! They are applied to the description before the tree is built: exact, and without an operation more.
use super::placement::matrix_vector;
use crate::description::model::{Inertial, Link, Pose, RobotDescription};
use crate::tree::{Inertia, Rotation};
use bipedc_effects::effect::{Acts, Effect, Law};
use std::borrow::Cow;

/// The robot with the masses, inertias and gravity that it truly has.
pub fn as_built(description: &RobotDescription) -> Cow<'_, RobotDescription> {
    let changes = |effect: &Effect| matches!(effect.kind.law.acts(), Acts::Body | Acts::Gravity);
    if !description.effects.iter().any(changes) {
        return Cow::Borrowed(description);
    }
    let mut built = description.clone();
    for effect in description.effects.iter().filter(|effect| changes(effect)) {
        if effect.kind.law.acts() == Acts::Gravity {
            built.gravity = tilted(built.gravity, effect);
        }
    }
    for link in &mut built.links {
        let here = |effect: &&Effect| effect.location.link.as_ref() == Some(&link.name);
        let effects: Vec<&Effect> = description.effects.iter().filter(changes_body).filter(here).collect();
        match effects.as_slice() {
            [] => {}
            [one] => change(link, one),
            several => change_all(link, several),
        }
    }
    Cow::Owned(built)
}

fn changes_body(effect: &&Effect) -> bool {
    effect.kind.law.acts() == Acts::Body
}

/// Every effect changes the link of the URDF, not what the ones before it made of that: changes of mass, first and second
/// moments add up, in any order.
fn change_all(link: &mut Link, effects: &[&Effect]) {
    let of = |link: &Link| link.inertial.as_ref().map_or_else(Inertia::default, Inertia::from_inertial);
    let nominal = of(link);
    let total = effects.iter().fold(nominal, |total, effect| {
        let mut changed = link.clone();
        change(&mut changed, effect);
        total.plus(&of(&changed)).less(&nominal)
    });
    link.inertial = about_center(&total).or(link.inertial);
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
            let point = Inertial { mass, origin: Pose { xyz: three, rpy: [0.0; 3] }, inertia: [0.0; 6] };
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
            if let Some(inertial) = &mut link.inertial {
                add_inertia(inertial, effect);
            }
        }
        Law::InertialCorrection => {
            // A link without mass has its first body from here.
            let nothing = Pose { xyz: [0.0; 3], rpy: [0.0; 3] };
            let inertial =
                link.inertial.get_or_insert(Inertial { mass: 0.0, origin: nothing, inertia: [0.0; 6] });
            add_inertia(inertial, effect);
            inertial.mass += effect.value("mass");
            for (x, shift) in inertial.origin.xyz.iter_mut().zip(three) {
                *x += shift;
            }
        }
        // `as_built` picks those that act in bodies.
        other => debug_assert!(other.acts() != Acts::Body, "{effect} does not change the link"),
    }
}

/// Adds the six components of an effect to the inertia about the centre of mass, in the link's axes.
fn add_inertia(inertial: &mut Inertial, effect: &Effect) {
    let error = ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|name| effect.value(name));
    *inertial = in_link_axes(inertial);
    for (x, error) in inertial.inertia.iter_mut().zip(error) {
        *x += error;
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
    about_center(&Inertia::from_inertial(a).plus(&Inertia::from_inertial(b))).unwrap_or(*a)
}

/// Mass, centre of mass and inertia about it; none without mass.
fn about_center(sum: &Inertia) -> Option<Inertial> {
    if sum.mass == 0.0 {
        return None;
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
    let origin = Pose { xyz: center, rpy: [0.0; 3] };
    Some(Inertial { mass: sum.mass, origin, inertia: six(about) })
}
