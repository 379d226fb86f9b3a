//! Reads bodies and their meshes.

use super::context::{Context, Record};
use crate::document::{Key, Table, Value};
use crate::fields::tables::{BODY, VISUAL};
use crate::source::{Place, Span};
use stiction_core::mechanism::BodySpec;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Body as read from a model file, with the places of its values in the text for messages.
pub(crate) struct BodyDraft {
    pub(crate) name: String,
    pub(crate) spec: BodySpec,
    pub(crate) home: Option<Pose<f64>>,
    pub(crate) visuals: Vec<VisualDraft>,
    pub(crate) name_span: Span,
    pub(crate) mass_span: Span,
    pub(crate) inertia_span: Span,
}

/// Mesh of a body, with the place of its file name in the text.
pub(crate) struct VisualDraft {
    pub(crate) file: String,
    pub(crate) place: Place,
    pub(crate) scale: [f64; 3],
    pub(crate) pose: Pose<f64>,
}

/// Reads the meshes of a body.
fn visuals(context: &Context<'_>, value: &Value, what: &str) -> Vec<VisualDraft> {
    let Some(items) = value.as_list() else {
        context.wrong(value, "a list of tables such as [{ mesh = \"arm.stl\" }]");
        return Vec::new();
    };
    let visual = |item: &Value| {
        let Some(table) = item.as_table() else {
            context.wrong(item, "a table such as { mesh = \"arm.stl\" }");
            return None;
        };
        let record = Record::new(context, table, VISUAL, format!("`visual` of {what}"));
        let file = record.text("mesh")?.to_owned();
        let scale = record.vector("scale").map_or([1.0; 3], Vec3::to_array);
        let position = record.vector("position").unwrap_or(Vec3::zero());
        let rotation = record.value("rotation").and_then(|value| context.rotation(value));
        let pose = Pose { position, rotation: rotation.unwrap_or(Mat3::identity()) };
        Some(VisualDraft { file, place: context.place(&record.span("mesh")), scale, pose })
    };
    items.iter().filter_map(visual).collect()
}

/// Reads a body; `what` describes the body in messages.
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
        visuals: record
            .value("visual")
            .map_or_else(Vec::new, |value| visuals(context, value, what)),
        name_span: key.span.clone(),
        mass_span: record.span("mass"),
        inertia_span: record.span("inertia"),
    }
}
