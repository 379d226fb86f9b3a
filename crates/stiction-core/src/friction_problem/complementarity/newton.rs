//! Newton's method on the nonsmooth equations of the complementarity problem.

use super::SETTLED;
use super::problem::Complementarity;
use crate::friction_problem::small_system::{pack_after, solve_if_regular};
use crate::linalg::RowSpace;

/// Once the residual no longer decreases, a solution with a relative residual up to this value is
/// accepted, because only round-off remains.
pub(super) const STAGNATED: f64 = 1e-9;
/// Largest number of Newton steps.
const STEPS: usize = 40;
/// Largest number of step lengths tried in one line search: the full Newton step and its successive
/// halves, until the residual decreases.
const HALVINGS: usize = 10;
/// A row of the Newton matrix counts as dependent on the others if its component orthogonal to them
/// is at most this fraction of the largest row norm (or of 1, if that is greater).
const DEPENDENT: f64 = 1e-11;
/// Pivot, relative to the largest entry of the Newton matrix, below which its elimination is not
/// accurate enough.
const REGULAR: f64 = 1e-8;

impl Complementarity<'_> {
    /// Runs Newton's method from the unknowns `x` with `part` times the friction coefficients; `x`
    /// becomes the last iterate. Returns `true` if the method converges to a solution.
    pub(super) fn newton(&self, x: &mut Vec<f64>, part: f64) -> bool {
        let n = self.count();
        let (mut matrix, mut blocks, mut step) = (Vec::new(), Vec::new(), Vec::new());
        let mut space = RowSpace::default();
        let mut now = self.residual(x, part, Some(&mut matrix));
        for _ in 0..STEPS {
            if now.relative() <= SETTLED {
                return true;
            }
            if !now.relative().is_finite() || matrix.iter().any(|x| !x.is_finite()) {
                return false;
            }
            blocks.clear();
            matrix.chunks_exact(n).for_each(|row| pack_after(row, &mut blocks));
            step.clone_from(&now.values);
            if solve_if_regular(&mut blocks, &mut step, REGULAR).is_none() {
                space.decompose(&matrix, n, n, DEPENDENT);
                space.shortest_into(&now.values, &mut step);
            }
            let mut better = None;
            let mut factor = 1.0;
            for _ in 0..HALVINGS {
                let trial: Vec<f64> = x.iter().zip(&step).map(|(x, s)| x - factor * s).collect();
                let next = self.residual(&trial, part, None);
                if next.square() < (1.0 - 0.1 * factor) * now.square() {
                    better = Some(trial);
                    break;
                }
                factor *= 0.5;
            }
            let Some(trial) = better else { return now.relative() <= STAGNATED };
            *x = trial;
            now = self.residual(x, part, Some(&mut matrix));
        }
        now.relative() <= STAGNATED
    }
}
