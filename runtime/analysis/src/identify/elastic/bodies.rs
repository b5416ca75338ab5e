//! Bodies from the springs' torques: base parameters with errors of both steps, and all that follows from joint torques.
use super::super::accumulate::Sums;
use super::super::design::Design;
use super::super::estimate::{Estimate, Method};
use super::super::physical::Inertia;
use super::super::reading::Reading;
use super::super::result::Identification;
use super::super::run::{Feed, IdentificationResult, Judge, Options, RobotAndLogs, identify};
use super::super::summary::student;
use super::super::unknowns::ExtraChoice;
use super::fold::Folded;
use super::laws::Estimator;
use super::look::Look;
use super::run::Elastic;
use super::solve::Solved;
use bipedc_effects::diagnostic::Diagnostics;
use nalgebra::DVector;

/// What was found before.
pub struct Bodies<'a, 'd> {
    pub design: &'a Design<'d>,
    pub folded: &'a Folded,
    pub judged: Option<&'a Folded>,
    pub solved: &'a Solved,
    pub nominal: &'a DVector<f64>,
    pub extras: &'a ExtraChoice,
}

impl Bodies<'_, '_> {
    /// Identification as from joint torques, and the links' new inertias.
    ///
    /// # Errors
    /// Data that cannot carry an estimate, bounds that contradict each other.
    pub fn identify(
        &self,
        parts: &RobotAndLogs<'_>,
        judge: Option<(&Reading<'_>, &Look)>,
        options: &Elastic,
        progress: &dyn Fn(f64),
    ) -> Result<(Identification, Vec<(String, Inertia)>), Diagnostics> {
        let method = method(options.estimator);
        let sums = trained_on(self.design, self.folded, self.solved, self.nominal, method);
        let zero = DVector::zeros(self.nominal.len());
        let judging = self.judged.map(|judged| bodies(self.design, judged, self.solved, &zero));
        let judge = judge.zip(judging.as_ref()).map(|((reading, look), sums)| Judge {
            feed: Feed::Folded(sums),
            survey: &look.survey,
            file: reading.log.path(),
        });
        let further = Options {
            method,
            extras: self.extras.clone(),
            weight: options.weight,
            bounds: options.bounds.clone(),
            // What is folded already went through the drives' own.
            slow: Some(0.0),
            ..Options::default()
        };
        let IdentificationResult { mut identification, links, .. } =
            identify(parts, &Feed::Folded(&sums), judge.as_ref(), &further, progress)?;
        amend(&mut identification, self.design, self.solved);
        Ok((identification, links))
    }
}

fn method(estimator: Estimator) -> Method {
    match estimator {
        Estimator::Ordinary => Method::Ordinary,
        Estimator::Weighted => Method::Weighted,
        Estimator::Instrumental => Method::Instrumental,
    }
}

/// The joints' rows with the springs that were found, as from measured torques; `shift` times the regressor is taken from
/// the torques.
fn bodies(design: &Design<'_>, folded: &Folded, solved: &Solved, shift: &DVector<f64>) -> Sums {
    let mut sums = Sums::new(design, folded.joints.len());
    let stiffness = folded.laws.stiffness();
    for (cell, own) in folded.joints.iter().zip(&mut sums.cells) {
        for (c, (triangle, own)) in cell.iter().zip(own).enumerate() {
            let places = &design.channels[c].places;
            let first = if folded.instruments { places.len() } else { 0 };
            let kept: Vec<usize> = (first..first + places.len()).collect();
            let spring = folded.springs[c].map(|k| (first + places.len(), solved.motors[k].value[stiffness]));
            let shifted = places.iter().enumerate().map(|(k, &place)| (first + k, shift[place]));
            let known: Vec<(usize, f64)> = spring.into_iter().chain(shifted).collect();
            *own = triangle.reduced(&kept, &known);
        }
    }
    sums
}

/// Sums whose least squares are what was solved for.
///
/// Essential and physical parameters are found by the distance `‖W (θ − θ̂)‖` from an estimate. Of instruments, or of one
/// regression for everything, θ̂ is not the least-squares solution of the joints' rows: what differs is taken from the
/// torques, residuals stay as they are.
fn trained_on(
    design: &Design<'_>,
    folded: &Folded,
    solved: &Solved,
    nominal: &DVector<f64>,
    method: Method,
) -> Sums {
    let plain = bodies(design, folded, solved, &DVector::zeros(nominal.len()));
    let estimate = Estimate::weighted(design, &plain, nominal.clone(), method);
    let theta = estimate.solve(&estimate.total, &estimate.seen);
    bodies(design, folded, solved, &(theta - &solved.joints.value))
}

/// Error bars that know of both steps.
fn amend(identification: &mut Identification, design: &Design<'_>, solved: &Solved) {
    let t = student(solved.stretches);
    for parameter in &mut identification.parameters {
        let Some(k) = design.unknowns.iter().position(|u| u.name == parameter.name) else { continue };
        let [error, independent] = solved.joints.errors(k);
        let value = parameter.value;
        let relative = (value != 0.0).then(|| 100.0 * error / value.abs());
        parameter.standard_error = error;
        parameter.independent_error = independent;
        parameter.relative_error_percent = relative;
        parameter.interval = [value - t * error, value + t * error];
        parameter.well_identified = relative.is_some_and(|percent| percent < 15.0);
    }
}
