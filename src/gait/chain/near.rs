//! Points of a constraint surface that were found last: where the search for the next one begins, and what need not be found again.
use super::surface::SurfacePoint;
use std::sync::Arc;

/// How many things are kept: what one step of the integration asks for more than once lies within so many.
const KEPT: usize = 8;
/// How far beyond two points a cubic through them still says where the next one is, in their distance.
const BEYOND: f64 = 2.0;

/// Where the robot was last, along φ.
#[derive(Debug, Clone, Default)]
pub(super) struct Near {
    start: Vec<f64>,
    /// φ and the point there, the last one first.
    points: [Option<(f64, Arc<SurfacePoint>)>; 2],
}

impl Near {
    /// At a posture.
    pub fn at(q: &[f64]) -> Self {
        Self { start: q.to_vec(), points: [None, None] }
    }

    /// The posture that was found last.
    pub fn last(&self) -> &[f64] {
        self.points[0].as_ref().map_or(&self.start, |(_, point)| &point.q)
    }

    /// Where the posture at φ should be: on the cubic with the postures and slopes of two points, on the tangent of one.
    pub fn guess(&self, phi: f64) -> Vec<f64> {
        let Some((from, last)) = &self.points[0] else { return self.start.clone() };
        let tangent = || last.q.iter().zip(&last.slope).map(|(q, slope)| q + slope * (phi - from)).collect();
        let Some((other, before)) = &self.points[1] else { return tangent() };
        let length = from - other;
        let s = (phi - other) / length;
        if !(-BEYOND..=1.0 + BEYOND).contains(&s) {
            return tangent();
        }
        let rest = 1.0 - s;
        let [a, b] = [(1.0 + 2.0 * s) * rest * rest, s * s * (3.0 - 2.0 * s)];
        let [c, d] = [s * rest * rest * length, -s * s * rest * length];
        let one = |k: usize| a * before.q[k] + b * last.q[k] + c * before.slope[k] + d * last.slope[k];
        (0..last.q.len()).map(one).collect()
    }

    /// It was found.
    pub fn found(&mut self, phi: f64, point: &Arc<SurfacePoint>) {
        if self.points[0].as_ref().is_none_or(|(last, _)| *last != phi) {
            self.points.swap(0, 1);
        }
        self.points[0] = Some((phi, point.clone()));
    }
}

/// How many points the next one is extrapolated from.
const BEHIND: usize = 5;

/// Postures along φ that are found one after another, and where the next one should be.
#[derive(Debug)]
pub(super) struct Way {
    start: Vec<f64>,
    /// φ, the posture and its slope, in order.
    points: Vec<(f64, Arc<SurfacePoint>)>,
}

impl Way {
    /// From a posture.
    pub fn from(q: &[f64]) -> Self {
        Self { start: q.to_vec(), points: Vec::with_capacity(BEHIND + 1) }
    }

    /// The posture that was found last.
    pub fn last(&self) -> &[f64] {
        self.points.last().map_or(&self.start, |(_, point)| &point.q)
    }

    /// It was found, further on than all others.
    pub fn found(&mut self, phi: f64, point: Arc<SurfacePoint>) {
        self.points.push((phi, point));
        if self.points.len() > BEHIND {
            self.points.remove(0);
        }
    }

    /// Where the posture at φ should be: on the polynomial with the postures and slopes of the last points, so close that one step of Newton's method is left.
    pub fn guess(&self, phi: f64) -> Vec<f64> {
        (0..self.start.len())
            .map(|joint| self.extrapolated(joint, phi).unwrap_or(self.start[joint]))
            .collect()
    }

    /// By divided differences, every point taken twice (Hermite).
    fn extrapolated(&self, joint: usize, phi: f64) -> Option<f64> {
        let count = 2 * self.points.len();
        let place = |k: usize| self.points[k / 2].0;
        let mut differences = [0.0; 2 * BEHIND];
        for (k, difference) in differences.iter_mut().enumerate().take(count) {
            *difference = self.points[k / 2].1.q[joint];
        }
        for order in 1..count {
            for k in (order..count).rev() {
                let same = order == 1 && k % 2 == 1;
                let slope = (differences[k] - differences[k - 1]) / (place(k) - place(k - order));
                differences[k] = if same { self.points[k / 2].1.slope[joint] } else { slope };
            }
        }
        let (last, others) = differences[..count].split_last()?;
        Some(others.iter().enumerate().rev().fold(*last, |sum, (k, next)| sum * (phi - place(k)) + next))
    }
}

/// The last things that were found, by the numbers that they were found for.
#[derive(Debug, Clone)]
pub(super) struct Recent<K, T> {
    kept: Vec<(K, Arc<T>)>,
    next: usize,
}

impl<K: PartialEq, T> Default for Recent<K, T> {
    fn default() -> Self {
        Self::new()
    }
}

impl<K: PartialEq, T> Recent<K, T> {
    pub fn new() -> Self {
        Self { kept: Vec::with_capacity(KEPT), next: 0 }
    }

    pub fn get(&self, key: &K) -> Option<Arc<T>> {
        self.kept.iter().find(|(known, _)| known == key).map(|(_, found)| found.clone())
    }

    pub fn keep(&mut self, key: K, found: &Arc<T>) {
        let entry = (key, found.clone());
        match self.kept.get_mut(self.next) {
            Some(oldest) => *oldest = entry,
            None => self.kept.push(entry),
        }
        self.next = (self.next + 1) % KEPT;
    }
}

#[cfg(test)]
mod tests {
    use super::{Near, Recent, SurfacePoint, Way};
    use std::sync::Arc;

    /// Of the curve (φ³, 2 φ).
    fn point(phi: f64) -> Arc<SurfacePoint> {
        let (q, slope) = (vec![phi.powi(3), 2.0 * phi], vec![3.0 * phi * phi, 2.0]);
        Arc::new(SurfacePoint { q, slope, along_phase: Vec::new() })
    }

    #[test]
    fn cubics_are_guessed_exactly_from_two_points() {
        let mut near = Near::at(&[0.5, 0.5]);
        assert_eq!(near.guess(3.0), [0.5, 0.5]);
        near.found(1.0, &point(1.0));
        assert_eq!(near.guess(1.5), [2.5, 3.0]);
        near.found(1.2, &point(1.2));
        for phi in [0.9, 1.1, 1.2, 1.5] {
            let (guess, known) = (near.guess(phi), point(phi));
            assert!(guess.iter().zip(&known.q).all(|(a, b)| (a - b).abs() < 1e-13), "{phi}: {guess:?}");
        }
        // Too far away for the cubic: along the tangent of the last one.
        assert!((near.guess(2.0)[0] - (1.728 + 4.32 * 0.8)).abs() < 1e-13);
        assert_eq!(near.last(), point(1.2).q);
    }

    #[test]
    fn polynomials_go_on_exactly_along_their_way() {
        let mut way = Way::from(&[0.5]);
        assert_eq!((way.guess(3.0), way.last()), (vec![0.5], &[0.5][..]));
        let at = |phi: f64| 1.0 - phi + phi.powi(9);
        for k in 0..7 {
            let phi = 0.1 * f64::from(k * k);
            let point =
                SurfacePoint { q: vec![at(phi)], slope: vec![9.0 * phi.powi(8) - 1.0], along_phase: vec![] };
            let guess = way.guess(phi)[0];
            // From five points on the polynomial of degree 9 is known.
            assert!(k < 5 || (guess / at(phi) - 1.0).abs() < 1e-9, "{phi}: {guess} for {}", at(phi));
            way.found(phi, Arc::new(point));
            assert_eq!(way.last(), [at(phi)]);
        }
    }

    #[test]
    fn the_last_things_are_kept() {
        let mut recent = Recent::new();
        (0..20).for_each(|k| recent.keep(k, &Arc::new(10 * k)));
        assert_eq!(recent.get(&19).as_deref(), Some(&190));
        assert_eq!(recent.get(&12).as_deref(), Some(&120));
        assert_eq!(recent.get(&11), None);
    }
}
