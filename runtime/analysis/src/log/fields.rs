//! Splitting one line at its commas.
use std::ops::Range;

/// Why a line cannot be split.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct QuoteError {
    /// Byte offset of the quote.
    pub offset: usize,
}

/// Writes the byte ranges of the fields of `line` into `fields`, without surrounding blanks and quotes.
///
/// Own code rather than a CSV library: a quote left open must end at its line and not swallow a file of 2 GB,
/// and messages need the exact line and character of each field.
pub(super) fn split(line: &str, fields: &mut Vec<Range<usize>>) -> Result<(), QuoteError> {
    fields.clear();
    let bytes = line.as_bytes();
    let mut start = 0;
    loop {
        while bytes.get(start).is_some_and(|b| matches!(b, b' ' | b'\t')) {
            start += 1;
        }
        let quoted = bytes.get(start) == Some(&b'"');
        let end = if quoted {
            let open = start + 1;
            let close = find(bytes, open, b'"').ok_or(QuoteError { offset: start })?;
            let end = find(bytes, close, b',').unwrap_or(bytes.len());
            if !bytes[close + 1..end].iter().all(u8::is_ascii_whitespace) {
                return Err(QuoteError { offset: close });
            }
            fields.push(open..close);
            end
        } else {
            let end = find(bytes, start, b',').unwrap_or(bytes.len());
            let blanks = bytes[start..end].iter().rev().take_while(|b| b.is_ascii_whitespace()).count();
            fields.push(start..end - blanks);
            end
        };
        if end == bytes.len() {
            return Ok(());
        }
        start = end + 1;
    }
}

fn find(bytes: &[u8], from: usize, wanted: u8) -> Option<usize> {
    bytes[from..].iter().position(|b| *b == wanted).map(|i| from + i)
}

/// The character (from 1) of a byte offset, as editors count it.
pub(super) fn character(line: &str, offset: usize) -> usize {
    line.get(..offset).map_or(offset, |text| text.chars().count()) + 1
}

#[cfg(test)]
mod tests {
    use super::*;

    fn texts(line: &str) -> Result<Vec<&str>, QuoteError> {
        let mut fields = Vec::new();
        split(line, &mut fields)?;
        Ok(fields.into_iter().map(|f| &line[f]).collect())
    }

    #[test]
    fn fields_lose_blanks_and_quotes() {
        assert_eq!(texts(" a , \"b, c\" ,,1e5 ").unwrap(), ["a", "b, c", "", "1e5"]);
        assert_eq!(texts("a,").unwrap(), ["a", ""]);
        assert_eq!(texts("").unwrap(), [""]);
        assert_eq!(texts("\"\"").unwrap(), [""]);
    }

    #[test]
    fn open_quotes_are_refused() {
        assert_eq!(texts("a,\"b,c"), Err(QuoteError { offset: 2 }));
        assert_eq!(texts("\"a\"\"b\""), Err(QuoteError { offset: 2 }));
    }
}
