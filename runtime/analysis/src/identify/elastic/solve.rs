//! From triangles to friction, stiffness and base parameters, one step after the other or both at once.
use super::super::design::Design;
use super::super::estimate::independent;
use super::super::triangle::Triangle;
use super::driven::Driven;
use super::fold::Folded;
use super::laws::{Estimator, Steps};
use super::linear::{inverse, jackknife, least_squares, scatter, staged, variance};
use super::noise::Noise;
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::Diagnostic;
use nalgebra::{DMatrix, DVector};

/// Rounds in which the weights of the rows are found.
const ROUNDS: usize = 4;

/// What is solved for, and how.
pub struct Solver<'a, 'd> {
    pub design: &'a Design<'d>,
    pub folded: &'a Folded,
    pub drives: &'a [Driven<'a>],
    pub layout: &'a JointLayout,
    pub steps: Steps,
    pub estimator: Estimator,
    /// Where unknowns stay that the data do not tell.
    pub nominal: DVector<f64>,
}

/// Estimates with covariances; by stretches left out, and as if residuals were independent (8.2, 8.3).
#[derive(Debug, Clone)]
pub struct Solved {
    /// By elastic drive.
    pub motors: Vec<Estimated>,
    /// Unknowns of the design.
    pub joints: Estimated,
    /// Stretches of motion behind the error bars.
    pub stretches: usize,
    /// Condition number of each motor's regression (5.9), columns scaled to length 1.
    pub condition: Vec<f64>,
}

/// Values with their covariances.
#[derive(Debug, Clone)]
pub struct Estimated {
    pub value: DVector<f64>,
    pub jackknife: DMatrix<f64>,
    pub white: DMatrix<f64>,
}

impl Estimated {
    /// The larger of both covariances' standard errors, and the independent one.
    pub fn errors(&self, k: usize) -> [f64; 2] {
        let white = self.white[(k, k)].max(0.0);
        [self.jackknife[(k, k)].max(white).sqrt(), white.sqrt()]
    }
}

/// Triangles of some stretches: per motor, and one over all joints' rows, weighted.
#[derive(Clone)]
struct Whole {
    motors: Vec<Triangle>,
    joints: Triangle,
}

impl Whole {
    fn add(&mut self, other: &Self) {
        for (own, other) in self.motors.iter_mut().zip(&other.motors) {
            own.add(other);
        }
        self.joints.add(&other.joints);
    }
}

/// Estimates without errors.
#[derive(Clone)]
pub(super) struct Point {
    pub motors: Vec<DVector<f64>>,
    pub theta: DVector<f64>,
}

impl Solver<'_, '_> {
    /// Solves.
    ///
    /// # Errors
    /// A parameter of a drive that the data do not tell.
    pub fn solve(&self) -> Result<Solved, Diagnostic> {
        let mut noise = Noise::ones(self);
        let (mut wholes, mut total, mut seen, mut point);
        let mut round = 0;
        loop {
            wholes = self.wholes(&noise);
            total = self.total(&wholes);
            seen = self.seen(&total);
            point = self.point(&total, &seen)?;
            round += 1;
            if round > ROUNDS || self.estimator == Estimator::Ordinary {
                break;
            }
            noise = self.residuals(&point);
        }
        let noise = self.residuals(&point);
        let replicates = self.replicates(&wholes, &seen)?;
        let white = self.white(&total, &seen, &point, &noise)?;
        let n = self.design.unknowns.len();
        let count = self.folded.laws.count();
        let of_motor = |k: usize| Estimated {
            value: point.motors[k].clone(),
            jackknife: jackknife(&replicates.iter().map(|p| p.motors[k].clone()).collect::<Vec<_>>()),
            white: white.view((n + k * count, n + k * count), (count, count)).into_owned(),
        };
        Ok(Solved {
            motors: (0..self.folded.elastic.len()).map(of_motor).collect(),
            joints: Estimated {
                value: point.theta.clone(),
                jackknife: jackknife(&replicates.iter().map(|p| p.theta.clone()).collect::<Vec<_>>()),
                white: white.view((0, 0), (n, n)).into_owned(),
            },
            stretches: replicates.len(),
            condition: total.motors.iter().map(|triangle| self.condition(triangle)).collect(),
        })
    }

    /// Unknowns before those of the motors in a whole: the design's, with instruments twice.
    fn before(&self) -> usize {
        self.design.unknowns.len() * if self.folded.instruments { 2 } else { 1 }
    }

    /// Place of a spring's stiffness in a whole.
    fn spring(&self, k: usize) -> usize {
        self.before() + k * self.folded.laws.count() + self.folded.laws.stiffness()
    }

    fn wholes(&self, noise: &Noise) -> Vec<Whole> {
        let (n, count) = (self.design.unknowns.len(), self.folded.laws.count());
        let width = self.before() + self.folded.elastic.len() * count;
        let whole = |(motors, joints): (&Vec<Triangle>, &Vec<Triangle>)| {
            let mut all = Triangle::new(width);
            for (c, triangle) in joints.iter().enumerate().filter(|(_, t)| t.rows() > 0) {
                let own = &self.design.channels[c].places;
                let shifted = own.iter().map(|p| p + n);
                let mut places: Vec<usize> = own.clone();
                if self.folded.instruments {
                    places.extend(shifted);
                }
                places.extend(self.folded.springs[c].map(|k| self.spring(k)));
                all.merge(triangle, &places, 1.0 / noise.joints[c]);
            }
            if self.steps == Steps::One {
                for (k, triangle) in motors.iter().enumerate().filter(|(_, t)| t.rows() > 0) {
                    let first = self.before() + k * count;
                    let places: Vec<usize> = (first..first + count).collect();
                    all.merge(triangle, &places, 1.0 / noise.motors[k]);
                }
            }
            Whole { motors: motors.clone(), joints: all }
        };
        self.folded.motors.iter().zip(&self.folded.joints).map(whole).collect()
    }

    fn empty(&self, like: &Whole) -> Whole {
        Whole {
            motors: like.motors.iter().map(|t| Triangle::new(t.columns())).collect(),
            joints: Triangle::new(like.joints.columns()),
        }
    }

    fn total(&self, wholes: &[Whole]) -> Whole {
        let mut total = self.empty(&wholes[0]);
        wholes.iter().for_each(|whole| total.add(whole));
        total
    }

    /// Regressor columns in a whole, after the instruments.
    fn regressors(&self) -> Vec<usize> {
        let n = self.design.unknowns.len();
        (self.before() - n..self.before()).collect()
    }

    fn seen(&self, total: &Whole) -> Vec<usize> {
        independent(&total.joints.reduced(&self.regressors(), &[]))
    }

    /// Least squares from a motor's triangle, or with instruments (two stages).
    fn motor(&self, k: usize, triangle: &Triangle) -> Result<DVector<f64>, Diagnostic> {
        let count = self.folded.laws.count();
        let (matrix, right) = staged(triangle, if self.folded.instruments { count } else { 0 });
        least_squares(&matrix, &right).map_err(|place| {
            let joint = &self.layout.joints[self.drives[self.folded.elastic[k]].joint].name;
            let name = self.folded.laws.names()[place.min(count - 1)].0;
            Diagnostic::error(format!("the data do not tell `{name}` of `{joint}` from its other parameters"))
                .help("record a motion in which this motor turns both ways at several speeds while its spring is loaded both ways")
        })
    }

    fn point(&self, total: &Whole, seen: &[usize]) -> Result<Point, Diagnostic> {
        if self.steps == Steps::One {
            return self.at_once(total, seen);
        }
        let motors: Vec<DVector<f64>> = (0..self.folded.elastic.len())
            .map(|k| self.motor(k, &total.motors[k]))
            .collect::<Result<_, _>>()?;
        let theta = self.bodies(total, seen, &self.stiffness(&motors))?;
        Ok(Point { motors, theta })
    }

    pub(super) fn stiffness(&self, motors: &[DVector<f64>]) -> Vec<f64> {
        motors.iter().map(|values| values[self.folded.laws.stiffness()]).collect()
    }

    /// What stands still while `seen` is solved for: unseen unknowns, and springs.
    fn held(&self, seen: &[usize], stiffness: &[f64]) -> Vec<(usize, f64)> {
        let n = self.design.unknowns.len();
        let first = self.before() - n;
        let unseen = (0..n).filter(|k| !seen.contains(k)).map(|k| (first + k, self.nominal[k]));
        unseen.chain(stiffness.iter().enumerate().map(|(k, x)| (self.spring(k), *x))).collect()
    }

    /// The joints' rows over `seen`, with instruments before them, and how many of these there are.
    fn bodies_triangle(&self, total: &Whole, seen: &[usize], stiffness: &[f64]) -> (Triangle, usize) {
        let first = self.before() - self.design.unknowns.len();
        let instruments: Vec<usize> = if self.folded.instruments { seen.to_vec() } else { Vec::new() };
        let kept: Vec<usize> = instruments.iter().copied().chain(seen.iter().map(|k| first + k)).collect();
        (total.joints.reduced(&kept, &self.held(seen, stiffness)), instruments.len())
    }

    fn bodies(&self, total: &Whole, seen: &[usize], stiffness: &[f64]) -> Result<DVector<f64>, Diagnostic> {
        let (triangle, instruments) = self.bodies_triangle(total, seen, stiffness);
        let (matrix, right) = staged(&triangle, instruments);
        let own = least_squares(&matrix, &right).map_err(|place| self.untold(seen, place))?;
        Ok(self.spread(seen, &own))
    }

    fn spread(&self, seen: &[usize], own: &DVector<f64>) -> DVector<f64> {
        let mut theta = self.nominal.clone();
        seen.iter().zip(own.iter()).for_each(|(&k, x)| theta[k] = *x);
        theta
    }

    fn untold(&self, seen: &[usize], place: usize) -> Diagnostic {
        let name = seen.get(place).map_or("a parameter", |&k| self.design.unknowns[k].name.as_str());
        Diagnostic::error(format!("`{name}` is told by one stretch of the motion only: it has no error bar"))
            .help("record a longer motion in which all joints move all the time")
    }

    /// Unknowns of the regression of everything at once: `seen`, then all of the motors.
    fn all_at_once(&self, total: &Whole, seen: &[usize]) -> Triangle {
        let n = self.design.unknowns.len();
        let motors = n..n + self.folded.elastic.len() * self.folded.laws.count();
        let kept: Vec<usize> = seen.iter().copied().chain(motors).collect();
        total.joints.reduced(&kept, &self.held(seen, &[]))
    }

    fn at_once(&self, total: &Whole, seen: &[usize]) -> Result<Point, Diagnostic> {
        let triangle = self.all_at_once(total, seen);
        let own = least_squares(&triangle.matrix(), &triangle.right());
        let own = own.map_err(|place| {
            let count = self.folded.laws.count();
            match place.checked_sub(seen.len()) {
                Some(rest) => {
                    let driven = &self.drives[self.folded.elastic[rest / count]];
                    let (joint, name) = (&self.layout.joints[driven.joint].name, self.folded.laws.names()[rest % count].0);
                    Diagnostic::error(format!("the data do not tell `{name}` of `{joint}` from its other parameters"))
                        .help("record a motion in which this motor turns both ways while its spring is loaded both ways")
                }
                None => self.untold(seen, place),
            }
        })?;
        let count = self.folded.laws.count();
        let of = |k: usize| own.rows(seen.len() + k * count, count).into_owned();
        Ok(Point {
            motors: (0..self.folded.elastic.len()).map(of).collect(),
            theta: self.spread(seen, &own.rows(0, seen.len()).into_owned()),
        })
    }

    /// The whole procedure with one stretch of motion after the other left out.
    fn replicates(&self, wholes: &[Whole], seen: &[usize]) -> Result<Vec<Point>, Diagnostic> {
        let used: Vec<&Whole> = wholes.iter().filter(|w| w.joints.rows() > 0).collect();
        let count = used.len();
        if count < 2 {
            return Err(Diagnostic::error(
                "all usable samples lie in one short stretch of motion: nothing has an error bar",
            )
            .help("record a longer motion"));
        }
        let mut after = vec![self.empty(used[0]); count + 1];
        for k in (0..count).rev() {
            after[k] = after[k + 1].clone();
            after[k].add(used[k]);
        }
        let mut before = self.empty(used[0]);
        let mut points = Vec::with_capacity(count);
        for k in 0..count {
            let mut rest = before.clone();
            rest.add(&after[k + 1]);
            points.push(self.point(&rest, seen)?);
            before.add(used[k]);
        }
        Ok(points)
    }

    /// Covariance of the design's unknowns, then of the motors', as if residuals were independent.
    fn white(
        &self,
        total: &Whole,
        seen: &[usize],
        point: &Point,
        noise: &Noise,
    ) -> Result<DMatrix<f64>, Diagnostic> {
        let (n, count) = (self.design.unknowns.len(), self.folded.laws.count());
        let elastic = self.folded.elastic.len();
        let mut all = DMatrix::zeros(n + elastic * count, n + elastic * count);
        if self.steps == Steps::One {
            let triangle = self.all_at_once(total, seen);
            let small = inverse(&triangle.matrix()) * variance(&triangle);
            let places: Vec<usize> = seen.iter().copied().chain(n..n + elastic * count).collect();
            scatter(&mut all, &small, &places);
            return Ok(all);
        }
        let stiffness = self.stiffness(&point.motors);
        let (triangle, instruments) = self.bodies_triangle(total, seen, &stiffness);
        let (matrix, _) = staged(&triangle, instruments);
        let own = DVector::from_iterator(seen.len(), seen.iter().map(|&k| point.theta[k]));
        let full = DVector::from_iterator(
            instruments + seen.len(),
            std::iter::repeat_n(0.0, instruments).chain(own.iter().copied()),
        );
        let freedom = triangle.rows().saturating_sub(seen.len()).max(1) as f64;
        scatter(&mut all, &(inverse(&matrix) * (triangle.squares(&full) / freedom)), seen);
        for k in 0..elastic {
            let (matrix, _) = staged(&total.motors[k], if self.folded.instruments { count } else { 0 });
            let small = inverse(&matrix) * noise.motors[k].powi(2);
            let places: Vec<usize> = (n + k * count..n + (k + 1) * count).collect();
            scatter(&mut all, &small, &places);
            // An error of the spring's stiffness goes on into the bodies, linearly.
            let place = self.folded.laws.stiffness();
            let error = small[(place, place)].max(0.0).sqrt();
            let mut moved = stiffness.clone();
            moved[k] += error;
            let shift = self.bodies(total, seen, &moved)? - &point.theta;
            let mut own = all.view_mut((0, 0), (n, n));
            own += &shift * shift.transpose();
        }
        Ok(all)
    }

    fn condition(&self, triangle: &Triangle) -> f64 {
        let count = self.folded.laws.count();
        let (mut matrix, _) = staged(triangle, if self.folded.instruments { count } else { 0 });
        for mut column in matrix.column_iter_mut() {
            let length = column.norm().max(f64::MIN_POSITIVE);
            column /= length;
        }
        let values = matrix.singular_values();
        values.max() / values.min().max(f64::MIN_POSITIVE)
    }
}
