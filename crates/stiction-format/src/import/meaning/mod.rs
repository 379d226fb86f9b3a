//! Recognises joints that a format can only express indirectly: a hinge written as a ball joint
//! that closes a loop in a planar chain, a ball joint written as three hinges, or one hinge written
//! as two hinges about the same axis.
//!
//! The mechanism stays the same: exactly the relative motions that the file allows remain possible.

mod chains;
mod closures;
mod declared;
mod helpers;
mod planar;

pub(super) use declared::restore;
pub(super) use helpers::fold;

use super::context::Context;
use super::description::Description;
use stiction_core::spatial::Vec3;

/// Tolerance for parallel directions (sine of the angle) and for coincident lines (distance over
/// the size of the robot). Files have at least nine digits.
const SAME: f64 = 1e-8;

/// Replaces joints that the format expresses indirectly, such as a ball joint written as three
/// hinges.
pub(super) fn simplify(context: &Context<'_>, robot: &mut Description) {
    chains::merge(context, robot);
    closures::merge(context, robot);
    planar::hinges(context, robot);
}

fn are_parallel(a: Vec3<f64>, b: Vec3<f64>) -> bool {
    a.cross(b).norm() <= SAME
}

fn are_perpendicular(a: Vec3<f64>, b: Vec3<f64>) -> bool {
    a.dot(b).abs() <= SAME
}

/// Size of the robot, m: the greatest distance of a joint from the origin of its bodies.
pub(super) fn size_of(robot: &Description) -> f64 {
    let frames = robot.joints.iter().flat_map(|joint| [joint.frame_j, joint.frame_k]);
    frames.map(|frame| frame.position.norm()).fold(0.0, f64::max).max(1e-6)
}

/// Removes joints and bodies and renumbers all others.
fn remove(robot: &mut Description, joints: &[usize], bodies: &[usize]) {
    let kept = |removed: &[usize], count: usize| -> Vec<usize> {
        let mut next = 0;
        (0..count)
            .map(|index| {
                let own = next;
                next += usize::from(!removed.contains(&index));
                own
            })
            .collect()
    };
    let (joint_of, body_of) = (kept(joints, robot.joints.len()), kept(bodies, robot.bodies.len()));
    let mut index = 0;
    robot.joints.retain(|_| {
        index += 1;
        !joints.contains(&(index - 1))
    });
    index = 0;
    robot.bodies.retain(|_| {
        index += 1;
        !bodies.contains(&(index - 1))
    });
    for joint in &mut robot.joints {
        (joint.from, joint.to) = (body_of[joint.from], body_of[joint.to]);
    }
    for spring in &mut robot.springs {
        spring.ends = spring.ends.map(|end| body_of[end]);
    }
    for motor in &mut robot.motors {
        motor.joint = joint_of[motor.joint];
    }
    for motor in &mut robot.joint_motors {
        motor.terms.iter_mut().for_each(|term| term.0 = joint_of[term.0]);
    }
    for gearing in &mut robot.gearings {
        gearing.terms.iter_mut().for_each(|term| term.0 = joint_of[term.0]);
    }
}
