//! Tests on which parts of a model a value has an influence.

use crate::document::{Node, Table, Value, segments};
use crate::expression::token::{TokenKind, tokens};

/// Key of the tables that describe friction.
const FRICTION: &str = "friction";
const PARAMETERS: &str = "parameters";

/// Tests if the key or parameter at a path, as in changes, has an influence on friction alone. The default of friction
/// (`default.friction`), which switches it on or off, does not count.
pub(super) fn is_only_on_friction(root: &Table, path: &str) -> bool {
    let names = segments(path);
    let parameters = root.get(PARAMETERS).and_then(Value::as_table);
    let is_parameter = |name: &str| parameters.is_some_and(|table| table.get(name).is_some());
    match names.as_slice() {
        [first, ..] if first == "default" => false,
        [name] | [_, name]
            if (names.len() == 1 || names[0] == PARAMETERS) && is_parameter(name) =>
        {
            is_used_only_by_friction(root, name)
        }
        names => names.iter().any(|name| name == FRICTION),
    }
}

/// Tests if a parameter, or other parameters that depend on it, occur in formulas of friction and nowhere else.
fn is_used_only_by_friction(root: &Table, parameter: &str) -> bool {
    let (mut names, mut next, mut is_used) = (vec![parameter.to_owned()], 0, false);
    while let Some(name) = names.get(next).cloned() {
        next += 1;
        for (key, value) in &root.entries {
            if key.name != PARAMETERS {
                match use_of(&name, value, false) {
                    Use::Elsewhere => return false,
                    Use::Friction => is_used = true,
                    Use::None => {}
                }
                continue;
            }
            for (own, value) in value.as_table().into_iter().flat_map(|table| &table.entries) {
                if use_of(&name, value, false) != Use::None && !names.contains(&own.name) {
                    names.push(own.name.clone());
                }
            }
        }
    }
    is_used
}

/// Uses of a parameter in a part of the model; the greater of two counts for both together.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Use {
    None,
    Friction,
    Elsewhere,
}

/// Searches the formulas in a value for a parameter.
fn use_of(name: &str, value: &Value, in_friction: bool) -> Use {
    match &value.node {
        Node::Text(text) => {
            let content = text.content.as_str();
            let tokens = tokens(content).unwrap_or_default();
            let is_name = |kind, span| kind == TokenKind::Name && content.get(span) == Some(name);
            match tokens.into_iter().any(|token| is_name(token.kind, token.span)) {
                true if in_friction => Use::Friction,
                true => Use::Elsewhere,
                false => Use::None,
            }
        }
        Node::List(list) => {
            list.iter().map(|item| use_of(name, item, in_friction)).max().unwrap_or(Use::None)
        }
        Node::Table(table) => {
            let entries = table.entries.iter();
            let uses = entries
                .map(|(key, value)| use_of(name, value, in_friction || key.name == FRICTION));
            uses.max().unwrap_or(Use::None)
        }
        Node::Number(_) | Node::Flag(_) | Node::Other => Use::None,
    }
}
