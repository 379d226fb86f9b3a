//! Tables of motors.

use super::super::context::Context;
use super::super::description::{Coordinate, Description, Motor};
use super::joint::is_angle;
use super::numbers::quantity;
use super::{key, line, text};
use std::fmt::Write;

/// True if a coordinate gets the table of a motor: `actuated = true` says less.
pub(super) fn is_written(robot: &Description, joint: usize, dof: usize) -> bool {
    let own = &robot.joints[joint].dofs[dof];
    own.actuated
        && (own.armature > 0.0 || own.friction > 0.0 || motors(robot, joint, dof).any(is_special))
}

/// True if a motor has more than a name.
fn is_special(motor: &Motor) -> bool {
    motor.gear != 1.0 || motor.effort.is_some() || motor.rate.is_some()
}

fn motors(robot: &Description, joint: usize, dof: usize) -> impl Iterator<Item = &Motor> {
    robot.motors.iter().filter(move |motor| (motor.joint, motor.dof) == (joint, dof))
}

pub(super) fn write(context: &Context<'_>, out: &mut String, robot: &Description) {
    for (index, joint) in robot.joints.iter().enumerate() {
        for (dof, own) in joint.dofs.iter().enumerate() {
            if !own.actuated {
                if own.armature > 0.0 {
                    let message = "the armature of a joint without a motor has no counterpart in \
                                   the model: it is left out";
                    context.note(message, joint.place.clone());
                }
                continue;
            }
            if !is_written(robot, index, dof) {
                continue;
            }
            let all: Vec<&Motor> = motors(robot, index, dof).collect();
            let plain = Motor {
                name: joint.dof_name(dof),
                joint: index,
                dof,
                gear: 1.0,
                effort: None,
                rate: None,
                place: joint.place.clone(),
            };
            let shown = if all.is_empty() { vec![&plain] } else { all };
            for motor in &shown {
                one(out, robot, motor, (own, shown.len()));
            }
        }
    }
}

/// Writes the motor of a coordinate; several share its effort, inertia and friction equally.
fn one(out: &mut String, robot: &Description, motor: &Motor, (own, count): (&Coordinate, usize)) {
    let joint = &robot.joints[motor.joint];
    let turns = is_angle(joint.kind, motor.dof);
    let header = format!("[actuators.{}]", key(&motor.name));
    let _ = writeln!(out, "\n{}", line(motor.place.as_ref(), &header));
    let _ = writeln!(out, "joint = {}", text(&joint.dof_name(motor.dof)));
    // Joint effort over motor torque is the ratio, or 2 pi over the lead.
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
