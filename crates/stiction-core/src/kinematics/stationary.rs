//! Steps off stationary points of the error sum that are not its minima.
//!
//! On a line of symmetry between two solutions, such as a stretched position between two elbows, the
//! derivatives of the errors vanish along the direction that leads to both: damped least squares stops
//! there although the loops are open.

use super::bodies::State;
use super::least_squares::PositionEquations;
use super::system::Kinematics;
use crate::linalg::Svd;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Step of the central second differences, rad and characteristic lengths; their round-off is about
/// 1e-8.
const DIFFERENCE: f64 = 1e-4;
/// Curvatures of the error sum up to this multiple of the error norm may be round-off of the
/// differences.
const FLAT: f64 = 1e-6;
/// A position counts as stationary unless first-order steps can remove more than this fraction of
/// the error norm.
const STATIONARY: f64 = 0.5;
/// A step is rejected if the second derivative of the errors along a unit step, in characteristic
/// lengths and without the part that other directions can reduce, is at most this value. Such a
/// step leaves the loops as open as before.
const STRAIGHT: f64 = 1e-2;
/// Steps off stationary points need a dense decomposition, so they are not computed for more
/// degrees of freedom than this.
const LARGE: usize = 150;
/// Largest number of directions with small derivatives.
const DIRECTIONS: usize = 8;
/// Length of the longest step, rad and characteristic lengths.
const STRIDE: f64 = 0.25;
/// Largest number of iterations for the eigenvalues of a symmetric matrix of at most [`DIRECTIONS`]
/// rows.
const ITERATIONS: usize = 1000;

impl PositionEquations<'_> {
    /// Scaled step from a stationary point of the error sum along its most negative curvature; `None` at a
    /// minimum. With the errors `e`, their derivatives `J` and their second derivative `h` along a unit step
    /// `w`, the error sum along the step has the curvature `|J w|^2 + e.h`, and the errors that other
    /// directions cannot reduce are smallest after the step `s w` with `s^2 = -2 (|J w|^2 + e.h) / |h|^2`.
    pub(super) fn step_off(
        &self,
        kinematics: &mut Kinematics<f64>,
        state: &State<f64>,
    ) -> Option<DVector<f64>> {
        let errors = self.errors(kinematics, state);
        let jacobian = self.jacobian(kinematics).to_dense();
        let size = errors.norm();
        if jacobian.ncols() > LARGE || !(size > 0.0 && size.is_finite()) {
            return None;
        }
        let svd = Svd::new(&jacobian);
        // Second derivatives are of order one.
        let rank = svd.rank_of_order_one(size.sqrt());
        let reducible = svd.u.columns(0, rank);
        // A position is not stationary if steps can reduce the errors to first order.
        if reducible.tr_mul(&errors).norm() > STATIONARY * size {
            return None;
        }
        let mut open = svd.null_space(rank);
        let first = open.len().saturating_sub(DIRECTIONS);
        let open = open.split_off(first);
        let second = |kinematics: &mut Kinematics<f64>, along: &DVector<f64>| {
            let mut sum = &errors * -2.0;
            for step in [along * DIFFERENCE, along * -DIFFERENCE] {
                let mut moved = state.clone();
                moved.advance(self.topology(), &self.unscaled(&step));
                sum += self.errors(kinematics, &moved);
            }
            sum / DIFFERENCE.powi(2)
        };
        let count = open.len();
        let slopes: Vec<DVector<f64>> = open.iter().map(|v| &jacobian * v).collect();
        let pure: Vec<f64> = open.iter().map(|v| errors.dot(&second(kinematics, v))).collect();
        let mut curvature = DMatrix::zeros(count, count);
        for i in 0..count {
            for j in 0..=i {
                let bend = match i == j {
                    true => pure[i],
                    false => {
                        let both = errors.dot(&second(kinematics, &(&open[i] + &open[j])));
                        0.5 * (both - pure[i] - pure[j])
                    }
                };
                curvature[(i, j)] = bend + slopes[i].dot(&slopes[j]);
                curvature[(j, i)] = curvature[(i, j)];
            }
        }
        if count == 0 || !curvature.iter().all(|x| x.is_finite()) {
            return None;
        }
        let eigen = SymmetricEigen::try_new(curvature, f64::EPSILON, ITERATIONS)?;
        let least = eigen.eigenvalues.imin();
        let amount = eigen.eigenvalues[least];
        if amount > -FLAT * size {
            return None;
        }
        let direction = DMatrix::from_columns(&open) * eigen.eigenvectors.column(least);
        let bend = second(kinematics, &direction);
        let rest = &bend - reducible * reducible.tr_mul(&bend);
        // A motion that leaves the loop errors nearly unchanged leads to no solution.
        let opening = rest.norm();
        if opening <= STRAIGHT || opening.is_nan() {
            return None;
        }
        let length = (-2.0 * amount / rest.norm_squared()).sqrt().min(STRIDE);
        length.is_finite().then(|| direction * length)
    }
}
