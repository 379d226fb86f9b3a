//! Finds actuators by name, and reports unknown names.

use super::context::Context;
use crate::diagnostic::{Diagnostic, did_you_mean, quoted};
use crate::expression::Measure;
use crate::source::Span;
use stiction_core::mechanism::Mechanism;

/// Names of all actuators of a mechanism, in the order of their indices.
pub(crate) struct Actuators {
    all: Vec<Actuator>,
    /// Names of all joints.
    joints: Vec<String>,
}

struct Actuator {
    /// Name of the actuator: the name of the joint, followed by the name of the degree of freedom
    /// if the joint has several actuators.
    name: String,
    /// Name of the joint, always followed by the name of the degree of freedom.
    long_name: String,
    translates: bool,
}

impl Actuators {
    pub(crate) fn of(mechanism: &Mechanism) -> Self {
        let joints = mechanism.joints();
        let all = mechanism.actuators().map(|(id, dof)| {
            let joint = &joints[id.0];
            let own = &joint.joint_type.dofs()[dof];
            Actuator {
                name: joint.actuator_name(dof),
                long_name: format!("{}.{}", joint.name, own.name),
                translates: own.translates(),
            }
        });
        Self { all: all.collect(), joints: joints.iter().map(|j| j.name.clone()).collect() }
    }

    pub(crate) fn len(&self) -> usize {
        self.all.len()
    }

    /// Returns the index of the actuator with this name.
    pub(crate) fn find(&self, name: &str) -> Option<usize> {
        self.all.iter().position(|a| a.name == name || a.long_name == name)
    }

    pub(crate) fn names(&self) -> impl Iterator<Item = &str> {
        self.all.iter().map(|actuator| actuator.name.as_str())
    }

    /// Returns `linear` for an actuator that translates, and `angular` for an actuator that
    /// rotates.
    pub(crate) fn measure(&self, actuator: usize, linear: Measure, angular: Measure) -> Measure {
        let translates = self.all.get(actuator).is_none_or(|actuator| actuator.translates);
        if translates { linear } else { angular }
    }

    /// Returns the message and the advice for an unknown name of an actuator.
    pub(crate) fn unknown(&self, name: &str) -> (String, Option<String>) {
        if self.joints.iter().any(|joint| joint == name) {
            let message = format!("joint {} has no actuator", quoted(name));
            let none = || "the model has no actuators".to_owned();
            return (
                message,
                did_you_mean(name, "actuators", self.names()).or_else(|| Some(none())),
            );
        }
        let help = did_you_mean(name, "actuators", self.names());
        let none = || "the model has no actuators: set `actuated = true` for a joint".to_owned();
        (format!("there is no actuator {}", quoted(name)), help.or_else(|| Some(none())))
    }

    /// Reports an unknown actuator at a place.
    pub(crate) fn report(&self, context: &Context<'_>, name: &str, span: &Span) {
        let (message, help) = self.unknown(name);
        context.push_missing(
            Diagnostic::error("unknown-name", message)
                .at(context.place(span), "unknown actuator")
                .maybe_help(help),
        );
    }
}
