//! The quadratic program of the ground's forces: scaled unknowns, equations, limits as rows, and what is done when they contradict each other.
use super::ground_forces::{
    Certificate, Limits, MOST_LEG_JOINTS, StandingFoot, about, halves, in_the_world, joined,
};
use super::space::{Vector, add, cross, length, scale, subtract, transpose, turned_back};
use crate::control::least_change::{
    Active, Conditions, Optimality, Room, Search, nearest, nearest_compromise, optimality,
};
use crate::control::slices::{copy, get, set};
use crate::real::Scalar;

/// Unknowns of two feet.
const MOST_UNKNOWNS: usize = 12;
/// The required wrench.
const EQUATIONS: usize = 6;
/// Push, friction both ways along x and y, four edges, turning both ways; all but the push have two numbers.
const PAIRS: usize = 10;
/// Rows of two feet.
const MOST_ROWS: usize = EQUATIONS + 2 * (1 + PAIRS) + 2 * 2 * MOST_LEG_JOINTS;
/// Numbers of a search and of a compromise.
const ROOM: usize = MOST_UNKNOWNS * (3 * MOST_UNKNOWNS + 4);
/// The least share of a foot that is there.
const LEAST_SHARE: f64 = 1e-6;
/// Half the extent that a sole has at least in the scales, m.
const LEAST_HALF: f64 = 1e-3;
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

/// A foot whose wrench is unknown.
#[derive(Clone, Copy)]
struct Foot<'a, R> {
    given: &'a StandingFoot<'a, R>,
    /// Its place among those given.
    number: usize,
    /// From the point between the feet to its origin.
    arm: Vector<R>,
    /// Its wrench in axes of the sole is this times its unknowns.
    scale: [R; 6],
    /// The unknowns of the planned distribution.
    planned: [R; 6],
    /// N
    least_load: R,
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

impl<'a, R: Scalar> StandingFoot<'a, R> {
    fn makes_sense(&self, torques: usize) -> bool {
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
    fn halves(&self) -> [R; 2] {
        let [rear, front, right, left] = self.extent;
        let (half, least) = (R::constant(0.5), R::constant(LEAST_HALF));
        [(half * (left - right)).larger(least), (half * (front - rear)).larger(least)]
    }

    /// Limits `a w_i + b w_z ≤ 0` of its wrench in axes of the sole: i, a, b.
    fn pairs(&self, limits: &Limits<'_, R>) -> [(usize, R, R); PAIRS] {
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
                for (foot, x) in self.feet().zip(x.chunks_exact(6)) {
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
        let found = nearest_compromise(conditions, x, memory, &mut room, &mut active);
        // What is left are the limits in coordinates in which x is the nearest point to 0.
        let (rows, bounds) = (work.rows.get_mut(EQUATIONS * size..)?, work.bounds.get_mut(EQUATIONS..)?);
        let limits = Conditions { rows, bounds, size, equations: 0, count: count - EQUATIONS };
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
            Conditions { rows, bounds, size, equations: 0, count }.normalise();
        }
        Conditions { rows, bounds, size, equations: EQUATIONS, count }
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

impl<'a, R: Scalar> Foot<'a, R> {
    /// Number and point between the feet; required force and its unit; share.
    fn of(
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
    fn to_middle(self, [weight, lever]: [R; 2]) -> [[R; 6]; 6] {
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
    fn of_joint(&self, joint: usize, sign: R) -> [R; 6] {
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
    fn write_limits(&self, first: usize, limits: &Limits<'_, R>, writer: &mut Writer<'_, R>) {
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
    fn write(&self, unknown: impl Fn(usize) -> R, wrenches: &mut [[R; 6]; 2]) {
        let mut own = self.scale;
        own.iter_mut().enumerate().for_each(|(k, w)| *w = *w * unknown(k));
        if let Some(wrench) = wrenches.get_mut(self.number) {
            *wrench = in_the_world(&self.given.sole, own);
        }
    }

    /// A wrench within the limits of the ground, where no search came to an end: the planned one, pushing and within its friction.
    fn hold(&self, limits: &Limits<'_, R>, wrenches: &mut [[R; 6]; 2]) {
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

impl<R: Scalar> From<Optimality<R>> for Certificate<R> {
    fn from(found: Optimality<R>) -> Self {
        let Optimality { stationarity, wrong_sign, excess } = found;
        Self { stationarity, wrong_sign, excess }
    }
}

/// Rows one after the other.
struct Writer<'m, R> {
    rows: &'m mut [R],
    bounds: &'m mut [R],
    size: usize,
    count: usize,
}

impl<R: Scalar> Writer<'_, R> {
    fn next(&mut self, bound: R) -> Option<&mut [R]> {
        let first = self.count * self.size;
        *self.bounds.get_mut(self.count)? = bound;
        let row = self.rows.get_mut(first..first + self.size)?;
        self.count += 1;
        Some(row)
    }

    fn push(&mut self, bound: R, row: impl Iterator<Item = R>) {
        if let Some(place) = self.next(bound) {
            place.iter_mut().zip(row).for_each(|(a, value)| *a = value);
        }
    }

    /// A row of zeros but for two numbers.
    fn push_pair(&mut self, bound: R, (i, a): (usize, R), (j, b): (usize, R)) {
        let Some(place) = self.next(bound) else { return };
        place.fill(R::constant(0.0));
        set(place, i, a);
        set(place, j, b);
    }
}
