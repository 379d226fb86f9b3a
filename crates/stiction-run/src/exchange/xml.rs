//! Writer of XML text, for exported files.

use std::fmt::Write;
use stiction_draw::xml::escape;

/// Attributes of an XML element, in the order of output.
pub(in crate::exchange) type Attributes<'a> = &'a [(&'static str, String)];

/// Partially written XML text with its open elements.
#[derive(Debug, Default)]
pub(in crate::exchange) struct Xml {
    text: String,
    open: Vec<&'static str>,
}

impl Xml {
    /// Returns the number of open elements.
    pub(in crate::exchange) fn depth(&self) -> usize {
        self.open.len()
    }

    /// Writes the opening tag of an element that has content.
    pub(in crate::exchange) fn open(&mut self, tag: &'static str, attributes: Attributes<'_>) {
        self.begin(tag, attributes);
        self.text.push_str(">\n");
        self.open.push(tag);
    }

    /// Writes the closing tag of the innermost open element.
    pub(in crate::exchange) fn close(&mut self) {
        if let Some(tag) = self.open.pop() {
            self.indent();
            // Writing to a string does not fail.
            let _ = writeln!(self.text, "</{tag}>");
        }
    }

    /// Writes an element without content.
    pub(in crate::exchange) fn empty(&mut self, tag: &'static str, attributes: Attributes<'_>) {
        self.begin(tag, attributes);
        self.text.push_str("/>\n");
    }

    /// Writes an element that contains only text.
    pub(in crate::exchange) fn text(
        &mut self,
        tag: &'static str,
        attributes: Attributes<'_>,
        text: &str,
    ) {
        self.begin(tag, attributes);
        let _ = writeln!(self.text, ">{}</{tag}>", escape(text));
    }

    /// Writes a comment with one line for each of `lines`.
    pub(in crate::exchange) fn comment(&mut self, lines: &[&str]) {
        for (k, line) in lines.iter().enumerate() {
            self.indent();
            self.text.push_str(if k == 0 { "<!-- " } else { "     " });
            self.text.push_str(&harmless(line));
            self.text.push_str(if k + 1 == lines.len() { " -->\n" } else { "\n" });
        }
    }

    /// Closes all elements and returns the text.
    pub(in crate::exchange) fn finish(mut self) -> String {
        while !self.open.is_empty() {
            self.close();
        }
        self.text
    }

    fn begin(&mut self, tag: &'static str, attributes: Attributes<'_>) {
        self.indent();
        let _ = write!(self.text, "<{tag}");
        for (name, value) in attributes {
            let _ = write!(self.text, " {name}=\"{}\"", escape(value));
        }
    }

    fn indent(&mut self) {
        self.text.extend(std::iter::repeat_n("  ", self.open.len()));
    }
}

/// Makes text safe for an XML comment: separates successive hyphens by spaces and removes control
/// characters.
fn harmless(text: &str) -> String {
    let mut harmless = String::with_capacity(text.len());
    for c in text.chars().filter(|c| !c.is_control() && !matches!(c, '\u{fffe}' | '\u{ffff}')) {
        if c == '-' && harmless.ends_with('-') {
            harmless.push(' ');
        }
        harmless.push(c);
    }
    harmless
}

/// Formats numbers, separated by spaces, in the shortest form that reads back as the same number.
pub(in crate::exchange) fn numbers(values: &[f64]) -> String {
    let mut text = String::new();
    for (k, &value) in values.iter().enumerate() {
        // Adding zero removes the sign of a negative zero.
        let value = value + 0.0;
        let gap = if k == 0 { "" } else { " " };
        let plain = value == 0.0 || (1e-5..1e16).contains(&value.abs());
        let _ = match plain {
            true => write!(text, "{gap}{value}"),
            false => write!(text, "{gap}{value:e}"),
        };
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_and_comments_are_escaped() {
        let mut xml = Xml::default();
        xml.open("a", &[("name", "x<\"&'y".into())]);
        xml.comment(&["one --> two", "--- three"]);
        xml.empty("b", &[]);
        let text = xml.finish();
        let read = roxmltree::Document::parse(&text).unwrap();
        assert_eq!(read.root_element().attribute("name"), Some("x<\"&'y"));
        assert_eq!(read.root_element().children().filter(|node| node.is_element()).count(), 1);
    }

    #[test]
    fn numbers_read_back_as_the_same() {
        let values = [0.1, -0.0, 1.0 / 3.0, 6.02e23, -1.6e-19, 5e-324, 1e-5];
        let text = numbers(&values);
        let read: Vec<f64> = text.split(' ').map(|number| number.parse().unwrap()).collect();
        assert_eq!(read, values);
        assert!(!text.contains("-0 "), "{text}");
    }
}
