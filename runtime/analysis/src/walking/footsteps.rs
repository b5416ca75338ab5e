//! Where feet step to: repeated steps, or a table of them.
use super::LEGS;
use super::schedule::{Sole, Stance};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics, shorten};
use bipedc_effects::input;
use bipedc_effects::magnitude;
use std::path::Path;

/// Most steps of a walk.
const MOST: usize = 1000;
/// Columns of a table of footsteps; the last one may be left out.
const COLUMNS: [&str; 5] = ["foot", "x", "y", "yaw", "duration"];

/// A foot and where it steps to.
#[derive(Debug, Clone, PartialEq)]
pub struct Footstep {
    /// 0 right, 1 left.
    pub foot: usize,
    /// The middle of its sole.
    pub sole: Sole,
    /// Of the foot in the air, s; `None`: as all steps.
    pub duration: Option<f64>,
    /// Line of the table that says so; `None`: of a sequence.
    pub line: Option<usize>,
}

/// What a step adds to the place of the body.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Advance {
    /// m
    pub forward: f64,
    /// To the left, m. The foot of that side leads with twice as much, the other one joins it.
    pub sideways: f64,
    /// To the left, rad; as `sideways`, or the same for every step (`Sequence::even`).
    pub turn: f64,
}

/// Steps one after the other.
#[derive(Debug, Clone, PartialEq)]
pub struct Sequence {
    /// Of each step but the last one, in which the other foot comes beside the one that stands.
    pub steps: Vec<Advance>,
    /// Distance of the middles of the soles, m.
    pub width: f64,
    /// Every step turns alike: right for feet that come to stand ahead of one another, on the spot toes would meet.
    pub even: bool,
}

impl Sequence {
    /// The steps from the origin, feet beside one another.
    pub fn footsteps(&self) -> Vec<Footstep> {
        let sum = self.steps.iter().fold([0.0; 2], |s, step| [s[0] + step.sideways, s[1] + step.turn]);
        let leads = |sum: f64| usize::from(sum >= 0.0);
        let sides = [leads(sum[0]), leads(if sum[1] == 0.0 { sum[0] } else { sum[1] })];
        let first = if sum[0] == 0.0 { sides[1] } else { sides[0] };
        let (mut x, mut y, mut yaw) = (0.0, 0.0, 0.0);
        let mut found = Vec::with_capacity(self.steps.len());
        for (k, step) in self.steps.iter().enumerate() {
            let foot = (first + k) % 2;
            if k + 1 < self.steps.len() {
                let part = |side: usize| if foot == side { 2.0 } else { 0.0 };
                let lateral = part(sides[0]) * step.sideways;
                let turn = if self.even { step.turn } else { part(sides[1]) * step.turn };
                let heading: f64 = yaw + 0.5 * turn;
                x += step.forward * heading.cos() - lateral * heading.sin();
                y += step.forward * heading.sin() + lateral * heading.cos();
                yaw += turn;
            }
            let body = Sole { place: [x, y], yaw };
            found.push(Footstep {
                foot,
                sole: Stance::about(body, self.width).soles[foot],
                duration: None,
                line: None,
            });
        }
        found
    }
}

/// Reads a table of footsteps: CSV with `foot` (`left` or `right`), `x`, `y` (m, the middle of the sole in the world), `yaw` (rad), and, if it has
/// it, `duration` (s).
///
/// # Errors
/// Everything that is no such table, with line and column.
pub fn read_footsteps(path: &Path) -> Result<Vec<Footstep>, Diagnostics> {
    let cannot = |error: std::io::Error| Diagnostic::error(format!("cannot be read: {error}")).in_file(path);
    let text = input::read_to_string(path).map_err(cannot)?;
    parse_footsteps(&text)
        .map_err(|list| Diagnostics(list.0.into_iter().map(|wrong| wrong.in_file(path)).collect()))
}

pub(super) fn parse_footsteps(text: &str) -> Result<Vec<Footstep>, Diagnostics> {
    let mut lines =
        text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty() && !line.starts_with('#'));
    let (number, head) = lines.next().ok_or_else(|| help(Diagnostic::error("no header")))?;
    let names: Vec<&str> = head.split(',').map(str::trim).collect();
    if names != COLUMNS && names != COLUMNS[..4] {
        let message = format!("the columns are `{}`", shorten(head));
        return Err(help(Diagnostic::error(message).at(number + 1, 1)).into());
    }
    let mut steps = Vec::new();
    let mut wrong = Vec::new();
    for (number, line) in lines {
        match footstep(line, names.len()) {
            Ok(step) => steps.push(Footstep { line: Some(number + 1), ..step }),
            Err((message, column)) => wrong.push(help(Diagnostic::error(message).at(number + 1, column))),
        }
        if steps.len() > MOST || wrong.len() > 20 {
            wrong.push(
                Diagnostic::error(format!("more than {MOST} steps, or too many errors")).at(number + 1, 1),
            );
            break;
        }
    }
    if steps.is_empty() && wrong.is_empty() {
        wrong.push(help(Diagnostic::error("the table has no steps")));
    }
    if wrong.is_empty() { Ok(steps) } else { Err(Diagnostics(wrong)) }
}

fn help(wrong: Diagnostic) -> Diagnostic {
    wrong.help("write `foot,x,y,yaw` or `foot,x,y,yaw,duration`: left or right, m, m, rad, s")
}

/// A row; errors have the number of the field's first letter.
fn footstep(line: &str, columns: usize) -> Result<Footstep, (String, usize)> {
    let fields: Vec<&str> = line.split(',').collect();
    if fields.len() != columns {
        return Err((format!("{} fields, but {columns} columns", fields.len()), 1));
    }
    let column = |k: usize| fields[..k].iter().map(|field| field.chars().count() + 1).sum::<usize>() + 1;
    let number = |k: usize| {
        let text = fields[k].trim();
        let value: f64 =
            text.parse().map_err(|_| (format!("`{}` is no number", shorten(text)), column(k)))?;
        if value.is_finite() && magnitude::refusal(value).is_none() && value.abs() <= 1e4 {
            Ok(value)
        } else {
            Err((format!("{} = {value} is not possible", COLUMNS[k]), column(k)))
        }
    };
    let name = fields[0].trim();
    let foot = LEGS.iter().position(|leg| *leg == name);
    let foot = foot.ok_or_else(|| (format!("`{}` is no foot", shorten(name)), 1))?;
    let sole = Sole { place: [number(1)?, number(2)?], yaw: number(3)? };
    let duration = if columns > 4 && !fields[4].trim().is_empty() { Some(number(4)?) } else { None };
    match duration {
        Some(time) if !(0.05..=60.0).contains(&time) => {
            Err((format!("a step of {time} s is not possible"), column(4)))
        }
        _ => Ok(Footstep { foot, sole, duration, line: None }),
    }
}
