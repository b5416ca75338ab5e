//! The semidefinite program of a design's unknowns.
use crate::identify::{Design, Summand};
use crate::physical::{Bounds, Links, Problem};
use nalgebra::{DMatrix, DVector};

/// The design's unknowns as functions of the links' coordinates and of its extras.
pub fn problem<'a>(design: &Design<'_>, links: &'a Links, bounds: &'a Bounds) -> Problem<'a> {
    let (coordinates, extras) = (links.coordinates(), design.extras.len());
    let value = |parameters: &[f64]| -> DVector<f64> {
        let sum = |sum: &[(Summand, f64)]| -> f64 {
            sum.iter()
                .map(|(part, factor)| match part {
                    Summand::Inertial(k) => factor * parameters[*k],
                    Summand::Extra(_) => 0.0,
                })
                .sum()
        };
        DVector::from_iterator(design.unknowns.len(), design.sums().map(sum))
    };
    let mut x = vec![0.0; coordinates];
    let nominal = value(&links.parameters(&x));
    let mut slopes = DMatrix::zeros(design.unknowns.len(), coordinates + extras);
    for k in 0..coordinates {
        x[k] = 1.0;
        slopes.set_column(k, &(value(&links.parameters(&x)) - &nominal));
        x[k] = 0.0;
    }
    for (row, sum) in design.sums().enumerate() {
        for (part, factor) in sum {
            if let Summand::Extra(e) = part {
                slopes[(row, coordinates + e)] += factor;
            }
        }
    }
    let positive = (0..extras).filter(|&e| design.extras[e].law.is_positive()).collect();
    Problem::new((nominal, slopes), positive, links, bounds)
}
