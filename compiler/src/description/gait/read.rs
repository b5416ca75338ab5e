//! From a gait file to a checked gait.
use super::dimension::parse_unit;
use super::names::{Names, Of};
use super::phase::{read_phase, read_phase_unit};
use super::phased::{PhasedGait, read_phases};
use super::{Gait, GaitLimits, GaitParameter};
use crate::description::model::{Base, RobotDescription};
use crate::description::settings::table::{Entry, Section};
use crate::description::settings::{Known, check_identifier, effects};
use crate::description::source::{Messages, finish, short};
use crate::description::urdf::read_urdf;
use crate::description::{SourceFiles, load_text};
use bipedc_effects::diagnostic::{Diagnostic, Diagnostics};
use bipedc_effects::effect::formula::Formula;
use bipedc_effects::effect::{Acts, Effect};
use bipedc_effects::spelling;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use toml::de::DeTable;

const KEYS: [&str; 6] = ["gravity", "parameters", "quantities", "phase", "limits", "effect"];

/// Said of a robot with another base than a planar one, and what to do.
pub(crate) const NOT_PLANAR: [&str; 2] =
    ["gaits are those of a robot in the x-z plane", "the robot's base is another one: --base planar"];

/// The file of a gait: `name` is one of `gaits/` beside the description, or a path that ends in `.toml`.
///
/// # Errors
/// No gait of this name.
pub fn gait_path(sources: &SourceFiles, name: &str) -> Result<PathBuf, Diagnostic> {
    if Path::new(name).extension().is_some_and(|ending| ending == "toml") {
        return Ok(PathBuf::from(name));
    }
    let folder = sources.toml_path.parent().unwrap_or(Path::new("")).join("gaits");
    let path = folder.join(format!("{name}.toml"));
    if path.is_file() {
        return Ok(path);
    }
    let listed = std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let toml = listed.filter(|path| path.extension().is_some_and(|ending| ending == "toml"));
    let mut names: Vec<String> =
        toml.filter_map(|path| Some(path.file_stem()?.to_str()?.to_owned())).collect();
    names.sort_unstable();
    let otherwise = || match names.is_empty() {
        true => format!("there are none in {}; docs/gaits.md shows a first one", folder.display()),
        false => format!("gaits: {}", names.join(", ")),
    };
    let help = spelling::suggest(name, names.iter().map(String::as_str), otherwise);
    Err(Diagnostic::error(format!("the robot has no gait `{}`", short(name))).help(help))
}

/// Reads a gait for a robot; `sources` are the robot's own files. Returns the gait and the warnings.
///
/// # Errors
/// Everything that has no meaning, all at once, with line and column.
pub fn read_gait(
    path: &Path,
    sources: &SourceFiles,
    description: &RobotDescription,
) -> Result<(Gait, Vec<Diagnostic>), Diagnostics> {
    parse_gait(path, &text_of(path)?, sources, description)
}

fn text_of(path: &Path) -> Result<String, Diagnostics> {
    if !path.exists() {
        let help = "give the name of a gait in gaits/ beside biped.toml, or a file that is there";
        return Err(Diagnostic::error("there is no such gait").in_file(path).help(help).into());
    }
    load_text(path)
}

/// A gait of one phase or of several.
#[derive(Debug, Clone, PartialEq)]
pub enum AnyGait {
    /// A step is one phase on one point.
    OnePhase(Box<Gait>),
    /// A step is a sequence of phases.
    Phased(PhasedGait),
}

/// As [`read_gait`], of a gait with any number of phases.
///
/// # Errors
/// Everything that has no meaning, all at once, with line and column.
pub fn read_any_gait(
    path: &Path,
    sources: &SourceFiles,
    description: &RobotDescription,
) -> Result<(AnyGait, Vec<Diagnostic>), Diagnostics> {
    parse_any_gait(path, &text_of(path)?, sources, description)
}

/// The same from a text; `path` gives the gait's name and serves messages.
///
/// # Errors
/// As [`read_any_gait`].
pub fn parse_any_gait(
    path: &Path,
    text: &str,
    sources: &SourceFiles,
    description: &RobotDescription,
) -> Result<(AnyGait, Vec<Diagnostic>), Diagnostics> {
    parse(path, text, |name, top, messages| {
        if !is_phased(&top.sections("phase", &mut Messages::new(text, path))) {
            return read(name, top, sources, description, messages)
                .map(|gait| AnyGait::OnePhase(Box::new(gait)));
        }
        let (head, phases) = read_with(top, sources, description, messages, |names, messages| {
            read_phases(top, names, description, messages)
        })?;
        let Head { gravity, parameters, quantities, effects, limits } = head;
        let gait = PhasedGait { name, gravity, parameters, quantities, phases, effects, limits };
        Some(AnyGait::Phased(gait))
    })
}

/// Whether these are the phases of a gait whose controller keeps the limits of the ground: several, or one that ends at a φ instead of by a guard.
fn is_phased(phases: &[Section<'_, '_>]) -> bool {
    match phases {
        [] => false,
        [phase] => phase.has("end") && !phase.has("guard"),
        _ => true,
    }
}

/// A gait of one phase from a text; `path` gives the gait's name and serves messages.
///
/// # Errors
/// As [`read_gait`].
pub fn parse_gait(
    path: &Path,
    text: &str,
    sources: &SourceFiles,
    description: &RobotDescription,
) -> Result<(Gait, Vec<Diagnostic>), Diagnostics> {
    parse(path, text, |name, top, messages| read(name, top, sources, description, messages))
}

fn parse<G>(
    path: &Path,
    text: &str,
    read: impl FnOnce(String, &Section<'_, '_>, &mut Messages<'_>) -> Option<G>,
) -> Result<(G, Vec<Diagnostic>), Diagnostics> {
    let mut messages = Messages::new(text, path);
    let (table, errors) = DeTable::parse_recoverable(text);
    for error in &errors {
        let at = error.span().map(|span| span.start);
        let message = format!("broken TOML: {}", error.message().replace('\n', "; "));
        messages.error(at, message, "docs/gaits.md shows a whole gait");
    }
    let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or("gait").to_owned();
    let gait = match errors.is_empty() {
        true => read(name, &Section::top(table.get_ref()), &mut messages),
        // After a syntax error the recovered table lacks things.
        false => None,
    };
    let warnings = finish(messages.into_list())?;
    gait.map(|gait| (gait, warnings)).ok_or_else(|| {
        // An error was said, or there is a gait; said rather than panicked on.
        Diagnostics(vec![Diagnostic::error("the gait could not be read").in_file(path)])
    })
}

fn read(
    name: String,
    top: &Section<'_, '_>,
    sources: &SourceFiles,
    description: &RobotDescription,
    messages: &mut Messages<'_>,
) -> Option<Gait> {
    let (head, phase) = read_with(top, sources, description, messages, |names, messages| {
        read_phase(top, names, description, messages)
    })?;
    let Head { gravity, parameters, quantities, effects, limits } = head;
    Some(Gait { name, gravity, parameters, quantities, phase, effects, limits })
}

/// What stands beside the phases.
struct Head {
    gravity: Option<f64>,
    parameters: Vec<GaitParameter>,
    quantities: BTreeMap<String, Formula>,
    effects: Vec<Effect>,
    limits: GaitLimits,
}

/// A whole file; `read_phases` knows what phases there can be.
fn read_with<P>(
    top: &Section<'_, '_>,
    sources: &SourceFiles,
    description: &RobotDescription,
    messages: &mut Messages<'_>,
    read_phases: impl FnOnce(&Names, &mut Messages<'_>) -> Option<P>,
) -> Option<(Head, P)> {
    if !matches!(description.base, Base::Planar { .. }) {
        // Formulas would name coordinates that are not there.
        messages.error(top.at, NOT_PLANAR[0], NOT_PLANAR[1]);
        return None;
    }
    top.check_keys(&KEYS, messages);
    let gravity = top.get("gravity").and_then(|entry| positive(&entry, messages));
    let mut names = Names::of_robot(description);
    let parameters = read_parameters(top, &mut names, messages);
    read_phase_unit(top, &mut names, messages);
    read_quantities(top, &mut names, messages);
    let phases = read_phases(&names, messages);
    let mut urdf_messages = Messages::new(&sources.urdf_text, &sources.urdf_path);
    let urdf = read_urdf(&sources.urdf_text, &mut urdf_messages);
    let known = Known { robot: urdf.as_ref() };
    let effects = effects::read_effects(top, known, &description.feet, messages);
    check_effects(top, &effects, messages);
    let limits = read_limits(top, messages);
    if messages.errors() > 0 {
        return None;
    }
    check_use(top, &names, messages);
    names.tell_apart(messages);
    Some((Head { gravity, parameters, quantities: names.quantities, effects, limits }, phases?))
}

/// Effects of a gait make another body: what acts in joints or sensors is no part of zero dynamics.
fn check_effects(top: &Section<'_, '_>, effects: &[Effect], messages: &mut Messages<'_>) {
    let sections = top.sections("effect", messages);
    // Where one was refused, that is said, and which are left is not known.
    for (section, effect) in sections.iter().zip(effects).filter(|_| sections.len() == effects.len()) {
        if effect.kind.law.acts() != Acts::Body {
            let message = format!("`{}` does not make another body of the robot", effect.kind.name);
            let help =
                "a gait's effects are errors of masses, centres and inertias, and payloads: leave it out";
            messages.error(section.at, message, help);
        }
    }
}

/// A number above 0.
pub(super) fn positive(entry: &Entry<'_, '_>, messages: &mut Messages<'_>) -> Option<f64> {
    let value = entry.number(messages)?;
    if value > 0.0 {
        return Some(value);
    }
    messages.error(entry.at, format!("{} = {value} is not possible", entry.name()), "write a number above 0");
    None
}

fn read_limits(top: &Section<'_, '_>, messages: &mut Messages<'_>) -> GaitLimits {
    let Some(section) = top.section("limits", messages) else { return GaitLimits::default() };
    section.check_keys(&["friction"], messages);
    GaitLimits { friction: section.get("friction").and_then(|entry| positive(&entry, messages)) }
}

fn read_parameters(
    top: &Section<'_, '_>,
    names: &mut Names,
    messages: &mut Messages<'_>,
) -> Vec<GaitParameter> {
    let Some(section) = top.section("parameters", messages) else { return Vec::new() };
    let mut found = Vec::new();
    for entry in section.entries() {
        check_identifier(entry.key, "parameter", entry.at, messages);
        let Some(table) = entry.section(format!("[parameters.{}]", short(entry.key)), messages) else {
            continue;
        };
        // One that is refused is a name all the same, of the unit that it states: formulas that have it are not wrong.
        let parameter = read_parameter(entry.key, &table, messages);
        let unit = table.get("unit").and_then(|entry| parse_unit(entry.text()?));
        if let Some(meaning) = names.meaning(entry.key) {
            let message = format!("`{}` means something else already: {meaning}", short(entry.key));
            messages.error(section.key_place(entry.key), message, "choose another name for the parameter");
        }
        names.add(entry.key, Of::Parameter, unit);
        found.extend(parameter);
    }
    found
}

/// Warns of parameters that no formula names.
fn check_use(top: &Section<'_, '_>, names: &Names, messages: &mut Messages<'_>) {
    let Some(section) = top.section("parameters", messages) else { return };
    let used = names.all_used();
    for entry in section.entries().iter().filter(|entry| !used.contains(entry.key)) {
        let message = format!(
            "no formula names the parameter `{}`: whatever its value, steps are the same",
            short(entry.key)
        );
        let help =
            format!("name it in a formula, such as wanted.plus = \"{}\", or remove it", short(entry.key));
        messages.warning(section.key_place(entry.key), message, help);
    }
}

fn read_parameter(
    name: &str,
    section: &Section<'_, '_>,
    messages: &mut Messages<'_>,
) -> Option<GaitParameter> {
    section.check_keys(&["unit", "meaning", "default", "bounds"], messages);
    let unit = read_unit(section, messages)?;
    let meaning = section.string("meaning", messages).map_or_else(String::new, |(text, _)| text);
    let missing = |key: &'static str, help: &str, messages: &mut Messages<'_>| {
        if !section.has(key) {
            messages.error(section.at, format!("`{name}` has no `{key}`"), help);
        }
    };
    missing("default", "add default = 0.4", messages);
    missing("bounds", "add bounds = [0.1, 0.9]", messages);
    let default = section.number("default", messages);
    let bounds = section.get("bounds").and_then(|entry| range(&entry, messages));
    let (default, bounds) = (default?, bounds?);
    if let Some(entry) = section.get("bounds").filter(|_| unit == "rad") {
        check_turns(&entry, &bounds, messages);
    }
    if !(bounds[0]..=bounds[1]).contains(&default) {
        let at = section.get("default").and_then(|entry| entry.at);
        let message = format!(
            "`default` of `{name}`, {default}, lies outside its bounds {} to {}",
            bounds[0], bounds[1]
        );
        messages.error(at, message, "widen the bounds, or choose another default");
        return None;
    }
    Some(GaitParameter { name: name.to_owned(), unit, meaning, default, bounds })
}

/// The `unit` of a section.
pub(super) fn read_unit(section: &Section<'_, '_>, messages: &mut Messages<'_>) -> Option<String> {
    let Some((unit, at)) = section.string("unit", messages) else {
        if !section.has("unit") {
            messages.error(section.at, format!("{} has no `unit`", section.title), "add unit = \"rad\"");
        }
        return None;
    };
    if parse_unit(&unit).is_some() {
        return Some(unit);
    }
    let help = match unit.trim().to_lowercase().as_str() {
        "deg" | "degree" | "degrees" | "°" | "grad" => DEGREES,
        _ => "SI units: rad, m, s, kg, N, J and 1, products like \"N m\", quotients like \"rad/s\"",
    };
    messages.error(at, format!("the unit `{}` is not understood", short(&unit)), help);
    None
}

/// Said of angles that are in degrees, or seem to be.
const DEGREES: &str =
    "SI units, angles in rad: write unit = \"rad\", and every number in rad (1 degree is 0.0174533 rad)";

/// Warns of angles (rad) of more than a turn.
pub(super) fn check_turns(entry: &Entry<'_, '_>, angles: &[f64], messages: &mut Messages<'_>) {
    if angles.iter().any(|angle| angle.abs() > std::f64::consts::TAU) {
        let message = format!("{} = {angles:?} rad is more than a turn: is it in degrees?", entry.name());
        messages.warning(entry.at, message, DEGREES);
    }
}

/// Two numbers, the smaller one first.
pub(super) fn range(entry: &Entry<'_, '_>, messages: &mut Messages<'_>) -> Option<[f64; 2]> {
    let [low, high] = entry.pair(messages)?;
    if low < high {
        return Some([low, high]);
    }
    let message = format!("{} = [{low}, {high}] holds nothing", entry.name());
    messages.error(entry.at, message, "write the smaller number first");
    None
}

fn read_quantities(top: &Section<'_, '_>, names: &mut Names, messages: &mut Messages<'_>) {
    let Some(section) = top.section("quantities", messages) else { return };
    for entry in section.entries() {
        check_identifier(entry.key, "quantity", entry.at, messages);
        if let Some(meaning) = names.meaning(entry.key) {
            let message = format!("`{}` means something else already: {meaning}", short(entry.key));
            messages.error(section.key_place(entry.key), message, "choose another name for the quantity");
        }
        names.add(entry.key, Of::Quantity, None);
    }
    // A quantity may name those below it: what they are is known first.
    for entry in section.entries() {
        let formula = entry.text().map(Formula::parse);
        if let Some(Ok(formula)) = formula {
            names.quantities.insert(entry.key.to_owned(), formula);
        }
    }
    names.settle(&section, messages);
}
