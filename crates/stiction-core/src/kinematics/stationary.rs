//! Computes steps away from stationary points of the error sum that are not minima. The error sum
//! is half the squared norm of the scaled errors of the position equations.
//!
//! On a line of symmetry between two solutions, for example with a stretched arm between its two
//! elbow configurations, the derivatives of the errors vanish along the direction that leads to
//! both solutions. Damped least squares stops at such a point although the loops are open.

use super::bodies::State;
use super::least_squares::PositionEquations;
use super::system::Kinematics;
use crate::linalg::Svd;
use nalgebra::{DMatrix, DVector, SymmetricEigen};

/// Step of the central second differences, in radians and characteristic lengths. The differences
/// have a round-off error of about 1e-8.
const DIFFERENCE: f64 = 1e-4;
/// A curvature of the error sum counts as negative only below minus this multiple of the error
/// norm, because smaller values may be due to round-off of the differences.
const FLAT: f64 = 1e-6;
/// A configuration counts as stationary if first-order steps can remove at most this fraction of
/// the error norm.
const STATIONARY: f64 = 0.5;
/// Smallest accepted norm of the second derivative of the scaled errors along a unit step, without
/// the part that first-order steps in other directions can remove. A step along a direction with a
/// smaller second derivative is rejected, because it would leave the loops as open as before.
const STRAIGHT: f64 = 1e-2;
/// Largest number of degrees of freedom for which steps away from stationary points are computed.
/// They need a dense decomposition.
const LARGE: usize = 150;
/// Maximum number of null-space directions of the Jacobian in which a negative curvature is
/// sought.
const DIRECTIONS: usize = 8;
/// Maximum length of a step, in radians and characteristic lengths.
const STRIDE: f64 = 0.25;
/// Largest number of iterations for the eigenvalues of a symmetric matrix with at most
/// [`DIRECTIONS`] rows.
const ITERATIONS: usize = 1000;

impl PositionEquations<'_> {
    /// Computes a scaled step from a stationary point of the error sum along its most negative
    /// curvature. Returns `None` at a minimum, where the errors can be reduced at first order, and
    /// for more than [`LARGE`] degrees of freedom.
    ///
    /// Let `e` be the errors, `J` their derivatives, and `h` their second derivative along a unit
    /// step `w`. The error sum has the curvature `|J w|^2 + e.h` along `w`. The errors that other
    /// directions cannot reduce are smallest after the step `s w` with `s^2 = -2 (|J w|^2 + e.h) /
    /// |h|^2`.
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
        // The limit is the square root of the error norm, because scaled second derivatives are of
        // order one.
        let rank = svd.rank_of_order_one(size.sqrt());
        let reducible = svd.u.columns(0, rank);
        // A configuration is not stationary if steps can reduce the errors at first order.
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
        // A motion that leaves the loop errors nearly unchanged does not lead to a solution.
        let opening = rest.norm();
        if opening <= STRAIGHT || opening.is_nan() {
            return None;
        }
        let length = (-2.0 * amount / rest.norm_squared()).sqrt().min(STRIDE);
        length.is_finite().then(|| direction * length)
    }
}
