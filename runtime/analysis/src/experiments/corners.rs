//! Samples at the corners of laws: where friction turns about, where a drive comes to its limit.
//!
//! There the torque that the motion needs jumps or bends, but what is known of the motion went through a filter, which rounds that; friction's
//! formula changes its sign over a width of speeds, and noise decides on which side of a limit a reported torque seems to be. An estimate from
//! all samples makes up for it: dry friction came out up to 0.6 % off, its value at rest 5 %, limits 2 to 4 % small, many times what noise leaves them
//! uncertain by. So estimates leave such samples out, and take the sign beyond as it is.
use super::signals::{signal_of, velocity_of};
use super::{Channel, Experiment};
use bipedc_effects::effect::{Effect, Law, Simulation, kinds};

/// So many widths away from rest the smoothed sign is within 4 % of one.
pub(crate) const WIDTHS: f64 = 2.0;
/// Least part of the samples that must be left.
const LEFT: f64 = 0.4;
/// How far around a reversal samples are left out, in halves of a period of the filter's cut-off: as far as enough others are left. What the filter
/// makes of a jump rings, with the other sign in each half: by 1 % of the friction in the second one, by a quarter in the fourth.
const REACHES: [usize; 3] = [3, 2, 1];
/// By which part of itself a torque that jumps comes out wrong where only the nearest of these are left out.
pub(crate) const NEAR_CORNERS: f64 = 4e-3;
/// The first and the last of these.
pub(crate) const FARTHEST: usize = REACHES[0];
pub(crate) const NEAREST: usize = REACHES[REACHES.len() - 1];
/// Part of a spring or a play between two encoders by which its estimate can be off however little the angles scatter: filters,
/// sampling and how stops give way are as wrong at every sample (up to 0.13 % on logs without noise).
const SIMILAR: f64 = 2e-3;
/// The same of play behind a motor whose link has no encoder: how the link meets its stops no law here tells, and its motion is made from that.
/// In twelve logs of three robots the play came out 3.5 % off (root mean square), 5.7 % at most.
const UNSEEN: f64 = 6e-2;
/// The same in a leg on the ground, where links chatter between their stops for a part of every step. In eleven walks of TUlip with 5 to 25 mrad
/// of play in one joint it came out 4 % off (median), 13 % at most, and a fifth and a third too small in two ankles that roll.
const UNSEEN_IN_A_LEG: f64 = 0.1;
/// The same of a spring there: 0.5 to 3.7 % in twelve walks, all of them too soft; of a motor's inertia before it 0.6 to 1.4 % too small. Neither the
/// simulation's step nor the sensors' noise is the cause: with true values 0.16 N m were left in an ankle of a log without noise. What is
/// left where filtered forces multiply filtered angles at each step of the foot may be.
const SPRING_IN_A_LEG: f64 = 6e-2;
const BEFORE_A_SPRING: f64 = 2e-2;
/// The same of a drive's limit: what the filter makes of a motion whose torque is cut off is too large where it is cut off.
pub(crate) const CLIPPED: f64 = 6e-3;
/// So many standard deviations of its noise a reported torque is away from a limit.
const DEVIATIONS: f64 = 3.0;
/// Fewest samples beyond a limit that tell where it is.
const BEYOND: usize = 50;
/// The parameter of friction's sign.
pub(crate) const SMOOTHING: &str = "smoothing";
/// A coupling's friction, and the part of the joint's own speed in its sign.
const COULOMB: &str = "coulomb";
const DIFFERENTIAL: &str = "differential";
/// Beyond the corner the width of the sign is this part of what is stated.
const SHARP: f64 = 0.02;

/// Samples of a row at the corners of what acts there.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Corners {
    /// One flag each; empty if there are none, or too few others.
    pub left_out: Vec<bool>,
    /// How far around a jump samples are left out, in halves of a period of the cut-off; `None`: none are, because
    /// nothing jumps or because too few others were left.
    pub reach: Option<usize>,
}

impl Corners {
    /// Whether a sample lies at one.
    pub fn hold(&self, sample: usize) -> bool {
        self.left_out.get(sample).is_some_and(|out| *out)
    }

    /// By which part of itself a torque that jumps comes out wrong, because of what rings beside the samples that are left
    /// out: what was measured on logs with little noise, at most.
    pub fn inexactness(&self) -> f64 {
        match self.reach {
            Some(3..) => 1e-3,
            Some(2) => 2e-3,
            Some(1) => NEAR_CORNERS,
            Some(0) => 1e-2,
            None => 2e-2,
        }
    }

    /// With others left out as well, if there are any.
    pub fn beside(mut self, others: Vec<bool>) -> Self {
        if self.left_out.is_empty() {
            self.left_out = others;
        } else {
            self.left_out.iter_mut().zip(others).for_each(|(flag, other)| *flag |= other);
        }
        self
    }
}

/// Corners as near as they are seen.
pub(crate) fn corners(experiment: &dyn Experiment, row: usize, effects: &[Effect]) -> Corners {
    let turning = reversals(experiment, row, effects, &REACHES[2..]);
    turning.beside(limits(experiment, row, effects))
}

/// The same as far around as an estimate can do without: what rings there is too little to be seen and enough to pull at it.
pub(crate) fn wide_corners(experiment: &dyn Experiment, row: usize, effects: &[Effect]) -> Corners {
    corners_within(experiment, row, effects, FARTHEST)
}

/// The same no farther around than so many halves of a period of the cut-off.
pub(crate) fn corners_within(
    experiment: &dyn Experiment,
    row: usize,
    effects: &[Effect],
    farthest: usize,
) -> Corners {
    match experiment.rows()[row].channel {
        Channel::Transmission => crossings(experiment, row, effects),
        _ => {
            let nearer = REACHES.partition_point(|reach| *reach > farthest);
            let turning = reversals(experiment, row, effects, &REACHES[nearer..]);
            turning.beside(limits(experiment, row, effects))
        }
    }
}

/// Samples at which a link behind a motor crosses its play under these effects, and as far around as leaves enough others: no sensor and no law
/// tells there how it meets its stop, and all joints feel it. Empty where none does.
pub(crate) fn landings(experiment: &dyn Experiment, effects: &[Effect]) -> Vec<bool> {
    let crossings = experiment.crossings(effects);
    if !crossings.contains(&true) {
        return Vec::new();
    }
    enough_beside(&crossings, &[], (experiment.smeared(), &REACHES)).left_out
}

/// Where links behind play meet their stops in legs on the ground, see [`landings`]: where they rest is told by where the feet stand, on a stand
/// by how they fly alone. Empty where none does.
pub(crate) fn landings_in_legs(experiment: &dyn Experiment, effects: &[Effect]) -> Vec<bool> {
    if is_on_ground(experiment) { landings(experiment, effects) } else { Vec::new() }
}

fn is_on_ground(experiment: &dyn Experiment) -> bool {
    experiment.rows().iter().any(|row| matches!(row.channel, Channel::BaseForce | Channel::Cop))
}

/// By which part of itself an effect's parameters come out wrong however little its row scatters, given the corners of all rows.
/// `all` are the effects that are estimated with it.
pub(crate) fn inexactness(
    experiment: &dyn Experiment,
    effect: &Effect,
    (all, corners): (&[Effect], &[Corners]),
) -> f64 {
    let of_joint = |(row, _): &(usize, &Corners)| {
        let what = &experiment.rows()[*row];
        what.channel == Channel::Effort && what.joint == effect.location.joint
    };
    let here = corners.iter().enumerate().find(of_joint).map(|(_, corners)| corners);
    let is_seen = || {
        let rows = experiment.rows().iter().filter(|row| row.channel == Channel::Transmission);
        rows.map(|row| &row.joint).any(|joint| *joint == effect.location.joint)
    };
    let is_before_spring = || {
        if *effect.kind != kinds::ROTOR_INERTIA {
            return false;
        }
        let springs = all.iter().filter(|other| other.kind.law == Law::SeriesElasticity);
        springs.map(|spring| &spring.location).any(|place| *place == effect.location)
    };
    match (effect.kind.law, effect.kind.simulation) {
        (Law::Backlash, _) if !is_seen() && is_on_ground(experiment) => UNSEEN_IN_A_LEG,
        (Law::Backlash, _) if !is_seen() => UNSEEN,
        (Law::SeriesElasticity, _) if !is_seen() && is_on_ground(experiment) => SPRING_IN_A_LEG,
        (Law::SeriesElasticity | Law::Backlash, _) => SIMILAR,
        _ if is_before_spring() && !is_seen() && is_on_ground(experiment) => BEFORE_A_SPRING,
        (_, Simulation::Dry(_) | Simulation::Coupling { .. }) => here.map_or(0.0, Corners::inexactness),
        (_, Simulation::Limit(_)) => CLIPPED,
        _ => 0.0,
    }
}

/// The effects with signs as sharp as they are where samples at their corners are left out; `reversed` says of each row
/// whether that is so.
pub(crate) fn sharpened(
    experiment: &dyn Experiment,
    effects: &[Effect],
    reversed: impl Fn(usize) -> bool,
) -> Vec<Effect> {
    let mut sharp = effects.to_vec();
    for (row, what) in experiment.rows().iter().enumerate() {
        if !reversed(row) {
            continue;
        }
        let joint = what.joint.as_deref();
        let jumps = |effect: &&mut Effect| match what.channel {
            Channel::Effort => rubs(effect, joint),
            Channel::Transmission => is_play(effect, joint),
            _ => false,
        };
        for effect in sharp.iter_mut().filter(jumps) {
            let width = SHARP * effect.value(SMOOTHING);
            effect.parameters.insert(SMOOTHING.to_owned(), width);
        }
    }
    sharp
}

/// Whether an effect has a sign of a speed at this joint.
fn rubs(effect: &Effect, joint: Option<&str>) -> bool {
    let signed = match effect.kind.simulation {
        Simulation::Dry(_) => true,
        Simulation::Coupling { .. } => effect.value(COULOMB) != 0.0,
        _ => false,
    };
    signed && effect.location.joint.as_deref() == joint
}

fn is_coupling(effect: &Effect) -> bool {
    matches!(effect.kind.simulation, Simulation::Coupling { .. })
}

/// The speed whose sign an effect has.
fn rubbing_speed(experiment: &dyn Experiment, row: usize, effect: &Effect) -> Option<Vec<f64>> {
    let own = velocity_of(experiment, row)?;
    let Simulation::Coupling { .. } = effect.kind.simulation else { return Some(own) };
    let mut other =
        signal_of(experiment, row, &format!("{}/velocity", effect.location.other_joint.as_ref()?))?;
    let part = effect.value(DIFFERENTIAL);
    other.iter_mut().zip(own).for_each(|(other, own)| *other += part * own);
    Some(other)
}

fn is_play(effect: &Effect, joint: Option<&str>) -> bool {
    effect.kind.law == Law::Backlash && effect.location.joint.as_deref() == joint
}

/// Samples at which the torque through a play is so small that its link may be anywhere between the stops, or is on its way
/// between them; empty where there is no play, or too few others were left.
fn crossings(experiment: &dyn Experiment, row: usize, effects: &[Effect]) -> Corners {
    let joint = experiment.rows()[row].joint.as_deref();
    let Some(play) = effects.iter().find(|effect| is_play(effect, joint)) else { return Corners::default() };
    let Some(load) = signal_of(experiment, row, "load") else { return Corners::default() };
    let least = WIDTHS * play.value(SMOOTHING);
    let small: Vec<bool> = load.iter().map(|torque| torque.abs() < least).collect();
    enough_beside(&small, &[], (experiment.smeared(), &REACHES))
}

/// Samples at which a joint of a row sticks, and as far around as filters smear what it does when it begins and ceases to move.
pub(crate) fn departures(experiment: &dyn Experiment, row: usize) -> Vec<bool> {
    around(experiment.sticks(row), FARTHEST * experiment.smeared())
}

/// Samples at which a joint with dry friction, or one that rubs in it, turns about; empty where it has none, or moves so slowly that too few others were left.
fn reversals(experiment: &dyn Experiment, row: usize, effects: &[Effect], reaches: &[usize]) -> Corners {
    let what = &experiment.rows()[row];
    let joint = what.joint.as_deref().filter(|_| what.channel == Channel::Effort);
    // Friction that turns about jumps, and so does the acceleration, which is known as smooth as the filter made it.
    let within = |of: fn(&Effect) -> bool, reaches: &[usize], width_of: fn(&Effect) -> f64| {
        let mut slow: Vec<bool> = Vec::new();
        for effect in effects.iter().filter(|effect| joint.is_some() && rubs(effect, joint) && of(effect)) {
            let width = WIDTHS * width_of(effect);
            let Some(speed) = rubbing_speed(experiment, row, effect).filter(|_| width > 0.0) else {
                continue;
            };
            slow.resize(speed.len(), false);
            slow.iter_mut().zip(speed).for_each(|(slow, speed)| *slow |= speed.abs() < width);
        }
        if slow.is_empty() {
            return Corners::default();
        }
        enough_beside(&slow, experiment.sticks(row), (experiment.smeared(), reaches))
    };
    // However sharp the sign is, the filter knows as little of a joint that leaves its rest; one that is hardly ever faster has nothing else.
    let beside = |of: fn(&Effect) -> bool, reaches: &[usize]| {
        let usual = within(of, reaches, usual_width);
        if usual.reach.is_some() { usual } else { within(of, reaches, |effect| effect.value(SMOOTHING)) }
    };
    let own = beside(|effect| !is_coupling(effect), reaches);
    // Two joints turn about more often than one: what rings farther away costs less than the samples there.
    let coupled = beside(is_coupling, &REACHES[2..]);
    let reach = own.reach.or(coupled.reach);
    Corners { reach, ..own.beside(coupled.left_out) }
}

/// The width of an effect's sign, or the usual one of its kind where that is larger; of slides it is their own.
fn usual_width(effect: &Effect) -> f64 {
    if effect.sliding {
        return effect.value(SMOOTHING);
    }
    let mut unstated = effect.clone();
    unstated.parameters.remove(SMOOTHING);
    effect.value(SMOOTHING).max(unstated.value(SMOOTHING))
}

/// Flags, and as many around them as leave enough others: `reaches` times so many samples, the farthest first, else none
/// around; empty if too few are left even so. Samples that stick count neither among those that are left nor among those that there are.
fn enough_beside(flags: &[bool], sticks: &[bool], (smeared, reaches): (usize, &[usize])) -> Corners {
    let moves = |i: &usize| !sticks.get(*i).is_some_and(|sticks| *sticks);
    let moving = (0..flags.len()).filter(moves).count();
    let leaves_enough = |(_, flags): &(usize, Vec<bool>)| {
        let left = (0..flags.len()).filter(moves).filter(|i| !flags[*i]).count();
        left > 0 && left as f64 >= LEFT * moving as f64
    };
    let wide = reaches.iter().map(|&reach| (reach, around(flags, reach * smeared)));
    match wide.chain([(0, flags.to_vec())]).find(leaves_enough) {
        Some((reach, left_out)) => Corners { left_out, reach: Some(reach) },
        None => Corners::default(),
    }
}

/// Flags, and those around them as far as `reach` samples.
fn around(flags: &[bool], reach: usize) -> Vec<bool> {
    let mut wide = vec![false; flags.len()];
    for (i, _) in flags.iter().enumerate().filter(|(_, flag)| **flag) {
        wide[i.saturating_sub(reach)..(i + reach + 1).min(flags.len())].fill(true);
    }
    wide
}

/// Samples at which the reported torque is so near a drive's limit that noise and filter decide whether it is beyond; empty where there is no limit,
/// or too few samples are beyond.
fn limits(experiment: &dyn Experiment, row: usize, effects: &[Effect]) -> Vec<bool> {
    let what = &experiment.rows()[row];
    let limit = effects.iter().find_map(|effect| match effect.kind.simulation {
        Simulation::Limit(name) if effect.location.joint == what.joint => Some(effect.value(name)),
        _ => None,
    });
    let Some(limit) = limit.filter(|_| what.channel == Channel::Effort) else { return Vec::new() };
    let Some(reported) = experiment.measured(row) else { return Vec::new() };
    let near = DEVIATIONS * what.noise;
    let beyond = reported.iter().filter(|torque| torque.abs() > limit + near).count();
    if beyond < BEYOND {
        return Vec::new();
    }
    reported.iter().map(|torque| (torque.abs() - limit).abs() < near).collect()
}

#[cfg(test)]
mod tests {
    use super::around;

    #[test]
    fn corners_reach_as_far_as_the_filter_does() {
        let flags = [false, false, false, true, false, false, false, false];
        assert_eq!(around(&flags, 2).iter().filter(|flag| **flag).count(), 5);
        assert_eq!(around(&flags, 0), flags);
    }
}
