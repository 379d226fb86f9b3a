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

/// Evaluates an expression with the constant `$w` equal to `$width`, so that loops over the blocks of a row
/// are unrolled; with the greatest constant if the row is longer, and `$rest` for all other rows.
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

/// Row of a matrix in blocks: an array, or a slice if it is long.
pub(super) trait BlockRow: AsRef<[Four]> + AsMut<[Four]> {
    /// Subtracts a multiple of a row with the same number of blocks.
    fn subtract(&mut self, row: &[Four], amount: f64);
}

impl<const W: usize> BlockRow for [Four; W] {
    #[inline(always)]
    fn subtract(&mut self, row: &[Four], amount: f64) {
        let Some(row) = row.first_chunk::<W>() else { return };
        let amount = Four::from_f64(amount);
        for k in 0..W {
            self[k] -= amount * row[k];
        }
    }
}

/// Solves a small dense system in place by Gaussian elimination with row pivoting; `right` becomes
/// the solution. Returns true if the determinant is positive, and `None` if the matrix is singular.
pub(super) fn solve_in_place(matrix: &mut [Four], right: &mut [f64]) -> Option<bool> {
    let width = blocks_of(right.len());
    by_width!(
        width,
        W => eliminate(matrix.as_chunks_mut::<W>().0, right),
        {
            let mut rows: Vec<LongRow<'_>> = matrix.chunks_exact_mut(width).map(LongRow).collect();
            eliminate(&mut rows, right)
        }
    )
}

/// Row of more blocks than have a constant.
struct LongRow<'a>(&'a mut [Four]);

impl AsRef<[Four]> for LongRow<'_> {
    fn as_ref(&self) -> &[Four] {
        self.0
    }
}

impl AsMut<[Four]> for LongRow<'_> {
    fn as_mut(&mut self) -> &mut [Four] {
        self.0
    }
}

impl BlockRow for LongRow<'_> {
    fn subtract(&mut self, row: &[Four], amount: f64) {
        let amount = Four::from_f64(amount);
        self.0.iter_mut().zip(row).for_each(|(x, r)| *x -= amount * *r);
    }
}

#[inline(always)]
fn eliminate<R: BlockRow>(rows: &mut [R], right: &mut [f64]) -> Option<bool> {
    let n = right.len();
    let rows = rows.get_mut(..n)?;
    let mut positive = true;
    for k in 0..n {
        let (block, lane) = (k / 4, k % 4);
        let entry = |row: &R| row.as_ref()[block].0[lane];
        let mut best = (k, entry(&rows[k]).abs());
        for (row, content) in rows.iter().enumerate().skip(k + 1) {
            let size = entry(content).abs();
            if size > best.1 {
                best = (row, size);
            }
        }
        if best.0 != k {
            rows.swap(k, best.0);
            right.swap(k, best.0);
            positive = !positive;
        }
        let (above, below) = rows.split_at_mut(k + 1);
        let row = above[k].as_ref();
        let pivot = row[block].0[lane];
        if pivot == 0.0 || pivot.is_nan() {
            return None;
        }
        positive ^= pivot < 0.0;
        let over = 1.0 / pivot;
        let (solved, rest) = right.split_at_mut(k + 1);
        for (other, right) in below.iter_mut().zip(rest) {
            // Entries before the pivot are not used again.
            let amount = entry(other) * over;
            other.subtract(row, amount);
            *right -= amount * solved[k];
        }
    }
    for k in (0..n).rev() {
        let (block, lane) = (k / 4, k % 4);
        let entry = |row: &R| row.as_ref()[block].0[lane];
        let (above, own) = right.split_at_mut(k);
        own[0] /= entry(&rows[k]);
        for (row, right) in rows.iter().zip(above) {
            *right -= entry(row) * own[0];
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
