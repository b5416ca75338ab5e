//! How the ground's force is shared between two feet that stand (thesis 6.57–6.60, corrected), within the limits of ground and drives.
//!
//! While both feet stand, six more forces act than the motion determines. The thesis fixes them by an expression of its own (6.59), which
//! asks feet to pull where the zero moment point is not between certain points, and takes the least torques (6.60). Here they are a quadratic
//! program: of all wrenches that give the motion and that the ground can give, those nearest to a planned distribution. A foot whose share
//! of the load goes to nothing is let go without a jump, as (6.58) asks for.
//!
//! The planned distribution: each foot carries its share of the required force, with its centre of pressure in the middle of its sole and no moment
//! about its normal. Nearest: the least Σ_k |(w_k − planned_k) / scale|² / share_k over the feet's wrenches in axes of their soles; the scales are
//! W, the magnitude of the required force, of forces, and W times half the sole's width, length and length of the moments about x, y and z. So a centre of
//! pressure costs what part of the way to the edge it is. The nearest point depends on nothing but the arguments: no search begins where
//! another one ended.
use super::ground_program::{Outcome, Program, Work};
use super::space::{Pose, Vector, add, along, cross, subtract, turned};
use crate::control::slices::{get, set};
use crate::real::Scalar;

/// Most joints that the wrench of a foot acts on.
pub const MOST_LEG_JOINTS: usize = 16;

/// A foot that stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StandingFoot<'a, R> {
    /// Where its wrench is taken about (the middle of the sole), and the axes of the sole: x forward, y left, z up.
    pub sole: Pose<R>,
    /// Rear, front, right and left edge of the sole in its axes, m: rear < 0 < front, right < 0 < left.
    pub extent: [R; 4],
    /// Which entries of the torques its wrench acts on, at most [`MOST_LEG_JOINTS`].
    pub joints: &'a [usize],
    /// Of each of these joints: linear (m/s), then angular (rad/s) velocity of the sole's origin per rate of the joint, world axes.
    pub jacobian: &'a [[R; 6]],
    /// Wished part of the load, 0 to 1; only the proportion of both counts. A foot below 1e-6 is not there: its wrench is 0.
    pub share: R,
}

/// What ground and drives can give.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits<'a, R> {
    /// Largest force along an axis in the sole's plane per normal force (a pyramid); infinite: none is asked for.
    pub friction: R,
    /// Largest moment about the sole's normal per normal force, m; infinite: none is asked for.
    pub turning: R,
    /// Least normal force of a foot, N, as far as its share of the load reaches: less for a foot that is let go.
    pub least_load: R,
    /// Largest torque by joint, N m; infinite, or beyond the end: none.
    pub torque: &'a [R],
}

/// What became of a required wrench. Missing is the required wrench less that of both feet: force (N), moment about the world's origin (N m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shared<R> {
    /// The feet give it, within all limits.
    Met,
    /// No wrenches within the limits give it. These are within them and as near as can be: the least of the distance to the planned distribution
    /// (scaled as above) + 10⁴ |missing / scale|², moments about the point between the feet in W times half the longer sole.
    GroundGaveWay {
        /// N, N m
        missing: [R; 6],
    },
    /// The limits of drives cannot be kept by any wrench of the ground. Wrenches are those without regard to drives, torques are clamped: they ask
    /// for another motion.
    Clamped {
        /// N, N m
        missing: [R; 6],
    },
    /// An argument is not finite, has the wrong length or makes no sense (a negative friction, no foot, a sole without extent). Wrenches are 0,
    /// torques those on entry within their limits, 0 where they are not finite.
    Refused,
}

/// How far the conditions of Karush, Kuhn and Tucker hold at what was found, forces in units of W: 0 but for roundings, infinite
/// where nothing was found. A result that is not certified is not used.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Certificate<R> {
    /// Length of what is left of the gradient.
    pub stationarity: R,
    /// The most negative multiplier of a limit, without its sign.
    pub wrong_sign: R,
    /// How far the farthest limit is violated, or an active one not met with equality.
    pub excess: R,
}

impl<R: Scalar> Certificate<R> {
    pub(super) fn exact() -> Self {
        let zero = R::constant(0.0);
        Self { stationarity: zero, wrong_sign: zero, excess: zero }
    }

    /// Nothing is known.
    pub(super) fn none() -> Self {
        let infinite = R::constant(f64::INFINITY);
        Self { stationarity: infinite, wrong_sign: infinite, excess: infinite }
    }

    /// Roundings, and nothing else.
    pub(super) fn holds(&self) -> bool {
        self.holds_within(R::constant(64.0) * R::constant(R::EPSILON).sqrt())
    }

    /// Whether none of them is more than this.
    pub fn holds_within(&self, most: R) -> bool {
        self.stationarity <= most && self.wrong_sign <= most && self.excess <= most
    }
}

/// Shares a wrench between the feet that stand, one or two.
///
/// `required`: force (N) and moment about the world's origin (N m) that both feet give together, world axes. `torques`: on entry those without
/// forces of the ground (D q̈ + H; N m); on exit those with them, less Jᵀ w, always finite and within the limits. `wrenches`: of each foot, about
/// the origin of its sole, world axes.
pub fn share<R: Scalar>(
    feet: &[StandingFoot<'_, R>],
    required: [R; 6],
    limits: &Limits<'_, R>,
    torques: &mut [R],
    wrenches: &mut [[R; 6]; 2],
) -> Shared<R> {
    share_certified(feet, required, limits, torques, wrenches).0
}

/// [`share`], and how well the result is known to be the best.
pub fn share_certified<R: Scalar>(
    feet: &[StandingFoot<'_, R>],
    required: [R; 6],
    limits: &Limits<'_, R>,
    torques: &mut [R],
    wrenches: &mut [[R; 6]; 2],
) -> (Shared<R>, Certificate<R>) {
    *wrenches = [[R::constant(0.0); 6]; 2];
    let usable = limits.make_sense() && required.iter().chain(torques.iter()).all(|x| x.is_finite());
    let program = if usable { Program::of(feet, required, limits, torques.len()) } else { None };
    let Some(program) = program else {
        limits.clamp(torques);
        return (Shared::Refused, Certificate::none());
    };
    let mut work = None;
    let (outcome, certificate) = match program.determined(torques, wrenches) {
        true => (Outcome::Met, Certificate::exact()),
        false => program.search(torques, work.insert(Work::new()), wrenches),
    };
    for (foot, wrench) in feet.iter().zip(wrenches.iter()) {
        for (joint, column) in foot.joints.iter().zip(foot.jacobian) {
            let torque =
                column.iter().zip(wrench).fold(get(torques, *joint), |sum, (j, w)| R::fused(-*j, *w, sum));
            set(torques, *joint, torque);
        }
    }
    let clamped = limits.clamp(torques);
    let missing = missing(feet, required, wrenches);
    let shared = match outcome {
        _ if clamped => Shared::Clamped { missing },
        Outcome::Met => Shared::Met,
        Outcome::GaveWay => Shared::GroundGaveWay { missing },
    };
    (shared, certificate)
}

/// What the feet do not give of a wrench about the world's origin.
fn missing<R: Scalar>(feet: &[StandingFoot<'_, R>], required: [R; 6], wrenches: &[[R; 6]; 2]) -> [R; 6] {
    let (mut force, mut moment) = halves(required);
    for (foot, wrench) in feet.iter().zip(wrenches) {
        let (own, about) = halves(*wrench);
        force = subtract(force, own);
        moment = subtract(moment, add(about, cross(foot.sole.position, own)));
    }
    joined(force, moment)
}

/// Force and moment of a wrench.
pub(super) fn halves<R: Copy>([a, b, c, d, e, f]: [R; 6]) -> (Vector<R>, Vector<R>) {
    ([a, b, c], [d, e, f])
}

/// The other way.
pub(super) fn joined<R: Copy>([a, b, c]: Vector<R>, [d, e, f]: Vector<R>) -> [R; 6] {
    [a, b, c, d, e, f]
}

impl<R: Scalar> Limits<'_, R> {
    fn make_sense(&self) -> bool {
        let zero = R::constant(0.0);
        let least = self.least_load;
        // NaN is not at least 0.
        let positive = self.friction >= zero && self.turning >= zero && least >= zero && least.is_finite();
        positive && self.torque.iter().all(|limit| *limit >= zero)
    }

    /// The limit of a joint, if it has one.
    pub(super) fn of(&self, joint: usize) -> Option<R> {
        self.torque.get(joint).copied().filter(|limit| limit.is_finite())
    }

    /// Holds torques within their limits; whether one was beyond by more than roundings.
    fn clamp(&self, torques: &mut [R]) -> bool {
        let (zero, rounding) = (R::constant(0.0), R::constant(ROUNDING * R::EPSILON));
        let mut beyond = false;
        for (joint, torque) in torques.iter_mut().enumerate() {
            if !torque.is_finite() {
                *torque = zero;
                beyond = true;
            }
            let limit = self.of(joint).filter(|limit| *limit >= zero);
            if let Some(limit) = limit.filter(|limit| torque.abs() > *limit) {
                beyond |= torque.abs() - limit > rounding * (R::constant(1.0) + torque.abs());
                *torque = torque.sign() * limit;
            }
        }
        beyond
    }
}

/// Roundings of a torque that is at its limit.
const ROUNDING: f64 = 1e4;

/// A wrench about the origin of a sole, in its axes, in those of the world.
pub(super) fn in_the_world<R: Scalar>(sole: &Pose<R>, wrench: [R; 6]) -> [R; 6] {
    let (force, moment) = halves(wrench);
    joined(turned(sole.turn, force), turned(sole.turn, moment))
}

/// A wrench about the world's origin, about another point, world axes.
pub(super) fn about<R: Scalar>(point: Vector<R>, wrench: [R; 6]) -> [R; 6] {
    let (force, moment) = halves(wrench);
    joined(force, along(moment, -R::constant(1.0), cross(point, force)))
}

#[cfg(test)]
mod tests {
    use super::super::space::{about_z, identity};
    use super::*;

    const HALF: f64 = 0.135;
    const WEIGHT: f64 = 150.0;

    fn foot(x: f64, y: f64, share: f64) -> StandingFoot<'static, f64> {
        let sole = Pose { position: [x, y, 0.0], turn: identity() };
        StandingFoot { sole, extent: [-HALF, HALF, -0.05, 0.05], joints: &[], jacobian: &[], share }
    }

    const GROUND: Limits<'static, f64> =
        Limits { friction: 0.6, turning: 0.05, least_load: 5.0, torque: &[] };

    /// A force of this size upward through a point of the ground.
    fn upward([x, y]: [f64; 2], force: f64) -> [f64; 6] {
        [0.0, 0.0, force, y * force, -x * force, 0.0]
    }

    fn shared(feet: &[StandingFoot<'_, f64>], required: [f64; 6]) -> ([[f64; 6]; 2], Shared<f64>) {
        let mut wrenches = [[0.0; 6]; 2];
        let (found, certificate) = share_certified(feet, required, &GROUND, &mut [], &mut wrenches);
        if found != Shared::Refused {
            let worst = certificate.stationarity.max(certificate.wrong_sign).max(certificate.excess);
            assert!(worst < 1e-11, "{certificate:?}");
        }
        (wrenches, found)
    }

    /// The centre of pressure of a wrench, from the middle of the sole.
    fn pressure([_, _, z, x, y, _]: [f64; 6]) -> [f64; 2] {
        [-y / z, x / z]
    }

    #[test]
    fn what_is_symmetric_is_shared_symmetrically() {
        let mut required = upward([0.02, 0.0], WEIGHT);
        required[0] = 12.0;
        let (found, verdict) = shared(&[foot(0.0, -0.1, 0.5), foot(0.0, 0.1, 0.5)], required);
        assert_eq!(verdict, Shared::Met);
        let mirrored = [1.0, -1.0, 1.0, -1.0, 1.0, -1.0];
        for ((right, left), sign) in found[0].iter().zip(found[1]).zip(mirrored) {
            assert!((right - sign * left).abs() < 1e-12 * WEIGHT, "{found:?}");
        }
        assert!((found[0][2] - WEIGHT / 2.0).abs() < 1e-10 && (found[0][0] - 6.0).abs() < 1e-10);
        assert!((pressure(found[0])[0] - 0.02).abs() < 1e-12);
    }

    /// (6.59) asks a foot to pull where the zero moment point is outside the line between its points of (6.57).
    #[test]
    fn no_foot_pulls_where_the_expression_of_the_thesis_does() {
        let (rear, front) = (foot(0.0, -0.1, 0.7), foot(0.2, 0.1, 0.3));
        let alpha = 0.3;
        let ends = |foot: &StandingFoot<'_, f64>| [-HALF, HALF].map(|end| foot.sole.position[0] + end);
        let point = -0.06;
        // a + b = λ₁ of both feet with a, b at (1 − α) p₂ + α p₃ and (1 − α) p₄ + α p₅.
        let mixed = |[p, q]: [f64; 2]| (1.0 - alpha) * p + alpha * q;
        let (a, b) = (mixed(ends(&rear)), mixed(ends(&front)));
        let of_front = WEIGHT * (point - a) / (b - a);
        assert!(of_front < -1.0, "{of_front}");
        let (found, verdict) = shared(&[rear, front], upward([point, -0.08], WEIGHT));
        assert_eq!(verdict, Shared::Met);
        for wrench in found {
            assert!(wrench[2] >= 5.0 - 1e-10 && pressure(wrench)[0].abs() < HALF + 1e-12, "{found:?}");
        }
    }

    #[test]
    fn one_foot_carries_all_of_it_and_a_foot_without_share_nothing() {
        let mut required = upward([0.05, -0.08], WEIGHT);
        required[1] = 7.0;
        let alone = shared(&[foot(0.0, -0.1, 0.0)], required);
        assert_eq!(alone.1, Shared::Met);
        assert!((alone.0[0][3] - 0.02 * WEIGHT).abs() < 1e-12 && alone.0[1] == [0.0; 6]);
        let let_go = shared(&[foot(0.0, -0.1, 1.0), foot(0.2, 0.1, 0.0)], required);
        assert_eq!(alone, let_go);
        // (6.58): no jump when the foot is let go.
        for share in [1e-2, 1e-4, 2e-6] {
            let (found, verdict) = shared(&[foot(0.0, -0.1, 1.0 - share), foot(0.2, 0.1, share)], required);
            assert_eq!(verdict, Shared::Met);
            let jump = found.iter().flatten().zip(alone.0.iter().flatten()).map(|(a, b)| (a - b).abs());
            assert!(jump.fold(0.0, f64::max) < 5.0 * share * WEIGHT, "{share}: {found:?}");
        }
    }

    #[test]
    fn what_the_ground_cannot_give_is_said() {
        let feet = [foot(0.0, -0.1, 0.5), foot(0.0, 0.1, 0.5)];
        let mut required = upward([0.0, 0.0], WEIGHT);
        required[0] = 0.8 * WEIGHT;
        let (found, verdict) = shared(&feet, required);
        let Shared::GroundGaveWay { missing } = verdict else { panic!("{verdict:?}") };
        assert!(missing[0] > 0.0 && found[0][0] <= 0.6 * found[0][2] + 1e-9, "{found:?} {missing:?}");
        for k in 0..3 {
            assert!((found[0][k] + found[1][k] + missing[k] - required[k]).abs() < 1e-11, "{missing:?}");
        }
        // Beyond the edge of a foot alone; pulled.
        assert!(matches!(shared(&feet[..1], upward([0.2, -0.1], WEIGHT)).1, Shared::GroundGaveWay { .. }));
        let (pulled, verdict) = shared(&feet, upward([0.0, 0.0], -WEIGHT));
        assert!(matches!(verdict, Shared::GroundGaveWay { .. }) && pulled[0][2] >= -1e-9, "{pulled:?}");
    }

    /// A knee alone: the ground gives what it must, another distribution if the drive is weak, less if both are.
    #[test]
    fn drives_are_not_asked_for_more_than_they_have() {
        let jacobian = [[0.0, 0.0, 0.3, 0.0, 0.0, 0.0]];
        let mut feet = [foot(0.0, -0.1, 0.5), foot(0.0, 0.1, 0.5)];
        for (foot, joint) in feet.iter_mut().zip([&[0_usize][..], &[1]]) {
            (foot.joints, foot.jacobian) = (joint, &jacobian);
        }
        let required = upward([0.0, 0.0], WEIGHT);
        let with = |limit: &[f64]| {
            let (mut torques, mut wrenches) = ([1.0, 1.0, 50.0], [[0.0; 6]; 2]);
            let found =
                share(&feet, required, &Limits { torque: limit, ..GROUND }, &mut torques, &mut wrenches);
            (found, torques, wrenches)
        };
        let (found, torques, _) = with(&[100.0, 100.0]);
        assert_eq!(found, Shared::Met);
        assert!((torques[0] - (1.0 - 0.3 * 75.0)).abs() < 1e-10 && torques[2] == 50.0);
        let (found, torques, wrenches) = with(&[20.0, 100.0]);
        assert_eq!(found, Shared::Met);
        assert!((torques[0] + 20.0).abs() < 1e-10 && (wrenches[0][2] - 70.0).abs() < 1e-9, "{wrenches:?}");
        let (found, torques, _) = with(&[20.0, 20.0]);
        assert!(matches!(found, Shared::GroundGaveWay { missing } if missing[2] > 5.0), "{found:?}");
        assert!(torques[..2].iter().all(|x| x.abs() <= 20.0));
        let (found, torques, _) = with(&[0.1, 100.0]);
        assert!(matches!(found, Shared::Clamped { .. }) && torques[0].abs() <= 0.1, "{found:?}");
        assert!(matches!(with(&[100.0, 100.0, 1.0]).0, Shared::Clamped { .. }));
    }

    #[test]
    fn what_makes_no_sense_is_refused() {
        let good = foot(0.0, 0.0, 1.0);
        let required = upward([0.0, 0.0], WEIGHT);
        let mut wrenches = [[1.0; 6]; 2];
        let mut refused = |feet: &[StandingFoot<'_, f64>], required, limits: &Limits<'_, f64>| {
            let mut torques = [f64::NAN, 3.0];
            let found = share(feet, required, limits, &mut torques[1..], &mut wrenches);
            assert!(wrenches == [[0.0; 6]; 2] || found != Shared::Refused);
            found == Shared::Refused && torques[1] == 3.0
        };
        assert!(refused(&[], required, &GROUND) && refused(&[good; 3], required, &GROUND));
        assert!(refused(&[good], [f64::NAN; 6], &GROUND));
        assert!(refused(&[good], required, &Limits { friction: -1.0, ..GROUND }));
        assert!(refused(&[good], required, &Limits { turning: f64::NAN, ..GROUND }));
        assert!(refused(&[StandingFoot { share: f64::NAN, ..good }], required, &GROUND));
        assert!(refused(&[StandingFoot { joints: &[0], ..good }], required, &GROUND));
        assert!(refused(&[StandingFoot { joints: &[7], jacobian: &[[0.0; 6]], ..good }], required, &GROUND));
        let infinite = Limits { friction: f64::INFINITY, turning: f64::INFINITY, ..GROUND };
        assert!(!refused(&[good], required, &infinite));
        let mut torques = [f64::NAN, -9.0];
        let limits = Limits { torque: &[2.0, 2.0], ..GROUND };
        assert_eq!(share(&[good], required, &limits, &mut torques, &mut wrenches), Shared::Refused);
        assert_eq!(torques, [0.0, -2.0]);
    }

    /// In single precision, turned and far from the origin, to its roundings.
    #[test]
    fn single_precision_agrees() {
        let turned = Pose { position: [3.0, -0.1, 0.0], turn: about_z(0.4) };
        let feet = [StandingFoot { sole: turned, ..foot(0.0, 0.0, 0.4) }, foot(3.2, 0.1, 0.6)];
        let required = upward([3.0, 0.0], WEIGHT);
        let (found, verdict) = shared(&feet, required);
        let single = feet.map(|foot| StandingFoot {
            sole: Pose {
                position: foot.sole.position.map(|x| x as f32),
                turn: foot.sole.turn.map(|row| row.map(|x| x as f32)),
            },
            extent: foot.extent.map(|x| x as f32),
            joints: &[],
            jacobian: &[],
            share: foot.share as f32,
        });
        let limits = Limits { friction: 0.6, turning: 0.05, least_load: 5.0, torque: &[] };
        let mut wrenches = [[0.0_f32; 6]; 2];
        let verdict_single = share(&single, required.map(|x| x as f32), &limits, &mut [], &mut wrenches);
        assert!(verdict == Shared::Met && verdict_single == Shared::Met);
        for (a, b) in found.iter().flatten().zip(wrenches.iter().flatten()) {
            assert!((a - f64::from(*b)).abs() < 1e-4 * WEIGHT, "{found:?} {wrenches:?}");
        }
    }
}
