//! The linear regression that a search works on: candidates, normal equations, weights, and what a set of effects costs.
use super::amended::Amended;
use super::block_equations::{BlockEquations, Spread, block_equations};
use super::candidates::{all_forms, candidates_of};
use super::fit::{Candidate, Corrections, Fit, NormalEquations, Term, TermProducts, errors, fit, sizes};
use super::noise_floor::noise_floor;
use super::resolution::resolutions;
use crate::experiments::form::{Column, Form, Search};
use crate::experiments::noise::heard;
use crate::experiments::{Channel, Experiment};
use crate::parallel::parallel;
use crate::physical::is_possible;
use crate::robot::inertial_parameters::{InertialParameters, body_of, parameter_index};
use bipedc_effects::effect::{Effect, Kind, Law, Location};
use std::sync::OnceLock;

/// Blocks of time that a log is cut into.
pub(super) const BLOCKS: usize = 9;

/// Evidence that an effect must bring beyond its parameters, as a fall of deviance.
const ENTRY: f64 = 15.0;
/// Part of the noise floor's deviance that each parameter has to pay.
const PARAMETER_PENALTY: f64 = 0.005;
/// Evidence that each parameter of an effect on a link must bring.
const INERTIAL: f64 = 4.0;
/// The same for each effect: of equivalent explanations the one with fewer effects is the cheaper one.
const EFFECT_PENALTY: f64 = 0.02;

/// What an effect makes is at most so many times all that there is to explain, as sums of squares.
pub(super) const MOST: f64 = 4.0;

/// What is left of a row whose squared error is below so many times the noise's variance is not worth a word.
pub(super) const NOISE_MARGIN: f64 = 1.6;
/// Squared errors below so many times the noise's variance are noise, whatever lowers them: estimates of noise are no better. Of n
/// samples, [`NOISE_SCATTER`] / √n more, two standard deviations of the mean of two logs' estimates.
const NOISE_SQUARES: f64 = 1.05;
const NOISE_SCATTER: f64 = 4.0;

/// A noise floor that effects lower further than to this part of it was none.
const LOWER: f64 = 0.4;
/// Noise that is so many times larger than it was taken is worth another search.
const LOUDER: f64 = 1.1;

/// Candidates with the normal equations of their columns, and how errors weigh.
pub(super) struct Regression<'a> {
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
    noise_floors: Vec<(f64, f64)>,
    pub corrections: Option<Corrections>,
    /// Products of each candidate's terms with all else, formed when first asked for.
    pub products: Vec<OnceLock<Vec<TermProducts>>>,
    /// Root mean squares below which errors say nothing, by row.
    pub resolutions: Vec<f64>,
    /// Sum of squares per row below which errors are the measurement's noise, however small they become.
    noise_squares: Vec<f64>,
    /// Inertial parameters are estimated freely: without them nothing can be said of the size of effects.
    pub free: bool,
    /// Squared errors by row before any effect entered.
    pub reference: Vec<f64>,
    /// Candidates that the exact estimate made impossible.
    pub banned: Vec<usize>,
    /// Candidates that stand whatever the data say; first in every list of active ones.
    pub standing: Vec<usize>,
}

/// A fit and what it costs.
#[derive(Debug, Clone)]
pub(super) struct ScoredFit {
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
pub(super) fn is_held_out(sample: usize, n: usize) -> bool {
    // The block that `block_limits` puts it into: the last that does not begin behind it.
    is_held_out_block(((sample + 1) * BLOCKS).div_ceil(n.max(1)).saturating_sub(1))
}

impl<'a> Regression<'a> {
    /// Forms all sums; `progress` is told which part of it is done.
    pub fn new(
        train: &'a dyn Experiment,
        validation: Option<&'a dyn Experiment>,
        places: &[(&'static Kind, Location)],
        options: &super::Options,
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
            reference: Vec::new(),
            free: options.widening > 1.0,
            banned: Vec::new(),
            standing: Vec::new(),
        };
        // Named as alternatives only.
        this.banned =
            (0..this.candidates.len()).filter(|&c| !this.candidates[c].form.fixed.is_empty()).collect();
        this.weigh();
        progress(1.0);
        this
    }

    /// Weights from what a smooth function of the signals could reach, or the noise where there are no signals.
    fn weigh(&mut self) {
        let rows = self.train.rows();
        self.noise_floors = parallel(rows.len(), |row| {
            noise_floor(self.train, self.judge, self.own_blocks, (row, self.resolutions[row]))
        });
        self.floor_deviance = self
            .judge_sums
            .rows
            .iter()
            .zip(&self.noise_floors)
            .map(|(row, (_, c))| row.count as f64 / c)
            .collect();
        let noise = |(resolution, sums): (&f64, &super::fit::RowEquations)| {
            let count = sums.count as f64;
            (NOISE_SQUARES + NOISE_SCATTER / count.max(1.0).sqrt()) * resolution.powi(2) * count
        };
        // Tables of postures and impacts know no more than a bound of their noise.
        let is_table = self.train.motion().time.is_empty();
        self.noise_squares = self
            .resolutions
            .iter()
            .zip(&self.judge_sums.rows)
            .map(|row| if is_table { 0.0 } else { noise(row) })
            .collect();
        self.weigh_by_noise_floors();
    }

    fn weigh_by_noise_floors(&mut self) {
        self.weights =
            self.noise_floors.iter().map(|(variance, correlation)| 1.0 / (variance * correlation)).collect();
        let wanted = self.train.inertial_count() > 0 && self.spread.corrects;
        self.corrections =
            wanted.then(|| Corrections::new(&self.train_sums, &self.weights, self.spread.len()));
        self.products = self.candidates.iter().map(|_| OnceLock::new()).collect();
    }

    /// Lowers the noise floor where effects do better than the smooth function did, which cannot follow every jump. Tells
    /// whether that changed anything worth another search.
    pub fn reweigh(&mut self, scored: &ScoredFit) -> bool {
        let mut changed = false;
        for (row, (variance, _)) in self.noise_floors.iter_mut().enumerate() {
            let reached = scored.errors[row] / self.judge_sums.rows[row].count.max(1) as f64;
            let noise = self.resolutions[row].powi(2);
            if reached < LOWER * *variance && noise < LOWER * *variance {
                *variance = reached.max(noise);
                changed = true;
            }
        }
        if changed {
            self.weigh_by_noise_floors();
        }
        changed
    }

    /// Takes noise for as large as what is left by these effects, as a search scored them, shows it to be: beside what they explain noise
    /// that is correlated in time could not be told. Tells whether that changed anything worth another search.
    pub fn hear(&mut self, effects: &[Effect], scored: &ScoredFit) -> bool {
        // Limits trim what is left, and with it the noise that they may be mistaken for.
        let kept = effects.iter().filter(|effect| !matches!(effect.kind.law, Law::TrueTorque(_)));
        let kept: Vec<Effect> = kept.cloned().collect();
        let mut left = Amended::new(self.train, &kept);
        if !scored.fit.corrections.is_empty() {
            left.correct(&self.spread.change(&scored.fit.corrections));
        }
        let mut changed = false;
        for (row, resolution) in self.resolutions.iter_mut().enumerate() {
            let noise = heard(self.train, row, left.residual(row));
            if noise > LOUDER * *resolution {
                *resolution = noise;
                changed = true;
            }
        }
        if changed {
            self.weigh();
        }
        changed
    }

    /// Whether play at a joint changes a torque or force: where nobody measured the link's angle.
    pub fn is_behind_play(&self, row: usize, at: &Location) -> bool {
        let play = |c: &&Candidate| c.form.kind.law == Law::Backlash && c.form.location == *at;
        self.train.rows()[row].channel != Channel::Transmission
            && self.candidates.iter().filter(play).any(|c| c.rows.contains(&row))
    }

    /// Whether the data are a table of postures or impacts, whose noise is known by a bound alone.
    pub fn is_table(&self) -> bool {
        self.noise_squares.iter().all(|noise| *noise == 0.0)
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
        let terms = self.terms(active);
        let corrections = self.corrections.as_ref().filter(|_| corrected);
        let products: Vec<&TermProducts> = active.iter().flat_map(|&c| self.products_of(c)).collect();
        let fit = fit(corrections, &products)?;
        let errors = errors(self.judge_sums.grams(), &fit, &terms);
        let heard = errors.iter().zip(&self.noise_squares).map(|(error, noise)| error.max(*noise));
        let deviance: f64 = heard.zip(&self.weights).map(|(e, w)| e * w).sum();
        let cost = deviance + fit.prior + self.complexity_penalty(active);
        Some(ScoredFit { fit, errors, cost })
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

    /// Why a fit is physically impossible, if it is.
    pub fn impossible(&self, active: &[usize], scored: &ScoredFit) -> Option<(usize, String)> {
        (0..active.len()).filter(|&k| !self.standing.contains(&active[k])).find_map(|k| {
            let (form, coefficients) =
                (&self.candidates[active[k]].form, self.coefficients(active, scored, k));
            let why = form.impossible(coefficients).or_else(|| self.massless(form, coefficients)).or_else(
                || self.cancelled(&self.candidates[active[k]], coefficients).filter(|_| active.len() > 1),
            )?;
            Some((active[k], why))
        })
    }

    /// Whether an effect makes far more than there is to explain, so that another one must take it back: a pair that
    /// the data cannot tell apart.
    fn cancelled(&self, candidate: &Candidate, coefficients: &[f64]) -> Option<String> {
        let made = sizes(&self.train_sums, &candidate.terms, coefficients);
        let weighted = |of: &dyn Fn(usize) -> f64| -> f64 {
            candidate.rows.iter().map(|&r| of(r) * self.weights[r]).sum()
        };
        let wanted = weighted(&|r| self.train_sums.rows[r].squares());
        (weighted(&|r| made[r]) > MOST * wanted).then(|| {
            "it and another effect would cancel each other: this data cannot tell them apart".to_owned()
        })
    }

    /// Whether an effect on a link leaves no body that can exist: its pseudo-inertia must be positive definite.
    fn massless(&self, form: &Form, coefficients: &[f64]) -> Option<String> {
        let Search::Inertial(_) = form.search else { return None };
        let nominal = self.train.inertial_parameters();
        let change = self.train.inertial_change(&form.effect(coefficients));
        let possible = nominal
            .chunks_exact(InertialParameters::PER_BODY)
            .zip(change.chunks_exact(InertialParameters::PER_BODY))
            .all(|(body, change)| {
                let p: [f64; 10] = std::array::from_fn(|k| body[k] + change[k]);
                change.iter().all(|c| *c == 0.0) || is_possible(&p)
            });
        (!possible).then(|| "no body has such an inertia".to_owned())
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
                Some((best, _)) => self.standing.push(best),
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
