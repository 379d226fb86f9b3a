//! Gearboxes of SDF: rigid couplings of two hinges on a reference body at a fixed ratio.

use super::super::description::Gearing;
use super::super::xml::Element;
use super::Reader;
use super::models::Model;
use crate::diagnostic::quoted;
use stiction_core::joint::JointType;

/// Minimum cosine of the angle between the axis of a gearbox and that of a hinge for which the axes
/// count as parallel.
const PARALLEL: f64 = 1.0 - 1e-9;

impl Reader<'_, '_> {
    /// Reads a gearbox with the equation theta_2 = -ratio theta_1. The angle theta_1 is the
    /// rotation of the parent relative to the reference body about `axis`, theta_2 that of the
    /// child about `axis2`.
    pub(super) fn read_gearbox(&mut self, model: &Model, element: &Element) -> Option<()> {
        if element.get("type") != Some("gearbox") {
            return Some(());
        }
        let context = self.context;
        let name = model.full(element.get("name")?);
        let reference = self.end(model, element, "gearbox_reference_body")?;
        let second = if element.child("axis2").is_some() { "axis2" } else { "axis" };
        let mut terms = Vec::new();
        for (tag, axis) in [("parent", "axis"), ("child", second)] {
            let body = self.end(model, element, tag)?;
            let direction = self.axis(model, element, axis)?;
            let found = self.robot.joints.iter().enumerate().find_map(|(index, joint)| {
                let sign = match (joint.from == reference, joint.to == reference) {
                    (true, false) if joint.to == body => 1.0,
                    (false, true) if joint.from == body => -1.0,
                    _ => return None,
                };
                let own = (self.poses[joint.from] * joint.frame_j).rotation.columns[2];
                let cosine = own.dot(direction);
                let is_same = joint.kind == JointType::Revolute && cosine.abs() > PARALLEL;
                is_same.then_some((index, sign * cosine.signum()))
            });
            let Some((joint, sign)) = found else {
                let message = format!(
                    "no hinge about the axis of {} connects its <{tag}> with its reference body",
                    element.title()
                );
                let help =
                    "a gearbox needs hinges about its axes, from the reference body to both links";
                context.error("gearbox", message, &element.place(), help);
                return None;
            };
            terms.push((joint, 0, sign));
        }
        let ratio = element.child_number(context, "gearbox_ratio").unwrap_or(1.0);
        if ratio == 0.0 {
            let message = format!("the ratio of gearbox {} is zero", quoted(&name));
            context.error("gearbox", message, &element.place(), "give another ratio");
            return None;
        }
        terms[0].2 *= ratio;
        terms.reverse();
        self.robot.gearings.push(Gearing {
            name,
            terms,
            constant: 0.0,
            place: Some(element.place()),
        });
        Some(())
    }
}
