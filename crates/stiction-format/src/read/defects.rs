//! Reports the defects found by the mechanism's builder, with their places in the text of the
//! model.

use super::actuator::ActuatorDraft;
use super::body::BodyDraft;
use super::context::Context;
use super::gearing::GearingDraft;
use super::joint::JointDraft;
use super::names::Names;
use super::spring::{self, SpringDraft};
use crate::diagnostic::{Diagnostic, did_you_mean, number};
use crate::source::Span;
use std::mem::discriminant;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{Defect, Warning};

/// Place of a defect that concerns the whole file.
const WHOLE: Span = 0..0;

/// Parts of the mechanism as read, with their places in the text.
pub(crate) struct Origin<'a> {
    pub(crate) context: &'a Context<'a>,
    pub(crate) bodies: &'a [BodyDraft],
    pub(crate) joints: &'a [JointDraft],
    pub(crate) springs: &'a [SpringDraft],
    pub(crate) actuators: &'a [ActuatorDraft],
    pub(crate) gearings: &'a [GearingDraft],
    pub(crate) names: &'a Names,
    /// Place of the key `characteristic_length`.
    pub(crate) length: Span,
}

impl Origin<'_> {
    /// Reports defects; a defect that several legs share is reported only once.
    pub(crate) fn report(&self, defects: &[Defect]) {
        // In a text with syntax errors, missing parts may be hidden by the errors.
        if !self.context.broken.is_empty() {
            return;
        }
        let incomplete =
            self.joints.iter().any(|joint| joint.spec.is_none()) || self.names.has_lost_legs();
        let mut reported = Vec::new();
        for defect in defects {
            // Connectivity is unknown if joints are missing.
            let consequence = match defect {
                Defect::Disconnected { .. } => incomplete,
                Defect::UnknownJointOfActuator { .. }
                | Defect::UnknownBodyOfActuator { .. }
                | Defect::UnknownJointOfSpring { .. }
                | Defect::UnknownJointOfGearing { .. } => incomplete,
                // It follows from the efficiency, which is out of range.
                Defect::ActuatorParameter {
                    actuator, parameter: "backward_efficiency", ..
                } => !self.is_given(actuator, "backward_efficiency"),
                Defect::UnknownBody { body, .. } | Defect::UnknownBodyOfSpring { body, .. } => {
                    self.names.may_be_lost(body)
                }
                _ => false,
            };
            if consequence {
                continue;
            }
            if self.context.is_full() {
                self.context.out.borrow_mut().add_omitted_errors(1);
                continue;
            }
            let (span, label, help) = self.locate(defect);
            let key = (discriminant(defect), span.clone());
            if reported.contains(&key) {
                continue;
            }
            reported.push(key);
            self.context.push(
                Diagnostic::error("mechanism", self.message(defect))
                    .at(self.context.place(&span), label)
                    .maybe_help(help),
            );
        }
    }

    /// Tests if the text of the model contains a parameter of an actuator.
    fn is_given(&self, actuator: &str, parameter: &str) -> bool {
        let mut drafts = self.actuators.iter().filter(|known| known.name == actuator);
        drafts.any(|draft| draft.spans.values.iter().any(|(key, _)| key == parameter))
    }

    /// Formats the message for a defect in the terms of the model file.
    fn message(&self, defect: &Defect) -> String {
        let joint = |name: &str| self.joints.iter().find(|joint| joint.name == name);
        let symbol = |name: &str| {
            joint(name)
                .and_then(|joint| joint.joint_type)
                .map_or("?", |joint_type| joint_type.symbol())
        };
        match defect {
            Defect::Pitch { joint } if symbol(joint) == "H" => {
                format!("joint `{joint}` needs a `pitch` other than 0")
            }
            Defect::Pitch { joint } => {
                format!("joint `{joint}` of type {} has no pitch", symbol(joint))
            }
            Defect::NotActuable { joint, .. } => {
                format!("joint `{joint}` of type {} cannot be actuated", symbol(joint))
            }
            other => other.to_string(),
        }
    }

    fn locate(&self, defect: &Defect) -> (Span, String, Option<String>) {
        let body = |name: &str| self.bodies.iter().find(|body| body.name == name);
        // The second of two parts with the same name is at fault.
        let last_body = |name: &str| self.bodies.iter().rev().find(|body| body.name == name);
        let joint = |name: &str| self.joints.iter().find(|joint| joint.name == name);
        let last_joint = |name: &str| self.joints.iter().rev().find(|joint| joint.name == name);
        let spring = |name: &str| self.springs.iter().find(|spring| spring.name == name);
        let actuator = |name: &str| self.actuators.iter().rev().find(|known| known.name == name);
        let gearing = |name: &str| self.gearings.iter().rev().find(|known| known.name == name);
        let whole = || WHOLE;
        let mut help = None;
        let (span, label) = match defect {
            Defect::NoBodies => {
                help = Some("add a table such as [bodies.crank]".to_owned());
                (whole(), "no table [bodies.…]")
            }
            Defect::DuplicateName { what: "bodies", name } => {
                (last_body(name).map_or_else(whole, |b| b.name_span.clone()), "already used")
            }
            Defect::DuplicateName { what: "springs", name } => {
                let last = self.springs.iter().rev().find(|spring| spring.name == *name);
                (last.map_or_else(whole, |s| s.spans.name.clone()), "already used")
            }
            Defect::DuplicateName { what: "actuators", name } => {
                (actuator(name).map_or_else(whole, |a| a.spans.name.clone()), "already used")
            }
            Defect::DuplicateName { what: "gearings", name } => {
                (gearing(name).map_or_else(whole, |g| g.name_span.clone()), "already used")
            }
            Defect::UnknownJointOfGearing { gearing: name, joint } => {
                help = did_you_mean(joint, "joints", self.joints.iter().map(|j| j.name.as_str()));
                (gearing(name).map_or_else(whole, |g| g.joints_span.clone()), "unknown joint")
            }
            Defect::Gearing { gearing: name, .. } => {
                (gearing(name).map_or_else(whole, |g| g.joints_span.clone()), "this gearing")
            }
            Defect::UnknownJointOfActuator { actuator: name, joint } => {
                help = did_you_mean(joint, "joints", self.joints.iter().map(|j| j.name.as_str()));
                (actuator(name).map_or_else(whole, |a| a.spans.joint.clone()), "unknown joint")
            }
            Defect::UnknownBodyOfActuator { actuator: name, body } => {
                help = did_you_mean(body, "bodies", self.bodies.iter().map(|b| b.name.as_str()));
                let draft = actuator(name);
                let values = draft.into_iter().flat_map(|draft| &draft.spans.values);
                let given = values.clone().find(|(key, _)| key == "rotor_axis.body");
                (given.map_or_else(whole, |(_, span)| span.clone()), "unknown body")
            }
            Defect::Actuator { actuator: name, .. } => {
                (actuator(name).map_or_else(whole, |a| a.spans.name.clone()), "this actuator")
            }
            Defect::ActuatorParameter { actuator: name, parameter, value, .. } => {
                if parameter.ends_with("efficiency") && *value > 1.0 && *value <= 100.0 {
                    help = Some(format!("write \"{0} %\" for {0} percent", number(*value)));
                }
                let draft = actuator(name);
                let values = draft.into_iter().flat_map(|draft| &draft.spans.values);
                let given = values.clone().find(|(key, _)| key == parameter);
                // A derived parameter, which has no key, is located at the table that defines it.
                let table = parameter.split('.').next().unwrap_or_default();
                let given = given.or_else(|| values.clone().find(|(key, _)| key == table));
                let span = given.map(|(_, span)| span).or(draft.map(|a| &a.spans.name));
                (span.cloned().unwrap_or(WHOLE), "out of range")
            }
            Defect::DuplicateName { name, .. } => {
                (last_joint(name).map_or_else(whole, |j| j.spans.name.clone()), "already used")
            }
            Defect::NameOfFreedom { joint: name, .. } | Defect::NameTaken { name } => {
                help = Some("choose another name".to_owned());
                (joint(name).map_or_else(whole, |j| j.spans.name.clone()), "already used")
            }
            Defect::GroundTaken => {
                help = Some("delete it: the ground needs no table".to_owned());
                let ground = body(stiction_core::mechanism::GROUND_NAME);
                (ground.map_or_else(whole, |b| b.name_span.clone()), "already used")
            }
            Defect::UnknownBody { joint: name, body } => {
                help = did_you_mean(body, "bodies", self.names.body_names());
                (self.end_of(name, body), "unknown body")
            }
            Defect::SameBody { joint: name, .. } => {
                (joint(name).map_or_else(whole, |j| j.spans.to.clone()), "the same as `from`")
            }
            Defect::Disconnected { body: name } => {
                (body(name).map_or_else(whole, |b| b.name_span.clone()), "not connected")
            }
            Defect::NegativeMass { body: name, .. } => {
                (body(name).map_or_else(whole, |b| b.mass_span.clone()), "negative")
            }
            Defect::AsymmetricInertia { body: name }
            | Defect::NegativeInertia { body: name, .. } => {
                (body(name).map_or_else(whole, |b| b.inertia_span.clone()), "not an inertia")
            }
            Defect::Pitch { joint: name } => {
                let draft = joint(name);
                let helical = draft.is_some_and(|j| j.joint_type == Some(JointType::Helical));
                help = helical.then(|| "for example `pitch = \"5 mm/rev\"`".to_owned());
                let label =
                    if helical { "the pitch is missing or 0" } else { "not allowed for this type" };
                (draft.map_or_else(whole, |j| j.spans.pitch.clone()), label)
            }
            Defect::NotActuable { joint: name, .. } => {
                help = Some(
                    "actuators drive the degrees of freedom of R, P, H, C, U and E joints; model \
                     an actuated ball as R and U"
                        .to_owned(),
                );
                (joint(name).map_or_else(whole, |j| j.spans.actuated.clone()), "cannot be driven")
            }
            Defect::StartLength { joint: name, .. } => (
                joint(name).map_or_else(whole, |j| j.spans.start.clone()),
                "wrong number of coordinates",
            ),
            Defect::NoContact { joint: name, .. }
            | Defect::DuplicateContact { joint: name }
            | Defect::Friction { joint: name, .. } => {
                let span = joint(name).map_or_else(whole, |j| j.spans.friction.table.clone());
                let label = match defect {
                    Defect::NoContact { .. } => "this joint cannot have friction",
                    Defect::DuplicateContact { .. } => "declared twice",
                    _ => "not possible",
                };
                (span, label)
            }
            Defect::Radius { joint: name, .. } => {
                let friction = joint(name).map(|j| &j.spans.friction);
                let given = friction
                    .and_then(|f| f.numbers.iter().find(|(key, ..)| *key == "radius"))
                    .map(|(.., span)| span.clone());
                let label = if given.is_some() { "not for a guide" } else { "`radius` is missing" };
                (given.or_else(|| friction.map(|f| f.table.clone())).unwrap_or(WHOLE), label)
            }
            Defect::FrictionParameter { joint: name, parameter, value, .. } => {
                let span = joint(name)
                    .map_or_else(whole, |j| j.spans.friction.of_parameter(parameter, *value));
                (span, "out of range")
            }
            Defect::Compliance { joint: name, part, .. } => {
                let place = joint(name).map(|j| {
                    let (table, parts) = &j.spans.compliance;
                    let place = parts.iter().find(|(known, _)| known == part);
                    place.map_or(table, |(_, span)| span).clone()
                });
                (place.unwrap_or(WHOLE), "not possible here")
            }
            Defect::Range { joint: name, .. } => {
                (joint(name).map_or(WHOLE, |j| j.spans.range.clone()), "not a range")
            }
            Defect::UnknownBodyOfSpring { spring: name, body } => {
                help = did_you_mean(body, "bodies", self.names.body_names());
                let spans = spring(name).map(|s| [&s.spans.from, &s.spans.to]);
                (spans.map_or_else(whole, |[from, to]| self.naming(body, from, to)), "unknown body")
            }
            Defect::SpringWithinBody { spring: name, .. } => {
                (spring(name).map_or_else(whole, |s| s.spans.to.clone()), "the same as `from`")
            }
            Defect::SpringParameter { spring: name, parameter, .. } => {
                let span = spring(name).map(|s| s.spans.of(parameter));
                (span.unwrap_or(WHOLE), "out of range")
            }
            Defect::UnknownJointOfSpring { spring: name, joint } => {
                let known = spring::coordinates(self.joints);
                help =
                    did_you_mean(joint, "coordinates of joints", known.iter().map(String::as_str));
                (spring(name).map_or_else(whole, |s| s.spans.of("joint")), "unknown joint")
            }
            Defect::Spring { spring: name, problem } => {
                let span = spring(name).map(|s| s.spans.mentioned_in(problem));
                (span.unwrap_or(WHOLE), "not possible")
            }
            Defect::CharacteristicLength(_) => (self.length.clone(), "not positive"),
            Defect::CharacteristicLengthFar { .. } => {
                (self.length.clone(), "far from the size of the mechanism")
            }
            // For any other defect, the first known name in the message determines the place.
            other => (self.named_in(&other.to_string()), ""),
        };
        (span, label.to_owned(), help)
    }

    /// Returns the place where a joint names this body.
    fn end_of(&self, joint: &str, body: &str) -> Span {
        let Some(draft) = self.joints.iter().find(|draft| draft.name == joint) else {
            return WHOLE;
        };
        self.naming(body, &draft.spans.from, &draft.spans.to)
    }

    /// Returns `from` or `to`, whichever is the place that names this body.
    fn naming(&self, body: &str, from: &Span, to: &Span) -> Span {
        let text = |span: &Span| self.context.source.text.get(span.clone()).unwrap_or_default();
        let names_it = |span: &Span| text(span).trim_matches(['"', '\'']) == body;
        if names_it(to) && !names_it(from) { to } else { from }.clone()
    }

    fn named_in(&self, message: &str) -> Span {
        for name in message.split('`').skip(1).step_by(2) {
            if let Some(body) = self.bodies.iter().find(|body| body.name == name) {
                return body.name_span.clone();
            }
            if let Some(joint) = self.joints.iter().find(|joint| joint.name == name) {
                return joint.spans.name.clone();
            }
        }
        WHOLE
    }

    /// Reports warnings; a warning that several legs share is reported only once.
    pub(crate) fn warn(&self, warnings: &[Warning]) {
        let mut reported = Vec::new();
        for warning in warnings {
            let body = |name: &str| self.bodies.iter().find(|body| body.name == name);
            let (span, label) = match warning {
                Warning::ImpossibleInertia { body: name, .. } => {
                    (body(name).map(|b| b.inertia_span.clone()), "not physical")
                }
                Warning::InertiaWithoutMass { body: name } => {
                    (body(name).map(|b| b.inertia_span.clone()), "without a `mass`")
                }
                Warning::UnlikelyInertia { body: name, .. } => {
                    (body(name).map(|b| b.inertia_span.clone()), "unlikely")
                }
                Warning::UnlikelyMass { body: name, .. } => {
                    (body(name).map(|b| b.name_span.clone()), "unlikely mass")
                }
                Warning::UnlikelyFriction { joint: name, .. } => {
                    let joint = self.joints.iter().find(|joint| joint.name == *name);
                    (joint.map(|joint| joint.spans.name.clone()), "unlikely friction")
                }
                _ => (None, ""),
            };
            let span = span.unwrap_or(WHOLE);
            let key = (discriminant(warning), span.clone());
            if !reported.contains(&key) {
                reported.push(key);
                self.context.push(
                    Diagnostic::warning("mechanism", warning.to_string())
                        .at(self.context.place(&span), label),
                );
            }
        }
    }
}
