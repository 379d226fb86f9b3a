//! Bounds on the singularity indices: a test whether an index exceeds a value, and bounds on the
//! change of the indices between two configurations.

use super::super::distance::Distances;
use super::{SMALL, SingularityDistances, SingularityIndex};
use crate::kinematics::Bodies;
use crate::linalg::{BLOCK, Part};
use crate::parameters::Parameters;

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
                self.multiply_between_joints(by);
                &mut self.by_joints
            }
        };
        matrix.shift(by);
        matrix.factor()
    }

    /// Computes upper bounds on the magnitudes of the changes of both indices from the
    /// configuration of the preceding call (of any method) to that of `bodies`. By Weyl's
    /// inequality, a singular value changes by at most the norm of the change of the matrix. This
    /// norm is at most the geometric mean of two numbers: the largest sum of magnitudes in a
    /// column, and the largest such sum in a row.
    pub fn travel(&mut self, parameters: &Parameters<f64>, bodies: &Bodies<f64>) -> Distances {
        std::mem::swap(&mut self.on, &mut self.passed);
        self.place(parameters, bodies);
        let Self { row_sums, .. } = self;
        row_sums.fill([[0.0; BLOCK]; 2]);
        // Largest sums of magnitudes in a column: first over the columns of constraints, then over
        // those of actuators.
        let mut columns = [0.0_f64; 2];
        for ((joint, on), passed) in self.joints.iter().zip(&self.on).zip(&self.passed) {
            let mut sums = [0.0; BLOCK];
            for end in 0..2 {
                let Some(body) = joint.ends[end].checked_sub(1) else { continue };
                let mut rows = [[0.0; BLOCK]; 2];
                for unknown in 0..joint.unknowns {
                    let kind = usize::from(unknown >= joint.constraints);
                    let (now, before) = (&on[end][unknown], &passed[end][unknown]);
                    let change: Part = core::array::from_fn(|i| (now[i] - before[i]).abs());
                    (0..BLOCK).for_each(|i| rows[kind][i] += change[i]);
                    sums[unknown] += change.iter().sum::<f64>();
                }
                for (kind, rows) in rows.iter().enumerate() {
                    (0..BLOCK).for_each(|i| row_sums[body][kind][i] += rows[i]);
                }
            }
            let (constraints, others) = sums.split_at(joint.constraints);
            columns[0] = constraints.iter().fold(columns[0], |most, sum| most.max(*sum));
            columns[1] = others.iter().fold(columns[1], |most, sum| most.max(*sum));
        }
        let mut rows = [0.0_f64; 2];
        for [constraints, drives] in row_sums {
            for i in 0..BLOCK {
                rows[0] = rows[0].max(constraints[i]);
                rows[1] = rows[1].max(constraints[i] + drives[i]);
            }
        }
        Distances {
            constraint: (columns[0] * rows[0]).sqrt(),
            actuation: (columns[0].max(columns[1]) * rows[1]).sqrt(),
        }
    }
}
