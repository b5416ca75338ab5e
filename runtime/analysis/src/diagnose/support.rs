//! Whether a log can support what is estimated from it: the trap of free swings.
//!
//! Where the drives do little, gravity and inertia cancel and the torque is next to nothing. Least squares then fit
//! noise: velocities and accelerations carry it, and the noisier a regressor, the smaller its coefficient (errors in
//! variables). All parameters come out too small, with narrow error bars. The tell-tale needs no truth: with a higher
//! cut-off there is more noise in the motion, and the model's torque fades from the measured one.
use crate::experiments::{Channel, Experiment, Inertial};
use crate::parallel::parallel;
use nalgebra::{DMatrix, DVector};

/// A scale that loses more than this part of itself when the cut-off doubles has faded.
const FADES: f64 = 0.25;
/// At least this part of the loss must be what noise costs: as much as the squares of the model's torque grow by it (at three joints
/// of free swings 0.31 to 0.36, of losses of 0.34). Friction that the fit beside it tells badly changes scales too, and no noise does that.
const BY_NOISE: f64 = 0.7;
/// A model's torque over the measurement's noise, from which on it is worth a warning that it fades.
pub const LOUD: f64 = 3.0;
/// A joint whose load varies by less than this part of it holds it: its bias tells the load, and noise alone what varies.
const VARIES: f64 = 0.05;
/// Speed over which the sign of velocity is smoothed, rad/s.
const SMOOTHING: f64 = 0.02;
/// Fewest samples that say anything.
const FEWEST: usize = 100;

/// How much of the model's torque a joint's log shows, at two cut-offs of the filter.
#[derive(Debug, Clone, PartialEq)]
pub struct Fading {
    /// Joint.
    pub joint: String,
    /// Factor on the rigid-body model's torque that fits the measured torque best, friction and bias beside it.
    pub scale: f64,
    /// The same with the higher cut-off; as large as `scale` on a log that supports estimates.
    pub faster: f64,
    /// Root mean square of the measured torque, N m.
    pub measured: f64,
    /// Root mean square of the model's torque, N m.
    pub modelled: f64,
}

/// Factor on the model's torque, and root mean squares.
struct Scale {
    factor: f64,
    measured: f64,
    modelled: f64,
    /// Of the model's torque without what goes with friction and bias: what tells the factor.
    own: f64,
}

/// Joints whose measured torque loses the model's when the cut-off is raised. Both experiments are of the same log,
/// `faster` with the higher cut-off (twice as high, say).
///
/// Joints whose model predicts less torque than `loud` times the measurement's noise are passed over.
pub fn fading(slower: &dyn Experiment, faster: &dyn Experiment, loud: f64) -> Vec<Fading> {
    let rows = slower.rows();
    let fading = parallel(rows.len(), |index| {
        let row = &rows[index];
        if row.channel != Channel::Effort {
            return None;
        }
        let other = faster.rows().iter().position(|r| r.name == row.name)?;
        let (a, b) = (scale(slower, index)?, scale(faster, other)?);
        // A negative scale is a wrong sign or another robot: no matter of noise.
        let fades = a.factor > 0.0 && b.factor < (1.0 - FADES) * a.factor;
        // Were the motion's noise all, factors would go with one over the squares.
        let by_noise = 1.0 - (a.own / b.own).powi(2);
        let noisier =
            by_noise > BY_NOISE * (1.0 - b.factor / a.factor).min(1.0) && a.modelled > loud * row.noise;
        let varies = a.own > VARIES * a.modelled;
        (fades && noisier && varies).then(|| Fading {
            joint: row.joint.clone().unwrap_or_else(|| row.name.clone()),
            scale: a.factor,
            faster: b.factor,
            measured: a.measured,
            modelled: a.modelled,
        })
    });
    fading.into_iter().flatten().collect()
}

/// Least squares of the measured torque on the model's, viscous and Coulomb friction, and a constant.
fn scale(experiment: &dyn Experiment, row: usize) -> Option<Scale> {
    let (velocity, load) = (experiment.signal(row, "velocity")?, experiment.signal(row, "load")?);
    let residual = experiment.residual(row);
    if load.len() != residual.len() {
        return None;
    }
    let told = told(experiment, row);
    let n = told.len();
    if n < FEWEST {
        return None;
    }
    let measured = DVector::from_fn(n, |k, _| residual[told[k]] + load[told[k]]);
    let columns = DMatrix::from_fn(n, 4, |k, column| match column {
        0 => load[told[k]],
        1 => velocity[told[k]],
        2 => (velocity[told[k]] / SMOOTHING).tanh(),
        _ => 1.0,
    });
    let right = columns.tr_mul(&measured);
    let gram = columns.tr_mul(&columns).cholesky()?;
    let rms = |squares: f64| (squares / n as f64).sqrt();
    Some(Scale {
        factor: gram.solve(&right)[0],
        own: rms(gram.inverse()[(0, 0)].recip()),
        measured: rms(measured.norm_squared()),
        modelled: rms(columns.column(0).norm_squared()),
    })
}

/// Samples at which a row's effort is told by the motion: no joint sticks and nothing shakes the robot.
fn told(experiment: &dyn Experiment, row: usize) -> Vec<usize> {
    let sticks = experiment.sticks(row);
    (0..experiment.residual(row).len()).filter(|i| !sticks.get(*i).is_some_and(|sticks| *sticks)).collect()
}

/// Largest number of samples that [`kept`] looks at.
const SAMPLES: usize = 2000;
/// Ridge on columns of unit length: directions that the motion hardly excites stay at zero.
const RIDGE: f64 = 1e-4;
/// Less than this part of the inertial parameters kept while the cut-off becomes four times as high: they are noise.
pub const KEEPS: f64 = 0.6;

/// Which part of the freely estimated inertial parameters is kept when the filter's cut-off is raised: 1 on a log that
/// supports estimates, whatever the URDF says. Both experiments are of the same log; friction and a bias are estimated
/// beside them at every joint. `None` without inertial parameters.
pub fn kept(slower: &dyn Experiment, faster: &dyn Experiment) -> Option<f64> {
    let mut both = parallel(2, |i| Free::new([slower, faster][i])).into_iter();
    let (a, b) = (both.next()??, both.next()??);
    // As torques of the slower motion, so that units do not matter.
    let product = |x: &DVector<f64>, y: &DVector<f64>| -> f64 {
        x.iter().zip(y.iter()).zip(&a.lengths).map(|((x, y), length)| x * y * length * length).sum()
    };
    let size = product(&a.parameters, &a.parameters);
    (size > 0.0).then(|| product(&a.parameters, &b.parameters) / size)
}

/// Least squares of all inertial parameters at once.
struct Free {
    parameters: DVector<f64>,
    /// Lengths of their columns.
    lengths: Vec<f64>,
}

impl Free {
    fn new(experiment: &dyn Experiment) -> Option<Self> {
        let p = experiment.inertial_count();
        if p == 0 {
            return None;
        }
        let picked: Vec<Vec<usize>> =
            (0..experiment.rows().len()).map(|row| picked(experiment, row)).collect();
        let mut samples = picked.concat();
        samples.sort_unstable();
        samples.dedup();
        let inertial = experiment.inertial_at(&samples);
        let rows: Vec<(usize, &Inertial)> = inertial
            .iter()
            .enumerate()
            .filter_map(|(row, inertial)| Some((row, inertial.as_ref()?)))
            .collect();
        if rows.is_empty() {
            return None;
        }
        let size = p + 3 * rows.len();
        let (mut gram, mut right) = (DMatrix::<f64>::zeros(size, size), DVector::<f64>::zeros(size));
        for (place, (row, inertial)) in rows.into_iter().enumerate() {
            let told = Told { row, picked: &picked[row], samples: &samples, inertial };
            add_row(experiment, &told, p + 3 * place, &mut gram, &mut right)?;
        }
        let lengths: Vec<f64> = (0..size).map(|k| gram[(k, k)].sqrt()).collect();
        let unit = |k: usize| if lengths[k] > 0.0 { 1.0 / lengths[k] } else { 0.0 };
        let scaled = DMatrix::from_fn(size, size, |r, c| {
            gram[(r, c)] * unit(r) * unit(c) + if r == c { RIDGE } else { 0.0 }
        });
        let solution = scaled.cholesky()?.solve(&DVector::from_fn(size, |k, _| right[k] * unit(k)));
        Some(Self { parameters: DVector::from_fn(p, |k, _| solution[k] * unit(k)), lengths })
    }
}

/// Samples of a row that are looked at.
fn picked(experiment: &dyn Experiment, row: usize) -> Vec<usize> {
    let told = told(experiment, row);
    let stride = told.len().div_ceil(SAMPLES).max(1);
    told.into_iter().step_by(stride).collect()
}

/// What a row tells of inertial parameters.
struct Told<'a> {
    row: usize,
    picked: &'a [usize],
    /// Those of all rows, increasing, at which `inertial` is.
    samples: &'a [usize],
    inertial: &'a Inertial,
}

/// Adds the products of one joint's columns; its friction and bias have the three unknowns from `first` on.
fn add_row(
    experiment: &dyn Experiment,
    told: &Told<'_>,
    first: usize,
    gram: &mut DMatrix<f64>,
    right: &mut DVector<f64>,
) -> Option<()> {
    let Told { row, picked, samples, inertial } = *told;
    let (velocity, load) = (experiment.signal(row, "velocity")?, experiment.signal(row, "load")?);
    let residual = experiment.residual(row);
    let width = inertial.columns.len();
    let places: Vec<usize> = inertial.columns.iter().copied().chain(first..first + 3).collect();
    let mut columns = DMatrix::zeros(picked.len(), width + 3);
    for (mut values, &i) in columns.row_iter_mut().zip(picked) {
        let at = samples.partition_point(|sample| *sample < i) * width;
        let rubbing = [velocity[i], (velocity[i] / SMOOTHING).tanh(), 1.0];
        let all = inertial.values[at..at + width].iter().chain(&rubbing);
        values.iter_mut().zip(all).for_each(|(value, x)| *value = *x);
    }
    let measured = DVector::from_iterator(picked.len(), picked.iter().map(|&i| residual[i] + load[i]));
    let (own, along) = (crate::gram::gram(&columns), columns.tr_mul(&measured));
    for (a, x) in places.iter().enumerate() {
        right[*x] += along[a];
        places.iter().enumerate().for_each(|(b, y)| gram[(*x, *y)] += own[(a, b)]);
    }
    Some(())
}

/// One warning of all joints whose torque fades, for people; `None` without any. `cutoffs` are both filters', Hz.
pub fn warning(fading: &[Fading], cutoffs: [f64; 2]) -> Option<String> {
    let of_joint = |joint: &Fading| {
        format!(
            "{} ({:.3} N m rms, {:.3} measured: {:.0} %, {:.0} %)",
            joint.joint,
            joint.modelled,
            joint.measured,
            100.0 * joint.scale,
            100.0 * joint.faster
        )
    };
    let joints: Vec<String> = fading.iter().map(of_joint).collect();
    let [slower, faster] = cutoffs;
    (!joints.is_empty()).then(|| {
        format!(
            "this log hardly supports estimates, as free swings do: of the torque that the model expects a part shows in the measured one \
             with a filter of {slower:.1} Hz, and less with {faster:.1} Hz, at {}; parameters that shrink so come from noise in the motion, \
             and all of them are too small",
            joints.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::experiments::Row;
    use bipedc_effects::effect::{Effect, Kind, Location};

    /// One joint: torque and load as given.
    struct Pendulum {
        rows: Vec<Row>,
        residual: Vec<f64>,
        velocity: Vec<f64>,
        load: Vec<f64>,
        time: Vec<f64>,
    }

    impl Pendulum {
        /// The drive gives `driven` of the load; the motion's noise adds `noise` to what the model makes of it.
        fn new(driven: f64, noise: f64) -> Self {
            let time: Vec<f64> = (0..2000).map(|i| 0.005 * f64::from(i)).collect();
            let velocity: Vec<f64> = time.iter().map(|t| (7.0 * t).cos()).collect();
            let clean: Vec<f64> = time.iter().map(|t| driven * (3.0 * t + 0.3).sin()).collect();
            // A quick sine stands for noise: it goes with nothing else.
            let load: Vec<f64> =
                clean.iter().zip(&time).map(|(c, t)| c + noise * (211.0 * t).sin()).collect();
            let residual = clean
                .iter()
                .zip(&load)
                .zip(&velocity)
                .map(|((c, l), v)| c + 0.2 * (v / SMOOTHING).tanh() - l)
                .collect();
            let row = Row {
                name: "hinge".to_owned(),
                channel: Channel::Effort,
                unit: "N m",
                joint: Some("hinge".to_owned()),
                noise: 0.01,
            };
            Self { rows: vec![row], residual, velocity, load, time }
        }
    }

    impl Experiment for Pendulum {
        fn rows(&self) -> &[Row] {
            &self.rows
        }
        fn time(&self) -> &[f64] {
            &self.time
        }
        fn residual(&self, _row: usize) -> &[f64] {
            &self.residual
        }
        fn response(&self, _effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
            Vec::new()
        }
        fn candidates(&self) -> Vec<(&'static Kind, Location)> {
            Vec::new()
        }
        fn signals(&self, _row: usize) -> Vec<(String, Vec<f64>)> {
            let named = |name: &str, values: &Vec<f64>| (name.to_owned(), values.clone());
            vec![named("velocity", &self.velocity), named("load", &self.load)]
        }
    }

    #[test]
    fn a_swing_without_drive_fades_and_a_driven_one_does_not() {
        // The drive's part is sin, rms 0.7 of its amplitude: scale 1 / (1 + (noise / driven)²).
        let found = fading(&Pendulum::new(0.2, 0.1), &Pendulum::new(0.2, 0.3), LOUD);
        assert_eq!(found.len(), 1);
        assert!((found[0].scale - 1.0 / 1.25).abs() < 0.01, "{found:?}");
        assert!((found[0].faster - 1.0 / 3.25).abs() < 0.01, "{found:?}");
        let both = [found[0].clone(), Fading { joint: "ankle".to_owned(), ..found[0].clone() }];
        let said = warning(&both, [10.0, 20.0]).unwrap();
        assert!(said.contains("at hinge (") && said.contains(" measured: 80 %, 31 %), ankle ("), "{said}");
        assert_eq!(warning(&[], [10.0, 20.0]), None);
        assert!(fading(&Pendulum::new(3.0, 0.1), &Pendulum::new(3.0, 0.3), LOUD).is_empty());
    }

    /// Of 9.6 N m that it holds all along 2 % go up and down with what the encoder makes of its angle.
    #[test]
    fn a_joint_that_holds_its_load_is_no_free_swing() {
        let held = |noise: f64| {
            let mut joint = Pendulum::new(0.2, noise);
            joint.load.iter_mut().for_each(|load| *load += 9.6);
            joint
        };
        let [slower, faster] = [held(0.1), held(0.3)];
        assert!(scale(&faster, 0).unwrap().factor < 0.6 * scale(&slower, 0).unwrap().factor);
        assert!(fading(&slower, &faster, LOUD).is_empty());
    }

    #[test]
    fn a_scale_that_falls_without_noise_in_the_motion_is_no_free_swing() {
        let driven = Pendulum::new(0.2, 0.1);
        let mut other = Pendulum::new(0.2, 0.11);
        // Friction of another law takes half of what goes with the load.
        for (residual, load) in other.residual.iter_mut().zip(&other.load) {
            *residual -= 0.4 * load;
        }
        let [a, b] = [&driven, &other].map(|log| scale(log, 0).unwrap());
        assert!(b.factor < 0.6 * a.factor && b.own > 1.01 * a.own);
        assert!(fading(&driven, &other, LOUD).is_empty());
    }
}
