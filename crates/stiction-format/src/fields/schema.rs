//! JSON schema of the model file, for editors and other programs.

use super::tables::{AXES, BODY_LOAD, BODY_MOTION, LIMITS, MODEL, ORDERS, POSE, TENSOR};
use super::{Field, Shape};
use crate::expression::Measure;
use serde_json::{Map, Value, json};

/// Returns a JSON schema (draft 2020-12) of the model file. It describes all keys and the forms of
/// their values; names, units and physics are checked by [`crate::read`].
pub fn json_schema() -> Value {
    let mut schema = table(MODEL);
    let object = json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Stiction model",
        "description": "A mechanism with its motions and loads.",
        "$defs": definitions(),
    });
    if let (Some(schema), Value::Object(head)) = (schema.as_object_mut(), object) {
        let body = std::mem::take(schema);
        schema.extend(head);
        schema.extend(body);
    }
    schema
}

fn definitions() -> Value {
    json!({
        "quantity": {
            "description": "A number in SI units, or an expression with units such as \"128.48 mm\" \
                            or \"2*l1 + 5 mm\".",
            "anyOf": [{ "type": "number" }, { "type": "string", "minLength": 1 }],
        },
        "vector": {
            "type": "array",
            "items": reference("quantity"),
            "minItems": 3,
            "maxItems": 3,
        },
        "axis": { "anyOf": [{ "enum": AXES }, reference("vector")] },
        "rotation": rotation(),
        "pose": table(POSE),
        "inertia": inertia(),
        "coordinates": {
            "description": "Coordinates, listed under the name of their body or joint; a dot in a name separates nested tables.",
            "anyOf": [
                reference("quantity"),
                { "type": "object", "additionalProperties": reference("coordinates") },
            ],
        },
        "waypoint": {
            "description": "Coordinates, listed under the name of their body or joint; a dot in a name separates nested tables. \
             A body can also have a `rotation`.",
            "anyOf": [
                reference("quantity"),
                reference("rotation"),
                { "type": "object", "additionalProperties": reference("waypoint") },
            ],
        },
        "limits": limits(),
        "load": load(),
    })
}

fn reference(name: &str) -> Value {
    json!({ "$ref": format!("#/$defs/{name}") })
}

fn rotation() -> Value {
    let angles = |order: &&str| {
        json!({
            "type": "object",
            "properties": { *order: reference("vector") },
            "required": [order],
            "additionalProperties": false,
        })
    };
    let mut forms = vec![json!({
        "type": "object",
        "properties": { "axis": reference("axis"), "angle": reference("quantity") },
        "required": ["axis", "angle"],
        "additionalProperties": false,
    })];
    forms.extend(ORDERS.iter().map(angles));
    json!({ "anyOf": forms })
}

fn inertia() -> Value {
    let entries: Map<_, _> =
        TENSOR.iter().map(|(key, _, _)| ((*key).to_owned(), reference("quantity"))).collect();
    json!({
        "anyOf": [
            reference("vector"),
            { "type": "object", "properties": entries, "additionalProperties": false },
        ],
    })
}

/// Schema of the load on a body. A dot in a body's name leads to a nested table, so that any other
/// key may be the beginning of a name.
fn load() -> Value {
    let mut schema = table(BODY_LOAD);
    if let Some(schema) = schema.as_object_mut() {
        schema.insert("additionalProperties".into(), reference("load"));
    }
    schema
}

/// Schema of the limits of motion of coordinates and bodies.
fn limits() -> Value {
    let mut schema = table(LIMITS);
    if let Some(schema) = schema.as_object_mut() {
        schema.insert("additionalProperties".into(), reference("limits"));
    }
    schema
}

fn table(fields: &[Field]) -> Value {
    let properties: Map<_, _> =
        fields.iter().map(|field| (field.key.to_owned(), property(field))).collect();
    let required: Vec<_> = fields.iter().filter(|f| f.required).map(|f| f.key).collect();
    let mut schema = json!({ "type": "object", "properties": properties });
    if let Some(schema) = schema.as_object_mut() {
        if !required.is_empty() {
            schema.insert("required".into(), json!(required));
        }
        schema.insert("additionalProperties".into(), json!(false));
    }
    schema
}

fn property(field: &Field) -> Value {
    let mut schema = shape(&field.shape);
    let both;
    let unit = match field.shape {
        Shape::LinearOrAngular(linear, angular) => {
            both = format!("{} or {}", linear.words().unit, angular.words().unit);
            &both
        }
        Shape::SixBySix(Measure::Stiffness) => "N/m, N and N m/rad",
        Shape::SixBySix(_) => "N s/m, N s and N m s/rad",
        Shape::Quantity(measure) | Shape::Vector(measure) | Shape::Quantities(measure) => {
            measure.words().unit
        }
        _ => "",
    };
    let doc = match unit {
        "" => field.doc.to_owned(),
        unit => format!("{} Bare numbers are in {unit}.", field.doc),
    };
    if let Some(schema) = schema.as_object_mut() {
        schema.insert("description".into(), json!(doc));
    }
    schema
}

fn shape(shape: &Shape) -> Value {
    match shape {
        Shape::Text | Shape::Name => json!({ "type": "string" }),
        Shape::Names => json!({ "type": "array", "items": { "type": "string" } }),
        Shape::Choice(words) => json!({ "enum": words }),
        Shape::Quantity(_) | Shape::LinearOrAngular(..) => reference("quantity"),
        Shape::SixBySix(_) => {
            let row = json!({ "type": "array", "items": reference("quantity"), "minItems": 6, "maxItems": 6 });
            json!({ "anyOf": [row, { "type": "array", "items": row, "minItems": 6, "maxItems": 6 }] })
        }
        Shape::Vector(_) => reference("vector"),
        Shape::Quantities(_) => json!({ "type": "array", "items": reference("quantity") }),
        Shape::Pairs(..) => json!({
            "type": "array",
            "items": {
                "type": "array",
                "items": reference("quantity"),
                "minItems": 2,
                "maxItems": 2,
            },
            "minItems": 2,
        }),
        Shape::Axis => reference("axis"),
        Shape::Rotation => reference("rotation"),
        Shape::Inertia => reference("inertia"),
        Shape::Actuated => json!({
            "anyOf": [{ "type": "boolean" }, { "type": "array", "items": { "type": "string" } }],
        }),
        Shape::Start => json!({
            "anyOf": [
                reference("quantity"),
                { "type": "array", "items": reference("quantity") },
                reference("rotation"),
                reference("pose"),
            ],
        }),
        Shape::Range => {
            let pair = json!({
                "type": "array",
                "items": reference("quantity"),
                "minItems": 2,
                "maxItems": 2,
            });
            json!({
                "anyOf": [pair, { "type": "object", "additionalProperties": pair }],
            })
        }
        Shape::Table(fields) => table(fields),
        Shape::OneOrMore(fields) => {
            let one = table(fields);
            json!({ "anyOf": [one, { "type": "array", "items": one }] })
        }
        Shape::List(fields) => json!({ "type": "array", "items": table(fields) }),
        Shape::Named(fields) => json!({ "type": "object", "additionalProperties": table(fields) }),
        Shape::Texts => {
            json!({ "type": "object", "additionalProperties": { "type": "string" } })
        }
        Shape::Parameters | Shape::Coefficients => {
            json!({ "type": "object", "additionalProperties": reference("quantity") })
        }
        Shape::Waypoints(fields) => {
            json!({ "type": "array", "items": open(fields, "waypoint"), "minItems": 2 })
        }
        Shape::Limits => reference("limits"),
        Shape::Motions(fields) => named_open(fields, "coordinates"),
        Shape::Loads(fields) => named_open(fields, "load"),
    }
}

/// Schema of named tables with these keys; the value of any other key has the schema named
/// `others`.
fn named_open(fields: &[Field], others: &str) -> Value {
    json!({ "type": "object", "additionalProperties": open(fields, others) })
}

/// Schema of a table with these keys; the value of any other key has the schema named `others`.
fn open(fields: &[Field], others: &str) -> Value {
    let mut each = table(fields);
    if let Some(each) = each.as_object_mut() {
        each.insert("additionalProperties".into(), reference(others));
        if others == "coordinates" {
            let hint: Vec<_> = BODY_MOTION.iter().map(|field| field.key).collect();
            each.insert(
                "$comment".into(),
                json!(format!("after the name of a body: {}", hint.join(" "))),
            );
        }
    }
    each
}
