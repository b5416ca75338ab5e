//! The least change of torques that meets conditions: the nearest point of a polyhedron, by the dual method of Goldfarb and Idnani (1983),
//! with bounded work and without a panic.
//!
//! Which point that is depends on nothing but the conditions, so that a controller's answer is a function of the state: no search begins
//! where another one ended.
use super::phased::MOST_JOINTS;
use super::slices::{columns, copy, get, set};
use crate::real::Scalar;

/// Most conditions of a search.
const MOST_CONDITIONS: usize = 256;
/// Most exchanges of a search.
const EXCHANGES: usize = 200;
/// Roundings: a row that is this small beside what it was depends on the others.
const DEPENDENT: f64 = 1e3;
/// Roundings: a condition is met within so many of what it is made of.
const MET: f64 = 1e3;

/// Conditions aᵀx = b, then aᵀx ≤ b, then limits of the unknowns themselves.
pub(crate) struct Conditions<'m, R> {
    /// Row after row, each of `size` numbers.
    pub rows: &'m mut [R],
    pub bounds: &'m mut [R],
    pub size: usize,
    /// So many of them, from the first one on, are equations.
    pub equations: usize,
    /// How many rows there are.
    pub count: usize,
    /// Behind the rows stand x_k ≤ l_k and −x_k ≤ l_k for each of these numbers l_k, of which none is negative.
    pub limits: &'m [R],
}

/// What became of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Search {
    Found,
    /// An equation depends on the others.
    Dependent,
    /// No point meets them all.
    Impossible,
    /// The search was given up.
    Unfinished,
}

/// Numbers of a search: `size` × (2 `size` + 4) of them.
pub(crate) struct Room<'m, R> {
    /// Orthonormal columns that span the active rows.
    pub basis: &'m mut [R],
    /// The active rows in that basis: upper triangle, column after column.
    pub upper: &'m mut [R],
    /// Multipliers of the active rows.
    pub multipliers: &'m mut [R],
    /// How they change.
    pub change: &'m mut [R],
    /// The direction of a step.
    pub step: &'m mut [R],
    /// A row in the basis.
    pub along: &'m mut [R],
}

impl<'m, R> Room<'m, R> {
    pub fn of(memory: &'m mut [R], size: usize) -> Option<Self> {
        let (basis, rest) = memory.split_at_mut_checked(size * size)?;
        let (upper, rest) = rest.split_at_mut_checked(size * size)?;
        let (multipliers, rest) = rest.split_at_mut_checked(size)?;
        let (change, rest) = rest.split_at_mut_checked(size)?;
        let (step, rest) = rest.split_at_mut_checked(size)?;
        let (along, _) = rest.split_at_mut_checked(size)?;
        Some(Self { basis, upper, multipliers, change, step, along })
    }
}

fn dot<R: Scalar>(a: &[R], b: &[R]) -> R {
    a.iter().zip(b).fold(R::constant(0.0), |sum, (a, b)| R::fused(*a, *b, sum))
}

impl<R: Scalar> Conditions<'_, R> {
    fn row(&self, index: usize) -> &[R] {
        self.rows.get(index * self.size..(index + 1) * self.size).unwrap_or(&[])
    }

    /// How many conditions there are.
    fn all(&self) -> usize {
        self.count + 2 * self.limits.len()
    }

    /// Which unknown a condition behind the rows limits, and from which side.
    fn limited(&self, index: usize) -> Option<(usize, R)> {
        let place = index.checked_sub(self.count)?;
        Some((place / 2, R::constant(if place.is_multiple_of(2) { 1.0 } else { -1.0 })))
    }

    /// Writes aᵀ of a condition.
    fn write(&self, index: usize, into: &mut [R]) {
        let Some((k, sign)) = self.limited(index) else { return copy(self.row(index), into) };
        into.fill(R::constant(0.0));
        set(into, k, sign);
    }

    /// How far x is beyond a condition.
    fn excess(&self, index: usize, x: &[R]) -> R {
        match self.limited(index) {
            Some((k, sign)) => sign * get(x, k) - get(self.limits, k),
            None => dot(self.row(index), x) - get(self.bounds, index),
        }
    }

    /// How large what an excess is made of is.
    fn size_of(&self, index: usize, x: &[R]) -> R {
        if let Some((k, _)) = self.limited(index) {
            return get(self.limits, k) + get(x, k).abs();
        }
        let bound = get(self.bounds, index).abs();
        self.row(index).iter().zip(x).fold(bound, |sum, (a, x)| sum + (*a * *x).abs())
    }

    /// Makes every row a unit vector; a row of zeros stays one.
    pub fn normalise(&mut self) {
        for index in 0..self.count {
            let length = dot(self.row(index), self.row(index)).sqrt();
            let factor = R::constant(1.0) / length;
            if factor.is_finite() {
                let row = self.rows.get_mut(index * self.size..(index + 1) * self.size).unwrap_or(&mut []);
                row.iter_mut().for_each(|a| *a = *a * factor);
                set(self.bounds, index, get(self.bounds, index) * factor);
            }
        }
    }
}

/// The conditions that hold with equality, in the order in which they became so.
pub(crate) struct Active {
    indices: [u16; MOST_JOINTS],
    count: usize,
    /// The same as bits.
    bits: [u64; MOST_CONDITIONS / 64],
}

impl Active {
    pub fn new() -> Self {
        Self { indices: [0; MOST_JOINTS], count: 0, bits: [0; MOST_CONDITIONS / 64] }
    }

    /// The conditions.
    pub fn all(&self) -> impl Iterator<Item = usize> + '_ {
        self.indices.iter().take(self.count).map(|&index| usize::from(index))
    }

    fn holds(&self, index: usize) -> bool {
        self.bits.get(index / 64).is_some_and(|bits| bits >> (index % 64) & 1 == 1)
    }

    fn mark(&mut self, index: usize) {
        if let Some(bits) = self.bits.get_mut(index / 64) {
            *bits ^= 1 << (index % 64);
        }
    }

    fn push(&mut self, index: usize) {
        self.mark(index);
        set(&mut self.indices, self.count, index as u16);
        self.count += 1;
    }

    fn remove(&mut self, place: usize) {
        if let Some(&index) = self.indices.get(place) {
            self.mark(usize::from(index));
        }
        for k in place + 1..self.count {
            let next = self.indices.get(k).copied().unwrap_or(0);
            set(&mut self.indices, k - 1, next);
        }
        self.count = self.count.saturating_sub(1);
    }
}

/// Moves x to the nearest point that meets the conditions, whose rows are unit vectors.
pub(crate) fn nearest<R: Scalar>(
    conditions: &Conditions<'_, R>,
    x: &mut [R],
    room: &mut Room<'_, R>,
    active: &mut Active,
) -> Search {
    if x.len() > MOST_JOINTS || conditions.size != x.len() || conditions.all() > MOST_CONDITIONS {
        return Search::Impossible;
    }
    *active = Active::new();
    let one = R::constant(1.0);
    for index in 0..conditions.equations {
        let excess = conditions.excess(index, x);
        let Some(reach) = room.direct(conditions, index, active.count) else { return Search::Dependent };
        let length = -excess / reach;
        x.iter_mut().zip(room.step.iter()).for_each(|(x, step)| *x = R::fused(length, *step, *x));
        // Equations have multipliers of any sign, which nobody asks for.
        room.enter(active.count);
        active.push(index);
    }
    for _ in 0..EXCHANGES {
        let Some(index) = worst(conditions, x, active) else { return Search::Found };
        let mut own = R::constant(0.0);
        loop {
            let excess = conditions.excess(index, x);
            let reach = room.direct(conditions, index, active.count);
            room.solve(active.count);
            let first = room.first_to_leave(active.count, conditions.equations);
            // Along −step the excess falls by `reach` per unit.
            let whole = reach.map(|reach| excess / reach);
            let (length, leaves) = match (whole, first) {
                (None, None) => return Search::Impossible,
                (Some(whole), None) => (whole, None),
                (Some(whole), Some((_, at))) if whole <= at => (whole, None),
                (_, Some((place, at))) => (at, Some(place)),
            };
            if whole.is_some() {
                x.iter_mut().zip(room.step.iter()).for_each(|(x, step)| *x = R::fused(-length, *step, *x));
            }
            let changes = room.multipliers.iter_mut().zip(room.change.iter());
            changes.take(active.count).for_each(|(u, change)| *u = R::fused(-length, *change, *u));
            own = R::fused(length, one, own);
            let Some(place) = leaves else {
                room.enter(active.count);
                set(room.multipliers, active.count, own);
                active.push(index);
                break;
            };
            room.leave(conditions, active, place);
        }
    }
    Search::Unfinished
}

/// How far the conditions of Karush, Kuhn and Tucker hold at a point that was found; each is 0 but for roundings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Optimality<R> {
    /// |x₀ − x − Aᵀu| with the multipliers u of the active rows.
    pub stationarity: R,
    /// The most negative multiplier of an inequality, without its sign.
    pub wrong_sign: R,
    /// How far the farthest condition is violated, or an active one not met with equality.
    pub excess: R,
}

/// Asks for them after a search from `start` ended in x.
pub(crate) fn optimality<R: Scalar>(
    conditions: &Conditions<'_, R>,
    (start, x): (&[R], &[R]),
    room: &mut Room<'_, R>,
    active: &Active,
) -> Optimality<R> {
    room.step.iter_mut().zip(start.iter().zip(x)).for_each(|(step, (start, x))| *step = *start - *x);
    for k in 0..active.count {
        let part = room.take_off(k);
        set(room.along, k, part);
    }
    let stationarity = dot(room.step, room.step).sqrt();
    room.solve(active.count);
    let zero = R::constant(0.0);
    let (mut wrong_sign, mut excess) = (zero, zero);
    for place in conditions.equations..active.count {
        wrong_sign = wrong_sign.larger(-get(room.change, place));
    }
    for index in 0..conditions.all() {
        excess = excess.larger(conditions.excess(index, x));
    }
    for index in active.all() {
        excess = excess.larger(conditions.excess(index, x).abs());
    }
    Optimality { stationarity, wrong_sign, excess }
}

/// The inequality that is violated most.
fn worst<R: Scalar>(conditions: &Conditions<'_, R>, x: &[R], active: &Active) -> Option<usize> {
    let met = R::constant(MET * R::EPSILON);
    let mut found: Option<(usize, R)> = None;
    for index in conditions.equations..conditions.all() {
        let excess = conditions.excess(index, x);
        let more = excess > found.map_or(R::constant(0.0), |(_, most)| most);
        if more && !active.holds(index) && excess > met * conditions.size_of(index, x) {
            found = Some((index, excess));
        }
    }
    found.map(|(index, _)| index)
}

impl<R: Scalar> Room<'_, R> {
    /// Takes the part along a column of the basis off `step`; how much that was.
    fn take_off(&mut self, k: usize) -> R {
        let size = self.step.len();
        let column = self.basis.get(k * size..(k + 1) * size).unwrap_or(&[]);
        let part = dot(column, self.step);
        self.step.iter_mut().zip(column).for_each(|(step, c)| *step = R::fused(-part, *c, *step));
        part
    }

    /// Takes the parts along the first columns off `step`, and adds them to `along`. All are those of the same `step`, so that a processor need
    /// not wait for one before the next.
    fn take_off_all(&mut self, count: usize) {
        let size = self.step.len();
        let columns = || columns(self.basis, size).take(count);
        for (part, column) in self.change.iter_mut().zip(columns()) {
            *part = dot(column, self.step);
        }
        for (part, column) in self.change.iter().zip(columns()) {
            self.step.iter_mut().zip(column).for_each(|(step, c)| *step = R::fused(-*part, *c, *step));
        }
        self.along.iter_mut().zip(self.change.iter()).take(count).for_each(|(all, part)| *all = *all + *part);
    }

    /// The part of a row that is across all active ones into `step`, its coordinates in the basis into `along`; how much of the row
    /// that is (its square), if it is more than rounding.
    fn direct(&mut self, conditions: &Conditions<'_, R>, index: usize, count: usize) -> Option<R> {
        conditions.write(index, self.step);
        self.along.fill(R::constant(0.0));
        let whole = dot(self.step, self.step);
        self.take_off_all(count);
        let mut reach = dot(self.step, self.step);
        // Where most was taken off, roundings of it are left: twice is enough (Kahan).
        if reach < R::constant(0.5) * whole {
            self.take_off_all(count);
            reach = dot(self.step, self.step);
        }
        let least = R::constant(DEPENDENT * R::EPSILON);
        let independent =
            count < self.step.len() && reach > least * least * whole && reach > R::constant(0.0);
        if !independent {
            self.step.fill(R::constant(0.0));
        }
        independent.then_some(reach)
    }

    /// How multipliers of the active rows change with that of the row in `along`: R⁻¹ `along` into `change`.
    fn solve(&mut self, count: usize) {
        let size = self.step.len();
        for k in (0..count).rev() {
            let mut sum = get(self.along, k);
            for j in k + 1..count {
                sum = R::fused(-get(self.upper, j * size + k), get(self.change, j), sum);
            }
            let value = sum / get(self.upper, k * size + k);
            set(self.change, k, value);
        }
    }

    /// Which active inequality's multiplier is the first to vanish, and after how long a step.
    fn first_to_leave(&self, count: usize, equations: usize) -> Option<(usize, R)> {
        let mut found: Option<(usize, R)> = None;
        for place in equations..count {
            let change = get(self.change, place);
            if change > R::constant(0.0) {
                let at = get(self.multipliers, place).larger(R::constant(0.0)) / change;
                if found.is_none_or(|(_, least)| at < least) {
                    found = Some((place, at));
                }
            }
        }
        found
    }

    /// The row of the last [`Room::direct`] becomes the `count`-th active one.
    fn enter(&mut self, count: usize) {
        let size = self.step.len();
        let length = dot(self.step, self.step).sqrt();
        for k in 0..count {
            set(self.upper, count * size + k, get(self.along, k));
        }
        set(self.upper, count * size + count, length);
        for i in 0..size {
            set(self.basis, count * size + i, get(self.step, i) / length);
        }
        set(self.multipliers, count, R::constant(0.0));
    }

    /// An active row leaves; those behind it enter again.
    fn leave(&mut self, conditions: &Conditions<'_, R>, active: &mut Active, place: usize) {
        active.remove(place);
        for k in place..active.count {
            let next = get(self.multipliers, k + 1);
            let index = active.indices.get(k).map_or(0, |&index| usize::from(index));
            // Independent before, so still.
            self.direct(conditions, index, k);
            self.enter(k);
            set(self.multipliers, k, next);
        }
    }
}

/// The nearest point where inequalities, all of them rows, are met and equations as well as they can be: the least of |x − x₀|² + w |A x − b|², w the `weight`. Rows are
/// unit vectors; inequalities are changed: afterwards they are those whose nearest point to 0 is `point`. `factor` has size² numbers, `centre`
/// and `point` size.
pub(crate) fn nearest_compromise<R: Scalar>(
    conditions: Conditions<'_, R>,
    x: &mut [R],
    weight: f64,
    (factor, centre, point): (&mut [R], &mut [R], &mut [R]),
    room: &mut Room<'_, R>,
    active: &mut Active,
) -> Search {
    let Conditions { rows, bounds, size, equations, count, .. } = conditions;
    let weight = R::constant(weight);
    let (one, zero) = (R::constant(1.0), R::constant(0.0));
    let Some((equal, rows)) = rows.split_at_mut_checked(equations * size) else { return Search::Impossible };
    let Some((goals, bounds)) = bounds.split_at_mut_checked(equations) else { return Search::Impossible };
    // H = 1 + w AᵀA, and what pulls away from x₀.
    factor.fill(zero);
    for k in 0..size {
        set(factor, k * size + k, one);
    }
    point.fill(zero);
    for (index, goal) in goals.iter().enumerate() {
        let row = equal.get(index * size..(index + 1) * size).unwrap_or(&[]);
        let miss = *goal - dot(row, x);
        for (k, a) in row.iter().enumerate() {
            set(point, k, R::fused(weight * *a, miss, get(point, k)));
            for (j, b) in row.iter().enumerate() {
                set(factor, j * size + k, R::fused(weight * *a, *b, get(factor, j * size + k)));
            }
        }
    }
    if !decompose(factor, size) {
        return Search::Impossible;
    }
    forward(factor, point);
    backward(factor, point);
    centre.iter_mut().zip(x.iter().zip(point.iter())).for_each(|(c, (x, change))| *c = *x + *change);
    for (index, bound) in bounds.iter_mut().enumerate().take(count.saturating_sub(equations)) {
        let row = rows.get_mut(index * size..(index + 1) * size).unwrap_or(&mut []);
        *bound = *bound - dot(row, centre);
        forward(factor, row);
    }
    let count = count.saturating_sub(equations);
    let mut changed = Conditions { rows, bounds, size, equations: 0, count, limits: &[] };
    changed.normalise();
    point.fill(zero);
    let found = nearest(&changed, point, room, active);
    copy(point, x);
    backward(factor, x);
    x.iter_mut().zip(centre.iter()).for_each(|(x, c)| *x = *c + *x);
    found
}

/// L of a symmetric positive definite matrix, in its lower triangle, column after column; `false`: it is none.
fn decompose<R: Scalar>(a: &mut [R], size: usize) -> bool {
    for k in 0..size {
        let mut pivot = get(a, k * size + k);
        for j in 0..k {
            let x = get(a, j * size + k);
            pivot = R::fused(-x, x, pivot);
        }
        let root = pivot.sqrt();
        if !(root > R::constant(0.0) && root.is_finite()) {
            return false;
        }
        set(a, k * size + k, root);
        for i in k + 1..size {
            let mut sum = get(a, k * size + i);
            for j in 0..k {
                sum = R::fused(-get(a, j * size + i), get(a, j * size + k), sum);
            }
            set(a, k * size + i, sum / root);
        }
    }
    true
}

/// L⁻¹ b into b.
fn forward<R: Scalar>(factor: &[R], b: &mut [R]) {
    let size = b.len();
    for k in 0..size {
        let mut sum = get(b, k);
        for j in 0..k {
            sum = R::fused(-get(factor, j * size + k), get(b, j), sum);
        }
        set(b, k, sum / get(factor, k * size + k));
    }
}

/// L⁻ᵀ b into b.
fn backward<R: Scalar>(factor: &[R], b: &mut [R]) {
    let size = b.len();
    for k in (0..size).rev() {
        let mut sum = get(b, k);
        for j in k + 1..size {
            sum = R::fused(-get(factor, k * size + j), get(b, j), sum);
        }
        set(b, k, sum / get(factor, k * size + k));
    }
}
