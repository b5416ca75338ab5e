//! Inertial corrections as effects that a description can state: of the links that matter, such as bodies can have.
//!
//! A fit corrects all ten parameters of every body within its prior. Of these corrections the ones that the data ask for
//! stay, one link of each body takes them, and where no body could have them the nearest possible ones take their place:
//! nearest in what the measurements and the prior say together. Effects are then estimated again beside them, so that
//! what is reported is what was written.
use crate::diagnose::FoundEffect;
use crate::diagnose::engine::equations::block_equations::Spread;
use crate::diagnose::engine::refine::amended::Amended;
use crate::diagnose::engine::refine::refinement::{Data, HalfWidths, Refined, refine};
use crate::experiments::Experiment;
use crate::physical::{Bounds, COORDINATES, Inertia, LeastSquares, Links, Problem};
use crate::robot::LinkInertias;
use crate::robot::inertial_parameters::{InertialParameters, of_body};
use crate::robot::link_inertias::Link;
use bipedc_effects::effect::{Effect, Location, kinds};
use nalgebra::{DMatrix, DVector, Matrix3};
use std::collections::BTreeMap;

/// Least evidence, as a fall of deviance, that a body's correction needs: its ten parameters cost that much by chance.
const EVIDENCE: f64 = 20.0;
/// By so small a part must a row's squared error grow without a correction that says something.
const IDLE: f64 = 5e-3;
/// Weight of the distance from the description: so little that it decides only what nothing else does.
const NEARNESS: f64 = 1e-6;
/// Free estimates whose deviation stays above this part of the prior's are told by the prior, not by data.
const TOLD: f64 = 0.5;
/// 97.5 % point of the normal distribution.
const NORMAL: f64 = 1.96;
/// Smaller changes (kg, m, kg m²) are rounding.
const NOTHING: f64 = 1e-9;
/// Names of the ten parameters of the kind.
const NAMES: [&str; 10] = ["mass", "x", "y", "z", "ixx", "ixy", "ixz", "iyy", "iyz", "izz"];

/// Effects beside inertial corrections, both final.
pub(crate) struct Settled {
    pub refined: Refined,
    /// One per link, the strongest evidence first.
    pub corrections: Vec<FoundEffect>,
    /// Corrections that had to go because no body could have them.
    pub impossible: bool,
}

impl Settled {
    /// The corrections alone.
    pub fn correcting(&self) -> Vec<Effect> {
        self.corrections.iter().map(|found| found.effect.clone()).collect()
    }

    /// All that acts.
    pub fn all(&self) -> Vec<Effect> {
        self.refined.effects.iter().cloned().chain(self.correcting()).collect()
    }
}

/// Makes the corrections of an estimate final. `free`: the prior says nothing.
pub(crate) fn settle(data: Data<'_>, refined: Refined, spread: &Spread, free: bool) -> Settled {
    let plain = |refined: Refined, impossible| Settled { refined, corrections: Vec::new(), impossible };
    let Some(links) = data.experiment.link_inertias().filter(|_| !refined.corrections.is_empty()) else {
        return plain(refined, false);
    };
    let mut bodies = if free { needed(&refined) } else { matter(&refined) };
    let without = |effects: Vec<Effect>| refine(data, effects, &[], None);
    let of_all = refined.half_width;
    let mut effects = refined.effects;
    let (joint, found) = loop {
        if bodies.is_empty() {
            return plain(without(effects), false);
        }
        let spread = spread.only(&bodies);
        let joint = refine(data, effects, &[], Some(&spread));
        let all = (!free).then_some((&refined.corrections[..], &refined.covariance));
        let Some(found) = Correction { links, bodies: &bodies, spread: &spread, joint: &joint, all }.found()
        else {
            return plain(without(joint.effects), true);
        };
        let Some(idle) = idle(data, &joint.effects, &found) else { break (joint, found) };
        bodies.remove(idle);
        effects = joint.effects;
    };
    let fixed: Vec<Effect> = found.iter().map(|found| found.effect.clone()).collect();
    let last = refine(data, joint.effects, &fixed, None);
    // How sure the effects are is said by the estimate of both together, and by that beside all other bodies, whose errors are too small
    // to be seen and still pull.
    let refined = Refined { half_width: wider(joint.half_width, &of_all), ..last };
    Settled { refined, corrections: found, impossible: false }
}

/// A correction without which no row is told worse, to speak of: the evidence for it lies in directions that its body shares with others.
fn idle(data: Data<'_>, effects: &[Effect], found: &[FoundEffect]) -> Option<usize> {
    let squares = |left_out: Option<usize>| -> Vec<f64> {
        let kept = found.iter().enumerate().filter(|(k, _)| Some(*k) != left_out);
        let corrections = kept.map(|(_, found)| found.effect.clone());
        let all: Vec<Effect> = effects.iter().cloned().chain(corrections).collect();
        let amended = Amended::new(data.experiment, &all);
        let of_row = |row: usize| {
            let residual = amended.residual(row);
            let told = (0..residual.len()).filter(|&i| (data.teaches)(i, residual.len()));
            told.map(|i| residual[i] * residual[i]).sum()
        };
        (0..data.experiment.rows().len()).map(of_row).collect()
    };
    let with = squares(None);
    let grows = |k: usize| {
        let without = squares(Some(k));
        let growth = with.iter().zip(&without).map(|(with, without)| without / with.max(f64::MIN_POSITIVE));
        growth.fold(0.0, f64::max) - 1.0
    };
    let growths = (0..found.len()).map(|k| (k, grows(k)));
    growths.filter(|(_, growth)| *growth < IDLE).min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k)
}

/// The larger one of two half widths of each parameter.
fn wider(widths: HalfWidths, others: &HalfWidths) -> HalfWidths {
    let other = |effect: usize, name: &str| {
        let of_effect = others.get(effect)?;
        of_effect.iter().find_map(|(known, half)| (known == name).then_some(*half))
    };
    let of_effect = |(effect, widths): (usize, Vec<(String, f64)>)| {
        let larger = |(name, half): (String, f64)| {
            let half = other(effect, &name).map_or(half, |other| half.max(other));
            (name, half)
        };
        widths.into_iter().map(larger).collect()
    };
    widths.into_iter().enumerate().map(of_effect).collect()
}

/// Bodies whose corrections the data ask for, the strongest evidence first: the fall of deviance that they bring, others
/// estimated along.
fn matter(refined: &Refined) -> Vec<usize> {
    let evidence = |body: usize| -> f64 {
        let of = of_body(body);
        let change = DVector::from_row_slice(&refined.corrections[of.clone()]);
        let covariance = refined.covariance.view((of.start, of.start), (of.len(), of.len())).into_owned();
        covariance.cholesky().map_or(0.0, |cholesky| cholesky.solve(&change).dot(&change))
    };
    let count = refined.corrections.len() / InertialParameters::PER_BODY;
    let mut list: Vec<(f64, usize)> = (0..count).map(|body| (evidence(body), body)).collect();
    list.retain(|(evidence, _)| *evidence >= EVIDENCE);
    list.sort_by(|a, b| b.0.total_cmp(&a.0));
    list.into_iter().map(|(_, body)| body).collect()
}

/// The same where no prior shares corrections among bodies: each could do most of what a neighbour does, so that none but the outermost
/// seems to matter while all are estimated along. The one with the least evidence goes, the others take over what it did, until all
/// that are left have enough.
fn needed(refined: &Refined) -> Vec<usize> {
    let count = refined.corrections.len() / InertialParameters::PER_BODY;
    let mut left: Vec<usize> = (0..count).collect();
    let mut change = DVector::from_column_slice(&refined.corrections);
    let mut covariance = refined.covariance.view((0, 0), (change.len(), change.len())).into_owned();
    loop {
        let evidence = |body: usize| -> (f64, usize) {
            let of = of_body(body);
            let own = covariance.view((of.start, of.start), (of.len(), of.len())).into_owned();
            let x = change.rows(of.start, of.len()).into_owned();
            (own.cholesky().map_or(0.0, |cholesky| cholesky.solve(&x).dot(&x)), body)
        };
        let mut ranked: Vec<(f64, usize)> = left.iter().map(|body| evidence(*body)).collect();
        ranked.sort_by(|a, b| b.0.total_cmp(&a.0));
        let Some(&(least, weakest)) = ranked.last() else { return Vec::new() };
        if least >= EVIDENCE {
            return ranked.into_iter().map(|(_, body)| body).collect();
        }
        left.retain(|body| *body != weakest);
        // What is known of the others once this one is known to be as described.
        let of = of_body(weakest);
        let across = covariance.columns(of.start, of.len()).into_owned();
        let own = covariance.view((of.start, of.start), (of.len(), of.len())).into_owned();
        let Some(cholesky) = own.cholesky() else { continue };
        let gone = change.rows(of.start, of.len()).into_owned();
        change -= &across * cholesky.solve(&gone);
        covariance -= &across * cholesky.solve(&across.transpose());
    }
}

/// An estimate whose corrections become effects.
struct Correction<'s> {
    links: &'s LinkInertias,
    bodies: &'s [usize],
    spread: &'s Spread,
    joint: &'s Refined,
    /// The estimate beside all other bodies, and its covariance; `None`: the prior says nothing, and only those that are needed are known.
    all: Option<(&'s [f64], &'s DMatrix<f64>)>,
}

impl Correction<'_> {
    /// One effect per body; `None` if no such bodies were found.
    fn found(&self) -> Option<Vec<FoundEffect>> {
        let chosen: Vec<Link> = self.bodies.iter().map(|body| self.heaviest(*body)).collect::<Option<_>>()?;
        let links = Links::new(&LinkInertias { links: chosen.clone(), bodies: self.links.bodies.clone() });
        let nominal: Vec<[f64; 10]> = chosen.iter().map(Link::parameters).collect();
        let coordinates = self.possible(&links, &nominal)?;
        let covariance = self.covariance();
        let one = |(k, x): (usize, &[f64])| {
            let parameters = links.bodies[k].parameters(x);
            let change: [f64; 10] = std::array::from_fn(|i| parameters[i] - nominal[k][i]);
            let sigma = self.sigma(k, &covariance, |change| {
                let moved = std::array::from_fn(|i| nominal[k][i] + change[i]);
                ten(&chosen[k], &links.bodies[k].inertia_of(&moved))
            });
            let values = ten(&chosen[k], &links.bodies[k].inertia(x));
            found(&chosen[k].name, &values, &sigma(&change))
        };
        Some(coordinates.chunks_exact(COORDINATES).enumerate().map(one).collect())
    }

    /// The link that takes a body's correction.
    fn heaviest(&self, body: usize) -> Option<Link> {
        let links = self.links.links.iter().filter(|link| link.body == body && link.mass > 0.0);
        links.max_by(|a, b| a.mass.total_cmp(&b.mass)).cloned()
    }

    /// Coordinates of the links that lie nearest to the estimate.
    fn possible(&self, links: &Links, nominal: &[[f64; 10]]) -> Option<Vec<f64>> {
        let count = links.coordinates();
        // The estimate's unknowns, multiples of the spread, as functions of the links' coordinates.
        let unknowns = |x: &[f64]| -> Option<DVector<f64>> {
            let mut all = DVector::zeros(count);
            for (k, body) in self.bodies.iter().enumerate() {
                let here = k * COORDINATES..(k + 1) * COORDINATES;
                let parameters = links.bodies[k].parameters(&x[here.clone()]);
                let change = DVector::from_fn(10, |i, _| parameters[i] - nominal[k][i]);
                let x = self.spread.factors[*body].solve_lower_triangular(&change)?;
                all.rows_mut(here.start, COORDINATES).copy_from(&x);
            }
            Some(all)
        };
        let mut x = vec![0.0; count];
        let origin = unknowns(&x)?;
        let mut slopes = DMatrix::zeros(count, count);
        for k in 0..count {
            x[k] = 1.0;
            slopes.set_column(k, &(unknowns(&x)? - &origin));
            x[k] = 0.0;
        }
        let estimate = DVector::from_iterator(
            count,
            self.bodies.iter().flat_map(|body| self.joint.corrections[of_body(*body)].iter().copied()),
        );
        let precision = self.covariance().cholesky()?.inverse();
        let factor = precision.cholesky()?.l().transpose();
        let right = &factor * estimate;
        let regression = LeastSquares { factor, right, rest: 0.0, rows: 1 };
        let bounds = Bounds::default();
        let problem = Problem::new((origin, slopes), Vec::new(), links, &bounds);
        Some(problem.solve(&regression, NEARNESS).ok()?.coordinates)
    }

    /// Of the unknowns of the bodies that matter.
    fn covariance(&self) -> DMatrix<f64> {
        let places: Vec<usize> = self.bodies.iter().flat_map(|body| of_body(*body)).collect();
        DMatrix::from_fn(places.len(), places.len(), |r, c| self.joint.covariance[(places[r], places[c])])
    }

    /// Covariance of the `k`-th body's unknowns. Bodies whose corrections are too small to be seen are as described, and their neighbours take over
    /// what they do: how far the truth may be is told by the estimate beside all of them, and how far that is away.
    fn of_body(&self, k: usize, covariance: &DMatrix<f64>) -> DMatrix<f64> {
        let Some((corrections, covariance)) = self.all else {
            return covariance.view((10 * k, 10 * k), (10, 10)).into_owned();
        };
        let of = of_body(self.bodies[k]);
        let away = DVector::from_iterator(10, of.clone().map(|i| corrections[i] - self.joint.corrections[i]));
        covariance.view((of.start, of.start), (10, 10)) + &away * away.transpose()
    }

    /// Standard deviations of what `of` makes of a change of the `k`-th body's parameters, at a change; infinite where
    /// the data tell nothing.
    fn sigma(
        &self,
        k: usize,
        covariance: &DMatrix<f64>,
        of: impl Fn(&[f64; 10]) -> [f64; 10],
    ) -> impl Fn(&[f64; 10]) -> [f64; 10] {
        let factor = &self.spread.factors[self.bodies[k]];
        let own = self.of_body(k, covariance);
        let free = self.all.is_none();
        move |change| {
            // Slopes by the unknowns: a hundredth of the prior's deviation is a small step.
            let slope = |unknown: usize| {
                let step = |sign: f64| -> [f64; 10] {
                    of(&std::array::from_fn(|i| change[i] + sign * 0.01 * factor[(i, unknown)]))
                };
                let (far, near) = (step(1.0), step(-1.0));
                DVector::from_fn(10, |i, _| (far[i] - near[i]) / 0.02)
            };
            let slopes = DMatrix::from_columns(&[0, 1, 2, 3, 4, 5, 6, 7, 8, 9].map(slope));
            let posterior = &slopes * &own * slopes.transpose();
            let prior = &slopes * slopes.transpose();
            std::array::from_fn(|i| {
                let (sigma, before) = (posterior[(i, i)].max(0.0).sqrt(), prior[(i, i)].sqrt());
                if free && sigma > TOLD * before { f64::INFINITY } else { sigma }
            })
        }
    }
}

/// What a link's mass, centre of mass and inertia are more than in the description.
fn ten(link: &Link, now: &Inertia) -> [f64; 10] {
    let before = Matrix3::from_fn(|r, c| link.inertia[r][c]);
    let more = now.inertia - before;
    let [x, y, z] = [0, 1, 2].map(|i| now.center[i] - link.center[i]);
    let [xx, xy, xz] = [0, 1, 2].map(|i| more[(0, i)]);
    [now.mass - link.mass, x, y, z, xx, xy, xz, more[(1, 1)], more[(1, 2)], more[(2, 2)]]
}

fn found(link: &str, values: &[f64; 10], sigma: &[f64; 10]) -> FoundEffect {
    let values = values.map(|value| if value.abs() < NOTHING { 0.0 } else { value });
    let effect = Effect::new(
        &kinds::INERTIAL_CORRECTION,
        Location::link(link),
        &NAMES.into_iter().zip(values).collect::<Vec<_>>(),
    );
    let interval = |k: usize| {
        let half = NORMAL * sigma[k];
        (NAMES[k].to_owned(), [values[k] - half, values[k] + half])
    };
    let ci95: BTreeMap<String, [f64; 2]> = (0..10).map(interval).collect();
    FoundEffect { effect, ci95, share: 0.0, doubts: Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three bodies of which data tell the sum of the first numbers of the first two, and nothing of the third.
    fn confounded(sum: f64, precision: f64) -> Refined {
        let direction = DVector::from_fn(30, |i, _| f64::from(u8::from(i == 0 || i == 10)));
        let information = DMatrix::identity(30, 30) + &direction * direction.transpose() * precision;
        let covariance = information.cholesky().unwrap().inverse();
        let corrections = &covariance * &direction * (precision * sum);
        Refined {
            effects: Vec::new(),
            half_width: Vec::new(),
            corrections: corrections.as_slice().to_vec(),
            covariance,
        }
    }

    #[test]
    fn of_bodies_that_can_do_the_same_one_does_it() {
        // Half of it by either body, which alone would be no evidence: the other one could do that too.
        let refined = confounded(6.0, 1e4);
        assert!(matter(&refined).is_empty());
        let needed = needed(&refined);
        assert!(needed.len() == 1 && needed[0] < 2, "{needed:?}");
        assert!(super::needed(&confounded(1e-3, 1e4)).is_empty(), "what is not there needs nobody");
    }
}
