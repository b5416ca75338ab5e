//! A foot in the quadratic program of the ground's forces: its scaled unknowns, its limits as rows, its part of the required wrench.
use super::ground_forces::{Limits, MOST_LEG_JOINTS, StandingFoot, halves, in_the_world, joined};
use super::space::{Vector, cross, subtract, transpose, turned_back};
use crate::control::slices::{get, set};
use crate::real::Scalar;

/// Push, friction both ways along x and y, four edges, turning both ways; all but the push have two numbers.
pub(super) const PAIRS: usize = 10;
/// Half the extent that a sole has at least in the scales, m.
pub(super) const LEAST_HALF: f64 = 1e-3;

/// A foot whose wrench is unknown.
#[derive(Clone, Copy)]
pub(super) struct Foot<'a, R> {
    pub(super) given: &'a StandingFoot<'a, R>,
    /// Its place among those given.
    pub(super) number: usize,
    /// From the point between the feet to its origin.
    pub(super) arm: Vector<R>,
    /// Its wrench in axes of the sole is this times its unknowns.
    pub(super) scale: [R; 6],
    /// The unknowns of the planned distribution.
    pub(super) planned: [R; 6],
    /// N
    pub(super) least_load: R,
}

impl<'a, R: Scalar> StandingFoot<'a, R> {
    pub(super) fn makes_sense(&self, torques: usize) -> bool {
        let zero = R::constant(0.0);
        let [rear, front, right, left] = self.extent;
        let numbers = self.sole.position.iter().chain(self.sole.turn.iter().flatten()).chain(&self.extent);
        let shapes = self.joints.len() == self.jacobian.len() && self.joints.len() <= MOST_LEG_JOINTS;
        let there = self
            .joints
            .iter()
            .enumerate()
            .all(|(k, joint)| *joint < torques && self.joints.iter().take(k).all(|other| other != joint));
        let finite = numbers.chain(self.jacobian.iter().flatten()).all(|x| x.is_finite());
        let open = rear <= zero && front >= zero && right <= zero && left >= zero;
        shapes && there && finite && open && front > rear && self.share >= zero && self.share.is_finite()
    }

    /// Half its width and half its length, at least a little.
    pub(super) fn halves(&self) -> [R; 2] {
        let [rear, front, right, left] = self.extent;
        let (half, least) = (R::constant(0.5), R::constant(LEAST_HALF));
        [(half * (left - right)).larger(least), (half * (front - rear)).larger(least)]
    }

    /// Limits `a w_i + b w_z ≤ 0` of its wrench in axes of the sole: i, a, b.
    pub(super) fn pairs(&self, limits: &Limits<'_, R>) -> [(usize, R, R); PAIRS] {
        let [rear, front, right, left] = self.extent;
        let one = R::constant(1.0);
        let (friction, turning) = (-limits.friction, -limits.turning);
        // The centre of pressure is at x = −M_y/F_z, y = M_x/F_z.
        [
            (0, one, friction),
            (0, -one, friction),
            (1, one, friction),
            (1, -one, friction),
            (3, one, -left),
            (3, -one, right),
            (4, -one, -front),
            (4, one, rear),
            (5, one, turning),
            (5, -one, turning),
        ]
    }
}

impl<'a, R: Scalar> Foot<'a, R> {
    /// Number and point between the feet; required force and its unit; share.
    pub(super) fn of(
        given: &'a StandingFoot<'a, R>,
        (number, middle): (usize, Vector<R>),
        (force, weight): (Vector<R>, R),
        (share, limits): (R, &Limits<'_, R>),
    ) -> Self {
        let zero = R::constant(0.0);
        let unit = weight * share.sqrt();
        let [width, length] = given.halves();
        let scales = [unit, unit, unit, unit * width, unit * length, unit * length];
        let [x, y, z] = super::space::scale(share, turned_back(given.sole.turn, force));
        let [rear, front, right, left] = given.extent;
        let half = R::constant(0.5);
        let moment = [half * (left + right) * z, -(half * (front + rear) * z), zero];
        let mut planned = joined([x, y, z], moment);
        planned.iter_mut().zip(scales).for_each(|(planned, scale)| *planned = *planned / scale);
        let reach = z.larger(zero);
        let least_load = if limits.least_load > reach { reach } else { limits.least_load };
        let arm = subtract(given.sole.position, middle);
        Self { given, number, arm, scale: scales, planned, least_load }
    }

    /// Rows of the map from its unknowns to its part of the required wrench.
    pub(super) fn to_middle(self, [weight, lever]: [R; 2]) -> [[R; 6]; 6] {
        let (force, moment) = halves(self.scale);
        let turn = self.given.sole.turn;
        let axes = transpose(turn);
        let zero = R::constant(0.0);
        let scaled =
            |[a, b, c]: Vector<R>, [d, e, f]: Vector<R>, unit: R| [a * d / unit, b * e / unit, c * f / unit];
        // Column j of r × R is r × (column j of R).
        let [a, b, c] = transpose(axes.map(|axis| cross(self.arm, axis)));
        let [x, y, z] = turn;
        let first = |row| joined(scaled(row, force, weight), [zero; 3]);
        let second = |arm, row| joined(scaled(arm, force, lever), scaled(row, moment, lever));
        [first(x), first(y), first(z), second(a, x), second(b, y), second(c, z)]
    }

    /// What its unknowns add to −sign × the torque of a joint: sign Jᵀ w.
    pub(super) fn of_joint(&self, joint: usize, sign: R) -> [R; 6] {
        let place = self.given.joints.iter().position(|own| *own == joint);
        let Some(column) = place.and_then(|place| self.given.jacobian.get(place)) else {
            return [R::constant(0.0); 6];
        };
        let (linear, angular) = halves(*column);
        let turn = self.given.sole.turn;
        let mut row = joined(turned_back(turn, linear), turned_back(turn, angular));
        row.iter_mut().zip(self.scale).for_each(|(a, scale)| *a = sign * *a * scale);
        row
    }

    /// Limits of its wrench, whose unknowns begin at `first`.
    pub(super) fn write_limits(&self, first: usize, limits: &Limits<'_, R>, writer: &mut Writer<'_, R>) {
        let zero = R::constant(0.0);
        let of = |k: usize| get(&self.scale, k);
        writer.push_pair(-self.least_load / of(2), (first, zero), (first + 2, -R::constant(1.0)));
        for (i, a, b) in self.given.pairs(limits) {
            if b.is_finite() {
                let (a, b) = (a * of(i), b * of(2));
                let length = (a * a + b * b).sqrt();
                writer.push_pair(zero, (first + i, a / length), (first + 2, b / length));
            }
        }
    }

    /// A wrench in unknowns, in the world.
    pub(super) fn write(&self, unknown: impl Fn(usize) -> R, wrenches: &mut [[R; 6]; 2]) {
        let mut own = self.scale;
        own.iter_mut().enumerate().for_each(|(k, w)| *w = *w * unknown(k));
        if let Some(wrench) = wrenches.get_mut(self.number) {
            *wrench = in_the_world(&self.given.sole, own);
        }
    }

    /// A wrench within the limits of the ground, where no search came to an end: the planned one, pushing and within its friction.
    pub(super) fn hold(&self, limits: &Limits<'_, R>, wrenches: &mut [[R; 6]; 2]) {
        let mut own = self.planned;
        own.iter_mut().zip(self.scale).for_each(|(w, scale)| *w = *w * scale);
        let [x, y, z, _, _, _] = own;
        let push = z.larger(self.least_load);
        let most = limits.friction * push;
        let kept = |force: R| if force.abs() > most { force.sign() * most } else { force };
        let [rear, front, right, left] = self.given.extent;
        let half = R::constant(0.5);
        let moment = [half * (left + right) * push, -(half * (front + rear) * push), R::constant(0.0)];
        if let Some(wrench) = wrenches.get_mut(self.number) {
            *wrench = in_the_world(&self.given.sole, joined([kept(x), kept(y), push], moment));
        }
    }
}

/// Rows one after the other.
pub(super) struct Writer<'m, R> {
    pub(super) rows: &'m mut [R],
    pub(super) bounds: &'m mut [R],
    pub(super) size: usize,
    pub(super) count: usize,
}

impl<R: Scalar> Writer<'_, R> {
    fn next(&mut self, bound: R) -> Option<&mut [R]> {
        let first = self.count * self.size;
        *self.bounds.get_mut(self.count)? = bound;
        let row = self.rows.get_mut(first..first + self.size)?;
        self.count += 1;
        Some(row)
    }

    pub(super) fn push(&mut self, bound: R, row: impl Iterator<Item = R>) {
        if let Some(place) = self.next(bound) {
            place.iter_mut().zip(row).for_each(|(a, value)| *a = value);
        }
    }

    /// A row of zeros but for two numbers.
    pub(super) fn push_pair(&mut self, bound: R, (i, a): (usize, R), (j, b): (usize, R)) {
        let Some(place) = self.next(bound) else { return };
        place.fill(R::constant(0.0));
        set(place, i, a);
        set(place, j, b);
    }
}
