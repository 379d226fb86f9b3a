//! Finds bodies and joints by name, and checks new names.

use super::context::Context;
use crate::diagnostic::{Diagnostic, quoted};
use crate::source::Span;
use std::collections::HashMap;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{BodyId, GROUND_NAME, JointId, Mechanism};

/// All bodies and joints by name, including those of a model with defects.
#[derive(Clone, Debug, Default)]
pub(crate) struct Names {
    bodies: HashMap<String, BodyId>,
    /// Joints by name; the type is `None` if it is invalid.
    joints: HashMap<String, (JointId, Option<JointType>)>,
    /// True if some legs are invalid.
    lost_legs: bool,
}

impl Names {
    /// Collects the names of bodies (without the ground) and joints, in the order of their indices.
    pub(crate) fn new<'a>(
        bodies: impl IntoIterator<Item = &'a str>,
        joints: impl IntoIterator<Item = (&'a str, Option<JointType>)>,
    ) -> Self {
        let mut names = Self::default();
        let bodies = std::iter::once(GROUND_NAME).chain(bodies);
        for (i, body) in bodies.into_iter().enumerate() {
            names.bodies.entry(body.to_owned()).or_insert(BodyId(i));
        }
        for (i, (joint, joint_type)) in joints.into_iter().enumerate() {
            names.joints.entry(joint.to_owned()).or_insert((JointId(i), joint_type));
        }
        names
    }

    /// Collects the names of a mechanism.
    pub(crate) fn of(mechanism: &Mechanism) -> Self {
        Self::new(
            mechanism.bodies().iter().skip(1).map(|body| body.name.as_str()),
            mechanism.joints().iter().map(|joint| (joint.name.as_str(), Some(joint.joint_type))),
        )
    }

    /// Stores if some legs of the mechanism are invalid.
    pub(crate) fn with_lost_legs(self, lost_legs: bool) -> Self {
        Self { lost_legs, ..self }
    }

    /// Tests if some legs are invalid, so that the names of their parts are unknown.
    pub(crate) fn has_lost_legs(&self) -> bool {
        self.lost_legs
    }

    /// Tests if a path can name a part of an invalid leg.
    pub(crate) fn may_be_lost(&self, path: &str) -> bool {
        let number = path.strip_prefix("leg");
        self.lost_legs && number.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()))
    }

    /// Returns the body with this name.
    pub(crate) fn body(&self, name: &str) -> Option<BodyId> {
        self.bodies.get(name).copied()
    }

    /// Returns the joint with this name, and its type.
    pub(crate) fn joint(&self, name: &str) -> Option<(JointId, Option<JointType>)> {
        self.joints.get(name).copied()
    }

    /// Returns the names of all moving bodies, sorted.
    pub(crate) fn body_names(&self) -> Vec<&str> {
        let mut names: Vec<_> =
            self.bodies.keys().map(String::as_str).filter(|name| *name != GROUND_NAME).collect();
        names.sort_unstable();
        names
    }

    /// Returns the names of all joints, sorted.
    pub(crate) fn joint_names(&self) -> Vec<&str> {
        let mut names: Vec<_> = self.joints.keys().map(String::as_str).collect();
        names.sort_unstable();
        names
    }
}

/// Reserved names, which are keys of motions and loads.
const TAKEN: &[&str] = &["title", "start", "duration", "step", "file", "order"];

/// Reports a new name that is reserved or contains characters that are not allowed; `kind` is the
/// type of the named part for messages.
pub(crate) fn check(context: &Context<'_>, name: &str, span: &Span, kind: &str) {
    let letters = |part: &str| {
        !part.is_empty() && part.chars().all(|c| c.is_alphanumeric() || c == '_' || c == '-')
    };
    let first = name.split('.').next().unwrap_or_default();
    let (problem, help) = if !name.split('.').all(letters) {
        let problem = format!("{} cannot be the name of a {kind}", quoted(name));
        (problem, "use letters, digits, `_` and `-`")
    } else if TAKEN.contains(&first) {
        let problem = format!("{} cannot be the name of a {kind}", quoted(name));
        (problem, "choose another name: this one is a key of motions and loads")
    } else {
        return;
    };
    context.push(
        Diagnostic::error("name", problem).at(context.place(span), "invalid name").help(help),
    );
}
