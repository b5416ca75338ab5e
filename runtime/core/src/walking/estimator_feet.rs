//! What an estimator learns from feet: where the legs see the soles, anchors of those that stand, level ground.
use super::error_state::{ATTITUDE, FEET, POSITION, Row};
use super::estimator::Estimator;
use super::readings::Believed;
use super::sensed::{Fault, LegKinematics, MOST_JOINTS};
use super::space::{
    Turn, Vector, add, along, cross, cross_matrix, dot, identity, of_quaternion, product, scale, subtract,
    transpose, turn_between, turned,
};
use crate::control::slices::set;
use crate::real::Scalar;

/// So many refused samples of a foot in a row: it slipped.
const SLIPPED: u16 = 10;
/// A foot that touched down comes to rest, s.
const SETTLING: f64 = 0.05;
/// Errors of kinematics and of the ground last about so long, s: samples within that time say the same.
const LASTING: [f64; 2] = [0.01, 0.5];

/// Twists of a sole are filtered over this time (s), and seen from so many standard deviations on.
const TWIST: (f64, f64) = (0.01, 6.0);
/// A sole tips that turns so many times as fast as soles that stand seem to (root of the mean square over so long, s).
const TIPPING: f64 = 2.5;
const RATTLING: f64 = 0.3;
/// Least and most that soles that stand seem to turn, rad/s.
const RATTLE: [f64; 2] = [1e-4, 1.0];
/// It turns about something so far from its middle (m), by no more than this in a sample (rad).
const PIVOT: f64 = 0.05;
const MOST_TURNED: f64 = 0.1;
/// A sole that is off the plane by more standard deviations lies on something else than the plane; for so long (s) at most.
const ASKEW: (f64, f64) = (5.0, 1.0);

/// A foot.
#[derive(Debug, Clone, Copy)]
pub(super) struct Anchor<R> {
    pub(super) standing: bool,
    pub(super) position: Vector<R>,
    pub(super) turn: Turn<R>,
    /// Since it stands, s.
    pub(super) age: R,
    pub(super) refused: u16,
    /// How far the leg sees it turned about the vertical from where it is held to be, filtered, rad.
    pub(super) twist: R,
}

/// A sole from the unit, in axes of the base, and how well it is known.
pub(super) struct Seen<R> {
    pub(super) arm: Vector<R>,
    pub(super) turn: Turn<R>,
    pub(super) variance: [R; 6],
    /// How it turns in the world, axes of the base, rad/s; none without a gyroscope.
    pub(super) rate: Option<Vector<R>>,
}

impl<R: Scalar> Estimator<R> {
    /// Both soles, seen from the unit, in axes of the base; of a leg that is believed. `angular_velocity`: of the gyroscope, if it is.
    pub(super) fn look(
        &self,
        legs: &impl LegKinematics<R>,
        angular_velocity: Option<Vector<R>>,
        fault: &mut Option<Fault>,
    ) -> [Option<Seen<R>>; 2] {
        [0, 1].map(|foot| {
            let mut jacobian = [[R::constant(0.0); 6]; MOST_JOINTS];
            let (jacobian, positions) =
                (jacobian.get_mut(..self.joints)?, self.readings.positions.get(..self.joints)?);
            let pose = legs.sole(foot, positions, jacobian)?;
            let acts = |column: &[R; 6]| column.iter().any(|x| *x != R::constant(0.0));
            let wrong = jacobian.iter().zip(self.readings.wrong).any(|(column, wrong)| wrong && acts(column));
            let mut variance = [R::constant(0.0); 6];
            for column in jacobian.iter() {
                variance.iter_mut().zip(column).for_each(|(sum, x)| *sum = R::fused(*x, *x, *sum));
            }
            let numbers = pose.position.iter().chain(pose.turn.iter().flatten()).chain(&variance);
            if !numbers.into_iter().all(|x| x.is_finite()) {
                fault.get_or_insert(Fault::Kinematics(foot));
                return None;
            }
            let encoder = self.settings.encoder * self.settings.encoder;
            let [place, tilt, turn] = self.settings.leg.map(|x| x * x);
            for (sum, own) in variance.iter_mut().zip([place, place, place, tilt, tilt, turn]) {
                *sum = R::fused(*sum, encoder, own);
            }
            let arm = subtract(pose.position, self.settings.unit);
            let turning = |base: Vector<R>| {
                let joints = jacobian.iter().zip(self.readings.velocities);
                joints.fold(subtract(base, self.gyroscope), |sum, ([.., x, y, z], velocity)| {
                    along(sum, velocity, [*x, *y, *z])
                })
            };
            let rate = angular_velocity.map(turning);
            (!wrong).then_some(Seen { arm, turn: pose.turn, variance, rate })
        })
    }

    /// What the feet say; how much each of them counts.
    pub(super) fn stand(
        &mut self,
        believed: &Believed<R>,
        soles: &[Option<Seen<R>>; 2],
        step: Option<R>,
        fault: &mut Option<Fault>,
    ) -> [R; 2] {
        let (one, zero) = (R::constant(1.0), R::constant(0.0));
        let step = step.unwrap_or(R::constant(1e-3));
        let [lifted, touching, full] = self.settings.loads;
        let mut trust = [zero; 2];
        let loads = self.loads(believed);
        let all = soles.iter().zip(loads).zip(FEET).zip(trust.iter_mut());
        for (foot, (((sole, load), first), trust)) in all.enumerate() {
            let Some(mut anchor) = self.feet.get(foot).copied() else { continue };
            let stood = anchor.standing;
            anchor.standing = load >= if stood { lifted } else { touching };
            let Some(sole) = sole.as_ref().filter(|_| anchor.standing) else {
                // A leg that is not believed for a sample: its foot stands on.
                anchor.standing = anchor.standing && stood;
                set(&mut self.feet, foot, anchor);
                continue;
            };
            let part = load / full;
            *trust = if part > one { one } else { part.larger(R::constant(0.05)) };
            if !stood {
                anchor.age = zero;
            }
            if !stood || anchor.refused >= SLIPPED {
                if stood {
                    fault.get_or_insert(Fault::Slip(foot));
                    *trust = zero;
                }
                self.anchor(&mut anchor, sole, first);
            } else {
                self.hold(&mut anchor, sole, first, (*trust, step));
            }
            anchor.age = anchor.age + step;
            set(&mut self.feet, foot, anchor);
        }
        trust
    }

    /// The load of each foot; where one is not measured, what the other one leaves, or as before.
    fn loads(&self, believed: &Believed<R>) -> [R; 2] {
        let [_, _, full] = self.settings.loads;
        let zero = R::constant(0.0);
        let [right, left] = self.feet.map(|foot| if foot.standing { full } else { zero });
        let rest = |other: R| (full + full - other).larger(zero);
        match believed.load {
            [Some(right), Some(left)] => [right, left],
            [Some(right), None] => [right, rest(right)],
            [None, Some(left)] => [rest(left), left],
            [None, None] => [right, left],
        }
    }

    /// A foot is where the leg says that it is.
    fn anchor(&mut self, anchor: &mut Anchor<R>, sole: &Seen<R>, first: usize) {
        let turn = of_quaternion(self.quaternion);
        let arm = turned(turn, sole.arm);
        anchor.position = add(self.position, arm);
        anchor.turn = product(turn, sole.turn);
        anchor.refused = 0;
        anchor.twist = R::constant(0.0);
        let one = identity();
        self.errors.mix(
            first,
            false,
            &[(POSITION, one), (ATTITUDE, cross_matrix(scale(-R::constant(1.0), arm)))],
        );
        self.errors.mix(first + 3, false, &[(ATTITUDE, one)]);
        let [a, b, c, d, e, f] = sole.variance;
        self.errors.grow(first, [a.larger(b).larger(c); 3]);
        let tilt = d.larger(e);
        self.errors.grow(first + 3, [tilt, tilt, f]);
    }

    /// A foot stays where it is; on level ground, flat.
    fn hold(&mut self, anchor: &mut Anchor<R>, sole: &Seen<R>, first: usize, (trust, step): (R, R)) {
        let (one, zero) = (R::constant(1.0), R::constant(0.0));
        let young = anchor.age < R::constant(SETTLING);
        let loose = if young { R::constant(100.0) } else { one } / (trust * trust);
        let [place, tilting, turning] = self.settings.foot.map(|x| x * x * step * loose);
        self.errors.grow(first, [place; 3]);
        self.errors.grow(first + 3, [tilting, tilting, turning]);
        let turn = of_quaternion(self.quaternion);
        let distance = subtract(anchor.position, self.position);
        let miss = subtract(turned(turn, sole.arm), distance);
        let twist = turn_between(anchor.turn, product(turn, sole.turn));
        self.tipping(sole, first, step);
        self.turning(anchor, sole, first, (twist, step));
        let lever = cross_matrix(distance);
        let lasting = (R::constant(LASTING[0]) / (step * trust)).larger(one);
        let [a, b, c, d, e, f] = sole.variance;
        let (of_place, tilt) = (a.larger(b).larger(c) * lasting, d.larger(e) * lasting);
        // What else is wrong with a leg hardly turns it about the vertical: samples are independent.
        let of_angle = [tilt, tilt, f / trust];
        let mut farthest = zero;
        let all = miss.into_iter().zip(twist).zip(of_angle).zip(lever).enumerate();
        for (k, (((miss, twist), of_angle), [x, y, z])) in all {
            let of_attitude = [(ATTITUDE, x), (ATTITUDE + 1, y), (ATTITUDE + 2, z)];
            let [a, b, c] = of_attitude;
            let row: Row<R> = [(first + k, one), (POSITION + k, -one), a, b, c, (0, zero)];
            farthest = farthest.larger(self.errors.measure(&row, miss, of_place));
            let row: Row<R> =
                [(first + 3 + k, one), (ATTITUDE + k, -one), (0, zero), (0, zero), (0, zero), (0, zero)];
            farthest = farthest.larger(self.errors.measure(&row, twist, of_angle));
        }
        let refused = farthest > R::constant(10.0);
        anchor.refused = if refused { anchor.refused.saturating_add(1) } else { 0 };
        if !young && !refused {
            self.level(anchor, first, (trust, step));
        }
    }

    /// A sole that tips from edge to edge, or is turned, does so within some milliseconds; joints and gyroscope see it turn. Then its place and attitude are
    /// known so much worse, and the unit's sensors hold the base.
    fn tipping(&mut self, sole: &Seen<R>, first: usize, step: R) {
        let Some(rate) = sole.rate else { return };
        let at_most = |most: R, x: R| if x < most { x } else { most };
        let square = dot(rate, rate);
        if square > R::constant(TIPPING * TIPPING) * self.rattle {
            let turned = at_most(R::constant(MOST_TURNED * MOST_TURNED), square * step * step);
            self.errors.grow(first + 3, [turned; 3]);
            self.errors.grow(first, [R::constant(PIVOT * PIVOT) * turned; 3]);
        }
        let usual = at_most(R::constant(9.0) * self.rattle, square);
        let part = step / (step + R::constant(RATTLING));
        let rattle = R::fused(part, usual - self.rattle, self.rattle);
        let [least, most] = RATTLE.map(|x| R::constant(x * x));
        self.rattle = at_most(most, rattle.larger(least));
    }

    /// A sole that turns slower: a twist, filtered, of more than the noise of the encoders is the foot's, and not believed of the base.
    /// Over so short a time the gyroscope knows the heading better than a sole stays.
    fn turning(
        &mut self,
        anchor: &mut Anchor<R>,
        sole: &Seen<R>,
        first: usize,
        (twist, step): (Vector<R>, R),
    ) {
        let ([_, _, now], [.., read]) = (twist, sole.variance);
        let [_, _, leg] = self.settings.leg;
        let part = step / (step + R::constant(TWIST.0));
        anchor.twist = R::fused(part, now - anchor.twist, anchor.twist);
        let square = anchor.twist * anchor.twist;
        // White noise of readings, filtered.
        let noise = (read - leg * leg) * part * R::constant(0.5);
        if square > R::constant(TWIST.1 * TWIST.1) * noise {
            let zero = R::constant(0.0);
            self.errors.grow(first + 3, [zero, zero, square]);
        }
    }

    /// Level ground.
    fn level(&mut self, anchor: &Anchor<R>, first: usize, (trust, step): (R, R)) {
        let (one, zero) = (R::constant(1.0), R::constant(0.0));
        let lasting = R::constant(LASTING[1]) / (step * trust);
        let [height, tilt] = self.settings.ground.map(|x| x * x * lasting);
        let none = (0, zero);
        let single = |index: usize| -> Row<R> { [(index, one), none, none, none, none, none] };
        if height.is_finite() {
            let [_, _, z] = anchor.position;
            self.errors.measure(&single(first + 2), -z, height);
        }
        if tilt.is_finite() {
            let [_, _, up] = transpose(anchor.turn);
            let [x, y, _] = cross(up, [zero, zero, one]);
            let [_, flat] = self.settings.ground;
            let known = flat * flat + self.errors.variance(first + 3).larger(self.errors.variance(first + 4));
            let off = x * x + y * y > R::constant(ASKEW.0 * ASKEW.0) * known;
            self.askew = if off { self.askew + step } else { zero };
            // Where no sole lies flat for long it is the estimate that does not.
            if off && self.askew < R::constant(ASKEW.1) {
                return;
            }
            self.errors.measure(&single(first + 3), x, tilt);
            self.errors.measure(&single(first + 4), y, tilt);
        }
    }
}
