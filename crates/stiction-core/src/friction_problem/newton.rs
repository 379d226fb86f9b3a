//! Newton's method on the normal loads.

use super::load_problem::LoadProblem;
use super::normal_load::Configuration;
use super::small_system::{Four, blocks_of, pack, solve_in_place};
use crate::linalg::largest;
use crate::scalar::Scalar;
use crate::spatial::Twist;

/// Largest number of Newton steps from one initial guess.
pub(super) const STEPS: usize = 30;
/// The iteration has converged if the relative change of the loads in the last step is at most this
/// value. The remaining error is about the square of this change, so it is at round-off even if the
/// system is close to singular.
const SETTLED: f64 = 1e-9;
/// Once the changes no longer decrease, loads with a relative change of at most this value are
/// accepted, because only round-off remains.
const STAGNATED: f64 = 1e-10;
/// Normal loads above this multiple of the largest starting load count as unbounded.
pub(crate) const UNBOUNDED: f64 = 1e9;

/// Buffers of Newton's method.
#[derive(Clone, Debug, Default)]
pub(super) struct NewtonWorkspace {
    blocks: Vec<Four>,
    /// Residual of the load equations, N, before the linear solve; afterwards the change of the
    /// loads in the Newton step, N.
    change: Vec<f64>,
    /// Gradients of the loads with respect to the joint wrenches.
    gradients: Vec<Twist<f64>>,
    matrix: Vec<Four>,
}

/// Criteria for accepting normal loads as a solution.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Accepted {
    /// Largest accepted load, N.
    pub(crate) most: f64,
    /// Loads with a residual, relative to the largest load, below this value are accepted without a
    /// further step. Zero unless the solution is known to be unique, because only then does a small
    /// residual imply a small error.
    pub(crate) residual: f64,
}

impl Accepted {
    /// Accepts loads below `most`, N, once the change in a step is at round-off.
    pub(crate) fn below(most: f64) -> Self {
        Self { most, residual: 0.0 }
    }
}

impl LoadProblem {
    /// Solves by Newton's method with `part` times the friction coefficients, starting from
    /// `loads`, N, which become the solution. Returns `Some(true)` if the determinant of the Newton
    /// matrix is positive, as on the branch of the frictionless solution and wherever the solution
    /// is unique. Returns `None` if no solution is found or a load exceeds the limit in `accepted`.
    pub(super) fn newton(
        &self,
        at: Configuration<'_>,
        loads: &mut [f64],
        (part, accepted): (f64, Accepted),
        workspace: &mut NewtonWorkspace,
    ) -> Option<bool> {
        let width = blocks_of(loads.len());
        let NewtonWorkspace { blocks, change, gradients, matrix } = workspace;
        let influenced = part * self.sense();
        let mut before = f64::INFINITY;
        for _ in 0..STEPS {
            pack(loads, blocks);
            change.clear();
            gradients.clear();
            for (k, unknown) in self.unknowns.iter().enumerate() {
                let wrench = unknown.base + self.influence.apply(k, blocks) * influenced;
                let state = at.normal_load(unknown.interface, wrench, unknown.own_at(part));
                change.push(loads[k] - state.value);
                gradients.push(state.gradient);
            }
            if accepted.residual > 0.0 && largest(change) <= accepted.residual * largest(loads) {
                // Accept the computed normal loads, `loads - change`, which are closer to the
                // solution.
                loads.iter_mut().zip(&*change).for_each(|(load, change)| *load -= change);
                return Some(true);
            }
            matrix.resize(width * loads.len(), Four::zero());
            let rows = matrix.chunks_exact_mut(width).zip(&*gradients);
            for (k, (row, Twist { angular, linear })) in rows.enumerate() {
                let slopes = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z];
                self.influence.combine(k, slopes.map(|slope| -influenced * slope), row);
                row[k / 4].0[k % 4] += 1.0;
            }
            let positive = solve_in_place(matrix, change)?;
            loads.iter_mut().zip(&*change).for_each(|(load, change)| *load -= change);
            let (size, largest) = (largest(change), largest(loads));
            if !(size.is_finite() && largest < accepted.most) {
                return None;
            }
            if is_settled(size, before, largest) {
                return Some(positive);
            }
            before = size;
        }
        None
    }

    /// Solves the linear system with the transposed Newton matrix at the given loads and the
    /// right-hand side `right`, which becomes the solution. Also writes the gradients of the loads
    /// with respect to the joint wrenches to `gradients`. Returns `None` if the matrix is singular.
    pub(super) fn transposed(
        &self,
        at: Configuration<'_>,
        loads: &[f64],
        right: &mut [f64],
        gradients: &mut Vec<Twist<f64>>,
        workspace: &mut NewtonWorkspace,
    ) -> Option<()> {
        let width = blocks_of(loads.len());
        let NewtonWorkspace { blocks, change, matrix, .. } = workspace;
        pack(loads, blocks);
        gradients.clear();
        matrix.clear();
        matrix.resize(width * loads.len(), Four::zero());
        for (k, unknown) in self.unknowns.iter().enumerate() {
            let wrench = unknown.base + self.influence.apply(k, blocks) * self.sense();
            let Twist { angular, linear } =
                at.normal_load(unknown.interface, wrench, unknown.own_at(1.0)).gradient;
            gradients.push(Twist { angular, linear });
            let slopes = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z];
            let slopes = slopes.map(|slope| slope * self.sense());
            change.clear();
            change.resize(loads.len(), 0.0);
            for (slope, influence) in slopes.into_iter().zip(self.influence.rows(k)) {
                for (l, sum) in change.iter_mut().enumerate() {
                    *sum += slope * influence[l / 4].0[l % 4];
                }
            }
            for (l, slope) in change.iter().enumerate() {
                let own = if l == k { 1.0 } else { 0.0 };
                matrix[l * width + k / 4].0[k % 4] = own - slope;
            }
        }
        solve_in_place(matrix, right).map(|_| ())
    }
}

/// Returns true if loads, of which the largest is `largest`, are a solution after a Newton step that
/// changed them by `size`, and the step before it by `before`, N.
pub(super) fn is_settled(size: f64, before: f64, largest: f64) -> bool {
    size <= SETTLED * largest || (size >= before && size <= STAGNATED * largest) || largest == 0.0
}
