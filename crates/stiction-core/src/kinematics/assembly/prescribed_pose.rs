//! Prescribed coordinates of one body as components of its pose.

use super::super::coordinate::{AngleOrder, Coordinate, Target};
use super::super::measure::intrinsic_angles;
use super::super::rotation_vector::RotationVector;
use crate::spatial::{Mat3, Pose, Vec3};

/// Prescribed coordinates of one body.
#[derive(Clone, Default)]
pub(super) struct PrescribedPose {
    position: [Option<f64>; 3],
    angles: Vec<(AngleOrder, usize, f64)>,
    rotation_vector: [Option<f64>; 3],
}

impl PrescribedPose {
    /// Collects the prescribed coordinates of each body; `bodies` is the number of bodies.
    pub(super) fn of_bodies(
        bodies: usize,
        coordinates: &[Coordinate],
        targets: &[Target<f64>],
    ) -> Vec<Self> {
        let mut poses = vec![Self::default(); bodies];
        for (coordinate, target) in coordinates.iter().zip(targets) {
            match *coordinate {
                Coordinate::Position { body, axis } => {
                    poses[body.0].position[axis] = Some(target.value);
                }
                Coordinate::Angle { body, order, index } => {
                    poses[body.0].angles.push((order, index, target.value));
                }
                Coordinate::RotationVector { body, axis } => {
                    poses[body.0].rotation_vector[axis] = Some(target.value);
                }
                Coordinate::Joint { .. } => {}
            }
        }
        poses
    }

    /// Returns `true` if all six components are prescribed.
    pub(super) fn is_whole(&self) -> bool {
        let turned = self.rotation_vector.iter().all(Option::is_some)
            || (0..3).all(|index| {
                self.angles.iter().any(|(order, k, _)| *order == self.angles[0].0 && *k == index)
            });
        turned && self.position.iter().all(Option::is_some)
    }

    /// Returns `pose` (in the ground's frame) with the prescribed components inserted.
    pub(super) fn applied_to(&self, pose: Pose<f64>) -> Pose<f64> {
        let mut position = pose.position.to_array();
        for (x, prescribed) in position.iter_mut().zip(self.position) {
            *x = prescribed.unwrap_or(*x);
        }
        let mut rotation = pose.rotation;
        if let Some((order, ..)) = self.angles.first().copied() {
            let mut angles = intrinsic_angles(rotation, order);
            for (_, index, value) in self.angles.iter().filter(|(other, ..)| *other == order) {
                angles[*index] = *value;
            }
            let turn = |k: usize| Mat3::about_axis(order.axes()[k], angles[k].sin_cos());
            rotation = turn(0) * turn(1) * turn(2);
        }
        if self.rotation_vector.iter().any(Option::is_some) {
            let mut vector = RotationVector::of(rotation).value.to_array();
            for (x, prescribed) in vector.iter_mut().zip(self.rotation_vector) {
                *x = prescribed.unwrap_or(*x);
            }
            let vector = Vec3::from(vector);
            if vector.norm() > 0.0 {
                rotation = Mat3::rotation(vector, vector.norm());
            }
        }
        Pose { position: Vec3::from(position), rotation }
    }
}
