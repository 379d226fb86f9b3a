//! Reads the friction of joints.

mod law;
mod layers;
mod load;

use super::context::{Context, Record};
use crate::diagnostic::{Diagnostic, did_you_mean, quoted};
use crate::document::Table;
use crate::fields::tables::{BACKWARD_LAW, INTERFACE, JOINT_FRICTION};
use crate::source::Span;
use layers::{Layers, Notes};
use stiction_core::friction::{InterfaceShape, JointFriction, Law, interfaces_of};
use stiction_core::joint::JointType;

/// Properties of the joint whose friction is read.
pub(crate) struct Place<'a> {
    pub(crate) joint_type: JointType,
    /// Pitch, m/rad; zero if the joint has none.
    pub(crate) pitch: f64,
    /// Description of the joint in messages.
    pub(crate) what: &'a str,
}

/// Places of a joint's friction table and of the numbers in it.
#[derive(Default)]
pub(crate) struct FrictionSpans {
    pub(crate) table: Span,
    /// Key, value and place of every number.
    pub(crate) numbers: Vec<(&'static str, f64, Span)>,
}

impl FrictionSpans {
    /// Returns the place of the number that a message of the mechanism's builder calls `parameter`.
    pub(crate) fn of_parameter(&self, parameter: &str, value: f64) -> Span {
        let key = match parameter {
            "coefficient" => "mu",
            "static coefficient" => "mu_static",
            "viscous coefficient" => "viscous",
            "Stribeck velocity" => "stribeck_velocity",
            "Stribeck exponent" => "stribeck_exponent",
            "regularisation velocity" => "regularisation_velocity",
            "bristle stiffness" => "sigma0",
            "bristle damping" => "sigma1",
            "bending span" => "bending_span",
            "collar ratio" => "collar_radius",
            "torsion arm" => "torsion_arm",
            "position of the gland" => "gland",
            "position of the piston" => "piston",
            other => other,
        };
        let is_it = |known: &str| known == key || (known == "sigma2" && key == "viscous");
        let mut places = self.numbers.iter().filter(|(known, ..)| is_it(known));
        let exact = places.clone().find(|(_, number, _)| *number == value);
        exact.or_else(|| places.next()).map_or(&self.table, |(_, _, span)| span).clone()
    }
}

/// Reads the friction of all interfaces of a joint; also returns the places of the numbers.
pub(crate) fn read(
    context: &Context<'_>,
    table: &Table,
    joint: &Place<'_>,
) -> (Vec<JointFriction>, FrictionSpans) {
    let &Place { joint_type, what, .. } = joint;
    let places = interfaces_of(joint_type);
    let shared = Record::new(context, table, JOINT_FRICTION, format!("the friction of {what}"));
    let spans = FrictionSpans { table: table.span.clone(), numbers: Vec::new() };
    let mut notes = Notes { spans, reported: Vec::new() };
    let own_name = |name: &str| places.iter().any(|(place, _)| !place.is_empty() && *place == name);
    for (key, _) in &table.entries {
        let is_interface = !INTERFACE.iter().any(|field| field.key == key.name)
            && JOINT_FRICTION.iter().any(|field| field.key == key.name);
        if is_interface && !own_name(&key.name) {
            let symbol = joint_type.symbol();
            let names = places.iter().map(|(name, _)| *name).filter(|name| !name.is_empty());
            context.push(
                Diagnostic::error(
                    "unknown-key",
                    format!(
                        "a joint of type {symbol} has no friction interface {}",
                        quoted(&key.name)
                    ),
                )
                .at(context.place(&key.span), "unknown friction interface")
                .maybe_help(did_you_mean(
                    &key.name,
                    "its friction interfaces",
                    names,
                )),
            );
        }
    }
    // Returns the table for backward sliding from the table of an interface or of the whole joint.
    let backward = |record: &Record<'_>, what: &str| {
        let what = format!("the backward friction of {what}");
        let table = record.value("backward").and_then(|_| record.table("backward"));
        table.map(|table| (table.clone(), what))
    };
    let shared_backward = backward(&shared, what);
    let shared_backward = shared_backward
        .as_ref()
        .map(|(table, what)| Record::new(context, table, BACKWARD_LAW, what.clone()));
    // Without tables for its pin and guide, a C joint has a single interface, the sleeve.
    let named = places.iter().any(|(name, _)| !name.is_empty() && table.get(name).is_some());
    let has_sleeve = places.iter().any(|(_, shape)| *shape == InterfaceShape::Sleeve);
    let present: Vec<_> = places
        .iter()
        .enumerate()
        .filter(|(_, (_, shape))| !has_sleeve || named != (*shape == InterfaceShape::Sleeve))
        .collect();
    let mut interfaces = Vec::new();
    for &(place, (name, shape)) in &present {
        let own = (!name.is_empty()).then(|| shared.table(name)).flatten();
        let what = format!("friction interface `{name}` of {what}");
        let own = own.map(|table| Record::new(context, table, INTERFACE, what.clone()));
        let own_backward = own.as_ref().and_then(|own| backward(own, &what));
        let own_backward = own_backward
            .as_ref()
            .map(|(table, what)| Record::new(context, table, BACKWARD_LAW, what.clone()));
        // In a C joint with a pin and a guide, the radius of the whole joint belongs to the pin;
        // the guide has no radius.
        let no_shared_radius = present.len() > 1 && !shape.turns();
        let sides = [own_backward.as_ref(), shared_backward.as_ref()];
        let forward: Vec<_> = own.as_ref().into_iter().chain([&shared]).collect();
        let both: Vec<_> = sides.into_iter().flatten().chain(forward.iter().copied()).collect();
        let differs = both.len() > forward.len() && shape.has_one_dof();
        let forward = Layers { records: &forward, no_shared_radius };
        let both = Layers { records: &both, no_shared_radius };
        let radius = forward.number("radius", &mut notes);
        let arm = shape.turns().then(|| {
            let pitch = if *shape == InterfaceShape::Thread { joint.pitch } else { 0.0 };
            // The builder reports a radius that is missing or not positive.
            radius.filter(|radius| *radius > 0.0).map_or(1.0, |radius| radius.hypot(pitch))
        });
        let law = law::read(&forward, arm, &mut notes);
        let load = load::read(&forward, *shape, joint, radius, &mut notes);
        let backward = differs.then(|| law::read(&both, arm, &mut notes));
        interfaces.push(JointFriction { place, radius, law, backward, load });
        if let Some(own) = &own {
            not_applicable(context, own, INTERFACE, &[*shape], joint_type);
        }
    }
    if places.is_empty() {
        // The builder reports that this joint cannot have friction.
        interfaces.push(JointFriction::guide(Law::coulomb_viscous(0.0, 0.0)));
    } else {
        let shapes: Vec<_> = present.iter().map(|(_, (_, shape))| *shape).collect();
        not_applicable(context, &shared, JOINT_FRICTION, &shapes, joint_type);
    }
    (interfaces, notes.spans)
}

/// Tests if an interface of this shape has the key. A radius is accepted for guides as well; the
/// mechanism's builder then reports it.
fn applies(key: &str, shape: InterfaceShape, joint_type: JointType) -> bool {
    use InterfaceShape::{Ball, Guide, Pin, Plate, Shaft, Sleeve, Thread};
    match key {
        "bending_span" | "combine" => shape != Ball,
        "collar_radius" => matches!(shape, Pin { .. }),
        "torsion_arm" => matches!(shape, Guide { .. }),
        "supports" | "gland" | "piston" => match shape {
            Guide { .. } | Thread | Sleeve => true,
            Pin { .. } => joint_type == JointType::Cylindrical,
            Ball | Plate | Shaft { .. } => false,
        },
        "flank_angle" => shape == Thread,
        "smoothing" => shape != Thread,
        "backward" => shape.has_one_dof(),
        _ => true,
    }
}

/// Reports keys that have no effect for any interface with one of these shapes.
fn not_applicable(
    context: &Context<'_>,
    record: &Record<'_>,
    fields: &[crate::fields::Field],
    shapes: &[InterfaceShape],
    joint_type: JointType,
) {
    for field in fields {
        let Some(value) = record.table.get(field.key) else { continue };
        if shapes.iter().any(|shape| applies(field.key, *shape, joint_type)) {
            continue;
        }
        let what = match shapes {
            [InterfaceShape::Ball] => "a ball",
            [InterfaceShape::Plate] => "a plate",
            [InterfaceShape::Thread] => "a thread",
            [InterfaceShape::Guide { .. }] => "a straight guide",
            [InterfaceShape::Sleeve] => "a sleeve",
            _ => "a pin",
        };
        let label = match field.key {
            "bending_span" | "collar_radius" | "torsion_arm" => {
                "this interface does not carry this load"
            }
            _ => "not for this friction interface",
        };
        let message =
            format!("`{}` has no effect at {what} (type {})", field.key, joint_type.symbol());
        context.push(
            Diagnostic::error("unknown-key", message).at(context.place(&value.span), label).help(
                match shapes {
                    [InterfaceShape::Sleeve] => {
                        "if pin and guide are separate surfaces, give each its own table, `angle` or `slide`, in \
                         `friction`"
                            .to_owned()
                    }
                    _ => format!("`{}`: {}", field.key, field.summary()),
                },
            ),
        );
    }
}
