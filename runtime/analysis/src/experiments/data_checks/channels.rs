//! Signs, units and columns that are mixed up: the log is read again under each suspicion, and the one under which
//! the model explains the torques is named.
use super::hypothesis::{Mixup, View};
use super::{Evidence, list, standing};
use bipedc_effects::diagnostic::Diagnostic;
use std::f64::consts::{FRAC_PI_2, PI};

/// A torque of which more than this is left by model and friction is suspicious: effects leave as much at times, but no
/// mix-up then explains them.
const SUSPICIOUS: f64 = 0.1;
/// A mix-up is believed if the joints concerned lose all but this part of what was left.
const LEFT: f64 = 0.3;
/// Another mix-up that removes nearly as much is named beside it.
const ALIKE: f64 = 0.9;
/// No joint swings or slides through so much (rad, m): its position may be in degrees or mm, or that of a motor.
const WIDE: f64 = 4.0;
/// Factors that are tried where a position is so wide: of gears, and of a motor's angle (or mm) for a slide.
const GEARS: (f64, f64) = (4.0, 250.0);
const SPINDLES: (f64, f64) = (4.0, 1e4);
/// So far apart at first, and around the best; units are told from gears within twice as much.
const COARSE: f64 = 1.3;
const APART: f64 = 1.03;
/// A unit explains as well if it leaves no more than so many times as much: what a log leaves open, not what it hardly tells.
const AS_WELL: f64 = 1.02;
/// Factors of encoders whose edges or poles are counted more often than somebody thought. If fewer are, more of the motion is as if a spring were
/// there, which is the likelier.
const COUNTS: [f64; 2] = [2.0, 4.0];
const MILLIMETRES: f64 = 1e3;
/// A mix-up is none if effects leave less than this part of what it leaves: one body with another mass and first moment, springs, friction.
const EFFECTS: f64 = 0.5;
/// A sign or a zero is doubtful if they leave less than so many times as much: of a last joint these are the same by algebra.
const ALMOST: f64 = 1.25;
/// Most mix-ups that are looked for in one log.
const MOST: usize = 3;
/// So many joints at least show what holds of all.
const MOST_OF_ALL: usize = 2;
/// If every joint has this left, the torques are those of another robot.
const FOREIGN: f64 = 0.5;

/// Errors about mixed-up channels, or a warning that nothing fits.
pub(super) fn check(evidence: &Evidence<'_>) -> Vec<Diagnostic> {
    let mut view = View::new(evidence);
    let mut found = Vec::new();
    let whole = whole(evidence, &view);
    // Whatever else the torques of a robot that stands look like comes from that.
    if let Some(stands) =
        (!evidence.recording.is_held && whole.is_none()).then(|| standing::check(evidence, &view)).flatten()
    {
        return vec![stands];
    }
    if let Some(mixup) = whole {
        found.push(error(evidence, mixup, &[]));
        view = view.under(evidence, mixup);
    }
    let mut doubtful = Vec::new();
    for _ in 0..MOST {
        let left = view.unexplained();
        if left.iter().all(|part| *part < SUSPICIOUS) {
            break;
        }
        let mut ranked = tried(evidence, &view, &left);
        ranked.retain(|(mixup, _)| !doubtful.contains(mixup));
        let Some((best, gain)) = ranked.pop() else { break };
        if may_be_effects(evidence, &view, best) {
            found.push(doubt(evidence, best));
            doubtful.push(best);
            continue;
        }
        let mixup = refined(evidence, &view, best);
        let mut others: Vec<Mixup> = Vec::new();
        for (other, _) in ranked.iter().rev().filter(|(_, much)| *much > ALIKE * gain) {
            // Neighbouring factors say the same.
            if !other.scales_as(best) && !others.iter().any(|known| known.scales_as(*other)) {
                others.push(*other);
            }
        }
        found.push(error(evidence, mixup, &others));
        view = view.under(evidence, mixup);
    }
    let joints = view.joints();
    let left = view.unexplained();
    if found.is_empty() && joints.len() > 1 && joints.iter().all(|&joint| left[joint] > FOREIGN) {
        let explained = joints.iter().map(|&j| 1.0 - left[j]).fold(0.0, f64::max);
        let message = format!(
            "the torques of the log have little to do with the model's: it explains at most {:.0} % of any joint's variance",
            100.0 * explained
        );
        let help =
            "is it a log of this robot, in N m and rad, and does the description say how its base is held?";
        found.push(Diagnostic::warning(message).help(help));
    }
    found
}

/// A mix-up of all joints at once, under which those that are not explained are, none worse than before; what is left of a sign that all have wrong is
/// explained in part by swaps as well.
fn whole(evidence: &Evidence<'_>, view: &View) -> Option<Mixup> {
    let left = view.unexplained();
    let torques = view.joints();
    let wide = (0..left.len()).any(|joint| !evidence.joints[joint].1 && view.range(joint) > WIDE);
    let degrees = wide.then_some(Mixup::AllDegrees);
    let efforts = [Mixup::EffortSigns, Mixup::EffortUnits(1e3), Mixup::EffortUnits(1e-3)];
    let heals = |mixup: &Mixup| {
        let read = view.under(evidence, *mixup);
        let then = read.unexplained();
        let healed = torques.iter().filter(|&&j| left[j] > SUSPICIOUS && then[j] < LEFT * left[j]);
        let stays = |&&j: &&usize| then[j] > SUSPICIOUS.max(LEFT * left[j]) || !read.explains(j);
        healed.count() >= MOST_OF_ALL.max(torques.len().div_ceil(2))
            && torques.iter().filter(stays).count() == 0
    };
    degrees.into_iter().chain(efforts).find(heals)
}

/// A factor of a position put right: the one around it that explains most, or that of a unit next to it.
fn refined(evidence: &Evidence<'_>, view: &View, mixup: Mixup) -> Mixup {
    let (joint, rough) = match mixup {
        Mixup::Geared(joint, factor) if view.range(joint) >= WIDE => (joint, factor),
        Mixup::Motor(joint, factor) => (joint, factor),
        Mixup::Degrees(joint) => (joint, 180.0 / PI),
        other => return other,
    };
    let with = |factor: f64| match mixup {
        Mixup::Motor(..) => Mixup::Motor(joint, factor),
        _ => Mixup::Geared(joint, factor),
    };
    let left = |mixup: Mixup| view.under(evidence, mixup).unexplained();
    let whole = |factor: f64| left(with(factor)).iter().sum::<f64>();
    let steps = (COARSE.ln() / APART.ln()).ceil() as i32;
    let tried = (-steps..=steps).map(|k| rough * APART.powi(k)).map(|factor| (factor, whole(factor)));
    let best = tried.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(rough, |(factor, _)| factor);
    if matches!(mixup, Mixup::Motor(..)) {
        return with(best);
    }
    let near = |factor: f64| (best / factor).ln().abs() <= 2.0 * APART.ln();
    if let Some(count) = COUNTS.into_iter().find(|&count| near(count)) {
        return with(count);
    }
    // A single joint may leave its scale open: then it is that of a unit.
    let (factor, unit) = unit(evidence, joint);
    let as_well =
        || left(unit).iter().zip(left(with(best))).all(|(unit, best)| *unit <= AS_WELL * best + 1e-9);
    if near(factor) || as_well() { unit } else { with(best) }
}

/// The unit that a joint's position is mistaken for, and its factor.
fn unit(evidence: &Evidence<'_>, joint: usize) -> (f64, Mixup) {
    match evidence.joints[joint].1 {
        true => (MILLIMETRES, Mixup::Geared(joint, MILLIMETRES)),
        false => (180.0 / PI, Mixup::Degrees(joint)),
    }
}

/// What may be wrong with the scale of a joint's position.
fn scales(evidence: &Evidence<'_>, view: &View, joint: usize) -> Vec<Mixup> {
    let mut list: Vec<Mixup> = COUNTS.map(|factor| Mixup::Geared(joint, factor)).to_vec();
    if view.range(joint) < WIDE {
        return list;
    }
    let (low, high) = if evidence.joints[joint].1 { SPINDLES } else { GEARS };
    list.push(unit(evidence, joint).1);
    let count = ((high / low).ln() / COARSE.ln()) as i32;
    let factors = (1..=count).map(|k| low * COARSE.powi(k));
    list.extend(factors.flat_map(|factor| [Mixup::Geared(joint, factor), Mixup::Motor(joint, factor)]));
    list
}

/// Mix-ups that explain what is left, the best last, each with how much it removes.
fn tried(evidence: &Evidence<'_>, view: &View, left: &[f64]) -> Vec<(Mixup, f64)> {
    let mut good: Vec<(Mixup, f64)> = suspicions(evidence, view, left)
        .into_iter()
        .filter_map(|mixup| {
            let read = view.under(evidence, mixup);
            let then = read.unexplained();
            let concerned: Vec<usize> =
                (0..left.len()).filter(|&j| (left[j] - then[j]).abs() > 1e-6).collect();
            let sum = |parts: &[f64]| concerned.iter().map(|&j| parts[j].min(10.0)).sum::<f64>();
            let (before, after) = (sum(left), sum(&then));
            let heals = |&&j: &&usize| left[j] > SUSPICIOUS && then[j] < LEFT * left[j];
            let mut healed = concerned.iter().filter(heals).peekable();
            let healed = healed.peek().is_some() && healed.all(|&j| read.explains(j));
            let mixed_up = healed && after < LEFT * before;
            // A body of another mass would be as light as a unit is large.
            let are_effects = || {
                (mixup.is_of_sign_or_zero() || is_of_counts(mixup))
                    && are_effects(evidence, (view, &concerned), after)
            };
            (mixed_up && !are_effects()).then_some((mixup, before - after))
        })
        .collect();
    good.sort_by(|a, b| a.1.total_cmp(&b.1));
    good
}

/// Whether a body that carries something, springs and the like explain some joints' torques better than a mix-up does that leaves this much
/// of them.
fn are_effects(evidence: &Evidence<'_>, (view, joints): (&View, &[usize]), left: f64) -> bool {
    view.left_by_effects(evidence, joints) < EFFECTS * left
}

/// Whether it is an encoder whose edges or poles are counted more often: a load far out on a shin makes as much of a thigh's torque.
fn is_of_counts(mixup: Mixup) -> bool {
    matches!(mixup, Mixup::Geared(_, factor) if COUNTS.contains(&factor))
}

/// Whether they explain about as well what a sign or a zero would.
fn may_be_effects(evidence: &Evidence<'_>, view: &View, mixup: Mixup) -> bool {
    let (before, after) = (view.unexplained(), view.under(evidence, mixup).unexplained());
    let concerned: Vec<usize> = (0..before.len()).filter(|&j| (before[j] - after[j]).abs() > 1e-6).collect();
    let left = concerned.iter().map(|&joint| after[joint]).sum::<f64>();
    mixup.is_of_sign_or_zero() && view.left_by_effects(evidence, &concerned) < ALMOST * left
}

fn suspicions(evidence: &Evidence<'_>, view: &View, left: &[f64]) -> Vec<Mixup> {
    let count = left.len();
    let mut list = Vec::new();
    // Columns of which one is missing are zero: nothing to swap or to turn.
    let moves: Vec<usize> = (0..count).filter(|&j| view.range(j) > 1e-6).collect();
    list.extend(moves.iter().flat_map(|&joint| scales(evidence, view, joint)));
    for (n, &joint) in moves.iter().enumerate() {
        list.push(Mixup::PositionSign(joint));
        list.extend(moves[..n].iter().map(|&other| Mixup::PositionsSwapped(other, joint)));
        if !evidence.joints[joint].1 {
            list.extend([1, -1, 2].map(|quarters| Mixup::Quarters(joint, quarters)));
        }
    }
    let torques = view.joints();
    for (n, &joint) in torques.iter().enumerate() {
        if left[joint] > SUSPICIOUS {
            list.extend([Mixup::EffortSign(joint), Mixup::Direction(joint)]);
            list.extend([1e3, 1e-3].map(|factor| Mixup::EffortUnit(joint, factor)));
        }
        let swapped = |&&other: &&usize| left[joint] > SUSPICIOUS || left[other] > SUSPICIOUS;
        let others: Vec<usize> = torques[..n].iter().filter(swapped).copied().collect();
        list.extend(others.iter().map(|&o| Mixup::EffortsSwapped(o, joint)));
        let both = others.into_iter().filter(|&o| left[joint].min(left[o]) > SUSPICIOUS);
        list.extend(both.map(|o| Mixup::JointsSwapped(o, joint)));
    }
    list
}

/// A mix-up that something carried looks like.
fn doubt(evidence: &Evidence<'_>, mixup: Mixup) -> Diagnostic {
    let (words, entry) = described(evidence, mixup);
    let message = format!("{words}, or a body carries something or sits elsewhere: both explain the torques");
    let help = format!(
        "look whether the joint is where its encoder says; if not, give a mapping file with the line\n  {entry}"
    );
    Diagnostic::warning(message).help(help)
}

fn error(evidence: &Evidence<'_>, mixup: Mixup, others: &[Mixup]) -> Diagnostic {
    let (words, entry) = described(evidence, mixup);
    let mut message = format!("{words}: read so, the model explains the torques, as logged it does not");
    for other in others {
        message.push_str(&format!(" (or {})", described(evidence, *other).0));
    }
    Diagnostic::error(message)
        .help(format!("correct the log, or give a mapping file with the line\n  {entry}"))
}

/// In words, and the line of a mapping file that puts it right.
fn described(evidence: &Evidence<'_>, mixup: Mixup) -> (String, String) {
    let name = |joint: usize| evidence.joints[joint].0;
    let position =
        |joint: usize, words: &str, entry: &str| of_column(name(joint), "position", (words, entry));
    let effort = |joint: usize, words: &str, entry: &str| of_column(name(joint), "effort", (words, entry));
    let (wrong_sign, sign) = ("has the wrong sign", "sign = -1");
    let radians = format!("scale = {:.10}", PI / 180.0);
    match mixup {
        Mixup::EffortSign(j) => effort(j, wrong_sign, sign),
        Mixup::EffortUnit(j, factor) => {
            effort(j, &format!("is in the {}", wrong_unit(factor)), &format!("scale = {}", factor.recip()))
        }
        Mixup::PositionSign(j) => position(j, wrong_sign, sign),
        Mixup::Direction(j) => {
            let (words, line) = position(j, "and its effort count the other way round", sign);
            (words, format!("{line}\n  {}", effort(j, "", sign).1))
        }
        Mixup::Geared(j, factor) => {
            position(j, &times(evidence.joints[j].1, factor), &format!("scale = {}", inverse(factor)))
        }
        Mixup::Motor(j, factor) => {
            let words = format!(
                "is about {factor:.0} times too large and its effort as much too small: those of a motor in front of its gear or spindle (scale: one over its exact ratio, and the ratio)"
            );
            let (words, line) = position(j, &words, &format!("scale = {}", inverse(factor)));
            (words, format!("{line}\n  {}", effort(j, "", &format!("scale = {factor:.3}")).1))
        }
        Mixup::Quarters(j, quarters) => {
            let words = format!("counts from elsewhere, about {} degrees off", 90 * i32::from(quarters));
            position(j, &words, &format!("offset = {:.10}", -FRAC_PI_2 * f64::from(quarters)))
        }
        Mixup::Degrees(j) => {
            let words = "is in degrees instead of rad (factor 57.3), or of a motor in front of a gear of about as much";
            position(j, words, &radians)
        }
        Mixup::EffortSigns => of_all(evidence, ("effort", "efforts of all joints have the wrong sign"), sign),
        Mixup::EffortUnits(factor) => {
            let words = format!("efforts of all joints are in the {}", wrong_unit(factor));
            of_all(evidence, ("effort", &words), &format!("scale = {}", factor.recip()))
        }
        Mixup::AllDegrees => {
            let words = "positions of all joints are in degrees instead of rad (factor 57.3)";
            of_all(evidence, ("position", words), &radians)
        }
        Mixup::PositionsSwapped(a, b) => swapped(name(a), name(b), "position"),
        Mixup::EffortsSwapped(a, b) => swapped(name(a), name(b), "effort"),
        Mixup::JointsSwapped(a, b) => {
            let (words, lines): (Vec<String>, Vec<String>) =
                ["position", "effort"].map(|what| swapped(name(a), name(b), what)).into_iter().unzip();
            (words.join(", and "), lines.join("\n  "))
        }
    }
}

/// Of one column: what it is, and the line with an entry for it.
fn of_column(joint: &str, what: &str, (words, entry): (&str, &str)) -> (String, String) {
    (format!("`{joint}/{what}` {words}"), format!("\"{joint}/{what}\" = {{ {entry} }}"))
}

/// One over a factor: exact of counts and units, what was found of others.
fn inverse(factor: f64) -> String {
    let exact = COUNTS.contains(&factor) || factor == MILLIMETRES;
    match factor {
        _ if exact => factor.recip().to_string(),
        _ if factor < 100.0 => format!("{:.5}", factor.recip()),
        _ => format!("{:.4e}", factor.recip()),
    }
}

/// Of a position that is so many times too large.
fn times(slides: bool, factor: f64) -> String {
    if slides && factor == MILLIMETRES {
        return "is in mm instead of m (factor 1000)".to_owned();
    }
    if COUNTS.contains(&factor) {
        return format!(
            "is about {factor} times too large, such as of an encoder whose edges are counted otherwise, or of a motor in front of its gear"
        );
    }
    let of = if slides {
        "a motor's angle in front of its spindle"
    } else {
        "a motor's angle in front of its gear"
    };
    format!("is about {factor:.0} times too large, such as {of} (scale: one over its exact ratio)")
}

/// Of efforts that are so many times too large.
fn wrong_unit(factor: f64) -> String {
    let unit = if factor > 1.0 { "N mm (mN m) instead of N m" } else { "kN m instead of N m" };
    format!("wrong unit, such as {unit} (factor {factor})")
}

/// The same of every joint that has the column.
fn of_all(evidence: &Evidence<'_>, (what, words): (&str, &str), how: &str) -> (String, String) {
    let has = |joint: &usize| match what {
        "effort" => evidence.recording.effort[*joint].is_some(),
        _ => !evidence.joints[*joint].1,
    };
    let lines = (0..evidence.joints.len()).filter(has);
    let lines: Vec<String> =
        lines.map(|joint| format!("\"{}/{what}\" = {{ {how} }}", evidence.joints[joint].0)).collect();
    (words.to_owned(), lines.join("\n  "))
}

fn swapped(a: &str, b: &str, what: &str) -> (String, String) {
    let pair = [format!("{a}/{what}"), format!("{b}/{what}")];
    (
        format!("{} are swapped", list(pair.iter().map(String::as_str))),
        format!(
            "\"{a}/{what}\" = {{ column = \"{b}/{what}\" }}\n  \"{b}/{what}\" = {{ column = \"{a}/{what}\" }}"
        ),
    )
}
