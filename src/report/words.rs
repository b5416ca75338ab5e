//! Sentences that say the same of several rows, said once.
use bipedc_analysis::report::Row;

/// Stands for a number where sentences are compared.
const NUMBER: char = '\u{1}';
/// Spans of more numbers than this say nothing any more: such rows are told one by one.
const MOST_SPANS: usize = 2;

/// Rows of which the same is said, but for numbers.
struct Group<'r> {
    template: String,
    names: Vec<&'r str>,
    /// Per row its numbers, as they are written.
    numbers: Vec<Vec<String>>,
}

/// Sentences of a row that stand in the summary: the strongest. All of them stand beside the row's plots.
const MOST_SENTENCES: usize = 2;

/// What is left in each row: a paragraph for those of which the same is to be said, quiet rows at the end.
pub(super) fn grouped(rows: &[Row]) -> String {
    let mut groups: Vec<Group<'_>> = Vec::new();
    for row in rows.iter().filter(|row| !row.note.is_empty()) {
        let note = row.note.replace(&format!("{}: ", row.name), "");
        let note = note.split(". ").take(MOST_SENTENCES).collect::<Vec<_>>().join(". ");
        let (template, numbers) = taken_apart(&note);
        let same = |group: &&mut Group<'_>| {
            group.template == template && (numbers.len() <= MOST_SPANS || group.numbers[0] == numbers)
        };
        match groups.iter_mut().find(same) {
            Some(group) => {
                group.names.push(&row.name);
                group.numbers.push(numbers);
            }
            None => groups.push(Group { template, names: vec![&row.name], numbers: vec![numbers] }),
        }
    }
    groups.sort_by_key(|group| group.template.starts_with("nothing but noise"));
    let what = if rows.iter().all(|row| row.joint.is_some()) { "joints" } else { "rows" };
    groups.iter().map(|group| group.paragraph(what)).collect::<Vec<_>>().join("\n\n")
}

/// A sentence without its numbers, and these.
fn taken_apart(sentence: &str) -> (String, Vec<String>) {
    let mut numbers = Vec::new();
    let word = |word: &str| {
        let core = word.trim_matches(['(', ')', ',', ';']).trim_end_matches('.');
        if core.is_empty() || core.parse::<f64>().is_err() {
            return word.to_owned();
        }
        numbers.push(core.to_owned());
        word.replacen(core, &NUMBER.to_string(), 1)
    };
    let template = sentence.split(' ').map(word).collect::<Vec<_>>().join(" ");
    (template, numbers)
}

impl Group<'_> {
    fn paragraph(&self, what: &str) -> String {
        let mut words = self.template.clone();
        for place in 0..self.numbers[0].len() {
            words = words.replacen(NUMBER, &self.span(place), 1);
        }
        match self.names.as_slice() {
            [name] => format!("{name}: {words}."),
            names => format!("{} {what}: {words}: {}.", names.len(), names.join(", ")),
        }
    }

    /// From the smallest to the largest number at a place of the sentence.
    fn span(&self, place: usize) -> String {
        let value = |text: &&String| text.parse::<f64>().unwrap_or(f64::NAN);
        let texts = || self.numbers.iter().map(|numbers| &numbers[place]);
        let least = texts().min_by(|a, b| value(a).total_cmp(&value(b)));
        let most = texts().max_by(|a, b| value(a).total_cmp(&value(b)));
        match (least, most) {
            (Some(least), Some(most)) if least != most => format!("{least} to {most}"),
            (Some(one), _) => one.clone(),
            _ => String::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use bipedc_analysis::experiments::Channel;
    use bipedc_analysis::report::Series;

    #[test]
    fn what_is_said_of_several_rows_is_said_once() {
        let row = |name: &str, note: &str| {
            let row = Row::new(name, Channel::Effort, "N m", 0.0, Series::default()).at_joint(name);
            Row { note: note.to_owned(), ..row }
        };
        let rows = [
            row("hip", "hip: nothing but noise is left"),
            row("knee", "knee: it follows velocity (97 % of 3 N m). knee: 1 N m (moving), 2 N m (standing)"),
            row("ankle", "ankle: the error is 1.3 times the noise"),
            row("toe", "toe: nothing but noise is left"),
            row("wrist", "wrist: the error is 1.11 times the noise"),
            row("neck", ""),
            row("jaw", "jaw: 1 N m from 2 to 3"),
            row("ear", "ear: 4 N m from 5 to 6"),
        ];
        let expected = [
            "knee: it follows velocity (97 % of 3 N m). 1 N m (moving), 2 N m (standing).",
            "2 joints: the error is 1.11 to 1.3 times the noise: ankle, wrist.",
            "jaw: 1 N m from 2 to 3.",
            "ear: 4 N m from 5 to 6.",
            "2 joints: nothing but noise is left: hip, toe.",
        ];
        assert_eq!(grouped(&rows), expected.join("\n\n"));
    }
}
