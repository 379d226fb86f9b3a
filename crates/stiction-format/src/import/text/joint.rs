//! Writes the tables of joints into the text of a model file.

use super::super::context::Context;
use super::super::description::{Coordinate, Description, Joint};
use super::numbers::{angle, axis, guess, is_none, length, lengths, quantity, rotation};
use super::{comment, header, line, motor, text};
use std::fmt::Write;
use stiction_core::joint::{JointType, Motion};
use stiction_core::spatial::Mat3;

/// Nominal pin radius, m, written for rotary joints whose friction or damping is given as a moment.
/// Friction moments in the model do not depend on its value, because it cancels.
const RADIUS: f64 = 0.01;
/// Friction coefficient written for a joint with constant friction, which is modelled by a preload.
/// It is so small that the friction due to the joint's reaction force is negligible.
const SMALL: f64 = 1e-6;

pub(super) fn write(
    context: &Context<'_>,
    out: &mut String,
    robot: &Description,
    index: usize,
    in_loop: bool,
) {
    let joint = &robot.joints[index];
    out.push('\n');
    if let Some(remark) = &joint.comment {
        comment(out, remark);
    }
    let header = header("joints", &joint.name);
    let _ = writeln!(out, "{}", line(joint.place.as_ref(), &header));
    let _ = writeln!(out, "type = \"{}\"", joint.kind.symbol());
    let _ = writeln!(out, "from = {}", text(&robot.bodies[joint.from].name));
    let _ = writeln!(out, "to = {}", text(&robot.bodies[joint.to].name));
    frames(out, joint);
    pitch(out, joint);
    actuation(out, robot, index);
    start(out, joint, in_loop);
    ranges(out, joint);
    friction(context, out, robot, index);
}

pub(super) fn pitch(out: &mut String, joint: &Joint) {
    if joint.kind == JointType::Helical {
        let _ = writeln!(out, "pitch = {}", quantity(joint.pitch, "m/rad"));
    }
}

pub(in crate::import) fn has_axes(kind: JointType) -> bool {
    !matches!(kind, JointType::Spherical | JointType::Fixed | JointType::Free)
}

pub(super) fn frames(out: &mut String, joint: &Joint) {
    for (name, point) in [("at", joint.frame_j.position), ("to_at", joint.frame_k.position)] {
        let point = lengths(point);
        if point != "[0, 0, 0]" {
            let _ = writeln!(out, "{name} = {point}");
        }
    }
    let axes = joint.frame_j.rotation;
    if has_axes(joint.kind) {
        let _ = writeln!(out, "axis = {}", axis(axes.columns[2]));
        match joint.kind {
            JointType::Universal => {
                let _ = writeln!(out, "second_axis = {}", axis(axes.columns[0]));
            }
            JointType::Planar => {
                let _ = writeln!(out, "x_axis = {}", axis(axes.columns[0]));
            }
            _ => {}
        }
    }
    let turn = axes * joint.frame_k.rotation.transpose();
    if !is_none(turn) {
        let _ = writeln!(out, "turn = {}", rotation(turn));
    }
}

pub(super) fn actuation(out: &mut String, robot: &Description, index: usize) {
    let joint = &robot.joints[index];
    let names: Vec<String> = (0..joint.dofs.len())
        // Coordinates with a motor table need no key `actuated`.
        .filter(|&dof| {
            joint.dofs[dof].actuated
                && !motor::is_written(robot, index, dof)
                && !motor::is_driven_otherwise(robot, index, dof)
        })
        .map(|dof| text(joint.kind.dofs()[dof].name))
        .collect();
    if names.is_empty() {
        return;
    }
    let _ = match joint.dofs.len() {
        1 => writeln!(out, "actuated = true"),
        _ => writeln!(out, "actuated = [{}]", names.join(", ")),
    };
}

/// Tests if the coordinate with index `dof` of a joint of this type is an angle rather than a
/// length.
pub(super) fn is_angle(kind: JointType, dof: usize) -> bool {
    kind.dofs()[dof].motion != Motion::Translation
}

pub(super) fn start(out: &mut String, joint: &Joint, in_loop: bool) {
    let axes = joint.frame_j.rotation;
    let turned = |pose: Mat3<f64>| axes * pose * axes.transpose();
    match (joint.kind, joint.start) {
        (JointType::Fixed, _) => {}
        (JointType::Spherical, Some(start)) => {
            let turned = turned(start.rotation);
            if !is_none(turned) || in_loop {
                let _ = writeln!(out, "start = {}", rotation(turned));
            }
        }
        (JointType::Free, Some(start)) => {
            let (position, turned) = (axes * start.position, turned(start.rotation));
            let position = format!("position = {}", lengths(position));
            let _ = match is_none(turned) {
                true => writeln!(out, "start = {{ {position} }}"),
                false => {
                    let rotation = rotation(turned);
                    writeln!(out, "start = {{ {position}, rotation = {rotation} }}")
                }
            };
        }
        (JointType::Spherical | JointType::Free, None) => {}
        _ => {
            let is_zero = joint.dofs.iter().all(|dof| dof.position == 0.0);
            // The coordinates of joints that close a loop follow from those of the other joints.
            if is_zero && (!in_loop || joint.closes) {
                return;
            }
            let values: Vec<String> = (0..joint.dofs.len())
                .map(|dof| guess(joint.dofs[dof].position, is_angle(joint.kind, dof)))
                .collect();
            let _ = match values.as_slice() {
                [value] => writeln!(out, "start = {value}"),
                values => writeln!(out, "start = [{}]", values.join(", ")),
            };
        }
    }
}

pub(super) fn ranges(out: &mut String, joint: &Joint) {
    if let Some(table) = &joint.range {
        let _ = match table.get("range") {
            // For a joint with one coordinate, the table contains a pair of limits under the key
            // `range`.
            Some(range) => writeln!(out, "range = {range}"),
            None => writeln!(out, "range = {}", toml::Value::Table(table.clone())),
        };
        return;
    }
    let range = |dof: usize| {
        let [least, greatest] = joint.dofs[dof].range?;
        let bound = |value: f64| match is_angle(joint.kind, dof) {
            true => angle(value),
            false => length(value),
        };
        Some(format!("[{}, {}]", bound(least), bound(greatest)))
    };
    match joint.dofs.len() {
        1 => {
            if let Some(range) = range(0) {
                let _ = writeln!(out, "range = {range}");
            }
        }
        count => {
            let each = (0..count).filter_map(|dof| {
                Some(format!("{} = {}", joint.kind.dofs()[dof].name, range(dof)?))
            });
            let each: Vec<String> = each.collect();
            if !each.is_empty() {
                let _ = writeln!(out, "range = {{ {} }}", each.join(", "));
            }
        }
    }
}

/// Returns the friction interfaces of a joint type: the name of each interface in a friction table,
/// and the index of its coordinate. The name is empty for the only interface of a joint.
fn interfaces(kind: JointType) -> &'static [(&'static str, usize)] {
    match kind {
        JointType::Revolute | JointType::Prismatic => &[("", 0)],
        JointType::Universal => &[("first", 0), ("second", 1)],
        JointType::Cylindrical => &[("angle", 0), ("slide", 1)],
        _ => &[],
    }
}

pub(super) fn friction(context: &Context<'_>, out: &mut String, robot: &Description, index: usize) {
    let joint = &robot.joints[index];
    if let Some(table) = &joint.friction {
        inline(out, table);
        return;
    }
    if joint.kind == JointType::Spherical && joint.damping > 0.0 {
        let damping = quantity(joint.damping, "N m s/rad");
        let _ = writeln!(out, "friction = {{ viscous = {damping}, radius = {} }}", length(RADIUS));
        return;
    }
    let places = interfaces(joint.kind);
    let has = |dof: &Coordinate| dof.damping > 0.0 || dof.friction > 0.0;
    if places.is_empty() {
        if joint.dofs.iter().any(has) {
            let message = "damping and friction of joints of this type are left out";
            context.warn(message, joint.place.clone());
        }
        return;
    }
    let mut tables = Vec::new();
    for &(name, dof) in places {
        let turns = is_angle(joint.kind, dof);
        let own = &joint.dofs[dof];
        // If the coordinate has a motor table, its constant friction is written there.
        let constant = if motor::is_written(robot, index, dof) { 0.0 } else { own.friction };
        if own.damping == 0.0 && constant == 0.0 {
            if places.len() > 1 && joint.dofs.iter().any(has) {
                let radius =
                    if turns { format!(", radius = {}", length(RADIUS)) } else { String::new() };
                tables.push((name, format!("{{ mu = 0{radius} }}")));
            }
            continue;
        }
        let mut keys = Vec::new();
        if constant > 0.0 {
            let force = constant / SMALL / if turns { RADIUS } else { 1.0 };
            keys.push(format!("mu = {SMALL:e}"));
            keys.push(format!("preload = {}", quantity(force, "N")));
            let unit = if turns { "N m" } else { "N" };
            let remark = format!(
                "Constant friction of {constant} {unit}: the coefficient is so small that only the preload matters."
            );
            comment(out, &remark);
        }
        if own.damping > 0.0 {
            let unit = if turns { "N m s/rad" } else { "N s/m" };
            keys.push(format!("viscous = {}", quantity(own.damping, unit)));
        }
        if turns {
            keys.push(format!("radius = {}", length(RADIUS)));
        }
        tables.push((name, format!("{{ {} }}", keys.join(", "))));
    }
    // Tables are written only if some interface has friction.
    let any = tables.iter().any(|(_, table)| !table.starts_with("{ mu = 0"));
    if !any {
        return;
    }
    let _ = match tables.as_slice() {
        [("", table)] => writeln!(out, "friction = {table}"),
        tables => {
            let each: Vec<String> =
                tables.iter().map(|(name, table)| format!("{name} = {table}")).collect();
            writeln!(out, "friction = {{ {} }}", each.join(", "))
        }
    };
}

/// Writes the friction table of an extension element on one line.
fn inline(out: &mut String, table: &toml::Table) {
    let value = toml::Value::Table(table.clone());
    let _ = writeln!(out, "friction = {value}");
}

/// Checks that axes of joints are written as names of coordinate axes where possible.
#[cfg(test)]
mod tests {
    use super::*;
    use stiction_core::spatial::{Pose, Vec3};

    #[test]
    fn universal_axes_are_written() {
        let mut joint = Joint::new("u", JointType::Universal, (0, 0));
        let rotation = Mat3::from_columns(Vec3::unit(1), Vec3::unit(2), Vec3::unit(0));
        joint.frame_j = Pose { rotation, position: Vec3::zero() };
        joint.frame_k = joint.frame_j;
        let mut out = String::new();
        frames(&mut out, &joint);
        assert_eq!(out, "axis = \"x\"\nsecond_axis = \"y\"\n");
    }
}
