//! Removes links whose only purpose is to mark a joint's frame, and joins the parts of bodies that
//! an export divided. Files that this program exports contain both.

use super::super::description::{Body, Description, GROUND, Joint};
use super::super::inertia::Mass;
use super::remove;
use stiction_core::joint::JointType;
use stiction_core::mechanism::GROUND_NAME;
use stiction_core::spatial::Pose;

/// Endings of the names of links that mark a frame: the frame of a joint on its child, and the two
/// frames of a loop closure.
const ENDINGS: [&str; 3] = [".frame", ".from", ".to"];

/// Removes links that mark a frame, and moves the frame to the joint itself. Also replaces a link
/// named `ground` by the ground, and joins divided bodies.
pub(in crate::import) fn fold(robot: &mut Description) {
    fold_ground(robot);
    join_parts(robot);
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

/// Joins bodies that an export divided at a closure: `rocker@D` is a part of `rocker`, welded to it.
///
/// Separate bodies would distribute redundant reactions differently from the undivided body.
fn join_parts(robot: &mut Description) {
    while let Some((weld, body, part)) = next_part(robot) {
        let joint = &robot.joints[weld];
        let place = match joint.to == part {
            true => joint.relative(),
            false => joint.relative().inverse(),
        };
        let mass = |body: &Body| Mass { mass: body.mass, com: body.com, inertia: body.inertia };
        let sum = mass(&robot.bodies[body]).with(mass(&robot.bodies[part]).placed(place));
        let own = &mut robot.bodies[body];
        (own.mass, own.com, own.inertia) = (sum.mass, sum.com, sum.inertia);
        move_to(robot, part, (body, place));
        remove(robot, &[weld], &[part]);
    }
}

/// Finds a weld between a body and a part that an export divided from it. Returns the indices of
/// the weld, the body and the part.
fn next_part(robot: &Description) -> Option<(usize, usize, usize)> {
    let is_part = |part: usize, body: usize| {
        let name = robot.bodies[part].name.rsplit_once('@');
        body != GROUND && name.is_some_and(|(whole, _)| whole == robot.bodies[body].name)
    };
    robot.joints.iter().enumerate().find_map(|(index, joint)| match (joint.from, joint.to) {
        _ if joint.kind != JointType::Fixed || !joint.closes => None,
        (body, part) if is_part(part, body) => Some((index, body, part)),
        (part, body) if is_part(part, body) => Some((index, body, part)),
        _ => None,
    })
}

/// Moves all joints and springs of `body` to the body `target`; `place` is the pose of `body` in
/// `target`.
fn move_to(robot: &mut Description, body: usize, (target, place): (usize, Pose<f64>)) {
    for joint in &mut robot.joints {
        if joint.from == body {
            (joint.from, joint.frame_j) = (target, place * joint.frame_j);
        } else if joint.to == body {
            (joint.to, joint.frame_k) = (target, place * joint.frame_k);
        }
    }
    for spring in &mut robot.springs {
        for (end, point) in spring.ends.iter_mut().zip(&mut spring.points) {
            if *end == body {
                (*end, *point) = (target, place.apply(*point));
            }
        }
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
    move_to(robot, body, (GROUND, place));
    remove(robot, &[mount], &[body]);
    Some(())
}

/// Finds a link that marks a frame. Returns the indices of the link, of the fixed joint that mounts
/// it, and of its other joint.
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
        // A fixed joint of the tree takes precedence over a rigid loop closure.
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
