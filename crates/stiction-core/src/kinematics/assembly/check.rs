//! Checks of home poses, coordinates and targets before assembly.

use crate::kinematics::coordinate::{Coordinate, Target};
use crate::kinematics::error::AssemblyError;
use crate::mechanism::{BodyId, Mechanism};
use crate::spatial::Pose;

/// Panics if a given body, joint or degree of freedom does not exist. The indices come from the
/// calling code, not from user input.
pub(super) fn check_existence(
    mechanism: &Mechanism,
    initial_poses: &[(BodyId, Pose<f64>)],
    coordinates: &[Coordinate],
) {
    let check_body = |body: BodyId| {
        let count = mechanism.bodies().len();
        assert!(
            body.0 < count,
            "{body:?} does not exist: the mechanism has {count} bodies, including the ground"
        );
    };
    initial_poses.iter().for_each(|(body, _)| check_body(*body));
    for coordinate in coordinates {
        match *coordinate {
            Coordinate::Position { body, axis: index }
            | Coordinate::Angle { body, index, .. }
            | Coordinate::RotationVector { body, axis: index } => {
                check_body(body);
                assert!(index < 3, "{coordinate:?}: the index must be 0, 1 or 2");
            }
            Coordinate::Joint { joint, dof } => {
                let joints = mechanism.joints();
                let count = joints.len();
                assert!(
                    joint.0 < count,
                    "{joint:?} does not exist: the mechanism has {count} joints"
                );
                let joint_type = joints[joint.0].joint_type;
                assert!(
                    joint_type.has_scalar_coordinates() && dof < joint_type.dofs().len(),
                    "joint `{}` has no scalar coordinate {dof}",
                    joints[joint.0].name
                );
            }
        }
    }
}

/// Largest accepted magnitude of a number, in SI units; squares of larger numbers might overflow.
const LARGEST: f64 = 1e30;

fn check_number(coordinates: &[Coordinate], targets: &[Target<f64>]) {
    let (found, expected) = (targets.len(), coordinates.len());
    assert!(
        found == expected,
        "expected {expected} targets, one for each prescribed coordinate, but found {found}"
    );
}

pub(super) fn check_targets(
    body_names: &[String],
    coordinates: &[Coordinate],
    targets: &[Target<f64>],
) -> Result<(), AssemblyError> {
    check_number(coordinates, targets);
    let fits =
        |t: &Target<f64>| [t.value, t.rate, t.acceleration].iter().all(|x| x.abs() <= LARGEST);
    match targets.iter().position(|target| !fits(target)) {
        Some(index) => Err(AssemblyError::NotFinite { index }),
        None => check_angle_ranges(body_names, coordinates, targets),
    }
}

pub(super) fn check_angle_ranges(
    body_names: &[String],
    coordinates: &[Coordinate],
    targets: &[Target<f64>],
) -> Result<(), AssemblyError> {
    for (coordinate, target) in coordinates.iter().zip(targets) {
        let Coordinate::Angle { body, order, index: 1 } = coordinate else { continue };
        let quarter = core::f64::consts::FRAC_PI_2;
        let (middle, range) = if order.is_tait_bryan() {
            (0.0, "between -90 and 90 deg")
        } else {
            (quarter, "between 0 and 180 deg")
        };
        if (target.value - middle).abs() >= quarter * (1.0 - 1e-9) {
            return Err(AssemblyError::AngleRange {
                body: body_names[body.0].clone(),
                degrees: target.value.to_degrees(),
                range,
            });
        }
    }
    Ok(())
}
