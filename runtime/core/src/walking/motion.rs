//! From wishes for feet, torso, height and zero moment point to accelerations, joint torques and what the ground has to give (6.54)–(6.58).
use super::payload::Payload;
use super::robot::{BASE, LEG, MOST_VELOCITIES, Place, WalkingRobot};
use super::space::{Vector, add, along, cross, scale, subtract, turned, turned_back, zero};
use crate::control::Refusal;
use crate::control::elimination::{solve, solve_all};
use crate::control::slices::{columns, get, set};
use crate::model::{Argument, Model, State};
use crate::real::Scalar;
use core::cmp::Ordering;

/// What shall happen in the next instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Wish<R> {
    /// Linear and angular accelerations of both soles, world axes.
    pub soles: [[Vector<R>; 2]; 2],
    /// Angular acceleration of the torso, world axes, rad/s².
    pub torso: Vector<R>,
    /// Vertical acceleration of the centre of mass, m/s².
    pub rise: R,
    /// Zero moment point with the height of the ground there, m.
    pub zero_moment_point: Vector<R>,
}

/// Memory of [`Motion::of`].
#[derive(Debug, Clone)]
pub struct Motion<R> {
    mass: [R; MOST_VELOCITIES * MOST_VELOCITIES],
    bias: [R; MOST_VELOCITIES],
    /// Accelerations: without, and per unit of, the base's linear acceleration (root axes).
    columns: [[R; MOST_VELOCITIES]; 4],
    /// Generalised forces of the same.
    forces: [[R; MOST_VELOCITIES]; 4],
    /// Accelerations that do what is wished, as the model takes them.
    pub acceleration: [R; MOST_VELOCITIES],
    /// D q̈ + H of the joints, N m: torques without the ground.
    pub torques: [R; MOST_VELOCITIES],
    /// What the ground has to give, about the world's origin: force (N), moment (N m).
    pub ground: [R; 6],
    /// With the payload, kg.
    pub weighs: R,
    /// Without, kg.
    pub modelled: R,
    /// Of the robot without payload, about the root's origin in its axes: linear (kg m/s), angular (kg m²/s).
    pub momentum: [Vector<R>; 2],
}

/// Below this bend of the knee (rad) a leg counts as nearly straight: it no longer does all that is wished.
const STRAIGHT: f64 = 0.15;
/// Damping of a straight leg, m.
const DAMPING: f64 = 0.1;

/// Joint accelerations of a leg: J⁻¹ r of each six numbers of `rights` into themselves; of a leg that is nearly straight (JᵀJ + λ²)⁻¹ Jᵀ r.
fn damped<R: Scalar>(columns: &[[R; 6]; LEG], rights: &mut [R], bend: R) -> bool {
    let o = R::constant(0.0);
    let mut matrix = [o; LEG * 6];
    let missing = R::constant(STRAIGHT) - bend;
    // NaN neither.
    if missing.partial_cmp(&o) != Some(Ordering::Greater) {
        matrix.iter_mut().zip(columns.iter().flatten()).for_each(|(to, from)| *to = *from);
        return solve_all(&mut matrix, LEG, rights);
    }
    let dot = |a: &[R], b: &[R]| a.iter().zip(b).fold(o, |sum, (a, b)| R::fused(*a, *b, sum));
    let damping = R::constant(DAMPING / STRAIGHT) * missing;
    for (k, (row, a)) in matrix.as_chunks_mut::<LEG>().0.iter_mut().zip(columns).enumerate() {
        for (j, (place, b)) in row.iter_mut().zip(columns).enumerate() {
            *place = dot(a, b) + if j == k { damping * damping } else { o };
        }
    }
    for right in rights.as_chunks_mut::<LEG>().0 {
        let found = columns.each_ref().map(|column| dot(column, right));
        right.iter_mut().zip(found).for_each(|(to, from)| *to = from);
    }
    solve_all(&mut matrix, LEG, rights)
}

/// The first six rows of D v.
fn momentum<R: Scalar>(mass: &[R], v: &[R]) -> [Vector<R>; 2] {
    let mut sum = [zero(); 2];
    for (column, x) in columns(mass, v.len()).zip(v) {
        let rows = [0, 3].map(|first| [0, 1, 2].map(|k| get(column, first + k)));
        sum = [along(sum[0], *x, rows[0]), along(sum[1], *x, rows[1])];
    }
    sum
}

impl<R: Scalar> Default for Motion<R> {
    fn default() -> Self {
        let o = R::constant(0.0);
        Self {
            mass: [o; MOST_VELOCITIES * MOST_VELOCITIES],
            bias: [o; MOST_VELOCITIES],
            columns: [[o; MOST_VELOCITIES]; 4],
            forces: [[o; MOST_VELOCITIES]; 4],
            acceleration: [o; MOST_VELOCITIES],
            torques: [o; MOST_VELOCITIES],
            ground: [o; 6],
            weighs: o,
            modelled: o,
            momentum: [zero(); 2],
        }
    }
}

impl<R: Scalar> Motion<R> {
    /// Accelerations of all joints that do what is wished, with the forces that belong to them. `others`: accelerations of joints that are in no leg.
    ///
    /// With both feet given, the base's turning and the joints beside the legs, only the linear acceleration of the base is left; height and zero moment
    /// point are three equations for it.
    ///
    /// # Errors
    /// A stretched leg; lengths that the model does not have.
    pub fn of(
        &mut self,
        (robot, model, payload): (&WalkingRobot<R>, &impl Model<R>, &Payload<R>),
        [q, v]: [&[R]; 2],
        place: &Place<R>,
        wish: &Wish<R>,
        others: impl Fn(usize) -> R,
    ) -> Result<(), Refusal> {
        let nv = v.len();
        let state = State::new().with(Argument::Q, q).with(Argument::V, v);
        let mass = self.mass.get_mut(..nv * nv).ok_or(Refusal::WrongLength)?;
        model.evaluate(robot.mass_matrix, &state, mass).map_err(|_| Refusal::WrongLength)?;
        let bias = self.bias.get_mut(..nv).ok_or(Refusal::WrongLength)?;
        model.evaluate(robot.bias, &state, bias).map_err(|_| Refusal::WrongLength)?;
        self.modelled = get(mass, 0);
        self.momentum = momentum(mass, v);
        payload.add_to_mass(mass, nv);
        payload.add_to_bias(bias, place.base.turn, v, robot.gravity);
        self.weighs = self.modelled + payload.mass;
        self.accelerations(robot, q, place, wish, (nv, &others))?;
        self.forces(nv);
        self.balance(robot, place, wish, nv)
    }

    /// Joint accelerations as they depend on the linear acceleration of the base.
    fn accelerations(
        &mut self,
        robot: &WalkingRobot<R>,
        q: &[R],
        place: &Place<R>,
        wish: &Wish<R>,
        (nv, others): (usize, &impl Fn(usize) -> R),
    ) -> Result<(), Refusal> {
        let (one, o) = (R::constant(1.0), R::constant(0.0));
        self.columns = [[o; MOST_VELOCITIES]; 4];
        let turn = place.base.turn;
        let [free, x, y, z] = &mut self.columns;
        [(x, 0), (y, 1), (z, 2)].into_iter().for_each(|(column, axis)| set(column, axis, one));
        // The rate of the angular velocity in the root's own axes is the world's, turned.
        let torso = turned_back(turn, wish.torso);
        torso.into_iter().enumerate().for_each(|(k, x)| set(free, 3 + k, x));
        for joint in BASE..nv {
            if !robot.legs.iter().any(|leg| leg.joints.contains(&joint)) {
                set(free, joint, others(joint));
            }
        }
        // v̇ of the root's origin in the world is R (ȧ + ω × v): what the second part gives is drift of both soles, and in theirs already.
        let feet = robot.legs.iter().zip(&place.soles).zip(&wish.soles);
        for ((leg, sole), wished) in feet {
            let bend = leg.bend(q);
            let arm = subtract(sole.pose.position, place.base.position);
            let linear = subtract(subtract(wished[0], sole.drift[0]), cross(wish.torso, arm));
            let angular = subtract(subtract(wished[1], sole.drift[1]), wish.torso);
            let axis = |k: usize| {
                let mut unit = zero();
                set(&mut unit, k, one);
                scale(-one, turned(turn, unit))
            };
            let rights = [(linear, angular), (axis(0), zero()), (axis(1), zero()), (axis(2), zero())];
            let mut right = [o; 4 * LEG];
            for (right, ([a, b, c], [d, e, f])) in right.as_chunks_mut::<LEG>().0.iter_mut().zip(rights) {
                right.iter_mut().zip([a, b, c, d, e, f]).for_each(|(to, from)| *to = from);
            }
            if !damped(&sole.columns, &mut right, bend) {
                return Err(Refusal::Because("a leg is stretched or its joints are parallel"));
            }
            for (column, found) in self.columns.iter_mut().zip(right.as_chunks::<LEG>().0) {
                leg.joints.iter().zip(found).for_each(|(joint, x)| set(column, *joint, *x));
            }
        }
        Ok(())
    }

    /// D times each column; with the bias in the first one.
    fn forces(&mut self, nv: usize) {
        let Self { mass, bias, columns, forces, .. } = self;
        for (force, column) in forces.iter_mut().zip(columns.iter()) {
            force.fill(R::constant(0.0));
            for (of, x) in self::columns(mass, nv).take(nv).zip(column.iter()) {
                force.iter_mut().zip(of).for_each(|(f, m)| *f = R::fused(*m, *x, *f));
            }
        }
        let [first, ..] = forces;
        first.iter_mut().zip(bias.iter()).for_each(|(f, h)| *f = *f + *h);
    }

    /// The base's linear acceleration from height and zero moment point; then everything.
    fn balance(
        &mut self,
        robot: &WalkingRobot<R>,
        place: &Place<R>,
        wish: &Wish<R>,
        nv: usize,
    ) -> Result<(), Refusal> {
        let (turn, origin) = (place.base.turn, place.base.position);
        // What the ground gives, about the world's origin.
        let ground = |force: &[R; MOST_VELOCITIES]| {
            let [a, b, c, d, e, f, ..] = *force;
            let force = turned(turn, [a, b, c]);
            [force, add(turned(turn, [d, e, f]), cross(origin, force))]
        };
        let about = |[force, moment]: [Vector<R>; 2]| {
            let [x, y, _] = subtract(moment, cross(wish.zero_moment_point, force));
            let [_, _, up] = force;
            [up, x, y]
        };
        let [free, x, y, z] = self.forces.each_ref().map(ground);
        let [up, tip, roll] = about(free);
        let goal = self.weighs * (robot.gravity + wish.rise);
        let mut right = [goal - up, -tip, -roll];
        let [a, b, c] = [x, y, z].map(about);
        let mut matrix = [a[0], a[1], a[2], b[0], b[1], b[2], c[0], c[1], c[2]];
        if !solve(&mut matrix, &mut right) {
            return Err(Refusal::Because("the zero moment point cannot be moved"));
        }
        let sum = |all: &[[R; MOST_VELOCITIES]; 4], k: usize| {
            let [free, x, y, z] = all.each_ref().map(|column| get(column, k));
            let [a, b, c] = right;
            R::fused(a, x, R::fused(b, y, R::fused(c, z, free)))
        };
        for k in 0..nv {
            set(&mut self.acceleration, k, sum(&self.columns, k));
            if k >= BASE {
                set(&mut self.torques, k - BASE, sum(&self.forces, k));
            }
        }
        let part = |k: usize| {
            let [a, b, c] = right;
            let of = |all: &[Vector<R>; 2]| all.get(k).copied().unwrap_or(zero());
            along(along(along(of(&free), a, of(&x)), b, of(&y)), c, of(&z))
        };
        let ([fx, fy, fz], [mx, my, mz]) = (part(0), part(1));
        self.ground = [fx, fy, fz, mx, my, mz];
        let all = self.acceleration.iter().chain(&self.torques).chain(&self.ground);
        if all.into_iter().all(|x| x.is_finite()) { Ok(()) } else { Err(Refusal::NotFinite) }
    }
}
