//! Estimates from samples away from corners, where laws jump.
use super::refinement::{Data, Refined, refine};
use crate::experiments::corners::CLIPPED;
use crate::experiments::{Channel, Experiment, Row};
use bipedc_effects::effect::{Acts, BoundLaw, Effect, Kind, Location, VARIABLES, kinds};

const NOISE: f64 = 0.05;

/// A joint that swings to and fro; torques with white noise.
struct Hinge {
    rows: Vec<Row>,
    time: Vec<f64>,
    velocity: Vec<f64>,
    reported: Vec<f64>,
    residual: Vec<f64>,
    smeared: usize,
}

impl Hinge {
    /// Its reported and true torques follow from time and velocity.
    fn new(torques: impl Fn(f64, f64, f64) -> [f64; 2]) -> Self {
        Self::moving(|t| 0.5 * (4.1 * t).sin() * (0.37 * t).cos(), torques)
    }

    /// The same with this velocity, a function of time.
    fn moving(velocity: impl Fn(f64) -> f64, torques: impl Fn(f64, f64, f64) -> [f64; 2]) -> Self {
        let time: Vec<f64> = (0..6000).map(|i| 0.002 * f64::from(i)).collect();
        let velocity: Vec<f64> = time.iter().map(|t| velocity(*t)).collect();
        let mut state = 1_u64;
        let mut uniform = || {
            state = state.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
            (state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5
        };
        let noise = |_| NOISE * (0..12).map(|_| uniform()).sum::<f64>();
        let noise: Vec<f64> = (0..time.len()).map(noise).collect();
        let both = time.iter().zip(&velocity).zip(noise).map(|((t, v), noise)| torques(*t, *v, noise));
        let (reported, residual) = both.map(|[reported, modelled]| (reported, reported - modelled)).unzip();
        let name = "hinge".to_owned();
        let row = Row {
            name: name.clone(),
            channel: Channel::Effort,
            unit: "N m",
            joint: Some(name),
            noise: NOISE,
        };
        Self { rows: vec![row], time, velocity, reported, residual, smeared: 0 }
    }

    /// The estimate of some effects; jumps are smeared over so many samples.
    fn refined(&self, effects: Vec<Effect>) -> Refined {
        let (weights, teaches) = (&[NOISE.powi(-2)], &|_, _| true);
        refine(
            Data {
                experiment: self,
                weights,
                teaches,
                judge: self,
                judges: |_, _| true,
                held: &[],
                at_corners: false,
            },
            effects,
            &[],
            None,
        )
    }

    /// The value of a parameter that is estimated from `start`, and its half width.
    fn estimated(&self, kind: &'static Kind, start: &[(&str, f64)], name: &str) -> [f64; 2] {
        let effect = Effect::new(kind, Location::joint("hinge"), start);
        let refined = self.refined(vec![effect]);
        let half = refined.half_width[0].iter().find(|(known, _)| known == name).unwrap().1;
        [refined.effects[0].value(name), half]
    }
}

impl Experiment for Hinge {
    fn rows(&self) -> &[Row] {
        &self.rows
    }
    fn time(&self) -> &[f64] {
        &self.time
    }
    fn residual(&self, _row: usize) -> &[f64] {
        &self.residual
    }
    fn measured(&self, _row: usize) -> Option<Vec<f64>> {
        Some(self.reported.clone())
    }
    fn response(&self, effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
        let mut all = vec![0.0; self.time.len()];
        for effect in effects {
            let text = effect.law_text().unwrap();
            let torque = effect.kind.law.acts() == Acts::Torque;
            let variables: &[&str] = if torque { &VARIABLES } else { &["reading"] };
            let mut law = BoundLaw::new(text, variables, effect).unwrap();
            for ((all, v), reading) in all.iter_mut().zip(&self.velocity).zip(&self.reported) {
                *all += match torque {
                    true => law.at(&[0.0, *v, 0.0, 0.0, 0.0, 0.0, 0.0], &mut Vec::new()),
                    false => reading - law.at(&[*reading], &mut Vec::new()),
                };
            }
        }
        vec![(0, all)]
    }
    fn smeared(&self) -> usize {
        self.smeared
    }
    fn candidates(&self) -> Vec<(&'static Kind, Location)> {
        Vec::new()
    }
    fn signals(&self, _row: usize) -> Vec<(String, Vec<f64>)> {
        vec![("velocity".to_owned(), self.velocity.clone())]
    }
}

/// All samples with the smoothed sign gave 0.969 ± 0.031.
#[test]
fn friction_at_rest_is_that_of_a_sharp_sign() {
    let hinge =
        Hinge::new(|_, v, noise| [(0.5 + 0.4 * (-(v / 0.06).powi(2)).exp()) * v.signum() + noise, 0.0]);
    let start = [("coulomb", 0.45), ("static", 1.0), ("stribeck_velocity", 0.07)];
    let [found, half] = hinge.estimated(&kinds::STRIBECK_FRICTION, &start, "static");
    assert!((found - 0.9).abs() < half && half < 0.05, "{found} ± {half}");
}

/// A filter rounds the corners of what the motion needs: from all samples the limit came out at 1.9960 ± 0.0021.
#[test]
fn limits_are_those_of_torques_that_are_surely_beyond() {
    let wanted = |t: f64| 2.5 * (2.3 * t).sin();
    let limited = |t: f64| wanted(t).clamp(-2.0, 2.0);
    let hinge = Hinge::new(|t, _, noise| {
        let rounded = (-20..=20).map(|k| limited(t + 0.003 * f64::from(k))).sum::<f64>() / 41.0;
        [wanted(t) + noise, rounded]
    });
    let [found, half] = hinge.estimated(&kinds::TORQUE_SATURATION, &[("limit", 1.9)], "limit");
    assert!((found - 2.0).abs() < 0.002, "{found}");
    // What filters do to limits is stated besides the scatter.
    assert!(half > CLIPPED * found && half < 1.1 * CLIPPED * found, "{half}");
}

/// Where commands are so noisy that a search sees no difference between limits it may begin at half of one: the estimate stayed within 40 % of where it began.
#[test]
fn limits_are_found_from_half_of_them_and_from_twice() {
    let wanted = |t: f64| 6.0 * (2.3 * t).sin();
    let hinge = Hinge::new(|t, _, noise| [wanted(t) + noise, wanted(t).clamp(-2.0, 2.0)]);
    for start in [1.0, 4.0] {
        let [found, half] = hinge.estimated(&kinds::TORQUE_SATURATION, &[("limit", start)], "limit");
        assert!((found - 2.0).abs() < half && half < 0.1, "from {start}: {found} ± {half}");
    }
}

/// Goes back, slowly, for a quarter of a second every two seconds: one and a half periods of a filter of 10 Hz away from reversals joints always go forward, where dry and
/// viscous friction are one constant.
#[test]
fn friction_that_shows_near_reversals_alone_is_told_from_another() {
    let goes_back = |t: f64| t % 2.0 < 0.24;
    let turns = |t: f64| t % 2.0 < 0.006 || (t % 2.0 - 0.24).abs() < 0.006;
    let speed = |t: f64| if turns(t) { 1e-3 } else { 1.0 } * if goes_back(t) { -0.15 } else { 0.4 };
    let mut hinge = Hinge::moving(speed, |_, v, noise| [0.5 * v.signum() + 0.5 * v + noise, 0.0]);
    hinge.smeared = 25;
    let of = |kind, start: &[(&str, f64)]| Effect::new(kind, Location::joint("hinge"), start);
    let dry = of(&kinds::COULOMB_FRICTION, &[("torque", 0.3)]);
    let refined = hinge.refined(vec![dry, of(&kinds::VISCOUS_FRICTION, &[("damping", 0.1)])]);
    let (torque, half) = (refined.effects[0].value("torque"), refined.half_width[0][0].1);
    assert!((torque - 0.5).abs() < half && half < 0.02, "{torque} ± {half}");
}
