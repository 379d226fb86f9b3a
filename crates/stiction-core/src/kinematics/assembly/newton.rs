//! Newton's method for closed loops and prescribed values.

use super::{Assembly, CLOSED, CLOSED_AT_WORST};
use crate::parameters::Parameters;

/// Closure error below which Newton's method converges quadratically.
const NEAR: f64 = 1e-7;
/// If the closure error before a Newton step is below this value, a second step with the same
/// matrix reduces the error to about the product of the errors before the two steps.
const CLOSE: f64 = 1e-3;
/// Errors below this fraction of the closure tolerance are comparable to round-off.
const ROUNDED: f64 = 0.1;
/// Maximum number of Newton steps before the search by damped least squares begins.
const NEWTON_STEPS: usize = 12;

impl Assembly {
    /// Runs Newton's method with the current plan and computes the poses of the bodies. Returns
    /// `false` if some loops remain open.
    pub(super) fn newton(&mut self, parameters: &Parameters<f64>) -> bool {
        let closed = CLOSED.max(self.state.round_off());
        let mut error = f64::INFINITY;
        let mut is_placed = false;
        // A program computes rates without factors; those of an earlier configuration then remain.
        let has_factors = self.kinematics.is_factored() || self.program.is_some();
        if self.extrapolation.is_active() && self.is_determined() && has_factors {
            // The matrix of the previous configuration is almost that of the present one.
            error = self.place(parameters);
            if error < closed {
                return true;
            }
            is_placed = true;
            if self.extrapolation.suffices(error, ROUNDED * closed) {
                self.sound.clone_from(&self.state);
                self.kinematics.approach_again(&self.model, &mut self.state);
                let before = std::mem::replace(&mut error, self.place(parameters));
                self.extrapolation.add(before, error, ROUNDED * closed);
                if error < closed {
                    return true;
                }
                if !error.is_finite() {
                    self.state.clone_from(&self.sound);
                    is_placed = false;
                }
            }
        }
        for _ in 0..NEWTON_STEPS {
            self.sound.clone_from(&self.state);
            if !std::mem::take(&mut is_placed) {
                self.place(parameters);
            }
            self.kinematics.approach_here(&self.model, parameters, &mut self.state);
            if !self.state.coordinates.iter().all(|q| q.is_finite()) {
                // Singular matrix: restore the last finite state, from which the next method
                // starts.
                self.state.clone_from(&self.sound);
                return false;
            }
            // The errors are those of the poses before the present step.
            let before = self.scaled_error();
            if before < CLOSE {
                error = self.place(parameters);
                // Two more steps with the matrix of this step reduce the error to round-off.
                let again = if before < NEAR { 0 } else { 2 };
                for _ in 0..again {
                    if error < ROUNDED * closed {
                        return true;
                    }
                    self.kinematics.approach_again(&self.model, &mut self.state);
                    error = self.place(parameters);
                }
                if error < closed {
                    return true;
                }
            }
        }
        error < CLOSED_AT_WORST.max(closed)
    }
}
