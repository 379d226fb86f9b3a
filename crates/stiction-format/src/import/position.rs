//! Finds the position of the robot with closed loops that is nearest to the position of its file, and the coordinates
//! that fix this position.

use super::context::Context;
use super::description::{Description, Joint};
use super::text::Held;
use crate::diagnostic::quoted;
use crate::model_file::ModelFile;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::joint::{JointType, Motion};
use stiction_core::kinematics::{Coordinate, Target, locks};
use stiction_core::mechanism::{JointId, Mechanism};
use stiction_core::spatial::Pose;

/// Greatest change of a coordinate, rad or m, that is attributed to rounded numbers.
const SAME: f64 = 1e-6;

/// Greatest number of degrees of freedom of all joints for which loops are closed here.
const MOST: usize = 400;

/// Coordinates of all joints of an open chain; `None` for robots with loops, gearings, balls or
/// floating bodies.
fn open_chain(robot: &Description) -> Option<Vec<Held>> {
    let is_simple = |joint: &Joint| joint.kind == JointType::Fixed || !joint.dofs.is_empty();
    let is_open = robot.joints.len() + 1 == robot.bodies.len();
    let is_geared = !robot.gearings.is_empty() || !robot.gearing_tables.is_empty();
    if is_geared || !is_open || !robot.joints.iter().all(is_simple) {
        return None;
    }
    let held = |joint: &Joint| -> Vec<Held> {
        let dof = |(dof, own): (usize, &super::description::Coordinate)| Held {
            name: joint.dof_name(dof),
            value: own.position,
            is_angle: joint.kind.dofs()[dof].motion != Motion::Translation,
        };
        joint.dofs.iter().enumerate().map(dof).collect()
    };
    Some(robot.joints.iter().flat_map(held).collect())
}

type Fixed = Vec<(Coordinate, f64)>;

fn solver(model: &ModelFile, fixed: &Fixed) -> Option<InverseDynamics> {
    let coordinates: Vec<Coordinate> = fixed.iter().map(|(coordinate, _)| *coordinate).collect();
    let target = |&(_, value): &(_, f64)| Target { value, rate: 0.0, acceleration: 0.0 };
    let targets: Vec<Target<f64>> = fixed.iter().map(target).collect();
    let (mechanism, homes) = (model.mechanism.clone(), &model.initial_poses);
    InverseDynamics::new(mechanism, homes, &coordinates, &targets, Settings::default()).ok()
}

/// Moves the description to the nearest position with closed loops. Returns coordinates that fix this position,
/// preferably those of the motors.
pub(super) fn assemble(
    context: &Context<'_>,
    robot: &mut Description,
    model: &ModelFile,
) -> Option<Vec<Held>> {
    let mechanism = &model.mechanism;
    if let Some(held) = open_chain(robot) {
        return Some(held);
    }
    let size: usize = mechanism.joints().iter().map(|joint| joint.joint_type.dofs().len()).sum();
    if size > MOST {
        let message = format!(
            "the loops were not closed, because the joints have too many degrees of freedom in total ({size}): \
             add a motion to the model"
        );
        context.note(message, None);
        return None;
    }
    let found = locks(mechanism, &model.initial_poses, &[], &[]);
    let free = match found {
        Ok(free) => free,
        Err(error) => {
            let message = format!("the loops do not close: {error}");
            context.note(message.trim_end_matches('.'), None);
            return None;
        }
    };
    let Some(assembled) = solver(model, &free) else {
        context.note("the loops do not close near the position of the file", None);
        return None;
    };
    take_position(context, robot, &assembled);
    let held = by_motors(model, &assembled).unwrap_or(free);
    Some(held.into_iter().map(|(coordinate, value)| named(mechanism, coordinate, value)).collect())
}

/// Coordinates of the motors, with further ones for motions that the motors do not determine.
/// `None` if these do not fix the position of the robot.
fn by_motors(model: &ModelFile, at: &InverseDynamics) -> Option<Fixed> {
    let mechanism = &model.mechanism;
    let motors: Fixed = mechanism
        .actuators()
        .map(|(joint, dof)| {
            let coordinate = Coordinate::Joint { joint, dof };
            (coordinate, at.joint_motion(joint, dof).value)
        })
        .collect();
    if motors.is_empty() {
        return None;
    }
    let same = |again: &InverseDynamics| {
        let (before, after) = (at.bodies(), again.bodies());
        let moved = |body: usize| {
            let com = mechanism.bodies()[body].com;
            (before.pose[body].apply(com) + -after.pose[body].apply(com)).norm()
        };
        let limit = SAME * mechanism.characteristic_length();
        (0..mechanism.bodies().len()).all(|body| moved(body) < limit)
    };
    // Bodies with a local passive rotation need no coordinate for it.
    if solver(model, &motors).is_some_and(|again| same(&again)) {
        return Some(motors);
    }
    let coordinates: Vec<Coordinate> = motors.iter().map(|(coordinate, _)| *coordinate).collect();
    let target = |&(_, value): &(_, f64)| Target { value, rate: 0.0, acceleration: 0.0 };
    let targets: Vec<Target<f64>> = motors.iter().map(target).collect();
    let rest = locks(mechanism, &model.initial_poses, &coordinates, &targets).ok()?;
    let all: Fixed = motors.into_iter().chain(rest).collect();
    solver(model, &all).is_some_and(|again| same(&again)).then_some(all)
}

/// Difference of two coordinates; 0 for angles that differ by a full turn.
fn difference(a: f64, b: f64) -> f64 {
    let difference = a - b;
    if (difference.abs() - std::f64::consts::TAU).abs() < SAME { 0.0 } else { difference }
}

fn take_position(context: &Context<'_>, robot: &mut Description, at: &InverseDynamics) {
    let bodies = at.bodies();
    let across: Vec<Pose<f64>> =
        bodies.frame_j.iter().zip(&bodies.frame_k).map(|(j, k)| j.inverse() * *k).collect();
    let in_loops = robot.in_loops();
    let (mut largest, mut most) = (0.0_f64, String::new());
    for (index, joint) in robot.joints.iter().enumerate().filter(|(index, _)| in_loops[*index]) {
        let values = at.joint_coordinates(JointId(index));
        for (dof, value) in joint.dofs.iter().zip(values) {
            let change = difference(dof.position, value).abs();
            // Angles that differ by a full turn give the same position.
            let change = change.min((change - std::f64::consts::TAU).abs());
            if change > largest && !joint.closes {
                (largest, most) = (change, joint.name.clone());
            }
        }
    }
    if largest <= SAME {
        return;
    }
    for (index, joint) in robot.joints.iter_mut().enumerate().filter(|(index, _)| in_loops[*index])
    {
        let values = at.joint_coordinates(JointId(index));
        for (dof, value) in joint.dofs.iter_mut().zip(values) {
            if difference(dof.position, value).abs() > SAME {
                dof.position = value;
            }
        }
        if joint.kind == JointType::Spherical {
            // Frame J of the model is parallel to its body, see `text`.
            let axes = joint.frame_j.rotation;
            let rotation = axes.transpose() * across[index].rotation * axes;
            joint.start = Some(Pose { rotation, ..across[index] });
        }
    }
    let message = format!(
        "the loops do not close at {} of the file: they are closed nearby, where {} has changed \
         most, by {largest:.3}",
        robot.position,
        quoted(&most)
    );
    context.note(message, None);
}

fn named(mechanism: &Mechanism, coordinate: Coordinate, value: f64) -> Held {
    const AXES: [char; 3] = ['x', 'y', 'z'];
    let body = |body: stiction_core::mechanism::BodyId| &mechanism.bodies()[body.0].name;
    let types: Vec<JointType> = mechanism.joints().iter().map(|joint| joint.joint_type).collect();
    let name = match coordinate {
        Coordinate::Joint { joint, dof } => mechanism.joints()[joint.0].dof_name(dof),
        Coordinate::Position { body: id, axis } => format!("{}.{}", body(id), AXES[axis]),
        Coordinate::RotationVector { body: id, axis } => format!("{}.rv{}", body(id), AXES[axis]),
        Coordinate::Angle { body: id, index, .. } => format!("{}.r{}", body(id), index + 1),
    };
    Held { name, value, is_angle: coordinate.is_angle(&types) }
}
