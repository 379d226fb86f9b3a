//! Friction of joints.

use super::context::{Context, Record};
use crate::diagnostic::{Diagnostic, did_you_mean, quoted};
use crate::document::{Table, Value};
use crate::fields::tables::{CONTACT, JOINT_FRICTION};
use crate::source::Span;
use stiction::friction::{Contact, ContactShape, Law, LoadMap, contacts_of};
use stiction::joint::JointType;

/// Where the numbers of a friction stand.
#[derive(Default)]
pub(crate) struct FrictionSpans {
    pub(crate) table: Span,
    /// Key, value and place of every number.
    pub(crate) numbers: Vec<(&'static str, f64, Span)>,
}

impl FrictionSpans {
    /// The place of the parameter that the mechanism's builder calls `parameter`.
    pub(crate) fn of_parameter(&self, parameter: &str, value: f64) -> Span {
        let key = match parameter {
            "coefficient" => "mu",
            "viscous coefficient" => "viscous",
            "bending span" => "bending_span",
            "collar ratio" => "collar_radius",
            "torsion arm" => "torsion_arm",
            other => other,
        };
        let mut places = self.numbers.iter().filter(|(known, ..)| *known == key);
        let exact = places.clone().find(|(_, number, _)| *number == value);
        exact.or_else(|| places.next()).map_or(&self.table, |(_, _, span)| span).clone()
    }
}

/// Reads the friction of all contacts of a joint.
pub(crate) fn read(
    context: &Context<'_>,
    table: &Table,
    joint_type: JointType,
    what: &str,
) -> (Vec<Contact>, FrictionSpans) {
    let places = contacts_of(joint_type);
    let shared = Record::new(context, table, JOINT_FRICTION, format!("the friction of {what}"));
    let mut spans = FrictionSpans { table: table.span.clone(), numbers: Vec::new() };
    let own_name = |name: &str| places.iter().any(|(place, _)| !place.is_empty() && *place == name);
    for (key, _) in &table.entries {
        let is_contact = !CONTACT.iter().any(|field| field.key == key.name)
            && JOINT_FRICTION.iter().any(|field| field.key == key.name);
        if is_contact && !own_name(&key.name) {
            let symbol = joint_type.symbol();
            let names = places.iter().map(|(name, _)| *name).filter(|name| !name.is_empty());
            context.push(
                Diagnostic::error(
                    "unknown-key",
                    format!("a joint of type {symbol} has no contact {}", quoted(&key.name)),
                )
                .at(context.place(&key.span), "unknown contact")
                .maybe_help(did_you_mean(&key.name, "its contacts", names)),
            );
        }
    }
    let mut contacts = Vec::new();
    for (place, (name, shape)) in places.iter().enumerate() {
        let own = (!name.is_empty()).then(|| shared.table(name)).flatten();
        let what = format!("contact `{name}` of {what}");
        let own = own.map(|table| Record::new(context, table, CONTACT, what));
        let alone = places.len() == 1;
        let (own_record, spans) = (own.as_ref(), &mut spans);
        let mut reader = Reader { shared: &shared, own: own_record, shape: *shape, alone, spans };
        contacts.push(reader.contact(place));
        if let Some(own) = &own {
            not_applicable(context, own, CONTACT, &[*shape], joint_type);
        }
    }
    if places.is_empty() {
        // The builder says that this joint has no friction.
        contacts.push(Contact {
            place: 0,
            radius: None,
            law: Law { coulomb: 0.0, viscous: 0.0 },
            load: LoadMap::force_only(),
        });
    } else {
        let shapes: Vec<_> = places.iter().map(|(_, shape)| *shape).collect();
        not_applicable(context, &shared, JOINT_FRICTION, &shapes, joint_type);
    }
    (contacts, spans)
}

/// Whether a contact of this shape has the part. A radius of a guide is the builder's to refuse.
fn applies(key: &str, shape: ContactShape) -> bool {
    match (key, shape) {
        ("bending_span", ContactShape::Ball) => false,
        ("collar_radius", shape) => matches!(shape, ContactShape::Pin { .. }),
        ("torsion_arm", shape) => matches!(shape, ContactShape::Guide { .. }),
        _ => true,
    }
}

/// Says which keys mean nothing at any of these contacts.
fn not_applicable(
    context: &Context<'_>,
    record: &Record<'_>,
    fields: &[crate::fields::Field],
    shapes: &[ContactShape],
    joint_type: JointType,
) {
    for field in fields {
        let Some(value) = record.table.get(field.key) else { continue };
        if shapes.iter().any(|shape| applies(field.key, *shape)) {
            continue;
        }
        let what = match shapes {
            [ContactShape::Ball] => "a ball",
            [ContactShape::Guide { .. }] => "a straight guide",
            _ => "a pin",
        };
        let message =
            format!("`{}` means nothing at {what} (type {})", field.key, joint_type.symbol());
        context.push(
            Diagnostic::error("unknown-key", message)
                .at(context.place(&value.span), "nothing takes this load")
                .help(format!("`{}`: {}", field.key, field.doc.trim_end_matches('.'))),
        );
    }
}

struct Reader<'a> {
    shared: &'a Record<'a>,
    own: Option<&'a Record<'a>>,
    shape: ContactShape,
    /// Whether it is the joint's only contact.
    alone: bool,
    spans: &'a mut FrictionSpans,
}

impl Reader<'_> {
    fn contact(&mut self, place: usize) -> Contact {
        let (mu, viscous) = (self.number("mu"), self.number("viscous"));
        if self.given("mu").is_none() && self.given("viscous").is_none() {
            let record = self.own.unwrap_or(self.shared);
            record.missing_both(["mu", "viscous"]);
        }
        let radius = self.number("radius");
        let mut part = |key| applies(key, self.shape).then(|| self.number(key)).flatten();
        let (bending_span, collar, torsion_arm) =
            (part("bending_span"), part("collar_radius"), part("torsion_arm"));
        let axial_ratio = collar.zip(radius).map(|(collar, radius)| collar / radius);
        Contact {
            place,
            radius,
            law: Law { coulomb: mu.unwrap_or(0.0), viscous: viscous.unwrap_or(0.0) },
            load: LoadMap {
                bending_span,
                axial_ratio: axial_ratio.filter(|ratio| ratio.is_finite()),
                torsion_arm,
                preload: self.number("preload").unwrap_or(0.0),
            },
        }
    }

    /// The contact's own value of a key, or else the joint's.
    fn given(&self, key: &str) -> Option<(&Record<'_>, &Value)> {
        if let Some(own) = self.own
            && let Some(value) = own.value(key)
        {
            return Some((own, value));
        }
        // In a C joint the shared radius is that of the pin; its guide has none.
        let guide_beside_pin = !self.alone && !self.shape.turns();
        let shared = self.shared.value(key).filter(|_| key != "radius" || !guide_beside_pin);
        shared.map(|value| (self.shared, value))
    }

    fn number(&mut self, key: &'static str) -> Option<f64> {
        let (record, value) = self.given(key)?;
        let span = value.span.clone();
        // What cannot be read has been complained about; any valid number will do from here.
        let number = record.quantity(key).unwrap_or(1.0);
        self.spans.numbers.push((key, number, span));
        Some(number)
    }
}
