//! Bounds on the singularity indices: a test whether an index exceeds a value, and bounds on the
//! change of the indices between two configurations.

use super::super::distance::Distances;
use super::{SMALL, SingularityDistances, SingularityIndex};
use crate::kinematics::Bodies;
use crate::linalg::{Part, dot};
use crate::parameters::Parameters;
use core::ops::Range;

/// Round-off of a Gram matrix and of its decomposition, relative to the square of the largest entry
/// of the balance matrix, with a margin.
const ROUNDED: f64 = 1e-11;

impl SingularityDistances {
    /// Returns `true` if the index `index` certainly exceeds `value` at the configuration of
    /// `bodies`. The index exceeds the value if the Gram matrix, less the square of the value times
    /// the unit matrix, has a Cholesky decomposition. The test costs less than computing the index.
    /// Returns `false` if round-off does not permit a decision.
    pub fn exceeds(
        &mut self,
        index: SingularityIndex,
        value: f64,
        (parameters, bodies): (&Parameters<f64>, &Bodies<f64>),
    ) -> bool {
        self.place(parameters, bodies);
        let largest = self.largest();
        if value.is_nan() || value <= SMALL * largest {
            return false;
        }
        let by = value * value + ROUNDED * largest * largest;
        let matrix = match index {
            SingularityIndex::Actuation => {
                self.multiply_between_bodies();
                &mut self.by_bodies
            }
            SingularityIndex::Constraint => {
                self.multiply_between_joints();
                &mut self.by_joints
            }
        };
        matrix.shift(by);
        matrix.factor()
    }

    /// Computes upper bounds on the magnitudes of the changes of both indices from the
    /// configuration of the preceding call (of any method) to that of `bodies`. By Weyl's
    /// inequality, a singular value changes by at most the norm of the change of the matrix. This
    /// norm is at most the geometric mean of two numbers: the largest sum of the Frobenius norms of
    /// the blocks of a joint, and the largest such sum for a body.
    pub fn travel(&mut self, parameters: &Parameters<f64>, bodies: &Bodies<f64>) -> Distances {
        std::mem::swap(&mut self.on, &mut self.passed);
        self.place(parameters, bodies);
        let Self { body_sums, .. } = self;
        body_sums.fill([0.0; 2]);
        // Both arrays contain a sum for the constraints alone, then one for all unknowns.
        let mut largest = [0.0_f64; 2];
        for ((joint, on), passed) in self.joints.iter().zip(&self.on).zip(&self.passed) {
            let mut joint_sums = [0.0; 2];
            for end in 0..2 {
                let Some(body) = joint.ends[end].checked_sub(1) else { continue };
                let square = |unknowns: Range<usize>| {
                    let pairs = on[end][unknowns.clone()].iter().zip(&passed[end][unknowns]);
                    pairs.fold(0.0, |sum, (now, before)| {
                        let change: Part = core::array::from_fn(|i| now[i] - before[i]);
                        sum + dot(&change, &change)
                    })
                };
                let constraints = square(0..joint.constraints);
                let all = constraints + square(joint.constraints..joint.unknowns);
                for (k, norm) in [constraints.sqrt(), all.sqrt()].into_iter().enumerate() {
                    joint_sums[k] += norm;
                    body_sums[body][k] += norm;
                }
            }
            largest = core::array::from_fn(|k| largest[k].max(joint_sums[k]));
        }
        let of_bodies = |k: usize| body_sums.iter().fold(0.0_f64, |most, sums| most.max(sums[k]));
        Distances {
            constraint: (largest[0] * of_bodies(0)).sqrt(),
            actuation: (largest[1] * of_bodies(1)).sqrt(),
        }
    }
}
