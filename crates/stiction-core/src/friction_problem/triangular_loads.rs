//! Newton's method on many normal loads in block triangular form.
//!
//! In a mechanism with many bodies, most friction forces influence only few normal loads. The
//! Jacobian of the load equations is then sparse, and block triangular for a suitable order of the
//! unknowns: only its diagonal blocks are factorised.
//!
//! Equation (D3) of the book's theory.

use super::newton::{STEPS, UNBOUNDED, is_settled};
use super::small_system::{Four, blocks_of, solve_in_place};
use crate::linalg::largest;
use crate::scalar::Scalar;
use crate::spatial::Twist;

/// Equations `N = load(N)` of unknown normal loads.
pub(crate) trait LoadEquations {
    /// Sets the friction forces that the normal loads `loads`, N, cause.
    fn set_loads(&mut self, loads: &[f64]);

    /// Computes a normal load, N, under the present friction forces, and its gradient with respect
    /// to the wrench of the joint.
    fn load(&self, unknown: usize) -> (f64, Twist<f64>);

    /// Calls `put` with unknowns and the derivatives of the normal load `unknown` with respect to
    /// them, which sum up for repeated unknowns. `gradient` is the gradient of this load.
    fn slopes(&self, unknown: usize, gradient: Twist<f64>, put: impl FnMut(usize, f64));
}

/// Solver of [`LoadEquations`], with the solution and all buffers.
#[derive(Clone, Debug, Default)]
pub(crate) struct TriangularLoads {
    loads: Vec<f64>,
    /// Residual of the equations, N, and then the Newton step.
    change: Vec<f64>,
    gradients: Vec<Twist<f64>>,
    jacobian: Jacobian,
}

/// Derivatives of the computed normal loads, row by row. For a group of unknowns, only the columns
/// of this group and of earlier groups are stored: later groups do not influence it.
#[derive(Clone, Debug, Default)]
struct Jacobian {
    /// Index of the first entry of each row, followed by the number of entries.
    starts: Vec<usize>,
    entries: Vec<(usize, f64)>,
    block: Vec<Four>,
}

impl TriangularLoads {
    /// Returns true if the last solution has this number of unknowns.
    pub(crate) fn fits(&self, unknowns: usize) -> bool {
        self.loads.len() == unknowns
    }

    /// Sets the normal loads from which the next solution starts.
    pub(crate) fn start(&mut self, loads: impl Iterator<Item = f64>) {
        self.loads.clear();
        self.loads.extend(loads);
    }

    /// Returns the gradients of the normal loads after [`Self::adjoint`].
    pub(crate) fn gradients(&self) -> &[Twist<f64>] {
        &self.gradients
    }

    /// Solves the equations by Newton's method from the present normal loads. `ends` contains the
    /// number of unknowns up to the end of each group; no group influences earlier groups, except
    /// for round-off. Loads count as settled relative to the largest one, or to `scale`, N, if that is
    /// greater. After a success, the friction forces of the solution are set in `equations`.
    /// Returns false if the method does not converge.
    pub(crate) fn solve(
        &mut self,
        equations: &mut impl LoadEquations,
        ends: &[usize],
        scale: f64,
    ) -> bool {
        let most = UNBOUNDED * largest(&self.loads).max(scale).max(f64::MIN_POSITIVE);
        let mut before = f64::INFINITY;
        for _ in 0..STEPS {
            equations.set_loads(&self.loads);
            self.linearise(equations, ends);
            if self.jacobian.solve(ends, &mut self.change).is_none() {
                return false;
            }
            self.loads.iter_mut().zip(&self.change).for_each(|(load, change)| *load -= change);
            let (size, largest) = (largest(&self.change), largest(&self.loads).max(scale));
            if !(size.is_finite() && largest < most) {
                return false;
            }
            if is_settled(size, before, largest) {
                equations.set_loads(&self.loads);
                return true;
            }
            before = size;
        }
        false
    }

    /// Solves the adjoint problem at the solution, see
    /// [`LoadProblem::adjoint`](super::load_problem::LoadProblem::adjoint). Returns `None` if the
    /// system is singular.
    pub(crate) fn adjoint(
        &mut self,
        equations: &mut impl LoadEquations,
        ends: &[usize],
        weights: &mut [f64],
    ) -> Option<()> {
        self.linearise(equations, ends);
        self.jacobian.solve_transposed(ends, weights)
    }

    /// Computes residuals, gradients and Jacobian for the present friction forces.
    fn linearise(&mut self, equations: &impl LoadEquations, ends: &[usize]) {
        let Self { loads, change, gradients, jacobian: Jacobian { starts, entries, .. } } = self;
        change.clear();
        gradients.clear();
        entries.clear();
        starts.clear();
        let mut groups = ends.iter();
        let mut end = 0;
        for (unknown, load) in loads.iter().enumerate() {
            if unknown == end {
                end = groups.next().copied().unwrap_or(loads.len());
            }
            let (value, gradient) = equations.load(unknown);
            change.push(load - value);
            gradients.push(gradient);
            starts.push(entries.len());
            equations.slopes(unknown, gradient, |column, slope| {
                if column < end && slope != 0.0 {
                    entries.push((column, slope));
                }
            });
        }
        starts.push(entries.len());
    }
}

impl Jacobian {
    fn row(&self, row: usize) -> &[(usize, f64)] {
        &self.entries[self.starts[row]..self.starts[row + 1]]
    }

    /// Solves `(I - J) x = right` in place.
    fn solve(&mut self, ends: &[usize], right: &mut [f64]) -> Option<()> {
        let mut first = 0;
        for &end in ends {
            for row in first..end {
                let known = self.row(row).iter().filter(|(column, _)| *column < first);
                let sum: f64 = known.map(|(column, slope)| slope * right[*column]).sum();
                right[row] += sum;
            }
            self.solve_block(first..end, false, right)?;
            first = end;
        }
        Some(())
    }

    /// Solves `(I - J)^T x = right` in place.
    fn solve_transposed(&mut self, ends: &[usize], right: &mut [f64]) -> Option<()> {
        for (group, &end) in ends.iter().enumerate().rev() {
            let first = if group > 0 { ends[group - 1] } else { 0 };
            self.solve_block(first..end, true, right)?;
            for row in first..end {
                let amount = right[row];
                for (column, slope) in self.row(row).iter().filter(|(column, _)| *column < first) {
                    right[*column] += slope * amount;
                }
            }
        }
        Some(())
    }

    /// Solves a diagonal block of `I - J`, or its transpose, in place.
    fn solve_block(
        &mut self,
        range: core::ops::Range<usize>,
        transposed: bool,
        right: &mut [f64],
    ) -> Option<()> {
        let (first, count) = (range.start, range.len());
        let width = blocks_of(count);
        let mut block = core::mem::take(&mut self.block);
        block.clear();
        block.resize(width * count, Four::zero());
        for row in range.clone() {
            block[(row - first) * width + (row - first) / 4].0[(row - first) % 4] += 1.0;
            for (column, slope) in self.row(row).iter().filter(|(column, _)| *column >= first) {
                let place = (row - first, column - first);
                let (row, column) = if transposed { (place.1, place.0) } else { place };
                block[row * width + column / 4].0[column % 4] -= slope;
            }
        }
        let solved = solve_in_place(&mut block, &mut right[range]);
        self.block = block;
        solved.map(|_| ())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    proptest! {
        /// Checks the solutions of block triangular systems against dense elimination.
        #[test]
        fn triangular_systems_are_solved(
            numbers in prop::collection::vec(-0.1..0.1_f64, 36),
            right in prop::collection::vec(-1.0..1.0_f64, 6),
        ) {
            let ends = [2, 3, 6];
            let end_of = |row: usize| ends.into_iter().find(|end| row < *end).unwrap_or(6);
            let dense = DMatrix::from_fn(6, 6, |row, column| {
                if column < end_of(row) { numbers[6 * row + column] } else { 0.0 }
            });
            let mut jacobian = Jacobian::default();
            for row in 0..6 {
                jacobian.starts.push(jacobian.entries.len());
                jacobian.entries.extend((0..end_of(row)).map(|column| (column, dense[(row, column)])));
            }
            jacobian.starts.push(jacobian.entries.len());
            let matrix = DMatrix::identity(6, 6) - dense;
            let known = DVector::from_column_slice(&right);
            let mut found = right.clone();
            prop_assert!(jacobian.solve(&ends, &mut found).is_some());
            prop_assert!((&matrix * DVector::from_vec(found) - &known).amax() < 1e-12);
            let mut found = right;
            prop_assert!(jacobian.solve_transposed(&ends, &mut found).is_some());
            prop_assert!((matrix.transpose() * DVector::from_vec(found) - known).amax() < 1e-12);
        }
    }
}
