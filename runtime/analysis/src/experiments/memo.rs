//! What was computed last for lists of effects.
//!
//! An estimate moves one parameter at a time, and most of them leave alone what costs most: where the links are, what the rigid model
//! needs there, what the ground does.
use bipedc_effects::effect::Effect;
use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};

/// So many are kept: of the present estimate, of a neighbour, for each of the processors that estimate at a time.
const KEPT: usize = 6;
/// At most so many numbers in all (64 MB), or one result.
const ROOM: usize = 1 << 23;

/// The last results of a function of effects, oldest first.
pub(crate) struct Memo<V> {
    kept: usize,
    recent: Mutex<VecDeque<(Vec<Effect>, Arc<V>)>>,
}

impl<V> Memo<V> {
    /// Of results of this many numbers.
    pub fn new(numbers: usize) -> Self {
        Self { kept: (ROOM / numbers.max(1)).clamp(1, KEPT), recent: Mutex::default() }
    }

    /// The result for those of the effects that `matter`; made outside of the lock, so that several processors work at a time.
    pub fn of(
        &self,
        effects: &[Effect],
        matter: impl Fn(&Effect) -> bool,
        make: impl FnOnce() -> V,
    ) -> Arc<V> {
        let is_it = |known: &[Effect]| effects.iter().filter(|effect| matter(effect)).eq(known);
        let locked = || self.recent.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, value)) = locked().iter().rev().find(|(known, _)| is_it(known)) {
            return value.clone();
        }
        let value = Arc::new(make());
        let key = effects.iter().filter(|effect| matter(effect)).cloned().collect();
        let mut recent = locked();
        if recent.len() == self.kept {
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
        let (memo, mut made) = (Memo::new(1), 0);
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

    #[test]
    fn of_large_results_the_last_is_kept() {
        let memo = Memo::new(ROOM);
        let asked = |torque: f64, value: u8| *memo.of(&[friction(torque)], |_| true, || value);
        assert_eq!([asked(1.0, 1), asked(1.0, 2), asked(2.0, 3), asked(1.0, 4)], [1, 1, 3, 4]);
    }
}
