//! Removes links whose only purpose is to mark a joint's frame; exports of this program contain
//! such links.

use super::super::description::{Description, GROUND, Joint};
use super::remove;
use stiction_core::joint::JointType;
use stiction_core::mechanism::GROUND_NAME;

/// Endings of the names of such links: the frame of a joint on its child, and the frames of a closure.
const ENDINGS: [&str; 3] = [".frame", ".from", ".to"];

/// Removes links that mark a frame, and moves the frame to the joint itself.
pub(in crate::import) fn fold(robot: &mut Description) {
    fold_ground(robot);
    while let Some((body, mount, joint)) = next(robot) {
        let mount_joint = robot.joints[mount].clone();
        // Body on which the link is mounted, and pose of the link in this body.
        let (base, place) = match mount_joint.to == body {
            true => (mount_joint.from, mount_joint.relative()),
            false => (mount_joint.to, mount_joint.relative().inverse()),
        };
        let own = &mut robot.joints[joint];
        if own.from == body {
            (own.from, own.frame_j) = (base, place * own.frame_j);
        } else {
            (own.to, own.frame_k) = (base, place * own.frame_k);
        }
        if mount_joint.closes {
            own.closes = true;
            own.comment = mount_joint.comment;
        }
        remove(robot, &[mount], &[body]);
    }
}

/// Replaces a massless link named `ground`, fixed to the world, by the ground.
fn fold_ground(robot: &mut Description) -> Option<()> {
    let is_ground =
        |body: usize| robot.bodies[body].name == GROUND_NAME && robot.bodies[body].is_massless();
    let mount = robot.joints.iter().position(|joint| {
        joint.kind == JointType::Fixed
            && joint.from == GROUND
            && joint.to > 0
            && is_ground(joint.to)
    })?;
    let (body, place) = (robot.joints[mount].to, robot.joints[mount].relative());
    for joint in &mut robot.joints {
        if joint.from == body {
            (joint.from, joint.frame_j) = (GROUND, place * joint.frame_j);
        } else if joint.to == body {
            (joint.to, joint.frame_k) = (GROUND, place * joint.frame_k);
        }
    }
    for spring in &mut robot.springs {
        for (end, point) in spring.ends.iter_mut().zip(&mut spring.points) {
            if *end == body {
                (*end, *point) = (GROUND, place.apply(*point));
            }
        }
    }
    remove(robot, &[mount], &[body]);
    Some(())
}

/// Finds a link that marks a frame; returns its index, that of its fixed joint, and that of its
/// other joint.
fn next(robot: &Description) -> Option<(usize, usize, usize)> {
    (GROUND + 1..robot.bodies.len()).find_map(|body| {
        let content = &robot.bodies[body];
        let is_mark = ENDINGS.iter().any(|ending| content.name.ends_with(ending));
        if !is_mark || !content.is_massless() {
            return None;
        }
        let touching = |joint: &&Joint| joint.from == body || joint.to == body;
        let mut joints = (0..robot.joints.len()).filter(|&k| touching(&&robot.joints[k]));
        let (a, b, None) = (joints.next()?, joints.next()?, joints.next()) else { return None };
        let is_fixed = |k: usize| robot.joints[k].kind == JointType::Fixed;
        // A mount in the tree rather than a rigid closure.
        let is_mount = |k: usize| is_fixed(k) && !robot.joints[k].closes;
        match (is_mount(a), is_mount(b)) {
            (true, _) => Some((body, a, b)),
            (_, true) => Some((body, b, a)),
            _ if is_fixed(a) => Some((body, a, b)),
            _ if is_fixed(b) => Some((body, b, a)),
            _ => None,
        }
    })
}
