//! Which foot stands, until when, where the other one goes: footsteps from a commanded velocity, timing, and the motion of zero moment point and
//! divergent component that belongs to them.
use super::divergent::{Piece, Point};
use super::space::{Pose, Vector, about_z, add, angle, angle_near_zero, turned};
use crate::real::Scalar;

/// Steps that are looked ahead.
const AHEAD: usize = 3;

/// Where a foot stands or goes to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Foothold<R> {
    /// Middle of the sole, m.
    pub place: Vector<R>,
    /// rad
    pub yaw: R,
}

impl<R: Scalar> Foothold<R> {
    /// On the ground.
    pub fn point(&self) -> Point<R> {
        let [x, y, _] = self.place;
        [x, y]
    }

    /// Where a sole is; `near`: an angle within a quarter turn of its yaw.
    pub fn of(sole: &Pose<R>, near: R) -> Self {
        let [[c, ..], [s, ..], _] = sole.turn;
        let (sine, cosine) = crate::math::sin_cos(near);
        let rest = angle_near_zero(c * cosine + s * sine, s * cosine - c * sine);
        Self { place: sole.position, yaw: near + rest }
    }

    /// Where a robot's soles are, right and left; their yaws are less than a quarter turn apart.
    pub fn both(right: &Pose<R>, left: &Pose<R>) -> [Self; 2] {
        let [[c, ..], [s, ..], _] = right.turn;
        let yaw = angle(c, s);
        [Self { place: right.position, yaw }, Self::of(left, yaw)]
    }

    /// Forward and left of it, turned.
    fn beyond(&self, way: Point<R>, turn: R) -> Self {
        let [x, y] = way;
        let moved = turned(about_z(self.yaw), [x, y, R::constant(0.0)]);
        Self { place: add(self.place, moved), yaw: self.yaw + turn }
    }
}

/// How fast the robot shall walk.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Velocity<R> {
    /// m/s
    pub forward: R,
    /// m/s
    pub left: R,
    /// Counterclockwise, rad/s.
    pub turning: R,
}

impl<R: Scalar> Velocity<R> {
    /// Standing.
    pub fn zero() -> Self {
        let zero = R::constant(0.0);
        Self { forward: zero, left: zero, turning: zero }
    }

    /// Whether it is none.
    pub fn is_zero(&self) -> bool {
        *self == Self::zero()
    }

    /// Neither infinite nor NaN.
    pub fn is_finite(&self) -> bool {
        self.forward.is_finite() && self.left.is_finite() && self.turning.is_finite()
    }

    /// Goes toward another one by at most `most` m/s and rad/s each.
    fn toward(self, goal: Self, most: R) -> Self {
        let go = |from: R, to: R| from + -(-(to - from).larger(-most)).larger(-most);
        Self {
            forward: go(self.forward, goal.forward),
            left: go(self.left, goal.left),
            turning: go(self.turning, goal.turning),
        }
    }
}

/// What the robot's legs do.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Phase {
    /// Both feet stand, and stay.
    Stand,
    /// Both feet stand; the weight goes to [`Steps::stands`].
    Shift,
    /// Both feet stand; the weight goes to the middle.
    Halt,
    /// [`Steps::stands`] stands, the other one swings.
    Swing,
}

/// Times and sizes of steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stride<R> {
    /// Of a slow step, s.
    pub time: R,
    /// Of the fastest step, s.
    pub shortest: R,
    /// Steps that would be longer than this (m) are made faster instead.
    pub easy: R,
    /// Part of it in which both feet stand.
    pub double_support: R,
    /// Distance of the feet, m.
    pub width: R,
    /// Farthest that a foot goes beyond the other one forward, back; m.
    pub longest: R,
    /// Nearest and farthest that feet are to the side, m.
    pub across: [R; 2],
    /// Largest turn of a step, rad.
    pub largest_turn: R,
    /// By how much the velocity changes from step to step, m/s and rad/s.
    pub change: R,
    /// What a changed duration costs against a changed place, both as parts of duration and width, squared.
    pub punctual: R,
    /// What is missing of the divergent component at the end of a step costs, as a part of the width.
    pub strict: R,
    /// Time within which a foot in the air can come down, s.
    pub soonest: R,
    /// Longest time that both feet stand on until the next step can end well, s.
    pub patience: R,
    /// How fast a foot in the air goes to another place, m/s.
    pub speed: R,
    /// How fast its goal may move, per time squared that is left until it comes down, m/s³: what moves late takes large accelerations.
    pub agility: R,
    /// √(g/z), 1/s
    pub omega: R,
}

/// The state of the steps.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Steps<R> {
    /// What the legs do.
    pub phase: Phase,
    /// The foot that stands alone in, or after, this phase: 0 right, 1 left.
    pub stands: usize,
    /// Since the phase began, s.
    pub time: R,
    /// Of the phase, s.
    pub duration: R,
    /// Of the phase if nothing disturbs, s.
    pub usual: R,
    /// Where the feet stand; that of the swinging one where it left the ground.
    pub feet: [Foothold<R>; 2],
    /// Where the swinging foot goes if nothing disturbs.
    pub nominal: Foothold<R>,
    /// Where it goes.
    pub goal: Foothold<R>,
    /// As the steps have it.
    pub velocity: Velocity<R>,
    /// Of a step, s.
    pub pace: R,
    /// By how much steps are planned longer than wished, because they end shorter, m.
    pub longer: R,
    /// Where the zero moment point was wished when the phase began.
    from: Point<R>,
}

/// Left of right, right of left.
fn other(foot: usize) -> usize {
    1 - foot.min(1)
}

/// Between two bounds.
pub fn clamp<R: Scalar>(x: R, low: R, high: R) -> R {
    -(-x.larger(low)).larger(-high)
}

impl<R: Scalar> Steps<R> {
    /// Standing on both feet.
    pub fn standing(feet: [Foothold<R>; 2]) -> Self {
        let [goal, _] = feet;
        let zero = R::constant(0.0);
        let mut steps = Self {
            phase: Phase::Stand,
            stands: 0,
            time: zero,
            duration: zero,
            usual: zero,
            feet,
            nominal: goal,
            goal,
            velocity: Velocity::zero(),
            pace: R::constant(0.5),
            longer: zero,
            from: [zero; 2],
        };
        steps.from = steps.middle();
        steps
    }

    /// A foot: 0 right, 1 left.
    pub fn foot(&self, foot: usize) -> Foothold<R> {
        let [right, left] = self.feet;
        if foot == 0 { right } else { left }
    }

    /// The one that does not stand alone in, or after, this phase.
    pub fn swings(&self) -> usize {
        other(self.stands)
    }

    /// Between the feet.
    pub fn middle(&self) -> Point<R> {
        let ([a, b], [c, d]) = (self.foot(0).point(), self.foot(1).point());
        let half = R::constant(0.5);
        [half * (a + c), half * (b + d)]
    }

    /// Whether a foot stands in this phase.
    pub fn is_standing(&self, foot: usize) -> bool {
        self.phase != Phase::Swing || foot == self.stands
    }

    /// s, until the phase ends by its time; not below 0.
    pub fn left(&self) -> R {
        (self.duration - self.time).larger(R::constant(0.0))
    }

    /// Where the foot goes that swings while `stands` stands (0 right, 1 left), at a velocity.
    fn next(
        &self,
        stride: &Stride<R>,
        stands: usize,
        from: &Foothold<R>,
        velocity: &Velocity<R>,
    ) -> Foothold<R> {
        let (zero, half, two) = (R::constant(0.0), R::constant(0.5), R::constant(2.0));
        // The other foot is to the left of the right one.
        let side = R::constant(if stands == 0 { 1.0 } else { -1.0 });
        // To the side one foot leads and the other one joins.
        let aside = two * velocity.left * self.pace;
        let aside = if aside * side > zero { aside } else { zero };
        let turn = clamp(velocity.turning * self.pace, -stride.largest_turn, stride.largest_turn);
        let forward = velocity.forward * self.pace + if velocity.is_zero() { zero } else { self.longer };
        let forward = clamp(forward, -stride.longest, stride.longest);
        let [nearest, farthest] = stride.across;
        let across = clamp(stride.width + side * aside, nearest, farthest) - stride.width;
        let center = from.beyond([forward, side * half * stride.width], turn);
        center.beyond([zero, side * (half * stride.width + across)], zero)
    }

    /// s, of a phase with both feet.
    fn shift_time(&self, stride: &Stride<R>) -> R {
        stride.double_support * self.pace
    }

    /// s, of a phase with one foot.
    fn swing_time(&self, stride: &Stride<R>) -> R {
        self.pace - self.shift_time(stride)
    }

    /// Fast steps are short in time, so that they are not long.
    fn choose_pace(&mut self, stride: &Stride<R>) {
        let speed = self.velocity.forward.abs();
        let wished = if speed * stride.time > stride.easy { stride.easy / speed } else { stride.time };
        self.pace = clamp(wished, stride.shortest, stride.time);
    }

    fn begin(&mut self, phase: Phase, duration: R, from: Point<R>) {
        (self.phase, self.duration, self.usual, self.from) = (phase, duration, duration, from);
        self.time = R::constant(0.0);
    }

    /// From standing: the weight goes to a foot.
    pub fn start(&mut self, stride: &Stride<R>, stands: usize, duration: R) {
        self.choose_pace(stride);
        let from = self.reference_zmp();
        self.stands = stands;
        self.begin(Phase::Shift, duration, from);
    }

    /// The other foot leaves the ground.
    pub fn lift(&mut self, stride: &Stride<R>, asked: &Velocity<R>) {
        self.velocity = self.velocity.toward(*asked, stride.change);
        self.choose_pace(stride);
        self.nominal = self.next(stride, self.stands, &self.foot(self.stands), &self.velocity);
        self.goal = self.nominal;
        let from = self.foot(self.stands).point();
        self.begin(Phase::Swing, self.swing_time(stride), from);
    }

    /// The swinging foot has come down at a place.
    pub fn land(&mut self, stride: &Stride<R>, at: Foothold<R>, asked: &Velocity<R>) {
        let (old, swinging) = (self.foot(self.stands), other(self.stands));
        self.lengthen(stride, &at);
        if let Some(foot) = self.feet.get_mut(swinging) {
            *foot = at;
        }
        let rests = asked.is_zero() && self.velocity.is_zero() && self.is_side_by_side(stride);
        self.stands = swinging;
        let shift = self.shift_time(stride);
        match rests {
            true => self.begin(Phase::Halt, shift + shift, old.point()),
            false => self.begin(Phase::Shift, shift, old.point()),
        }
    }

    /// Steps that end shorter than wished are planned longer: what the limbs' own motion takes from the robot's is not known beforehand.
    fn lengthen(&mut self, stride: &Stride<R>, at: &Foothold<R>) {
        let ([x, y, _], [a, b, _]) = (self.foot(self.stands).place, at.place);
        let (s, c) = crate::math::sin_cos(self.foot(self.stands).yaw);
        let reached = (a - x) * c + (b - y) * s;
        let missing = self.velocity.forward * self.pace - reached;
        let most = R::constant(0.3) * stride.easy;
        let longer = self.longer + R::constant(0.2) * missing;
        self.longer = if self.velocity.is_zero() { R::constant(0.0) } else { clamp(longer, -most, most) };
    }

    /// Nothing more to do.
    pub fn rest(&mut self) {
        let middle = self.middle();
        self.begin(Phase::Stand, R::constant(0.0), middle);
    }

    fn is_side_by_side(&self, stride: &Stride<R>) -> bool {
        let wished = self.next(stride, 0, &self.foot(0), &Velocity::zero());
        let ([x, y], [a, b]) = (wished.point(), self.foot(1).point());
        let near = R::constant(0.15) * stride.width;
        (x - a).abs() < near && (y - b).abs() < near
    }

    /// What the zero moment point does in the rest of the phase.
    fn present(&self) -> Piece<R> {
        let to = match self.phase {
            Phase::Stand | Phase::Halt => self.middle(),
            Phase::Shift | Phase::Swing => self.foot(self.stands).point(),
        };
        Piece { from: self.from, to, duration: self.duration }.rest(self.time)
    }

    /// Where the zero moment point is wished.
    pub fn reference_zmp(&self) -> Point<R> {
        match self.phase {
            Phase::Stand => self.middle(),
            _ => self.present().from,
        }
    }

    /// Where the divergent component is wished at the end of this phase, if the swinging foot goes to `goal`.
    pub fn divergent_at_end(&self, stride: &Stride<R>, goal: &Foothold<R>) -> Point<R> {
        if matches!(self.phase, Phase::Stand | Phase::Halt) {
            return self.middle();
        }
        // Footholds from here on: the one that stands, then those that are stepped on.
        let first = self.foot(self.stands);
        let mut holds = [first; AHEAD + 2];
        let (mut stands, mut last) = (self.stands, first);
        for (k, hold) in holds.iter_mut().enumerate().skip(1) {
            *hold = match (k, self.phase) {
                (1, Phase::Swing) => *goal,
                _ => self.next(stride, stands, &last, &self.velocity),
            };
            (stands, last) = (other(stands), *hold);
        }
        let half = R::constant(0.5);
        let pair = |a: &Foothold<R>, b: &Foothold<R>| {
            let ([a, b], [c, d]) = (a.point(), b.point());
            [half * (a + c), half * (b + d)]
        };
        let mut end = first.point();
        for (k, hold) in holds.windows(2).enumerate().rev() {
            let [a, b] = hold else { continue };
            if k == AHEAD {
                end = pair(a, b);
                continue;
            }
            // On a alone, then over to b, then on.
            end = Piece { from: b.point(), to: b.point(), duration: self.swing_time(stride) }
                .before(stride.omega, end);
            end = Piece { from: a.point(), to: b.point(), duration: self.shift_time(stride) }
                .before(stride.omega, end);
        }
        if self.phase == Phase::Shift {
            // Before all that it stands alone.
            let alone = Piece { from: first.point(), to: first.point(), duration: self.swing_time(stride) };
            end = alone.before(stride.omega, end);
        }
        end
    }

    /// Where the divergent component is wished now, if it is there at the end.
    pub fn divergent_now(&self, stride: &Stride<R>, end: Point<R>) -> Point<R> {
        match self.phase {
            Phase::Stand => self.middle(),
            _ => self.present().before(stride.omega, end),
        }
    }
}
