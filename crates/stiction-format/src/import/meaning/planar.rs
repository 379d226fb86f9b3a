//! Replaces point closures in chains that move in a plane by hinges.
//!
//! Consider the path through the tree of bodies between the two bodies of a closure. If all hinges
//! on this path are parallel, and all slides perpendicular to the hinges, the two bodies rotate
//! relative to each other only about the direction of the hinges, in every configuration. One of
//! the three equations of the closure is then redundant, and the closure is a hinge about the same
//! direction.

use super::super::context::Context;
use super::super::description::{Description, Joint};
use super::super::rotation::z_to;
use super::{are_parallel, are_perpendicular};
use crate::diagnostic::quoted;
use stiction_core::joint::JointType::{Fixed, Planar, Prismatic, Revolute, Spherical};
use stiction_core::spatial::{Pose, Vec3};

/// Replaces point closures in planar chains by hinges.
pub(super) fn hinges(context: &Context<'_>, robot: &mut Description) {
    for index in 0..robot.joints.len() {
        let own = &robot.joints[index];
        let is_point =
            own.closes && own.kind == Spherical && own.damping == 0.0 && !own.is_extended();
        let Some((normal, relative)) = is_point.then(|| plane(robot, own)).flatten() else {
            continue;
        };
        let message = format!(
            "the loop closure {} is in a planar chain: its ball joint is replaced by a hinge joint \
             (--literal keeps it)",
            quoted(&own.name)
        );
        context.note(message, own.place.clone());
        let mut joint = Joint::new(own.name.clone(), Revolute, (own.from, own.to));
        // The angle of the hinge is zero where the coordinates of the chain are zero.
        let rotation = z_to(normal);
        joint.frame_j = Pose { rotation, position: own.frame_j.position };
        joint.frame_k = Pose {
            rotation: relative.rotation.transpose() * rotation,
            position: own.frame_k.position,
        };
        joint.closes = true;
        joint.place = own.place.clone();
        joint.comment = own.comment.clone();
        robot.joints[index] = joint;
    }
}

/// Finds the direction about which the two bodies of a closure rotate relative to each other.
/// Returns this direction in the axes of the first body, and the pose of the second body in the
/// first at zero coordinates of the joints between them. `None` if the chain between the bodies
/// does not move in a plane.
fn plane(robot: &Description, closure: &Joint) -> Option<(Vec3<f64>, Pose<f64>)> {
    let path = path(robot, (closure.from, closure.to))?;
    let mut at = Pose::identity();
    let mut normal: Option<Vec3<f64>> = None;
    let mut slides = Vec::new();
    for (index, forward) in path {
        let joint = &robot.joints[index];
        let (near, far) = match forward {
            true => (joint.frame_j, joint.frame_k),
            false => (joint.frame_k, joint.frame_j),
        };
        let axis = at.rotation * near.rotation.columns[2];
        match joint.kind {
            Fixed => {}
            Revolute | Planar => match normal {
                Some(known) if !are_parallel(known, axis) => return None,
                Some(_) => {}
                None => normal = Some(axis),
            },
            Prismatic => slides.push(axis),
            _ => return None,
        }
        at = at * near * far.inverse();
    }
    let normal = normal?;
    slides.iter().all(|slide| are_perpendicular(*slide, normal)).then_some((normal, at))
}

/// Joints of the spanning tree on the path from one body to another. The flag is true for a joint
/// that is traversed from its predecessor to its successor.
fn path(robot: &Description, (from, to): (usize, usize)) -> Option<Vec<(usize, bool)>> {
    let mut reached: Vec<Option<(usize, bool)>> = vec![None; robot.bodies.len()];
    let mut open = vec![from];
    let mut seen = vec![false; robot.bodies.len()];
    seen[from] = true;
    while let Some(body) = open.pop() {
        for (index, joint) in robot.joints.iter().enumerate().filter(|(_, joint)| !joint.closes) {
            let (next, forward) = match (joint.from == body, joint.to == body) {
                (true, _) => (joint.to, true),
                (_, true) => (joint.from, false),
                _ => continue,
            };
            if !std::mem::replace(&mut seen[next], true) {
                reached[next] = Some((index, forward));
                open.push(next);
            }
        }
    }
    let mut path = Vec::new();
    let mut body = to;
    while body != from {
        let (index, forward) = reached[body]?;
        path.push((index, forward));
        body = if forward { robot.joints[index].from } else { robot.joints[index].to };
    }
    path.reverse();
    Some(path)
}
