//! Reads rigid gearings, which couple the coordinates of several joints.

use super::context::{Context, Record};
use crate::document::{Key, Table};
use crate::expression::Measure;
use crate::fields::tables::GEARING;
use crate::source::Span;
use stiction_core::joint::JointType;
use stiction_core::mechanism::GearingSpec;

/// Gearing as read from a model file, with the places of its values in the text for messages.
pub(crate) struct GearingDraft {
    pub(crate) name: String,
    /// Specification of the gearing; `None` if its joints are missing or a number is invalid.
    pub(crate) spec: Option<GearingSpec>,
    pub(crate) name_span: Span,
    pub(crate) joints_span: Span,
}

/// Reads a gearing. `what` describes the gearing in messages; `type_of` returns the type of the
/// joint with this name.
pub(crate) fn read(
    context: &Context<'_>,
    key: &Key,
    table: &Table,
    what: &str,
    type_of: impl Fn(&str) -> Option<JointType>,
) -> GearingDraft {
    let record = Record::new(context, table, GEARING, what);
    // The name is the name of a joint with one degree of freedom, or has the form `joint.dof`.
    let translates = |name: &str| {
        let own = type_of(name).and_then(|joint_type| joint_type.dofs().first());
        let named = || {
            let (joint, dof) = name.rsplit_once('.')?;
            type_of(joint)?.dofs().iter().find(|known| known.name == dof)
        };
        own.or_else(named).is_some_and(|dof| dof.translates())
    };
    let entries = record.table("joints").map_or(&[][..], |joints| &joints.entries[..]);
    let is_length = entries.iter().any(|(joint, _)| translates(&joint.name));
    let coefficient = |joint: &str| match is_length && !translates(joint) {
        true => Measure::Pitch,
        false => Measure::Number,
    };
    let joints: Vec<Option<(String, f64)>> = entries
        .iter()
        .map(|(joint, value)| {
            let value = context.quantity(value, coefficient(&joint.name))?;
            Some((joint.name.clone(), value))
        })
        .collect();
    let offset = match record.value("offset") {
        Some(value) => {
            context.quantity(value, if is_length { Measure::Length } else { Measure::Angle })
        }
        None => Some(0.0),
    };
    let joints: Option<Vec<(String, f64)>> = joints.into_iter().collect();
    let given = joints.filter(|_| record.value("joints").is_some());
    let spec = given
        .zip(offset)
        .map(|(joints, offset)| GearingSpec::new(key.name.as_str(), joints).offset(offset));
    GearingDraft {
        name: key.name.clone(),
        spec,
        name_span: key.span.clone(),
        joints_span: record.span("joints"),
    }
}
