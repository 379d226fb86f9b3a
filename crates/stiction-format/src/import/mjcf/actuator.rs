//! Reads the actuators of an MJCF file.

use super::super::description::{JointMotor, Motor};
use super::super::xml::Element;
use super::Reader;
use super::defaults::ACTUATORS;
use super::tendon::Tendons;
use crate::diagnostic::quoted;

impl Reader<'_, '_> {
    pub(super) fn read_actuators(&mut self, root: &Element, tendons: &mut Tendons) {
        for element in root.all("actuator").flat_map(|all| all.children.iter()) {
            if ACTUATORS.contains(&element.tag.as_str()) {
                let element = self.defaults.applied(self.context, element, None);
                self.read_actuator(&element, tendons);
            }
        }
    }

    fn read_actuator(&mut self, element: &Element, tendons: &mut Tendons) -> Option<()> {
        let context = self.context;
        let place = element.place();
        let gear = element.list(context, "gear").unwrap_or_default();
        let gear = gear.first().copied().unwrap_or(1.0);
        let terms = if let Some(name) = element.get("tendon") {
            let Some(tendon) = tendons.get_mut(name) else {
                context.note(
                    "an actuator whose tendon is not a <fixed> tendon is left out",
                    Some(place),
                );
                return None;
            };
            tendon.joints.clone()
        } else if let Some(name) = element.get("joint").or_else(|| element.get("jointinparent")) {
            match self.joints.get(name) {
                Some(&joint) => vec![(joint, 1.0)],
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
        if terms.iter().any(|(joint, _)| self.robot.joints[*joint].dofs.len() != 1) {
            context.warn("motors of ball and free joints are left out", Some(place));
            return None;
        }
        let terms: Vec<(usize, f64)> = terms.into_iter().filter(|term| term.1 != 0.0).collect();
        if gear == 0.0 || terms.is_empty() {
            context.note("an actuator with the gear 0 is left out", Some(place));
            return None;
        }
        // Inertia, friction and damping of a tendon are assigned to its first motor.
        let tendon = element.get("tendon").and_then(|name| tendons.get_mut(name));
        let mut own = [0.0; 3];
        if let Some(tendon) = tendon.filter(|tendon| !tendon.is_driven) {
            tendon.is_driven = true;
            own = [tendon.armature, tendon.friction, tendon.damping];
        }
        // The armature of an actuator is on the motor side of the gear.
        own[0] += element.number(context, "armature").unwrap_or(0.0).max(0.0) * gear * gear;
        let greatest = |key: &str, limited: &str| {
            let range = element.numbers::<2>(context, key)?;
            let is_limited = match element.get(limited) {
                Some("true") => true,
                Some("false") => false,
                _ => self.settings.autolimits,
            };
            if is_limited && range[0] != -range[1] {
                let message = format!(
                    "`{key}` is not symmetric: the larger magnitude is used for both directions"
                );
                context.note(message, Some(element.place()));
            }
            let most = range[0].abs().max(range[1].abs());
            (is_limited && most > 0.0).then_some(most)
        };
        let is_motor = element.tag == "motor" || is_direct(element);
        let force = greatest("forcerange", "forcelimited");
        // The force is the control signal times the gain, which `motor` sets to 1.
        let gain = match element.tag.as_str() {
            "general" => element.list(context, "gainprm").and_then(|gains| gains.first().copied()),
            _ => None,
        };
        let gain = gain.unwrap_or(1.0).abs();
        let control = is_motor.then(|| greatest("ctrlrange", "ctrllimited")).flatten();
        let control = control.map(|control| control * gain).filter(|force| *force > 0.0);
        let effort = [force, control].into_iter().flatten().reduce(f64::min);
        let effort = effort.map(|force| force * gear.abs());
        if !is_motor {
            let message = "control laws of actuators are left out: the actuators become motors without a \
                controller";
            context.note(message, Some(place.clone()));
        }
        let name = element.get("name").map(str::to_owned);
        let name = name.unwrap_or_else(|| self.robot.joints[terms[0].0].name.clone());
        let [armature, friction, damping] = own;
        let place = Some(place);
        let &[(joint, factor)] = terms.as_slice() else {
            self.robot.joint_motors.push(JointMotor {
                name,
                terms,
                gear,
                effort,
                armature,
                friction,
                damping,
                place,
            });
            return Some(());
        };
        let dof = &mut self.robot.joints[joint].dofs[0];
        dof.actuated = true;
        dof.armature += armature * factor * factor;
        dof.friction += friction * factor.abs();
        dof.damping += damping * factor * factor;
        self.robot.motors.push(Motor {
            name,
            joint,
            dof: 0,
            gear: gear * factor,
            effort: effort.map(|effort| effort * factor.abs()),
            rate: None,
            place,
        });
        Some(())
    }
}

/// Tests if a general actuator has a force that is proportional to its control signal.
fn is_direct(element: &Element) -> bool {
    let is = |key: &str, plain: &str| element.get(key).is_none_or(|word| word == plain);
    let plain = is("dyntype", "none") && is("gaintype", "fixed") && is("biastype", "none");
    element.tag == "general" && plain
}
