//! Reports the elements and attributes of a robot file that the importer does not read, with their
//! lines in the file.
//!
//! Each format has a list of known content: content that the importer reads or reports itself, and
//! content without influence on the model, such as colours, contacts and solver settings.
//! Everything else is reported.

use super::context::Context;
use super::xml::Element;

/// Entry in the list of known content: the known attributes and children of one type of element.
///
/// A word `name=value` matches only if the file contains the format's default `value`: numbers that
/// are all equal to it, or the same word. `true` equals `1`, and `false` equals `0`.
pub(super) struct Known {
    /// Tag of the element, or `parent/tag` where the parent matters.
    pub(super) tag: &'static str,
    /// Names of the known attributes, separated by spaces.
    pub(super) attributes: &'static str,
    /// Tags of the known children, separated by spaces. The content of children without an entry of
    /// their own is not checked.
    pub(super) children: &'static str,
}

/// Creates the entry of an element type in a list of known content.
pub(super) const fn known(
    tag: &'static str,
    attributes: &'static str,
    children: &'static str,
) -> Known {
    Known { tag, attributes, children }
}

/// Entry that matches all attributes, or all children with their content.
pub(super) const ANY: &str = "*";

/// Reports all elements and attributes below `root` that are not in the list of known content.
pub(super) fn note(context: &Context<'_>, root: &Element, list: &[Known]) {
    let entry = |parent: &str, tag: &str| {
        let is_own = |entry: &&Known| {
            entry.tag.split_once('/').is_some_and(|(outer, own)| (outer, own) == (parent, tag))
        };
        let own = list.iter().find(is_own);
        own.or_else(|| list.iter().find(|entry| entry.tag == tag))
    };
    let mut open: Vec<(&Element, &Known)> =
        entry("", &root.tag).map(|own| (root, own)).into_iter().collect();
    while let Some((element, own)) = open.pop() {
        for attribute in &element.attributes {
            // Attributes with a namespace prefix belong to other programs.
            if own.attributes != ANY
                && !attribute.name.contains(':')
                && !is_known(own.attributes, &attribute.name, &attribute.value)
            {
                let message = format!("`{}` of <{}> is not read", attribute.name, element.tag);
                context.note(message, Some(attribute.place()));
            }
        }
        if own.children == ANY {
            continue;
        }
        let mut below = Vec::new();
        for child in &element.children {
            if child.namespace == super::NAMESPACE {
                continue;
            }
            match is_known(own.children, &child.tag, &child.text) {
                true => below.extend(entry(&element.tag, &child.tag).map(|own| (child, own))),
                false => {
                    let message = format!("<{}> has no counterpart in the model", child.tag);
                    context.note(message, Some(child.place()));
                }
            }
        }
        // The children are pushed in reverse so that elements are visited in the order of the file.
        open.extend(below.into_iter().rev());
    }
}

fn is_known(list: &str, name: &str, value: &str) -> bool {
    list.split_whitespace().any(|entry| match entry.split_once('=') {
        Some((known, default)) => known == name && is_default(value, default),
        None => entry == name,
    })
}

fn is_default(value: &str, default: &str) -> bool {
    let word = |text: &str| match text.trim() {
        "true" => "1".to_owned(),
        "false" => "0".to_owned(),
        other => other.to_owned(),
    };
    if word(value) == word(default) {
        return true;
    }
    let Ok(default) = word(default).parse::<f64>() else { return false };
    let mut numbers = value.split_whitespace().map(str::parse::<f64>).peekable();
    numbers.peek().is_none() || numbers.all(|number| number == Ok(default))
}

#[cfg(test)]
mod tests {
    use super::is_known;

    #[test]
    fn defaults_are_known() {
        for (value, expected) in
            [("0", true), ("0 0.0 0", true), ("", true), ("0 1", false), ("x", false)]
        {
            assert_eq!(is_known("mass wind=0", "wind", value), expected, "{value}");
        }
        assert!(is_known("a kinematic=false", "kinematic", "0") && is_known("a", "a", "anything"));
        assert!(!is_known("kinematic=false", "kinematic", "true") && !is_known("ab", "a", ""));
    }
}
