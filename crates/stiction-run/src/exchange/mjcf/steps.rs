//! Decomposition of each joint into a sequence of MJCF joints: hinges, slides and balls.

use super::super::Home;
use stiction_core::joint::JointType;
use stiction_core::mechanism::{Joint, Mechanism};
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Type of an MJCF joint.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Hinge,
    Slide,
    Ball,
}

/// One MJCF joint in the sequence that replaces a joint of the mechanism.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    pub(super) kind: Kind,
    /// Suffix that distinguishes this MJCF joint; it is appended to the name of the mechanism's joint.
    pub(super) suffix: &'static str,
    /// Degree of freedom of the mechanism's joint that this MJCF joint represents; for a ball the first of three.
    /// `None` for the advance of a screw, which follows from the angle.
    pub(super) dof: Option<usize>,
    /// Position of the MJCF joint in the frame of the child body, m.
    pub(super) position: Vec3<f64>,
    /// Axis of the MJCF joint in the frame of the child body; arbitrary for a ball.
    pub(super) axis: Vec3<f64>,
    /// Coordinate of the MJCF joint at the home position, rad or m; zero for a ball.
    pub(super) home: f64,
}

/// Returns the MJCF joints that lead from frame J to frame K of a joint, in order. Each entry
/// contains the type of the MJCF joint, the index of its axis, the suffix of its name, and its
/// degree of freedom.
fn sequence(joint_type: JointType) -> &'static [(Kind, usize, &'static str, Option<usize>)] {
    use Kind::{Ball, Hinge, Slide};
    match joint_type {
        JointType::Revolute => &[(Hinge, 2, "", Some(0))],
        JointType::Prismatic => &[(Slide, 2, "", Some(0))],
        JointType::Helical => &[(Hinge, 2, "", Some(0)), (Slide, 2, ".advance", None)],
        JointType::Cylindrical => &[(Hinge, 2, ".angle", Some(0)), (Slide, 2, ".slide", Some(1))],
        JointType::Universal => &[(Hinge, 2, ".first", Some(0)), (Hinge, 0, ".second", Some(1))],
        JointType::Spherical => &[(Ball, 0, "", Some(0))],
        JointType::Planar => {
            &[(Slide, 0, ".x", Some(0)), (Slide, 1, ".y", Some(1)), (Hinge, 2, ".angle", Some(2))]
        }
        JointType::Fixed => &[],
        JointType::Free => &[
            (Slide, 0, ".x", Some(0)),
            (Slide, 1, ".y", Some(1)),
            (Slide, 2, ".z", Some(2)),
            (Ball, 0, ".rotation", Some(3)),
        ],
    }
}

/// Types of the MJCF joints that replace a joint of the mechanism.
pub(super) fn kinds(mechanism: &Mechanism, joint: usize) -> Vec<Kind> {
    sequence(mechanism.joints()[joint].joint_type).iter().map(|(kind, ..)| *kind).collect()
}

/// Lists the MJCF joints that replace a joint of the mechanism, in the order in which they move the
/// child body. The child is the successor of the joint, or the predecessor if `reversed`. In both
/// cases the coordinates are those of the mechanism's joint.
///
/// The MJCF joints of one body act in sequence. Their positions and axes refer to the child in the
/// reference position of the file, which is the home position. With `X_JK = A1(q1) A2(q2) ..`, the
/// factors after step `i` relate the frame of step `i` to frame K. If the child is the predecessor,
/// the sequence is reversed, and the factors before step `i` relate the frame of step `i` to frame
/// J.
pub(super) fn steps(home: &Home<'_>, index: usize, reversed: bool) -> Vec<Step> {
    let joint = &home.model.mechanism.joints()[index];
    let sequence = sequence(joint.joint_type);
    let coordinate = |dof: Option<usize>| match dof {
        Some(dof) => home.coordinates[index][dof].unwrap_or(0.0),
        None => joint.pitch * home.coordinates[index][0].unwrap_or(0.0),
    };
    let moves: Vec<Pose<f64>> = sequence
        .iter()
        .map(|&(kind, axis, _, dof)| match kind {
            Kind::Hinge => Pose {
                rotation: Mat3::about_axis(axis, coordinate(dof).sin_cos()),
                position: Vec3::zero(),
            },
            Kind::Slide => Pose::at(Vec3::unit(axis) * coordinate(dof)),
            Kind::Ball => Pose { rotation: home.across[index].rotation, position: Vec3::zero() },
        })
        .collect();
    let product =
        |poses: &[Pose<f64>]| poses.iter().fold(Pose::identity(), |all, pose| all * *pose);
    let frame = child_frame(joint, reversed);
    let step = |k: usize| {
        let (kind, axis, suffix, dof) = sequence[k];
        // Frame of this step relative to the child.
        let seen = match reversed {
            false => frame * product(&moves[k + 1..]).inverse(),
            true => frame * product(&moves[..k]),
        };
        let axis = seen.rotation.columns[axis];
        let axis = if reversed { -axis } else { axis };
        let home = if kind == Kind::Ball { 0.0 } else { coordinate(dof) };
        // MuJoCo ignores the position of a slide. The file contains the origin of the joint at
        // coordinate zero.
        let position = match kind {
            Kind::Slide => seen.position + axis * -home,
            _ => seen.position,
        };
        Step { kind, suffix, dof, position, axis, home }
    };
    let mut steps: Vec<Step> = (0..sequence.len()).map(step).collect();
    if reversed {
        steps.reverse();
    }
    steps
}

/// Returns the joint frame that is fixed in the child body of a joint.
fn child_frame(joint: &Joint, reversed: bool) -> Pose<f64> {
    if reversed { joint.frame_j } else { joint.frame_k }
}
