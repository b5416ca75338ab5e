//! From text to an XML tree with positions, or a message about why it is none.
use crate::description::source::{Messages, short};
use roxmltree::{Document, Error, Node, ParsingOptions};

/// Far above any robot; keeps memory bounded on hostile input.
const NODE_LIMIT: u32 = 2_000_000;
/// URDF itself needs six levels; extension elements (`<gazebo>`) a few more.
const DEPTH_LIMIT: usize = 200;
/// Undeclared name-space prefixes that are tolerated in one file.
const PREFIX_LIMIT: usize = 16;

const XACRO_HELP: &str =
    "run xacro first and use its output: `ros2 run xacro xacro robot.urdf.xacro > robot.urdf`";

/// The text with undeclared prefixes neutralised; same length, so positions stay.
pub(super) fn prepare(text: &str, messages: &mut Messages<'_>) -> Option<String> {
    if let Some(at) = too_deep(text) {
        messages.error(
            Some(at),
            format!("XML elements nested more than {DEPTH_LIMIT} deep"),
            "a URDF needs six levels; remove the nesting",
        );
        return None;
    }
    let mut text = lenient(text);
    for _ in 0..PREFIX_LIMIT {
        // The XML crate refuses undeclared prefixes; old Gazebo extensions use them and other tools load them.
        let Err(Error::UnknownNamespace(prefix, position)) = parse_xml(&text) else {
            return Some(text);
        };
        let at = messages.source.offset(position.row as usize, position.col as usize);
        if prefix == "xacro" {
            messages.error(
                Some(at),
                "this is a xacro file, not a URDF: it has `xacro:` elements",
                XACRO_HELP,
            );
            return None;
        }
        messages.warning(
            Some(at),
            format!("the name-space prefix `{prefix}` is not declared; its elements are ignored"),
            format!("add `xmlns:{prefix}=\"…\"` to <robot>, or remove them"),
        );
        for before in ["<", "</", " "] {
            text = text.replace(&format!("{before}{prefix}:"), &format!("{before}{prefix}_"));
        }
    }
    Some(text)
}

/// Blanks what the XML crate refuses and every robotics tool accepts: `--` within comments, and blank lines
/// before `<?xml … ?>`. The length stays, so positions stay.
fn lenient(text: &str) -> String {
    let mut result = text.as_bytes().to_vec();
    let mut at = 0;
    while let Some(start) = text[at..].find("<!--").map(|start| at + start) {
        let Some(length) = text[start + 4..].find("-->") else { break };
        at = start + 4 + length + 3;
        blank(&mut result[start..at]);
    }
    let body = text.trim_start_matches('\u{feff}').trim_start();
    if body.starts_with("<?xml ")
        && let Some(length) = body.find("?>")
    {
        let start = text.len() - body.len();
        blank(&mut result[start..start + length + 2]);
    }
    // Ranges begin and end at ASCII characters, so what is left is still UTF-8.
    String::from_utf8(result).unwrap_or_else(|_| text.to_string())
}

/// Overwrites with blanks, except line ends.
fn blank(bytes: &mut [u8]) {
    for byte in bytes.iter_mut().filter(|byte| **byte != b'\n') {
        *byte = b' ';
    }
}

/// Parses the XML; the caller knows from [`prepare`] that nesting is harmless.
pub(super) fn parse_xml(text: &str) -> Result<Document<'_>, Error> {
    Document::parse_with_options(
        text,
        ParsingOptions { allow_dtd: false, nodes_limit: NODE_LIMIT, ..ParsingOptions::default() },
    )
}

/// The message for XML that the parser refuses.
pub(super) fn report_broken(error: &Error, messages: &mut Messages<'_>) {
    let position = error.pos();
    let at = messages.source.offset(position.row as usize, position.col as usize);
    let (message, help) = match error {
        Error::DtdDetected => (
            "a DOCTYPE (with entity definitions) is not supported".to_string(),
            "remove the <!DOCTYPE …> and write the values where they are used",
        ),
        Error::NodesLimitReached => {
            (format!("more than {NODE_LIMIT} XML nodes"), "is this a robot? remove what is not its URDF")
        }
        Error::NoRootNode => {
            ("no XML element found".to_string(), "the file must contain <robot name=\"…\">…</robot>")
        }
        error => (
            format!("broken XML: {}", without_position(&error.to_string())),
            "correct the XML here; every <tag> needs its </tag>",
        ),
    };
    messages.error(Some(at), message, help);
}

/// The XML crate ends its messages with the position, which ours have anyway.
fn without_position(message: &str) -> &str {
    let is_position = |end: &str| end.chars().all(|c| c.is_ascii_digit() || c == ':');
    message.rsplit_once(" at ").filter(|(_, end)| is_position(end)).map_or(message, |(start, _)| start)
}

/// Where elements are nested deeper than [`DEPTH_LIMIT`]; a rough scan, before anything recursive runs.
fn too_deep(text: &str) -> Option<usize> {
    let bytes = text.as_bytes();
    let (mut depth, mut at) = (0usize, 0usize);
    while let Some(step) = bytes[at..].iter().position(|&byte| byte == b'<') {
        let open = at + step;
        let rest = &text[open..];
        let skip = |end: &str| rest.find(end).map_or(rest.len(), |length| length + end.len());
        let length = if rest.starts_with("<!--") {
            skip("-->")
        } else if rest.starts_with("<![CDATA[") {
            skip("]]>")
        } else {
            let length = tag_length(rest);
            if rest.starts_with("</") {
                depth = depth.saturating_sub(1);
            } else if !rest.starts_with("<?") && !rest.starts_with("<!") && !rest[..length].ends_with("/>") {
                depth += 1;
            }
            length
        };
        if depth > DEPTH_LIMIT {
            return Some(open);
        }
        at = open + length;
    }
    None
}

/// Length of the tag at the start of `rest`, minding `>` in quotes.
fn tag_length(rest: &str) -> usize {
    let mut quote = None;
    for (at, byte) in rest.bytes().enumerate() {
        match (quote, byte) {
            (None, b'"' | b'\'') => quote = Some(byte),
            (None, b'>') => return at + 1,
            (Some(open), _) if open == byte => quote = None,
            _ => {}
        }
    }
    rest.len()
}

/// Reports what only xacro understands, once; false if there is any.
pub(super) fn check_no_xacro(root: Node<'_, '_>, messages: &mut Messages<'_>) -> bool {
    for node in root.descendants().filter(Node::is_element) {
        if node.tag_name().namespace().is_some_and(|space| space.contains("xacro")) {
            let element = node.tag_name().name();
            messages.error(
                Some(node.range().start),
                format!("`<xacro:{element}>` is not URDF: this is a xacro file"),
                XACRO_HELP,
            );
            return false;
        }
        for attribute in node.attributes() {
            if ["${", "$("].iter().any(|start| attribute.value().contains(start)) {
                let message = format!(
                    "`{}=\"{}\"` is a xacro expression, not a value",
                    attribute.name(),
                    short(attribute.value())
                );
                messages.error(Some(attribute.range().start), message, XACRO_HELP);
                return false;
            }
        }
    }
    true
}
