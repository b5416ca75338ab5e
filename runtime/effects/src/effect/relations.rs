//! What kinds have to do with each other.
use super::kind::{Kind, Law};

/// What a kind has to do with others, by their names.
#[derive(Debug)]
pub struct Relations {
    /// Special cases of it: it explains whatever these explain.
    pub contains: &'static [&'static str],
    /// Kinds that, at the same place, differ from it only in what neither is about: the moment of reversal, a constant.
    pub resembles: &'static [&'static str],
    /// Two kinds that, at the same place, are nearly it together.
    pub sum_of: Option<[&'static str; 2]>,
    /// What is estimated beside it without being reported, and where that starts.
    pub nuisance: Option<(&'static str, &'static [(&'static str, f64)])>,
    /// Whether two of them at one place are more than one with other numbers.
    pub repeats: bool,
}

impl Relations {
    /// Nothing to do with any other.
    pub const NONE: Self =
        Self { contains: &[], resembles: &[], sum_of: None, nuisance: None, repeats: false };
}

impl Kind {
    /// Whether the other one is a special case of it.
    pub fn contains(&self, other: &Self) -> bool {
        self.relations.contains.contains(&other.name)
    }

    /// The motion that tells it from the other one, if that is a confounder.
    pub fn told_from(&self, other: &Self) -> Option<&'static str> {
        self.confounders.iter().find(|confounder| confounder.kind == other.name).map(|c| c.experiment)
    }

    /// The measurement that tells the two apart, as either of them says; bodies that are others than described are weighed.
    pub fn told_apart_by(&self, other: &Self) -> Option<&'static str> {
        let corrected = || [self, other].into_iter().find(|kind| kind.law == Law::InertialCorrection);
        let told = self.told_from(other).or_else(|| other.told_from(self));
        told.or_else(|| corrected().map(|kind| kind.experiment))
    }

    /// What is estimated beside it without being reported, and where that starts.
    pub fn nuisance(&self) -> Option<(&'static Self, &'static [(&'static str, f64)])> {
        let (name, start) = self.relations.nuisance?;
        Some((super::kind(name)?, start))
    }

    /// Whether the two together, at one place, are nearly it.
    pub fn is_sum_of(&self, a: &Self, b: &Self) -> bool {
        self.relations.sum_of.is_some_and(|names| names == [a.name, b.name] || names == [b.name, a.name])
    }

    /// Whether the two differ, at one place, only in what neither is about.
    pub fn resembles(&self, other: &Self) -> bool {
        self.relations.resembles.contains(&other.name) || other.relations.resembles.contains(&self.name)
    }
}
