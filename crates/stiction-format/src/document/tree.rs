//! Document tree: nested tables in the order of the file; each key and value has its byte range in
//! the text.

use crate::source::Span;

/// A key, and its byte range in the text.
#[derive(Clone, Debug)]
pub(crate) struct Key {
    pub(crate) name: String,
    pub(crate) span: Span,
}

/// A value, and its byte range in the text.
#[derive(Clone, Debug)]
pub(crate) struct Value {
    pub(crate) span: Span,
    pub(crate) node: Node,
}

/// Content of a value, by kind.
#[derive(Clone, Debug)]
pub(crate) enum Node {
    Text(Text),
    /// A number, which may be infinite or NaN so that the reader can report it.
    Number(f64),
    Flag(bool),
    List(Vec<Value>),
    Table(Table),
    /// A date, or a value nested too deeply; the model file uses neither.
    Other,
}

/// A string, with its position in the source.
#[derive(Clone, Debug)]
pub(crate) struct Text {
    pub(crate) content: String,
    /// Byte offset of the content in the source; `None` if the content contains escapes.
    pub(crate) start: Option<usize>,
}

/// A table: its keys and values in the order of the file.
#[derive(Clone, Debug, Default)]
pub(crate) struct Table {
    /// Place of the table's header, braces or key.
    pub(crate) span: Span,
    pub(crate) entries: Vec<(Key, Value)>,
}

impl Table {
    /// Key and value of the entry with this name.
    pub(crate) fn entry(&self, name: &str) -> Option<(&Key, &Value)> {
        self.entries.iter().find(|(key, _)| key.name == name).map(|(key, value)| (key, value))
    }

    /// Value of the entry with this name.
    pub(crate) fn get(&self, name: &str) -> Option<&Value> {
        self.entry(name).map(|(_, value)| value)
    }
}

impl Value {
    /// The value as a table; `None` for any other kind.
    pub(crate) fn as_table(&self) -> Option<&Table> {
        match &self.node {
            Node::Table(table) => Some(table),
            _ => None,
        }
    }

    /// The value as a list; `None` for any other kind.
    pub(crate) fn as_list(&self) -> Option<&[Value]> {
        match &self.node {
            Node::List(list) => Some(list),
            _ => None,
        }
    }

    /// The value as a string; `None` for any other kind.
    pub(crate) fn as_text(&self) -> Option<&str> {
        match &self.node {
            Node::Text(text) => Some(&text.content),
            _ => None,
        }
    }

    /// Phrase for the kind of the value.
    pub(crate) fn describe(&self) -> &'static str {
        match self.node {
            Node::Text(_) => "a string",
            Node::Number(_) => "a number",
            Node::Flag(_) => "a Boolean",
            Node::List(_) => "a list",
            Node::Table(_) => "a table",
            Node::Other => "an unsupported value (a date?)",
        }
    }
}

impl Text {
    /// Converts the range `part` of the content to a byte range in the source. Returns the range of
    /// the whole value if the content contains escapes.
    pub(crate) fn place_of(&self, value: &Span, part: &Span) -> Span {
        match self.start {
            Some(start) => start + part.start..start + part.end,
            None => value.clone(),
        }
    }
}
