//! Actuators of MJCF.

use super::super::description::Motor;
use super::super::xml::Element;
use super::Reader;
use super::defaults::ACTUATORS;
use super::tendon::Tendons;
use crate::diagnostic::quoted;

impl Reader<'_, '_> {
    pub(super) fn read_actuators(&mut self, root: &Element, tendons: &Tendons) {
        for element in root.all("actuator").flat_map(|all| all.children.iter()) {
            if ACTUATORS.contains(&element.tag.as_str()) {
                let element = self.defaults.applied(self.context, element, None);
                self.read_actuator(&element, tendons);
            }
        }
    }

    fn read_actuator(&mut self, element: &Element, tendons: &Tendons) -> Option<()> {
        let context = self.context;
        let place = element.place();
        let gear = element.list(context, "gear").unwrap_or_default();
        let gear = gear.first().copied().unwrap_or(1.0);
        let (joint, factor) = if let Some(tendon) = element.get("tendon") {
            match tendons.get(tendon).map(Vec::as_slice) {
                Some([only]) => *only,
                Some(several) => {
                    let names: Vec<String> = several
                        .iter()
                        .map(|(joint, _)| quoted(&self.robot.joints[*joint].name))
                        .collect();
                    let message = format!(
                        "the motor of several joints, {}, has no counterpart in the model",
                        names.join(", ")
                    );
                    context.note(message, Some(place));
                    return None;
                }
                None => {
                    context.note("an actuator of this tendon is left out", Some(place));
                    return None;
                }
            }
        } else if let Some(name) = element.get("joint").or_else(|| element.get("jointinparent")) {
            match self.joints.get(name) {
                Some(&joint) => (joint, 1.0),
                None => {
                    let message = format!("there is no joint {}", quoted(name));
                    context.error("name", message, &place, "");
                    return None;
                }
            }
        } else {
            let message = "an actuator without joint or tendon has no counterpart in the model";
            context.note(message, Some(place));
            return None;
        };
        let gear = gear * factor;
        let [dof] = self.robot.joints[joint].dofs.as_mut_slice() else {
            context.note("motors of ball and free joints are left out", Some(place));
            return None;
        };
        if gear == 0.0 {
            context.note("an actuator with the gear 0 is left out", Some(place));
            return None;
        }
        dof.actuated = true;
        // The armature of an actuator turns with its shaft.
        dof.armature += element.number(context, "armature").unwrap_or(0.0).max(0.0) * gear * gear;
        let greatest = |key: &str, limited: &str| {
            let range = element.numbers::<2>(context, key)?;
            let is_limited = match element.get(limited) {
                Some("true") => true,
                Some("false") => false,
                _ => self.settings.autolimits,
            };
            let most = range[0].abs().max(range[1].abs());
            (is_limited && most > 0.0).then_some(most)
        };
        let force = greatest("forcerange", "forcelimited");
        let control = (element.tag == "motor").then(|| greatest("ctrlrange", "ctrllimited"));
        let effort = force.or(control.flatten()).map(|force| force * gear.abs());
        if !matches!(element.tag.as_str(), "motor" | "general") {
            let message = "control laws of actuators are left out: they are motors";
            context.note(message, Some(place.clone()));
        }
        let name = element.get("name").map(str::to_owned);
        let name = name.unwrap_or_else(|| self.robot.joints[joint].name.clone());
        self.robot.motors.push(Motor {
            name,
            joint,
            dof: 0,
            gear,
            effort,
            rate: None,
            place: Some(place),
        });
        Some(())
    }
}
