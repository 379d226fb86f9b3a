//! Reader of springs.

use super::check_values::check_values;
use super::context::{Context, Record};
use crate::document::{Key, Table};
use crate::fields::tables::SPRING;
use crate::source::Span;
use stiction_core::mechanism::SpringSpec;
use stiction_core::spatial::Vec3;

/// A spring with the places of its parts.
pub(crate) struct SpringDraft {
    pub(crate) name: String,
    /// `None` if its bodies or ends are invalid.
    pub(crate) spec: Option<SpringSpec>,
    pub(crate) spans: SpringSpans,
}

/// Places of the parts of a spring.
pub(crate) struct SpringSpans {
    pub(crate) name: Span,
    pub(crate) from: Span,
    pub(crate) to: Span,
    pub(crate) stiffness: Span,
    pub(crate) free_length: Span,
    pub(crate) damping: Span,
}

/// Reads a spring; `what` describes it in messages.
pub(crate) fn read(context: &Context<'_>, key: &Key, table: &Table, what: &str) -> SpringDraft {
    let record = Record::new(context, table, SPRING, what);
    if record.value("stiffness").is_none() && record.value("damping").is_none() {
        record.missing_both(["stiffness", "damping"]);
    }
    if record.value("stiffness").is_some() && record.value("free_length").is_none() {
        record.missing("free_length", ", though it has a stiffness");
    }
    SpringDraft {
        name: key.name.clone(),
        spec: spec(&record, key),
        spans: SpringSpans {
            name: key.span.clone(),
            from: record.span("from"),
            to: record.span("to"),
            stiffness: record.span("stiffness"),
            free_length: record.span("free_length"),
            damping: record.span("damping"),
        },
    }
}

fn spec(record: &Record<'_>, key: &Key) -> Option<SpringSpec> {
    let (Some(from), Some(to)) = (record.text("from"), record.text("to")) else {
        check_values(record, SPRING);
        return None;
    };
    let end = |key: &str| match record.value(key) {
        Some(_) => record.vector(key),
        None => Some(Vec3::zero()),
    };
    let number = |key: &str| record.quantity(key).unwrap_or(0.0);
    let (at, to_at) = (end("at"), end("to_at"));
    let (stiffness, free_length, damping) =
        (number("stiffness"), number("free_length"), number("damping"));
    let spec = SpringSpec::new(key.name.as_str(), from, to)
        .points(at?, to_at?)
        .stiffness(stiffness, free_length)
        .damping(damping);
    Some(spec)
}
