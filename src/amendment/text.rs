//! `[[effect]]` tables as text: only the bytes of the change are touched, so that comments, order, spacing and line
//! ends of everything else stay by construction. The crate `toml_edit` says where tables and values stand.
use super::comments::{self, COMMENT};
use bipedc_effects::diagnostic::Diagnostic;
use bipedc_effects::effect::{Effect, Law, Role};
use std::collections::BTreeMap;
use std::ops::Range;
use toml_edit::{Document, Item, Table, Value};

/// An effect to be written, with what stands in the comments.
#[derive(Debug, Clone)]
pub struct Written<'a> {
    /// Kind, place and numbers.
    pub effect: &'a Effect,
    /// 95 % confidence intervals by parameter, for the comments behind them.
    pub ci95: &'a BTreeMap<String, [f64; 2]>,
    /// The comment above the table, without `#`; one line.
    pub comment: &'a str,
}

/// A table of the text.
#[derive(Debug)]
struct Place {
    /// From the first byte of its header's line to behind its last value's line.
    lines: Range<usize>,
    /// Values by key, with `parameters.k` for those of a formula.
    values: BTreeMap<String, Range<usize>>,
}

/// Appends the effect as a table of its own.
///
/// # Errors
/// Effects written as an inline array, which nothing can be appended to.
pub fn add(text: &str, written: &Written<'_>) -> Result<String, Diagnostic> {
    tables(text)?;
    let end = line_end(text);
    let gap = match text {
        "" => String::new(),
        text if text.ends_with("\n\n") || text.ends_with("\n\r\n") => String::new(),
        text if text.ends_with('\n') => end.to_owned(),
        _ => end.repeat(2),
    };
    Ok(format!("{text}{gap}{}", block(written, end)))
}

/// Gives the effect of the same kind at the same place these parameters. What is not given stays, and so do
/// comments. A formula is written anew as a whole.
///
/// # Errors
/// No such effect, or several.
pub fn replace(text: &str, written: &Written<'_>) -> Result<String, Diagnostic> {
    let place = find(text, written.effect)?;
    let end = line_end(text);
    let own = own_comment(text, place.lines.start);
    if written.effect.kind.law == Law::Formula {
        let start = own.map_or(place.lines.start, |own| own.start);
        return Ok(splice(text, vec![(start..place.lines.end, block(written, end))]));
    }
    let at = own.unwrap_or(place.lines.start..place.lines.start);
    let mut edits = vec![(at, format!("# {}{end}", written.comment))];
    let mut new_lines = String::new();
    for (name, value) in &written.effect.parameters {
        match place.values.get(name) {
            Some(range) => {
                edits.push((range.clone(), comments::number(*value)));
                edits.extend(new_comment(text, range.end, written, name));
            }
            None => new_lines += &parameter_line(written, name, *value, end),
        }
    }
    if !new_lines.is_empty() && !text[..place.lines.end].ends_with('\n') {
        new_lines.insert_str(0, end);
    }
    edits.push((place.lines.end..place.lines.end, new_lines));
    Ok(splice(text, edits))
}

/// Takes the effect of this kind at this place out.
///
/// # Errors
/// No such effect, or several.
pub fn remove(text: &str, effect: &Effect) -> Result<String, Diagnostic> {
    let place = find(text, effect)?;
    let mut start = own_comment(text, place.lines.start).map_or(place.lines.start, |own| own.start);
    // The empty line that set it apart goes as well.
    for gap in ["\r\n", "\n"] {
        let before = &text[..start];
        if before.ends_with(&format!("\n{gap}")) {
            start -= gap.len();
            break;
        }
    }
    Ok(splice(text, vec![(start..place.lines.end, String::new())]))
}

/// How many effects of this kind stand at this place.
///
/// # Errors
/// Effects written as an inline array.
pub fn count(text: &str, effect: &Effect) -> Result<usize, Diagnostic> {
    Ok(tables(text)?.iter().filter(|table| is_same(table, effect)).count())
}

/// `\r\n` if the first line ends so.
fn line_end(text: &str) -> &'static str {
    match text.find('\n') {
        Some(at) if text[..at].ends_with('\r') => "\r\n",
        _ => "\n",
    }
}

fn find(text: &str, effect: &Effect) -> Result<Place, Diagnostic> {
    let tables = tables(text)?;
    let mut same = tables.iter().filter(|table| is_same(table, effect));
    match (same.next(), same.next()) {
        (Some(table), None) => Ok(place(text, table)),
        (None, _) => Err(Diagnostic::error(format!("the description has no {}", comments::title(effect)))
            .help("`bipedc history` lists what was added; kind and place must be the same")),
        (Some(_), Some(_)) => {
            Err(Diagnostic::error(format!("the description has several: {}", comments::title(effect)))
                .help("--add adds one more; to change one of them edit the description"))
        }
    }
}

fn tables(text: &str) -> Result<Vec<Table>, Diagnostic> {
    let document = Document::parse(text).map_err(|error| {
        Diagnostic::error(format!("broken TOML: {}", error.message())).help("run bipedc check")
    })?;
    match document.as_table().get("effect") {
        None => Ok(Vec::new()),
        Some(Item::ArrayOfTables(array)) => Ok(array.iter().cloned().collect()),
        Some(_) => Err(Diagnostic::error("`effect` is written as an array in one line: effect = [ … ]")
            .help("write each effect as a table under [[effect]]; then amend can add to them")),
    }
}

fn is_same(table: &Table, effect: &Effect) -> bool {
    let text = |key: &str| table.get(key).and_then(Item::as_str);
    if text("kind") != Some(effect.kind.name) {
        return false;
    }
    // Names of formulas are unique in a description.
    if effect.name.is_some() {
        return text("name") == effect.name.as_deref();
    }
    let at = &effect.location;
    let places =
        [("joint", &at.joint), ("other_joint", &at.other_joint), ("link", &at.link), ("sensor", &at.sensor)];
    text("name").is_none() && places.iter().all(|(key, place)| text(key) == place.as_deref())
}

fn place(text: &str, table: &Table) -> Place {
    let header = table.span().unwrap_or(0..0);
    let start = text[..header.start].rfind('\n').map_or(0, |at| at + 1);
    let mut values = BTreeMap::new();
    let mut last = header.end;
    for (key, item) in table {
        collect(key, item, &mut values, &mut last);
    }
    let end = text[last..].find('\n').map_or(text.len(), |at| last + at + 1);
    Place { lines: start..end, values }
}

/// The places of an item's values; `last` becomes the end of the last one.
fn collect(key: &str, item: &Item, values: &mut BTreeMap<String, Range<usize>>, last: &mut usize) {
    if let Item::Table(table) = item {
        *last = (*last).max(table.span().map_or(0, |span| span.end));
        for (inner, item) in table {
            collect(&format!("{key}.{inner}"), item, values, last);
        }
    } else if let Some(span) = item.span() {
        *last = (*last).max(span.end);
        values.insert(key.to_owned(), span);
    }
}

/// The line above the table if an earlier amend wrote it.
fn own_comment(text: &str, header: usize) -> Option<Range<usize>> {
    let before = text[..header].strip_suffix('\n')?;
    let start = before.rfind('\n').map_or(0, |at| at + 1);
    before[start..].starts_with(&format!("# {COMMENT}")).then_some(start..header)
}

/// The unit and interval behind a value, unless the user wrote something else there.
fn new_comment(
    text: &str,
    value_end: usize,
    written: &Written<'_>,
    name: &str,
) -> Option<(Range<usize>, String)> {
    let rest = text[value_end..].lines().next().unwrap_or("");
    let said = rest.trim().trim_start_matches('#').trim_start();
    let unit = comments::unit_words(written.effect.unit(name));
    let is_own = said.is_empty() || said == unit || said.starts_with(&format!("{unit}, 95 %"));
    is_own.then(|| {
        (value_end..value_end + rest.len(), comments::behind(written.effect, name, written.ci95.get(name)))
    })
}

fn splice(text: &str, mut edits: Vec<(Range<usize>, String)>) -> String {
    // Stable: an insertion at the end of a replaced range comes after it.
    edits.sort_by_key(|(range, _)| (range.start, range.end));
    let (mut result, mut done) = (String::with_capacity(text.len() + 256), 0);
    for (range, new) in edits {
        result += &text[done..range.start];
        result += &new;
        done = range.end;
    }
    result + &text[done..]
}

/// The whole table, ending with a line end.
fn block(written: &Written<'_>, end: &str) -> String {
    let effect = written.effect;
    let mut lines = vec![format!("# {}", written.comment), "[[effect]]".to_owned()];
    let at = &effect.location;
    let texts = [
        ("kind", Some(effect.kind.name)),
        ("name", effect.name.as_deref()),
        ("joint", at.joint.as_deref()),
        ("other_joint", at.other_joint.as_deref()),
        ("link", at.link.as_deref()),
        ("sensor", at.sensor.as_deref()),
        ("torque", effect.torque.as_deref()),
    ];
    let texts = texts.iter().filter_map(|(key, text)| Some((key, text.as_ref()?)));
    lines.extend(texts.map(|(key, text)| format!("{key} = {}", quoted(text))));
    let mut text: String = lines.iter().map(|line| format!("{line}{end}")).collect();
    for name in in_order(effect) {
        text += &parameter_line(written, &name, effect.parameters[&name], end);
    }
    text
}

/// Names of the given parameters in the order of the library, then the author's own.
fn in_order(effect: &Effect) -> Vec<String> {
    let library = effect.kind.parameters;
    let known = library.iter().map(|parameter| parameter.name.to_owned());
    let known = known.filter(|name| effect.parameters.contains_key(name));
    let own = effect.parameters.keys().filter(|name| library.iter().all(|p| p.name != name.as_str()));
    known.chain(own.cloned()).collect()
}

fn parameter_line(written: &Written<'_>, name: &str, value: f64, end: &str) -> String {
    let effect = written.effect;
    let is_setting = || {
        let known = effect.kind.parameter(name);
        known.is_some_and(|parameter| matches!(parameter.role, Role::Setting(_)))
    };
    let number = comments::number(value);
    let comment = comments::behind(effect, name, written.ci95.get(name));
    if effect.kind.law != Law::Formula || is_setting() {
        return format!("{} = {number}{comment}{end}", key(name));
    }
    let mut inner = vec![format!("value = {number}")];
    if let Some(own) = effect.own.get(name) {
        inner.push(format!("unit = {}", quoted(&own.unit)));
        inner.extend(own.min.map(|min| format!("min = {}", comments::number(min))));
        inner.extend(own.max.map(|max| format!("max = {}", comments::number(max))));
    }
    // The unit stands in the table already.
    let comment = match written.ci95.get(name) {
        Some(_) => comment,
        None => String::new(),
    };
    format!("parameters.{} = {{ {} }}{comment}{end}", key(name), inner.join(", "))
}

fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

/// Bare where TOML allows it.
fn key(name: &str) -> String {
    let bare = !name.is_empty() && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    if bare { name.to_owned() } else { quoted(name) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_effects::effect::{Location, OwnParameter, kinds};

    static NONE: BTreeMap<String, [f64; 2]> = BTreeMap::new();

    fn written<'a>(effect: &'a Effect, comment: &'a str) -> Written<'a> {
        Written { effect, ci95: &NONE, comment }
    }

    fn friction(torque: f64) -> Effect {
        Effect::new(&kinds::COULOMB_FRICTION, Location::joint("knee"), &[("torque", torque)])
    }

    #[test]
    fn everything_but_the_change_stays() {
        let text = "# mine\nname = \"x\"   # odd   spacing\n\n[base]\nkind='fixed'";
        let added = add(text, &written(&friction(0.5), "note")).unwrap();
        let block =
            "# note\n[[effect]]\nkind = \"coulomb_friction\"\njoint = \"knee\"\ntorque = 0.5  # N m\n";
        assert_eq!(added, format!("{text}\n\n{block}"));
        assert_eq!(count(&added, &friction(0.0)).unwrap(), 1);
    }

    #[test]
    fn replacing_keeps_settings_comments_and_what_follows() {
        let head = "[[effect]]   # mine\nkind = \"coulomb_friction\"\njoint = 'knee'\n";
        let text = format!(
            "{head}torque = 0.5  # guessed\nsmoothing = 0.1\n\n# after\n[drives.knee]\nkind = \"stiff\"\n"
        );
        let replaced = replace(&text, &written(&friction(0.75), "bipedc amend, a")).unwrap();
        let expected = text.replace("0.5", "0.75");
        assert_eq!(replaced, format!("# bipedc amend, a\n{expected}"));
        let again = replace(&replaced, &written(&friction(0.8), "bipedc amend, b")).unwrap();
        assert_eq!(again, format!("# bipedc amend, b\n{}", text.replace("0.5", "0.8")));
    }

    #[test]
    fn new_parameters_come_behind_the_others() {
        let text =
            "[[effect]]\nkind = \"coulomb_friction\"\njoint = \"knee\"\ntorque = 0.5 # N m, 95 %: 0 to 1";
        let mut effect = friction(0.6);
        effect.parameters.insert("smoothing".to_owned(), 0.1);
        let replaced = replace(text, &written(&effect, "bipedc amend, a")).unwrap();
        let expected = "# bipedc amend, a\n[[effect]]\nkind = \"coulomb_friction\"\njoint = \"knee\"\ntorque = 0.6  # N m\nsmoothing = 0.1  # rad/s\n";
        assert_eq!(replaced, expected);
    }

    #[test]
    fn line_ends_of_windows_stay() {
        let text = "name = \"x\"\r\n";
        let added = add(text, &written(&friction(0.5), "bipedc amend, a")).unwrap();
        assert_eq!(added.matches('\n').count(), added.matches("\r\n").count(), "{added:?}");
        let replaced = replace(&added, &written(&friction(0.25), "bipedc amend, b")).unwrap();
        assert_eq!(replaced, added.replace("0.5", "0.25").replace("amend, a", "amend, b"));
        assert_eq!(remove(&replaced, &friction(0.0)).unwrap(), text);
    }

    #[test]
    fn a_formula_is_written_and_replaced_as_a_whole() {
        let mut effect = Effect::new(&kinds::FORMULA, Location::joint("knee"), &[("k", 0.5)]);
        effect.name = Some("cable".to_owned());
        effect.torque = Some("k * sin(3 * position) # \\ \"".to_owned());
        let own = OwnParameter { unit: "N m".to_owned(), min: Some(0.0), max: None };
        effect.own.insert("k".to_owned(), own);
        let text = add("", &written(&effect, "bipedc amend, a")).unwrap();
        let document = Document::parse(text.as_str()).unwrap();
        let table = document.as_table()["effect"].as_array_of_tables().unwrap().get(0).unwrap();
        assert_eq!(table["torque"].as_str(), effect.torque.as_deref());
        assert_eq!(table["parameters"]["k"]["unit"].as_str(), Some("N m"));
        let dotted = text.replace(
            "parameters.k = { value = 0.5, unit = \"N m\", min = 0.0 }",
            "[effect.parameters.k]\nvalue = 0.5",
        );
        assert_ne!(dotted, text);
        let followed = format!("{dotted}\n[base]\n");
        assert_eq!(
            replace(&followed, &written(&effect, "bipedc amend, a")).unwrap(),
            format!("{text}\n[base]\n")
        );
        assert_eq!(remove(&dotted, &effect).unwrap(), "");
    }

    #[test]
    fn inline_arrays_are_refused_and_twins_are_not_guessed() {
        let inline = "effect = [{ kind = \"coulomb_friction\", joint = \"knee\", torque = 1.0 }]\n";
        assert!(add(inline, &written(&friction(0.5), "a")).is_err());
        let one = add("", &written(&friction(0.5), "a")).unwrap();
        let two = add(&one, &written(&friction(0.5), "a")).unwrap();
        assert!(replace(&two, &written(&friction(0.6), "a")).is_err());
        assert!(remove("", &friction(0.6)).is_err());
    }

    /// Broken and odd texts are refused or amended, and never panic.
    #[test]
    fn no_text_makes_it_panic() {
        let text = "\u{feff}# ü\r\n[[effect]] # ä\r\nkind = 'coulomb_friction'\njoint = \"knee\"\ntorque = 1e0 # N m\n\
                    [effect.more.x]\ny = [{ z = '''\n''' }]\n[[effect]]\nkind = 3\n[base]\nkind = 'fixed'\n";
        let effect = friction(0.5);
        let try_all = |text: &str| {
            let written = written(&effect, "bipedc amend, a");
            let results = [add(text, &written), replace(text, &written), remove(text, &effect)];
            results.into_iter().filter(Result::is_ok).count()
        };
        assert_eq!(try_all(text), 3);
        for cut in (0..text.len()).filter(|&cut| text.is_char_boundary(cut)) {
            try_all(&text[..cut]);
            try_all(&text[cut..]);
            for inserted in ["\n", "[", "]", "=", "\"", "#", "'", ".", "\r", "é"] {
                try_all(&format!("{}{inserted}{}", &text[..cut], &text[cut..]));
            }
        }
    }
}
