//! The quadratic program of the ground's forces: scaled unknowns, equations, limits as rows, and what is done when they contradict each other.
use super::ground_foot::{Foot, LEAST_HALF, PAIRS, Writer};
use super::ground_forces::{Certificate, Limits, MOST_LEG_JOINTS, StandingFoot, about, halves, joined};
use super::space::{add, length, scale, turned_back};
use crate::control::least_change::{
    Active, Conditions, Optimality, Room, Search, nearest, nearest_compromise, optimality,
};
use crate::control::slices::{copy, get};
use crate::real::Scalar;

/// How much more a missing wrench weighs than a change of the shares, squares of N and N m.
const MISSING: f64 = 1e4;

/// Unknowns of two feet.
const MOST_UNKNOWNS: usize = 12;
/// The required wrench.
const EQUATIONS: usize = 6;
/// Rows of two feet.
const MOST_ROWS: usize = EQUATIONS + 2 * (1 + PAIRS) + 2 * 2 * MOST_LEG_JOINTS;
/// Numbers of a search and of a compromise.
const ROOM: usize = MOST_UNKNOWNS * (3 * MOST_UNKNOWNS + 4);
/// The least share of a foot that is there.
const LEAST_SHARE: f64 = 1e-6;
/// Roundings: a limit is met within so many of what it is made of.
const MET: f64 = 1e3;

/// Numbers to work with.
pub(super) struct Work<R> {
    rows: [R; MOST_ROWS * MOST_UNKNOWNS],
    bounds: [R; MOST_ROWS],
    room: [R; ROOM],
}

impl<R: Scalar> Work<R> {
    pub fn new() -> Self {
        let zero = R::constant(0.0);
        Self { rows: [zero; MOST_ROWS * MOST_UNKNOWNS], bounds: [zero; MOST_ROWS], room: [zero; ROOM] }
    }
}

/// What was found.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Outcome {
    Met,
    GaveWay,
}

/// The program.
pub(super) struct Program<'a, R> {
    feet: [Option<Foot<'a, R>>; 2],
    limits: &'a Limits<'a, R>,
    /// About the world's origin.
    required: [R; 6],
    /// About the point between the feet, in the units of the equations.
    goal: [R; 6],
    /// W (N), and W times half a sole (N m).
    units: [R; 2],
}

impl<'a, R: Scalar> Program<'a, R> {
    /// `None`: an argument makes no sense.
    pub fn of(
        feet: &'a [StandingFoot<'a, R>],
        required: [R; 6],
        limits: &'a Limits<'a, R>,
        torques: usize,
    ) -> Option<Self> {
        let one = R::constant(1.0);
        if !feet.iter().all(|foot| foot.makes_sense(torques)) {
            return None;
        }
        let (first, second) = match feet {
            [only] => (only, None),
            [first, second] => (first, Some(second)),
            _ => return None,
        };
        let shares = match second {
            Some(second) if first.share + second.share > R::constant(0.0) => {
                let sum = first.share + second.share;
                [first.share / sum, second.share / sum]
            }
            Some(_) => [R::constant(0.5); 2],
            None => [one, R::constant(0.0)],
        };
        let there = shares.map(|share| share >= R::constant(LEAST_SHARE));
        let middle = match second {
            Some(second) if there == [true; 2] => {
                scale(R::constant(0.5), add(first.sole.position, second.sole.position))
            }
            Some(second) if there == [false, true] => second.sole.position,
            _ => first.sole.position,
        };
        let (force, moment) = halves(about(middle, required));
        let size = length(force);
        // Where no force is required, any unit will do.
        let weight = if size > R::constant(0.0) { size } else { one };
        let mut program =
            Self { feet: [None; 2], limits, required, goal: [R::constant(0.0); 6], units: [weight; 2] };
        let mut longest = R::constant(LEAST_HALF);
        let given = [Some(first), second];
        for (number, ((place, given), share)) in program.feet.iter_mut().zip(given).zip(shares).enumerate() {
            let Some(given) = given.filter(|_| share >= R::constant(LEAST_SHARE)) else { continue };
            *place = Some(Foot::of(given, (number, middle), (force, weight), (share, limits)));
            longest = longest.larger(given.halves()[1]);
        }
        program.units = [weight, weight * longest];
        program.goal = joined(scale(one / weight, force), scale(one / (weight * longest), moment));
        Some(program)
    }

    fn feet(&self) -> impl Iterator<Item = &Foot<'a, R>> {
        self.feet.iter().flatten()
    }

    /// The wrench of a foot that stands alone, if it is within all limits: nothing is to be searched for.
    pub fn determined(&self, torques: &[R], wrenches: &mut [[R; 6]; 2]) -> bool {
        let (Some(foot), 1) = (self.feet().next(), self.feet().count()) else { return false };
        let sole = &foot.given.sole;
        let world = about(sole.position, self.required);
        let (force, moment) = halves(world);
        let wrench = joined(turned_back(sole.turn, force), turned_back(sole.turn, moment));
        let met = R::constant(MET * R::EPSILON);
        let push = get(&wrench, 2);
        let mut within = push >= foot.least_load;
        for (i, a, b) in foot.given.pairs(self.limits) {
            let (own, normal) = (a * get(&wrench, i), b * push);
            within &= !b.is_finite() || own + normal <= met * (own.abs() + normal.abs());
        }
        for (joint, column) in foot.given.joints.iter().zip(foot.given.jacobian) {
            let torque =
                column.iter().zip(&world).fold(get(torques, *joint), |sum, (j, w)| R::fused(-*j, *w, sum));
            within &= self.limits.of(*joint).is_none_or(|limit| torque.abs() <= limit);
        }
        if let (true, Some(place)) = (within, wrenches.get_mut(foot.number)) {
            *place = world;
        }
        within
    }

    /// The nearest wrenches, world axes.
    pub fn search(
        &self,
        torques: &[R],
        work: &mut Work<R>,
        wrenches: &mut [[R; 6]; 2],
    ) -> (Outcome, Certificate<R>) {
        let tries = [
            (Outcome::Met, Some(torques)),
            (Outcome::GaveWay, Some(torques)),
            // Drives ask for what the ground cannot give: without regard to them.
            (Outcome::Met, None),
            (Outcome::GaveWay, None),
        ];
        let mut x = [R::constant(0.0); MOST_UNKNOWNS];
        let size = 6 * self.feet().count();
        for (outcome, torques) in tries {
            let Some(x) = x.get_mut(..size) else { break };
            x.iter_mut().zip(self.feet().flat_map(|foot| foot.planned)).for_each(|(x, planned)| *x = planned);
            let found = match outcome {
                Outcome::Met => self.nearest(torques, work, x),
                Outcome::GaveWay => self.compromise(torques, work, x),
            };
            if let Some(certificate) = found.filter(Certificate::holds) {
                for (foot, x) in self.feet().zip(x.as_chunks::<6>().0) {
                    foot.write(|k| get(x, k), wrenches);
                }
                return (outcome, certificate);
            }
        }
        self.feet().for_each(|foot| foot.hold(self.limits, wrenches));
        (Outcome::GaveWay, Certificate::none())
    }

    /// The nearest x that gives the required wrench within all limits.
    fn nearest(&self, torques: Option<&[R]>, work: &mut Work<R>, x: &mut [R]) -> Option<Certificate<R>> {
        let mut start = [R::constant(0.0); MOST_UNKNOWNS];
        let start = start.get_mut(..x.len())?;
        copy(x, start);
        let conditions = self.conditions(torques, &mut work.rows, &mut work.bounds, x.len());
        let mut room = Room::of(&mut work.room, x.len())?;
        let mut active = Active::new();
        let found = nearest(&conditions, x, &mut room, &mut active);
        (found == Search::Found).then(|| optimality(&conditions, (start, x), &mut room, &active).into())
    }

    /// The nearest x within all limits that gives the required wrench as well as can be.
    fn compromise(&self, torques: Option<&[R]>, work: &mut Work<R>, x: &mut [R]) -> Option<Certificate<R>> {
        let (size, zero) = (x.len(), R::constant(0.0));
        let (mut factor, mut centre) = ([zero; MOST_UNKNOWNS * MOST_UNKNOWNS], [zero; MOST_UNKNOWNS]);
        let (mut point, start) = ([zero; MOST_UNKNOWNS], [zero; MOST_UNKNOWNS]);
        let point = point.get_mut(..size)?;
        let conditions = self.conditions(torques, &mut work.rows, &mut work.bounds, size);
        let count = conditions.count;
        let mut room = Room::of(&mut work.room, size)?;
        let mut active = Active::new();
        let memory = (factor.get_mut(..size * size)?, centre.get_mut(..size)?, &mut *point);
        let found = nearest_compromise(conditions, x, MISSING, memory, &mut room, &mut active);
        // What is left are the limits in coordinates in which x is the nearest point to 0.
        let (rows, bounds) = (work.rows.get_mut(EQUATIONS * size..)?, work.bounds.get_mut(EQUATIONS..)?);
        let limits = Conditions { rows, bounds, size, equations: 0, count: count - EQUATIONS, limits: &[] };
        let start = start.get(..size)?;
        (found == Search::Found).then(|| optimality(&limits, (start, point), &mut room, &active).into())
    }

    /// Equations, then limits of the ground, then those of the drives; limits are unit vectors.
    fn conditions<'m>(
        &self,
        torques: Option<&[R]>,
        rows: &'m mut [R],
        bounds: &'m mut [R],
        size: usize,
    ) -> Conditions<'m, R> {
        let mut writer = Writer { rows, bounds, size, count: 0 };
        let zero = R::constant(0.0);
        let maps = self.feet.map(|foot| foot.map(|foot| foot.to_middle(self.units)));
        for (equation, goal) in self.goal.iter().enumerate() {
            let row = maps.iter().flatten().flat_map(|map| map.get(equation).copied().unwrap_or([zero; 6]));
            writer.push(*goal, row);
        }
        for (place, foot) in self.feet().enumerate() {
            foot.write_limits(6 * place, self.limits, &mut writer);
        }
        let first = writer.count;
        if let Some(torques) = torques {
            self.write_drives(torques, &mut writer);
        }
        let Writer { rows, bounds, count, .. } = writer;
        if let (Some(rows), Some(bounds)) = (rows.get_mut(first * size..), bounds.get_mut(first..)) {
            let count = count.saturating_sub(first);
            Conditions { rows, bounds, size, equations: 0, count, limits: &[] }.normalise();
        }
        Conditions { rows, bounds, size, equations: EQUATIONS, count, limits: &[] }
    }

    /// Both limits of each joint that a wrench acts on.
    fn write_drives(&self, torques: &[R], writer: &mut Writer<'_, R>) {
        let lever = R::constant(MET * R::EPSILON) * get(&self.units, 0);
        for (place, foot) in self.feet().enumerate() {
            for joint in foot.given.joints {
                let known = self.feet().take(place).any(|before| before.given.joints.contains(joint));
                let Some(limit) = self.limits.of(*joint).filter(|_| !known) else { continue };
                let row = |sign: R| self.feet().flat_map(move |foot| foot.of_joint(*joint, sign));
                if row(R::constant(1.0)).any(|a| a.abs() > lever) {
                    let torque = get(torques, *joint);
                    writer.push(limit - torque, row(-R::constant(1.0)));
                    writer.push(limit + torque, row(R::constant(1.0)));
                }
            }
        }
    }
}

impl<R: Scalar> From<Optimality<R>> for Certificate<R> {
    fn from(found: Optimality<R>) -> Self {
        let Optimality { stationarity, wrong_sign, excess } = found;
        Self { stationarity, wrong_sign, excess }
    }
}
