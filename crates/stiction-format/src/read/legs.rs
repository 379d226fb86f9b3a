//! Expands groups of equal legs around an axis into bodies, joints, actuators and springs.

use super::actuator::{self, ActuatorDraft};
use super::body::{self, BodyDraft};
use super::chain::{Chain, Link};
use super::context::{Context, Record};
use super::geometry::about;
use super::joint::{self, JointDraft, LegAttributes};
use super::leg_springs::{self, LegSpring};
use super::names;
use crate::diagnostic::{Diagnostic, did_you_mean, quoted};
use crate::document::{Key, Node, Table, Value};
use crate::expression::Measure;
use crate::fields::tables::{LEGS, PLACE};
use crate::source::Span;
use std::collections::{HashMap, HashSet};
use stiction_core::mechanism::GROUND_NAME;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// A leg: its name, and the names of its joints and bodies.
pub(crate) struct LegDraft {
    pub(crate) name: String,
    pub(crate) joints: Vec<String>,
    pub(crate) bodies: Vec<String>,
}

/// All parts that the legs add to the mechanism.
#[derive(Default)]
pub(crate) struct Expansion {
    pub(crate) bodies: Vec<BodyDraft>,
    pub(crate) joints: Vec<JointDraft>,
    pub(crate) actuators: Vec<ActuatorDraft>,
    pub(crate) springs: Vec<LegSpring>,
    pub(crate) legs: Vec<LegDraft>,
    /// True if some legs are invalid. Names that seem unknown may then be names of parts of these
    /// legs.
    pub(crate) lost: bool,
}

/// Expands all groups of legs; the numbers of the legs continue across groups.
pub(crate) fn read(context: &Context<'_>, value: &Value) -> Expansion {
    let mut all = Expansion::default();
    let groups = match &value.node {
        Node::List(groups) => groups.as_slice(),
        _ => std::slice::from_ref(value),
    };
    for group in groups {
        match group.as_table() {
            Some(table) => read_group(context, table, &mut all),
            None => {
                context.wrong(group, "a table of legs");
                all.lost = true;
            }
        }
    }
    all
}

/// Angle of a leg about the axis of its group, rad, and the table with the values that only this
/// leg has.
struct Placement<'a> {
    angle: f64,
    table: Option<&'a Table>,
}

fn read_group(context: &Context<'_>, table: &Table, all: &mut Expansion) {
    let record = Record::new(context, table, LEGS, "a group of legs");
    let chain = record
        .value("chain")
        .and_then(|value| Chain::read(context, value, record.value("between")));
    let about_axis = match record.value("about") {
        Some(value) => context.axis(value),
        None => Some(Vec3::unit(2)),
    };
    let to = record.text("to").map(|to| (to, record.span("to")));
    let from = match record.value("from") {
        Some(value) => context.text(value, "a quoted body name"),
        None => Some(GROUND_NAME),
    };
    let (placements, complete) = placements(context, &record);
    all.lost |= !complete;
    let (Some(chain), Some(axis), Some(to), Some(from)) = (chain, about_axis, to, from) else {
        all.lost = true;
        return;
    };
    let group = Group {
        context,
        record: &record,
        chain: &chain,
        axis,
        from: (from, record.span("from")),
        to,
        patterns: patterns(context, record.value("names"), &chain),
    };
    group.check_names(|key| record.value(key));
    for placement in placements {
        group.expand(&placement, all);
    }
}

/// Patterns of the names of joints and bodies, by the names in the chain. Each pattern consists of
/// the text before the leg's name, the text after the leg's name, and the place of the pattern.
type Patterns<'a> = HashMap<&'a str, (&'a str, &'a str, Span)>;

fn patterns<'a>(context: &Context<'_>, names: Option<&'a Value>, chain: &'a Chain) -> Patterns<'a> {
    let mut patterns = Patterns::new();
    let Some(names) = names else { return patterns };
    let Some(table) = names.as_table() else {
        context.wrong(names, "a table of names such as { R = \"{}_hinge\" }");
        return patterns;
    };
    let joints = chain.joints.iter().map(|joint| joint.key.as_str());
    let known: Vec<&str> =
        joints.chain(chain.bodies.iter().map(|body| body.key.as_str())).collect();
    for (key, value) in &table.entries {
        if !known.contains(&key.name.as_str()) {
            let message = format!("the chain has no joint or body {}", quoted(&key.name));
            let help = did_you_mean(&key.name, "it has", known.iter().copied());
            context.push(
                Diagnostic::error("unknown-name", message)
                    .at(context.place(&key.span), "not in the chain")
                    .maybe_help(help),
            );
            continue;
        }
        let Some(pattern) = context.text(value, "a quoted name such as \"{}_hinge\"") else {
            continue;
        };
        match pattern.split_once("{}") {
            Some((before, after)) if !after.contains("{}") => {
                patterns.insert(&key.name, (before, after, value.span.clone()));
            }
            _ => context.push(
                Diagnostic::error("legs", "the name must contain {} exactly once")
                    .at(context.place(&value.span), "")
                    .help("{} stands for the name of the leg, such as leg1: \"{}_hinge\""),
            ),
        }
    }
    patterns
}

/// Reads the placements of a group's legs; the flag returned is true if all of them are valid.
fn placements<'a>(context: &'a Context<'a>, record: &Record<'a>) -> (Vec<Placement<'a>>, bool) {
    let mut placements = Vec::new();
    let mut count = 1;
    match (record.value("angles"), record.value("place")) {
        (None, None) => {
            record.missing_both(["angles", "place"]);
        }
        (Some(angles), Some(place)) => context.push(
            Diagnostic::error("legs", "the positions of the legs are given twice")
                .at(context.place(&place.span), "once here")
                .also(context.place(&angles.span), "once here")
                .help(
                    "`angles` is short for a `place` list with angles alone: keep one of the two",
                ),
        ),
        (Some(angles), None) => match angles.as_list() {
            Some([]) => no_legs(context, angles),
            Some(list) => {
                count = list.len();
                placements.extend(list.iter().filter_map(|angle| {
                    Some(Placement { angle: context.quantity(angle, Measure::Angle)?, table: None })
                }));
            }
            None => context.wrong(angles, "a list of angles such as [\"0 deg\", \"120 deg\"]"),
        },
        (None, Some(place)) => match place.as_list() {
            Some([]) => no_legs(context, place),
            Some(list) => {
                count = list.len();
                placements.extend(list.iter().filter_map(|entry| placement(context, entry)));
            }
            None => context.wrong(place, "a list of places such as [{ angle = \"0 deg\" }]"),
        },
    }
    let complete = placements.len() == count;
    (placements, complete)
}

fn placement<'a>(context: &'a Context<'a>, entry: &'a Value) -> Option<Placement<'a>> {
    let Some(table) = entry.as_table() else {
        context.wrong(entry, "a place such as { angle = \"0 deg\" }");
        return None;
    };
    let record = Record::new(context, table, PLACE, "the place of a leg");
    let angle = match record.value("angle") {
        Some(_) => record.quantity("angle")?,
        None => 0.0,
    };
    Some(Placement { angle, table: Some(table) })
}

/// Reports a group without legs: the mechanism without its legs may be valid, but is not the
/// intended mechanism.
fn no_legs(context: &Context<'_>, list: &Value) {
    context.push(
        Diagnostic::error("legs", "this group has no legs")
            .at(context.place(&list.span), "this list is empty")
            .help("list the angle or place of each leg, or delete the group"),
    );
}

struct Group<'a> {
    context: &'a Context<'a>,
    record: &'a Record<'a>,
    chain: &'a Chain,
    axis: Vec3<f64>,
    from: (&'a str, Span),
    to: (&'a str, Span),
    patterns: Patterns<'a>,
}

impl Group<'_> {
    /// Returns the name in the model of a leg's joint or body with this key.
    fn full(&self, leg: &str, key: &str) -> String {
        match self.patterns.get(key) {
            Some((before, after, _)) => format!("{before}{leg}{after}"),
            None => format!("{leg}.{key}"),
        }
    }

    /// Checks the names that the patterns produce for the joints and bodies of a leg.
    fn check_patterns(&self, leg: &str) {
        for (key, (.., span)) in &self.patterns {
            let is_body = self.chain.bodies.iter().any(|body| body.key == *key);
            let kind = if is_body { "body" } else { "joint" };
            names::check(self.context, &self.full(leg, key), span, kind);
        }
    }

    /// Reports keys in the tables of joints, actuators and bodies that are not in the chain.
    fn check_names<'v>(&self, value: impl Fn(&str) -> Option<&'v Value>) {
        let of = |value: Option<&Value>, kind: &str, known: Vec<&str>| {
            let table = value.and_then(Value::as_table);
            for (key, _) in table.into_iter().flat_map(|table| &table.entries) {
                if !known.contains(&key.name.as_str()) {
                    let message = format!("the chain has no {kind} {}", quoted(&key.name));
                    let help = did_you_mean(&key.name, "it has", known.iter().copied());
                    self.context.push(
                        Diagnostic::error("unknown-name", message)
                            .at(self.context.place(&key.span), "not in the chain")
                            .maybe_help(help),
                    );
                }
            }
        };
        let joints: Vec<_> = self.chain.joints.iter().map(|joint| joint.key.as_str()).collect();
        of(value("joints"), "joint", joints.clone());
        of(value("actuators"), "joint", joints);
        of(
            value("bodies"),
            "body",
            self.chain.bodies.iter().map(|body| body.key.as_str()).collect(),
        );
    }

    fn expand(&self, placement: &Placement<'_>, all: &mut Expansion) {
        let context = self.context;
        let own = |key: &str| placement.table.and_then(|table| table.get(key));
        let name = match own("name") {
            Some(value) => {
                let Some(name) = context.text(value, "a quoted name") else {
                    all.lost = true;
                    return;
                };
                names::check(context, name, &value.span, "leg");
                if all.legs.iter().any(|leg| leg.name == name) {
                    context.push(
                        Diagnostic::error(
                            "duplicate",
                            format!("two legs are named {}", quoted(name)),
                        )
                        .at(context.place(&value.span), "already used"),
                    );
                    return;
                }
                name.to_owned()
            }
            None => format!("leg{}", all.legs.len() + 1),
        };
        if placement.table.is_some() {
            self.check_names(own);
        }
        let turn = about(self.axis, placement.angle);
        let origin = |key: &str| match own(key).or_else(|| self.record.value(key)) {
            Some(value) => context.vector(value, Measure::Length),
            None => {
                self.record.missing(key, "");
                None
            }
        };
        // An invalid origin has been reported.
        let foot = origin("foot").unwrap_or(Vec3::zero());
        let tip = origin("tip").unwrap_or(Vec3::zero());

        self.check_patterns(&name);
        let full = |link: &Link| self.full(&name, &link.key);
        for link in &self.chain.bodies {
            let table = self.merged("bodies", link, placement);
            let what = format!("body `{}` of the legs", link.key);
            let key = Key { name: link.key.clone(), span: link.span.clone() };
            let mut body = body::read(context, full(link), &key, &table, &what);
            body.home = body.home.and_then(|home| self.placed_home(home, turn, &table));
            all.bodies.push(body);
        }
        let last = self.chain.joints.len().saturating_sub(1);
        let ends: Vec<String> = self.chain.bodies.iter().map(full).collect();
        let keys = self.chain.bodies.iter().map(|body| body.key.clone());
        let bodies: Vec<(String, String)> = keys.zip(ends.iter().cloned()).collect();
        for (i, link) in self.chain.joints.iter().enumerate() {
            let inner = |k: Option<usize>| k.and_then(|k| ends.get(k)).map(String::as_str);
            let span = &link.span;
            let from = inner(i.checked_sub(1)).map(|body| (body, span.clone()));
            let to = inner(Some(i)).map(|body| (body, span.clone()));
            let attributes = LegAttributes {
                joint_type: link.joint_type,
                actuated: link.actuated,
                from: from.unwrap_or_else(|| self.from.clone()),
                to: to.unwrap_or_else(|| self.to.clone()),
                first: (i == 0).then_some((foot, turn)),
                last: (i == last).then_some((tip, turn)),
            };
            let table = self.merged("joints", &link.link(), placement);
            let what = format!("joint `{}` of the legs", link.key);
            let joint_name = self.full(&name, &link.key);
            let drive = self.merged("actuators", &link.link(), placement);
            if !drive.entries.is_empty() {
                let what = format!("actuator of joint `{}` of the legs", link.key);
                let name = (joint_name.clone(), span);
                let leg = actuator::Leg { joint: &joint_name, bodies: &bodies };
                let draft = actuator::read(context, name, &drive, Some(leg), &what);
                all.actuators.push(draft);
            }
            all.joints.push(joint::read(
                context,
                joint_name,
                span,
                &table,
                Some(&attributes),
                &what,
            ));
        }
        let joints: Vec<String> =
            self.chain.joints.iter().map(|link| self.full(&name, &link.key)).collect();
        let keys = self.chain.joints.iter().map(|link| link.key.clone());
        let keyed: Vec<(String, String)> = keys.zip(joints.iter().cloned()).collect();
        let leg = leg_springs::Leg {
            name: &name,
            bodies: &bodies,
            joints: &keyed,
            ends: [self.from.0, self.to.0],
            turn,
        };
        let springs = self.springs(placement);
        all.springs.extend(springs.iter().map(|(key, table)| leg.spring(context, key, table)));
        all.legs.push(LegDraft { name, joints, bodies: ends });
    }

    /// Returns the tables of one leg's springs: the tables of the group, overridden by the values
    /// of this leg.
    fn springs(&self, placement: &Placement<'_>) -> Vec<(Key, Table)> {
        let of = |table: &Table| table.get("springs").cloned();
        let merged = match (of(self.record.table), placement.table.and_then(of)) {
            (Some(base), Some(own)) => merge(base, own),
            (Some(value), None) | (None, Some(value)) => value,
            (None, None) => return Vec::new(),
        };
        let Node::Table(table) = merged.node else {
            self.context.wrong(&merged, "a table of springs by name");
            return Vec::new();
        };
        let own = table.entries.into_iter().filter_map(|(key, value)| match value.node {
            Node::Table(table) => Some((key, table)),
            _ => {
                self.context.wrong(&value, &format!("a table for {}", quoted(&key.name)));
                None
            }
        });
        own.collect()
    }

    /// Returns the home pose of a leg's body in the ground's frame. The file gives the pose in the
    /// rotated frame of `from`, which must therefore be the ground.
    fn placed_home(&self, home: Pose<f64>, turn: Mat3<f64>, table: &Table) -> Option<Pose<f64>> {
        if self.from.0 == GROUND_NAME {
            return Some(Pose { rotation: turn, position: Vec3::zero() } * home);
        }
        let span = table.get("home").map_or(&table.span, |value| &value.span);
        self.context.push(
            Diagnostic::error("legs", "`home` is only allowed for legs that start from the ground")
                .at(self.context.place(span), "not in the ground's frame")
                .help("use `start` of the joints instead"),
        );
        None
    }

    /// Returns the table of one leg's joint, actuator or body: the table of the group, overridden
    /// by the values of this leg. `kind` is the key of these tables, such as `joints`.
    fn merged(&self, kind: &str, link: &Link, placement: &Placement<'_>) -> Table {
        let of = |table: &Table| {
            table.get(kind).and_then(Value::as_table).and_then(|t| t.get(&link.key)).cloned()
        };
        let (base, own) = (of(self.record.table), placement.table.and_then(of));
        let empty = Table { span: link.span.clone(), entries: Vec::new() };
        match (base, own) {
            (Some(base), Some(own)) => match merge(base, own).node {
                Node::Table(table) => table,
                _ => empty,
            },
            (Some(value), None) | (None, Some(value)) => match value.node {
                Node::Table(table) => table,
                _ => {
                    self.context.wrong(&value, &format!("a table for {}", quoted(&link.key)));
                    empty
                }
            },
            (None, None) => empty,
        }
    }
}

/// Merges `over` into `base` key by key. Tables that represent one value (rotations, inertia) are replaced as a
/// whole.
fn merge(base: Value, over: Value) -> Value {
    const WHOLE: &[&str] = &["turn", "rotation", "inertia", "start", "home"];
    match (base.node, over.node) {
        (Node::Table(mut base), Node::Table(over_table)) => {
            let known: HashSet<String> =
                base.entries.iter().map(|(key, _)| key.name.clone()).collect();
            for (key, value) in over_table.entries {
                if !known.contains(&key.name) {
                    base.entries.push((key, value));
                } else if let Some((_, old)) =
                    base.entries.iter_mut().find(|(known, _)| known.name == key.name)
                {
                    let whole = WHOLE.contains(&key.name.as_str());
                    let before = old.clone();
                    *old = if whole { value } else { merge(before, value) };
                }
            }
            Value { span: base.span.clone(), node: Node::Table(base) }
        }
        (_, node) => Value { span: over.span, node },
    }
}
