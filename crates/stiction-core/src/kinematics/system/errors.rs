//! Errors of loop closure and deviations from prescribed coordinates.

use super::Kinematics;
use crate::kinematics::bodies::Bodies;
use crate::kinematics::motion_constraints::MotionConstraints;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::topology::Topology;

impl<T: Scalar> Kinematics<T> {
    /// Returns the largest error over all cut joints and gearings, m. Angular errors are multiplied
    /// by `length` (m).
    pub(crate) fn closure_error(&self, motion_constraints: &MotionConstraints, length: f64) -> f64 {
        let errors = self.errors[..self.closures].iter().zip(&motion_constraints.rows);
        largest_in_metres(errors.map(|(error, row)| (error.largest(), row.is_angle)), length)
    }

    /// Returns the largest magnitude of the errors of loop closure and of the deviations from
    /// prescribed coordinates, m or rad.
    pub fn largest_error(&self) -> f64 {
        largest(&self.errors)
    }

    /// Returns the largest error of any row, with lengths divided by `length` and angles in rad.
    /// NaN if any error is NaN.
    pub(crate) fn scaled_error(&self, constraints: &MotionConstraints, length: f64) -> f64 {
        let rows = self.errors.iter().zip(&constraints.rows);
        let errors = rows.map(|(error, row)| {
            let size = error.largest();
            if row.is_angle { size } else { size / length }
        });
        errors.fold(0.0, |max, e| if e > max || e.is_nan() { e } else { max })
    }

    /// Yields the errors of all rows in row order, with lengths divided by `length` and angles in
    /// rad.
    pub fn scaled_errors<'a>(
        &'a self,
        constraints: &'a MotionConstraints,
        length: f64,
    ) -> impl Iterator<Item = T> + 'a {
        let scales = constraints.row_scales(length);
        self.errors.iter().zip(scales).map(|(error, scale)| *error * T::from_f64(scale))
    }

    /// Returns the errors of all rows in row order, m or rad.
    pub(in crate::kinematics) fn errors(&self) -> &[T] {
        &self.errors
    }
}

/// Returns the largest loop-closure error, m: over all cut joints at the given body poses, and over
/// all gearings at the given coordinates of the spanning tree. Angular errors are multiplied by the
/// characteristic length.
pub(crate) fn closure_error(
    topology: &Topology,
    parameters: &Parameters<f64>,
    (bodies, coordinates): (&Bodies<f64>, &[f64]),
) -> f64 {
    let errors = topology.cuts.iter().flat_map(|cut| {
        let joint_type = topology.joint_types[cut.joint];
        let relative = bodies.frame_j[cut.joint].inverse() * bodies.frame_k[cut.joint];
        let (misfit, _) = joint_type.misfit(relative, parameters.pitch[cut.joint]);
        let constraints = joint_type.constraints().iter();
        misfit.into_iter().zip(constraints).map(|(error, row)| (error.largest(), row.is_moment()))
    });
    let gearings = topology
        .gearings
        .iter()
        .map(|gearing| (gearing.error(parameters, coordinates).largest(), !gearing.is_length));
    largest_in_metres(errors.chain(gearings), parameters.length)
}

/// Returns the largest error, m. Each item is the magnitude of an error and a flag that is `true`
/// for an angle; angles are multiplied by `length` (m).
fn largest_in_metres(errors: impl Iterator<Item = (f64, bool)>, length: f64) -> f64 {
    let in_metres = errors.map(|(size, is_angle)| size * if is_angle { length } else { 1.0 });
    // Propagate NaN.
    in_metres.fold(0.0, |max, e| if e > max || e.is_nan() { e } else { max })
}

fn largest<T: Scalar>(values: &[T]) -> f64 {
    let mut worst = 0.0;
    for value in values {
        let size = value.largest();
        // Propagate NaN.
        if size > worst || size.is_nan() {
            worst = size;
        }
        if worst.is_nan() {
            break;
        }
    }
    worst
}
