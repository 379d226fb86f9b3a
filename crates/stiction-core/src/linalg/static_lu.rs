//! LU factorisation as a fixed sequence of operations, compiled once and used for many matrices.
//!
//! Equation (M7) of the book's theory.

use super::plan::Plan;
use crate::scalar::{Lanes, Scalar};
use core::ops::Range;

/// LU factorisation of a sparse matrix in a fixed order, for any scalar type.
///
/// The order of pivots is chosen once, from a representative matrix ([`Plan`]). A factorisation
/// then neither branches nor allocates, and touches only structurally nonzero entries. If the order
/// is unsuitable for the values of a matrix, the residual of the solution is large.
///
/// Rows that depend on other rows are omitted.
#[derive(Clone, Debug, Default)]
pub(crate) struct StaticLu {
    entries: usize,
    /// For each matrix entry: index (slot) in the array of factors where the entry is stored.
    /// `None` for entries of omitted rows.
    slots: Vec<Option<u32>>,
    values: usize,
    rows: usize,
    columns: usize,
    steps: Vec<Step>,
    targets: Vec<Target>,
    /// Entries of the pivot rows to the right of the pivots, step by step.
    upper: Vec<Upper>,
    /// Slots that the elimination changes. For each target row of a step, there is one slot for
    /// each entry of the pivot row to the right of the pivot.
    updates: Vec<u32>,
}

#[derive(Clone, Debug)]
struct Step {
    pivot: u32,
    row: u32,
    column: u32,
    targets: Range<u32>,
    upper: Range<u32>,
}

#[derive(Clone, Debug)]
struct Target {
    slot: u32,
    row: u32,
    first_update: u32,
}

#[derive(Clone, Debug)]
struct Upper {
    slot: u32,
    column: u32,
}

impl StaticLu {
    /// Compiles a [`Plan`] to a fixed sequence of operations.
    pub(super) fn compile(plan: &Plan) -> Self {
        let mut program = Self {
            entries: plan.entries.len(),
            rows: plan.rows,
            columns: plan.columns,
            ..Self::default()
        };
        // Slots by row and column index, for the rows that have a pivot.
        let mut in_use = vec![false; plan.rows];
        for &(row, _) in &plan.pivots {
            in_use[row] = true;
        }
        let mut slot_of = vec![std::collections::BTreeMap::new(); plan.rows];
        for entry in &plan.entries {
            program.slots.push(in_use[entry.row].then(|| {
                let next = program.values as u32;
                *slot_of[entry.row].entry(entry.column).or_insert_with(|| {
                    program.values += 1;
                    next
                })
            }));
        }
        let mut rows_of = vec![Vec::new(); plan.columns];
        for (row, slots) in slot_of.iter().enumerate() {
            for &column in slots.keys() {
                rows_of[column].push(row);
            }
        }
        let mut row_done = vec![false; plan.rows];
        let mut column_done = vec![false; plan.columns];
        for &(row, column) in &plan.pivots {
            row_done[row] = true;
            column_done[column] = true;
            let first_upper = program.upper.len() as u32;
            for (&column, &slot) in &slot_of[row] {
                if !column_done[column] {
                    program.upper.push(Upper { slot, column: column as u32 });
                }
            }
            let upper = first_upper..program.upper.len() as u32;
            let first_target = program.targets.len() as u32;
            for target in rows_of[column].clone() {
                if row_done[target] {
                    continue;
                }
                program.targets.push(Target {
                    slot: slot_of[target][&column],
                    row: target as u32,
                    first_update: program.updates.len() as u32,
                });
                for k in upper.clone() {
                    let column = program.upper[k as usize].column as usize;
                    let next = program.values as u32;
                    let slot = *slot_of[target].entry(column).or_insert_with(|| {
                        program.values += 1;
                        rows_of[column].push(target);
                        next
                    });
                    program.updates.push(slot);
                }
            }
            program.steps.push(Step {
                pivot: slot_of[row][&column],
                row: row as u32,
                column: column as u32,
                targets: first_target..program.targets.len() as u32,
                upper,
            });
        }
        program
    }

    /// Returns the length of the array of factors: entries of all rows with a pivot, and fill-in.
    pub(crate) fn values(&self) -> usize {
        self.values
    }

    /// Returns the number of rows of the matrix.
    pub(crate) fn rows(&self) -> usize {
        self.rows
    }

    /// Returns the number of columns of the matrix.
    pub(crate) fn columns(&self) -> usize {
        self.columns
    }

    /// Returns the number of multiplications in one factorisation: one for each target row and one
    /// for each update.
    pub(crate) fn operations(&self) -> usize {
        self.updates.len() + self.targets.len()
    }

    /// Factors the matrix with the values `entries`, which are in the order of the plan; repeated
    /// entries are added. Writes the factors to `values`, which must have the length
    /// [`Self::values`]. Returns the product of the signs of the pivots, which equals the sign of
    /// the determinant up to a constant factor, 1 or -1.
    ///
    /// The factors carry no derivatives ([`Scalar::held`]). A solution has correct derivatives if
    /// it is a Newton step from a point where the equations hold. Otherwise, its derivatives
    /// require one additional step.
    pub(crate) fn factor<T: Scalar>(&self, entries: &[T], values: &mut [T]) -> T {
        debug_assert_eq!(entries.len(), self.entries);
        values.fill(T::zero());
        for (&entry, slot) in entries.iter().zip(&self.slots) {
            if let Some(slot) = slot {
                values[*slot as usize] += entry.held();
            }
        }
        let mut sign = T::one();
        for step in &self.steps {
            let pivot = values[step.pivot as usize];
            sign = pivot.if_positive(sign, -sign);
            let inverse = pivot.recip();
            values[step.pivot as usize] = inverse;
            let upper = &self.upper[step.upper.start as usize..step.upper.end as usize];
            for target in &self.targets[step.targets.start as usize..step.targets.end as usize] {
                let factor = values[target.slot as usize] * inverse;
                values[target.slot as usize] = factor;
                let updates = &self.updates[target.first_update as usize..];
                for (upper, &slot) in upper.iter().zip(updates) {
                    let change = factor * values[upper.slot as usize];
                    values[slot as usize] -= change;
                }
            }
        }
        sign
    }

    /// Yields the indices of the reciprocal pivots in the array of factors, in the order of
    /// elimination.
    pub(crate) fn pivots(&self) -> impl Iterator<Item = usize> + '_ {
        self.steps.iter().map(|step| step.pivot as usize)
    }

    /// Returns the smallest magnitude of the pivots in the factors `values`, each multiplied by
    /// `scale`, a function of row and column.
    pub(crate) fn smallest_pivot(
        &self,
        values: &[f64],
        scale: impl Fn(usize, usize) -> f64,
    ) -> f64 {
        let pivots = self.steps.iter().map(|step| {
            let reciprocal = values[step.pivot as usize];
            scale(step.row as usize, step.column as usize) / reciprocal.abs()
        });
        pivots.fold(f64::INFINITY, f64::min)
    }

    /// Solves the equations with the factors `values` and writes the result to `solution` (one
    /// value for each column). Overwrites the right-hand side `right` (one value for each row).
    pub(crate) fn solve<T: Scalar>(&self, values: &[T], right: &mut [T], solution: &mut [T]) {
        self.solve_by(|slot| values[slot as usize], right, solution);
    }

    /// Solves the equations as [`Self::solve`], for `N` right-hand sides at once, one in each SIMD
    /// lane.
    pub(crate) fn solve_lanes<const N: usize>(
        &self,
        values: &[f64],
        right: &mut [Lanes<f64, N>],
        solution: &mut [Lanes<f64, N>],
    ) {
        self.solve_by(|slot| Lanes::from_f64(values[slot as usize]), right, solution);
    }

    #[inline(always)]
    fn solve_by<T: Scalar>(&self, value: impl Fn(u32) -> T, right: &mut [T], solution: &mut [T]) {
        for step in &self.steps {
            let known = right[step.row as usize];
            for target in &self.targets[step.targets.start as usize..step.targets.end as usize] {
                right[target.row as usize] -= value(target.slot) * known;
            }
        }
        for step in self.steps.iter().rev() {
            let mut sum = right[step.row as usize];
            for upper in &self.upper[step.upper.start as usize..step.upper.end as usize] {
                sum -= value(upper.slot) * solution[upper.column as usize];
            }
            solution[step.column as usize] = sum * value(step.pivot);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::linalg::{Entry, Plan, Scales};
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    fn dense(entries: &[Entry], numbers: &[f64], rows: usize, columns: usize) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(rows, columns);
        for (entry, number) in entries.iter().zip(numbers) {
            matrix[(entry.row, entry.column)] += number;
        }
        matrix
    }

    proptest! {
        /// Checks the residuals of sparse square systems, for the values of the plan and for other
        /// values.
        #[test]
        fn agrees_with_dense_elimination(
            size in 1..12usize,
            seeds in prop::collection::vec((0..12usize, 0..12usize, -1.0..1.0f64, -0.1..0.1f64), 0..60),
        ) {
            let mut entries: Vec<Entry> = (0..size).map(|i| Entry { row: i, column: (i * 7 + 3) % size }).collect();
            let permutation = (0..size).map(|i| (i * 7 + 3) % size).collect::<std::collections::BTreeSet<_>>();
            prop_assume!(permutation.len() == size);
            let mut planned = vec![4.0; size];
            let mut replayed = vec![-3.5; size];
            for (row, column, number, change) in seeds {
                entries.push(Entry { row: row % size, column: column % size });
                planned.push(number);
                replayed.push(number + change);
            }
            let plan = Plan::new(size, size, &entries, &planned, Scales::NONE).unwrap();
            let program = plan.compile();
            for numbers in [planned, replayed] {
                let matrix = dense(&entries, &numbers, size, size);
                prop_assume!(matrix.clone().svd(false, false).singular_values.min() > 1e-2);
                let right = DVector::from_fn(size, |i, _| 1.0 + i as f64);
                let mut values = vec![0.0; program.values()];
                let sign = program.factor(&numbers, &mut values);
                let mut solution = vec![0.0; size];
                program.solve(&values, right.clone().as_mut_slice(), &mut solution);
                let residual = &matrix * DVector::from_vec(solution) - right;
                prop_assert!(residual.amax() < 1e-10, "{}", residual.amax());
                prop_assert!(sign.abs() == 1.0);
            }
        }

        /// Checks that a redundant row is omitted, and that the solution of the other rows is
        /// correct.
        #[test]
        fn redundant_rows_are_found(numbers in prop::collection::vec(-1.0..1.0f64, 12)) {
            let base = DMatrix::from_row_slice(3, 3, &numbers[..9]) + DMatrix::identity(3, 3) * 3.0;
            let mix = DMatrix::from_row_slice(1, 3, &numbers[9..]);
            let extra = &mix * &base;
            let mut entries = Vec::new();
            let mut values = Vec::new();
            for row in 0..4 {
                for column in 0..3 {
                    entries.push(Entry { row, column });
                    values.push(if row < 3 { base[(row, column)] } else { extra[column] });
                }
            }
            let plan = Plan::new(4, 3, &entries, &values, Scales::NONE).unwrap();
            prop_assert_eq!(plan.pivots.len(), 3);
            let program = plan.compile();
            let mut factors = vec![0.0; program.values()];
            program.factor(&values, &mut factors);
            let truth = DVector::from_row_slice(&[0.3, -0.2, 0.5]);
            let mut right: Vec<f64> = (dense(&entries, &values, 4, 3) * &truth).iter().copied().collect();
            let mut solution = vec![0.0; 3];
            program.solve(&factors, &mut right, &mut solution);
            prop_assert!((DVector::from_vec(solution) - truth).amax() < 1e-12);
        }
    }

    #[test]
    fn a_dependent_column_is_an_error() {
        let entries = [
            Entry { row: 0, column: 0 },
            Entry { row: 1, column: 0 },
            Entry { row: 0, column: 1 },
            Entry { row: 1, column: 1 },
        ];
        let deficient = Plan::new(2, 2, &entries, &[1.0, 2.0, 2.0, 4.0], Scales::NONE).unwrap_err();
        assert_eq!(deficient.columns.len(), 1);
    }
}
