//! Merges several point closures (ball joints that close loops) between the same two bodies into a
//! hinge or a rigid connection.

use super::super::context::Context;
use super::super::description::{Description, Joint};
use super::super::rotation::z_to;
use super::{SAME, remove, size_of};
use crate::diagnostic::quoted;
use stiction_core::joint::JointType::{Fixed, Revolute, Spherical};
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Merges point closures between the same two bodies wherever a hinge or a rigid connection can
/// replace them.
pub(super) fn merge(context: &Context<'_>, robot: &mut Description) {
    let size = size_of(robot);
    let mut index = 0;
    while index < robot.joints.len() {
        let group = same_bodies(robot, index);
        match merged(robot, &group, size) {
            Some((joint, used)) => {
                let names: Vec<String> =
                    used.iter().map(|&k| quoted(&robot.joints[k].name)).collect();
                let what =
                    if joint.kind == Fixed { "a rigid connection" } else { "one hinge joint" };
                let message = format!(
                    "the loop closures {} connect the same bodies and are replaced by {what} \
                     (--literal keeps them)",
                    names.join(", ")
                );
                context.note(message, joint.place.clone());
                let others: Vec<usize> = used.into_iter().filter(|&k| k != index).collect();
                robot.joints[index] = joint;
                remove(robot, &others, &[]);
            }
            None => index += 1,
        }
    }
}

/// Indices of the point closure `index` and of all later point closures between the same two
/// bodies; empty if joint `index` is not a point closure.
fn same_bodies(robot: &Description, index: usize) -> Vec<usize> {
    let own = &robot.joints[index];
    let is_same = |other: &Joint| {
        let ends = (other.from, other.to);
        (other.closes && other.kind == Spherical && other.damping == 0.0)
            && !other.is_extended()
            && (ends == (own.from, own.to) || ends == (own.to, own.from))
    };
    if !is_same(own) {
        return Vec::new();
    }
    (index..robot.joints.len()).filter(|&k| is_same(&robot.joints[k])).collect()
}

/// Joint that replaces a group of point closures, with the indices of the closures that it
/// replaces. `None` if the group does not contain two different points.
fn merged(robot: &Description, group: &[usize], size: f64) -> Option<(Joint, Vec<usize>)> {
    let [first, rest @ ..] = group else { return None };
    let own = &robot.joints[*first];
    let points = |index: usize| {
        let other = &robot.joints[index];
        let (j, k) = (other.frame_j.position, other.frame_k.position);
        if other.from == own.from { [j, k] } else { [k, j] }
    };
    let origin = points(*first);
    let from_origin = |index: usize| {
        let [j, k] = points(index);
        [j + -origin[0], k + -origin[1]]
    };
    let far = |index: &usize| from_origin(*index)[0].norm() > SAME * size;
    let second = *rest.iter().find(|index| far(index))?;
    let axes = from_origin(second).map(|between| between.direction());
    let [Some(one), Some(two)] = axes else { return None };
    // A third point off the axis connects both bodies rigidly.
    let beside = |index: &&usize| from_origin(**index)[0].cross(one).norm() > SAME * size;
    let third = rest.iter().find(beside).copied();
    let frame = |axis: Vec3<f64>, side: Option<Vec3<f64>>| match side {
        None => z_to(axis),
        Some(side) => {
            let y = axis.cross(side).direction().unwrap_or(axis.any_perpendicular());
            Mat3::from_columns(y.cross(axis), y, axis)
        }
    };
    let sides = third.map(&from_origin);
    let kind = if third.is_some() { Fixed } else { Revolute };
    let mut joint = Joint::new(own.name.clone(), kind, (own.from, own.to));
    joint.frame_j = Pose { rotation: frame(one, sides.map(|sides| sides[0])), position: origin[0] };
    joint.frame_k = Pose { rotation: frame(two, sides.map(|sides| sides[1])), position: origin[1] };
    joint.closes = true;
    joint.place = own.place.clone();
    joint.comment = own.comment.clone();
    let used: Vec<usize> = match third {
        Some(_) => group.to_vec(),
        // Further points on the axis are redundant.
        None => group
            .iter()
            .copied()
            .filter(|&k| from_origin(k)[0].cross(one).norm() <= SAME * size)
            .collect(),
    };
    Some((joint, used))
}
