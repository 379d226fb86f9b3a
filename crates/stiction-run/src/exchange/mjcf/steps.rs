//! Joints as MJCF has them: hinges, slides and balls, one after the other.

use super::super::Home;
use stiction_core::joint::JointType;
use stiction_core::mechanism::Joint;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// The kind of a joint of MJCF.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Hinge,
    Slide,
    Ball,
}

/// One joint of MJCF, part of one of ours.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Step {
    pub(super) kind: Kind,
    /// What is added to the joint's name.
    pub(super) suffix: &'static str,
    /// The freedom of our joint whose coordinate it has; none for the advance of a screw, which the
    /// angle dictates. Of a ball, the first of three.
    pub(super) dof: Option<usize>,
    /// Where it is, in the frame of the child, m.
    pub(super) position: Vec3<f64>,
    /// Its axis in the frame of the child; of a ball without meaning.
    pub(super) axis: Vec3<f64>,
    /// Its coordinate where the mechanism is put together, rad or m; zero for a ball.
    pub(super) home: f64,
}

/// What a joint is made of, from J to K: kind, axis, suffix and freedom.
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

/// The joints of MJCF that make up a joint, in the order in which they move the child: its successor,
/// or its predecessor if `reversed`. Coordinates are those of our joint in both cases.
///
/// MJCF's joints of one body act one after the other, each fixed in the child as the later ones leave
/// it, and all are given as they are in the file's own position, which is the home. With
/// `X_JK = A1(q1) A2(q2) ..`, step `i` is seen by K through the later ones, and, if the child is the
/// predecessor, walked backwards and seen by J through the earlier ones.
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
        // Where the child sees the frame about which this step moves.
        let seen = match reversed {
            false => frame * product(&moves[k + 1..]).inverse(),
            true => frame * product(&moves[..k]),
        };
        let axis = seen.rotation.columns[axis];
        Step {
            kind,
            suffix,
            dof,
            position: seen.position,
            axis: if reversed { -axis } else { axis },
            home: if kind == Kind::Ball { 0.0 } else { coordinate(dof) },
        }
    };
    let mut steps: Vec<Step> = (0..sequence.len()).map(step).collect();
    if reversed {
        steps.reverse();
    }
    steps
}

/// The joint's frame in its child.
fn child_frame(joint: &Joint, reversed: bool) -> Pose<f64> {
    if reversed { joint.frame_j } else { joint.frame_k }
}
