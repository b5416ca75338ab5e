//! What was found of the drives; the keys under `drives` of `identify --method elastic --json`.
use super::super::result::Parameter;
use super::super::summary::student;
use super::driven::Driven;
use super::fold::Folded;
use super::laws::{Estimator, Laws, Steps};
use super::look::Look;
use super::run::Elastic;
use super::solve::Solved;
use crate::robot::JointLayout;
use nalgebra::DVector;
use serde::Serialize;

/// A stiffness this many times the described one, or this part of it, deserves a word.
const STRANGE: f64 = 3.0;

/// What was found of all drives.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DriveSummary {
    /// Both regressions one after the other, or at once.
    pub steps: Steps,
    /// How residuals count.
    pub estimator: Estimator,
    /// Samples count for friction where the motor is nowhere near slower than this part of its largest speed, per cent.
    pub slow_percent: f64,
    /// One per drive, in the order of the joints.
    pub joints: Vec<JointDriveSummary>,
}

/// One drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointDriveSummary {
    /// The driven joint.
    pub joint: String,
    /// `series_elastic`, `stiff` or `passive`.
    pub kind: &'static str,
    /// Estimates, at the motor shaft; none of a passive joint.
    pub parameters: Vec<DriveParameter>,
    /// Rows of the motor's regression; of series elastic drives only.
    pub rows: usize,
    /// Condition number of the motor's regression (5.9), columns scaled to length 1.
    pub condition_number: Option<f64>,
    /// Smallest and largest torque of the spring on the joint, N m.
    pub spring_torque: Option<[f64; 2]>,
    /// Torque of the motor less its rotor's: root mean squares on the logs that taught.
    pub motor: Option<MotorErrors>,
    /// The same on the validation log.
    pub validation: Option<MotorErrors>,
}

/// Root mean squares at the motor shaft, N m.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct MotorErrors {
    /// Of the measured torque less what the rotor takes.
    pub measured: f64,
    /// Of what the description misses of it.
    pub described: f64,
    /// Of what the estimate misses.
    pub estimated: f64,
}

/// One estimate of a drive.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct DriveParameter {
    /// `viscous_friction`, `coulomb_friction`, `torque_offset` at the motor shaft; `spring_stiffness` in the cable;
    /// `joint_stiffness` at the joint.
    pub name: &'static str,
    /// Of all numbers.
    pub unit: &'static str,
    /// Estimate.
    pub value: f64,
    /// One standard deviation, errors that last taken into account.
    pub standard_error: f64,
    /// As if residuals were independent (8.2, 8.3).
    pub independent_error: f64,
    /// `standard_error` over |value|, per cent; absent where the value is zero.
    pub relative_error_percent: Option<f64>,
    /// 95 % confidence interval.
    pub interval: [f64; 2],
    /// Of the description.
    pub nominal: f64,
    /// Whether the relative error is below 15 %.
    pub well_identified: bool,
}

impl DriveParameter {
    fn new(
        (name, unit): (&'static str, &'static str),
        value: f64,
        errors: [f64; 2],
        nominal: f64,
        t: f64,
    ) -> Self {
        let [standard_error, independent_error] = errors;
        let relative = (value != 0.0).then(|| 100.0 * standard_error / value.abs());
        Self {
            name,
            unit,
            value,
            standard_error,
            independent_error,
            relative_error_percent: relative,
            interval: [value - t * standard_error, value + t * standard_error],
            nominal,
            well_identified: relative.is_some_and(|percent| percent < 15.0),
        }
    }

    /// The same in other units.
    fn scaled(&self, (name, unit): (&'static str, &'static str), factor: f64) -> Self {
        let t = if self.standard_error > 0.0 {
            (self.interval[1] - self.value) / self.standard_error
        } else {
            0.0
        };
        let errors = [self.standard_error, self.independent_error].map(|e| e * factor.abs());
        Self::new((name, unit), factor * self.value, errors, factor * self.nominal, t)
    }
}

/// What summaries are made of.
pub struct SummaryInput<'a> {
    pub layout: &'a JointLayout,
    pub drives: &'a [Driven<'a>],
    pub looks: &'a [Look],
    pub folded: &'a Folded,
    pub judged: Option<&'a Folded>,
    pub solved: &'a Solved,
    pub laws: Laws,
}

impl SummaryInput<'_> {
    /// All drives; `parameters` are those of the joints' regression.
    pub fn summary(&self, options: &Elastic, parameters: &[Parameter]) -> DriveSummary {
        DriveSummary {
            steps: options.steps,
            estimator: options.estimator,
            slow_percent: 100.0 * options.slow,
            joints: self.joints(parameters),
        }
    }

    fn joints(&self, parameters: &[Parameter]) -> Vec<JointDriveSummary> {
        let elastic = |index: usize| self.folded.elastic.iter().position(|t| *t == index);
        let of = |(index, driven): (usize, &Driven<'_>)| match elastic(index) {
            Some(k) => self.elastic(k, index, driven),
            None => self.other(driven, parameters),
        };
        self.drives.iter().enumerate().map(of).collect()
    }

    fn elastic(&self, k: usize, index: usize, driven: &Driven<'_>) -> JointDriveSummary {
        let (estimated, nominal) = (&self.solved.motors[k], self.laws.nominal(driven.drive));
        let t = student(self.solved.stretches);
        let mut parameters: Vec<DriveParameter> = (self.laws.names().into_iter().enumerate())
            .map(|(i, name)| {
                DriveParameter::new(name, estimated.value[i], estimated.errors(i), nominal[i], t)
            })
            .collect();
        let spring = parameters[self.laws.stiffness()].clone();
        let at_joint = spring.scaled(("joint_stiffness", "N m/rad"), driven.drive.load_radius().powi(2));
        parameters.push(at_joint);
        let torque = spring.value * driven.drive.load_radius();
        let extents = self.looks.iter().map(|look| look.drives[index].elongation);
        let [low, high] = extents
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], e| [low.min(e.low), high.max(e.high)]);
        JointDriveSummary {
            joint: self.name(driven),
            kind: driven.drive.transmission.kind(),
            parameters,
            rows: self.folded.motor_rows(k),
            condition_number: Some(self.solved.condition[k]),
            spring_torque: Some(if torque < 0.0 { [high, low] } else { [low, high] }.map(|x| x * torque)),
            motor: self.errors(self.folded, k, driven),
            validation: self.judged.and_then(|judged| self.errors(judged, k, driven)),
        }
    }

    /// Friction of stiff drives comes with the joints' rows: torques at the joint, speeds of the joint.
    fn other(&self, driven: &Driven<'_>, parameters: &[Parameter]) -> JointDriveSummary {
        let name = self.name(driven);
        let drive = driven.drive;
        let gear = drive.gear_ratio.abs();
        let laws = [
            ("viscous_friction", "N m s/rad", 1.0 / (gear * gear), drive.viscous_friction),
            ("coulomb_friction", "N m", 1.0 / gear, drive.coulomb_friction),
            ("torque_offset", "N m", 1.0 / drive.gear_ratio, 0.0),
        ];
        let t = student(self.solved.stretches);
        let found = laws.iter().filter_map(|(law, unit, factor, nominal)| {
            let full = format!("{name}.{law}");
            let p = parameters.iter().find(|p| p.name == full)?;
            let errors = [p.standard_error, p.independent_error].map(|e| e * factor.abs());
            Some(DriveParameter::new((law, unit), p.value * factor, errors, *nominal, t))
        });
        JointDriveSummary {
            parameters: if drive.is_stiff() { found.collect() } else { Vec::new() },
            joint: name,
            kind: driven.drive.transmission.kind(),
            rows: 0,
            condition_number: None,
            spring_torque: None,
            motor: None,
            validation: None,
        }
    }

    fn name(&self, driven: &Driven<'_>) -> String {
        self.layout.joints[driven.joint].name.clone()
    }

    fn errors(&self, folded: &Folded, k: usize, driven: &Driven<'_>) -> Option<MotorErrors> {
        let zeros = if folded.instruments { self.laws.count() } else { 0 };
        let padded = |values: &DVector<f64>| {
            DVector::from_iterator(
                zeros + values.len(),
                std::iter::repeat_n(0.0, zeros).chain(values.iter().copied()),
            )
        };
        let (estimate, nominal) =
            (padded(&self.solved.motors[k].value), padded(&self.laws.nominal(driven.drive)));
        let sum = |of: &dyn Fn(&super::super::triangle::Triangle) -> f64| -> f64 {
            folded.motors.iter().map(|cell| of(&cell[k])).sum()
        };
        let rows = folded.motor_rows(k);
        let rms = |squares: f64| (squares / rows as f64).sqrt();
        (rows > 0).then(|| MotorErrors {
            measured: rms(sum(&|t| t.right_squares())),
            described: rms(sum(&|t| t.squares(&nominal))),
            estimated: rms(sum(&|t| t.squares(&estimate))),
        })
    }
}

impl JointDriveSummary {
    /// What is strange about the numbers.
    pub fn warnings(&self) -> Vec<String> {
        let joint = &self.joint;
        let odd = |p: &DriveParameter| match p.name {
            "spring_stiffness" if p.value <= 0.0 => Some(format!(
                "`spring_stiffness` of `{joint}` comes out negative ({:.0} ± {:.0} N/m): signs of current and motor_position must agree, and `torque_constant` be that of the motor",
                p.value, p.standard_error
            )),
            "spring_stiffness" if p.value > STRANGE * p.nominal || p.value * STRANGE < p.nominal => {
                Some(format!(
                    "`spring_stiffness` of `{joint}` is {:.2} times the described one: are angles in rad, the current in A, and gear, pulleys and `torque_constant` those of this drive?",
                    p.value / p.nominal
                ))
            }
            "viscous_friction" | "coulomb_friction" if p.interval[1] < 0.0 => Some(format!(
                "`{}` of `{joint}` comes out negative ({:.3e} ± {:.1e} {}): friction never drives",
                p.name, p.value, p.standard_error, p.unit
            )),
            _ if p.name != "torque_offset" && p.name != "joint_stiffness" && !p.well_identified => {
                Some(format!(
                    "`{}` of `{joint}` is uncertain: {:.3e} ± {:.1e} {}",
                    p.name, p.value, p.standard_error, p.unit
                ))
            }
            _ => None,
        };
        self.parameters.iter().filter_map(odd).collect()
    }
}
