//! A scenario file with mistakes in it: unknown keys and values of another type are noted and left out, one after the other, so that
//! all are told together, and with them what is wrong about the rest.
use super::file::File;
use super::reading::Reading;
use bipedc_effects::spelling::suggest;
use serde::Deserialize;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer, Error};

/// More mistakes are not looked for.
const MOST: usize = 100;
const KEYS: &str = "docs/simulation.md lists all keys";

/// On the way from the whole file to what is left out.
#[derive(Debug, Clone)]
enum Way {
    Key(String),
    Index(usize),
}

impl Reading<'_> {
    /// The file as far as it can be understood; `None`: not at all, and what was noted says why.
    pub(super) fn file(&mut self, text: &str) -> Option<File> {
        let mut table = match DeTable::parse(text) {
            Ok(table) => table,
            Err(error) => {
                let at = error.span().map_or(0, |span| span.start);
                return self.wrong(at, first_line(&error), KEYS);
            }
        };
        // Tables of which a key was left out: it was not forgotten there.
        let mut torn: Vec<(Range<usize>, String)> = Vec::new();
        for _ in 0..MOST {
            let error = match File::deserialize(Deserializer::from(table.clone())) {
                Ok(file) => return Some(file),
                Err(error) => error,
            };
            let span = error.span().unwrap_or_default();
            let (way, within) = nearest(table.get_ref(), &span);
            let was_there = |(table, key): &(Range<usize>, String)| {
                *table == span && error.message().starts_with(&format!("missing field `{key}`"))
            };
            if !torn.iter().any(was_there) {
                let (message, help) = told(&error, way.last());
                self.wrong::<()>(span.start, message, help);
            }
            if way.is_empty() {
                return None;
            }
            if let Some(Way::Key(key)) = way.last() {
                torn.push((within, key.clone()));
            }
            leave_out(table.get_mut(), &way);
        }
        None
    }
}

/// Where the entry is that an error is about, and the place of the table that it is in.
fn nearest(table: &DeTable<'_>, wanted: &Range<usize>) -> (Vec<Way>, Range<usize>) {
    let mut best = Best { size: usize::MAX, way: Vec::new(), within: 0..0 };
    best.look(table, &(0..0), wanted, &mut Vec::new());
    (best.way, best.within)
}

struct Best {
    size: usize,
    way: Vec<Way>,
    within: Range<usize>,
}

impl Best {
    /// The smallest one that holds what is wanted; of equals the deepest.
    fn look(&mut self, table: &DeTable<'_>, own: &Range<usize>, wanted: &Range<usize>, way: &mut Vec<Way>) {
        for (key, value) in table.iter() {
            way.push(Way::Key(key.get_ref().to_string()));
            if key.span() == *wanted {
                self.offer(0, way, own);
            }
            self.value(value, own, wanted, way);
            way.pop();
        }
    }

    fn value(
        &mut self,
        value: &Spanned<DeValue<'_>>,
        own: &Range<usize>,
        wanted: &Range<usize>,
        way: &mut Vec<Way>,
    ) {
        let span = value.span();
        if span.start <= wanted.start && span.end >= wanted.end {
            self.offer(span.len(), way, own);
        }
        match value.get_ref() {
            DeValue::Table(table) => self.look(table, &span, wanted, way),
            DeValue::Array(list) => {
                // Of a list of numbers all goes, of a list of tables what is wrong.
                for (index, element) in list.iter().enumerate().filter(|(_, e)| e.get_ref().is_table()) {
                    way.push(Way::Index(index));
                    self.value(element, own, wanted, way);
                    way.pop();
                }
            }
            _ => {}
        }
    }

    fn offer(&mut self, size: usize, way: &[Way], within: &Range<usize>) {
        if size <= self.size {
            *self = Self { size, way: way.to_vec(), within: within.clone() };
        }
    }
}

fn leave_out(table: &mut DeTable<'_>, way: &[Way]) {
    let Some((Way::Key(key), rest)) = way.split_first() else { return };
    if rest.is_empty() {
        table.remove(key.as_str());
        return;
    }
    match (table.get_mut(key.as_str()).map(Spanned::get_mut), rest) {
        (Some(DeValue::Table(inner)), rest) => leave_out(inner, rest),
        (Some(DeValue::Array(list)), [Way::Index(index)]) => {
            let kept =
                list.iter().enumerate().filter(|(k, _)| k != index).map(|(_, element)| element.clone());
            *list = kept.collect();
        }
        (Some(DeValue::Array(list)), [Way::Index(index), rest @ ..]) => {
            if let Some(DeValue::Table(inner)) = list.get_mut(*index).map(Spanned::get_mut) {
                leave_out(inner, rest);
            }
        }
        _ => {}
    }
}

fn first_line(error: &Error) -> String {
    error.message().lines().next().unwrap_or("broken TOML").to_owned()
}

/// What is wrong and what to do, in the words of this file's readers.
fn told(error: &Error, way: Option<&Way>) -> (String, String) {
    let message = first_line(error);
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).collect();
    if let (true, Some((key, known))) = (message.starts_with("unknown field"), quoted.split_first()) {
        let help = suggest(key, known.iter().copied(), || format!("keys here: {}", known.join(", ")));
        return (format!("unknown key `{key}`"), help);
    }
    if let (true, Some(key)) = (message.starts_with("missing field"), quoted.first()) {
        return (format!("`{key}` is missing"), KEYS.to_owned());
    }
    let plain = [
        ("f64", "a number"),
        ("u64", "a whole number"),
        ("u32", "a whole number"),
        ("i64", "a whole number"),
    ];
    let typed = message.rsplit_once("expected ").map(|(found, wanted)| {
        let wanted = plain.iter().find(|(rust, _)| *rust == wanted).map_or(wanted, |(_, words)| *words);
        format!("{found}expected {wanted}")
    });
    let message = typed.unwrap_or(message);
    match way {
        Some(Way::Key(key)) => (format!("`{key}`: {message}"), KEYS.to_owned()),
        _ => (message, KEYS.to_owned()),
    }
}
