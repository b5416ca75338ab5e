//! An experiment of which only some kinds of rows count.
use crate::experiments::{Experiment, Inertial, Row};
use crate::log::names;
use crate::measure::JointPositions;
use crate::robot::InertialParameters;
use crate::robot::LinkInertias;
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, Kind, Location};

/// The rows of some channels of another experiment.
pub struct Selected<'a> {
    inner: Box<dyn Experiment + 'a>,
    /// Places of the rows in `inner`.
    places: Vec<usize>,
    rows: Vec<Row>,
    /// What is left of rows, where that is not what is left in `inner`.
    residuals: Vec<Option<Vec<f64>>>,
}

impl<'a> Selected<'a> {
    /// Keeps the rows of channels of these names, as in JSON: `base_force`.
    ///
    /// # Errors
    /// A name that no row has.
    pub fn new(inner: Box<dyn Experiment + 'a>, channels: &[String]) -> Result<Self, Diagnostic> {
        let has = |name: &str| inner.rows().iter().any(|row| row.channel.name() == name);
        if let Some(unknown) = channels.iter().find(|name| !has(name)) {
            let mut known: Vec<&str> = inner.rows().iter().map(|row| row.channel.name()).collect();
            known.dedup();
            let message = format!("the log has no channel `{unknown}`");
            let help = format!("channels of this log: {}", names::list(known, 8));
            return Err(Diagnostic::error(message).help(help));
        }
        Ok(Self::kept(inner, |row| channels.iter().any(|name| row.channel.name() == name)))
    }

    /// Keeps the rows of these names.
    pub fn named(inner: Box<dyn Experiment + 'a>, names: &[String]) -> Self {
        Self::kept(inner, |row| names.contains(&row.name))
    }

    fn kept(inner: Box<dyn Experiment + 'a>, kept: impl Fn(&Row) -> bool) -> Self {
        let places: Vec<usize> = (0..inner.rows().len()).filter(|&r| kept(&inner.rows()[r])).collect();
        let rows = places.iter().map(|&r| inner.rows()[r].clone()).collect();
        let residuals = vec![None; places.len()];
        Self { inner, places, rows, residuals }
    }

    /// All rows, without constants where an angle that is known to a step of its encoder alone may make as much: any bias and any mass that does as little is
    /// where the joint rests within that step.
    pub fn within_steps(inner: Box<dyn Experiment + 'a>) -> Self {
        let mut this = Self::kept(inner, |_| true);
        this.residuals = (0..this.rows.len()).map(|row| this.centred(row)).collect();
        this
    }

    fn centred(&self, row: usize) -> Option<Vec<f64>> {
        let [most, _] = self.inner.within_steps(row);
        let (residual, sticks) = (self.inner.residual(row), self.inner.sticks(row));
        let is_free = |i: &usize| !sticks.get(*i).is_some_and(|sticks| *sticks);
        let free: Vec<usize> = (0..residual.len()).filter(is_free).collect();
        let mean = free.iter().map(|i| residual[*i]).sum::<f64>() / free.len().max(1) as f64;
        (most > 0.0 && mean.abs() <= most).then(|| {
            let mut left = residual.to_vec();
            free.iter().for_each(|i| left[*i] -= mean);
            left
        })
    }
}

impl Experiment for Selected<'_> {
    fn rows(&self) -> &[Row] {
        &self.rows
    }
    fn time(&self) -> &[f64] {
        self.inner.time()
    }
    fn residual(&self, row: usize) -> &[f64] {
        self.residuals[row].as_deref().unwrap_or_else(|| self.inner.residual(self.places[row]))
    }
    fn measured(&self, row: usize) -> Option<Vec<f64>> {
        self.inner.measured(self.places[row])
    }
    fn sticks(&self, row: usize) -> &[bool] {
        self.inner.sticks(self.places[row])
    }
    fn shaken(&self) -> Vec<bool> {
        self.inner.shaken()
    }
    fn described(&self) -> &[Effect] {
        self.inner.described()
    }
    fn motion_noise(&self, row: usize) -> f64 {
        self.inner.motion_noise(self.places[row])
    }
    fn noise_in_signals(&self, row: usize) -> f64 {
        self.inner.noise_in_signals(self.places[row])
    }
    fn within_steps(&self, row: usize) -> [f64; 2] {
        self.inner.within_steps(self.places[row])
    }
    fn smeared(&self) -> usize {
        self.inner.smeared()
    }
    fn crossings(&self, effects: &[Effect]) -> Vec<bool> {
        self.inner.crossings(effects)
    }
    fn beside_impacts(&self) -> f64 {
        self.inner.beside_impacts()
    }
    fn response(&self, effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
        let here = |(row, values)| Some((self.places.iter().position(|p| *p == row)?, values));
        self.inner.response(effects).into_iter().filter_map(here).collect()
    }
    fn candidates(&self) -> Vec<(&'static Kind, Location)> {
        self.inner.candidates()
    }
    fn guess(&self, kind: &'static Kind, place: &Location) -> Option<Effect> {
        self.inner.guess(kind, place)
    }
    fn inertial_count(&self) -> usize {
        self.inner.inertial_count()
    }
    fn inertial_parameters(&self) -> &InertialParameters {
        self.inner.inertial_parameters()
    }
    fn inertial(&self, row: usize) -> Option<&Inertial> {
        self.inner.inertial(self.places[row])
    }
    fn inertial_at(&self, samples: &[usize]) -> Vec<Option<Inertial>> {
        let mut all = self.inner.inertial_at(samples);
        self.places.iter().map(|place| all[*place].take()).collect()
    }
    fn signals(&self, row: usize) -> Vec<(String, Vec<f64>)> {
        self.inner.signals(self.places[row])
    }
    fn signal(&self, row: usize, name: &str) -> Option<Vec<f64>> {
        self.inner.signal(self.places[row], name)
    }
    fn phases(&self) -> Vec<(String, Vec<bool>)> {
        self.inner.phases()
    }
    fn slides(&self, place: &Location) -> Option<f64> {
        self.inner.slides(place)
    }
    fn heaviness(&self, place: &Location) -> f64 {
        self.inner.heaviness(place)
    }
    fn slowness(&self, place: &Location) -> [f64; 2] {
        self.inner.slowness(place)
    }
    fn small_load(&self, place: &Location) -> Option<f64> {
        self.inner.small_load(place)
    }
    fn seeds(&self, kind: &'static Kind, location: &Location) -> Option<Vec<f64>> {
        self.inner.seeds(kind, location)
    }
    fn link_inertias(&self) -> Option<&LinkInertias> {
        self.inner.link_inertias()
    }
    fn check(&self) -> Vec<Diagnostic> {
        self.inner.check()
    }
    fn duration(&self) -> Option<f64> {
        self.inner.duration()
    }
    fn joints(&self) -> Vec<&str> {
        self.inner.joints()
    }
    fn motion(&self) -> JointPositions {
        self.inner.motion()
    }
}
