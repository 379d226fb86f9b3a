//! Changes of values of a part of a single leg. The path contains the name of the part in the
//! model: `leg2.rod.mass = 2 kg`.

use super::change::{Outcome, Target, table_of};
use super::{Key, Node, Table, Value};

/// Keys of the tables, in a group of legs, whose entries can be changed for a single leg.
const KINDS: [&str; 3] = ["bodies", "joints", "actuators"];

/// Sets a value of a part of a single leg, which may belong to any group of legs; returns `None` if
/// the path does not name such a part. The path begins with the name of the part, or with the key
/// of its table: `bodies.leg2.rod.mass`.
pub(super) fn set(target: &Target<'_>, legs: &mut Value) -> Option<Outcome> {
    let first = target.path.first()?;
    let (kinds, path) = match KINDS.iter().find(|kind| *kind == first) {
        Some(kind) => (std::slice::from_ref(kind), &target.path[1..]),
        None => (&KINDS[..], target.path),
    };
    let mut count = 0;
    let groups = match &mut legs.node {
        Node::Table(_) => std::slice::from_mut(legs),
        Node::List(groups) => groups.as_mut_slice(),
        _ => return None,
    };
    for group in groups {
        let Node::Table(group) = &mut group.node else { continue };
        let own = names(group, count);
        count += own.len();
        // Names may contain dots, and the value needs at least one key.
        for length in (1..path.len()).rev() {
            let name = path[..length].join(".");
            for kind in kinds {
                for (index, leg) in own.iter().enumerate() {
                    let Some(part) = part(group, kind, leg, &name) else { continue };
                    let target = Target { path: &path[length..], ..*target };
                    return set_in_leg(&target, group, (index, kind, &part));
                }
            }
        }
    }
    None
}

/// Names of the legs of `group`. Legs without a name are numbered; `count` is the number of legs in
/// all previous groups.
fn names(group: &Table, count: usize) -> Vec<String> {
    let list = group.get("place").or_else(|| group.get("angles")).and_then(Value::as_list);
    let own = |value: &Value| Some(value.as_table()?.get("name")?.as_text()?.to_owned());
    let legs = list.unwrap_or_default().iter().enumerate();
    legs.map(|(index, leg)| own(leg).unwrap_or_else(|| format!("leg{}", count + index + 1)))
        .collect()
}

/// Converts the name of a part in the model, such as `leg2.rod`, to its key in the table `kind` of
/// the group, such as `rod`. Returns `None` if this table does not contain the part.
fn part(group: &Table, kind: &str, leg: &str, name: &str) -> Option<String> {
    let known = |key: &str| {
        group.get(kind).and_then(Value::as_table).is_some_and(|table| table.get(key).is_some())
    };
    let patterns = group.get("names").and_then(Value::as_table);
    let pattern = |key: &str| patterns?.get(key)?.as_text();
    let mut of_patterns = patterns.into_iter().flat_map(|table| &table.entries);
    let named = of_patterns.find(|(key, value)| {
        known(&key.name) && value.as_text().is_some_and(|text| text.replacen("{}", leg, 1) == name)
    });
    if let Some((key, _)) = named {
        return Some(key.name.clone());
    }
    let key = name.strip_prefix(leg)?.strip_prefix('.')?;
    (known(key) && pattern(key).is_none()).then(|| key.to_owned())
}

/// Sets a value in the table of a single leg. If the path leads into a value that all legs share,
/// this value is first copied to the leg.
fn set_in_leg(
    target: &Target<'_>,
    group: &mut Table,
    (index, kind, part): (usize, &str, &str),
) -> Option<Outcome> {
    let first = target.path.first()?;
    let shared = group.get(kind).and_then(Value::as_table);
    let shared = shared.and_then(|table| table.get(part)?.as_table()?.get(first)).cloned();
    let place = place_list(group)?;
    let Node::Table(leg) = &mut place.get_mut(index)?.node else { return None };
    let own = inner(target, inner(target, leg, kind)?, part)?;
    if let Some(shared) = shared.filter(|_| target.path.len() > 1 && own.get(first).is_none()) {
        own.entries.push((Key { name: first.clone(), span: target.span.clone() }, shared));
    }
    Some(target.in_table(own, true, part))
}

/// Returns the list `place` of a group, which has an entry for each leg. A list `angles` is first
/// converted to a list `place`.
fn place_list(group: &mut Table) -> Option<&mut Vec<Value>> {
    if group.get("place").is_none()
        && let Some((key, value)) = group.entries.iter_mut().find(|(key, _)| key.name == "angles")
        && let Node::List(angles) = &mut value.node
    {
        key.name = "place".to_owned();
        for angle in angles {
            let span = angle.span.clone();
            let key = Key { name: "angle".to_owned(), span: span.clone() };
            let node = std::mem::replace(&mut angle.node, Node::Other);
            let own = Value { span: span.clone(), node };
            angle.node = Node::Table(Table { span, entries: vec![(key, own)] });
        }
    }
    let (_, place) = group.entries.iter_mut().find(|(key, _)| key.name == "place")?;
    match &mut place.node {
        Node::List(list) => Some(list),
        _ => None,
    }
}

/// Returns the table with this key in `table`; if the key is missing, adds an empty table. Returns
/// `None` if the value of the key is not a table.
fn inner<'a>(target: &Target<'_>, table: &'a mut Table, key: &str) -> Option<&'a mut Table> {
    if table.get(key).is_none() {
        let span = target.span.clone();
        let empty = Node::Table(Table { span: span.clone(), entries: Vec::new() });
        let key = Key { name: key.to_owned(), span: span.clone() };
        table.entries.push((key, Value { span, node: empty }));
    }
    table_of(table, key)
}
