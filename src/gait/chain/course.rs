//! A constraint surface along φ by polynomials: T is smooth between the beginning of a phase and its end, so that a few points of each part tell
//! all others to rounding, for a fraction of what finding them costs.
use super::Refused;
use super::near::Way;
use super::surface::SurfacePoint;
use std::f64::consts::PI;
use std::sync::{Arc, LazyLock};

/// Parts of a phase.
const PARTS: usize = 8;
/// Points of a part (Chebyshev's).
const POINTS: usize = 12;
/// How far a polynomial may be from the surface where it is tried, as a part of 1 and what is there: between its points it is about as far.
const CLOSE: f64 = 1e-10;
/// Parts behind the end in which a polynomial is tried.
const BEYOND: usize = 4;

/// Finds the point at a φ, from a posture nearby.
type Find<'f> = &'f dyn Fn(f64, &[f64]) -> Result<SurfacePoint, Refused>;

/// The surface of a phase that has begun.
pub(super) struct Course {
    start: f64,
    end: f64,
    way: Way,
    /// From the beginning on; none: no polynomial is close enough, or there is no posture.
    parts: Vec<Option<Part>>,
    /// There was no posture in the last part, and none is looked for beyond.
    ended: bool,
}

struct Part {
    /// At each point T, T′ and ∂φ/∂q one after another.
    values: [Vec<f64>; POINTS],
}

/// Points between −1 and 1, from left to right, and their weights (barycentric).
static CHEBYSHEV: LazyLock<[(f64, f64); POINTS]> = LazyLock::new(|| {
    std::array::from_fn(|k| {
        let angle = (2 * k + 1) as f64 * PI / (2 * POINTS) as f64;
        (-angle.cos(), if k.is_multiple_of(2) { angle.sin() } else { -angle.sin() })
    })
});

impl Course {
    /// Of a phase that begins at `start` in the posture q, and ends at `end`.
    pub fn new([start, end]: [f64; 2], q: &[f64]) -> Self {
        Self { start, end, way: Way::from(q), parts: Vec::new(), ended: false }
    }

    /// The point at φ; none where it has to be looked for. `find` does that for one φ, from a posture nearby. What is said does not depend on what was
    /// asked before: parts are made one after another from the beginning.
    pub fn at(&mut self, phi: f64, find: Find<'_>) -> Option<SurfacePoint> {
        let width = (self.end - self.start) / PARTS as f64;
        let part = ((phi - self.start) / width).floor();
        if !(part >= 0.0 && part < (PARTS + BEYOND) as f64) {
            return None;
        }
        let index = part as usize;
        while self.parts.len() <= index {
            let made = self.part(self.parts.len(), width, find);
            self.parts.push(made);
        }
        let part = self.parts[index].as_ref()?;
        Some(part.at(2.0 * ((phi - self.start) / width - index as f64) - 1.0))
    }

    fn part(&mut self, index: usize, width: f64, find: Find<'_>) -> Option<Part> {
        if self.ended {
            return None;
        }
        let place = |s: f64| self.start + (index as f64 + 0.5 * (1.0 + s)) * width;
        let mut values: [Vec<f64>; POINTS] = Default::default();
        for (value, &(point, _)) in values.iter_mut().zip(&*CHEBYSHEV) {
            let phi = place(point);
            let found = find(phi, &self.way.guess(phi)).or_else(|_| find(phi, self.way.last()));
            let Ok(found) = found else {
                self.ended = true;
                return None;
            };
            *value = [&found.q[..], &found.slope, &found.along_phase].concat();
            self.way.found(phi, Arc::new(found));
        }
        let part = Part { values };
        let (tried, found) = (part.at(0.0), find(place(0.0), &part.at(0.0).q).ok()?);
        let close =
            |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() <= CLOSE * (1.0 + b.abs()));
        let all = close(&tried.q, &found.q)
            && close(&tried.slope, &found.slope)
            && close(&tried.along_phase, &found.along_phase);
        all.then_some(part)
    }
}

impl Part {
    /// The point at a place from −1 to 1.
    fn at(&self, s: f64) -> SurfacePoint {
        let (mut weights, mut whole) = ([0.0; POINTS], 0.0);
        for (k, &(place, weight)) in CHEBYSHEV.iter().enumerate() {
            if s == place {
                (weights, whole) = ([0.0; POINTS], 1.0);
                weights[k] = 1.0;
                break;
            }
            weights[k] = weight / (s - place);
            whole += weights[k];
        }
        let [q, slope, along_phase] = [0, 1, 2].map(|third| {
            let size = self.values[0].len() / 3;
            let own = third * size..(third + 1) * size;
            let mut sum = vec![0.0; size];
            for (weight, value) in weights.iter().zip(&self.values) {
                sum.iter_mut().zip(&value[own.clone()]).for_each(|(sum, value)| *sum += weight * value);
            }
            sum.iter_mut().for_each(|sum| *sum /= whole);
            sum
        });
        SurfacePoint { q, slope, along_phase }
    }
}

#[cfg(test)]
mod tests {
    use super::{Course, SurfacePoint};
    use crate::gait::chain::Refused;
    use bipedc_analysis::gait::Reason;
    use std::cell::Cell;

    /// Of a curve that ends at φ = 1.5, with a kink at 0.65 if it has one.
    fn point(phi: f64, kink: bool) -> Result<SurfacePoint, Refused> {
        if phi > 1.5 {
            return Err(Refused::new(Reason::NoPosture, "ended"));
        }
        let bent = if kink { (phi - 0.65).abs() } else { 0.0 };
        let q = vec![(3.0 * phi).sin() + bent, phi.exp()];
        Ok(SurfacePoint {
            q,
            slope: vec![3.0 * (3.0 * phi).cos(), phi.exp()],
            along_phase: vec![1.0, phi * phi],
        })
    }

    #[test]
    fn polynomials_say_what_would_be_found_where_the_surface_is_smooth() {
        for (kink, known) in [(false, [2.0, 2.0]), (true, [0.57, 0.71])] {
            let found = Cell::new(0);
            let find = |phi: f64, _: &[f64]| {
                found.set(found.get() + 1);
                point(phi, kink)
            };
            let mut course = Course::new([0.2, 1.2], &[0.0, 0.0]);
            let mut asked = 0;
            for k in 0..=1000 {
                let phi = 0.2 + 1.2 * f64::from(k) / 1000.0;
                let wanted = point(phi, kink).unwrap();
                match course.at(phi, &find) {
                    Some(point) => {
                        let apart =
                            |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-11);
                        assert!(apart(&point.q, &wanted.q) && apart(&point.slope, &wanted.slope), "{phi}");
                        assert!(apart(&point.along_phase, &wanted.along_phase), "{phi}");
                        asked += 1;
                    }
                    None => assert!(phi > known[0] && phi < known[1], "{phi}"),
                }
            }
            assert!(asked > 800, "{asked}");
            assert!(found.get() < 200, "{} points found for 1001", found.get());
            assert!(course.at(0.1, &find).is_none() && course.at(9.0, &find).is_none());
            assert!(course.at(f64::NAN, &find).is_none());
            // What was asked before makes no difference.
            let mut other = Course::new([0.2, 1.2], &[0.0, 0.0]);
            let [one, two] = [&mut course, &mut other].map(|course| course.at(0.55, &find).unwrap());
            assert_eq!((one.q, one.slope, one.along_phase), (two.q, two.slope, two.along_phase));
        }
    }
}
