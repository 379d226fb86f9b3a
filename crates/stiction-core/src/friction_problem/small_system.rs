//! Small dense linear systems with rows stored in blocks of four numbers.

use crate::scalar::{Lanes, Scalar};

/// Four numbers that are computed together in SIMD lanes.
pub(crate) type Four = Lanes<f64, 4>;

/// Number of blocks that hold `count` numbers; at least one.
pub(super) fn blocks_of(count: usize) -> usize {
    count.div_ceil(4).max(1)
}

/// Stores numbers in blocks, padding the last one with zeros.
pub(crate) fn pack(numbers: &[f64], blocks: &mut Vec<Four>) {
    blocks.clear();
    pack_after(numbers, blocks);
}

/// Appends numbers in blocks, padding the last one with zeros.
pub(super) fn pack_after(numbers: &[f64], blocks: &mut Vec<Four>) {
    let of = |chunk: &[f64]| Four::from_fn(|l| chunk.get(l).copied().unwrap_or(0.0));
    blocks.extend(numbers.chunks(4).map(of));
}

/// Evaluates `$fixed` with the constant `$w` equal to `$width`, so that loops over the blocks of a
/// row are unrolled. For rows of more than six blocks, evaluates `$rest` instead.
macro_rules! by_width {
    ($width:expr, $w:ident => $fixed:expr, $rest:expr) => {
        match $width {
            1 => {
                const $w: usize = 1;
                $fixed
            }
            2 => {
                const $w: usize = 2;
                $fixed
            }
            3 => {
                const $w: usize = 3;
                $fixed
            }
            4 => {
                const $w: usize = 4;
                $fixed
            }
            5 => {
                const $w: usize = 5;
                $fixed
            }
            6 => {
                const $w: usize = 6;
                $fixed
            }
            _ => $rest,
        }
    };
}
pub(super) use by_width;

/// Solves a small dense system in place by Gaussian elimination with row pivoting; `right` becomes
/// the solution. Returns `Some(true)` if the determinant is positive, and `None` if the matrix is
/// singular.
pub(super) fn solve_in_place(matrix: &mut [Four], right: &mut [f64]) -> Option<bool> {
    solve_if_regular(matrix, right, 0.0)
}

/// Solves the system like [`solve_in_place`], but returns `None` if a pivot is at most the fraction
/// `least` of the largest entry.
pub(super) fn solve_if_regular(matrix: &mut [Four], right: &mut [f64], least: f64) -> Option<bool> {
    let width = blocks_of(right.len());
    let negligible = match least {
        0.0 => 0.0,
        _ => least * matrix.iter().flat_map(|block| block.0).fold(0.0_f64, |m, x| m.max(x.abs())),
    };
    by_width!(
        width,
        W => eliminate(matrix, W, right, negligible),
        eliminate(matrix, width, right, negligible)
    )
}

/// Solves the system like [`solve_in_place`], with `width` blocks per row. Inlined, so that a
/// constant `width` unrolls the loops over the blocks of a row.
#[inline(always)]
fn eliminate(
    matrix: &mut [Four],
    width: usize,
    right: &mut [f64],
    negligible: f64,
) -> Option<bool> {
    let n = right.len();
    let matrix = matrix.get_mut(..n * width)?;
    let mut positive = true;
    for k in 0..n {
        let (block, lane) = (k / 4, k % 4);
        let mut best = (k, 0.0);
        for (row, content) in matrix.chunks_exact(width).enumerate().skip(k) {
            let size = content[block].0[lane].abs();
            if size > best.1 {
                best = (row, size);
            }
        }
        if best.0 != k {
            for column in 0..width {
                matrix.swap(k * width + column, best.0 * width + column);
            }
            right.swap(k, best.0);
            positive = !positive;
        }
        let (above, below) = matrix.split_at_mut((k + 1) * width);
        let row = &above[k * width..];
        let pivot = row[block].0[lane];
        if pivot.abs() <= negligible || pivot.is_nan() {
            return None;
        }
        positive ^= pivot < 0.0;
        let over = 1.0 / pivot;
        let (solved, rest) = right.split_at_mut(k + 1);
        for (other, right) in below.chunks_exact_mut(width).zip(rest) {
            // Entries to the left of the pivot are not used again.
            let amount = other[block].0[lane] * over;
            let amounts = Four::from_f64(amount);
            other.iter_mut().zip(row).for_each(|(x, r)| *x -= amounts * *r);
            *right -= amount * solved[k];
        }
    }
    for k in (0..n).rev() {
        let (block, lane) = (k / 4, k % 4);
        let (above, own) = right.split_at_mut(k);
        own[0] /= matrix[k * width + block].0[lane];
        for (row, right) in matrix.chunks_exact(width).zip(above) {
            *right -= row[block].0[lane] * own[0];
        }
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
