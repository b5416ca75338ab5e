//! Typed access to TOML tables that reports what is missing, mistyped or unknown, with its place.
use crate::description::source::{Messages, Place, short, suggest};
use bipedc_effects::magnitude;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// The title of the top level.
const TOP: &str = "the top level";

/// "in [base]", "at the top level".
fn inside(title: &str) -> String {
    if title == TOP { format!("at {title}") } else { format!("in {title}") }
}

/// A TOML table with its name for messages.
#[derive(Debug, Clone)]
pub(in crate::description) struct Section<'t, 'i> {
    table: &'t DeTable<'i>,
    /// How messages call it: `[base]`, `[drives.left_knee]`, [`TOP`].
    pub(in crate::description) title: String,
    pub(in crate::description) at: Place,
}

/// A value with its key, place and title.
#[derive(Debug, Clone)]
pub(in crate::description) struct Entry<'t, 'i> {
    pub(in crate::description) key: &'t str,
    pub(in crate::description) at: Place,
    title: String,
    value: &'t DeValue<'i>,
}

impl<'t, 'i> Section<'t, 'i> {
    pub(in crate::description) fn top(table: &'t DeTable<'i>) -> Self {
        Self { table, title: TOP.into(), at: Some(0) }
    }

    /// Reports keys that are not among the known ones.
    pub(in crate::description) fn check_keys(&self, known: &[&'static str], messages: &mut Messages<'_>) {
        for (key, _) in self.table.iter() {
            let written: &str = key.get_ref();
            if !known.contains(&written) {
                messages.error(
                    Some(key.span().start),
                    format!("unknown key `{}` {}", short(written), inside(&self.title)),
                    suggest(written, known.iter().copied(), "known keys"),
                );
            }
        }
    }

    pub(in crate::description) fn has(&self, key: &str) -> bool {
        self.table.contains_key(key)
    }

    /// Where a key stands (not its value).
    pub(in crate::description) fn key_place(&self, key: &str) -> Place {
        self.table.get_key_value(key).map(|(key, _)| key.span().start)
    }

    pub(in crate::description) fn get(&self, key: &'t str) -> Option<Entry<'t, 'i>> {
        let value = self.table.get(key)?;
        Some(Entry { key, at: place(value), title: self.title.clone(), value: value.get_ref() })
    }

    /// All entries in the order of the file.
    pub(in crate::description) fn entries(&self) -> Vec<Entry<'t, 'i>> {
        let mut pairs: Vec<_> = self.table.iter().collect();
        pairs.sort_by_key(|(key, _)| key.span().start);
        let entry = |(key, value): (&'t Spanned<_>, &'t Spanned<DeValue<'i>>)| {
            let key: &'t std::borrow::Cow<'i, str> = key.get_ref();
            Entry { key, at: place(value), title: self.title.clone(), value: value.get_ref() }
        };
        pairs.into_iter().map(entry).collect()
    }

    /// The table under a key.
    pub(in crate::description) fn section(
        &self,
        key: &'t str,
        messages: &mut Messages<'_>,
    ) -> Option<Section<'t, 'i>> {
        self.get(key)?.section(format!("[{key}]"), messages)
    }

    pub(in crate::description) fn string(
        &self,
        key: &'t str,
        messages: &mut Messages<'_>,
    ) -> Option<(String, Place)> {
        let entry = self.get(key)?;
        entry.string(messages).map(|text| (text, entry.at))
    }

    pub(in crate::description) fn number(&self, key: &'t str, messages: &mut Messages<'_>) -> Option<f64> {
        self.get(key)?.number(messages)
    }

    pub(in crate::description) fn boolean(&self, key: &'t str, messages: &mut Messages<'_>) -> Option<bool> {
        let entry = self.get(key)?;
        match entry.value {
            DeValue::Boolean(value) => Some(*value),
            _ => entry.mistyped("true or false", messages),
        }
    }

    pub(in crate::description) fn strings(
        &self,
        key: &'t str,
        messages: &mut Messages<'_>,
    ) -> Option<Vec<(String, Place)>> {
        self.get(key)?.strings(messages)
    }

    /// An array of tables, written `[[key]]` or as inline tables.
    pub(in crate::description) fn sections(
        &self,
        key: &'t str,
        messages: &mut Messages<'_>,
    ) -> Vec<Section<'t, 'i>> {
        let Some(entry) = self.get(key) else { return Vec::new() };
        let title = match self.title.strip_prefix("[[").and_then(|title| title.strip_suffix("]]")) {
            Some(outer) => format!("[[{outer}.{key}]]"),
            None => format!("[[{key}]]"),
        };
        if let DeValue::Table(table) = entry.value {
            // Read as the list of one that was meant, so that nothing else is said to be missing.
            let message = format!("[{key}] is one table of a list");
            messages.error(entry.at, message, format!("write {title}, with two brackets"));
            return vec![Section { table, title, at: entry.at }];
        }
        let Some(items) = entry.items("an array of tables", messages) else { return Vec::new() };
        items.into_iter().filter_map(|item| item.section(title.clone(), messages)).collect()
    }
}

impl<'t, 'i> Entry<'t, 'i> {
    /// "`key` in [section]".
    pub(in crate::description) fn name(&self) -> String {
        format!("`{}` {}", short(self.key), inside(&self.title))
    }

    pub(in crate::description) fn section(
        &self,
        title: String,
        messages: &mut Messages<'_>,
    ) -> Option<Section<'t, 'i>> {
        match self.value {
            DeValue::Table(table) => Some(Section { table, title, at: self.at }),
            _ => self.mistyped("a table", messages),
        }
    }

    pub(in crate::description) fn string(&self, messages: &mut Messages<'_>) -> Option<String> {
        match self.value {
            DeValue::String(text) => Some(text.to_string()),
            _ => self.mistyped("a text in quotes", messages),
        }
    }

    /// The text, if it is one; nothing is reported.
    pub(in crate::description) fn text(&self) -> Option<&'t str> {
        self.value.as_str()
    }

    pub(in crate::description) fn is_table(&self) -> bool {
        matches!(self.value, DeValue::Table(_))
    }

    /// Where the character with this index (from 0) of a text stands in the file.
    pub(in crate::description) fn inside_text(&self, index: usize, messages: &Messages<'_>) -> Place {
        let start = self.at?;
        let raw = messages.source.text.get(start..)?;
        Some(start + raw_offset(raw, index))
    }

    pub(in crate::description) fn number(&self, messages: &mut Messages<'_>) -> Option<f64> {
        let value = match self.value {
            DeValue::Float(value) => value.as_str().parse::<f64>().ok(),
            DeValue::Integer(value) => {
                i64::from_str_radix(value.as_str(), value.radix()).ok().map(|value| value as f64)
            }
            _ => return self.mistyped("a number", messages),
        };
        let Some(value) = value.filter(|value| value.is_finite()) else {
            return self.mistyped("a finite number", messages);
        };
        if let Some((problem, help)) = magnitude::refusal(value) {
            messages.error(self.at, format!("{}: the number {value:e} {problem}", self.name()), help);
            return None;
        }
        Some(value)
    }

    pub(in crate::description) fn vector(&self, messages: &mut Messages<'_>) -> Option<[f64; 3]> {
        let items = self.items("three numbers, such as [0.0, 0.0, -0.1]", messages)?;
        if items.len() != 3 {
            let message = format!("{}: expected three numbers, found {}", self.name(), items.len());
            messages.error(self.at, message, "write [x, y, z]");
            return None;
        }
        let mut numbers = items.iter().map(|item| item.number(messages));
        let all = [numbers.next()??, numbers.next()??, numbers.next()??];
        Some(all)
    }

    /// Two numbers.
    pub(in crate::description) fn pair(&self, messages: &mut Messages<'_>) -> Option<[f64; 2]> {
        let items = self.items("two numbers, such as [0.1, 0.9]", messages)?;
        let [low, high] = items.as_slice() else {
            let message = format!("{}: expected two numbers, found {}", self.name(), items.len());
            messages.error(self.at, message, "write [low, high]");
            return None;
        };
        Some([low.number(messages)?, high.number(messages)?])
    }

    /// Any number of numbers.
    pub(in crate::description) fn numbers(&self, messages: &mut Messages<'_>) -> Option<Vec<f64>> {
        self.items("an array of numbers", messages)?.iter().map(|item| item.number(messages)).collect()
    }

    pub(in crate::description) fn strings(
        &self,
        messages: &mut Messages<'_>,
    ) -> Option<Vec<(String, Place)>> {
        let items = self.items("an array of texts", messages)?;
        Some(items.iter().filter_map(|item| Some((item.string(messages)?, item.at))).collect())
    }

    fn items(&self, expected: &str, messages: &mut Messages<'_>) -> Option<Vec<Entry<'t, 'i>>> {
        let DeValue::Array(array) = self.value else { return self.mistyped(expected, messages) };
        let item = |value: &'t Spanned<DeValue<'i>>| Entry {
            key: self.key,
            at: place(value),
            title: self.title.clone(),
            value: value.get_ref(),
        };
        Some(array.iter().map(item).collect())
    }

    fn mistyped<T>(&self, expected: &str, messages: &mut Messages<'_>) -> Option<T> {
        let found = match self.value {
            DeValue::String(text) => format!("the text \"{}\"", short(text)),
            DeValue::Integer(number) => format!("the number {}", short(number.as_str())),
            DeValue::Float(number) => format!("the number {}", short(number.as_str())),
            DeValue::Boolean(value) => format!("{value}"),
            DeValue::Datetime(_) => "a date".into(),
            DeValue::Array(_) => "an array".into(),
            DeValue::Table(_) => "a table".into(),
        };
        let message = format!("{}: expected {expected}, found {found}", self.name());
        messages.error(self.at, message, format!("write {expected}"));
        None
    }
}

/// Bytes from the opening quote of a TOML text to its character with this index.
fn raw_offset(raw: &str, index: usize) -> usize {
    let multiline = raw.starts_with("\"\"\"") || raw.starts_with("'''");
    let basic = raw.starts_with('"');
    let mut rest = raw.get(if multiline { 3 } else { 1 }..).unwrap_or("");
    if multiline {
        // A line break just after the quotes does not count.
        rest = rest.strip_prefix("\r\n").or_else(|| rest.strip_prefix('\n')).unwrap_or(rest);
    }
    let mut passed = 0;
    while let Some(c) = rest.chars().next() {
        let after = rest.get(c.len_utf8()..).unwrap_or("");
        // A backslash at the end of a line swallows the blanks that follow.
        let continued = basic && c == '\\' && after.starts_with(char::is_whitespace);
        if passed == index && !continued {
            break;
        }
        let length = match after.chars().next() {
            _ if continued => rest.len() - after.trim_start().len(),
            Some('x') if basic && c == '\\' => 4,
            Some('u') if basic && c == '\\' => 6,
            Some('U') if basic && c == '\\' => 10,
            Some(escape) if basic && c == '\\' => 1 + escape.len_utf8(),
            _ => c.len_utf8(),
        };
        rest = rest.get(length..).unwrap_or("");
        passed += usize::from(!continued);
    }
    raw.len() - rest.len()
}

fn place(value: &Spanned<DeValue<'_>>) -> Place {
    Some(value.span().start)
}
