//! Small dense linear systems, their rows stored in blocks of four numbers.

use crate::scalar::{Lanes, Scalar};

/// Four numbers, computed side by side.
pub(super) type Four = Lanes<f64, 4>;

/// Number of blocks that hold `count` numbers, at least one.
pub(super) fn blocks_of(count: usize) -> usize {
    count.div_ceil(4).max(1)
}

/// Stores numbers in blocks, padding the last one with zeros.
pub(super) fn pack(numbers: &[f64], blocks: &mut Vec<Four>) {
    blocks.clear();
    let of = |chunk: &[f64]| Four::from_fn(|l| chunk.get(l).copied().unwrap_or(0.0));
    blocks.extend(numbers.chunks(4).map(of));
}

/// Solves a small dense system in place by Gaussian elimination with row pivoting; `right` becomes
/// the solution. Returns true if the determinant is positive, and `None` if the matrix is singular.
pub(super) fn solve_in_place(matrix: &mut [Four], right: &mut [f64]) -> Option<bool> {
    let n = right.len();
    let width = blocks_of(n);
    let mut positive = true;
    for k in 0..n {
        let (block, lane) = (k / 4, k % 4);
        let mut best = (k, matrix[k * width + block].0[lane].abs());
        for row in k + 1..n {
            let size = matrix[row * width + block].0[lane].abs();
            if size > best.1 {
                best = (row, size);
            }
        }
        if best.0 != k {
            for column in block..width {
                matrix.swap(k * width + column, best.0 * width + column);
            }
            right.swap(k, best.0);
            positive = !positive;
        }
        let (above, below) = matrix.split_at_mut((k + 1) * width);
        let row = &above[k * width + block..];
        let pivot = row[0].0[lane];
        if pivot == 0.0 || pivot.is_nan() {
            return None;
        }
        positive ^= pivot < 0.0;
        let (solved, rest) = right.split_at_mut(k + 1);
        for (other, right) in below.chunks_exact_mut(width).zip(rest) {
            let other = &mut other[block..];
            // Entries before the pivot in its block are not used again.
            let amount = other[0].0[lane] / pivot;
            let amounts = Four::from_f64(amount);
            other.iter_mut().zip(row).for_each(|(x, r)| *x -= amounts * *r);
            *right -= amount * solved[k];
        }
    }
    for k in (0..n).rev() {
        let row = &matrix[k * width..(k + 1) * width];
        let mut sum = right[k];
        for (l, x) in right.iter().enumerate().skip(k + 1) {
            sum -= row[l / 4].0[l % 4] * x;
        }
        right[k] = sum / row[k / 4].0[k % 4];
    }
    Some(positive)
}

#[cfg(test)]
mod tests {
    use super::*;
    use nalgebra::{DMatrix, DVector};
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn small_systems_are_solved(
            numbers in prop::collection::vec(-1.0..1.0_f64, 25),
            solution in prop::collection::vec(-1.0..1.0_f64, 5),
        ) {
            let matrix = DMatrix::from_row_slice(5, 5, &numbers);
            let right = &matrix * DVector::from_column_slice(&solution);
            let determinant = matrix.determinant();
            prop_assume!(determinant.abs() > 1e-3);
            let (mut work, mut found) = (Vec::new(), right.as_slice().to_vec());
            for row in numbers.chunks(5) {
                let mut blocks = Vec::new();
                pack(row, &mut blocks);
                work.extend(blocks);
            }
            prop_assert_eq!(solve_in_place(&mut work, &mut found), Some(determinant > 0.0));
            prop_assert!(found.iter().zip(&solution).all(|(a, b)| (a - b).abs() < 1e-10));
        }
    }
}
