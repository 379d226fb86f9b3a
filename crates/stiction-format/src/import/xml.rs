//! Parses robot files into XML elements with their places in the file, and reads numbers from these
//! elements.

use super::context::Context;
use super::extension::NAMESPACE;
use crate::diagnostic::{Diagnostic, Diagnostics, number, quoted};
use crate::source::{Place, Source, Span};
use std::sync::Arc;

/// Maximum nesting depth of the elements in a robot file.
const DEEPEST: usize = 1000;
/// Greatest accepted magnitude of a number, as in the model file.
const LARGEST: f64 = 1e30;
/// Greatest number of elements and texts in a file; this bounds the memory used.
const MOST_NODES: u32 = 4_000_000;

/// Message for a xacro file, a template from which URDF is generated.
pub(super) const XACRO: &str = "this is a xacro file, a template from which URDF is generated";
pub(super) const EXPAND_XACRO: &str = "expand it first: `xacro robot.urdf.xacro > robot.urdf`";

/// Attribute of an XML element, with its place in the file.
#[derive(Clone, Debug)]
pub(super) struct Attribute {
    pub(super) name: String,
    pub(super) value: String,
    span: Span,
    source: Arc<Source>,
}

impl Attribute {
    /// Place of the whole attribute, both name and value, in the file.
    pub(super) fn place(&self) -> Place {
        Place::new(&self.source, self.span.clone())
    }
}

/// Element of a robot file.
#[derive(Clone, Debug)]
pub(super) struct Element {
    /// Name of the element as written, with its namespace prefix: `foo:joint` does not count as a
    /// joint of the robot. The prefix that the file declares for this program's own namespace is
    /// omitted.
    pub(super) tag: String,
    /// Namespace of the element; empty if the name has no namespace.
    pub(super) namespace: String,
    pub(super) attributes: Vec<Attribute>,
    pub(super) children: Vec<Element>,
    /// Text directly in the element, outside its children, trimmed.
    pub(super) text: String,
    span: Span,
    source: Arc<Source>,
}

impl Element {
    /// Place of the element's name in its start tag.
    pub(super) fn place(&self) -> Place {
        Place::new(&self.source, self.span.clone())
    }

    /// Returns the attribute with this name.
    pub(super) fn attribute(&self, name: &str) -> Option<&Attribute> {
        self.attributes.iter().find(|attribute| attribute.name == name)
    }

    /// Returns the value of the attribute with this name.
    pub(super) fn get(&self, name: &str) -> Option<&str> {
        self.attribute(name).map(|attribute| attribute.value.trim())
    }

    /// Returns the first child with this tag.
    pub(super) fn child(&self, tag: &str) -> Option<&Self> {
        self.children.iter().find(|child| child.tag == tag)
    }

    /// Returns all children with this tag.
    pub(super) fn all<'a>(&'a self, tag: &'a str) -> impl Iterator<Item = &'a Self> {
        self.children.iter().filter(move |child| child.tag == tag)
    }

    /// Description of the element for messages, such as "joint `knee`".
    pub(super) fn title(&self) -> String {
        match self.get("name") {
            Some(name) => format!("{} {}", self.tag, quoted(name)),
            None => format!("<{}>", self.tag),
        }
    }
}

/// Maximum number of namespace prefixes that a file may use without declaring them.
const MOST_PREFIXES: usize = 32;

/// Text of a file, with declarations inserted for namespace prefixes that the file does not
/// declare.
///
/// URDF parsers accept `<sensor:camera>` without a declaration of the prefix `sensor`, so existing
/// files contain such names.
struct Declared {
    text: String,
    prefixes: Vec<String>,
    /// Byte offset of the inserted declarations; `inserted` is their total length, bytes.
    at: usize,
    inserted: usize,
}

impl Declared {
    fn new(text: &str) -> Self {
        Self {
            text: text.to_owned(),
            prefixes: Vec::new(),
            at: end_of_root_name(text).unwrap_or(text.len()),
            inserted: 0,
        }
    }

    fn declare(&mut self, prefix: String) {
        let declaration = format!(" xmlns:{prefix}=\"{prefix}\"");
        self.text.insert_str(self.at, &declaration);
        self.inserted += declaration.len();
        self.prefixes.push(prefix);
    }

    /// Converts a byte offset in the changed text to the offset in the original text.
    fn original(&self, offset: usize) -> usize {
        if offset <= self.at { offset } else { offset.saturating_sub(self.inserted).max(self.at) }
    }
}

/// Returns the byte offset of the end of the root element's name in its start tag; `None` if the
/// text has no start tag.
fn end_of_root_name(text: &str) -> Option<usize> {
    let mut at = 0;
    loop {
        at += text[at..].find('<')?;
        let rest = &text[at..];
        let skipped = match rest.as_bytes().get(1)? {
            b'?' => rest.find("?>")?,
            b'!' if rest.starts_with("<!--") => 4 + rest[4..].find("-->")?,
            b'!' => rest.find('>')?,
            _ => {
                return rest
                    .find(|c: char| c.is_whitespace() || c == '>' || c == '/')
                    .map(|k| at + k);
            }
        };
        at += skipped;
    }
}

/// Parses an XML file and returns its root element.
///
/// # Errors
/// The text is not well-formed XML, declares entities, or is nested too deeply.
pub(super) fn parse(source: &Arc<Source>) -> Result<Element, Diagnostics> {
    let mut declared = Declared::new(&source.text);
    loop {
        let options = roxmltree::ParsingOptions { nodes_limit: MOST_NODES, ..Default::default() };
        let error = match roxmltree::Document::parse_with_options(&declared.text, options) {
            Ok(document) => return build(document.root_element(), source, &declared),
            Err(error) => error,
        };
        let at = declared.original(offset(&declared.text, error.pos()));
        let place = Place::new(source, at..at);
        match error {
            // A second error for the same prefix is reported: the inserted declaration has no
            // effect on the name.
            roxmltree::Error::UnknownNamespace(prefix, _)
                if prefix != "xacro" && !declared.prefixes.contains(&prefix) =>
            {
                if declared.prefixes.len() == MOST_PREFIXES {
                    let message =
                        format!("more than {MOST_PREFIXES} namespace prefixes are not declared");
                    let help = "declare them in the first element: xmlns:prefix=\"…\"";
                    return Err(Diagnostic::error("xml", message).at(place, "").help(help).into());
                }
                declared.declare(prefix);
            }
            error => return Err(refusal(&error, place)),
        }
    }
}

fn refusal(error: &roxmltree::Error, place: Place) -> Diagnostics {
    let (message, help) = match error {
        roxmltree::Error::DtdDetected => (
            "the file declares its own entities (<!DOCTYPE>), which are not read".to_owned(),
            "remove the declaration, and write the values in place of the entities",
        ),
        roxmltree::Error::UnknownNamespace(prefix, _) if prefix == "xacro" => {
            (XACRO.to_owned(), EXPAND_XACRO)
        }
        error => {
            let message = error.to_string();
            let message = message.split(" at ").next().unwrap_or_default().to_owned();
            (format!("the file is not well-formed XML: {message}"), "correct the XML")
        }
    };
    Diagnostics::from(Diagnostic::error("xml", message).at(place, "").help(help))
}

/// Returns the byte offset of a position in the text. The line and the column of the position count
/// from 1; the column is in characters.
fn offset(text: &str, position: roxmltree::TextPos) -> usize {
    let line = position.row.max(1) as usize - 1;
    let start: usize = text.split_inclusive('\n').take(line).map(str::len).sum();
    let rest = text.get(start..).unwrap_or_default();
    let column = rest.char_indices().nth(position.col.max(1) as usize - 1);
    start + column.map_or(rest.len(), |(at, _)| at)
}

/// Copies the parsed nodes into [`Element`]s, without recursion because files may be nested deeply.
fn build(
    root: roxmltree::Node<'_, '_>,
    source: &Arc<Source>,
    declared: &Declared,
) -> Result<Element, Diagnostics> {
    let element = |node| element(node, source, declared);
    let mut open: Vec<(roxmltree::Node<'_, '_>, Element)> = vec![(root, element(root))];
    let mut next = root.first_element_child();
    loop {
        if let Some(node) = next {
            if open.len() >= DEEPEST {
                let message = format!("elements are nested more than {DEEPEST} levels deep");
                let place = element(node).place();
                let help = "flatten the file; robots need far fewer levels";
                return Err(Diagnostic::error("xml", message).at(place, "").help(help).into());
            }
            open.push((node, element(node)));
            next = node.first_element_child();
            continue;
        }
        let Some((node, done)) = open.pop() else { break };
        let Some((_, parent)) = open.last_mut() else { return Ok(done) };
        parent.children.push(done);
        next = node.next_sibling_element();
    }
    // The root is always returned above.
    Ok(element(root))
}

fn element(node: roxmltree::Node<'_, '_>, source: &Arc<Source>, declared: &Declared) -> Element {
    let range = node.range();
    let start = declared.original(range.start);
    let namespace = node.tag_name().namespace().unwrap_or_default();
    let written = declared.text[range].trim_start_matches('<');
    let end = written.find(|c: char| c.is_whitespace() || c == '>' || c == '/');
    let written = &written[..end.unwrap_or(written.len())];
    let attribute = |attribute: roxmltree::Attribute<'_, '_>| Attribute {
        name: declared.text[attribute.range_qname()].to_owned(),
        value: attribute.value().to_owned(),
        span: declared.original(attribute.range().start)..declared.original(attribute.range().end),
        source: Arc::clone(source),
    };
    let text: String =
        node.children().filter(|child| child.is_text()).filter_map(|child| child.text()).collect();
    Element {
        tag: if namespace == NAMESPACE { node.tag_name().name() } else { written }.to_owned(),
        namespace: namespace.to_owned(),
        attributes: node.attributes().map(attribute).collect(),
        children: Vec::new(),
        text: text.trim().to_owned(),
        span: start..start + 1 + written.len(),
        source: Arc::clone(source),
    }
}

/// Reads numbers separated by white space or commas; reports the first word that is not a finite
/// number of accepted magnitude, and then returns `None`.
pub(super) fn numbers_in(context: &Context, text: &str, place: &Place) -> Option<Vec<f64>> {
    let mut numbers = Vec::new();
    for word in text.split([' ', '\t', '\n', '\r', ',']).filter(|word| !word.is_empty()) {
        let found: Option<f64> = word.parse().ok();
        let (message, help) = match found {
            Some(value) if value.abs() <= LARGEST => {
                numbers.push(value);
                continue;
            }
            Some(value) if value.is_finite() => (
                format!("{} is greater than {}", quoted(word), number(LARGEST)),
                "write a smaller number".to_owned(),
            ),
            Some(_) => (
                format!("{} is not a finite number", quoted(word)),
                "write a number that is finite; for a missing limit, a large one such as 1e9"
                    .to_owned(),
            ),
            None => (format!("{} is not a number", quoted(word)), help_for(word)),
        };
        context.error("number", message, place, &help);
        return None;
    }
    Some(numbers)
}

/// Remedy for a word that is not a number.
fn help_for(word: &str) -> String {
    /// Greatest length of a word in which a number with a unit is sought, bytes.
    const LONGEST: usize = 40;
    let end = |(at, letter): (usize, char)| at + letter.len_utf8();
    let mut ends = word.char_indices().map(end).filter(|_| word.len() <= LONGEST);
    let is_number = |text: &str| text.parse::<f64>().is_ok_and(f64::is_finite);
    let value = ends.rfind(|end| is_number(&word[..*end]));
    match value {
        Some(end) => format!("write {} without a unit: robot files have fixed units", &word[..end]),
        None => "write a number, such as 0.25".to_owned(),
    }
}

/// Reads exactly `N` numbers from a text; reports an error if the text has another count of
/// numbers.
pub(super) fn array<const N: usize>(
    context: &Context,
    text: &str,
    place: &Place,
) -> Option<[f64; N]> {
    let numbers = numbers_in(context, text, place)?;
    let count = numbers.len();
    let found = <[f64; N]>::try_from(numbers).ok();
    if found.is_none() {
        let plural = if N == 1 { "" } else { "s" };
        let shown = match text.trim() {
            "" => String::new(),
            text => format!(": {}", quoted(text)),
        };
        let message = format!("expected {N} number{plural}, found {count}{shown}");
        let help = match N {
            1 if text.contains(',') => "write the decimal point as a point, as in 2.5",
            1 => "write one number",
            _ => "separate the numbers by spaces",
        };
        context.error("number", message, place, help);
    }
    found
}

impl Element {
    /// Reads a list of numbers from the attribute with this name; returns `None` if the attribute
    /// is missing or invalid.
    pub(super) fn list(&self, context: &Context, name: &str) -> Option<Vec<f64>> {
        let attribute = self.attribute(name)?;
        numbers_in(context, &attribute.value, &attribute.place())
    }

    /// Reads exactly `N` numbers from the attribute with this name; returns `None` if the attribute
    /// is missing or invalid.
    pub(super) fn numbers<const N: usize>(
        &self,
        context: &Context,
        name: &str,
    ) -> Option<[f64; N]> {
        let attribute = self.attribute(name)?;
        array(context, &attribute.value, &attribute.place())
    }

    /// Reads one number from the attribute with this name; returns `None` if the attribute is
    /// missing or invalid.
    pub(super) fn number(&self, context: &Context, name: &str) -> Option<f64> {
        self.numbers::<1>(context, name).map(|[value]| value)
    }

    /// Returns the value of a required attribute; reports an error if the attribute is missing.
    pub(super) fn required(&self, context: &Context, name: &str) -> Option<&str> {
        let value = self.get(name);
        if value.is_none() {
            let message = format!("{} has no attribute `{name}`", self.title());
            context.error("missing", message, &self.place(), "");
        }
        value
    }

    /// Reads the text of the element as `N` numbers.
    pub(super) fn text_numbers<const N: usize>(&self, context: &Context) -> Option<[f64; N]> {
        array(context, &self.text, &self.place())
    }

    /// Reads the text of the child with this tag as a number; returns `None` if there is no such
    /// child or its text is empty.
    pub(super) fn child_number(&self, context: &Context, tag: &str) -> Option<f64> {
        let child = self.child(tag).filter(|child| !child.text.is_empty())?;
        child.text_numbers::<1>(context).map(|[value]| value)
    }
}
