//! What `amend` says about what it did.
use bipedc::amendment::history::{Action, Change, History};
use bipedc::amendment::{Amended, Undone, comments};
use std::fmt::Write;
use std::path::Path;

/// After a step.
pub fn amended(amended: &Amended, robot: &Path) -> String {
    let mut text = String::new();
    for remark in &amended.remarks {
        let _ = writeln!(text, "{remark}");
    }
    for change in &amended.step.changes {
        text += &one(change);
    }
    let filter = amended.step.filter();
    for error in &amended.step.errors {
        let _ = writeln!(text, "error: {}{filter}", comments::error(error));
    }
    if let Some(note) = &amended.step.note {
        let _ = writeln!(text, "note: {note}");
    }
    let robot = robot.display();
    let cutoff = amended.step.cutoff_hz.map_or(String::new(), |hz| format!(" --cutoff {hz}"));
    let _ = writeln!(
        text,
        "wrote {}; step {} in {}\nnext: bipedc compare {robot} other.csv{cutoff}; bipedc generate {robot}; back with bipedc amend {robot} --undo",
        amended.description.display(),
        amended.step.step,
        History::path(&amended.description).display(),
    );
    text
}

fn one(change: &Change) -> String {
    let title = comments::title(&change.effect);
    let mut text = match change.action {
        Action::Added => format!("added {title}\n"),
        Action::Replaced => format!("replaced the parameters of {title}\n"),
        Action::Removed => format!("removed {title}\n"),
    };
    for (name, value) in &change.effect.parameters {
        let unit = change.effect.unit(name);
        let old = change.previous.as_ref().and_then(|effect| effect.parameters.get(name));
        let old = old.map_or_else(String::new, |old| format!("{} → ", comments::rounded(*old)));
        let _ = write!(text, "  {name:18} {old}{}", comments::quantity(*value, unit));
        if let Some([low, high]) = change.ci95.get(name) {
            let _ = write!(text, "  ({})", comments::sure(*low, *high));
        }
        text.push('\n');
    }
    text
}

/// What a dry run would change: lines that go and lines that come.
pub fn difference(amended: &Amended) -> String {
    let (before, after): (Vec<&str>, Vec<&str>) =
        (amended.before.lines().collect(), amended.after.lines().collect());
    let head = before.iter().zip(&after).take_while(|(a, b)| a == b).count();
    let rest = (&before[head..], &after[head..]);
    let tail = rest.0.iter().rev().zip(rest.1.iter().rev()).take_while(|(a, b)| a == b).count();
    let mut text = format!("{} would change at line {}:\n", amended.description.display(), head + 1);
    for line in &rest.0[..rest.0.len() - tail] {
        let _ = writeln!(text, "- {}", comments::one_line(line));
    }
    for line in &rest.1[..rest.1.len() - tail] {
        let _ = writeln!(text, "+ {}", comments::one_line(line));
    }
    text + "nothing was written (--dry-run)\n"
}

/// After taking a step back.
pub fn undone(undone: &Undone) -> String {
    let titles: Vec<String> =
        undone.step.changes.iter().map(|change| comments::title(&change.effect)).collect();
    let (step, titles) = (undone.step.step, titles.join(", "));
    let file = undone.description.display();
    if !undone.restored {
        return format!(
            "{file} is as before step {step} ({titles}) already: the step is marked as taken back\n"
        );
    }
    let mut text = format!(
        "took back step {step} ({titles})\n{file} is as it was before, byte for byte: hash {}\n",
        undone.step.before.hash
    );
    if let Some(copy) = &undone.edited {
        let _ = writeln!(
            text,
            "it had been edited by hand: {} lines of it are gone; the edited text is kept in {}",
            undone.lost.len(),
            copy.display()
        );
    }
    text
}
