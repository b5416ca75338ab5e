//! Errors of a diagnosis: root mean squares before and after effects, by row and by kind of channel.
use crate::diagnose::engine::equations::regression::is_held_out;
use crate::diagnose::engine::equations::resolution::resolutions;
use crate::diagnose::engine::refine::amended::Amended;
use crate::diagnose::{Diagnosis, ErrorFall};
use crate::experiments::jumps::Jumps;
use crate::experiments::moving::moving;
use crate::experiments::noise::noise_beside;
use crate::experiments::{Channel, Experiment};
use crate::parallel::parallel;
use bipedc_effects::effect::Effect;
use std::collections::BTreeMap;

/// Errors of a list of effects, as a diagnosis states them: on `validation`, or on the blocks of `train` that were held out.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Errors {
    /// By row.
    pub rows: BTreeMap<String, ErrorFall>,
    /// By kind of channel.
    pub rms: BTreeMap<String, ErrorFall>,
    /// The same on all samples of `train`.
    pub rms_training: BTreeMap<String, ErrorFall>,
    /// And by row.
    pub rows_training: BTreeMap<String, ErrorFall>,
}

/// Root mean square errors with the effects of `before` and with those of `after`.
pub fn errors(
    train: &dyn Experiment,
    validation: Option<&dyn Experiment>,
    [before, after]: [&[Effect]; 2],
) -> Errors {
    let judge = validation.unwrap_or(train);
    let counts = |sample: usize, n: usize| validation.is_some() || is_held_out(sample, n);
    let judged = Left::new(judge, [before, after]);
    let (mut rows, rms) = judged.grouped(&counts);
    judged.look_away_from_jumps(after, &counts, &mut rows);
    let all = |_: usize, _: usize| true;
    let taught = validation.map(|_| Left::new(train, [before, after]));
    let taught = taught.as_ref().unwrap_or(&judged);
    let (mut rows_training, rms_training) = taught.grouped(&all);
    taught.look_away_from_jumps(after, &all, &mut rows_training);
    Errors { rows, rms, rms_training, rows_training }
}

/// What effects leave of each row, over all samples of a log: root mean squares.
pub fn root_mean_squares(experiment: &dyn Experiment, effects: &[Effect]) -> Vec<f64> {
    let amended = Amended::new(experiment, effects);
    let of_row = |row: usize| {
        let left = amended.residual(row);
        (left.iter().map(|x| x * x).sum::<f64>() / left.len().max(1) as f64).sqrt()
    };
    (0..experiment.rows().len()).map(of_row).collect()
}

/// Root mean squares that effects leave, by kind of channel: on `validation`, or on the blocks of `train` that were held out, and on all samples of
/// `train`. Those of [`errors`] without all else that they tell.
pub fn left_by_kind(
    train: &dyn Experiment,
    validation: Option<&dyn Experiment>,
    effects: &[Effect],
) -> [BTreeMap<String, f64>; 2] {
    let of = |experiment: &dyn Experiment, counts: &dyn Fn(usize, usize) -> bool| {
        let left = Amended::new(experiment, effects);
        let mut kinds = BTreeMap::<Channel, (f64, f64)>::new();
        for (row, what) in left.rows().iter().enumerate() {
            let (squares, n) = squares(left.residual(row), counts);
            let sums = kinds.entry(what.channel).or_default();
            *sums = (sums.0 + squares, sums.1 + n);
        }
        kinds.into_iter().map(|(channel, sums)| (channel.name().to_owned(), root(sums))).collect()
    };
    let held_out = |sample: usize, n: usize| validation.is_some() || is_held_out(sample, n);
    [of(validation.unwrap_or(train), &held_out), of(train, &|_, _| true)]
}

/// Sum of the squares of the samples that count, and their number.
fn squares(values: &[f64], counts: &dyn Fn(usize, usize) -> bool) -> (f64, f64) {
    let kept = values.iter().enumerate().filter(|(i, _)| counts(*i, values.len()));
    kept.fold((0.0, 0.0), |(sum, n), (_, x)| (sum + x * x, n + 1.0))
}

/// Root of a mean square.
fn root((squares, n): (f64, f64)) -> f64 {
    (squares / n.max(1.0)).sqrt()
}

type Falls = BTreeMap<String, ErrorFall>;

/// What is left of a log's rows with some effects, and with others.
struct Left<'a> {
    before: Amended<'a>,
    after: Amended<'a>,
    /// Of each row as it is left after.
    noises: Vec<f64>,
}

impl<'a> Left<'a> {
    fn new(experiment: &'a dyn Experiment, effects: [&[Effect]; 2]) -> Self {
        let [before, after] = effects.map(|effects| Amended::new(experiment, effects));
        let rows = experiment.rows().len();
        let noises =
            parallel(rows, |row| noise_beside(&before, row, after.residual(row), after.motion_noise(row)));
        Self { before, after, noises }
    }

    /// What is left away from where these effects jump.
    fn look_away_from_jumps(
        &self,
        effects: &[Effect],
        counts: &dyn Fn(usize, usize) -> bool,
        rows: &mut Falls,
    ) {
        let left = &self.after;
        let jumps = Jumps::of(left, effects);
        for (row, what) in left.rows().iter().enumerate() {
            if let Some(fall) = rows.get_mut(&what.name) {
                fall.away_from_jumps = jumps.away(left, row, left.residual(row), counts);
            }
        }
    }

    /// Root mean squares before and after, by row and by kind of channel.
    fn grouped(&self, counts: &dyn Fn(usize, usize) -> bool) -> (Falls, Falls) {
        let Self { before, after, noises } = self;
        let resolutions = resolutions(before);
        let (mut rows, mut groups) = (Falls::new(), BTreeMap::<Channel, Sums>::new());
        for ((row, what), noise) in before.rows().iter().enumerate().zip(noises) {
            let ((was, n), (is, _)): ((f64, f64), _) =
                (squares(before.residual(row), counts), squares(after.residual(row), counts));
            let [was_moving, is_moving] = [before.residual(row), after.residual(row)]
                .map(|residual| moving(before, row, residual, counts));
            let all = [was, is].map(|squares| (squares, n));
            let told =
                [was_moving, is_moving].map(|told| told.map(|told| (told.squares, told.samples as f64)));
            let sums = Sums {
                all,
                told: [told[0].unwrap_or(all[0]), told[1].unwrap_or(all[1])],
                noise: noise.powi(2) * n,
                sticks: told[0].is_some(),
            };
            // Nor is what nobody sees of joints that rest within a step of their encoders.
            let [angles, motions] = before.within_steps(row);
            let resolution = resolutions[row].max(noise.hypot(angles).hypot(motions));
            rows.insert(what.name.clone(), ErrorFall { resolution, ..sums.fall(what.unit) });
            groups.entry(what.channel).or_default().add(&sums);
        }
        let of_kind =
            |(channel, sums): (Channel, Sums)| (channel.name().to_owned(), sums.fall(channel.unit()));
        (rows, groups.into_iter().map(of_kind).collect())
    }
}

/// Sums of squared errors, each with how many samples it is of.
#[derive(Default)]
struct Sums {
    /// Before and after.
    all: [(f64, f64); 2],
    /// The same where no joint sticks.
    told: [(f64, f64); 2],
    /// Of the noise at all samples.
    noise: f64,
    /// Whether a joint sticks.
    sticks: bool,
}

impl Sums {
    fn add(&mut self, other: &Self) {
        let sums = self.all.iter_mut().chain(&mut self.told);
        for (sum, more) in sums.zip(other.all.iter().chain(&other.told)) {
            *sum = (sum.0 + more.0, sum.1 + more.1);
        }
        (self.noise, self.sticks) = (self.noise + other.noise, self.sticks | other.sticks);
    }

    /// Root mean squares.
    fn fall(&self, unit: &str) -> ErrorFall {
        let moving = |k: usize| self.sticks.then(|| root(self.told[k]));
        ErrorFall {
            unit: unit.to_owned(),
            before: root(self.all[0]),
            after: root(self.all[1]),
            noise: root((self.noise, self.all[0].1)),
            resolution: 0.0,
            before_moving: moving(0),
            after_moving: moving(1),
            away_from_jumps: None,
            behind_both: None,
            gone_at_hz: None,
        }
    }
}

impl Diagnosis {
    /// States these errors.
    pub fn take(&mut self, errors: Errors) {
        (self.rows, self.rms) = (errors.rows, errors.rms);
        (self.rows_training, self.rms_training) = (errors.rows_training, errors.rms_training);
        if let Some(fall) = self.rms.get(main_channel(self)) {
            (self.rms_before, self.rms_after) = (fall.before, fall.after);
        }
    }
}

/// The kind of channel that the table is about.
fn main_channel(diagnosis: &Diagnosis) -> &'static str {
    ["post_impact_velocity", "cop", "effort", "base_force", "base_moment", "transmission"]
        .into_iter()
        .find(|name| diagnosis.rms.contains_key(*name))
        .unwrap_or("effort")
}
