//! Reads bushings, which are six-dimensional spring-dampers between two bodies.

use super::context::{Context, Record};
use super::spring::{AnySpring, SpringDraft, SpringSpans};
use crate::document::{Key, Table, Value};
use crate::expression::Measure;
use crate::fields::tables::BUSHING;
use stiction_core::mechanism::{BushingSpec, SixBySix};
use stiction_core::spatial::Pose;

/// Measures of the 3x3 blocks of a 6x6 stiffness or damping matrix: force per displacement (or
/// velocity), coupling, and moment per rotation (or angular velocity).
type Measures = [Measure; 3];

const STIFFNESS: Measures = [Measure::Stiffness, Measure::Force, Measure::AngularStiffness];
const DAMPING: Measures = [Measure::Damping, Measure::Impulse, Measure::AngularDamping];

/// Reads a bushing; `what` describes the bushing in messages.
pub(crate) fn read(context: &Context<'_>, key: &Key, table: &Table, what: &str) -> SpringDraft {
    let record = Record::new(context, table, BUSHING, what);
    if record.value("stiffness").is_none() && record.value("damping").is_none() {
        record.missing_both(["stiffness", "damping"]);
    }
    let frame = |key: &str| match record.value(key) {
        Some(_) => record.table(key).and_then(|table| context.pose(table, &format!("`{key}`"))),
        None => Some(Pose::identity()),
    };
    let (frame_a, frame_b) = (frame("frame"), frame("to_frame"));
    let matrix = |key: &str, measures: Measures| match record.value(key) {
        Some(value) => matrix(context, value, measures),
        None => Some([[0.0; 6]; 6]),
    };
    let (stiffness, damping) = (matrix("stiffness", STIFFNESS), matrix("damping", DAMPING));
    let spec = || {
        let spec = BushingSpec::new(key.name.as_str(), record.text("from")?, record.text("to")?);
        let spec = spec.frames(frame_a?, frame_b?).stiffness(stiffness?);
        Some(AnySpring::Bushing(Box::new(spec.damping(damping?))))
    };
    let spec = spec();
    SpringDraft { name: key.name.clone(), spec, spans: SpringSpans::new(&record, key) }
}

/// Reads a 6x6 matrix, given by the six entries of its diagonal or by six rows of six entries.
fn matrix(context: &Context<'_>, value: &Value, measures: Measures) -> Option<SixBySix> {
    const FORMS: &str = "6 diagonal entries (for x, y, z, rx, ry, rz) or 6 rows of 6 entries";
    let Some(list) = value.as_list().filter(|list| list.len() == 6) else {
        context.wrong(value, FORMS);
        return None;
    };
    let mut matrix = [[0.0; 6]; 6];
    let mut is_complete = true;
    for (i, (row, item)) in matrix.iter_mut().zip(list).enumerate() {
        match item.as_list() {
            None => match context.quantity(item, measures[2 * (i / 3)]) {
                Some(number) => row[i] = number,
                None => is_complete = false,
            },
            Some(items) if items.len() == 6 => {
                for (j, (entry, item)) in row.iter_mut().zip(items).enumerate() {
                    match context.quantity(item, measures[i / 3 + j / 3]) {
                        Some(number) => *entry = number,
                        None => is_complete = false,
                    }
                }
            }
            Some(_) => {
                context.wrong(item, "a row of 6 quantities");
                is_complete = false;
            }
        }
    }
    let rows = list.iter().filter(|item| item.as_list().is_some()).count();
    if rows != 0 && rows != 6 {
        context.wrong(value, FORMS);
        return None;
    }
    is_complete.then_some(matrix)
}
