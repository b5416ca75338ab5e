//! Sets of contacts that a walk may pass where it does not follow the order of its phases.
use super::PhaseSpec;
use bipedc_analysis::simulate::phases::Ending;
use bipedc_compiler::description::model::{Contact, ContactPart, Phase, RobotDescription};

/// Most contact points of a robot whose sets are derived: two feet with heel and toe have 15.
const MOST_POINTS: usize = 4;

/// A phase for each set of contact points, with an impact that holds the same set; none where there are too many.
pub(super) fn sets(description: &RobotDescription) -> Vec<Phase> {
    let points: Vec<(usize, usize)> = (description.feet.iter().enumerate())
        .flat_map(|(foot, of)| (0..of.points.len()).map(move |point| (foot, point)))
        .collect();
    if points.len() > MOST_POINTS || description.feet.iter().any(|foot| foot.points.len() > 2) {
        return Vec::new();
    }
    (1..1_usize << points.len()).map(|set| phase(description, &points, set)).collect()
}

/// `set` has a bit for each point.
fn phase(description: &RobotDescription, points: &[(usize, usize)], set: usize) -> Phase {
    let mut contacts = Vec::new();
    for (index, foot) in description.feet.iter().enumerate() {
        let stands = |&(k, &(of, _)): &(usize, &(usize, usize))| of == index && set >> k & 1 == 1;
        let own: Vec<usize> =
            points.iter().enumerate().filter(stands).map(|(_, (_, point))| *point).collect();
        let part = match own[..] {
            [] => continue,
            [only] => ContactPart::Point(foot.points[only].name.clone()),
            _ => ContactPart::Flat,
        };
        contacts.push(Contact { foot: foot.name.clone(), part });
    }
    let name = format!("contacts_{set}");
    Phase { next: name.clone(), name, impact: contacts.clone(), contacts, relabel: false }
}

/// Sets as the walk takes them: named by their contacts, without an end of their own.
pub(super) fn named(specs: Vec<PhaseSpec>, sets: &[Phase]) -> Vec<PhaseSpec> {
    let words = |contact: &Contact| match &contact.part {
        ContactPart::Flat => contact.foot.clone(),
        ContactPart::Point(part) | ContactPart::Edge(part) => format!("{}/{part}", contact.foot),
    };
    let named = |(spec, set): (PhaseSpec, &Phase)| {
        let name = set.contacts.iter().map(words).collect::<Vec<_>>().join(" + ");
        PhaseSpec { name, ending: Ending::Never, ..spec }
    };
    specs.into_iter().zip(sets).map(named).collect()
}
