//! Which functions a description asks for.
use super::catalogue::{Entry, Scope, catalogue, entry_and_subject};
use super::{FunctionRequest, Solvable, identifier};
use crate::derive::effects::JointLaws;
use crate::derive::relabel::Relabelling;
use crate::description::model::RobotDescription;
use crate::tree::{BaseKind, Tree};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::spelling::suggest;
use std::collections::HashSet;

/// Everything that `biped.toml` asks for; by default all functions, those of frames for the feet, their contact points and the
/// frames that `[generate] frames` names, without feet for the links at the ends of the tree.
///
/// # Errors
/// Functions, frames and phases that there are not.
pub fn requested_functions(
    description: &RobotDescription,
    tree: &Tree,
) -> Result<Vec<FunctionRequest>, Diagnostic> {
    let asked = Asked::new(description, tree)?;
    let laws = JointLaws::new(tree, description)?;
    let solvable = Solvable::new(description, tree, &laws);
    let mut out = Vec::new();
    for entry in catalogue() {
        // On a base that is not free the torques do not tell all of the robot's mass distribution.
        let told = !description.generate.runtime_parameters
            || tree.base == BaseKind::Floating
            || !entry.needs_whole_robot();
        if !told {
            continue;
        }
        // Whoever names a function is told why it cannot be had; by default it is left out.
        let possible = |subject: &Option<String>| {
            let refused = || solvable.refusal(entry.name, subject.as_deref()).is_some();
            !asked.everything || !(laws.refusal(entry.name).is_some() || refused())
        };
        let subjects = asked.subjects(entry, description, tree).into_iter().filter(possible);
        out.extend(subjects.map(|subject| FunctionRequest { family: entry.name.to_owned(), subject }));
    }
    Ok(out)
}

/// What the description names, found in catalogue and robot.
struct Asked {
    /// Nothing is named: everything but what is on demand.
    everything: bool,
    /// Names of the catalogue, and of what each is about where that is said.
    named: Vec<(&'static str, Option<String>)>,
    /// Frames that every function of frames is about.
    frames: Vec<String>,
}

impl Asked {
    fn new(description: &RobotDescription, tree: &Tree) -> Result<Self, Diagnostic> {
        let generate = &description.generate;
        let named = generate.functions.iter().map(|name| find(name, description, tree));
        let mut frames = default_frames(description, tree);
        for name in &generate.frames {
            let frame = tree.frame(name).ok_or_else(|| no_frame(name, name, tree))?;
            frames.push(frame.name.clone());
        }
        let mut seen = HashSet::new();
        frames.retain(|frame| seen.insert(frame.clone()));
        Ok(Self {
            everything: generate.functions.is_empty(),
            named: named.collect::<Result<_, _>>()?,
            frames,
        })
    }

    /// What functions of this entry are wanted of, `None` for the whole robot.
    fn subjects(&self, entry: &Entry, description: &RobotDescription, tree: &Tree) -> Vec<Option<String>> {
        let of_entry = || self.named.iter().filter(|(name, _)| *name == entry.name);
        let whole = if self.everything { !entry.on_demand } else { of_entry().any(|(_, of)| of.is_none()) };
        let mut subjects = match whole {
            true => self.default_subjects(entry.scope, description, tree),
            false => Vec::new(),
        };
        for (_, subject) in of_entry() {
            if subject.is_some() && !subjects.contains(subject) {
                subjects.push(subject.clone());
            }
        }
        subjects
    }

    fn default_subjects(
        &self,
        scope: Scope,
        description: &RobotDescription,
        tree: &Tree,
    ) -> Vec<Option<String>> {
        let robot = |there: bool| if there { vec![None] } else { Vec::new() };
        match scope {
            Scope::Robot => robot(true),
            Scope::Frame => self.frames.iter().cloned().map(Some).collect(),
            Scope::Contacts => robot(!tree.points.is_empty()),
            Scope::Drives => robot(!description.drives.is_empty()),
            Scope::Phase => description.phases.iter().map(|phase| Some(phase.name.clone())).collect(),
            Scope::Relabelling => {
                let asked = description.phases.iter().any(|phase| phase.relabel);
                robot(asked && Relabelling::new(tree, description).is_ok())
            }
            Scope::Impact => {
                // On a pinned root the impact of the other foot cannot be told: the root would stay pinned.
                let free = matches!(tree.base, BaseKind::Floating | BaseKind::Planar);
                let impacts = description.phases.iter().filter(|phase| free && !phase.impact.is_empty());
                impacts.map(|phase| Some(phase.name.clone())).collect()
            }
        }
    }
}

impl FunctionRequest {
    /// By a name such as `mass_matrix`, `jacobian_of_tool` or `impact_map_of_single_support`.
    ///
    /// # Errors
    /// There is no such function, link, contact point or phase.
    pub fn named(name: &str, description: &RobotDescription, tree: &Tree) -> Result<Self, Diagnostic> {
        let (family, subject) = find(name, description, tree)?;
        Ok(Self { family: family.to_owned(), subject })
    }
}

/// A name of the catalogue, or one with what it is about: `jacobian_of_tool`, `impact_map_of_single_support`.
fn find(
    name: &str,
    description: &RobotDescription,
    tree: &Tree,
) -> Result<(&'static str, Option<String>), Diagnostic> {
    let (family, subject) = entry_and_subject(name)?;
    let Some(subject) = subject else { return Ok((family.name, None)) };
    let names: Vec<&str> = match family.scope {
        Scope::Frame => tree.links.iter().chain(&tree.points).map(|frame| frame.name.as_str()).collect(),
        _ => description.phases.iter().map(|phase| phase.name.as_str()).collect(),
    };
    let exact = names.iter().find(|known| **known == subject);
    let same = exact.or_else(|| names.iter().find(|known| identifier(known) == identifier(subject)));
    match same {
        Some(known) => Ok((family.name, Some((*known).to_owned()))),
        None if family.scope == Scope::Frame => Err(no_frame(name, subject, tree)),
        None => {
            let what = format!("`{name}`: no phase `{subject}`");
            let known = || format!("phases are: {}", names.join(", "));
            Err(Diagnostic::error(what).help(suggest(subject, names.iter().copied(), known)))
        }
    }
}

fn no_frame(asked: &str, name: &str, tree: &Tree) -> Diagnostic {
    let names: Vec<&str> = tree.links.iter().chain(&tree.points).map(|frame| frame.name.as_str()).collect();
    let known = || format!("links and contact points are: {}", names.join(", "));
    let help = suggest(name, names.iter().copied(), known);
    Diagnostic::error(format!("`{asked}`: there is no link or contact point `{name}`")).help(help)
}

/// Feet and their points; without feet the links at the ends of the tree.
fn default_frames(description: &RobotDescription, tree: &Tree) -> Vec<String> {
    let mut frames: Vec<String> = description.feet.iter().map(|foot| foot.link.clone()).collect();
    if frames.is_empty() {
        let carries = |link: &str| description.joints.iter().any(|joint| joint.parent == link);
        let ends = tree.links.iter().filter(|link| link.body.is_some() && !carries(&link.name));
        frames = ends.map(|link| link.name.clone()).collect();
    }
    frames.sort_unstable();
    frames.dedup();
    frames.extend(tree.points.iter().map(|point| point.name.clone()));
    frames
}
