//! Reader of bodies.

use super::context::{Context, Record};
use crate::document::{Key, Table};
use crate::fields::tables::BODY;
use crate::source::Span;
use stiction_core::mechanism::BodySpec;
use stiction_core::spatial::Pose;

/// A body with the places of its parts.
pub(crate) struct BodyDraft {
    pub(crate) name: String,
    pub(crate) spec: BodySpec,
    pub(crate) home: Option<Pose<f64>>,
    pub(crate) name_span: Span,
    pub(crate) mass_span: Span,
    pub(crate) inertia_span: Span,
}

/// Reads a body; `what` describes it in messages.
pub(crate) fn read(
    context: &Context<'_>,
    name: String,
    key: &Key,
    table: &Table,
    what: &str,
) -> BodyDraft {
    let record = Record::new(context, table, BODY, what);
    let mut spec = BodySpec::new(name.as_str());
    // If the mass is invalid, it is unknown which other keys are required.
    let mass = record.quantity("mass");
    if let Some(mass) = mass {
        spec = spec.mass(mass);
    }
    for key in ["com", "inertia"] {
        if mass.is_some_and(|mass| mass > 0.0) && record.value(key).is_none() {
            record.missing(key, ", though it has a mass");
        }
    }
    if let Some(com) = record.vector("com") {
        spec = spec.com(com);
    }
    if let Some(inertia) = record.value("inertia").and_then(|value| context.inertia(value)) {
        spec = spec.inertia(inertia);
    }
    let home = record.table("home").and_then(|home| context.pose(home, "`home`"));
    BodyDraft {
        name,
        spec,
        home,
        name_span: key.span.clone(),
        mass_span: record.span("mass"),
        inertia_span: record.span("inertia"),
    }
}
