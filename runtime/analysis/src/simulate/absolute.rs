//! Planar robots in absolute coordinates (thesis 4.3.1, (4.8) to (4.10)): every link is a free body with constant inertia,
//! joints are bilateral constraints.
//!
//! A second way to the same motion, which shares with [`Stepper`](super::Stepper) only the laws of contact and their solver:
//! neither the generated functions nor the coordinates. As the step shrinks both must agree.
use super::ground::Ground;
use super::problem::{Block, Law, Problem};
use super::proximal::{Solver, Tolerance};
use super::stepper::Stepped;
use bipedc_effects::diagnostic::Diagnostic;
use nalgebra::{Cholesky, DMatrix, DVector, Dyn};

/// A link by itself.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreeLink {
    /// kg
    pub mass: f64,
    /// About the centre of mass, kg m².
    pub inertia: f64,
}

/// A revolute joint.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pin {
    /// The two links; a torque acts on the second one and back on the first.
    pub links: [usize; 2],
    /// From each link's centre of mass to the axis, link axes (x, z), m.
    pub anchors: [[f64; 2]; 2],
}

/// A point that may touch the ground z = 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FreePoint {
    /// The link.
    pub link: usize,
    /// From its centre of mass, link axes (x, z), m.
    pub place: [f64; 2],
}

/// A planar robot taken apart. Its coordinates are x, z (m) and pitch (rad, about y) of each link's centre of mass in turn.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FreeBodies {
    /// All links.
    pub links: Vec<FreeLink>,
    /// All joints.
    pub pins: Vec<Pin>,
    /// All contact points.
    pub points: Vec<FreePoint>,
    /// Along x and z, m/s².
    pub gravity: [f64; 2],
}

/// Newton steps that put the links back on their joints after a step.
const PROJECTIONS: usize = 3;

/// Steps free bodies through time as [`Stepper`](super::Stepper) does: midpoint, contacts closed there, impulses.
pub struct FreeStepper<'a> {
    bodies: &'a FreeBodies,
    ground: Ground,
    tolerance: Tolerance,
    solver: Solver,
    problem: Problem,
    /// Last impulses by point, normal and tangential, N s: where the next step starts.
    memory: Vec<[f64; 2]>,
}

/// Joints at a configuration: `J`, `M⁻¹ Jᵀ` and the factor of `J M⁻¹ Jᵀ`.
struct Joined {
    rows: DMatrix<f64>,
    light: DMatrix<f64>,
    factor: Option<Cholesky<f64, Dyn>>,
}

impl Joined {
    /// What the joints leave of a change of velocity after they made `J v = target`.
    fn constrain(&self, v: &mut DVector<f64>, target: &DVector<f64>) {
        if let Some(factor) = &self.factor {
            *v -= &self.light * factor.solve(&(&self.rows * &*v - target));
        }
    }
}

impl<'a> FreeStepper<'a> {
    /// On hard ground.
    ///
    /// # Errors
    /// Impossible ground, soft ground, links without mass, joints or points at links that are not there.
    pub fn new(bodies: &'a FreeBodies, ground: Ground, tolerance: Tolerance) -> Result<Self, Diagnostic> {
        ground.check()?;
        let wrong = |what: &str| Err(Diagnostic::error(format!("free bodies: {what}")));
        if ground.compliance.is_some() {
            return wrong("soft ground is not simulated in absolute coordinates");
        }
        if bodies.links.iter().any(|link| !(link.mass > 0.0 && link.inertia > 0.0)) {
            return wrong("every link needs mass and inertia");
        }
        let there = |link: &usize| *link < bodies.links.len();
        if !bodies.pins.iter().flat_map(|pin| &pin.links).all(there)
            || !bodies.points.iter().map(|point| &point.link).all(there)
        {
            return wrong("a joint or a contact point is at a link that does not exist");
        }
        let memory = vec![[0.0; 2]; bodies.points.len()];
        Ok(Self { bodies, ground, tolerance, solver: Solver::default(), problem: Problem::default(), memory })
    }

    /// Impulse on a point in the last step, x and z, N s.
    pub fn impulse(&self, point: usize) -> [f64; 2] {
        let [normal, tangential] = self.memory[point];
        [tangential, normal]
    }

    /// One step of `time` seconds; `torques` by joint, N m.
    ///
    /// # Errors
    /// Joints that do not hold together (a singular constraint), or an infinite motion.
    pub fn step(
        &mut self,
        q: &mut DVector<f64>,
        v: &mut DVector<f64>,
        torques: &[f64],
        time: f64,
    ) -> Result<Stepped, Diagnostic> {
        let middle = &*q + &*v * (0.5 * time);
        let joined = self.joined(&middle)?;
        let mut free = v.clone();
        for (k, link) in self.bodies.links.iter().enumerate() {
            for axis in 0..2 {
                free[3 * k + axis] += time * self.bodies.gravity[axis];
            }
            let turned: f64 =
                self.bodies.pins.iter().zip(torques).map(|(pin, torque)| pin.sign(k) * torque).sum();
            free[3 * k + 2] += time * turned / link.inertia;
        }
        // At the end of the step the joints have turned on by half of it: J(q⁺) v⁺ = 0.
        joined.constrain(&mut free, &(self.turning(&middle, v) * (-0.5 * time)));
        let mut stepped = Stepped::default();
        let closed: Vec<usize> =
            (0..self.bodies.points.len()).filter(|&p| self.height(&middle, p) <= 0.0).collect();
        if !closed.is_empty() {
            stepped = self.strike(&middle, &joined, v, &mut free, &closed);
        } else {
            self.memory.fill([0.0; 2]);
        }
        v.copy_from(&free);
        *q = middle + &*v * (0.5 * time);
        for _ in 0..PROJECTIONS {
            self.put_together(q)?;
        }
        if v.iter().all(|v| v.is_finite()) {
            Ok(stepped)
        } else {
            Err(Diagnostic::error("the motion is no longer finite").help("shorten the step"))
        }
    }

    /// The contact problem of the closed points; `free` becomes the velocity after the step.
    fn strike(
        &mut self,
        middle: &DVector<f64>,
        joined: &Joined,
        before: &DVector<f64>,
        free: &mut DVector<f64>,
        closed: &[usize],
    ) -> Stepped {
        let rows = 2 * closed.len();
        let mut directions = DMatrix::zeros(free.len(), rows);
        for (k, &point) in closed.iter().enumerate() {
            let [tangential, normal] = self.point_rows(middle, point);
            directions.set_column(2 * k, &normal);
            directions.set_column(2 * k + 1, &tangential);
        }
        let mut answers = directions.clone();
        let none = DVector::zeros(joined.rows.nrows());
        for mut column in answers.column_iter_mut() {
            let mut answer = self.light(&column.clone_owned());
            joined.constrain(&mut answer, &none);
            column.copy_from(&answer);
        }
        let delassus = directions.tr_mul(&answers);
        let (gamma, known) = (directions.tr_mul(before), directions.tr_mul(free));
        self.problem.clear(rows);
        for i in 0..rows {
            let restitution = [self.ground.normal_restitution, self.ground.tangential_restitution][i % 2];
            self.problem.free[i] = known[i] + restitution * gamma[i];
        }
        self.problem.set_delassus(|i, j| 0.5 * (delassus[(i, j)] + delassus[(j, i)]));
        for (k, &point) in closed.iter().enumerate() {
            self.problem.impulse[2 * k..2 * k + 2].copy_from_slice(&self.memory[point]);
            let law = Law::Contact { friction: self.ground.friction, tangents: 1, cone: self.ground.cone };
            self.problem.blocks.push(Block { first: 2 * k, law });
        }
        let solved = self.solver.solve(&mut self.problem, &self.tolerance);
        let impulse = DVector::from_column_slice(&self.problem.impulse);
        self.memory.fill([0.0; 2]);
        for (k, &point) in closed.iter().enumerate() {
            self.memory[point] = [impulse[2 * k], impulse[2 * k + 1]];
        }
        *free += answers * &impulse;
        let work = 0.5 * impulse.dot(&(gamma + directions.tr_mul(free)));
        Stepped { solved, contacts: closed.len(), work, made: work.max(0.0) }
    }

    /// `M⁻¹ f`
    fn light(&self, f: &DVector<f64>) -> DVector<f64> {
        let links = &self.bodies.links;
        DVector::from_fn(f.len(), |i, _| {
            f[i] / if i % 3 == 2 { links[i / 3].inertia } else { links[i / 3].mass }
        })
    }

    fn joined(&self, q: &DVector<f64>) -> Result<Joined, Diagnostic> {
        let mut rows = DMatrix::zeros(2 * self.bodies.pins.len(), q.len());
        for (k, pin) in self.bodies.pins.iter().enumerate() {
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let (link, arm) = (pin.links[side], turned(pin.anchors[side], q[3 * pin.links[side] + 2]));
                (rows[(2 * k, 3 * link)], rows[(2 * k + 1, 3 * link + 1)]) = (sign, sign);
                // Pitch turns z towards x.
                (rows[(2 * k, 3 * link + 2)], rows[(2 * k + 1, 3 * link + 2)]) =
                    (sign * arm[1], -sign * arm[0]);
            }
        }
        let mut light = rows.transpose();
        for mut column in light.column_iter_mut() {
            let made = self.light(&column.clone_owned());
            column.copy_from(&made);
        }
        let factor = if rows.nrows() == 0 {
            None
        } else {
            let factor = Cholesky::new(&rows * &light);
            Some(
                factor
                    .ok_or_else(|| Diagnostic::error("free bodies: the joints constrain each other twice"))?,
            )
        };
        Ok(Joined { rows, light, factor })
    }

    /// Accelerations of the joints' gaps from the links' turning alone, m/s².
    fn turning(&self, q: &DVector<f64>, v: &DVector<f64>) -> DVector<f64> {
        let mut found = DVector::zeros(2 * self.bodies.pins.len());
        for (k, pin) in self.bodies.pins.iter().enumerate() {
            for (side, sign) in [(0, -1.0), (1, 1.0)] {
                let link = pin.links[side];
                let arm = turned(pin.anchors[side], q[3 * link + 2]);
                let square = v[3 * link + 2].powi(2);
                (0..2).for_each(|axis| found[2 * k + axis] -= sign * square * arm[axis]);
            }
        }
        found
    }

    /// One Newton step back onto the joints, by the way that costs the least kinetic energy.
    fn put_together(&self, q: &mut DVector<f64>) -> Result<(), Diagnostic> {
        let joined = self.joined(q)?;
        let mut gaps = DVector::zeros(2 * self.bodies.pins.len());
        for (k, pin) in self.bodies.pins.iter().enumerate() {
            let at = |side: usize| place(q, pin.links[side], pin.anchors[side]);
            let (first, second) = (at(0), at(1));
            (0..2).for_each(|axis| gaps[2 * k + axis] = second[axis] - first[axis]);
        }
        if let Some(factor) = &joined.factor {
            *q -= &joined.light * factor.solve(&gaps);
        }
        Ok(())
    }

    fn height(&self, q: &DVector<f64>, point: usize) -> f64 {
        let FreePoint { link, place: own } = self.bodies.points[point];
        place(q, link, own)[1]
    }

    /// Velocity of a point along x and along z per velocity of the bodies.
    fn point_rows(&self, q: &DVector<f64>, point: usize) -> [DVector<f64>; 2] {
        let FreePoint { link, place } = self.bodies.points[point];
        let arm = turned(place, q[3 * link + 2]);
        let mut rows = [DVector::zeros(q.len()), DVector::zeros(q.len())];
        (rows[0][3 * link], rows[0][3 * link + 2]) = (1.0, arm[1]);
        (rows[1][3 * link + 1], rows[1][3 * link + 2]) = (1.0, -arm[0]);
        rows
    }
}

impl Pin {
    /// How its torque acts on a link.
    fn sign(&self, link: usize) -> f64 {
        f64::from(u8::from(self.links[1] == link)) - f64::from(u8::from(self.links[0] == link))
    }
}

/// A vector of link axes in world axes.
fn turned([x, z]: [f64; 2], pitch: f64) -> [f64; 2] {
    let (s, c) = pitch.sin_cos();
    [c * x + s * z, c * z - s * x]
}

/// A point of a link in the world.
fn place(q: &DVector<f64>, link: usize, own: [f64; 2]) -> [f64; 2] {
    let arm = turned(own, q[3 * link + 2]);
    [q[3 * link] + arm[0], q[3 * link + 1] + arm[1]]
}
