//! The impact map, and its derivative by the inertial parameters.
use super::{Changed, ImpactExperiment};
use crate::robot::BaseKind;
use crate::signal::rotate_to_base;
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// Directions that are tried for the sliding of a foot in space,
const DIRECTIONS: usize = 72;
/// and how often the interval between two of them is halved.
const HALVINGS: usize = 50;

/// How the foot meets the ground.
#[derive(Debug, Clone, Copy)]
pub(super) struct Contact {
    /// Normal speed after per normal speed before.
    pub restitution: f64,
    /// Tangential per normal impulse; infinite: no slip.
    pub friction: f64,
    /// Impulse about the vertical per normal impulse, m; infinite: a flat foot does not turn.
    pub spin: f64,
    /// Velocities do not jump.
    pub none: bool,
}

impl Default for Contact {
    fn default() -> Self {
        Self { restitution: 0.0, friction: f64::INFINITY, spin: f64::INFINITY, none: false }
    }
}

/// Contact rows: first the tangential ones, then the normal one, then those of turning.
struct Rows {
    jacobian: DMatrix<f64>,
    tangential: usize,
    /// Which of the rows bounce: the normal one and turning about horizontal axes.
    bounces: Vec<bool>,
    /// The row of turning about the vertical, of a flat foot in space.
    vertical: Option<usize>,
}

/// What an impact is computed from.
struct Impact {
    mass: DMatrix<f64>,
    rows: Rows,
    before: DVector<f64>,
}

impl ImpactExperiment<'_> {
    /// Velocities just after an impact, as the model has them.
    pub(super) fn velocity_after(&self, i: usize, changed: &Changed) -> DVector<f64> {
        let (q, before) = self.state(i, changed);
        if changed.contact.none {
            return before;
        }
        let impact = Impact { mass: self.mass_matrix(&q, changed), rows: self.rows_at(&q, changed), before };
        // A mass matrix that is not positive definite has no impact map: seen in the numbers.
        impact.after(&changed.contact).unwrap_or_else(|| DVector::from_element(self.calls.nv, f64::NAN))
    }

    /// Derivative of the velocities after by the inertial parameters (columns), nominal contact: from
    /// `M dv⁺ + dM (v⁺ − v⁻) = Jᵀ dλ` and `J dv⁺ = 0`.
    pub(super) fn gradient(&self, i: usize, nominal: &Changed) -> DMatrix<f64> {
        let nv = self.calls.nv;
        let (q, before) = self.state(i, nominal);
        let jump = self.velocity_after(i, nominal) - before;
        let moved = self.regressor_at(&q, jump.as_slice()) - self.regressor_at(&q, &vec![0.0; nv]);
        let rows = self.rows_at(&q, nominal).jacobian;
        let Some(factor) = self.mass_matrix(&q, nominal).cholesky() else {
            return DMatrix::from_element(nv, moved.ncols(), f64::NAN);
        };
        let free = factor.solve(&moved);
        let reach = factor.solve(&rows.transpose());
        let impulse = (&rows * &reach).lu().solve(&(&rows * &free));
        impulse.map_or(-&free, |impulse| reach * impulse - free)
    }

    /// Impulse about the vertical per normal impulse that holds the foot of an impact, m. `None`: it cannot turn.
    pub(super) fn turning(&self, i: usize, nominal: &Changed) -> Option<f64> {
        let (q, before) = self.state(i, nominal);
        let rows = self.rows_at(&q, nominal);
        let reach = self.mass_matrix(&q, nominal).cholesky()?.solve(&rows.jacobian.transpose());
        let held = Strike { rows: &rows, reach: &reach, before: &before }.impulse(&nominal.contact)?;
        let ratio = held[rows.vertical?].abs() / held[rows.tangential];
        (ratio > 0.0 && ratio.is_finite()).then_some(ratio)
    }

    /// How velocities after depend on those before (nominal contact), `I − M⁻¹ Jᵀ (J M⁻¹ Jᵀ)⁻¹ J`, and a basis of
    /// what impulses can cause, `M⁻¹ Jᵀ`.
    pub(super) fn projection(&self, i: usize, nominal: &Changed) -> Option<(DMatrix<f64>, DMatrix<f64>)> {
        let (q, _) = self.state(i, nominal);
        let rows = self.rows_at(&q, nominal).jacobian;
        let reach = self.mass_matrix(&q, nominal).cholesky()?.solve(&rows.transpose());
        let nv = self.calls.nv;
        let map = DMatrix::identity(nv, nv) - &reach * (&rows * &reach).lu().solve(&rows)?;
        Some((map, reach))
    }

    /// True configuration and velocities before.
    fn state(&self, i: usize, changed: &Changed) -> (Vec<f64>, DVector<f64>) {
        let (nq, nv) = (self.calls.nq, self.calls.nv);
        let mut q = self.q[i * nq..(i + 1) * nq].to_vec();
        changed.world.correct(&mut q);
        (q, DVector::from_column_slice(&self.before[i * nv..(i + 1) * nv]))
    }

    /// Velocities of the model as the table names them: the base's linear velocity in world axes.
    pub(super) fn logged(&self, i: usize, v: &DVector<f64>) -> DVector<f64> {
        let mut out = v.clone();
        if self.robot.layout.base == BaseKind::Floating {
            let q = &self.q[i * self.calls.nq..];
            // Turning with the conjugate is turning back.
            let world = rotate_to_base([-q[3], -q[4], -q[5], q[6]], [v[0], v[1], v[2]]);
            out.as_mut_slice()[..3].copy_from_slice(&world);
        }
        out
    }

    fn mass_matrix(&self, q: &[f64], changed: &Changed) -> DMatrix<f64> {
        let nv = self.calls.nv;
        let still = vec![0.0; nv];
        let rest = self.forces(q, &still, changed);
        let mut mass = DMatrix::zeros(nv, nv);
        let mut unit = still;
        for k in 0..nv {
            unit[k] = 1.0;
            mass.set_column(k, &(self.forces(q, &unit, changed) - &rest));
            unit[k] = 0.0;
            mass[(k, k)] += changed.rotors[k];
        }
        mass
    }

    /// Inverse dynamics at rest with these accelerations.
    fn forces(&self, q: &[f64], a: &[f64], changed: &Changed) -> DVector<f64> {
        let still = vec![0.0; self.calls.nv];
        let mut tau = DVector::zeros(self.calls.nv);
        self.calls.moving(self.inverse_dynamics, q, &still, a, tau.as_mut_slice());
        if let Some(change) = &changed.parameters {
            tau += self.regressor_at(q, a) * DVector::from_column_slice(change);
        }
        tau
    }

    fn regressor_at(&self, q: &[f64], a: &[f64]) -> DMatrix<f64> {
        let still = vec![0.0; self.calls.nv];
        let mut matrix = DMatrix::zeros(self.calls.nv, self.parameters.len());
        self.calls.moving(self.regressor, q, &still, a, matrix.as_mut_slice());
        matrix
    }

    /// The contact's rows in axes of the ground, at the middle of the sole or at the foot's point.
    fn rows_at(&self, q: &[f64], changed: &Changed) -> Rows {
        let (foot, nv) = (&self.robot.feet[self.foot], self.calls.nv);
        let mut six = Vec::new();
        self.foot_calls.jacobian(&self.calls, q, &mut six);
        let sole = self.foot_calls.sole(&self.calls, foot, q);
        let at = sole.below + sole.rotation * foot.center();
        let ground: Matrix3<f64> = (changed.world.tilt.transpose() * changed.world.slope).transpose();
        let columns = six.chunks_exact(6).map(|c| {
            let (linear, angular) = (Vector3::new(c[0], c[1], c[2]), Vector3::new(c[3], c[4], c[5]));
            (ground * (linear + angular.cross(&at)), ground * angular)
        });
        let columns: Vec<_> = columns.collect();
        let (linear, angular): (&[usize], &[usize]) = match (self.robot.planar(), self.flat) {
            (true, false) => (&[0, 2], &[]),
            (true, true) => (&[0, 2], &[1]),
            (false, false) => (&[0, 1, 2], &[]),
            (false, true) => (&[0, 1, 2], &[0, 1, 2]),
        };
        let count = linear.len() + angular.len();
        let jacobian = DMatrix::from_fn(count, nv, |r, k| match linear.get(r) {
            Some(axis) => columns[k].0[*axis],
            None => columns[k].1[angular[r - linear.len()]],
        });
        let tangential = linear.len() - 1;
        let bounces = (0..count).map(|r| r == tangential || r > tangential && angular[r - linear.len()] != 2);
        let vertical = angular.iter().position(|axis| *axis == 2).map(|k| linear.len() + k);
        Rows { jacobian, tangential, bounces: bounces.collect(), vertical }
    }
}

impl Impact {
    fn after(&self, contact: &Contact) -> Option<DVector<f64>> {
        let factor = self.mass.clone().cholesky()?;
        let reach = factor.solve(&self.rows.jacobian.transpose());
        let strike = Strike { rows: &self.rows, reach: &reach, before: &self.before };
        let held = strike.impulse(contact)?;
        let impulse = match self.rows.vertical {
            Some(k) if held[k].abs() > contact.spin * held[self.rows.tangential] => {
                self.spinning(k, -held[k].signum(), contact, &reach).unwrap_or(held)
            }
            _ => held,
        };
        Some(&self.before + reach * impulse)
    }

    /// The impulse of a foot that turns about the vertical (row `k`): limited by the normal impulse, against the
    /// turning just after. `first` is the sense of turning that is tried first.
    fn spinning(
        &self,
        k: usize,
        first: f64,
        contact: &Contact,
        reach: &DMatrix<f64>,
    ) -> Option<DVector<f64>> {
        let rows = &self.rows;
        [first, -first].into_iter().find_map(|sense| {
            // The normal impulse brings that about the vertical along.
            let brought = -sense * contact.spin;
            let mut along = reach.clone();
            along.column_mut(rows.tangential).axpy(brought, &reach.column(k), 1.0);
            let fewer = Rows {
                jacobian: rows.jacobian.clone().remove_row(k),
                tangential: rows.tangential,
                bounces: rows.bounces.iter().enumerate().filter(|(r, _)| *r != k).map(|(_, b)| *b).collect(),
                vertical: None,
            };
            let along = along.remove_column(k);
            let strike = Strike { rows: &fewer, reach: &along, before: &self.before };
            let impulse = strike.impulse(contact)?;
            let left = rows.jacobian.row(k) * (&self.before + along * &impulse);
            let normal = impulse[rows.tangential];
            (normal > 0.0 && left[0] * sense >= 0.0).then(|| impulse.insert_row(k, brought * normal))
        })
    }
}

/// A contact whose impulses act on the velocities through `reach`.
struct Strike<'a> {
    rows: &'a Rows,
    reach: &'a DMatrix<f64>,
    before: &'a DVector<f64>,
}

impl Strike<'_> {
    fn impulse(&self, contact: &Contact) -> Option<DVector<f64>> {
        let rows = self.rows;
        let speed = &rows.jacobian * self.before;
        let gain = &rows.jacobian * self.reach;
        let bounce = |r: usize| if rows.bounces[r] { -contact.restitution } else { 0.0 };
        let wanted = DVector::from_fn(speed.len(), |r, _| (bounce(r) - 1.0) * speed[r]);
        let impulse = gain.clone().lu().solve(&wanted)?;
        let push = impulse.rows(0, rows.tangential).norm();
        if push <= contact.friction * impulse[rows.tangential] {
            return Some(impulse);
        }
        // Where no sliding obeys the law, friction jams the foot.
        Some(self.sliding(contact.friction, &gain, &wanted, &speed, &impulse).unwrap_or(impulse))
    }

    /// The impulse of a foot that slides: friction times the normal impulse, against the sliding just after. Of
    /// several, the one nearest to what would hold the foot.
    fn sliding(
        &self,
        friction: f64,
        gain: &DMatrix<f64>,
        wanted: &DVector<f64>,
        speed: &DVector<f64>,
        sticking: &DVector<f64>,
    ) -> Option<DVector<f64>> {
        let t = self.rows.tangential;
        let slide = Slide { t, friction, gain, wanted, speed };
        let hold = sticking.rows(0, t).into_owned();
        if t == 1 {
            return slide.along(&hold.normalize()).map(|(impulse, _)| impulse).filter(|i| i[t] > 0.0);
        }
        let first = hold[1].atan2(hold[0]);
        let turn = std::f64::consts::TAU / DIRECTIONS as f64;
        // Outwards from the direction that would hold the foot: a change of sign brackets a solution.
        let steps = (0..DIRECTIONS as i32).map(|k| if k % 2 == 0 { -(k / 2) } else { k / 2 });
        steps.map(|k| first + f64::from(k) * turn).find_map(|angle| slide.between(angle, angle + turn))
    }
}

/// What a sliding foot's impulse follows from.
struct Slide<'a> {
    /// Number of tangential rows.
    t: usize,
    friction: f64,
    gain: &'a DMatrix<f64>,
    wanted: &'a DVector<f64>,
    speed: &'a DVector<f64>,
}

impl Slide<'_> {
    /// Impulse with its tangential part along a direction of length 1, and the sliding velocity after.
    fn along(&self, direction: &DVector<f64>) -> Option<(DVector<f64>, DVector<f64>)> {
        let (t, rest) = (self.t, self.speed.len() - self.t);
        // Unknown: the normal impulse, which brings the tangential one along, and those of turning.
        let mut along = self.gain.columns(t, rest).into_owned();
        let brought = self.gain.columns(0, t) * direction * self.friction;
        along.column_mut(0).axpy(1.0, &brought, 1.0);
        let solved = along.rows(t, rest).into_owned().lu().solve(&self.wanted.rows(t, rest).into_owned())?;
        let mut impulse = DVector::zeros(self.speed.len());
        impulse.rows_mut(0, t).copy_from(&(direction * (self.friction * solved[0])));
        impulse.rows_mut(t, rest).copy_from(&solved);
        let after = self.speed.rows(0, t) + self.gain.rows(0, t) * &impulse;
        Some((impulse, after))
    }

    /// Impulse, and the sliding velocity's parts across and along a direction.
    fn at(&self, angle: f64) -> Option<(DVector<f64>, f64, f64)> {
        let (y, x) = angle.sin_cos();
        let (impulse, after) = self.along(&DVector::from_vec(vec![x, y]))?;
        Some((impulse, x * after[1] - y * after[0], x * after[0] + y * after[1]))
    }

    /// The solution between two directions, if the sliding across them changes its sign there and is against them.
    fn between(&self, mut low: f64, mut high: f64) -> Option<DVector<f64>> {
        let below = self.at(low)?.1;
        if below * self.at(high)?.1 > 0.0 {
            return None;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.at(middle)?.1 * below > 0.0 { low = middle } else { high = middle }
        }
        let (impulse, across, along) = self.at(0.5 * (low + high))?;
        let against = along < 0.0 && across.abs() < 1e-6 * along.abs();
        (against && impulse[self.t] > 0.0).then_some(impulse)
    }
}
