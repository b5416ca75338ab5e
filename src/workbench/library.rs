//! Libraries of gaits: what an earlier run of the same request found is taken over, and the next search begins there.
//!
//! A gait depends on all speeds before it, because each search begins where the one before ended. Its file says in its first line of what request
//! it is; beside it, in `searches`, is where its search ended. Without either of them, or with others, it is found anew.
use super::closed_loop::Tried;
use super::lack::Lack;
use super::optimised::{Asked, OptimisedGait, described};
use super::{OptimiseOptions, Workbench};
use crate::gait::optimise::{Demands, Optimum, least_distance, size};
use crate::simulation::Trial;
use bipedc_compiler::description::gait::AnyGait;
use bipedc_compiler::description::model::RobotDescription;
use bipedc_compiler::robot::fnv1a;
use bipedc_effects::diagnostic::Diagnostic;
use std::path::{Path, PathBuf};

/// The gait file of a speed.
pub fn gait_file(folder: &Path, speed: f64) -> PathBuf {
    folder.join(format!("{speed}.toml"))
}

/// Where the search at a speed ended.
pub fn search_file(folder: &Path, speed: f64) -> PathBuf {
    folder.join("searches").join(format!("{speed}.txt"))
}

/// A hash of robot, form and everything that is asked, up to the speed of this index: equal hashes mean equal gaits.
pub(super) fn identity(
    (description, source): (&RobotDescription, &str),
    start: Option<&AnyGait>,
    options: &OptimiseOptions,
    index: usize,
) -> String {
    let version = env!("CARGO_PKG_VERSION");
    let OptimiseOptions { speeds, coefficients, beginnings, wishes, .. } = options;
    let speeds = &speeds[..=index];
    let asked = format!("{speeds:?}\0{coefficients}\0{beginnings:?}\0{wishes:?}");
    let parts = format!("{version}\0{description:?}\0{source}\0{start:?}\0{asked}");
    format!("{:016x}", fnv1a(&parts))
}

/// Words in the first line of a file of this request.
pub(super) fn mark(identity: &str) -> String {
    format!("request {identity}")
}

/// What is written beside a gait file.
pub(super) fn search_text(identity: &str, gait: &OptimisedGait, optimum: &Optimum) -> String {
    let asked = gait.landing.as_ref().map_or(0.0, |landing| landing.asked);
    let head = "# where the search of a gait ended, for `bipedc gait optimise`;";
    let text = fnv1a(gait.text.as_deref().unwrap_or_default());
    let OptimisedGait { iterations, rounds, impulse, .. } = gait;
    let body =
        format!("run {iterations} {rounds} {asked} {impulse}\ngait {text:016x}\n{}", optimum.to_text());
    format!("{head} {}, numbers {:016x}\n{body}", mark(identity), fnv1a(&body))
}

/// What was written there, if it is whole.
fn intact(search: &str) -> Option<&str> {
    let (head, body) = search.split_once('\n')?;
    head.ends_with(&format!("numbers {:016x}", fnv1a(body))).then_some(body)
}

impl Workbench {
    /// The gait of a speed that an earlier run found, tried once more: this is quick beside a search, and tells everything that was told of it then.
    ///
    /// # Errors
    /// The file is another one than was written: nothing is taken over that nobody found, and nothing overwritten that somebody wrote.
    pub(super) fn taken_over(
        &self,
        asked: &Asked<'_>,
        trial: &Trial,
        index: usize,
    ) -> Result<Option<(OptimisedGait, Optimum)>, Diagnostic> {
        let Some(folder) = asked.options.library.as_deref() else { return Ok(None) };
        let (speed, identity) = (asked.options.speeds[index], asked.identity(index));
        let file = gait_file(folder, speed);
        let files = (own(&file, &identity), own(&search_file(folder, speed), &identity));
        let (Some(text), Some(search)) = files else { return Ok(None) };
        let Some(search) = intact(&search) else { return Ok(None) };
        let written = search.lines().find_map(|line| line.strip_prefix("gait "));
        if written.is_some_and(|written| written != format!("{:016x}", fnv1a(&text))) {
            return Err(was_changed(&file));
        }
        Ok(self.tried_again(asked, trial, (index, &text), search))
    }

    /// What an earlier run wrote, tried once more.
    fn tried_again(
        &self,
        asked: &Asked<'_>,
        trial: &Trial,
        (index, text): (usize, &str),
        search: &str,
    ) -> Option<(OptimisedGait, Optimum)> {
        let speed = asked.options.speeds[index];
        let run = search.lines().find_map(|line| line.strip_prefix("run "))?;
        let numbers: Vec<f64> = run.split(' ').map(|word| word.parse().ok()).collect::<Option<_>>()?;
        let [iterations, rounds, pushed, impulse] = numbers[..] else { return None };
        let optimum = Optimum::from_text(asked.of, search)?;
        let wishes = &asked.options.wishes;
        let usual = wishes.demands(speed, size(asked.of));
        let wished = Demands { impulse, joint: least_distance(asked.of, usual.joint), ..usual };
        let it = Tried { file: asked.file, text, of: asked.of, optimum: &optimum, friction: wished.friction };
        let tried = self.progress.stage("walking", || self.tried(trial, &it));
        let lacking = Lack::of((&wished, wishes.multiplier), &tried).names();
        let gait = OptimisedGait {
            taken_over: true,
            iterations: iterations as usize,
            rounds: rounds as usize,
            impulse,
            closed_loop: Some(tried),
            lacking,
            ..described(asked.of, &optimum, (speed, pushed))
        };
        Some((gait, optimum))
    }
}

/// The text of a gait that was found, with a hash of all that follows in its first line: what was changed since shows.
pub(super) fn sealed(text: &str) -> String {
    match text.split_once('\n') {
        Some((head, rest)) => {
            format!("{}, {}\n{rest}", head.trim_end_matches(BY).trim_end_matches(','), seal(rest) + BY)
        }
        None => text.to_owned(),
    }
}

/// How first lines of found gaits end.
const BY: &str = " by";
/// How they begin.
const FOUND: &str = "# Found";

fn seal(rest: &str) -> String {
    format!("rest {:016x}", fnv1a(rest))
}

/// That a file that is there already is a gait that a search wrote, as it wrote it. Files of earlier versions have no hash: they are taken as they are.
///
/// # Errors
/// It is another file, or was changed since: somebody may want to keep it.
pub fn may_be_replaced(path: &Path) -> Result<(), Diagnostic> {
    // Devices and pipes have nothing to lose, and reading them may never end.
    let Some(_) = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file) else { return Ok(()) };
    let foreign = || {
        let help = "give --out another name, or remove the file; nothing was written";
        Diagnostic::error("is there already, and is no gait that a search wrote").in_file(path).help(help)
    };
    // What cannot be read cannot be told apart.
    let text = std::fs::read_to_string(path).map_err(|_| foreign())?;
    let (head, rest) = text.split_once('\n').unwrap_or((&text, ""));
    match head.starts_with(FOUND) {
        true if head.contains(", rest ") && !head.ends_with(&format!(", {}{BY}", seal(rest))) => {
            Err(was_changed(path))
        }
        true => Ok(()),
        false => Err(foreign()),
    }
}

fn was_changed(path: &Path) -> Diagnostic {
    let message = "is not the gait that was found and written here: it was changed since, or cut off";
    let help = "move it away to have it found anew, or give another --out; nothing was written";
    Diagnostic::error(message).in_file(path).help(help)
}

/// A file whose first line says that it is of this request.
fn own(path: &Path, identity: &str) -> Option<String> {
    // Devices and pipes have nothing to go on from, and reading them may never end.
    std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    let text = std::fs::read_to_string(path).ok()?;
    text.lines().next()?.contains(&mark(identity)).then_some(text)
}
