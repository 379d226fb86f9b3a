//! Expands a spring of a group of legs into a table for each leg, with the names of that leg's
//! bodies and joints.

use super::context::Context;
use super::spring::{self, SpringDraft};
use super::{joint::JointDraft, names};
use crate::diagnostic::quoted;
use crate::document::{Key, Node, Table, Text, Value};
use crate::expression::Measure;
use stiction_core::spatial::{Mat3, Vec3};

/// Table of a leg's spring, which can be read only after the joints of all legs are known.
pub(crate) struct LegSpring {
    key: Key,
    table: Table,
    what: String,
}

/// Names and rotation of a leg, from which the tables of its springs are created.
pub(crate) struct Leg<'a> {
    pub(crate) name: &'a str,
    /// Bodies of the leg, each with its key in the group and its full name; `joints` lists the
    /// joints in the same form.
    pub(crate) bodies: &'a [(String, String)],
    pub(crate) joints: &'a [(String, String)],
    /// Bodies at which legs begin and end; points on them rotate with the leg.
    pub(crate) ends: [&'a str; 2],
    pub(crate) turn: Mat3<f64>,
}

impl Leg<'_> {
    /// Creates the table of this leg's spring from the table of the group's spring.
    pub(crate) fn spring(&self, context: &Context<'_>, key: &Key, table: &Table) -> LegSpring {
        names::check(context, &key.name, &key.span, "spring");
        let mut own = table.clone();
        let is_end = |kind: &str| {
            let body = table.get(kind).and_then(Value::as_text);
            let is_of_leg = |body: &str| self.bodies.iter().any(|(known, _)| known == body);
            body.is_some_and(|body| self.ends.contains(&body) && !is_of_leg(body))
        };
        let turned = [("at", is_end("from")), ("to_at", is_end("to"))];
        own.entries.retain_mut(|(name, value)| {
            match name.name.as_str() {
                "from" | "to" => rename(value, |body| full(self.bodies, body)),
                "joint" => rename(value, |joint| self.joint(joint)),
                kind if turned.contains(&(kind, true)) => {
                    // An invalid vector has been reported.
                    let Some(point) = context.vector(value, Measure::Length) else { return false };
                    *value = numbers(value, self.turn * point);
                }
                _ => {}
            }
            true
        });
        LegSpring {
            key: Key { name: format!("{}.{}", self.name, key.name), span: key.span.clone() },
            table: own,
            what: format!("spring {} of the legs", quoted(&key.name)),
        }
    }

    /// Returns the full name of a joint of the chain, or of one of its degrees of freedom.
    fn joint(&self, name: &str) -> Option<String> {
        full(self.joints, name).or_else(|| {
            let (joint, dof) = name.split_once('.')?;
            Some(format!("{}.{dof}", full(self.joints, joint)?))
        })
    }
}

impl LegSpring {
    pub(crate) fn read(&self, context: &Context<'_>, joints: &[JointDraft]) -> SpringDraft {
        spring::read(context, &self.key, &self.table, joints, &self.what)
    }
}

fn full(known: &[(String, String)], key: &str) -> Option<String> {
    known.iter().find(|(own, _)| own == key).map(|(_, name)| name.clone())
}

/// Replaces the key of a body or joint in the group by its full name in the model.
fn rename(value: &mut Value, own: impl Fn(&str) -> Option<String>) {
    if let Some(name) = value.as_text().and_then(own) {
        value.node = Node::Text(Text { content: name, start: None });
    }
}

/// Creates a list with the components of a vector, m, as plain numbers at the place of the value
/// `given`.
fn numbers(given: &Value, vector: Vec3<f64>) -> Value {
    let number = |x: f64| Value { span: given.span.clone(), node: Node::Number(x) };
    let list = vector.to_array().map(number).to_vec();
    Value { span: given.span.clone(), node: Node::List(list) }
}
