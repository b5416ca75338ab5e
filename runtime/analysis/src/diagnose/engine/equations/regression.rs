//! The linear regression that a search works on: candidates, normal equations, weights, and what a set of effects costs.
use super::block_equations::{BlockEquations, Spread, block_equations};
use super::candidates::{all_forms, candidates_of};
use super::fit::{Candidate, Corrections, Fit, NormalEquations, Term, TermProducts, errors, fit};
use super::resolution::resolutions;
use crate::experiments::form::{Column, Form, Search};
use crate::experiments::{Channel, Experiment};
use crate::parallel::parallel;
use crate::robot::inertial_parameters::{body_of, parameter_index};
use bipedc_effects::effect::{Effect, Kind, Law, Location};
use std::sync::OnceLock;

/// Blocks of time that a log is cut into.
pub(crate) const BLOCKS: usize = 9;

/// Evidence that an effect must bring beyond its parameters, as a fall of deviance.
const ENTRY: f64 = 15.0;
/// Part of the noise floor's deviance that each parameter has to pay.
const PARAMETER_PENALTY: f64 = 0.005;
/// Evidence that each parameter of an effect on a link must bring.
const INERTIAL: f64 = 4.0;
/// The same for each effect: of equivalent explanations the one with fewer effects is the cheaper one.
const EFFECT_PENALTY: f64 = 0.02;

/// What is left of a row whose squared error is below so many times the noise's variance is not worth a word.
pub(crate) const NOISE_MARGIN: f64 = 1.6;
/// Candidates with the normal equations of their columns, and how errors weigh.
pub(crate) struct Regression<'a> {
    pub train: &'a dyn Experiment,
    /// The data that judge; the training data's own blocks if there are no others.
    pub judge: &'a dyn Experiment,
    pub own_blocks: bool,
    pub spread: Spread,
    pub candidates: Vec<Candidate>,
    equations: Vec<BlockEquations>,
    judge_equations: Option<Vec<BlockEquations>>,
    pub train_sums: NormalEquations,
    pub judge_sums: NormalEquations,
    pub judge_blocks: Vec<usize>,
    /// One over the noise floor's variance and correlation, per row.
    pub weights: Vec<f64>,
    /// Deviance of the noise floor on the judging data, per row.
    pub floor_deviance: Vec<f64>,
    /// Variance of the noise floor and how many samples tell the same, per row.
    pub(crate) noise_floors: Vec<(f64, f64)>,
    pub corrections: Option<Corrections>,
    /// Products of each candidate's terms with all else, formed when first asked for.
    pub products: Vec<OnceLock<Vec<TermProducts>>>,
    /// Root mean squares below which errors say nothing, by row.
    pub resolutions: Vec<f64>,
    /// Sum of squares per row below which errors are the measurement's noise, however small they become.
    pub(crate) noise_squares: Vec<f64>,
    /// The data are a table of postures or impacts, whose noise is known by a bound alone.
    pub is_table: bool,
    /// Inertial parameters are estimated freely: without them nothing can be said of the size of effects.
    pub free: bool,
    /// Squared errors by row before any effect entered.
    pub reference: Vec<f64>,
    /// Candidates that the exact estimate made impossible.
    pub banned: Vec<usize>,
    /// Candidates that stand whatever the data say; first in every list of active ones.
    pub standing: Vec<usize>,
    /// The same as they are described, where all values are stated.
    pub described: Vec<Option<Effect>>,
}

/// A fit and what it costs.
#[derive(Debug, Clone)]
pub(crate) struct ScoredFit {
    pub fit: Fit,
    /// Sums of squared errors on the judging data, by row.
    pub errors: Vec<f64>,
    /// Weighted errors, prior and complexity penalty of all effects.
    pub cost: f64,
}

/// The resolutions of two logs, where they are alike the mean of both, which is known better; else the first's.
fn both(train: &[f64], judge: &[f64]) -> Vec<f64> {
    /// By less than this part the noise of a sensor differs from log to log by chance.
    const ALIKE: f64 = 0.1;
    let mean = |(a, b): (&f64, &f64)| if (b - a).abs() < ALIKE * a { 0.5 * (a + b) } else { *a };
    train.iter().zip(judge).map(mean).collect()
}

/// Blocks that judge where there is no other log.
fn is_held_out_block(block: usize) -> bool {
    block % 3 == 1
}

/// Whether the `sample`-th of n lies in such a block.
pub(crate) fn is_held_out(sample: usize, n: usize) -> bool {
    // The block that `block_limits` puts it into: the last that does not begin behind it.
    is_held_out_block(((sample + 1) * BLOCKS).div_ceil(n.max(1)).saturating_sub(1))
}

impl<'a> Regression<'a> {
    /// Forms all sums; `progress` is told which part of it is done.
    pub fn new(
        train: &'a dyn Experiment,
        validation: Option<&'a dyn Experiment>,
        places: &[(&'static Kind, Location)],
        options: &crate::diagnose::engine::Options,
        progress: &dyn Fn(f64),
    ) -> Self {
        let judge = validation.unwrap_or(train);
        let spread = Spread::new(train, &options.cad, options.widening);
        let forms = all_forms(train, places);
        let columns = columns_of(train, &forms);
        progress(0.2);
        let judge_columns = validation.map(|v| columns_of(v, &forms));
        progress(0.4);
        let equations = equations_of(train, &spread, &columns);
        progress(0.7);
        let judge_equations =
            validation.zip(judge_columns).map(|(v, columns)| equations_of(v, &spread, &columns));
        progress(0.9);
        let candidates = candidates_of(train, forms, &columns, &spread);
        let own_blocks = validation.is_none();
        let (train_blocks, judge_blocks): (Vec<usize>, Vec<usize>) = if own_blocks {
            (0..BLOCKS).partition(|b| !is_held_out_block(*b))
        } else {
            ((0..BLOCKS).collect(), (0..BLOCKS).collect())
        };
        let train_sums = NormalEquations::of(&equations, &train_blocks);
        let judge_sums = NormalEquations::of(judge_equations.as_deref().unwrap_or(&equations), &judge_blocks);
        let mut this = Self {
            train,
            judge,
            own_blocks,
            spread,
            candidates,
            equations,
            judge_equations,
            train_sums,
            judge_sums,
            judge_blocks,
            weights: Vec::new(),
            floor_deviance: Vec::new(),
            noise_floors: Vec::new(),
            corrections: None,
            products: Vec::new(),
            resolutions: both(&resolutions(train), &resolutions(judge)),
            noise_squares: Vec::new(),
            is_table: train.motion().time.is_empty(),
            reference: Vec::new(),
            free: options.widening > 1.0,
            banned: Vec::new(),
            standing: Vec::new(),
            described: Vec::new(),
        };
        // Named as alternatives only.
        this.banned =
            (0..this.candidates.len()).filter(|&c| !this.candidates[c].form.fixed.is_empty()).collect();
        this.weigh();
        progress(1.0);
        this
    }

    /// Whether play at a joint changes a torque or force: where nobody measured the link's angle.
    pub fn is_behind_play(&self, row: usize, at: &Location) -> bool {
        let play = |c: &&Candidate| c.form.kind.law == Law::Backlash && c.form.location == *at;
        self.train.rows()[row].channel != Channel::Transmission
            && self.candidates.iter().filter(play).any(|c| c.rows.contains(&row))
    }

    /// Keeps all forms of a candidate's kind and place out of further searches.
    pub fn ban(&mut self, c: usize) {
        let form = |c: usize| &self.candidates[c].form;
        let same = (0..self.candidates.len())
            .filter(|&o| form(o).kind == form(c).kind && form(o).location == form(c).location);
        let same: Vec<usize> = same.collect();
        self.banned.extend(same);
    }

    /// Mass of the body on which an effect on a link acts, kg.
    pub fn carrier(&self, c: usize) -> Option<f64> {
        let Search::Inertial(directions) = &self.candidates[c].form.search else { return None };
        let body = directions.first()?.iter().position(|x| *x != 0.0).map(body_of)?;
        self.train.inertial_parameters().get(parameter_index(body, 0)).copied()
    }

    /// A candidate's terms, for [`Regression::recall`].
    pub fn remembered(&self, c: usize) -> (Form, Vec<Term>) {
        (self.candidates[c].form.clone(), self.candidates[c].terms.clone())
    }

    /// Gives a candidate the terms that it had.
    pub fn recall(&mut self, c: usize, (form, terms): (Form, Vec<Term>)) {
        (self.candidates[c].form, self.candidates[c].terms) = (form, terms);
        self.products[c] = OnceLock::new();
    }

    /// All terms of some candidates.
    pub fn terms(&self, active: &[usize]) -> Vec<&Term> {
        active.iter().flat_map(|&c| &self.candidates[c].terms).collect()
    }

    /// Evidence that effects have to bring for being more than none.
    pub fn complexity_penalty(&self, active: &[usize]) -> f64 {
        let total: f64 = self.floor_deviance.iter().sum::<f64>().max(2.0);
        let penalty = |&c: &usize| {
            let candidate = &self.candidates[c];
            if let Search::Inertial(_) = candidate.form.search {
                // These compete with corrections that cost by themselves.
                return INERTIAL * candidate.parameters as f64 + ENTRY;
            }
            let floor = candidate.rows.iter().map(|&r| self.floor_deviance[r]).fold(0.0, f64::max);
            candidate.parameters as f64 * (total.ln() + PARAMETER_PENALTY * floor)
                + ENTRY
                + EFFECT_PENALTY * floor
        };
        active.iter().map(penalty).sum()
    }

    /// Fits candidates and judges them.
    pub fn scored_fit(&self, active: &[usize], corrected: bool) -> Option<ScoredFit> {
        let products: Vec<&TermProducts> = active.iter().flat_map(|&c| self.products_of(c)).collect();
        self.scored((&products, &self.terms(active)), active, corrected)
    }

    /// The fit of candidates of which one has another form.
    pub fn scored_fit_with(
        &self,
        active: &[usize],
        (other, candidate, own): (usize, &Candidate, &[TermProducts]),
        corrected: bool,
    ) -> Option<ScoredFit> {
        let is_it = |c: usize| c == other;
        let products = active.iter().flat_map(|&c| if is_it(c) { own } else { self.products_of(c) });
        let terms =
            active.iter().flat_map(|&c| if is_it(c) { &candidate.terms } else { &self.candidates[c].terms });
        let (products, terms): (Vec<_>, Vec<_>) = (products.collect(), terms.collect());
        self.scored((&products, &terms), active, corrected)
    }

    fn scored(
        &self,
        (products, terms): (&[&TermProducts], &[&Term]),
        active: &[usize],
        corrected: bool,
    ) -> Option<ScoredFit> {
        let corrections = self.corrections.as_ref().filter(|_| corrected);
        let fit = fit(corrections, products)?;
        let errors = errors(self.judge_sums.grams(), &fit, terms);
        let heard = errors.iter().zip(&self.noise_squares).map(|(error, noise)| error.max(*noise));
        let deviance: f64 = heard.zip(&self.weights).map(|(e, w)| e * w).sum();
        let cost = deviance + fit.prior + self.complexity_penalty(active);
        Some(ScoredFit { fit, errors, cost })
    }

    /// What a fit costs if all of its error counts, what lies below the noise too.
    pub fn whole_cost(&self, active: &[usize], scored: &ScoredFit) -> f64 {
        let deviance: f64 = scored.errors.iter().zip(&self.weights).map(|(e, w)| e * w).sum();
        deviance + scored.fit.prior + self.complexity_penalty(active)
    }

    /// Whether a candidate changes the inertial parameters of a link.
    pub fn is_of_link(&self, c: usize) -> bool {
        matches!(self.candidates[c].form.search, Search::Inertial(_))
    }

    /// Whether more is left in a row than a measurement's noise.
    pub fn is_loud(&self, row: usize, scored: &ScoredFit) -> bool {
        let noise = self.noise_squares[row];
        noise > 0.0 && scored.errors[row] > 2.0 * noise
    }

    pub fn products_of(&self, c: usize) -> &[TermProducts] {
        self.products[c].get_or_init(|| self.products_with(&self.candidates[c]))
    }

    pub fn products_with(&self, candidate: &Candidate) -> Vec<TermProducts> {
        let corrections = self.corrections.as_ref();
        let of = |term: &Term| TermProducts::new(&self.train_sums, &self.weights, corrections, term);
        candidate.terms.iter().map(of).collect()
    }

    /// Errors of a fit in each judging block, one row.
    pub fn block_errors(&self, scored: &ScoredFit, active: &[usize]) -> Vec<Vec<f64>> {
        let equations = self.judge_equations.as_deref().unwrap_or(&self.equations);
        let terms = self.terms(active);
        self.judge_blocks
            .iter()
            .map(|&b| errors(equations.iter().map(|row| row.block(b)), &scored.fit, &terms))
            .collect()
    }

    /// Standard error of the difference between the deviances of two fits, from the scatter over the judging blocks.
    pub fn scatter(&self, a: &ScoredFit, with_a: &[usize], b: &ScoredFit, with_b: &[usize]) -> f64 {
        let of = |scored: &ScoredFit, active: &[usize]| -> Vec<f64> {
            let weighted = |errors: Vec<f64>| errors.iter().zip(&self.weights).map(|(e, w)| e * w).sum();
            self.block_errors(scored, active).into_iter().map(weighted).collect()
        };
        let differences: Vec<f64> =
            of(a, with_a).iter().zip(of(b, with_b)).map(|(a, b): (&f64, f64)| b - a).collect();
        let n = differences.len() as f64;
        let mean = differences.iter().sum::<f64>() / n;
        let squares: f64 = differences.iter().map(|d| (d - mean).powi(2)).sum();
        (n * squares / (n - 1.0).max(1.0)).sqrt()
    }

    /// Coefficients of one of the active candidates.
    pub fn coefficients<'t>(&self, active: &[usize], scored: &'t ScoredFit, which: usize) -> &'t [f64] {
        let first: usize = active[..which].iter().map(|&c| self.candidates[c].terms.len()).sum();
        &scored.fit.coefficients[first..first + self.candidates[active[which]].terms.len()]
    }

    /// Lets effects stand from the start, each in the form that fits best. Those that the data cannot tell from the
    /// others are left out and returned.
    pub fn keep<'e>(&mut self, effects: &'e [Effect], corrected: bool) -> Vec<&'e Effect> {
        let mut left_out = Vec::new();
        for effect in effects {
            let searched = |c: &usize| {
                let form = &self.candidates[*c].form;
                form.is_of(effect) && form.fixed.is_empty()
            };
            let forms = (0..self.candidates.len()).filter(searched);
            let with = |c: usize| self.standing.iter().copied().chain([c]).collect::<Vec<usize>>();
            let tried = forms.filter_map(|c| Some((c, self.scored_fit(&with(c), corrected)?.cost)));
            match tried.min_by(|a, b| a.1.total_cmp(&b.1)) {
                Some((best, _)) => {
                    self.standing.push(best);
                    let is_stated = |name: &str| effect.parameters.contains_key(name);
                    let is_whole = effect.kind.estimated().all(|parameter| is_stated(parameter.name));
                    self.described.push(is_whole.then(|| effect.clone()));
                }
                None => left_out.push(effect),
            }
        }
        left_out
    }

    /// Whether a candidate is of the kind and at the place of one that stands from the start.
    pub fn stands(&self, c: usize) -> bool {
        let form = &self.candidates[c].form;
        self.standing.iter().any(|&s| {
            let other = &self.candidates[s].form;
            other.kind == form.kind && other.location == form.location
        })
    }

    /// Whether two candidates touch the same row.
    pub fn meet(&self, a: usize, b: usize) -> bool {
        self.candidates[a].rows.iter().any(|row| self.candidates[b].rows.contains(row))
    }

    /// Whether inertial corrections are possible at all.
    pub fn has_corrections(&self) -> bool {
        self.corrections.is_some()
    }
}

fn columns_of(experiment: &dyn Experiment, forms: &[Form]) -> Vec<Vec<Column>> {
    parallel(forms.len(), |i| forms[i].columns(experiment))
}

fn equations_of(
    experiment: &dyn Experiment,
    spread: &Spread,
    columns: &[Vec<Column>],
) -> Vec<BlockEquations> {
    let flat: Vec<(usize, &Column)> = columns.iter().flatten().enumerate().collect();
    parallel(experiment.rows().len(), |row| {
        let sticks = experiment.sticks(row);
        let emphasis: Vec<f64> = sticks.iter().map(|sticks| if *sticks { 0.0 } else { 1.0 }).collect();
        let emphasis = Some(&*emphasis).filter(|emphasis| !emphasis.is_empty());
        block_equations(experiment, row, spread, &flat, BLOCKS, emphasis)
    })
}
