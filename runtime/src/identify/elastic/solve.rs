//! From triangles to friction, stiffness and base parameters, one step after the other or both at once.
use super::super::design::Design;
use super::super::estimate::independent;
use super::super::triangle::Triangle;
use super::fold::Folded;
use super::train::Train;
use crate::compare::Subject;
use crate::diagnostic::Diagnostic;
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// A column that is this part of its length away from the others is a sum of them.
const DEPENDENT: f64 = 1e-9;
/// Rounds in which the weights of the rows are found.
const ROUNDS: usize = 4;

/// What a motor's torque consists of, beside the spring's.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Laws {
    /// `F_v θ̇_M`
    pub viscous: bool,
    /// `F_c sign θ̇_M`
    pub coulomb: bool,
    /// Constant: of the current's sensor, or a shifted encoder.
    pub offset: bool,
}

impl Laws {
    /// Number of unknowns of a motor.
    pub fn count(&self) -> usize {
        1 + usize::from(self.viscous) + usize::from(self.coulomb) + usize::from(self.offset)
    }

    /// Place of the spring's stiffness among them.
    pub fn stiffness(&self) -> usize {
        usize::from(self.viscous) + usize::from(self.coulomb)
    }

    /// Names and units, in the order of the columns.
    pub fn names(&self) -> Vec<(&'static str, &'static str)> {
        let all = [
            (self.viscous, ("viscous_friction", "N m s/rad")),
            (self.coulomb, ("coulomb_friction", "N m")),
            (true, ("spring_stiffness", "N/m")),
            (self.offset, ("torque_offset", "N m")),
        ];
        all.into_iter().filter(|(wanted, _)| *wanted).map(|(_, name)| name).collect()
    }

    /// Described values in the same order.
    pub fn nominal(&self, train: &Train) -> DVector<f64> {
        let all = [
            (self.viscous, train.viscous_friction),
            (self.coulomb, train.coulomb_friction),
            (true, train.stiffness()),
            (self.offset, 0.0),
        ];
        DVector::from_vec(all.into_iter().filter(|(wanted, _)| *wanted).map(|(_, x)| x).collect())
    }
}

/// How the two regressions are put together.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Steps {
    /// Motors first, then joints with the springs so found (5.13), (5.15).
    #[default]
    Two,
    /// One regression, every row by its own noise: joints tell about springs too.
    One,
}

/// How residuals count.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Estimator {
    /// All joints alike.
    Ordinary,
    /// Each joint by its own noise.
    #[default]
    Weighted,
    /// As weighted; instruments are the same signals from samples that the regressors do not use.
    Instrumental,
}

/// What is solved for, and how.
pub struct Solver<'a, 'd> {
    pub design: &'a Design<'d>,
    pub folded: &'a Folded,
    pub trains: &'a [Train],
    pub subject: &'a Subject,
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
struct Point {
    motors: Vec<DVector<f64>>,
    theta: DVector<f64>,
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
            jackknife: jackknife(&replicates, |p| p.motors[k].clone()),
            white: white.view((n + k * count, n + k * count), (count, count)).into_owned(),
        };
        Ok(Solved {
            motors: (0..self.folded.elastic.len()).map(of_motor).collect(),
            joints: Estimated {
                value: point.theta.clone(),
                jackknife: jackknife(&replicates, |p| p.theta.clone()),
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
            let joint = &self.subject.joints[self.trains[self.folded.elastic[k]].joint].name;
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

    fn stiffness(&self, motors: &[DVector<f64>]) -> Vec<f64> {
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
                    let train = &self.trains[self.folded.elastic[rest / count]];
                    let (joint, name) = (&self.subject.joints[train.joint].name, self.folded.laws.names()[rest % count].0);
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

    /// Standard deviation of every row's residual.
    fn residuals(&self, point: &Point) -> Noise {
        let copies = usize::from(self.folded.instruments);
        let deviation = |triangle: &Triangle, own: &DVector<f64>, unknowns: usize| {
            let freedom = triangle.rows().saturating_sub(unknowns).max(1) as f64;
            (triangle.squares(own) / freedom).sqrt()
        };
        let summed = |parts: &mut dyn Iterator<Item = &Triangle>| {
            parts.fold(None, |sum: Option<Triangle>, part| match sum {
                Some(mut sum) => {
                    sum.add(part);
                    Some(sum)
                }
                None => Some(part.clone()),
            })
        };
        let motor = |k: usize| {
            let triangle = summed(&mut self.folded.motors.iter().map(|cell| &cell[k]))
                .unwrap_or_else(|| Triangle::new(0));
            let count = self.folded.laws.count();
            let own = DVector::from_iterator(
                (1 + copies) * count,
                std::iter::repeat_n(0.0, copies * count).chain(point.motors[k].iter().copied()),
            );
            deviation(&triangle, &own, count)
        };
        let stiffness = self.stiffness(&point.motors);
        let joint = |c: usize| {
            let triangle = summed(&mut self.folded.joints.iter().map(|cell| &cell[c]))
                .unwrap_or_else(|| Triangle::new(0));
            let places = &self.design.channels[c].places;
            let zeros = std::iter::repeat_n(0.0, copies * places.len());
            let values: Vec<f64> = zeros
                .chain(places.iter().map(|&p| point.theta[p]))
                .chain(self.folded.springs[c].map(|k| stiffness[k]))
                .collect();
            deviation(&triangle, &DVector::from_vec(values), places.len())
        };
        let floor = |list: Vec<f64>| -> Vec<f64> {
            let least = 1e-12 * list.iter().copied().fold(0.0, f64::max).max(f64::MIN_POSITIVE.sqrt());
            list.into_iter().map(|x| x.max(least)).collect()
        };
        Noise {
            motors: floor((0..self.folded.elastic.len()).map(motor).collect()),
            joints: floor((0..self.design.channels.len()).map(joint).collect()),
        }
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

/// Standard deviations of residuals.
struct Noise {
    motors: Vec<f64>,
    joints: Vec<f64>,
}

impl Noise {
    fn ones(solver: &Solver<'_, '_>) -> Self {
        // Before residuals are known, a motor's torque counts as much as the torque behind its gear.
        let gear = |t: &usize| 1.0 / solver.trains[*t].turns().abs().max(f64::MIN_POSITIVE);
        Self {
            motors: solver.folded.elastic.iter().map(gear).collect(),
            joints: vec![1.0; solver.design.channels.len()],
        }
    }
}

/// The regression of a triangle whose first `instruments` unknowns are instruments: of what these explain of regressors
/// and right-hand side (two-stage least squares; with as many instruments as regressors `(Zᵀ W)⁻¹ Zᵀ y`).
fn staged(triangle: &Triangle, instruments: usize) -> (DMatrix<f64>, DVector<f64>) {
    let (matrix, right) = (triangle.matrix(), triangle.right());
    if instruments == 0 {
        return (matrix, right);
    }
    let own = matrix.ncols() - instruments;
    (matrix.view((0, instruments), (instruments, own)).into_owned(), right.rows(0, instruments).into_owned())
}

/// Shortest `‖W θ − y‖`; the place of a column that is a sum of others where there is one.
pub(super) fn least_squares(matrix: &DMatrix<f64>, right: &DVector<f64>) -> Result<DVector<f64>, usize> {
    let mut columns = matrix.clone();
    let mut scale = Vec::with_capacity(columns.ncols());
    for (k, mut column) in columns.column_iter_mut().enumerate() {
        let length = column.norm();
        if !(length > 0.0 && length.is_finite()) {
            return Err(k);
        }
        column /= length;
        scale.push(length);
    }
    let qr = columns.qr();
    let r = qr.r();
    if let Some(k) = (0..r.ncols()).find(|&k| r[(k, k)].abs() <= DEPENDENT) {
        return Err(k);
    }
    let mut target = right.clone();
    qr.q_tr_mul(&mut target);
    let own = target.rows(0, r.ncols()).into_owned();
    let solution = r.solve_upper_triangular(&own).ok_or(0_usize)?;
    Ok(DVector::from_iterator(solution.len(), solution.iter().zip(&scale).map(|(x, s)| x / s)))
}

/// `(Wᵀ W)⁻¹`
fn inverse(matrix: &DMatrix<f64>) -> DMatrix<f64> {
    let n = matrix.ncols();
    let mut columns = matrix.clone();
    let scale: Vec<f64> = columns.column_iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
    columns.column_iter_mut().zip(&scale).for_each(|(mut c, s)| c /= *s);
    let r = columns.qr().r();
    let half = r.solve_upper_triangular(&DMatrix::identity(n, n));
    let half = half.unwrap_or_else(|| DMatrix::from_element(n, n, f64::INFINITY));
    let full = &half * half.transpose();
    DMatrix::from_fn(n, n, |i, j| full[(i, j)] / (scale[i] * scale[j]))
}

/// Mean square that no unknowns explain (8.3).
fn variance(triangle: &Triangle) -> f64 {
    triangle.rest() / triangle.rows().saturating_sub(triangle.columns()).max(1) as f64
}

fn scatter(all: &mut DMatrix<f64>, small: &DMatrix<f64>, places: &[usize]) {
    for (i, &a) in places.iter().enumerate() {
        for (j, &b) in places.iter().enumerate() {
            all[(a, b)] += small[(i, j)];
        }
    }
}

/// Covariance from replicates with one stretch left out each (the estimator CR3).
fn jackknife(points: &[Point], of: impl Fn(&Point) -> DVector<f64>) -> DMatrix<f64> {
    let values: Vec<DVector<f64>> = points.iter().map(of).collect();
    let count = values.len() as f64;
    let mean = values.iter().sum::<DVector<f64>>() / count;
    let n = mean.len();
    let sum = values.iter().fold(DMatrix::zeros(n, n), |sum, value| {
        let away = value - &mean;
        sum + &away * away.transpose()
    });
    sum * ((count - 1.0) / count)
}
