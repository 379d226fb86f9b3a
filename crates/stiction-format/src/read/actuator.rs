//! Reader of drive trains.

use super::check_values::check_values;
use super::context::{Context, Record};
use crate::diagnostic::Diagnostic;
use crate::document::Table;
use crate::fields::tables::{ACTUATOR, LEG_ACTUATOR, MESH, MOTOR_FRICTION, MOTOR_LIMITS};
use crate::source::Span;
use std::f64::consts::TAU;
use stiction_core::mechanism::{DriveTrainSpec, GearLoss, Mesh, MotorFriction, MotorLimits};

/// A drive train with the places of its parts.
pub(crate) struct ActuatorDraft {
    pub(crate) name: String,
    /// `None` if its joint or its mesh is invalid.
    pub(crate) spec: Option<DriveTrainSpec>,
    pub(crate) spans: ActuatorSpans,
}

/// Places of the parts of a drive train.
pub(crate) struct ActuatorSpans {
    pub(crate) name: Span,
    pub(crate) joint: Span,
    /// Places of the values by key, `table.key` in inner tables.
    pub(crate) values: Vec<(String, Span)>,
}

/// Reads a drive train. `joint` is its joint if its leg determines it; `what` describes it in messages.
pub(crate) fn read(
    context: &Context<'_>,
    (name, span): (String, &Span),
    table: &Table,
    joint: Option<&str>,
    what: &str,
) -> ActuatorDraft {
    let fields = if joint.is_some() { LEG_ACTUATOR } else { ACTUATOR };
    let record = Record::new(context, table, fields, what);
    let own_joint = if joint.is_some() { None } else { record.text("joint") };
    let mut values = Vec::new();
    for (key, value) in &table.entries {
        values.push((key.name.clone(), value.span.clone()));
        let inner = value.as_table().into_iter().flat_map(|inner| &inner.entries);
        values
            .extend(inner.map(|(inner, value)| {
                (format!("{}.{}", key.name, inner.name), value.span.clone())
            }));
    }
    let spans = ActuatorSpans {
        name: span.clone(),
        joint: table.get("joint").map_or(span, |value| &value.span).clone(),
        values,
    };
    let spec = match joint.or(own_joint) {
        Some(joint) => spec(&record, &name, joint, what),
        None => {
            check_values(&record, fields);
            None
        }
    };
    ActuatorDraft { name, spec, spans }
}

fn spec(record: &Record<'_>, name: &str, joint: &str, what: &str) -> Option<DriveTrainSpec> {
    let inner = |key: &str, fields| {
        let table = record.table(key)?;
        Some(Record::new(record.context, table, fields, format!("`{key}` of {what}")))
    };
    let mut spec = DriveTrainSpec::new(name, joint);
    if let Some(ratio) = record.quantity("ratio") {
        spec = spec.ratio(ratio);
    }
    let lead = record.quantity("lead");
    match lead {
        Some(lead) => spec = spec.lead(lead),
        // Without it the joint may seem not to fit.
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
                    .help("keep the efficiencies or the mesh: one follows from the other"),
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
                        .at(context.place(&value.span), "a radius greater than 0 needs a `lead`")
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
