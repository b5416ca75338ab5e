//! Flat soles that turn: their friction acts in the middle, not at the corners.
use std::ops::Range;

/// Soles whose turning about the vertical is limited by a law of its own (`spin_friction`).
#[derive(Debug, Clone, Default)]
pub(super) struct Soles {
    /// Contact points of each.
    pub points: Vec<Range<usize>>,
    /// Largest moment about the vertical per normal force, m.
    pub turning: f64,
    /// Horizontal positions of all contact points, m.
    pub places: Vec<f64>,
}

/// Corners on the ground from which on a sole is flat.
const FLAT: usize = 3;

impl Soles {
    /// The sole that begins with this point, if it stands flat: corners up to this height (m) are on the ground.
    pub fn flat(&self, point: usize, gaps: &[f64], height: f64) -> Option<usize> {
        let index = self.points.iter().position(|points| points.start == point)?;
        let closed = gaps[self.points[index].clone()].iter().filter(|gap| **gap <= height).count();
        (closed >= FLAT).then_some(index)
    }

    /// How much of each point's velocity along x and y is in the rows of a sole: its middle along x and y, and its turning
    /// about the vertical, `Σ r × v / Σ r²` with r from the middle.
    pub fn parts(&self, index: usize) -> impl Iterator<Item = (usize, [[f64; 2]; 3])> + '_ {
        let points = self.points[index].clone();
        let place = |point: usize| [self.places[2 * point], self.places[2 * point + 1]];
        let share = 1.0 / points.len() as f64;
        let mut middle = [0.0; 2];
        points.clone().for_each(|point| (0..2).for_each(|i| middle[i] += share * place(point)[i]));
        let arm = move |point: usize| [place(point)[0] - middle[0], place(point)[1] - middle[1]];
        let square: f64 = points.clone().map(|point| arm(point).iter().map(|x| x * x).sum::<f64>()).sum();
        points.map(move |point| {
            let [x, y] = arm(point);
            (point, [[share, 0.0], [0.0, share], [-y / square, x / square]])
        })
    }
}
