//! Limits that the ground and the drives set to torques, as inequalities aᵀu ≤ b.
use super::phased::{PhaseLayout, PhasedLayout, StandingFoot};
use crate::real::Scalar;

/// Part of what all feet carry by which a foot that is let go may exceed its friction: what it carries vanishes, and the quotient of its forces means
/// nothing there. Half of what a simulation takes for nothing, so that it is kept there too.
const LIGHT: f64 = 0.005;

/// What a limit is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// The torque of a joint.
    Torque(u8),
    /// A foot, by its place in [`PhaseLayout::feet`], may not push less than [`PhasedLayout::least_push`].
    Push(u8),
    /// It may not slip.
    Friction(u8),
    /// It may not tip: the centre of pressure stays in the sole (6.42).
    Edge(u8),
}

/// Rows to be written one after the other.
pub(super) struct Writer<'m, R> {
    pub rows: &'m mut [R],
    pub bounds: &'m mut [R],
    pub size: usize,
    pub count: usize,
}

impl<R: Scalar> Writer<'_, R> {
    /// The next row, with its bound.
    pub fn push(&mut self, bound: R, row: impl Fn(usize) -> R) {
        let (first, count) = (self.count * self.size, self.count);
        let Some(place) = self.rows.get_mut(first..first + self.size) else { return };
        place.iter_mut().enumerate().for_each(|(k, a)| *a = row(k));
        if let Some(place) = self.bounds.get_mut(count) {
            *place = bound;
            self.count += 1;
        }
    }
}

/// A foot whose letting go ends the phase. It keeps the push that torques without regard to its friction would give it, so that it is let go
/// when it is meant to be; only the force along the ground gives way.
#[derive(Clone, Copy)]
pub(super) struct LettingGo<R> {
    /// Place among the feet of the phase.
    pub number: usize,
    force: [usize; 2],
    push: R,
    most: R,
}

/// Forces of the ground as they depend on torques: λ₀ + Λ u.
#[derive(Clone, Copy)]
pub(super) struct Forces<'m, R> {
    /// `lie_derivatives` of the phase, column after column.
    pub lie: &'m [R],
    pub layout: &'m PhaseLayout,
}

impl<R: Scalar> Forces<'_, R> {
    fn at(&self, force: usize, column: usize) -> R {
        let height = self.layout.outputs + self.layout.forces;
        self.lie.get(column * height + self.layout.outputs + force).copied().unwrap_or(R::constant(0.0))
    }

    /// λ₀ of a force.
    pub fn free(&self, force: usize) -> R {
        self.at(force, 2)
    }

    /// What one N m at a joint adds.
    pub fn of_torque(&self, force: usize, joint: usize) -> R {
        self.at(force, 3 + joint)
    }

    /// `a λ_i + b λ_j ≤ 0`.
    fn push(&self, writer: &mut Writer<'_, R>, (a, i): (R, usize), (b, j): (R, usize)) {
        let bound = -(a * self.free(i) + b * self.free(j));
        writer.push(bound, |joint| a * self.of_torque(i, joint) + b * self.of_torque(j, joint));
    }

    /// A force at these torques.
    fn force(&self, force: usize, torques: &[R]) -> R {
        let of = torques.iter().enumerate();
        of.fold(self.free(force), |sum, (joint, u)| R::fused(self.of_torque(force, joint), *u, sum))
    }

    /// The foot that is let go, if it would slip with these torques.
    pub fn letting_go(&self, friction: Option<f64>, torques: &[R]) -> Option<LettingGo<R>> {
        let mut feet = self.layout.feet.iter().enumerate();
        let (number, foot) = feet.find_map(|(k, foot)| Some((k, foot.filter(|foot| !foot.holds)?)))?;
        let [along, push] = foot.force.map(|force| self.force(force, torques));
        let most = R::constant(friction?) * push.larger(R::constant(0.0));
        let load = self.all_pushes(|push| self.force(push, torques));
        let slips = along.abs() > most + R::constant(LIGHT) * load;
        slips.then_some(LettingGo { number, force: foot.force, push, most })
    }

    /// The sum over the pushes of all feet.
    fn all_pushes(&self, of: impl Fn(usize) -> R) -> R {
        let feet = self.layout.feet.iter().flatten();
        feet.fold(R::constant(0.0), |sum, foot| sum + of(foot.force[1]))
    }

    /// The push of a foot that is let go, as an equation.
    pub fn keep_push(&self, of: &LettingGo<R>, writer: &mut Writer<'_, R>) {
        let z = of.force[1];
        writer.push(of.push - self.free(z), |joint| self.of_torque(z, joint));
    }

    /// Its friction.
    pub fn keep_from_slipping(&self, of: &LettingGo<R>, writer: &mut Writer<'_, R>) {
        let (x, light) = (of.force[0], R::constant(LIGHT));
        let free = light * self.all_pushes(|push| self.free(push));
        for sign in [1.0, -1.0].map(R::constant) {
            writer.push(of.most + free - sign * self.free(x), |joint| {
                sign * self.of_torque(x, joint) - light * self.all_pushes(|push| self.of_torque(push, joint))
            });
        }
    }

    /// Limits of a foot: push, friction both ways, both edges.
    fn foot(&self, foot: &StandingFoot, of: &PhasedLayout, writer: &mut Writer<'_, R>) {
        let [x, z] = foot.force;
        let one = R::constant(1.0);
        if foot.holds {
            let bound = self.free(z) - R::constant(of.least_push);
            writer.push(bound, |joint| -self.of_torque(z, joint));
            if let Some(friction) = of.friction.map(R::constant) {
                self.push(writer, (one, x), (-friction, z));
                self.push(writer, (-one, x), (-friction, z));
            }
        }
        // The centre of pressure is −M/F_z from the middle of the sole.
        let Some(moment) = foot.moment else { return };
        let [rear, front] = foot.sole.map(R::constant);
        if foot.level[0] {
            self.push(writer, (one, moment), (rear, z));
        }
        if foot.level[1] {
            self.push(writer, (-one, moment), (-front, z));
        }
    }

    /// All limits of the ground, for a gait of these sizes.
    pub fn write(&self, of: &PhasedLayout, writer: &mut Writer<'_, R>) {
        for foot in self.layout.feet.iter().flatten() {
            self.foot(foot, of, writer);
        }
    }
}

/// Limits of a foot by their rows, in the order of [`Forces::write`], with whether they are written.
fn of_foot(foot: u8, standing: &StandingFoot, friction: bool) -> [(bool, Limit); 5] {
    let edge =
        |k: usize| (standing.moment.is_some() && standing.level.get(k) == Some(&true), Limit::Edge(foot));
    let slips = (standing.holds && friction, Limit::Friction(foot));
    [(standing.holds, Limit::Push(foot)), slips, slips, edge(0), edge(1)]
}

/// The limits that [`Forces::write`] writes, row after row.
pub(super) fn rows(layout: &PhaseLayout, friction: bool) -> impl Iterator<Item = Limit> {
    let standing =
        layout.feet.iter().enumerate().filter_map(|(foot, standing)| Some((foot as u8, standing.as_ref()?)));
    let all = standing.flat_map(move |(foot, standing)| of_foot(foot, standing, friction));
    all.filter_map(|(written, limit)| written.then_some(limit))
}
