//! Mixed-up signals, before anything is estimated.
use super::driven::Driven;
use super::look::{Look, Seen};
use crate::robot::JointLayout;
use bipedc_effects::diagnostic::{Diagnostic, Severity};
use bipedc_effects::drive::Drive;

/// Joints do not turn further than this, rad; degrees do.
const FAR: f64 = 9.5;
/// Motor turns per joint turn may be off by this factor: a soft spring gives.
const OFF: f64 = 2.0;
/// Degrees per radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;
/// Springs loaded less than this the other way, as a part of the load, are loaded one way only.
const ONE_WAY: f64 = 0.05;

/// What is odd about the signals of a log; errors stop the command unless they are overruled.
pub fn odd(look: &Look, drives: &[Driven<'_>], layout: &JointLayout) -> Vec<Diagnostic> {
    let mut found = Vec::new();
    for (Driven { joint, drive }, seen) in
        drives.iter().zip(&look.drives).filter(|(_, seen)| seen.samples > 0)
    {
        let name = layout.joints[*joint].name.as_str();
        let motion = still(name, seen).or_else(|| ratio(name, drive, seen)).or_else(|| far(name, seen));
        match motion {
            Some(error) => found.push(error),
            None => found.extend(one_way(name, drive, seen)),
        }
    }
    found
}

/// Whether any of it stops the command.
pub fn stops(found: &[Diagnostic]) -> bool {
    found.iter().any(|diagnostic| diagnostic.severity == Severity::Error)
}

fn still(name: &str, seen: &Seen) -> Option<Diagnostic> {
    if seen.speed < 1e-6 {
        return Some(
            Diagnostic::error(format!(
                "`{name}/motor_position` stands still: neither friction nor spring can be told"
            ))
            .help("record a motion in which every motor turns both ways"),
        );
    }
    (seen.current.width() < 1e-12).then(|| {
        Diagnostic::error(format!(
            "`{name}/motor_current` is constant ({} A): it measures no torque",
            seen.current.low
        ))
        .help("log the measured current of the motor in A")
    })
}

fn far(name: &str, seen: &Seen) -> Option<Diagnostic> {
    (seen.angle.size() > FAR && seen.angle.width() > FAR).then(|| {
        Diagnostic::error(format!(
            "`{name}` turns from {:.1} to {:.1} rad: is it logged in degrees?",
            seen.angle.low, seen.angle.high
        ))
        .help("positions are in rad; a mapping file scales them (scale = 0.0174533)")
    })
}

/// Motor turns per joint turn tell swapped columns and wrong units.
fn ratio(name: &str, drive: &Drive, seen: &Seen) -> Option<Diagnostic> {
    let [slope, correlation] = seen.line.slope()?;
    let wanted = drive.turns();
    if !drive.is_elastic() || correlation.abs() < 0.5 {
        return None;
    }
    let near = |value: f64, of: f64| value / of > 1.0 / OFF && value / of < OFF;
    if near(slope, wanted) {
        return None;
    }
    let (gear, pulleys) = (drive.gear_ratio, wanted / drive.gear_ratio);
    let guesses = [
        (1.0 / wanted, "position and motor_position are swapped"),
        (-wanted, "one of both counts the other way round (a negative `gear_ratio` turns the motor)"),
        (
            pulleys,
            "motor_position is already divided by the gear ratio, but the motor shaft's angle is wanted",
        ),
        (wanted * gear, "motor_position is multiplied by the gear ratio"),
        (wanted * DEGREES, "motor_position is in degrees, position in rad"),
        (wanted / DEGREES, "position is in degrees, motor_position in rad"),
    ];
    let away = |value: f64| if slope / value > 0.0 { (slope / value).ln().abs() } else { f64::INFINITY };
    let guess = guesses.iter().filter(|(value, _)| near(slope, *value));
    let guess = guess.min_by(|a, b| away(a.0).total_cmp(&away(b.0))).map_or(
        "columns of different joints, another unit, or another gear ratio or pulley radius than described",
        |(_, words)| words,
    );
    Some(
        Diagnostic::error(format!(
            "`{name}/motor_position` turns {slope:.4} times per turn of `{name}/position`, {wanted:.4} times by gear and pulleys: {guess}"
        ))
        .help("angles are in rad, motor_position of the motor shaft; a mapping file exchanges and scales columns"),
    )
}

fn one_way(name: &str, drive: &Drive, seen: &Seen) -> Option<Diagnostic> {
    let extent = seen.elongation;
    let both = extent.high.min(-extent.low);
    if !drive.is_elastic() || both > ONE_WAY * extent.size() {
        return None;
    }
    let torque = |x: f64| drive.cable_stiffness() * drive.load_radius() * x;
    Some(
        Diagnostic::warning(format!(
            "the spring of `{name}` is loaded one way only (described: {:.3} to {:.3} N m): its stiffness holds for this side, and play or a shifted encoder would go unnoticed",
            torque(extent.low),
            torque(extent.high)
        ))
        .help(format!("let the motion pass through postures in which `{name}` is loaded the other way")),
    )
}
