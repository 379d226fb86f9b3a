//! Tests on which parts of a model a value has an influence.

use crate::document::{Node, Table, Value, segments};
use crate::expression::token::{TokenKind, tokens};
use crate::fields::tables::MODEL;

/// Key of the tables that describe friction.
const FRICTION: &str = "friction";
const PARAMETERS: &str = "parameters";
/// Keys of the model whose tables contain joints. Only joints have tables of friction.
const WITH_JOINTS: [&str; 2] = ["joints", "legs"];
/// Keys of tables of named parts, one of which may have the name `friction`.
const NAMED: [&str; 5] = ["joints", "legs", "bodies", "springs", "actuators"];

/// Tests if `key`, in a table with the key `parent` within a table of [`WITH_JOINTS`], is the key of a table of friction.
fn is_friction(parent: &str, key: &str) -> bool {
    key == FRICTION && !NAMED.contains(&parent)
}

/// Tests if the key or parameter at a path, as in changes, has an influence on friction alone. The default of friction
/// (`default.friction`), which switches it on or off, does not count.
pub(super) fn is_only_on_friction(root: &Table, path: &str) -> bool {
    let names = segments(path);
    let parameters = root.get(PARAMETERS).and_then(Value::as_table);
    let is_parameter = |name: &str| parameters.is_some_and(|table| table.get(name).is_some());
    match names.as_slice() {
        [name] | [_, name]
            if (names.len() == 1 || names[0] == PARAMETERS) && is_parameter(name) =>
        {
            is_used_only_by_friction(root, name)
        }
        [first, ..] => {
            let has = |table: &str| {
                let parts = root.get(table).and_then(Value::as_table);
                parts.is_some_and(|parts| parts.get(first).is_some())
            };
            // The path may omit the key of the table of a part.
            let may_be_joint = match MODEL.iter().any(|field| field.key == first) {
                true => WITH_JOINTS.contains(&first.as_str()),
                false => has("joints") || !has("motions"),
            };
            may_be_joint && names.windows(2).any(|pair| is_friction(&pair[0], &pair[1]))
        }
        [] => false,
    }
}

/// Tests if a parameter, or other parameters that depend on it, occur in formulas of friction and nowhere else.
fn is_used_only_by_friction(root: &Table, parameter: &str) -> bool {
    let (mut names, mut next, mut is_used) = (vec![parameter.to_owned()], 0, false);
    while let Some(name) = names.get(next).cloned() {
        next += 1;
        for (key, value) in &root.entries {
            if key.name != PARAMETERS {
                match use_of(&name, (&key.name, value), Place::of_root(&key.name)) {
                    Use::Elsewhere => return false,
                    Use::Friction => is_used = true,
                    Use::None => {}
                }
                continue;
            }
            for (own, value) in value.as_table().into_iter().flat_map(|table| &table.entries) {
                let use_of_name = use_of(&name, (&own.name, value), Place::Elsewhere);
                if use_of_name != Use::None && !names.contains(&own.name) {
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

/// Part of the model to which a value belongs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// Friction of a joint.
    Friction,
    /// A table that contains joints, outside their friction.
    WithJoints,
    Elsewhere,
}

impl Place {
    /// Place of the value of a key of the model.
    fn of_root(key: &str) -> Self {
        if WITH_JOINTS.contains(&key) { Self::WithJoints } else { Self::Elsewhere }
    }

    /// Place of the value of `key` in a table with the key `parent` at this place.
    fn within(self, parent: &str, key: &str) -> Self {
        match self {
            Self::WithJoints if is_friction(parent, key) => Self::Friction,
            _ => self,
        }
    }
}

/// Searches the formulas in a value for a parameter. `own` is the key of the value.
fn use_of(name: &str, (own, value): (&str, &Value), place: Place) -> Use {
    match &value.node {
        Node::Text(text) => {
            let content = text.content.as_str();
            let tokens = tokens(content).unwrap_or_default();
            let is_name = |kind, span| kind == TokenKind::Name && content.get(span) == Some(name);
            match tokens.into_iter().any(|token| is_name(token.kind, token.span)) {
                true if place == Place::Friction => Use::Friction,
                true => Use::Elsewhere,
                false => Use::None,
            }
        }
        Node::List(list) => {
            let uses = list.iter().map(|item| use_of(name, (own, item), place));
            uses.max().unwrap_or(Use::None)
        }
        Node::Table(table) => {
            let uses = table
                .entries
                .iter()
                .map(|(key, value)| use_of(name, (&key.name, value), place.within(own, &key.name)));
            uses.max().unwrap_or(Use::None)
        }
        Node::Number(_) | Node::Flag(_) | Node::Other => Use::None,
    }
}
