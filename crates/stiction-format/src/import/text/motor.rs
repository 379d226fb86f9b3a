//! Writes the tables of motors into the text of a model file.

use super::super::context::Context;
use super::super::description::{Coordinate, Description, JointMotor, Motor};
use super::joint::is_angle;
use super::numbers::quantity;
use super::{entries, key, line, text};
use crate::source::Place;
use std::collections::HashSet;
use std::fmt::Write;

/// Tests if a coordinate needs a motor table, because the key `actuated = true` cannot express its
/// motor.
pub(super) fn is_written(robot: &Description, joint: usize, dof: usize) -> bool {
    let own = &robot.joints[joint].dofs[dof];
    let is_alone =
        motors(robot, joint, dof).next().is_some() || !is_driven_otherwise(robot, joint, dof);
    own.actuated
        && is_alone
        && (own.armature > 0.0 || own.friction > 0.0 || motors(robot, joint, dof).any(is_special))
}

/// Tests if a coordinate is driven by a motor that drives several joints, or by a motor from an
/// extension element.
pub(super) fn is_driven_otherwise(robot: &Description, joint: usize, dof: usize) -> bool {
    let several = || robot.joint_motors.iter().flat_map(|motor| &motor.terms);
    let name = robot.joints[joint].dof_name(dof);
    (dof == 0 && several().any(|term| term.0 == joint))
        || robot.motor_tables.iter().any(|(_, table)| {
            table.get("joint").and_then(toml::Value::as_str) == Some(&name)
                || table.get("joints").and_then(|joints| joints.get(&name)).is_some()
        })
}

/// Tests if a motor has a gear ratio other than 1 or a limit, which only a motor table can express.
fn is_special(motor: &Motor) -> bool {
    motor.gear != 1.0 || motor.effort.is_some() || motor.rate.is_some()
}

fn motors(robot: &Description, joint: usize, dof: usize) -> impl Iterator<Item = &Motor> {
    robot.motors.iter().filter(move |motor| (motor.joint, motor.dof) == (joint, dof))
}

/// Formats the motor table of a joint as part of a leg, without the key `joint`. Returns `None` if
/// the joint needs no motor table, or if a leg cannot contain the table: the joint must have one
/// degree of freedom and one motor with the name of the joint, and the motor no `rotor_axis`.
pub(super) fn of_leg(robot: &Description, joint: usize) -> Option<String> {
    let own = &robot.joints[joint];
    if own.dofs.len() != 1 || own.kind.dofs().len() != 1 {
        return None;
    }
    let mut out = String::new();
    if is_driven_otherwise(robot, joint, 0) {
        let (_, table) = robot.motor_tables.iter().find(|(name, _)| *name == own.name)?;
        let is_own = table.get("joint").and_then(toml::Value::as_str) == Some(&own.name);
        let names = |(name, table): &&(String, toml::Table)| {
            *name != own.name && table.to_string().contains(&text(&own.name))
        };
        let is_alone = motors(robot, joint, 0).next().is_none()
            && robot.joint_motors.iter().flat_map(|motor| &motor.terms).all(|term| term.0 != joint)
            && robot.motor_tables.iter().find(names).is_none();
        // `rotor_axis` may name a body, which differs between legs.
        if !is_own || !is_alone || table.contains_key("rotor_axis") {
            return None;
        }
        let mut table = table.clone();
        table.remove("joint");
        entries(&mut out, &table);
        return Some(out);
    }
    if !is_written(robot, joint, 0) {
        return None;
    }
    let all: Vec<&Motor> = motors(robot, joint, 0).collect();
    let plain = plain(robot, joint, 0);
    let motor = match all.as_slice() {
        [] => &plain,
        [motor] if motor.name == own.name => motor,
        _ => return None,
    };
    values(&mut out, robot, motor, (&own.dofs[0], 1));
    Some(out)
}

/// Returns the place of a joint's motor in the imported file: the place of the joint if the file
/// has no motor for it, `None` if the motor comes from an extension element.
pub(super) fn place(robot: &Description, joint: usize) -> Option<&Place> {
    match motors(robot, joint, 0).next() {
        Some(motor) => motor.place.as_ref(),
        None if robot.motor_tables.iter().any(|(name, _)| *name == robot.joints[joint].name) => {
            None
        }
        None => robot.joints[joint].place.as_ref(),
    }
}

/// Creates a motor with gear ratio 1 and without limits, for a coordinate that has no motor in the
/// imported file.
fn plain(robot: &Description, joint: usize, dof: usize) -> Motor {
    let own = &robot.joints[joint];
    Motor {
        name: own.dof_name(dof),
        joint,
        dof,
        gear: 1.0,
        effort: None,
        rate: None,
        place: own.place.clone(),
    }
}

/// Writes the tables of all motors except those of the joints `in_legs`, which are written with
/// their legs.
pub(super) fn write(
    context: &Context<'_>,
    out: &mut String,
    robot: &Description,
    in_legs: &HashSet<usize>,
) {
    let is_in_legs = |name: &str| in_legs.iter().any(|joint| robot.joints[*joint].name == name);
    for (name, table) in robot.motor_tables.iter().filter(|(name, _)| !is_in_legs(name)) {
        let _ = writeln!(out, "\n[actuators.{}]", key(name));
        entries(out, table);
    }
    for motor in &robot.joint_motors {
        several(out, robot, motor);
    }
    for (index, joint) in robot.joints.iter().enumerate() {
        for (dof, own) in joint.dofs.iter().enumerate() {
            let is_driven_otherwise = is_driven_otherwise(robot, index, dof);
            let has_own = motors(robot, index, dof).next().is_some();
            if !own.actuated || (is_driven_otherwise && !has_own) {
                if own.armature > 0.0 {
                    let message = "the armature of a joint without a motor of its own has no counterpart in \
                                   the model: it is left out";
                    context.warn(message, joint.place.clone());
                }
                continue;
            }
            if !is_written(robot, index, dof) || in_legs.contains(&index) {
                continue;
            }
            let all: Vec<&Motor> = motors(robot, index, dof).collect();
            let plain = plain(robot, index, dof);
            let shown = if all.is_empty() { vec![&plain] } else { all };
            for motor in &shown {
                if shown.len() > 1 {
                    let message = "several motors of a joint share its effort equally";
                    context.note(message, motor.place.clone());
                }
                one(out, robot, motor, (own, shown.len()));
            }
        }
    }
}

/// Writes the table of a motor that drives several joints.
fn several(out: &mut String, robot: &Description, motor: &JointMotor) {
    let header = format!("[actuators.{}]", key(&motor.name));
    let _ = writeln!(out, "\n{}", line(motor.place.as_ref(), &header));
    let name = |joint: usize| key(&robot.joints[joint].dof_name(0));
    let each: Vec<String> =
        motor.terms.iter().map(|(joint, part)| format!("{} = {part}", name(*joint))).collect();
    let _ = writeln!(out, "joints = {{ {} }}", each.join(", "));
    let translates = |joint: usize| !is_angle(robot.joints[joint].kind, 0);
    let count = motor.terms.iter().filter(|term| translates(term.0)).count();
    if count == motor.terms.len() {
        let lead = std::f64::consts::TAU / motor.gear;
        let _ = writeln!(out, "lead = {}", quantity(lead, "m/rev"));
    } else {
        if count > 0 {
            // A lead of 2 pi m per revolution converts one metre to one rad.
            let _ = writeln!(out, "lead = {}", quantity(std::f64::consts::TAU, "m/rev"));
        }
        if motor.gear != 1.0 {
            let _ = writeln!(out, "ratio = {}", motor.gear);
        }
    }
    let square = motor.gear * motor.gear;
    if motor.armature > 0.0 {
        let inertia = quantity(motor.armature / square, "kg m^2");
        let _ = writeln!(out, "rotor_inertia = {inertia}");
    }
    let mut losses = Vec::new();
    if motor.friction > 0.0 {
        let constant = quantity(motor.friction / motor.gear.abs(), "N m");
        losses.push(format!("constant = {constant}"));
    }
    if motor.damping > 0.0 {
        losses.push(format!("viscous = {}", quantity(motor.damping / square, "N m s/rad")));
    }
    if !losses.is_empty() {
        let _ = writeln!(out, "motor_friction = {{ {} }}", losses.join(", "));
    }
    if let Some(effort) = motor.effort {
        let peak = quantity(effort / motor.gear.abs(), "N m");
        let _ = writeln!(out, "limits = {{ peak = {peak} }}");
    }
}

/// Writes the table of one motor of a coordinate. All `count` motors of the coordinate share its
/// effort, inertia and friction equally.
fn one(out: &mut String, robot: &Description, motor: &Motor, (own, count): (&Coordinate, usize)) {
    let joint = &robot.joints[motor.joint];
    let header = format!("[actuators.{}]", key(&motor.name));
    let _ = writeln!(out, "\n{}", line(motor.place.as_ref(), &header));
    let _ = writeln!(out, "joint = {}", text(&joint.dof_name(motor.dof)));
    values(out, robot, motor, (own, count));
}

/// Writes all keys of a motor table except the key of the joint.
fn values(
    out: &mut String,
    robot: &Description,
    motor: &Motor,
    (own, count): (&Coordinate, usize),
) {
    let turns = is_angle(robot.joints[motor.joint].kind, motor.dof);
    // The ratio of joint effort to motor torque is the gear ratio, or 2 pi divided by the lead.
    if !turns {
        let lead = std::f64::consts::TAU / motor.gear;
        let _ = writeln!(out, "lead = {}", quantity(lead, "m/rev"));
    } else if motor.gear != 1.0 {
        let _ = writeln!(out, "ratio = {}", motor.gear);
    }
    let part = 1.0 / count as f64;
    if count > 1 {
        let _ = writeln!(out, "share = {part}");
    }
    if own.armature > 0.0 {
        let inertia = own.armature * part / (motor.gear * motor.gear);
        let _ = writeln!(out, "rotor_inertia = {}", quantity(inertia, "kg m^2"));
    }
    if own.friction > 0.0 {
        let constant = quantity(own.friction * part / motor.gear.abs(), "N m");
        let _ = writeln!(out, "motor_friction = {{ constant = {constant} }}");
    }
    let mut limits = Vec::new();
    if let Some(effort) = motor.effort {
        limits.push(format!("peak = {}", quantity(effort / motor.gear.abs(), "N m")));
    }
    if let Some(rate) = motor.rate {
        limits.push(format!("speed = {}", quantity(rate * motor.gear.abs(), "rad/s")));
    }
    if !limits.is_empty() {
        let _ = writeln!(out, "limits = {{ {} }}", limits.join(", "));
    }
}
