//! Searches at one speed: after the first each asks for a little more where the walk under the controller lacked something, or begins elsewhere where none was found.
use super::closed_loop::Tried;
use super::lack::Lack;
use super::optimised::{Asked, OptimisedGait, described};
use super::search::{Beginning, FirstGuess, is_found};
use super::{Workbench, library};
use crate::gait::optimise::{
    Demands, Optimum, gait_text, impulse_that_lands, lands_by_posture, least_distance, size,
};
use crate::simulation::Trial;
use bipedc_effects::diagnostic::Diagnostics;
use std::time::Instant;

/// Motions that are tried at one speed at most. Searches that find none end by themselves: there are so many beginnings and nodes.
const ROUNDS: usize = 6;

/// What is known after some searches.
struct Rounds<'a> {
    bench: &'a Workbench,
    asked: &'a Asked<'a>,
    trial: &'a Trial,
    index: usize,
    /// What the walk is to keep.
    wished: Demands,
    /// What the next search asks for.
    demands: Demands,
    /// Where the next search begins.
    near: Option<Optimum>,
    guess: FirstGuess,
    /// What lacks least.
    best: Option<(Lack, OptimisedGait, Optimum)>,
    beginnings: Vec<Beginning>,
    /// Motions of other beginnings that cost more, the cheapest last: tried where that does not walk which costs least.
    others: Vec<(usize, Optimum)>,
    /// Searches.
    count: usize,
    /// Of these, those that found a motion.
    tried: usize,
    iterations: usize,
    search_seconds: f64,
}

/// What comes after a search.
enum Next {
    Another,
    Nothing,
    Stopped,
}

impl Workbench {
    /// Searches and tries, and asks for more where the controller's walk lacks something; none: stopped.
    pub(super) fn found_from(
        &self,
        asked: &Asked<'_>,
        trial: &Trial,
        index: usize,
        near: Option<&Optimum>,
    ) -> Result<Option<(OptimisedGait, Optimum)>, Diagnostics> {
        let begin = Instant::now();
        let wished = asked.options.wishes.demands(asked.options.speeds[index], size(asked.of));
        let mut rounds = Rounds {
            bench: self,
            asked,
            trial,
            index,
            demands: wished.with_reserve(),
            wished: Demands { joint: least_distance(asked.of, wished.joint), ..wished },
            near: near.cloned(),
            guess: FirstGuess::Straight(0..asked.beginnings()),
            best: None,
            beginnings: Vec::new(),
            others: Vec::new(),
            count: 0,
            tried: 0,
            iterations: 0,
            search_seconds: 0.0,
        };
        while rounds.tried < ROUNDS {
            match rounds.next(begin)? {
                Next::Another => {}
                Next::Nothing => break,
                Next::Stopped => return Ok(None),
            }
        }
        let Rounds { wished, best, beginnings, count, iterations, search_seconds, .. } = rounds;
        let seconds = begin.elapsed().as_secs_f64();
        Ok(best.map(|(lack, gait, optimum)| {
            let lacking = if gait.feasible { lack.names() } else { Vec::new() };
            let of_all = OptimisedGait {
                impulse: wished.impulse,
                beginnings,
                rounds: count,
                iterations,
                seconds,
                search_seconds,
                lacking,
                ..gait
            };
            (of_all, optimum)
        }))
    }
}

impl Rounds<'_> {
    fn next(&mut self, begin: Instant) -> Result<Next, Diagnostics> {
        let searched = self.bench.search(self.asked, &self.demands, self.near.as_ref(), &self.guess)?;
        if (self.bench.stop)() {
            return Ok(Next::Stopped);
        }
        if self.count == 0 {
            self.search_seconds = begin.elapsed().as_secs_f64();
        }
        if !searched.beginnings.is_empty() {
            (self.beginnings, self.others) = (searched.beginnings, searched.others);
        }
        self.count += 1;
        self.iterations += searched.iterations;
        self.tried += usize::from(is_found(&searched.optimum));
        let mut optimum = searched.optimum;
        let mut from = self.beginnings.iter().position(|beginning| beginning.kept).unwrap_or(0);
        loop {
            let gait = described(self.asked.of, &optimum, (self.wished.speed, self.demands.impulse));
            if !gait.feasible {
                return Ok(self.not_found(gait, optimum));
            }
            let next = self.walked(gait, optimum)?;
            if self.near.is_some() {
                self.beginnings.iter_mut().enumerate().for_each(|(k, beginning)| beginning.kept = k == from);
                return Ok(next);
            }
            match self.others.pop() {
                Some(other) if !(self.bench.stop)() => (from, optimum) = other,
                _ => return Ok(next),
            }
        }
    }

    /// Another beginning, or more nodes.
    fn not_found(&mut self, gait: OptimisedGait, optimum: Optimum) -> Next {
        let walks = self.best.as_ref().is_some_and(|(lack, ..)| lack.walks);
        let another = match &self.guess {
            FirstGuess::Straight(_) if self.near.is_some() || !lands_by_posture(self.asked.of) => None,
            FirstGuess::Straight(tried) => Some(tried.end..tried.end + tried.len()),
            FirstGuess::Landing => None,
        };
        let landing = gait.landing.clone();
        let (_, told, _) = self.best.get_or_insert((Lack::everything(), gait, optimum));
        told.landing = landing.or(told.landing.take());
        if walks || another.is_none() && !self.demands.finer() {
            return Next::Nothing;
        }
        self.near = None;
        if let Some(others) = another {
            // What is asked for now is another thing, and so is where it is looked for.
            self.guess = if self.gives_way() { FirstGuess::Straight(others) } else { FirstGuess::Landing };
        }
        Next::Another
    }

    /// Where nobody asked for an impulse and none was found with what is usual, no more of it is asked for than the landing of a toe pushes with in the best posture that is
    /// known; false: it pushes with as much.
    fn gives_way(&mut self) -> bool {
        if self.asked.options.wishes.impulse.is_some() {
            return false;
        }
        let possible = impulse_that_lands(self.asked.of, &self.demands);
        let Some(possible) = possible.filter(|possible| *possible < self.demands.impulse) else {
            return false;
        };
        self.wished.impulse *= possible / self.demands.impulse;
        self.demands.impulse = possible;
        true
    }

    /// A motion as the gait that would be written.
    fn walked(&mut self, gait: OptimisedGait, optimum: Optimum) -> Result<Next, Diagnostics> {
        let (asked, wished) = (self.asked, &self.wished);
        let friction = wished.friction;
        let head = asked.head(self.index);
        let text = gait_text(asked.source, asked.form, asked.of, &optimum, (&head, friction))?;
        let text = library::sealed(&text);
        let it = Tried { file: asked.file, text: &text, of: asked.of, optimum: &optimum, friction };
        let tried = self.bench.progress.stage("walking", || self.bench.tried(self.trial, &it));
        let largest = asked.options.wishes.multiplier;
        let lack = Lack::of((wished, largest), &tried);
        let (walks, met) = (lack.walks, lack.is_met());
        if walks {
            lack.tighten((wished, largest), (&tried, &optimum, asked.of), &mut self.demands);
        }
        self.near = walks.then(|| optimum.clone());
        let gait = OptimisedGait { closed_loop: Some(tried), text: Some(text), ..gait };
        self.keep(lack, gait, optimum);
        Ok(match walks {
            true if met => Next::Nothing,
            false if self.others.is_empty() && !self.demands.finer() => Next::Nothing,
            _ => Next::Another,
        })
    }

    /// The gait that lacks least.
    fn keep(&mut self, lack: Lack, gait: OptimisedGait, optimum: Optimum) {
        if self.best.as_ref().is_none_or(|(best, ..)| lack.is_less_than(best)) {
            self.best = Some((lack, gait, optimum));
        }
    }
}
