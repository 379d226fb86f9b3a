//! Placements of equal legs: a rotation about an axis for each leg, and the leg's joints without
//! this rotation.

use super::super::description::{Description, Joint};
use super::super::text::has_axes;
use super::Group;
use crate::read::geometry::{about, frame};
use stiction_core::joint::JointType;
use stiction_core::spatial::{Mat3, Pose, Vec3};

/// Largest relative difference between numbers that is attributed to rounding. Such numbers are
/// written once for all legs.
const SAME: f64 = 5e-13;
/// Largest difference between an entry of a rotation matrix and 0, 1 or -1 that is attributed to
/// rounding.
const WHOLE: f64 = 4e-15;

/// Axis and angles of the rotations that place the legs of a group.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::import) struct Placement {
    pub(in crate::import) axis: Vec3<f64>,
    /// Angle of each leg, rad.
    pub(in crate::import) angles: Vec<f64>,
}

/// Possible placements of a group: one without rotations, and those whose rotations may map one leg
/// to another.
pub(in crate::import) fn candidates(robot: &Description, group: &Group) -> Vec<Placement> {
    let ends = |of_leg: fn(&[&Joint]) -> Option<Vec3<f64>>| -> Option<Vec<Vec3<f64>>> {
        let vector = |leg: &super::Leg| {
            let joints: Vec<&Joint> =
                leg.joints.iter().map(|&joint| &robot.joints[joint]).collect();
            of_leg(&joints)
        };
        group.legs.iter().map(vector).collect()
    };
    let feet = ends(|joints| Some(joints.first()?.frame_j.position));
    let tips = ends(|joints| Some(joints.last()?.frame_k.position));
    let directions = ends(|joints| Some(joints.first()?.frame_j.rotation.columns[2]));
    let vectors: Vec<Vec<Vec3<f64>>> = [feet, tips, directions].into_iter().flatten().collect();
    let mut axes = vec![Vec3::unit(2), Vec3::unit(0), Vec3::unit(1)];
    // The normal of the plane through the points of the first three legs.
    for points in &vectors {
        if let [first, second, third, ..] = points[..]
            && let Some(normal) = (second + -first).cross(third + -first).direction()
            && axes.iter().all(|axis| normal.cross(*axis).norm() > 1e-9)
        {
            axes.push(normal);
        }
    }
    let zero = Placement { axis: Vec3::unit(2), angles: vec![0.0; group.legs.len()] };
    let mut found = vec![zero];
    for axis in axes {
        for vectors in &vectors {
            let Some(angles) = angles(axis, vectors) else { continue };
            let relative = angles.iter().map(|angle| angle - angles[0]).collect();
            for angles in [relative, angles] {
                let angles: Vec<f64> = angles.into_iter().map(short).collect();
                let placement = Placement { axis, angles };
                let is_turned = placement.angles.iter().any(|angle| *angle != placement.angles[0]);
                if is_turned && !found.contains(&placement) {
                    found.push(placement);
                }
            }
        }
    }
    found
}

/// Angles of vectors about an axis, measured from a reference direction that depends only on the
/// axis; `None` if a vector is parallel to the axis.
fn angles(axis: Vec3<f64>, vectors: &[Vec3<f64>]) -> Option<Vec<f64>> {
    let x = match axis.to_array() {
        [0.0, 0.0, _] => Vec3::unit(0),
        [_, 0.0, 0.0] => Vec3::unit(1),
        [0.0, _, 0.0] => Vec3::unit(2),
        _ => axis.any_perpendicular(),
    };
    let y = axis.cross(x);
    let angle = |vector: &Vec3<f64>| {
        let [along, across] = [vector.dot(x), vector.dot(y)];
        (along.hypot(across) > 1e-6 * vector.norm().max(1e-3)).then(|| across.atan2(along))
    };
    vectors.iter().map(angle).collect()
}

/// Reduces an angle, rad, to the range from -180 to 180 degrees. If the angle has at most four
/// decimals in degrees, its rounding errors are removed.
fn short(angle: f64) -> f64 {
    let degrees = angle.to_degrees();
    let degrees = degrees - 360.0 * ((degrees + 180.0 - 1e-9) / 360.0).floor();
    let few = (degrees * 1e4).round() / 1e4;
    let degrees = if (few - degrees).abs() < 1e-11 { few } else { degrees };
    if degrees == 0.0 { 0.0 } else { degrees.to_radians() }
}

/// Returns the joints of each leg with the leg's rotation removed. Numbers that differ from those
/// of the first leg only by rounding are replaced by the numbers of the first leg.
pub(in crate::import) fn unrotated(
    robot: &Description,
    group: &Group,
    placement: &Placement,
) -> Vec<Vec<Joint>> {
    let mut legs: Vec<Vec<Joint>> = Vec::new();
    for (leg, angle) in group.legs.iter().zip(&placement.angles) {
        let turn = Pose { rotation: about(placement.axis, *angle), position: Vec3::zero() };
        let last = leg.joints.len() - 1;
        let joint = |(index, joint): (usize, &usize)| {
            let ends = [index == 0, index == last];
            let turns = ends.map(|is_end| if is_end { turn } else { Pose::identity() });
            unrotated_joint(&robot.joints[*joint], turns)
        };
        let mut own: Vec<Joint> = leg.joints.iter().enumerate().map(joint).collect();
        if let Some(first) = legs.first() {
            own.iter_mut().zip(first).for_each(|(own, first)| take_rounding(own, first));
        }
        legs.push(own);
    }
    legs
}

/// Expresses the frames of a joint relative to the rotated frames of its bodies, as a group of legs
/// in the model file requires. `from` and `to` are the rotations of the frames of the joint's
/// bodies; the identity for bodies within the leg.
fn unrotated_joint(joint: &Joint, [from, to]: [Pose<f64>; 2]) -> Joint {
    let mut own = joint.clone();
    let (mut j, mut k) = (joint.frame_j.rotation, joint.frame_k.rotation);
    if !has_axes(joint.kind) {
        // In the model file, frame J of a joint without axes is parallel to the frame of its body.
        k = k * j.transpose();
        own.start = own.start.map(|start| Pose {
            rotation: j * start.rotation * j.transpose(),
            position: j * start.position,
        });
        j = Mat3::identity();
    }
    let (from, to) = (from.inverse(), to.inverse());
    own.frame_j.position = snapped_point(from.rotation * joint.frame_j.position);
    own.frame_k.position = snapped_point(to.rotation * joint.frame_k.position);
    j = from.rotation * j;
    k = to.rotation * k;
    match joint.kind {
        JointType::Fixed => {
            k = k * j.transpose();
            j = Mat3::identity();
        }
        // Without a range, the frames matter only for the initial coordinates.
        JointType::Spherical if joint.range.is_none() => {
            let start = own.start.map_or(Mat3::identity(), |start| start.rotation);
            let rotation = snapped(j * start * k.transpose());
            if own.start.is_some() || rotation != Mat3::identity() {
                own.start = Some(Pose { rotation, position: Vec3::zero() });
            }
            (j, k) = (Mat3::identity(), Mat3::identity());
        }
        JointType::Spherical | JointType::Universal | JointType::Planar | JointType::Free => {}
        JointType::Revolute
        | JointType::Prismatic
        | JointType::Helical
        | JointType::Cylindrical => {
            // The x direction is the one that the reader of model files chooses by default.
            let again = frame(snapped(j).columns[2], None);
            k = k * j.transpose() * again;
            j = again;
        }
    }
    own.frame_j.rotation = snapped(j);
    // The model file contains the rotation between the two bodies.
    let turn = snapped(own.frame_j.rotation * k.transpose());
    own.frame_k.rotation = turn.transpose() * own.frame_j.rotation;
    own
}

/// Replaces entries of a rotation matrix by 0, 1 or -1 if they differ from these values only by
/// rounding.
fn snapped(rotation: Mat3<f64>) -> Mat3<f64> {
    let entry = |value: f64| {
        let whole = value.round();
        if (value - whole).abs() <= WHOLE { whole + 0.0 } else { value }
    };
    let column = |column: Vec3<f64>| Vec3::from(column.to_array().map(entry));
    let [x, y, z] = rotation.columns.map(column);
    Mat3::from_columns(x, y, z)
}

/// Sets coordinates of a point to zero if they are rounding errors compared with the distance of
/// the point from the origin.
fn snapped_point(point: Vec3<f64>) -> Vec3<f64> {
    let limit = WHOLE * point.norm();
    Vec3::from(point.to_array().map(|x| if x.abs() <= limit { 0.0 } else { x }))
}

/// Replaces the positions and rotations in the joint `own` by those of `first`, the corresponding
/// joint of the first leg, if they differ only by rounding.
fn take_rounding(own: &mut Joint, first: &Joint) {
    let near = |a: Vec3<f64>, b: Vec3<f64>| (a + -b).norm() <= SAME * b.norm();
    let alike =
        |a: Mat3<f64>, b: Mat3<f64>| a.columns.iter().zip(&b.columns).all(|(a, b)| near(*a, *b));
    for (own, first) in [(&mut own.frame_j, &first.frame_j), (&mut own.frame_k, &first.frame_k)] {
        if near(own.position, first.position) {
            own.position = first.position;
        }
        if alike(own.rotation, first.rotation) {
            own.rotation = first.rotation;
        }
    }
    if let (Some(own), Some(first)) = (&mut own.start, first.start)
        && alike(own.rotation, first.rotation)
    {
        own.rotation = first.rotation;
    }
}
