//! Reads the motors of a URDF file from transmissions, command interfaces or the effort limits of
//! joints.

use super::super::context::Context;
use super::super::description::{Description, Motor};
use super::super::xml::Element;
use super::Tree;
use super::convention::Convention;
use super::joint::UNLIMITED;
use crate::diagnostic::quoted;
use std::collections::HashMap;

/// Reads motors and their limits from the URDF file. If neither this file nor the YAML file names
/// actuated joints, motors are assumed at the joints of an open chain.
pub(super) fn read(
    context: &Context<'_>,
    tree: &Tree,
    root: &Element,
    convention: Convention,
    robot: &mut Description,
) {
    for transmission in root.all("transmission") {
        read_transmission(context, tree, transmission, robot);
    }
    for control in root.all("ros2_control") {
        for joint in control.all("joint").filter(|joint| joint.child("command_interface").is_some())
        {
            let index = joint.get("name").and_then(|name| tree.joints.get(name));
            if let Some([dof]) = index.map(|&index| robot.joints[index].dofs.as_mut_slice()) {
                dof.actuated = true;
            }
        }
    }
    let actuated = || robot.joints.iter().any(|joint| joint.dofs.iter().any(|dof| dof.actuated));
    let named = convention.names_motors || !robot.motors.is_empty() || actuated();
    if !named {
        guess(context, root, tree, robot);
    }
    limits(context, root, tree, robot);
}

fn read_transmission(
    context: &Context<'_>,
    tree: &Tree,
    transmission: &Element,
    robot: &mut Description,
) -> Option<()> {
    let joints: Vec<&Element> = transmission.all("joint").collect();
    let place = transmission.place();
    let [joint] = joints.as_slice() else {
        let message = "a transmission that does not have exactly one joint is left out";
        context.note(message, Some(place));
        return None;
    };
    let name = joint.required(context, "name")?;
    let Some(&index) = tree.joints.get(name) else {
        let message = format!("{} names a joint that the file does not have", transmission.title());
        context.note(message, Some(place));
        return None;
    };
    if robot.joints[index].dofs.len() != 1 {
        return None;
    }
    let actuator = transmission.child("actuator");
    let reduction = [actuator, Some(transmission)].into_iter().flatten().find_map(|element| {
        let value = element.child_number(context, "mechanicalReduction")?;
        Some((value, element.child("mechanicalReduction")?.place()))
    });
    if let Some((_, place)) = reduction.as_ref().filter(|(gear, _)| *gear == 0.0) {
        let message = format!("the mechanicalReduction of {} is 0", transmission.title());
        let help = "write the speed of the motor divided by that of the joint, or remove the element for 1";
        context.error("transmission", message, place, help);
        return None;
    }
    let gear = reduction.map_or(1.0, |(gear, _)| gear);
    robot.joints[index].dofs[0].actuated = true;
    robot.motors.push(Motor {
        name: actuator.and_then(|actuator| actuator.get("name")).unwrap_or(name).to_owned(),
        joint: index,
        dof: 0,
        gear,
        effort: None,
        rate: None,
        place: Some(place),
    });
    Some(())
}

/// Reads the effort limit, N or N m, and the rate limit, m/s or rad/s, of each joint. The keys are
/// the names of the joints.
fn limits_of(context: &Context<'_>, root: &Element) -> HashMap<String, [Option<f64>; 2]> {
    let read = |joint: &Element| {
        let limit = joint.child("limit")?;
        let values = ["effort", "velocity"].map(|key| limit.number(context, key));
        Some((joint.get("name")?.to_owned(), values))
    };
    root.all("joint").filter_map(read).collect()
}

/// Assumes a motor at each joint with one degree of freedom, except joints that follow another
/// joint or have an effort limit of 0, and reports this assumption. For a closed chain, only
/// reports that the file does not name actuated joints.
fn guess(context: &Context<'_>, root: &Element, tree: &Tree, robot: &mut Description) {
    if robot.joints.iter().any(|joint| joint.closes) {
        context.note(
            "the file does not say which joints have motors: add `actuated = true` to them",
            None,
        );
        return;
    }
    let limits = limits_of(context, root);
    let follows: Vec<usize> = robot.gearings.iter().map(|gearing| gearing.terms[0].0).collect();
    for (name, &index) in &tree.joints {
        let effort = limits.get(name).and_then(|[effort, _]| *effort);
        if effort != Some(0.0)
            && !follows.contains(&index)
            && let [dof] = robot.joints[index].dofs.as_mut_slice()
        {
            dof.actuated = true;
        }
    }
    context.note(
        "the file does not say which joints have motors: all joints of one degree of freedom are \
         actuated, except those that follow another joint or have an effort limit of 0",
        None,
    );
}

/// Assigns the effort and rate limits of joints to their motors; creates motors for actuated joints
/// that have limits but no motor.
fn limits(context: &Context<'_>, root: &Element, tree: &Tree, robot: &mut Description) {
    let limits = limits_of(context, root);
    let mut names: Vec<(&String, &usize)> = tree.joints.iter().collect();
    names.sort_by_key(|(_, index)| **index);
    for (name, &index) in names {
        let Some([effort, rate]) = limits.get(name) else { continue };
        let positive =
            |limit: &Option<f64>| limit.filter(|limit| *limit > 0.0 && *limit < UNLIMITED);
        for motor in robot.motors.iter_mut().filter(|motor| motor.joint == index) {
            (motor.effort, motor.rate) = (positive(effort), positive(rate));
        }
        let has_motor = robot.motors.iter().any(|motor| motor.joint == index);
        let is_actuated = robot.joints[index].dofs.iter().any(|dof| dof.actuated);
        if is_actuated && !has_motor && (positive(effort).is_some() || positive(rate).is_some()) {
            robot.motors.push(Motor {
                name: name.clone(),
                joint: index,
                dof: 0,
                gear: 1.0,
                effort: positive(effort),
                rate: positive(rate),
                place: robot.joints[index].place.clone(),
            });
        }
        if !is_actuated && robot.joints[index].closes {
            let message = format!("limits of {} are left out", quoted(name));
            context.note(message, robot.joints[index].place.clone());
        }
    }
}
