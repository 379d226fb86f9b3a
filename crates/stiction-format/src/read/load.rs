//! Reads external loads and payloads.

use super::context::{Context, Record};
use super::measured::{self, Effort};
use super::names::Names;
use super::path::{Leaf, leaves};
use crate::diagnostic::{Diagnostic, did_you_mean, number, quoted};
use crate::document::{Key, Table, Value};
use crate::expression::Measure;
use crate::fields::tables::{BODY_LOAD, LOAD, PAYLOAD};
use crate::model_file::{AppliedWrench, LoadCase, LoadLaw, Payload};
use crate::signal::Signal;
use stiction_core::dynamics::LoadAxes;
use stiction_core::mechanism::{Body, BodyId, GROUND_NAME};
use stiction_core::spatial::{Mat3, Vec3};

/// Reads a load case.
pub(crate) fn read(context: &Context<'_>, names: &Names, table: &Table) -> LoadCase {
    let record = Record::open(context, table, LOAD, "a load");
    let title = record.line("title");
    // Entries of the load on each body, in the order of the text.
    let mut bodies: Vec<(BodyId, Table)> = Vec::new();
    // If a body is named `payload`, its load is a table, whereas payloads are a list.
    let list = table.get("payload").and_then(Value::as_list);
    let own = if list.is_some() { LOAD } else { LOAD.get(..1).unwrap_or_default() };
    let found = leaves(table, own);
    for leaf in &found {
        if context.is_full() {
            break;
        }
        let Some((body, key)) = owner(context, names, leaf) else { continue };
        let known = bodies.iter().position(|(known, _)| *known == body);
        let index = known.unwrap_or_else(|| {
            bodies.push((body, Table { span: leaf.key.clone(), entries: Vec::new() }));
            bodies.len() - 1
        });
        if let (Some(value), Some((_, table))) = (leaf.value, bodies.get_mut(index)) {
            let key = Key { name: key.to_owned(), span: leaf.key.clone() };
            table.entries.push((key, value.clone()));
        }
    }
    let mut laws = Vec::new();
    let wrenches = bodies
        .iter()
        .filter_map(|(body, table)| wrench(context, names, (*body, table), &mut laws))
        .collect();
    let payloads = list.unwrap_or_default().iter();
    let payloads = payloads.filter_map(|entry| payload(context, names, entry)).collect();
    LoadCase { title, wrenches, laws, payloads }
}

/// Reads a payload.
fn payload(context: &Context<'_>, names: &Names, entry: &Value) -> Option<Payload> {
    let Some(table) = entry.as_table() else {
        context.wrong(entry, "a table such as [[loads.NAME.payload]]");
        return None;
    };
    let record = Record::new(context, table, PAYLOAD, "a payload");
    let name = record.text("body");
    let mass = record.quantity("mass");
    let com = match record.value("com") {
        Some(_) => record.vector("com"),
        None => Some(Vec3::zero()),
    };
    let inertia = match record.value("inertia") {
        Some(value) => context.inertia(value),
        None => Some(Mat3::zero()),
    };
    let time = |key: &str, default: f64| match record.value(key) {
        Some(_) => record.quantity(key),
        None => Some(default),
    };
    let (from, until) = (time("from", f64::NEG_INFINITY), time("until", f64::INFINITY));
    let refuse = |key: &str, message: String, label: &str| {
        context
            .push(Diagnostic::error("range", message).at(context.place(&record.span(key)), label));
    };
    if let Some(mass) = mass.filter(|mass| *mass <= 0.0) {
        refuse(
            "mass",
            format!("`mass` is {} kg, but must be greater than 0", number(mass)),
            "out of range",
        );
        return None;
    }
    let (from, until) = (from?, until?);
    if until <= from {
        let message = format!(
            "the part is placed at {} s, but picked up at {} s",
            number(until),
            number(from)
        );
        refuse("until", message, "expected a later time");
        return None;
    }
    let name = name?;
    let body = match names.body(name) {
        Some(BodyId::GROUND) | None => {
            if names.body(name).is_some() || !names.may_be_lost(name) {
                let near = did_you_mean(name, "bodies", names.body_names());
                let message = format!("no moving body has the name {}", quoted(name));
                context.push_missing(
                    Diagnostic::error("unknown-name", message)
                        .at(context.place(&record.span("body")), "unknown body")
                        .maybe_help(near),
                );
            }
            return None;
        }
        Some(body) => body,
    };
    let part =
        Body { name: format!("payload of {name}"), mass: mass?, com: com?, inertia: inertia? };
    Some(Payload { body, part, from, until })
}

/// Splits a path into a body and a key of the load on this body; reports an unknown body.
fn owner<'a>(
    context: &Context<'_>,
    names: &Names,
    leaf: &'a Leaf<'_>,
) -> Option<(BodyId, &'a str)> {
    let path = leaf.path.as_str();
    let (body, key) = match leaf.value {
        Some(_) => path.rsplit_once('.').unwrap_or((path, "")),
        None => (path, ""),
    };
    if leaf.value.is_some() && names.body(path).is_some() {
        context.push(
            Diagnostic::error("wrong-type", format!("the load on {} is missing", quoted(path)))
                .at(context.place(&leaf.key), "a body")
                .help(format!("for example `{path}.force = [\"20 N\", 0, 0]`")),
        );
        return None;
    }
    match names.body(body) {
        Some(BodyId::GROUND) => {
            context.push(
                Diagnostic::error("unknown-name", "a load on the ground has no effect")
                    .at(context.place(&leaf.owner), "the ground")
                    .maybe_help(did_you_mean(GROUND_NAME, "bodies", names.body_names())),
            );
            None
        }
        Some(id) => Some((id, key)),
        None if !context.broken.is_empty() || names.may_be_lost(body) => None,
        None => {
            let near = did_you_mean(body, "bodies", names.body_names());
            context.push_missing(
                Diagnostic::error("unknown-name", format!("there is no body {}", quoted(body)))
                    .at(context.place(&leaf.owner), "unknown body")
                    .maybe_help(near),
            );
            None
        }
    }
}

fn wrench(
    context: &Context<'_>,
    names: &Names,
    (body, table): (BodyId, &Table),
    laws: &mut Vec<LoadLaw>,
) -> Option<AppliedWrench> {
    if table.entries.is_empty() {
        return None;
    }
    let record = Record::new(context, table, BODY_LOAD, "the load on a body");
    let force = components((context, names), &record, "force", ["fx", "fy", "fz"], Measure::Force);
    let moment =
        components((context, names), &record, "moment", ["mx", "my", "mz"], Measure::Moment);
    let point = match record.value("at") {
        Some(_) => record.vector("at"),
        None => Some(Vec3::zero()),
    };
    let axes = match record.value("axes") {
        Some(_) => record.choice("axes"),
        None => Some("world"),
    };
    let (point, axes) = (point?, if axes? == "body" { LoadAxes::Body } else { LoadAxes::World });
    let mut signals = |efforts: [Effort; 3], first: usize| {
        let mut component = first;
        efforts.map(|effort| {
            component += 1;
            match effort {
                Effort::Signal(signal) => signal,
                Effort::Law(law) => {
                    laws.push(LoadLaw { body, point, axes, component: component - 1, law });
                    Signal::constant(0.0)
                }
            }
        })
    };
    let (force, moment) = (signals(force?, 0), signals(moment?, 3));
    Some(AppliedWrench { body, point, axes, force, moment })
}

/// Reads the three components of a force or moment, given as a list under the key `whole` or
/// individually under the keys `single`.
fn components(
    (context, names): (&Context<'_>, &Names),
    record: &Record<'_>,
    whole: &str,
    single: [&str; 3],
    measure: Measure,
) -> Option<[Effort; 3]> {
    let given = single.iter().find_map(|key| Some((*key, record.value(key)?)));
    let Some(value) = record.value(whole) else {
        let [x, y, z] = single.map(|key| match record.value(key) {
            Some(value) => measured::effort(context, names, value, measure),
            None => Some(Effort::Signal(Signal::constant(0.0))),
        });
        return Some([x?, y?, z?]);
    };
    if let Some((key, other)) = given {
        context.push(
            Diagnostic::error("duplicate", format!("the {whole} is given twice"))
                .at(context.place(&other.span), format!("`{key}` here"))
                .also(context.place(&value.span), format!("`{whole}` here")),
        );
    }
    let each = format!("{whole}s");
    let [x, y, z] =
        context.three(value, &each)?.map(|item| measured::effort(context, names, item, measure));
    Some([x?, y?, z?])
}
