//! Whether the joints move enough, and long enough.
use super::{Evidence, list, quantile};
use bipedc_effects::diagnostic::Diagnostic;

/// Shorter logs support hardly any estimate, s.
pub(crate) const SHORT: f64 = 4.0;
/// A joint that stays within this range hardly moves; rad, m.
const RANGE: [f64; 2] = [0.02, 0.002];
/// A joint that is always slower than this hardly moves; rad/s, m/s.
const SPEED: [f64; 2] = [0.05, 0.005];
/// A direction in which a joint moves for less than this part of the time in which it moves is not seen.
const ONE_WAY: f64 = 0.02;

/// Whether all joints stay where they are.
pub(super) fn nothing_moves(evidence: &Evidence<'_>) -> bool {
    let mut joints = evidence.joints.iter().enumerate();
    joints.all(|(joint, (_, prismatic))| range(evidence, joint) < RANGE[usize::from(*prismatic)])
}

/// How far a joint swings, but for the outermost samples.
fn range(evidence: &Evidence<'_>, joint: usize) -> f64 {
    let mut q: Vec<f64> = evidence.position(joint).collect();
    quantile(&mut q, 0.99) - quantile(&mut q, 0.01)
}

/// A warning about a log of which so much motion is looked at, s.
pub(in crate::experiments) fn short(duration: f64) -> Option<Diagnostic> {
    let decimals = if duration < 1.0 { 2 } else { 1 };
    let message =
        format!("the log has only {duration:.decimals$} s of motion: estimates from it are hardly supported");
    let warning = Diagnostic::warning(message).help("record at least 20 s in which all joints move");
    (duration < SHORT).then_some(warning)
}

/// Warnings about joints whose effects cannot be told apart.
pub(super) fn check(evidence: &Evidence<'_>) -> Vec<Diagnostic> {
    let r = evidence.recording;
    let mut found: Vec<Diagnostic> = short(r.time.len() as f64 * r.step).into_iter().collect();
    let (mut still, mut one_way) = (Vec::new(), Vec::new());
    for (joint, (name, prismatic)) in evidence.joints.iter().enumerate() {
        if r.effort[joint].is_none() {
            continue;
        }
        match motion(evidence, joint, usize::from(*prismatic)) {
            Excitation::Still => still.push(*name),
            Excitation::OneWay => one_way.push(*name),
            Excitation::Enough => {}
        }
    }
    if !still.is_empty() {
        let (verb, joints) = if still.len() == 1 { ("moves", "joint") } else { ("move", "joints") };
        let message =
            format!("{joints} {} hardly {verb}: friction cannot be told from bias there", list(still));
        let help = "record a motion in which the joint swings by at least a tenth of a radian to both sides";
        found.push(Diagnostic::warning(message).help(help));
    }
    if !one_way.is_empty() {
        let message = moving_one_way(&one_way);
        found.push(Diagnostic::warning(message).help("record a motion that goes to and fro"));
    }
    found
}

/// Of joints, in words.
fn moving_one_way(joints: &[&str]) -> String {
    let verb = if joints.len() == 1 { "moves" } else { "move" };
    let joints = list(joints.iter().copied());
    format!("{joints} {verb} in one direction only: Coulomb friction cannot be told from bias there")
}

enum Excitation {
    Still,
    OneWay,
    Enough,
}

fn motion(evidence: &Evidence<'_>, joint: usize, kind: usize) -> Excitation {
    let v: Vec<f64> = evidence.velocity(joint).collect();
    let mut speeds: Vec<f64> = v.iter().map(|v| v.abs()).collect();
    let fast = quantile(&mut speeds, 0.99);
    if range(evidence, joint) < RANGE[kind] || fast < SPEED[kind] {
        return Excitation::Still;
    }
    if is_one_way(&v, 0.1 * fast) { Excitation::OneWay } else { Excitation::Enough }
}

/// Whether nearly all that is faster than `moving` goes one way, rests of whatever length left out.
fn is_one_way(velocity: &[f64], moving: f64) -> bool {
    let faster = |sign: f64| velocity.iter().filter(|v| sign * **v > moving).count() as f64;
    let (forth, back) = (faster(1.0), faster(-1.0));
    forth.min(back) < ONE_WAY * (forth + back)
}

#[cfg(test)]
mod tests {
    use super::{is_one_way, moving_one_way};

    /// A joint that waits for the others moves for little of the log, and to and fro.
    #[test]
    fn rests_are_no_direction() {
        let mut velocity = vec![0.0; 10_000];
        velocity[300..420].fill(0.5);
        assert!(is_one_way(&velocity, 0.05));
        velocity[7000..7150].fill(-0.4);
        assert!(!is_one_way(&velocity, 0.05));
    }

    #[test]
    fn several_joints_move() {
        assert!(moving_one_way(&["a"]).starts_with("`a` moves in one direction"));
        assert!(moving_one_way(&["a", "b"]).starts_with("`a`, `b` move in one direction"));
    }
}
