//! Tables of a model file that describe joints.

use super::{Unwritable, friction, pose, rotation, vector};
use stiction_core::joint::JointType;
use stiction_core::mechanism::{Joint, JointRange, Mechanism, RangeOf};
use stiction_core::spatial::{Mat3, Pose, Quaternion, Vec3};
use toml::{Table, Value};

pub(super) fn table(mechanism: &Mechanism, joint: &Joint) -> Result<Table, Unwritable> {
    let mut table = Table::new();
    let mut put = |key: &str, value: Value| table.insert(key.to_owned(), value);
    let name = |body: usize| Value::from(mechanism.bodies()[body].name.as_str());
    put("type", joint.joint_type.symbol().into());
    put("from", name(joint.predecessor.0));
    put("to", name(joint.successor.0));
    put("at", vector(joint.frame_j.position));
    put("to_at", vector(joint.frame_k.position));
    let axes = joint.frame_j.rotation;
    if !has_no_axes(joint.joint_type) {
        put("axis", vector(column(&axes, 2)));
        let x = if joint.joint_type == JointType::Universal { "second_axis" } else { "x_axis" };
        put(x, vector(column(&axes, 0)));
    }
    let turn = axes * joint.frame_k.rotation.transpose();
    if turn.rotation_vector() != Vec3::zero() {
        put("turn", rotation(turn));
    }
    if joint.pitch != 0.0 {
        put("pitch", joint.pitch.into());
    }
    let driven: Vec<Value> =
        joint.actuated_dofs().map(|k| joint.joint_type.dofs()[k].name.into()).collect();
    if !driven.is_empty() {
        put("actuated", driven.into());
    }
    if let Some(start) = start(joint) {
        put("start", start);
    }
    // In the file, the z axes of a spherical joint are those of the bodies that the joint connects.
    let is_tilted = joint.joint_type == JointType::Spherical
        && !joint.ranges.is_empty()
        && column(&axes, 2) != Vec3::new(0.0, 0.0, 1.0);
    if is_tilted {
        return Err(Unwritable::TiltedRange(joint.name.clone()));
    }
    if let Some(range) = range(joint) {
        put("range", range);
    }
    if let Some(friction) = friction::table(joint)? {
        put("friction", friction.into());
    }
    let parts = joint.compliance.iter().flat_map(|compliance| compliance.parts());
    let parts: Table = parts
        .filter(|(_, value)| *value != 0.0)
        .map(|(part, value)| (part.to_owned(), value.into()))
        .collect();
    if joint.compliance.is_some() {
        put("compliance", parts.into());
    }
    Ok(table)
}

/// Returns the ranges of a joint as a value of the model file: the range of its only degree of
/// freedom, or a table of ranges by name. `None` if the joint has no ranges.
pub(in crate::exchange) fn range(joint: &Joint) -> Option<Value> {
    let pair = |range: &JointRange| -> Value {
        let (least, greatest) = range.limits;
        vec![Value::from(least), Value::from(greatest)].into()
    };
    let name = |of: RangeOf| match of {
        RangeOf::Dof(dof) => joint.joint_type.dofs()[dof].name,
        RangeOf::Tilt => "tilt",
    };
    match (joint.ranges.as_slice(), joint.joint_type.dofs()) {
        ([], _) => None,
        ([range], [_]) => Some(pair(range)),
        (all, _) => {
            let table: Table =
                all.iter().map(|range| (name(range.of).to_owned(), pair(range))).collect();
            Some(table.into())
        }
    }
}

const fn has_no_axes(joint_type: JointType) -> bool {
    matches!(joint_type, JointType::Spherical | JointType::Fixed | JointType::Free)
}

fn column(matrix: &Mat3<f64>, j: usize) -> Vec3<f64> {
    Vec3::from(std::array::from_fn(|i| matrix.at(i, j)))
}

/// Returns the start coordinates of a joint for the assembly. The file contains no axes for
/// spherical and free joints. In the file, the frames of these joints are therefore rotated, and
/// the start coordinates refer to the rotated frames.
fn start(joint: &Joint) -> Option<Value> {
    let axes = joint.frame_j.rotation;
    let turned = |x: &[f64]| axes * Quaternion::from_coordinates(x).rotation() * axes.transpose();
    match (joint.joint_type, joint.start.as_deref()?) {
        (JointType::Fixed, _) => None,
        (JointType::Spherical, q) => Some(rotation(turned(q))),
        (JointType::Free, [x, y, z, q @ ..]) => {
            let position = axes * Vec3::new(*x, *y, *z);
            Some(pose(Pose { position, rotation: turned(q) }))
        }
        (_, [q]) => Some((*q).into()),
        (_, q) => Some(q.iter().copied().map(Value::from).collect::<Vec<_>>().into()),
    }
}
