//! An inventory for people.
use super::{ColumnFound, Inventory, JointChannels, RobotChannels, Sampling};
use crate::table::table;
use bipedc_analysis::log::names::{JOINT_QUANTITIES, list};
use std::fmt;

/// Two turns: few joints have more, rad.
const LARGEST_SWING: f64 = 4.0 * std::f64::consts::PI;

impl fmt::Display for Inventory {
    /// What the file is, how it is sampled, its columns, what the robot's joints have. Warnings and the proposed mapping are not
    /// part of it.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let what = match self.kind {
            "time" => "a log over time",
            "posture" => "a table of postures",
            _ => "a table of impacts",
        };
        writeln!(f, "{}: {what}, {} rows, {} columns", self.file, self.rows, self.columns.len())?;
        if !self.has_header {
            writeln!(f, "no header row: joint states as `ros2 topic echo --csv` prints them")?;
        }
        if let Some(sampling) = &self.sampling {
            write_sampling(f, sampling)?;
        }
        writeln!(f, "\n{}", columns(&self.columns))?;
        if let Some(robot) = &self.robot {
            write_robot(f, robot)?;
        }
        for assumption in &self.proposal.assumptions {
            writeln!(f, "to be checked: {assumption}")?;
        }
        for doubt in &self.proposal.doubts {
            writeln!(f, "left open: {doubt}")?;
        }
        Ok(())
    }
}

fn write_sampling(f: &mut fmt::Formatter<'_>, s: &Sampling) -> fmt::Result {
    let span = format!("{} s to {} s", clock(s.from_s), clock(s.to_s));
    writeln!(f, "time: {} s ({span}), in column `{}`", short(s.duration_s), s.column)?;
    let even = match s.uneven {
        0 => "all steps within 1 % of it".to_owned(),
        n => format!(
            "{n} {} more than 1 % off, from {} s to {} s",
            if n == 1 { "step is" } else { "steps are" },
            short(s.shortest_s),
            short(s.longest_s)
        ),
    };
    writeln!(f, "sampling: {} Hz (median step {} s; {even})", short(s.rate_hz), short(s.step_s))?;
    match s.largest_gap {
        None => writeln!(f, "gaps: none"),
        Some(gap) => writeln!(
            f,
            "gaps: {} of more than 3.5 steps, the longest {} s, from {} s on (line {})",
            s.gaps,
            short(gap.length_s),
            clock(gap.from_s),
            gap.line
        ),
    }?;
    let stamps = |count: usize, what: &str, line: Option<usize>| {
        line.map(|line| format!("{count} {what}, first in line {line}"))
    };
    let odd =
        [stamps(s.doubled, "doubled", s.first_doubled), stamps(s.backward, "running back", s.first_backward)];
    let odd: Vec<String> = odd.into_iter().flatten().collect();
    let stamps = if odd.is_empty() { "all increase".to_owned() } else { odd.join("; ") };
    writeln!(f, "time stamps: {stamps}")
}

fn columns(columns: &[ColumnFound]) -> String {
    let row = |column: &ColumnFound| {
        let taken = match (&column.proposed, &column.taken_as) {
            (Some(proposed), _) => format!("could be {proposed}"),
            (None, Some(taken)) if *taken == column.name => "understood".to_owned(),
            (None, Some(taken)) => taken.clone(),
            (None, None) => "not understood".to_owned(),
        };
        let value = |x: Option<f64>| x.map_or_else(|| "-".to_owned(), short);
        let unit = column.unit.clone().unwrap_or_default();
        vec![column.name.clone(), taken, unit, notes(column), value(column.least), value(column.most)]
    };
    let mut head = vec!["column", "is", "unit", "notes", "least", "most"];
    let mut rows: Vec<Vec<String>> = columns.iter().map(row).collect();
    let mut left = 4;
    if rows.iter().all(|row| row[3].is_empty()) {
        head.remove(3);
        rows.iter_mut().for_each(|row| drop(row.remove(3)));
        left = 3;
    }
    table(&head, rows, left)
}

/// Of a joint's position, rad.
fn swing(column: &ColumnFound) -> Option<f64> {
    let name = column.proposed.as_ref().or(column.taken_as.as_ref())?;
    let turns = name.ends_with("/position") && column.unit.as_deref() == Some("rad");
    turns.then_some(column.most? - column.least?)
}

fn notes(column: &ColumnFound) -> String {
    let mut notes = Vec::new();
    if let Some(span) = swing(column).filter(|span| *span > LARGEST_SWING) {
        notes.push(format!("swings through {} rad: degrees?", short(span)));
    }
    if column.constant {
        notes.push("never changes".to_owned());
    }
    if let Some(line) = column.first_missing {
        notes.push(format!("{} missing, first in line {line}", column.missing));
    }
    if let Some(unusable) = &column.unusable {
        let (rows, line, example) = (unusable.rows, unusable.line, &unusable.example);
        notes.push(format!("{rows} no usable numbers, first `{example}` in line {line}"));
    }
    notes.join("; ")
}

fn write_robot(f: &mut fmt::Formatter<'_>, robot: &RobotChannels) -> fmt::Result {
    let all = robot.joints.len();
    writeln!(f, "joints of {}:", robot.robot)?;
    for quantity in JOINT_QUANTITIES {
        let having = |list: fn(&JointChannels) -> &Vec<&'static str>| {
            robot.joints.iter().filter(|joint| list(joint).contains(&quantity)).count()
        };
        let (has, proposed) = (having(|joint| &joint.has), having(|joint| &joint.proposed));
        if has + proposed == 0 {
            continue;
        }
        let with =
            if proposed > 0 { format!(", {proposed} more with the proposed mapping") } else { String::new() };
        let lacks =
            |joint: &&JointChannels| !joint.has.contains(&quantity) && !joint.proposed.contains(&quantity);
        let lacking: Vec<&str> = robot.joints.iter().filter(lacks).map(|joint| joint.name.as_str()).collect();
        let without = if lacking.is_empty() { String::new() } else { format!("; not {}", list(lacking, 40)) };
        writeln!(f, "  {quantity}: {has} of {all}{with}{without}")?;
    }
    if robot.missing.len() == all {
        writeln!(f, "  no column is of any of them")?;
    } else if !robot.missing.is_empty() {
        writeln!(f, "  nothing of {}", list(robot.missing.iter().map(String::as_str), 40))?;
    }
    for unknown in &robot.unknown {
        if unknown.held {
            writeln!(
                f,
                "  `{}` does not move in the description (fixed, or locked in biped.toml): not read",
                unknown.name
            )?;
            continue;
        }
        let meant = unknown.meant.as_ref().map(|meant| format!(": did you mean `{meant}`?"));
        writeln!(f, "  the robot has no `{}`{}", unknown.name, meant.unwrap_or_default())?;
    }
    Ok(())
}

/// A time stamp. Clocks that began in 1970 have more digits before the point than count elsewhere; microseconds are what a
/// number can tell of them.
fn clock(x: f64) -> String {
    if x.abs() < 1e5 {
        return short(x);
    }
    let text = format!("{x:.6}");
    text.trim_end_matches('0').trim_end_matches('.').to_owned()
}

/// Six digits that count, without zeros behind.
fn short(x: f64) -> String {
    if x != 0.0 && !(1e-6..1e15).contains(&x.abs()) {
        return format!("{x:.3e}");
    }
    let digits = if x == 0.0 { 0 } else { (5 - x.abs().log10().floor() as i32).clamp(0, 9) as usize };
    let text = format!("{x:.digits$}");
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".to_owned() } else { text.to_owned() }
}

#[cfg(test)]
mod tests {
    use super::{clock, short};

    #[test]
    fn clocks_keep_their_fractions() {
        assert_eq!(clock(1_764_000_000.123_456), "1764000000.123456");
        assert_eq!(clock(1_764_000_000_123.0 * 1e-3), "1764000000.123");
        assert_eq!((clock(1_764_000_016.0), clock(16.5)), ("1764000016".to_owned(), short(16.5)));
    }
}
