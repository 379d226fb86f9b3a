//! Changes of single values of a document, written as `platform.mass = 2 kg`.

use super::{Document, Key, MOST_LEVELS, Node, Table, Text, Value, change_leg, convert};
use crate::diagnostic::{Diagnostic, Diagnostics, did_you_mean, or, quoted};
use crate::fields::tables::{LEGS, MODEL};
use crate::separated::split_outside;
use crate::source::{Place, Source, Span};
use std::sync::Arc;
use toml::de::DeTable;

/// Keys of the tables whose entries are named parts of the model, or parameters. A change never
/// adds an entry to these tables, because a misspelt name would then define a new part.
const NAMED: &[&str] = &[
    "parameters",
    "bodies",
    "joints",
    "springs",
    "bushings",
    "actuators",
    "gearings",
    "motions",
    "loads",
];
/// Keys of those tables in a group of legs whose entries are named parts. The path of a change may
/// omit these keys.
const NAMED_IN_LEGS: &[&str] = &["bodies", "joints", "springs"];

/// Applies the changes that [`Source::with_changes`] attached to `source`, in the order given, to
/// the document of this source.
pub(crate) fn apply(source: &Arc<Source>, document: &mut Document, out: &mut Diagnostics) {
    let Some(changes) = source.changes() else { return };
    let mut begin = source.begin_of_changes();
    for line in changes.text.split('\n') {
        if let Some(diagnostic) = change(source, &mut document.root, line, begin) {
            out.push(diagnostic);
        }
        begin += line.len() + 1;
    }
}

/// Applies one change, written in `line` as `KEY=VALUE`; returns a diagnostic if the change cannot
/// be applied. `begin` is the byte offset of the line.
fn change(source: &Arc<Source>, root: &mut Table, line: &str, begin: usize) -> Option<Diagnostic> {
    let Some((path, value)) = line.split_once('=') else {
        return Some(
            Diagnostic::error("change", "a change needs a key and a value")
                .at(Place::new(source, begin..begin + line.len()), "expected KEY=VALUE")
                .help("for example `bodies.platform.mass=2kg`"),
        );
    };
    let value = read_value(value, begin + path.len() + 1, MOST_LEVELS);
    let at = begin + path.len() - path.trim_start().len();
    let span = at..at + path.trim().len();
    let names = segments(path.trim());
    let target = Target { path: &names, span: &span, value: &value };
    let outcome = target.in_model(root);
    let mut deeper = Vec::new();
    if let (Outcome::Unknown { .. }, [name]) = (&outcome, names.as_slice()) {
        paths_to(name, root, "", &mut deeper);
    }
    let (name, known, error) = match outcome {
        Outcome::Unknown { name, known } => {
            let message = format!("the model has no {}", quoted(&name));
            let error = Diagnostic::error("unknown-key", message);
            (name, known, error.at(Place::new(source, span), "unknown key"))
        }
        Outcome::NotATable { name, others } => {
            let message = format!("{} is a value, which has no keys", quoted(&name));
            let error = Diagnostic::error("change", message);
            (name, others, error.at(Place::new(source, span), "this value has no keys"))
        }
        Outcome::Set => return None,
    };
    if !deeper.is_empty() {
        return Some(error.help(deeper_keys(&name, &deeper)));
    }
    let mut distinct: Vec<&str> = Vec::new();
    for key in &known {
        if !distinct.contains(&key.as_str()) {
            distinct.push(key);
        }
    }
    Some(error.maybe_help(did_you_mean(&name, "known keys", distinct)))
}

/// Collects the paths of all keys `name` in tables below `table`, whose own path is `above`.
fn paths_to(name: &str, table: &Table, above: &str, paths: &mut Vec<String>) {
    for (key, value) in &table.entries {
        let own = match key.name.contains('.') {
            true => format!("\"{}\"", key.name),
            false => key.name.clone(),
        };
        let path = if above.is_empty() { own } else { format!("{above}.{own}") };
        match &value.node {
            Node::Table(inner) => paths_to(name, inner, &path, paths),
            Node::List(list) => {
                for (index, item) in list.iter().enumerate() {
                    if let Node::Table(inner) = &item.node {
                        paths_to(name, inner, &format!("{path}.{}", index + 1), paths);
                    }
                }
            }
            _ => {}
        }
        if key.name == name && !above.is_empty() {
            paths.push(path);
        }
    }
}

/// Returns advice for a change of a key without the tables that contain it.
fn deeper_keys(name: &str, paths: &[String]) -> String {
    const MOST: usize = 3;
    let shown: Vec<String> = paths.iter().take(MOST).map(|path| quoted(path)).collect();
    match paths {
        [_] => format!("write the whole path: {}", or(&shown)),
        _ => format!(
            "{} tables have a key {}; write a whole path, for example {}, or let these keys use a \
             parameter and change the parameter",
            paths.len(),
            quoted(name),
            or(&shown)
        ),
    }
}

/// Splits a key path at its dots; a quoted component may contain dots.
pub(crate) fn segments(path: &str) -> Vec<String> {
    let mut parts = vec![String::new()];
    let mut quote = None;
    for letter in path.chars() {
        match (letter, quote) {
            ('"' | '\'', None) => quote = Some(letter),
            (letter, Some(open)) if letter == open => quote = None,
            ('.', None) => parts.push(String::new()),
            (letter, _) => {
                if let Some(part) = parts.last_mut() {
                    part.push(letter);
                }
            }
        }
    }
    parts.iter().map(|part| part.trim().to_owned()).collect()
}

/// Parses the value of a change as TOML. Text that is not valid TOML is read as an unquoted string, or
/// as a list of such texts.
/// `begin` is the byte offset of `written`, and `levels` the largest number of nested lists.
fn read_value(written: &str, begin: usize, levels: usize) -> Value {
    const KEY: &str = "v=";
    let text = format!("{KEY}{written}");
    if let Ok(table) = DeTable::parse(&text)
        && let Some((_, value)) = table.get_ref().iter().next()
    {
        let mut value = convert(value, &text, 1);
        // The parsed text begins with `KEY`, which the source does not contain.
        move_by(&mut value, begin.wrapping_sub(KEY.len()));
        return value;
    }
    let start = begin + written.len() - written.trim_start().len();
    let content = written.trim().to_owned();
    let span = start..start + content.len();
    // Entries of a list need no quotes either.
    let list = content.strip_prefix('[').and_then(|rest| rest.strip_suffix(']'));
    if let Some(inner) = list.filter(|_| levels > 0)
        && let Some(mut items) = split_outside(inner, &(0..inner.len()), ',')
    {
        // A comma may follow the last entry.
        items.pop_if(|last| inner.get(last.clone()).is_some_and(|text| text.trim().is_empty()));
        let items = items.into_iter().map(|item| {
            let text = inner.get(item.clone()).unwrap_or_default();
            read_value(text, start + 1 + item.start, levels - 1)
        });
        return Value { span, node: Node::List(items.collect()) };
    }
    Value { span, node: Node::Text(Text { content, start: Some(start) }) }
}

/// Shifts the byte ranges of a value and of all values in it by `offset`.
fn move_by(value: &mut Value, offset: usize) {
    let moved = |span: &mut Span| {
        *span = span.start.wrapping_add(offset)..span.end.wrapping_add(offset);
    };
    moved(&mut value.span);
    match &mut value.node {
        Node::Text(text) => text.start = text.start.map(|start| start.wrapping_add(offset)),
        Node::List(list) => list.iter_mut().for_each(|item| move_by(item, offset)),
        Node::Table(table) => {
            moved(&mut table.span);
            for (key, value) in &mut table.entries {
                moved(&mut key.span);
                move_by(value, offset);
            }
        }
        Node::Number(_) | Node::Flag(_) | Node::Other => {}
    }
}

pub(super) enum Outcome {
    Set,
    /// No key has this name; `known` lists the names that exist at this point of the path.
    Unknown {
        name: String,
        known: Vec<String>,
    },
    /// The path continues below a value that is no table; `others` lists names that the path may
    /// have meant.
    NotATable {
        name: String,
        others: Vec<String>,
    },
}

/// A change to apply: the new value, and the path of the key that receives this value.
#[derive(Clone, Copy)]
pub(super) struct Target<'a> {
    pub(super) path: &'a [String],
    pub(super) span: &'a Span,
    pub(super) value: &'a Value,
}

impl Target<'_> {
    /// Sets the value in the model. The path begins with a top-level key of the model file, or
    /// directly with the name of a parameter or part, without the key of its table.
    fn in_model(&self, root: &mut Table) -> Outcome {
        let first = self.path.first().map(String::as_str).unwrap_or_default();
        if MODEL.iter().any(|field| field.key == first) {
            if let Some(outcome) = self.in_one_leg(root) {
                return outcome;
            }
            return self.in_table(root, !NAMED.contains(&first) && first != "legs", first);
        }
        let mut known: Vec<String> = Vec::new();
        let mut within = None;
        for kind in NAMED {
            let Some(table) = table_of(root, kind) else { continue };
            // Names may contain dots.
            let begins =
                |name: &str| (1..=self.path.len()).any(|n| self.path[..n].join(".") == name);
            let has_part = table.entries.iter().any(|(key, _)| begins(&key.name));
            match self.in_table(table, false, kind) {
                Outcome::Set => return Outcome::Set,
                // A parameter may have the name of a body.
                outcome if has_part => match (&within, &outcome) {
                    (Some(Outcome::Unknown { .. }), _) => {}
                    _ => within = Some(outcome),
                },
                _ => known.extend(table.entries.iter().map(|(key, _)| key.name.clone())),
            }
        }
        if let Some(outcome) = self.in_one_leg(root) {
            return outcome;
        }
        if let Some((_, legs)) = root.entries.iter_mut().find(|(key, _)| key.name == "legs") {
            match self.in_legs(legs) {
                Outcome::Unknown { known: of_legs, .. } => known.extend(of_legs),
                outcome => return outcome,
            }
        }
        match within {
            Some(Outcome::NotATable { name, .. }) if name == first => {
                return Outcome::NotATable { name, others: known };
            }
            Some(outcome) => return outcome,
            None => {}
        }
        known.extend(MODEL.iter().map(|field| field.key.to_owned()));
        Outcome::Unknown { name: first.to_owned(), known }
    }

    /// Sets the value of a part of a single leg. The path contains the name of the part in the
    /// model, such as `leg2.rod`. Returns `None` if the path does not name a part of a leg.
    fn in_one_leg(&self, root: &mut Table) -> Option<Outcome> {
        let (_, legs) = root.entries.iter_mut().find(|(key, _)| key.name == "legs")?;
        change_leg::set(self, legs)
    }

    /// Sets the value in a table. `open` permits a new key, which is checked later, when the
    /// document is read. `parent` is the key of the table; for the root it is the first key of the
    /// path.
    pub(super) fn in_table(&self, table: &mut Table, open: bool, parent: &str) -> Outcome {
        let names = |table: &Table| table.entries.iter().map(|(key, _)| key.name.clone()).collect();
        // Names may contain dots: try the longest existing name first.
        for count in (1..=self.path.len()).rev() {
            let (name, rest) = self.path.split_at(count);
            let name = name.join(".");
            let Some(entry) = table.entries.iter_mut().find(|(key, _)| key.name == name) else {
                continue;
            };
            let inner = Target { path: rest, ..*self };
            let open = !(NAMED.contains(&name.as_str()) && parent == name);
            return inner.in_value(&mut entry.1, open, &name);
        }
        if parent == "legs" {
            let Outcome::Unknown { name, mut known } = self.in_parts_of_legs(table) else {
                return Outcome::Set;
            };
            // A key may be new if it ends the path or is a key of the table `legs`; a part may not
            // be new.
            if !open || self.path.len() > 1 && LEGS.iter().all(|field| field.key != name) {
                known.extend(names(table));
                return Outcome::Unknown { name, known };
            }
        }
        match self.path {
            [first, ..] if !open => Outcome::Unknown { name: first.clone(), known: names(table) },
            [] => Outcome::NotATable { name: parent.to_owned(), others: Vec::new() },
            [name] => {
                let key = Key { name: name.clone(), span: self.span.clone() };
                table.entries.push((key, self.value.clone()));
                Outcome::Set
            }
            [name, rest @ ..] => {
                let mut inner = Table { span: self.span.clone(), entries: Vec::new() };
                let outcome = Target { path: rest, ..*self }.in_table(&mut inner, true, name);
                let key = Key { name: name.clone(), span: self.span.clone() };
                let value = Value { span: self.span.clone(), node: Node::Table(inner) };
                table.entries.push((key, value));
                outcome
            }
        }
    }

    /// Sets the value of a part in every group of legs that contains this part. The path begins
    /// with the name of the part, without the key of its table.
    fn in_legs(&self, legs: &mut Value) -> Outcome {
        match &mut legs.node {
            Node::Table(group) => self.in_parts_of_legs(group),
            Node::List(groups) => {
                let mut last = self.unknown(Vec::new());
                let mut set = false;
                for group in groups {
                    let Node::Table(group) = &mut group.node else { continue };
                    match self.in_parts_of_legs(group) {
                        Outcome::Set => set = true,
                        outcome => last = outcome,
                    }
                }
                if set { Outcome::Set } else { last }
            }
            _ => self.unknown(Vec::new()),
        }
    }

    /// Sets the value of a part in one group of legs. The path begins with the name of the part,
    /// without the key of its table.
    fn in_parts_of_legs(&self, group: &mut Table) -> Outcome {
        let mut known = Vec::new();
        for kind in NAMED_IN_LEGS {
            let Some(parts) = table_of(group, kind) else { continue };
            if let Outcome::Set = self.in_table(parts, false, kind) {
                return Outcome::Set;
            }
            known.extend(parts.entries.iter().map(|(key, _)| key.name.clone()));
        }
        self.unknown(known)
    }

    fn unknown(&self, known: Vec<String>) -> Outcome {
        Outcome::Unknown { name: self.path.first().cloned().unwrap_or_default(), known }
    }

    fn in_value(&self, value: &mut Value, open: bool, parent: &str) -> Outcome {
        if self.path.is_empty() {
            *value = self.value.clone();
            return Outcome::Set;
        }
        match &mut value.node {
            Node::Table(table) => self.in_table(table, open, parent),
            Node::List(list) => self.in_list(list, parent),
            _ => Outcome::NotATable { name: parent.to_owned(), others: Vec::new() },
        }
    }

    /// Sets the value in entries of a list. If the path begins with a number, the number selects
    /// one entry, counted from 1. Otherwise, the value is set in all entries that have the key.
    fn in_list(&self, list: &mut [Value], parent: &str) -> Outcome {
        let count = list.len();
        if let [first, rest @ ..] = self.path
            && let Ok(number) = first.parse::<usize>()
        {
            let inner = Target { path: rest, ..*self };
            return match number.checked_sub(1).and_then(|index| list.get_mut(index)) {
                Some(entry) => inner.in_value(entry, true, parent),
                None => Outcome::Unknown {
                    name: format!("{parent}.{number}"),
                    known: (1..=count.min(4)).map(|n| format!("{parent}.{n}")).collect(),
                },
            };
        }
        let mut last = Outcome::NotATable { name: parent.to_owned(), others: Vec::new() };
        let mut set = false;
        for entry in list {
            match self.in_value(entry, count == 1, parent) {
                Outcome::Set => set = true,
                outcome => last = outcome,
            }
        }
        if set { Outcome::Set } else { last }
    }
}

pub(super) fn table_of<'a>(table: &'a mut Table, key: &str) -> Option<&'a mut Table> {
    let (_, value) = table.entries.iter_mut().find(|(known, _)| known.name == key)?;
    match &mut value.node {
        Node::Table(table) => Some(table),
        _ => None,
    }
}
