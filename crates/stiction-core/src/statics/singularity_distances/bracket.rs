//! Smallest eigenvalue between a lower and an upper bound along smooth motions: a Rayleigh quotient
//! is above the eigenvalue, and a shift with a Cholesky decomposition is below it.

use super::inverse_iteration::length_squared;
use super::{Content, SingularityDistances, SingularityIndex};
use crate::linalg::{BLOCK, Part, dot};

/// Relative amount by which round-off may raise the quotient of the solution above that of the
/// extrapolated vector.
const RAISED: f64 = 1e-13;

impl SingularityDistances {
    /// Computes an index at the configuration set by [`Self::place`] with a single solution of the
    /// shifted equations. `largest` is the largest entry of the scaled balance matrix. Returns
    /// `None` if the motion is not so smooth that the extrapolated eigenvector suffices.
    pub(super) fn smallest_in_bracket(
        &mut self,
        index: SingularityIndex,
        largest: f64,
    ) -> Option<f64> {
        let mut vector = core::mem::take(&mut self.vector);
        let found = self.enclose(index, self.round_off(largest), &mut vector);
        self.vector = vector;
        found
    }

    /// Computes the index as [`Self::smallest_in_bracket`], with `vector` as the buffer of the
    /// eigenvector. `rounded` is the round-off of eigenvalues.
    fn enclose(
        &mut self,
        index: SingularityIndex,
        rounded: f64,
        vector: &mut Vec<f64>,
    ) -> Option<f64> {
        if !self.prediction(index).extrapolate(rounded, vector) {
            return None;
        }
        let vector: &mut [Part] = vector.as_chunks_mut().0;
        let quotient = self.square_of(index, vector);
        let below = self.prediction(index).bracket(quotient, rounded)?;
        let matrix = self.gram_matrix(index);
        matrix.shift(below);
        // The decomposition exists only if all eigenvalues are above the shift.
        if !matrix.factor() {
            return None;
        }
        matrix.solve(vector);
        let square = self.square_of(index, vector);
        // A quotient above that of the extrapolated vector, or NaN, indicates a failure.
        let is_below = square <= quotient * (1.0 + RAISED);
        if is_below {
            self.prediction(index).add(square, vector);
        }
        is_below.then(|| square.sqrt())
    }

    /// Returns the Rayleigh quotient of `vector` with the Gram matrix of an index.
    pub(super) fn square_of(&mut self, index: SingularityIndex, vector: &[Part]) -> f64 {
        match index {
            SingularityIndex::Actuation => square_of_motion(&self.joints, &self.on, vector),
            SingularityIndex::Constraint => {
                square_of_stress(&self.joints, &self.on, (vector, &mut self.carried))
            }
        }
    }
}

/// Returns the Rayleigh quotient of twists of the bodies: the sum of the squared powers of all unit
/// wrenches `on` the bodies, divided by the square of the twists. The balance matrix itself is used,
/// because the Gram matrix has fewer accurate digits.
fn square_of_motion(joints: &[Content], on: &[[[Part; BLOCK]; 2]], motion: &[Part]) -> f64 {
    let mut square = 0.0;
    for (joint, on) in joints.iter().zip(on) {
        let [a, b] = joint.ends.map(|end| end.checked_sub(1).map(|body| &motion[body]));
        let power = |twist: Option<&Part>, wrench: &Part| twist.map_or(0.0, |v| dot(wrench, v));
        for (on_a, on_b) in on[0].iter().zip(&on[1]).take(joint.unknowns) {
            let amount = power(a, on_a) + power(b, on_b);
            square += amount * amount;
        }
    }
    square / length_squared(motion)
}

/// Returns the Rayleigh quotient of multipliers `stress` of the constraints: the square of the
/// resultants on all bodies, divided by the square of the multipliers. The resultants are written to
/// `carried`.
fn square_of_stress(
    joints: &[Content],
    on: &[[[Part; BLOCK]; 2]],
    (stress, carried): (&[Part], &mut [Part]),
) -> f64 {
    carried.fill([0.0; BLOCK]);
    for ((joint, on), stress) in joints.iter().zip(on).zip(stress) {
        for (end, on) in joint.ends.iter().zip(on) {
            let Some(body) = end.checked_sub(1) else { continue };
            let mut sum = carried[body];
            for (column, amount) in on[..joint.constraints].iter().zip(stress) {
                (0..BLOCK).for_each(|i| sum[i] += column[i] * amount);
            }
            carried[body] = sum;
        }
    }
    length_squared(carried) / length_squared(stress)
}
