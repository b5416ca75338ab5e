//! Signs, units and columns that are mixed up: the log is read again under each suspicion, and the one under which
//! the model explains the torques is named.
use super::hypothesis::{Mixup, View};
use super::{Evidence, list};
use bipedc_effects::diagnostic::Diagnostic;
use std::f64::consts::{FRAC_PI_2, PI};

/// A torque of which more than this is left by model and friction is suspicious: effects leave as much at times, but no
/// mix-up then explains them.
const SUSPICIOUS: f64 = 0.1;
/// A mix-up is believed if the joints concerned lose all but this part of what was left.
const LEFT: f64 = 0.3;
/// Another mix-up that removes nearly as much is named beside it.
const ALIKE: f64 = 0.9;
/// No joint swings through so much (rad): its position may be in degrees.
const WIDE: f64 = 4.0;
/// Factors of gears that are tried where a position looks like one in degrees, so far apart; degrees are told from them within twice as much.
const GEARS: (f64, f64) = (4.0, 250.0);
const APART: f64 = 1.03;
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
    if let Some(mixup) = whole(evidence, &view) {
        found.push(error(evidence, mixup, &[]));
        view = view.under(evidence, mixup);
    }
    for _ in 0..MOST {
        let left = view.unexplained();
        if left.iter().all(|part| *part < SUSPICIOUS) {
            break;
        }
        let mut ranked = tried(evidence, &view, &left);
        let Some((best, gain)) = ranked.pop() else { break };
        let mixup = geared(evidence, &view, best);
        let others: Vec<Mixup> =
            ranked.iter().filter(|(_, other)| *other > ALIKE * gain).map(|(mixup, _)| *mixup).collect();
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

/// What a position that looks like one in degrees is: one of a motor in front of its gear, if another factor than that of degrees explains more.
fn geared(evidence: &Evidence<'_>, view: &View, mixup: Mixup) -> Mixup {
    let Mixup::Degrees(joint) = mixup else { return mixup };
    let degrees = 180.0 / PI;
    let left = |mixup: Mixup| view.under(evidence, mixup).unexplained().iter().sum::<f64>();
    let count = ((GEARS.1 / GEARS.0).ln() / APART.ln()) as i32;
    let factors = (0..=count).map(|k| GEARS.0 * APART.powi(k));
    let tried = factors.map(|factor| (factor, left(Mixup::Geared(joint, factor))));
    let best = tried.min_by(|a, b| a.1.total_cmp(&b.1));
    let is_other = |(factor, rest): &(f64, f64)| {
        let apart = (factor / degrees).ln().abs();
        apart > 2.0 * APART.ln() && *rest < left(mixup)
    };
    best.filter(is_other).map_or(mixup, |(factor, _)| Mixup::Geared(joint, factor))
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
            (healed && after < LEFT * before).then_some((mixup, before - after))
        })
        .collect();
    good.sort_by(|a, b| a.1.total_cmp(&b.1));
    good
}

fn suspicions(evidence: &Evidence<'_>, view: &View, left: &[f64]) -> Vec<Mixup> {
    let count = left.len();
    let mut list = Vec::new();
    // Columns of which one is missing are zero: nothing to swap or to turn.
    let moves: Vec<usize> = (0..count).filter(|&j| view.range(j) > 1e-6).collect();
    for &joint in moves.iter().filter(|&&j| !evidence.joints[j].1) {
        if view.range(joint) > WIDE {
            list.push(Mixup::Degrees(joint));
        }
    }
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
            let words = format!(
                "is about {factor:.0} times too large, such as a motor's angle in front of its gear (scale: one over its exact ratio)"
            );
            position(j, &words, &format!("scale = {:.5}", factor.recip()))
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
