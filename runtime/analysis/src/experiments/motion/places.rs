//! Which effects make sense at which places of a log with joint torques.
use crate::measure::recording::Recording;
use crate::robot::link_inertias::LinkInertias;
use crate::robot::{Joint, JointLayout};
use bipedc_effects::effect::{Acts, Evidence, Kind, Location, Place, sought};
use std::f64::consts::TAU;

/// A joint whose speed (root mean square) is below this part of the fastest one's hardly moves: what it does goes with the load of
/// others, it is no cause.
const HARDLY: f64 = 0.02;
/// So does one that is not faster than so many times what the encoder's noise makes of its speed: the steps of a joint that is held and yields.
const TOLD: f64 = 2.0;
/// Noise of accelerations is that of speeds times this part of the filter's circular frequency.
const OF_CUTOFF: f64 = 0.7;

/// Joints that move, each compared with the fastest of its sort and with its noise.
fn moving(layout: &JointLayout, recording: &Recording) -> Vec<bool> {
    let square = |joint: usize| recording.trajectory.velocities(joint).map(|v| v * v).sum::<f64>();
    let squares: Vec<f64> = (0..layout.joints.len()).map(square).collect();
    let fastest = |prismatic: bool| {
        let same = layout.joints.iter().zip(&squares).filter(|(joint, _)| joint.prismatic == prismatic);
        same.map(|(_, square)| *square).fold(0.0, f64::max)
    };
    let frequency = OF_CUTOFF * TAU * recording.cutoff_hz;
    let noise = |joint: usize| recording.acceleration_noise.get(joint).map_or(0.0, |noise| noise / frequency);
    let samples = recording.trajectory.len() as f64;
    let moves = |(index, joint): (usize, &Joint)| {
        let square = squares[index];
        square > HARDLY.powi(2) * fastest(joint.prismatic) && square > samples * (TOLD * noise(index)).powi(2)
    };
    layout.joints.iter().enumerate().map(moves).collect()
}

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
    let moving = moving(layout, recording);
    let with_effort = |joint: usize| recording.effort[joint].is_some();
    for (j, joint) in layout.joints.iter().enumerate().filter(|(j, _)| with_effort(*j)) {
        let here = Location::joint(&joint.name);
        list.extend(at(Place::Joint).filter(|kind| !between(kind)).map(|kind| (kind, here.clone())));
        for (_, other) in layout.joints.iter().enumerate().filter(|(k, _)| *k != j && moving[*k]) {
            list.extend(at(Place::JointPair).map(|kind| (kind, Location::pair(&joint.name, &other.name))));
        }
    }
    for (j, joint) in layout.joints.iter().enumerate() {
        if recording.transmission[j].is_some() {
            list.extend(at(Place::Joint).filter(between).map(|kind| (kind, Location::joint(&joint.name))));
        }
    }
    // Behind a motor that alone is measured springs and play show in its torque.
    for (j, joint) in layout.joints.iter().enumerate().filter(|(j, _)| with_effort(*j)) {
        if recording.motor_side.get(j).is_some_and(|alone| *alone) {
            list.extend(at(Place::Joint).filter(between).map(|kind| (kind, Location::joint(&joint.name))));
        }
    }
    // Of links that are bolted to each other the heaviest first: where they tell the same, it is named.
    let mut links: Vec<_> =
        link_inertias.links.iter().filter(|l| l.mass > 0.0 && moved_links[l.body]).collect();
    links.sort_by(|a, b| a.body.cmp(&b.body).then(b.mass.total_cmp(&a.mass)));
    for link in links {
        list.extend(at(Place::Link).map(|kind| (kind, Location::link(&link.name))));
    }
    list.extend(at(Place::Robot).map(|kind| (kind, Location::default())));
    list
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{BaseKind, Trajectory};

    #[test]
    fn a_joint_that_hardly_moves_is_no_cause() {
        let joints = ["hip", "knee", "yaw"].map(Joint::revolute).to_vec();
        let layout = JointLayout { joints, base: BaseKind::Fixed };
        let mut trajectory = Trajectory::new(&layout);
        for i in 0..100 {
            let (sine, cosine) = (0.1 * f64::from(i)).sin_cos();
            trajectory.extend([
                &[sine, cosine, 0.005 * sine],
                &[cosine, -sine, 0.005 * cosine],
                &[-sine, -cosine, -0.005 * sine],
            ]);
        }
        let recording = Recording {
            trajectory,
            effort: vec![Some(vec![0.0; 100]); 3],
            transmission: vec![None; 3],
            cutoff_hz: 10.0,
            ..Recording::default()
        };
        // The knee's encoder is so coarse that its noise is 0.6 of its speed.
        let noisy = Recording { acceleration_noise: vec![0.1, 20.0, 0.1], ..recording.clone() };
        assert_eq!(moving(&layout, &noisy), [true, false, false]);
        let links = LinkInertias::default();
        let others: Vec<String> = candidates(&layout, &recording, &links, &[])
            .into_iter()
            .filter(|(kind, _)| kind.place == Place::JointPair)
            .map(|(_, place)| format!("{place}"))
            .collect();
        assert!(!others.is_empty());
        assert_eq!(moving(&layout, &recording), [true, true, false]);
        assert!(others.iter().all(|place| !place.ends_with("yaw")), "{others:?}");
    }
}
