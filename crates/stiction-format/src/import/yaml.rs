//! Reads the subset of YAML used for loop closures: a mapping of keys to texts and lists.

use crate::diagnostic::{Diagnostic, Diagnostics, quoted};
use crate::source::{Place, Source};
use saphyr::{LoadableYamlNode, MarkedYaml, Scalar, YamlData};
use std::sync::Arc;

/// Maximum size of a YAML file, bytes.
const LONGEST: usize = 1 << 20;
/// Maximum nesting depth of lists and mappings, which are read recursively.
const DEEPEST: usize = 64;

/// A text in the YAML file, with its place.
#[derive(Clone, Debug)]
pub(super) struct Word {
    pub(super) text: String,
    pub(super) place: Place,
}

/// Value of a key: a text, or a list.
#[derive(Clone, Debug)]
pub(super) enum Value {
    Word(Word),
    List(Vec<Value>),
}

impl Value {
    /// Returns all texts in the value, including those of nested lists.
    pub(super) fn words(&self) -> Vec<&Word> {
        match self {
            Self::Word(word) => vec![word],
            Self::List(items) => items.iter().flat_map(Self::words).collect(),
        }
    }

    /// Returns the items of a list; a text counts as a list with one item.
    pub(super) fn items(&self) -> &[Self] {
        match self {
            Self::Word(_) => std::slice::from_ref(self),
            Self::List(items) => items,
        }
    }
}

/// Parses a YAML file and returns the keys and values of its mapping in the order of the file.
///
/// # Errors
/// The text is not valid YAML, is not a mapping, is too long, or is nested too deeply.
pub(super) fn parse(source: &Arc<Source>) -> Result<Vec<(Word, Value)>, Diagnostics> {
    let text = source.text.as_str();
    let refused = |message: String, at: usize| {
        let place = Place::new(source, at..at);
        Diagnostics::from(Diagnostic::error("yaml", message).at(place, "").help("correct the YAML"))
    };
    if text.len() > LONGEST {
        return Err(refused(
            format!("the YAML file is longer than the limit of {LONGEST} bytes"),
            0,
        ));
    }
    if let Some(at) = too_deep(text) {
        return Err(refused(format!("lists are nested more than {DEEPEST} levels deep"), at));
    }
    let documents = MarkedYaml::load_from_str(text).map_err(|error| {
        let at = byte_of(text, error.marker().index());
        refused(format!("the file is not valid YAML: {}", error.info()), at)
    })?;
    let entries = match documents.into_iter().next().map(|document| document.data) {
        Some(YamlData::Mapping(entries)) => entries,
        None => return Ok(Vec::new()),
        Some(_) => return Err(refused("the file has no keys, such as `closed_loop:`".into(), 0)),
    };
    let entry = |(key, value): (MarkedYaml<'_>, MarkedYaml<'_>)| {
        let Value::Word(key) = value_of(source, &key, 0)? else { return None };
        Some((key, value_of(source, &value, 0)?))
    };
    Ok(entries.into_iter().filter_map(entry).collect())
}

/// Returns the byte offset at which lists or mappings become nested too deeply; `None` if the
/// nesting is within the limit.
fn too_deep(text: &str) -> Option<usize> {
    let mut depth = 0_usize;
    let mut start = 0;
    for line in text.split_inclusive('\n') {
        let indent = line.len() - line.trim_start_matches([' ', '-', '?']).len();
        if indent > 4 * DEEPEST {
            return Some(start);
        }
        for (at, letter) in line.char_indices() {
            match letter {
                '[' | '{' => depth += 1,
                ']' | '}' => depth = depth.saturating_sub(1),
                _ => {}
            }
            if depth > DEEPEST {
                return Some(start + at);
            }
        }
        start += line.len();
    }
    None
}

/// Returns the byte offset of the character with this index in the text; the length of the text if
/// there is no such character.
fn byte_of(text: &str, index: usize) -> usize {
    text.char_indices().nth(index).map_or(text.len(), |(at, _)| at)
}

fn value_of(source: &Arc<Source>, node: &MarkedYaml<'_>, depth: usize) -> Option<Value> {
    let word = |text: String| {
        let at = |index: usize| byte_of(&source.text, index);
        let span = at(node.span.start.index())..at(node.span.end.index());
        Some(Value::Word(Word { text, place: Place::new(source, span) }))
    };
    match &node.data {
        YamlData::Sequence(_) if depth > DEEPEST => None,
        YamlData::Sequence(items) => {
            let items = items.iter().filter_map(|item| value_of(source, item, depth + 1));
            Some(Value::List(items.collect()))
        }
        YamlData::Value(Scalar::String(text)) => word(text.clone().into_owned()),
        YamlData::Value(Scalar::Integer(number)) => word(number.to_string()),
        YamlData::Value(Scalar::FloatingPoint(number)) => word(number.to_string()),
        YamlData::Value(Scalar::Boolean(value)) => word(value.to_string()),
        YamlData::Representation(text, _, _) => word(text.clone().into_owned()),
        YamlData::Tagged(_, inner) if depth <= DEEPEST => value_of(source, inner, depth + 1),
        _ => None,
    }
}

/// Formats the message that the list `key` and the list `other` differ in their numbers of entries.
pub(super) fn lengths(key: &str, other: &str, (found, expected): (usize, usize)) -> String {
    format!("{} has {found} entries, but {} has {expected}", quoted(key), quoted(other))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Vec<(String, Vec<String>)> {
        let source = Arc::new(Source::new("a.yaml", text));
        let words = |value: &Value| value.words().iter().map(|w| w.text.clone()).collect();
        let entries = parse(&source).unwrap();
        entries.iter().map(|(key, value)| (key.text.clone(), words(value))).collect()
    }

    #[test]
    fn lists_of_both_styles_are_read() {
        let flow = read("closed_loop: [['a', b], [\"c\", d]] # two\ntype: ['6d', 3D]\n");
        let block = read("closed_loop:\n  - - a\n    - b\n  - [c, d]\ntype:\n- 6d\n- 3D\n");
        assert_eq!(flow, block);
        assert_eq!(flow[0].1, ["a", "b", "c", "d"]);
        assert_eq!(flow[1].1, ["6d", "3D"]);
        assert!(read("").is_empty());
    }

    #[test]
    fn deep_and_broken_texts_are_refused() {
        for text in ["[".repeat(100_000), "a: [".into(), "- a".into(), "a: &x [*x, *x]".into()] {
            let source = Arc::new(Source::new("a.yaml", text));
            let _ = parse(&source);
        }
        let deep: String = (0..100_000).map(|_| "- ").collect();
        let source = Arc::new(Source::new("a.yaml", deep));
        assert!(parse(&source).is_err());
    }
}
