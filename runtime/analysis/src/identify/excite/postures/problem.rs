//! The cost of a set of postures with its conditions as barriers, and its derivatives along the surface.
use super::ground::Conditions;
use super::standing::{Bodies, StanceModel};
use super::surface::{Tangent, closed, tangent};
use crate::identify::excite::Quality;
use crate::identify::excite::spectrum::{self, Criterion, Scaling};
use nalgebra::{DMatrix, DVector};

/// Placements, and postures on them.
#[derive(Debug, Clone, PartialEq)]
pub struct Point {
    /// x, y (m), yaw (rad) of the other sole in the standing sole's frame.
    pub placements: Vec<[f64; 3]>,
    /// Joints of every posture.
    pub joints: Vec<Vec<f64>>,
    /// Which placement each posture is on.
    pub of: Vec<usize>,
}

/// What is minimised.
pub struct Problem<'s, 'm> {
    pub standing: &'s StanceModel<'m>,
    pub conditions: &'s Conditions,
    pub criterion: Criterion,
    pub scaling: Scaling,
}

/// A direction: motions of the placements and of all joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Direction {
    pub placements: Vec<[f64; 3]>,
    pub joints: Vec<DVector<f64>>,
}

impl Problem<'_, '_> {
    /// Rows x and y of the centre of mass, posture by posture.
    pub fn rows(&self, bodies: &[Bodies]) -> DMatrix<f64> {
        let columns = &self.standing.parts.columns;
        let mut rows = DMatrix::zeros(2 * bodies.len(), columns.len());
        for (i, bodies) in bodies.iter().enumerate() {
            for (c, k) in columns.iter().enumerate() {
                let column = self.standing.column(bodies, *k);
                (rows[(2 * i, c)], rows[(2 * i + 1, c)]) = (column.x, column.y);
            }
        }
        rows
    }

    fn bodies(&self, point: &Point) -> Vec<Bodies> {
        point.joints.iter().map(|q| self.standing.bodies(q)).collect()
    }

    /// What the postures are worth.
    pub fn quality(&self, point: &Point) -> Quality {
        let (condition_number, log_determinant) =
            spectrum::quality(&self.rows(&self.bodies(point)), self.scaling);
        Quality { condition_number, log_determinant }
    }

    /// Cost and barriers with their derivatives; `None` where a condition is broken.
    pub fn slopes(&self, point: &Point, barrier: f64) -> Option<(f64, Direction)> {
        let bodies = self.bodies(point);
        let (mut cost, by_rows) = spectrum::slopes(&self.rows(&bodies), self.criterion, self.scaling)?;
        let n = self.standing.joints();
        let mut slope = Direction {
            placements: vec![[0.0; 3]; point.placements.len()],
            joints: vec![DVector::zeros(n); point.joints.len()],
        };
        for (i, bodies) in bodies.iter().enumerate() {
            for (c, k) in self.standing.parts.columns.iter().enumerate() {
                let by = [by_rows[(2 * i, c)], by_rows[(2 * i + 1, c)]];
                for joint in 0..n {
                    let rate = self.standing.column_rate(bodies, *k, joint);
                    slope.joints[i][joint] += by[0] * rate.x + by[1] * rate.y;
                }
            }
        }
        cost += self.barriers(point, &bodies, barrier, &mut slope)?;
        cost.is_finite().then_some((cost, slope))
    }

    /// `-barrier Σ ln slack`, its derivatives added.
    fn barriers(&self, point: &Point, bodies: &[Bodies], barrier: f64, slope: &mut Direction) -> Option<f64> {
        let mut cost = 0.0;
        for (placement, slope) in point.placements.iter().zip(&mut slope.placements) {
            let (slack, by) = self.conditions.placement(self.standing, placement);
            if slack.is_nan() || slack <= 0.0 {
                return None;
            }
            cost -= barrier * slack.ln();
            slope.iter_mut().zip(by.placement).for_each(|(s, by)| *s -= barrier / slack * by);
        }
        for (i, (bodies, of)) in bodies.iter().zip(&point.of).enumerate() {
            let (own, placed) = (&mut slope.joints[i], &mut slope.placements[*of]);
            let mut visit = |slack: f64, by: &super::ground::Slope| {
                cost -= barrier * slack.ln();
                own.iter_mut().zip(&by.joints).for_each(|(s, by)| *s -= barrier / slack * by);
                placed.iter_mut().zip(by.placement).for_each(|(s, by)| *s -= barrier / slack * by);
                slack > 0.0
            };
            let placement = &point.placements[*of];
            if !self.conditions.posture(self.standing, (bodies, &point.joints[i]), placement, &mut visit) {
                return None;
            }
        }
        Some(cost)
    }

    /// Directions in which each posture may move; `None` at a singular one.
    pub fn tangents(&self, point: &Point) -> Option<Vec<Tangent>> {
        point.joints.iter().map(|q| tangent(self.standing, q)).collect()
    }

    /// The point so far along a direction, back on the surface; `None` if out of reach.
    pub fn moved(&self, point: &Point, direction: &Direction, step: f64) -> Option<Point> {
        let placements: Vec<[f64; 3]> = point
            .placements
            .iter()
            .zip(&direction.placements)
            .map(|(p, d)| [0, 1, 2].map(|k| p[k] + step * d[k]))
            .collect();
        let joints = point.joints.iter().zip(&direction.joints).zip(&point.of).map(|((q, d), of)| {
            let q: Vec<f64> = q.iter().zip(d.iter()).map(|(q, d)| q + step * d).collect();
            closed(self.standing, &q, &placements[*of])
        });
        Some(Point {
            joints: joints.collect::<Option<_>>()?,
            placements: placements.clone(),
            of: point.of.clone(),
        })
    }
}

impl Direction {
    /// Derivatives by the coordinates of the surface: placements, then the free motions of each posture.
    pub fn pulled_back(&self, tangents: &[Tangent], of: &[usize]) -> DVector<f64> {
        let mut placements = self.placements.clone();
        let mut free: Vec<f64> = Vec::new();
        for ((slope, tangent), of) in self.joints.iter().zip(tangents).zip(of) {
            let along = tangent.along.tr_mul(slope);
            placements[*of].iter_mut().zip(along.iter()).for_each(|(p, a)| *p += a);
            free.extend(tangent.free.tr_mul(slope).iter());
        }
        DVector::from_iterator(
            3 * placements.len() + free.len(),
            placements.iter().flatten().copied().chain(free),
        )
    }

    /// The direction with these coordinates on the surface.
    pub fn of_coordinates(x: &DVector<f64>, tangents: &[Tangent], of: &[usize], placements: usize) -> Self {
        let placed: Vec<[f64; 3]> = (0..placements).map(|k| [0, 1, 2].map(|i| x[3 * k + i])).collect();
        let mut first = 3 * placements;
        let joints = tangents.iter().zip(of).map(|(tangent, of)| {
            let own = x.rows(first, tangent.free.ncols()).into_owned();
            first += own.len();
            &tangent.free * own + &tangent.along * DVector::from_column_slice(&placed[*of])
        });
        Self { joints: joints.collect(), placements: placed }
    }

    /// Coordinates on another point's surface of what is nearest to this direction there.
    pub fn coordinates(&self, tangents: &[Tangent]) -> DVector<f64> {
        let free = self
            .joints
            .iter()
            .zip(tangents)
            .flat_map(|(q, tangent)| tangent.free.tr_mul(q).iter().copied().collect::<Vec<f64>>());
        let all: Vec<f64> = self.placements.iter().flatten().copied().chain(free).collect();
        DVector::from_vec(all)
    }

    /// Largest motion of a joint or placement.
    pub fn largest(&self) -> f64 {
        let placed = self.placements.iter().flatten().map(|x| x.abs()).fold(0.0, f64::max);
        self.joints.iter().map(|q| q.amax()).fold(placed, f64::max)
    }
}
