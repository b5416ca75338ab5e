//! How well a motion tells two effects apart, and how that changes with the motion.
use super::angle::View;
use super::columns::{Bench, Columns};
use super::{Reduced, beside_each_other};
use crate::identify::excite::search::Objective;
use crate::robot::Trajectory;
use bipedc_effects::diagnostic::Diagnostic;
use nalgebra::DMatrix;
use serde::Serialize;

/// Step of central differences, rad and rad/s, rad/s².
const STEP: f64 = 1e-5;

/// How well a motion tells two effects apart.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Separation {
    /// Largest canonical correlation of what the two do to the torques; those that are 1 along every motion do not count.
    pub correlation: f64,
    /// Its angle, rad.
    pub angle: f64,
    /// What each effect does at usual values, root mean square over measured joints and time, N m.
    pub sizes: [f64; 2],
    /// What remains of that whatever the other effect (and the bodies) are, N m.
    pub rests: [f64; 2],
    /// The cost that was made small.
    pub cost: f64,
}

/// Tells two effects apart.
pub(super) struct Apart<'r, 'm> {
    bench: Bench<'r, 'm>,
    reduced: Reduced,
}

impl<'r, 'm> Apart<'r, 'm> {
    pub fn new(bench: Bench<'r, 'm>, reduced: Reduced) -> Self {
        Self { bench, reduced }
    }

    /// The columns that count, as the layout says.
    fn matrix(&self, motion: &Trajectory) -> Result<DMatrix<f64>, Diagnostic> {
        let Columns { effects: [first, second], usual, beside } = self.bench.columns(motion)?;
        let reduced = &self.reduced;
        Ok(beside_each_other(&[
            &(first * &reduced.effects[0]),
            &(second * &reduced.effects[1]),
            &(beside * &reduced.beside),
            &usual,
        ]))
    }

    /// The cost and its derivatives by every element of the matrix.
    fn slopes(&self, matrix: &DMatrix<f64>) -> Option<(f64, DMatrix<f64>)> {
        let layout = self.reduced.layout;
        let (mut cost, mut slopes) = View::new(matrix, layout)?.slopes(matrix, layout)?;
        let (rows, noise) = (matrix.nrows() as f64, self.bench.pair.noise.powi(2));
        for k in matrix.ncols() - 2..matrix.ncols() {
            let square = matrix.column(k).norm_squared() / rows;
            if square <= 0.0 {
                return None;
            }
            cost += 0.5 * (noise / square).ln_1p();
            slopes.set_column(k, &(matrix.column(k) * (-noise / (square * (square + noise) * rows))));
        }
        Some((cost, slopes))
    }

    fn separation(&self, matrix: &DMatrix<f64>) -> Option<Separation> {
        let layout = self.reduced.layout;
        let view = View::new(matrix, layout)?;
        let (.., sine) = view.pair(layout.common)?;
        let rms = |square: f64| (square / matrix.nrows() as f64).sqrt();
        let usual = [2, 1].map(|back| matrix.column(matrix.ncols() - back).into_owned());
        let correlation = view.correlations[layout.common].clamp(0.0, 1.0);
        Some(Separation {
            correlation,
            angle: sine.atan2(correlation),
            sizes: usual.each_ref().map(|column| rms(column.norm_squared())),
            rests: [0, 1].map(|k| rms(view.rest(&usual[k], 1 - k).norm_squared())),
            cost: self.slopes(matrix).map_or(f64::INFINITY, |(cost, _)| cost),
        })
    }
}

impl Objective for Apart<'_, '_> {
    type Quality = Separation;

    fn quality(&self, motion: &Trajectory) -> Result<Separation, Diagnostic> {
        let nothing = Separation {
            correlation: 1.0,
            angle: 0.0,
            sizes: [0.0; 2],
            rests: [0.0; 2],
            cost: f64::INFINITY,
        };
        Ok(self.separation(&self.matrix(motion)?).unwrap_or(nothing))
    }

    /// From the cost to the columns analytically, from columns to states by central differences.
    ///
    /// All samples change at once; where a sample's torques depend on its neighbours, every n-th.
    fn cost(&self, motion: &Trajectory) -> Result<Option<(f64, Trajectory)>, Diagnostic> {
        let Some((cost, slopes)) = self.slopes(&self.matrix(motion)?) else { return Ok(None) };
        let machine = self.bench.machine;
        let (count, joints) = (motion.len(), machine.layout.joints.len());
        let mut gradient = motion.zeros();
        let reach = self.bench.reach(count);
        let stride = 2 * reach + 1;
        for (&joint, order, first) in machine.moving.iter().flat_map(|joint| {
            (0..3).flat_map(move |order| (0..stride).map(move |first| (joint, order, first)))
        }) {
            let moved = |step: f64| {
                let mut other = motion.clone();
                let values = other.order_mut(order);
                (first..count).step_by(stride).for_each(|i| values[i * joints + joint] += step);
                self.matrix(&other)
            };
            let product = ((moved(STEP)? - moved(-STEP)?) / (2.0 * STEP)).component_mul(&slopes);
            let rows: Vec<f64> = product.row_iter().map(|row| row.sum()).collect();
            for i in (first..count).step_by(stride) {
                let near = i.saturating_sub(reach)..(i + reach + 1).min(count);
                let all = rows.chunks_exact(count).flat_map(|row| &row[near.clone()]);
                gradient.order_mut(order)[i * joints + joint] += all.sum::<f64>();
            }
        }
        Ok(Some((cost, gradient)))
    }

    fn better(&self, one: &Separation, other: &Separation) -> bool {
        one.cost < other.cost
    }
}
