//! An experiment under effects: what their model leaves.
use crate::experiments::noise::yielding;
use crate::experiments::{Channel, Experiment, Inertial, Row};
use crate::robot::LinkInertias;
use bipedc_effects::effect::{Effect, Kind, Location};

/// An experiment whose model has effects already.
pub(crate) struct Amended<'a> {
    inner: &'a dyn Experiment,
    residual: Vec<Vec<f64>>,
    /// By row what the noise of motion makes of it through these effects.
    motion_noise: Vec<f64>,
}

/// What the noise of motion makes of an angle between a motor and its link: that of the link's torque, through springs.
fn through_springs(inner: &dyn Experiment, row: &Row, effects: &[Effect]) -> f64 {
    if row.channel != Channel::Transmission {
        return 0.0;
    }
    let yielding = yielding(effects.iter().filter(|effect| effect.location.joint == row.joint));
    let mut rows = inner.rows().iter();
    let effort = rows.position(|other| other.channel == Channel::Effort && other.joint == row.joint);
    yielding * effort.map_or(0.0, |effort| inner.motion_noise(effort))
}

impl<'a> Amended<'a> {
    pub fn new(inner: &'a dyn Experiment, effects: &[Effect]) -> Self {
        let mut residual: Vec<Vec<f64>> =
            (0..inner.rows().len()).map(|r| inner.residual(r).to_vec()).collect();
        if !effects.is_empty() {
            for (row, response) in inner.response(effects) {
                residual[row].iter_mut().zip(&response).for_each(|(r, x)| *r -= x);
            }
        }
        let of_row = |(index, row)| inner.motion_noise(index) + through_springs(inner, row, effects);
        let motion_noise = inner.rows().iter().enumerate().map(of_row).collect();
        Self { inner, residual, motion_noise }
    }

    /// Subtracts what a change of inertial parameters predicts.
    pub fn correct(&mut self, change: &[f64]) {
        for (row, residual) in self.residual.iter_mut().enumerate() {
            let Some(inertial) = self.inner.inertial(row) else { continue };
            let width = inertial.columns.len().max(1);
            for (r, y) in residual.iter_mut().zip(inertial.values.chunks_exact(width)) {
                *r -= inertial.columns.iter().zip(y).map(|(c, y)| y * change[*c]).sum::<f64>();
            }
        }
    }

    /// The residual without any effect.
    pub fn nominal(&self, row: usize) -> &[f64] {
        self.inner.residual(row)
    }
}

impl Experiment for Amended<'_> {
    fn rows(&self) -> &[Row] {
        self.inner.rows()
    }
    fn time(&self) -> &[f64] {
        self.inner.time()
    }
    fn residual(&self, row: usize) -> &[f64] {
        &self.residual[row]
    }
    fn measured(&self, row: usize) -> Option<Vec<f64>> {
        self.inner.measured(row)
    }
    fn sticks(&self, row: usize) -> &[bool] {
        self.inner.sticks(row)
    }
    fn described(&self) -> &[Effect] {
        self.inner.described()
    }
    fn motion_noise(&self, row: usize) -> f64 {
        self.motion_noise[row]
    }
    fn noise_in_signals(&self, row: usize) -> f64 {
        self.inner.noise_in_signals(row)
    }
    fn within_steps(&self, row: usize) -> [f64; 2] {
        self.inner.within_steps(row)
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
        self.inner.response(effects)
    }
    fn candidates(&self) -> Vec<(&'static Kind, Location)> {
        self.inner.candidates()
    }
    fn inertial_count(&self) -> usize {
        self.inner.inertial_count()
    }
    fn inertial(&self, row: usize) -> Option<&Inertial> {
        self.inner.inertial(row)
    }
    fn signals(&self, row: usize) -> Vec<(String, Vec<f64>)> {
        self.inner.signals(row)
    }
    fn signal(&self, row: usize, name: &str) -> Option<Vec<f64>> {
        self.inner.signal(row, name)
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
    fn link_inertias(&self) -> Option<&LinkInertias> {
        self.inner.link_inertias()
    }
}
