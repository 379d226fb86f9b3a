//! Finds the configuration with closed loops that is nearest to the configuration in the robot
//! file, and coordinates whose values determine this configuration.

use super::context::Context;
use super::description::{Description, GROUND};
use super::text::Held;
use crate::diagnostic::quoted;
use crate::model_file::ModelFile;
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::joint::JointType;
use stiction_core::kinematics::{AssemblyError, Coordinate, Target, locks};
use stiction_core::mechanism::{BodyId, JointId, Mechanism};
use stiction_core::spatial::Pose;

/// Greatest change of a coordinate, rad or m, that is attributed to rounded numbers in the file.
const SAME: f64 = 1e-6;

/// Maximum number of joint coordinates of the robot; for larger robots, loops are not closed.
const MOST: usize = 400;

/// Beginning of remarks on loops that no configuration closes.
const OPEN: &str = "the loops do not close";

type Fixed = Vec<(Coordinate, f64)>;

/// Returns coordinates of all joints that are in no loop and have no gearing, with their values in
/// the file's configuration. For free and spherical joints, these are coordinates of the pose or
/// orientation of the body that the joint carries.
fn outside_loops(robot: &Description) -> Fixed {
    let (in_loops, poses) = (robot.in_loops(), robot.poses());
    let mut fixed = Fixed::new();
    for (index, joint) in robot.joints.iter().enumerate().filter(|(index, _)| !in_loops[*index]) {
        for (dof, own) in joint.dofs.iter().enumerate() {
            fixed.push((Coordinate::Joint { joint: JointId(index), dof }, own.position));
        }
        if !matches!(joint.kind, JointType::Free | JointType::Spherical) {
            continue;
        }
        // The predecessor may be the body farther from the ground.
        let is_carried = !robot.reached_without(index, GROUND)[joint.to];
        let carried = if is_carried { joint.to } else { joint.from };
        let (body, Some(pose)) = (BodyId(carried), poses[carried]) else { continue };
        if joint.kind == JointType::Free {
            let position = pose.position.to_array();
            fixed.extend((0..3).map(|axis| (Coordinate::Position { body, axis }, position[axis])));
        }
        let vector = pose.rotation.rotation_vector().to_array();
        fixed.extend((0..3).map(|axis| (Coordinate::RotationVector { body, axis }, vector[axis])));
    }
    fixed
}

fn targets(fixed: &Fixed) -> Vec<Target<f64>> {
    let target = |&(_, value): &(_, f64)| Target { value, rate: 0.0, acceleration: 0.0 };
    fixed.iter().map(target).collect()
}

fn solver(model: &ModelFile, fixed: &Fixed) -> Option<InverseDynamics> {
    let coordinates: Vec<Coordinate> = fixed.iter().map(|(coordinate, _)| *coordinate).collect();
    let targets = targets(fixed);
    let (mechanism, homes) = (model.mechanism.clone(), &model.initial_poses);
    InverseDynamics::new(mechanism, homes, &coordinates, &targets, Settings::default()).ok()
}

/// Moves `robot` to the nearest configuration with closed loops. Returns coordinates that determine
/// this configuration, preferably those of the motors. Returns `None` after a remark if the robot
/// has too many joint coordinates or the loops cannot be closed.
pub(super) fn assemble(
    context: &Context<'_>,
    robot: &mut Description,
    model: &ModelFile,
) -> Option<Vec<Held>> {
    let mechanism = &model.mechanism;
    let names = |fixed: Fixed| -> Vec<Held> {
        fixed.into_iter().map(|(coordinate, value)| named(mechanism, coordinate, value)).collect()
    };
    let outside = outside_loops(robot);
    if !robot.in_loops().contains(&true) {
        return Some(names(outside));
    }
    let size: usize = mechanism.joints().iter().map(|joint| joint.joint_type.dofs().len()).sum();
    if size > MOST {
        let message = format!(
            "the loops were not closed: the joints have {size} degrees of freedom in total, above the limit of \
             {MOST} for closing loops at import; runs close them if you add a motion to the model"
        );
        context.note(message, None);
        return None;
    }
    let fixed = match with_locks(model, outside.clone()) {
        Ok(fixed) => fixed,
        Err(error) => {
            // Some of these errors begin with the same words.
            let message = match error.to_string() {
                message if message.starts_with(OPEN) => message,
                reason => format!("{OPEN}: {reason}"),
            };
            context.warn(message.trim_end_matches('.'), None);
            return None;
        }
    };
    let Some(assembled) = solver(model, &fixed) else {
        context.warn("the loops do not close near the position given in the file", None);
        return None;
    };
    take_position(context, robot, &assembled);
    Some(names(by_motors(model, &assembled, &outside).unwrap_or(fixed)))
}

/// Extends `fixed` by coordinates that determine the remaining degrees of freedom.
fn with_locks(model: &ModelFile, fixed: Fixed) -> Result<Fixed, AssemblyError> {
    let coordinates: Vec<Coordinate> = fixed.iter().map(|(coordinate, _)| *coordinate).collect();
    let rest = locks(&model.mechanism, &model.initial_poses, &coordinates, &targets(&fixed))?;
    Ok(fixed.into_iter().chain(rest).collect())
}

/// Returns the coordinates of the motors and of joints outside of loops, and further coordinates
/// for degrees of freedom that these coordinates leave undetermined. `None` if they do not
/// determine the robot's configuration.
fn by_motors(model: &ModelFile, at: &InverseDynamics, outside: &Fixed) -> Option<Fixed> {
    let mechanism = &model.mechanism;
    let mut fixed: Fixed = mechanism
        .actuators()
        .map(|(joint, dof)| {
            let coordinate = Coordinate::Joint { joint, dof };
            (coordinate, at.joint_motion(joint, dof).value)
        })
        .collect();
    if fixed.is_empty() {
        return None;
    }
    let is_further = |one: &&(Coordinate, f64)| fixed.iter().all(|(known, _)| *known != one.0);
    let further: Fixed = outside.iter().filter(is_further).copied().collect();
    fixed.extend(further);
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
    if solver(model, &fixed).is_some_and(|again| same(&again)) {
        return Some(fixed);
    }
    let all = with_locks(model, fixed).ok()?;
    solver(model, &all).is_some_and(|again| same(&again)).then_some(all)
}

/// Difference of two joint coordinates, rad or m; 0 for angles that differ by a full turn.
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
            // Angles that differ by a full turn describe the same configuration.
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
            // In the model, frame J of a spherical joint is parallel to the frame of its body, see
            // `text`.
            let axes = joint.frame_j.rotation;
            let rotation = axes.transpose() * across[index].rotation * axes;
            joint.start = Some(Pose { rotation, ..across[index] });
        }
    }
    let message = format!(
        "the loops do not close at {} of the file: a nearby position that closes them is used; {} changes most, by \
         {largest:.3} (rad or m)",
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
