//! What was computed last for lists of effects.
//!
//! An estimate moves one parameter at a time, and most of them leave alone what costs most: where the links are, what the rigid model
//! needs there, what the ground does.
use bipedc_effects::effect::Effect;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// So many are kept: of the present estimate, of a neighbour, for each of the processors that estimate at a time.
const KEPT: usize = 6;

/// The last results of a function of effects, oldest first.
pub(crate) struct Memo<V>(Mutex<VecDeque<(Vec<Effect>, Arc<V>)>>);

impl<V> Default for Memo<V> {
    fn default() -> Self {
        Self(Mutex::new(VecDeque::new()))
    }
}

impl<V> Memo<V> {
    /// The result for those of the effects that `matter`; made outside of the lock, so that several processors work at a time.
    pub fn of(
        &self,
        effects: &[Effect],
        matter: impl Fn(&Effect) -> bool,
        make: impl FnOnce() -> V,
    ) -> Arc<V> {
        let is_it = |known: &[Effect]| effects.iter().filter(|effect| matter(effect)).eq(known);
        let locked = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, value)) = locked().iter().rev().find(|(known, _)| is_it(known)) {
            return value.clone();
        }
        let value = Arc::new(make());
        let key = effects.iter().filter(|effect| matter(effect)).cloned().collect();
        let mut recent = locked();
        if recent.len() == KEPT {
            recent.pop_front();
        }
        recent.push_back((key, value.clone()));
        value
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::effect::{Location, kinds};

    fn friction(torque: f64) -> Effect {
        Effect::new(&kinds::COULOMB_FRICTION, Location::default(), &[("torque", torque)])
    }

    #[test]
    fn what_matters_is_computed_once_and_what_is_old_again() {
        let (memo, mut made) = (Memo::default(), 0);
        let mut asked = |effects: &[Effect]| {
            let is_large = |effect: &Effect| effect.value("torque") > 1.0;
            *memo.of(effects, is_large, || {
                made += 1;
                made
            })
        };
        assert_eq!(asked(&[friction(2.0)]), 1);
        // What does not matter may be anything.
        assert_eq!(asked(&[friction(0.5), friction(2.0), friction(0.7)]), 1);
        assert_eq!(asked(&[]), 2);
        assert_eq!(asked(&[friction(2.0), friction(2.0)]), 3);
        assert_eq!(asked(&[friction(2.0)]), 1);
        (0..6).for_each(|k| assert_eq!(asked(&[friction(3.0 + f64::from(k))]), 4 + k));
        assert_eq!(asked(&[friction(2.0)]), 10);
    }
}
