//! A posture table as rows that are linear in the parameters.
use crate::experiments::postures::{Moments, PostureExperiment};
use crate::experiments::{Channel, Experiment, Inertial, Row};
use crate::identify::BaseSet;
use crate::measure::JointPositions;
use crate::robot::InertialParameters;
use bipedc_effects::effect::{Effect, Kind, Location};
use nalgebra::{DMatrix, DVector};

/// Parts of a regressor below this are nothing, N m per kg, kg m.
const NOTHING: f64 = 1e-12;

/// Rows `sole/moment/x`, `sole/moment/y` (N m) of static postures: the ground's moment about the stance sole.
///
/// Samples are numbered from zero in the order of the table: postures that follow one another often share their foot
/// placement, so neighbours make one stretch.
pub struct PostureTable {
    rows: Vec<Row>,
    number: Vec<f64>,
    measured: [Vec<f64>; 2],
    residual: [Vec<f64>; 2],
    inertial: [Inertial; 2],
    /// Force along the sole's normal, N.
    normal: Vec<f64>,
    parameters: InertialParameters,
    bodies: Vec<String>,
}

impl PostureTable {
    /// The rows of a table for a robot that weighs `mass` (kg).
    pub fn new(postures: &PostureExperiment<'_>, mass: f64) -> Self {
        Self::of_moments(postures.moments(mass), postures.inertial_parameters(), postures.bodies())
    }

    /// The same from moments however they were come by.
    pub fn of_moments(moments: Moments, parameters: &InertialParameters, bodies: &[String]) -> Self {
        let (count, width) = (moments.normal.len(), parameters.len());
        let residual = [0, 1].map(|axis: usize| {
            let predicted = moments.columns[axis].chunks_exact(width.max(1)).map(|row| dot(row, parameters));
            moments.measured[axis].iter().zip(predicted).map(|(m, p)| m - p).collect()
        });
        let inertial = moments.columns.each_ref().map(|values| sparse(values, width));
        let row = |axis: &str| Row {
            name: format!("sole/moment/{axis}"),
            channel: Channel::BaseMoment,
            unit: "N m",
            joint: None,
            noise: 1.0,
        };
        Self {
            rows: vec![row("x"), row("y")],
            number: (0..count).map(|i| i as f64).collect(),
            measured: moments.measured,
            residual,
            inertial,
            normal: moments.normal,
            parameters: parameters.clone(),
            bodies: bodies.to_vec(),
        }
    }

    /// Number of postures.
    pub fn postures(&self) -> usize {
        self.normal.len()
    }

    /// Force along the sole's normal by posture, N.
    pub fn normal(&self) -> &[f64] {
        &self.normal
    }

    /// The regression on base parameters: `[W | y]`, rows posture by posture, x before y; N m.
    pub fn regression(&self, base: &BaseSet) -> (DMatrix<f64>, DVector<f64>) {
        let rows = 2 * self.postures();
        let mut w = DMatrix::zeros(rows, base.sums.len());
        for (axis, inertial) in self.inertial.iter().enumerate() {
            let width = inertial.columns.len();
            for k in 0..base.sums.len() {
                let place = inertial.columns.iter().position(|c| Some(*c) == base.leading(k));
                let Some(place) = place else { continue };
                for i in 0..self.postures() {
                    w[(2 * i + axis, k)] = inertial.values[i * width + place];
                }
            }
        }
        (w, DVector::from_fn(rows, |r, _| self.measured[r % 2][r / 2]))
    }

    /// Centres of pressure missed by moments that are missed by so much: x and y in m, by posture.
    pub fn centers(&self, moments: &DVector<f64>) -> Vec<[f64; 2]> {
        let of = |i: usize| [-moments[2 * i + 1] / self.normal[i], moments[2 * i] / self.normal[i]];
        (0..self.postures()).map(of).collect()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// The columns that are not zero.
fn sparse(values: &[f64], width: usize) -> Inertial {
    let matters = |k: &usize| values.iter().skip(*k).step_by(width).any(|x| x.abs() > NOTHING);
    let columns: Vec<usize> = (0..width).filter(matters).collect();
    let rows = values.chunks_exact(width.max(1));
    Inertial { values: rows.flat_map(|row| columns.iter().map(|k| row[*k])).collect(), columns }
}

impl Experiment for PostureTable {
    fn rows(&self) -> &[Row] {
        &self.rows
    }
    fn time(&self) -> &[f64] {
        &self.number
    }
    fn residual(&self, row: usize) -> &[f64] {
        &self.residual[row]
    }
    fn measured(&self, row: usize) -> Option<Vec<f64>> {
        self.measured.get(row).cloned()
    }
    fn response(&self, _effects: &[Effect]) -> Vec<(usize, Vec<f64>)> {
        Vec::new()
    }
    fn candidates(&self) -> Vec<(&'static Kind, Location)> {
        Vec::new()
    }
    fn inertial_count(&self) -> usize {
        self.parameters.len()
    }
    fn inertial_parameters(&self) -> &InertialParameters {
        &self.parameters
    }
    fn inertial(&self, row: usize) -> Option<&Inertial> {
        self.inertial.get(row)
    }
    fn motion(&self) -> JointPositions {
        // Postures have no rate: their order cuts them into stretches, and nothing is looked for that repeats.
        JointPositions { time: self.number.clone(), positions: Vec::new() }
    }
    fn bodies(&self) -> &[String] {
        &self.bodies
    }
}
