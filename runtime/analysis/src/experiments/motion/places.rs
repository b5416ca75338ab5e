//! Which effects make sense at which places of a log with joint torques.
use crate::measure::recording::Recording;
use crate::robot::JointLayout;
use crate::robot::link_inertias::LinkInertias;
use bipedc_effects::effect::{Acts, Evidence, Kind, Location, Place, sought};

/// All candidates that the recording could show.
pub(super) fn candidates(
    layout: &JointLayout,
    recording: &Recording,
    link_inertias: &LinkInertias,
    moved_links: &[bool],
) -> Vec<(&'static Kind, Location)> {
    let mut list = Vec::new();
    let at = |place: Place| sought(Evidence::Motion).filter(move |kind| kind.place == place);
    let between = |kind: &&'static Kind| kind.law.acts() == Acts::Transmission;
    let with_effort = |joint: usize| recording.effort[joint].is_some();
    for (j, joint) in layout.joints.iter().enumerate().filter(|(j, _)| with_effort(*j)) {
        let here = Location::joint(&joint.name);
        list.extend(at(Place::Joint).filter(|kind| !between(kind)).map(|kind| (kind, here.clone())));
        for (_, other) in layout.joints.iter().enumerate().filter(|(k, _)| *k != j) {
            list.extend(at(Place::JointPair).map(|kind| (kind, Location::pair(&joint.name, &other.name))));
        }
    }
    for (j, joint) in layout.joints.iter().enumerate() {
        if recording.transmission[j].is_some() {
            list.extend(at(Place::Joint).filter(between).map(|kind| (kind, Location::joint(&joint.name))));
        }
    }
    for link in link_inertias.links.iter().filter(|l| l.mass > 0.0 && moved_links[l.body]) {
        list.extend(at(Place::Link).map(|kind| (kind, Location::link(&link.name))));
    }
    list.extend(at(Place::Robot).map(|kind| (kind, Location::default())));
    list
}
