//! Which effects make sense at which places of a log with joint torques.
use crate::measure::recording::Recording;
use crate::robot::JointLayout;
use crate::robot::link_inertias::LinkInertias;
use bipedc_effects::effect::Location;

/// Kinds that are tried at every joint with an effort.
const AT_JOINTS: [&str; 13] = [
    "viscous_friction",
    "coulomb_friction",
    "asymmetric_coulomb_friction",
    "stribeck_friction",
    "load_dependent_friction",
    "rotor_inertia",
    "parallel_spring",
    "torque_gain",
    "torque_bias",
    "torque_saturation",
    "torque_ripple",
    "actuator_delay",
    "encoder_offset",
];

/// Kinds that are tried on every link with a mass.
const ON_LINKS: [&str; 3] = ["payload", "com_offset", "inertia_error"];

/// All candidates that the recording could show.
pub(super) fn candidates(
    subject: &JointLayout,
    recording: &Recording,
    link_inertias: &LinkInertias,
    moved_links: &[bool],
) -> Vec<(&'static str, Location)> {
    let mut list = Vec::new();
    let with_effort = |joint: usize| recording.effort[joint].is_some();
    for (j, joint) in subject.joints.iter().enumerate().filter(|(j, _)| with_effort(*j)) {
        list.extend(AT_JOINTS.map(|kind| (kind, Location::joint(&joint.name))));
        for (_, other) in subject.joints.iter().enumerate().filter(|(k, _)| *k != j) {
            list.push(("coupling", Location::pair(&joint.name, &other.name)));
        }
    }
    for (j, joint) in subject.joints.iter().enumerate() {
        if recording.transmission[j].is_some() {
            list.push(("backlash", Location::joint(&joint.name)));
            list.push(("series_elasticity", Location::joint(&joint.name)));
        }
    }
    for link in link_inertias.links.iter().filter(|l| l.mass > 0.0 && moved_links[l.body]) {
        list.extend(ON_LINKS.map(|kind| (kind, Location::link(&link.name))));
    }
    list.push(("gravity_tilt", Location::default()));
    list
}
