//! An XML element that is written out, one element per line.

/// Name, attributes in their order, children.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    name: &'static str,
    attributes: Vec<(&'static str, String)>,
    children: Vec<Element>,
}

impl Element {
    /// Without attributes and children.
    pub fn new(name: &'static str) -> Self {
        Self { name, attributes: Vec::new(), children: Vec::new() }
    }

    /// With one more attribute.
    #[must_use]
    pub fn with(mut self, key: &'static str, value: &str) -> Self {
        self.attributes.push((key, value.to_owned()));
        self
    }

    /// Adds a child.
    pub fn add(&mut self, child: Element) {
        self.children.push(child);
    }

    /// As it stands in a file.
    pub fn text(&self) -> String {
        let mut text = String::new();
        self.write(0, &mut text);
        text
    }

    fn write(&self, depth: usize, text: &mut String) {
        let indent = "  ".repeat(depth);
        let attributes: String =
            self.attributes.iter().map(|(key, value)| format!(" {key}=\"{}\"", escaped(value))).collect();
        if self.children.is_empty() {
            text.push_str(&format!("{indent}<{}{attributes}/>\n", self.name));
            return;
        }
        text.push_str(&format!("{indent}<{}{attributes}>\n", self.name));
        self.children.iter().for_each(|child| child.write(depth + 1, text));
        text.push_str(&format!("{indent}</{}>\n", self.name));
    }
}

fn escaped(value: &str) -> String {
    value.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
