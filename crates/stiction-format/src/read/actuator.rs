//! Reads drive trains from the tables of actuators.

use super::check_values::check_values;
use super::context::{Context, Record};
use crate::diagnostic::Diagnostic;
use crate::document::Table;
use crate::expression::Measure;
use crate::fields::tables::{
    ACTUATOR, LEG_ACTUATOR, MESH, MOTOR_FRICTION, MOTOR_LIMITS, ROTOR_AXIS,
};
use crate::source::Span;
use std::f64::consts::TAU;
use stiction_core::mechanism::{DriveTrainSpec, GearLoss, Mesh, MotorFriction, MotorLimits};

/// Drive train as read from a model file, with the places of its values in the text for messages.
pub(crate) struct ActuatorDraft {
    pub(crate) name: String,
    /// Specification of the drive train; `None` if the table has an error that leaves the drive
    /// train undefined.
    pub(crate) spec: Option<DriveTrainSpec>,
    pub(crate) spans: ActuatorSpans,
}

/// Places of the name, joint and values of a drive train in the text.
pub(crate) struct ActuatorSpans {
    pub(crate) name: Span,
    pub(crate) joint: Span,
    /// Places of the values by key; `table.key` for keys of inner tables.
    pub(crate) values: Vec<(String, Span)>,
}

/// Names in a leg that are needed to read a drive train of this leg.
#[derive(Clone, Copy)]
pub(crate) struct Leg<'a> {
    /// Joint that the drive train moves.
    pub(crate) joint: &'a str,
    /// Bodies of the leg, each with its name in the chain and its name in the model.
    pub(crate) bodies: &'a [(String, String)],
}

/// Reads a drive train. `leg` is `None` unless the drive train belongs to a leg; `what` describes
/// the drive train in messages.
pub(crate) fn read(
    context: &Context<'_>,
    (name, span): (String, &Span),
    table: &Table,
    leg: Option<Leg<'_>>,
    what: &str,
) -> ActuatorDraft {
    let fields = if leg.is_some() { LEG_ACTUATOR } else { ACTUATOR };
    let record = Record::new(context, table, fields, what);
    let driven = match leg {
        Some(leg) => Some(vec![(leg.joint.to_owned(), 1.0)]),
        None => driven_joints(&record, what),
    };
    let mut values = Vec::new();
    for (key, value) in &table.entries {
        values.push((key.name.clone(), value.span.clone()));
        let inner = value.as_table().into_iter().flat_map(|inner| &inner.entries);
        values
            .extend(inner.map(|(inner, value)| {
                (format!("{}.{}", key.name, inner.name), value.span.clone())
            }));
    }
    let joint = table.get("joint").or_else(|| table.get("joints"));
    let spans = ActuatorSpans {
        name: span.clone(),
        joint: joint.map_or(span, |value| &value.span).clone(),
        values,
    };
    let spec = match driven {
        Some(driven) => {
            spec(&record, &name, driven, what).map(|spec| with_axis(&record, spec, leg, what))
        }
        None => {
            check_values(&record, fields);
            None
        }
    };
    ActuatorDraft { name, spec, spans }
}

/// Reads the names of the joints that a motor drives, each with a coefficient: the number in the
/// table `joints`, or 1 for the key `joint`.
fn driven_joints(record: &Record<'_>, what: &str) -> Option<Vec<(String, f64)>> {
    let context = record.context;
    match (record.value("joint"), record.value("joints")) {
        (Some(joint), Some(joints)) => {
            context.push(
                Diagnostic::error("actuator", format!("the joints of {what} are given twice"))
                    .at(context.place(&joint.span), "once here")
                    .also(context.place(&joints.span), "once here")
                    .help("use `joint` for one joint, or `joints` for several joints with coefficients"),
            );
            None
        }
        (None, None) => {
            record.missing("joint", "");
            None
        }
        (Some(_), None) => Some(vec![(record.text("joint")?.to_owned(), 1.0)]),
        (None, Some(_)) => coefficients(record, "joints"),
    }
}

/// Reads the table under `key`, which contains a coefficient for each joint name.
pub(crate) fn coefficients(record: &Record<'_>, key: &str) -> Option<Vec<(String, f64)>> {
    let table = record.table(key)?;
    let each = table.entries.iter().map(|(joint, value)| {
        Some((joint.name.clone(), record.context.quantity(value, Measure::Number)?))
    });
    // All values are read, so that each error is reported.
    each.collect::<Vec<_>>().into_iter().collect()
}

/// Reads the axis of a spinning rotor and adds it to the specification.
fn with_axis(
    record: &Record<'_>,
    spec: DriveTrainSpec,
    leg: Option<Leg<'_>>,
    what: &str,
) -> DriveTrainSpec {
    let Some(table) = record.table("rotor_axis") else { return spec };
    let own = Record::new(record.context, table, ROTOR_AXIS, format!("`rotor_axis` of {what}"));
    let (body, axis) = (own.text("body"), own.value("axis"));
    if axis.is_none() {
        own.missing("axis", "");
    }
    let axis = axis.and_then(|axis| record.context.axis(axis));
    let (Some(body), Some(axis)) = (body, axis) else { return spec };
    let of_leg = leg.into_iter().flat_map(|leg| leg.bodies);
    let full = of_leg.clone().find(|(key, _)| key == body).map(|(_, full)| full.as_str());
    spec.rotor_axis(full.unwrap_or(body), axis)
}

fn spec(
    record: &Record<'_>,
    name: &str,
    joints: Vec<(String, f64)>,
    what: &str,
) -> Option<DriveTrainSpec> {
    let inner = |key: &str, fields| {
        let table = record.table(key)?;
        Some(Record::new(record.context, table, fields, format!("`{key}` of {what}")))
    };
    let mut spec = DriveTrainSpec::of_joints(name, joints);
    if let Some(ratio) = record.quantity("ratio") {
        spec = spec.ratio(ratio);
    }
    let lead = record.quantity("lead");
    match lead {
        Some(lead) => spec = spec.lead(lead),
        // Without a valid lead, a conflict with the joint type may be reported that is only a
        // consequence.
        None if record.value("lead").is_some() => return None,
        None => {}
    }
    if let Some(inertia) = record.quantity("rotor_inertia") {
        spec = spec.rotor_inertia(inertia);
    }
    if let Some(share) = record.quantity("share") {
        spec = spec.share(share);
    }
    if let Some(constant) = record.quantity("torque_constant") {
        spec = spec.torque_constant(constant);
    }
    if let Some(friction) = inner("motor_friction", MOTOR_FRICTION) {
        let number = |key: &str| friction.quantity(key).unwrap_or(0.0);
        let friction = MotorFriction { constant: number("constant"), viscous: number("viscous") };
        spec = spec.motor_friction(friction);
    }
    if let Some(limits) = inner("limits", MOTOR_LIMITS) {
        let number = |key: &str| limits.quantity(key);
        let (peak, rated, speed) = (number("peak"), number("rated"), number("speed"));
        spec = spec.limits(MotorLimits { peak, rated, speed });
    }
    let mesh = inner("mesh", MESH);
    let efficiencies = ["efficiency", "backward_efficiency"];
    let given = efficiencies.map(|key| record.quantity(key));
    let context = record.context;
    if let Some(mesh) = mesh {
        if let Some(key) = efficiencies.into_iter().find(|key| record.value(key).is_some()) {
            context.push(
                Diagnostic::error("actuator", format!("the loss of {what} is given twice"))
                    .at(context.place(&record.span(key)), "once here")
                    .also(context.place(&record.span("mesh")), "once here")
                    .help("keep either the efficiencies or the mesh: one follows from the other"),
            );
            return None;
        }
        return Some(spec.gear(GearLoss::Mesh(read_mesh(&mesh, lead)?)));
    }
    match given {
        [Some(forward), Some(backward)] => {
            spec = spec.gear(GearLoss::Efficiency { forward, backward });
        }
        [Some(forward), None] => spec = spec.gear(GearLoss::of_efficiency(forward)),
        [None, Some(_)] if record.value("efficiency").is_none() => {
            record.missing("efficiency", ", though it has a `backward_efficiency`");
            return None;
        }
        _ => {}
    }
    Some(spec)
}

fn read_mesh(mesh: &Record<'_>, lead: Option<f64>) -> Option<Mesh> {
    let (mu, flank_angle) = (mesh.quantity("mu"), mesh.quantity("flank_angle"));
    let context = mesh.context;
    let lead_angle = match (mesh.value("lead_angle"), mesh.value("radius")) {
        (Some(_), None) => mesh.quantity("lead_angle"),
        (None, Some(value)) => {
            let radius = mesh.quantity("radius")?;
            if radius <= 0.0 || lead.is_none() {
                context.push(
                    Diagnostic::error("actuator", "the lead angle of the mesh is not known")
                        .at(
                            context.place(&value.span),
                            "`radius` must be greater than 0, and the \
                            actuator must have a `lead`",
                        )
                        .help("give `lead` of the actuator, or `lead_angle` of the mesh"),
                );
                return None;
            }
            lead.map(|lead| (lead.abs() / (TAU * radius)).atan())
        }
        (Some(angle), Some(radius)) => {
            context.push(
                Diagnostic::error("actuator", "the lead angle of the mesh is given twice")
                    .at(context.place(&angle.span), "once here")
                    .also(context.place(&radius.span), "once here")
                    .help("keep `lead_angle` or `radius`"),
            );
            return None;
        }
        (None, None) => {
            mesh.missing_both(["lead_angle", "radius"]);
            return None;
        }
    };
    Some(Mesh { mu: mu?, lead_angle: lead_angle?, flank_angle: flank_angle? })
}
