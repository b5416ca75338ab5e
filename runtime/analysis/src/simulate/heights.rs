//! Ground that is not level: what each contact point stands on.
use bipedc_effects::random::Random;
use std::ops::Range;

/// A foot is in the air when all of its points are this far (m) above what it stood on and above what it comes down on.
const CLEAR: f64 = 0.002;

/// A foot has come down when it is at most so high, m: steps look ahead to the ground and may end a little above it.
const DOWN: f64 = 1e-4;

/// How the ground's heights are laid out. Each point is held up by level ground of its own height: normals stay vertical, and edges
/// between heights are felt by the points of a sole alone.
#[derive(Debug, Clone, PartialEq)]
pub struct Heights {
    /// What lies where.
    pub kind: HeightsKind,
    /// Heights are uniform within ± this, m.
    pub height: f64,
    /// Of tiles, and from each crest or hollow of waves to the next, m.
    pub size: f64,
    /// Around the place where the robot begins the ground is level to this distance, m.
    pub level: f64,
    /// Of the heights.
    pub seed: u64,
}

/// What [`Heights`] belong to.
#[derive(Debug, Clone, PartialEq)]
pub enum HeightsKind {
    /// Every foothold has a level plate of its own height, wherever the foot comes down: those of the list in the order in which feet are lifted, again
    /// from its beginning after its end; of an empty list random ones.
    Footholds(Vec<f64>),
    /// Square tiles of one height each.
    Tiles,
    /// Heights at the corners of squares, bilinear between them.
    Waves,
}

/// The ground below a robot, as it is now.
#[derive(Debug, Clone)]
pub(super) struct Terrain {
    heights: Heights,
    /// Contact points of each foot.
    feet: Vec<Range<usize>>,
    /// What each foot stands on, m; what it comes down on next, until that is below it.
    plates: Vec<(f64, Option<f64>)>,
    /// Where the robot begins, m.
    start: [f64; 2],
    random: Random,
    lifted: usize,
    /// Of the contact points: places (m), and the heights below them.
    pub places: Vec<f64>,
    below: Vec<f64>,
}

impl Terrain {
    /// Below a robot that begins at a place (m); `points`: contact points in all, and coordinates of each along the ground; `feet`: points
    /// of each foot.
    pub fn new(
        heights: Heights,
        feet: Vec<Range<usize>>,
        [points, tangents]: [usize; 2],
        start: [f64; 2],
    ) -> Self {
        let random = Random::new(heights.seed);
        let plates = vec![(0.0, None); feet.len()];
        let (places, below) = (vec![0.0; tangents * points], vec![0.0; points]);
        Self { heights, feet, plates, start, random, lifted: 0, places, below }
    }

    /// Takes the ground's heights off those of the contact points above z = 0, m, which are at [`Self::places`].
    pub fn lower(&mut self, gaps: &mut [f64]) {
        match self.heights.kind {
            HeightsKind::Footholds(_) => self.plates(gaps),
            HeightsKind::Tiles | HeightsKind::Waves => {
                let tangents = self.places.len() / self.below.len().max(1);
                for point in 0..self.below.len() {
                    let place = &self.places[tangents * point..];
                    self.below[point] = self.at([place[0], if tangents > 1 { place[1] } else { 0.0 }]);
                }
            }
        }
        gaps.iter_mut().zip(&self.below).for_each(|(gap, below)| *gap -= below);
    }

    /// Plates change below feet in the air.
    fn plates(&mut self, gaps: &[f64]) {
        for foot in 0..self.feet.len() {
            let points = self.feet[foot].clone();
            let lowest = gaps[points.clone()].iter().copied().fold(f64::INFINITY, f64::min);
            let (now, next) = self.plates[foot];
            self.plates[foot] = match next {
                Some(next) if lowest > now.max(next) + CLEAR => (next, None),
                None if lowest <= now + DOWN => (now, Some(self.next())),
                _ => (now, next),
            };
            self.below[points].fill(self.plates[foot].0);
        }
    }

    /// Height of the next foothold, m.
    fn next(&mut self) -> f64 {
        let index = self.lifted;
        self.lifted += 1;
        match &self.heights.kind {
            HeightsKind::Footholds(listed) if !listed.is_empty() => listed[index % listed.len()],
            _ => self.heights.height * self.random.symmetric(),
        }
    }

    /// Height at a place, m.
    fn at(&self, place: [f64; 2]) -> f64 {
        let size = self.heights.size;
        let [x, y] = place.map(|x| x / size);
        let cell = [x.floor(), y.floor()];
        if self.heights.kind == HeightsKind::Tiles {
            return self.of(cell, 0.5);
        }
        let [s, t] = [x - cell[0], y - cell[1]];
        let corner = |i: f64, j: f64| self.of([cell[0] + i, cell[1] + j], 0.0);
        let [near, far] = [0.0, 1.0].map(|j| corner(0.0, j) * (1.0 - s) + corner(1.0, j) * s);
        near * (1.0 - t) + far * t
    }

    /// Height of a tile or corner; `middle`: how far (parts of the size) its middle is from its place.
    fn of(&self, [i, j]: [f64; 2], middle: f64) -> f64 {
        let Heights { height, size, level, seed, .. } = self.heights;
        let [x, y] = [i, j].map(|k| size * (k + middle));
        let from = (x - self.start[0]).hypot(y - self.start[1]);
        if from < level {
            return 0.0;
        }
        // Neighbours have seeds far from one another.
        let key = (i as i64 as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ (j as i64 as u64).rotate_left(32);
        let mut random = Random::new(seed ^ Random::new(key).bits());
        height * random.symmetric()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heights(kind: HeightsKind) -> Heights {
        Heights { kind, height: 0.01, size: 0.3, level: 0.5, seed: 4 }
    }

    fn below(terrain: &mut Terrain, place: [f64; 2]) -> f64 {
        terrain.places = place.to_vec();
        let mut gap = [0.0];
        terrain.lower(&mut gap);
        -gap[0]
    }

    #[test]
    fn tiles_are_level_and_waves_are_continuous() {
        let [mut tiles, mut waves] = [HeightsKind::Tiles, HeightsKind::Waves]
            .map(|kind| Terrain::new(heights(kind), Vec::new(), [1, 2], [0.0; 2]));
        for terrain in [&mut tiles, &mut waves] {
            assert_eq!(below(terrain, [0.1, -0.1]), 0.0);
        }
        let (mut sum, mut squares, mut most) = (0.0, 0.0, 0.0_f64);
        for k in 0..4000 {
            let place = [2.1 + 0.3 * f64::from(k % 200), 0.3 * f64::from(k / 200)];
            let [a, b] = [0.01, 0.29].map(|x| below(&mut tiles, [place[0] + x, place[1] + x]));
            assert_eq!(a, b);
            (sum, squares) = (sum + a, squares + a * a);
            let [a, b] = [-1e-6, 1e-6].map(|x| below(&mut waves, [place[0] + x, place[1] + 0.1]));
            most = most.max((a - b).abs());
        }
        // Uniform within ±10 mm: mean 0, variance 10²/3 mm².
        assert!((sum / 4000.0).abs() < 3e-4 && (squares / 4000.0 / (1e-4 / 3.0) - 1.0).abs() < 0.05);
        // No steeper than 20 mm per 0.3 m.
        assert!(most > 0.0 && most < 2e-6 * 0.02 / 0.3, "{most}");
    }

    /// A foot comes down on the next plate only where it was above it; on the ground nothing moves below it.
    #[test]
    fn plates_change_in_the_air() {
        let kind = HeightsKind::Footholds(vec![0.01, -0.01]);
        let mut terrain = Terrain::new(heights(kind), std::iter::once(0..2).collect(), [2, 2], [0.0; 2]);
        let mut at = |z: f64| {
            let mut gaps = [z, z + 0.001];
            terrain.lower(&mut gaps);
            z - gaps[0]
        };
        let went = [0.0, 0.005, 0.0, 0.013, 0.02, 0.009, 0.02, -0.01, 0.0].map(|z| (at(z) * 1e3).round());
        assert_eq!(went, [0.0, 0.0, 0.0, 10.0, 10.0, 10.0, -10.0, -10.0, -10.0]);
    }
}
