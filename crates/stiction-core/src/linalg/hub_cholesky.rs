//! Cholesky decomposition of a block diagonal matrix plus a matrix of low rank.

use super::block::{
    BLOCK, Block, NOTHING, Part, UNIT, add_outer, dot, inverse_factor, lower_times, upper_times,
};

/// Cholesky decomposition of `S = D + V W V^T` in linear time, where `D` is block diagonal and `V`
/// has at most six columns.
///
/// The factor of `S` is full, but its blocks below the diagonal have low rank: with the Cholesky
/// factor `L_k` of the diagonal block `A_k = D_k + V_k W_k V_k^T`, they are `V_i U_k`, where
/// `U_k = W_k V_k^T L_k^-T` and `W_{k+1} = W_k - U_k U_k^T`. Neither `D` nor `W` needs to be
/// regular.
#[derive(Clone, Debug)]
pub(crate) struct HubCholesky {
    /// Diagonal blocks of `D`, and after the decomposition the inverses of the factors `L_k`.
    diagonal: Vec<Block>,
    /// Transposed block rows of `V`: the columns of `V`, of which unused ones are zero.
    columns: Vec<Block>,
    /// Diagonal of `W`.
    weights: Part,
    /// Block columns `U_k`, by rows.
    carried: Vec<Block>,
    /// Copy of `diagonal` before the decomposition, made by [`HubCholesky::keep`].
    kept: Vec<Block>,
}

impl HubCholesky {
    /// Prepares a matrix of `count` block rows.
    pub(crate) fn new(count: usize) -> Self {
        Self {
            diagonal: vec![NOTHING; count],
            columns: vec![NOTHING; count],
            weights: [0.0; BLOCK],
            carried: vec![NOTHING; count],
            kept: Vec::new(),
        }
    }

    /// Sets all blocks and weights to zero.
    pub(crate) fn clear(&mut self) {
        self.diagonal.fill(NOTHING);
        self.columns.fill(NOTHING);
        self.weights = [0.0; BLOCK];
    }

    /// Returns a diagonal block of `D`.
    pub(crate) fn block(&mut self, index: usize) -> &mut Block {
        &mut self.diagonal[index]
    }

    /// Sets a column of `V` and its entry of `W`. `parts` contains the nonzero components of the
    /// column, each with its block row.
    pub(crate) fn set_column(
        &mut self,
        column: usize,
        weight: f64,
        parts: impl Iterator<Item = (usize, Part)>,
    ) {
        self.weights[column] = weight;
        parts.for_each(|(row, part)| self.columns[row][column] = part);
    }

    /// Sets a block row of `V`, and all weights to one. `columns` contains the columns of this
    /// block row.
    pub(crate) fn set_row(&mut self, row: usize, columns: &Block) {
        self.columns[row] = *columns;
        self.weights = [1.0; BLOCK];
    }

    /// Returns the diagonal of a diagonal block of `V W V^T`.
    pub(crate) fn low_rank_diagonal(&self, row: usize) -> Part {
        let mut diagonal = [0.0; BLOCK];
        for (column, weight) in self.columns[row].iter().zip(self.weights) {
            (0..BLOCK).for_each(|i| diagonal[i] += weight * column[i] * column[i]);
        }
        diagonal
    }

    /// Saves a copy of the matrix, which [`Self::restore`] copies back after a decomposition.
    pub(crate) fn keep(&mut self) {
        self.kept.clone_from(&self.diagonal);
    }

    /// Restores the matrix saved by [`Self::keep`].
    pub(crate) fn restore(&mut self) {
        self.diagonal.copy_from_slice(&self.kept);
    }

    /// Decomposes the matrix in place. Returns `false` at the first pivot that does not exceed
    /// `least` or is not finite.
    pub(crate) fn factor_above(&mut self, least: f64) -> bool {
        let Self { diagonal, columns, weights, carried, .. } = self;
        let mut left = NOTHING;
        (0..BLOCK).for_each(|i| left[i][i] = weights[i]);
        for ((own, columns), carried) in diagonal.iter_mut().zip(columns).zip(carried) {
            // Rows of `W_k V_k^T`.
            let mut moved = NOTHING;
            for (moved, left) in moved.iter_mut().zip(&left) {
                *moved = upper_times(columns, left);
            }
            for (column, moved) in columns.iter().zip(&moved) {
                add_outer(own, column, moved);
            }
            let mut inverse = UNIT;
            if !inverse_factor(own, &mut inverse, BLOCK, least) {
                return false;
            }
            *own = inverse;
            *carried = moved.map(|row| lower_times(&inverse, &row));
            for (left, a) in left.iter_mut().zip(&*carried) {
                for (entry, b) in left.iter_mut().zip(&*carried) {
                    *entry -= dot(a, b);
                }
            }
        }
        true
    }

    /// Returns the pivots of a block row after [`Self::factor_above`].
    pub(crate) fn pivots(&self, block: usize) -> Part {
        let inverse = &self.diagonal[block];
        core::array::from_fn(|k| inverse[k][k].powi(-2))
    }

    /// Solves for the right-hand side `vector` in place, after [`Self::factor_above`].
    pub(crate) fn solve(&self, vector: &mut [Part]) {
        let blocks = || self.diagonal.iter().zip(&self.columns).zip(&self.carried);
        let mut before = [0.0; BLOCK];
        for (part, ((inverse, columns), carried)) in vector.iter_mut().zip(blocks()) {
            let known = upper_times(columns, &before);
            (0..BLOCK).for_each(|i| part[i] -= known[i]);
            *part = lower_times(inverse, part);
            (0..BLOCK).for_each(|i| before[i] += dot(&carried[i], part));
        }
        let mut after = [0.0; BLOCK];
        for (part, ((inverse, columns), carried)) in vector.iter_mut().zip(blocks()).rev() {
            let known = upper_times(carried, &after);
            (0..BLOCK).for_each(|i| part[i] -= known[i]);
            *part = upper_times(inverse, part);
            (0..BLOCK).for_each(|i| after[i] += dot(&columns[i], part));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linalg::{BlockCholesky, Slot};
    use crate::random::Random;

    /// Compares pivots and solutions with those of the general decomposition, for a regular and
    /// for a singular block diagonal matrix `D`.
    #[test]
    fn agrees_with_the_general_decomposition() {
        let mut random = Random::new(8);
        for singular in [false, true] {
            let count = 7;
            let mut hub = HubCholesky::new(count);
            let pairs = || (0..count).flat_map(|a| (0..a).map(move |b| (a, b)));
            let mut general = BlockCholesky::new(count, pairs());
            let columns: Vec<Vec<Part>> = (0..BLOCK)
                .map(|_| (0..count).map(|_| core::array::from_fn(|_| random.number())).collect())
                .collect();
            let mut own = vec![NOTHING; count];
            for (k, own) in own.iter_mut().enumerate() {
                // Two blocks, whose rows the low-rank matrix makes independent, have a low rank.
                let rank = if singular && k < 2 { 3 } else { 2 * BLOCK };
                for _ in 0..rank {
                    let part: Part = core::array::from_fn(|_| random.number());
                    add_outer(own, &part, &part);
                }
                *hub.block(k) = *own;
            }
            for (j, column) in columns.iter().enumerate() {
                hub.set_column(j, 0.5 + j as f64, column.iter().copied().enumerate());
            }
            for a in 0..count {
                for b in 0..=a {
                    let mut block = if a == b { own[a] } else { NOTHING };
                    for (j, column) in columns.iter().enumerate() {
                        let weighted = column[a].map(|x| x * (0.5 + j as f64));
                        add_outer(&mut block, &weighted, &column[b]);
                    }
                    match general.slot(a, b) {
                        Some(slot @ Slot::Below { transposed: true, .. }) => {
                            let (to, _) = general.block(slot);
                            (0..BLOCK)
                                .for_each(|i| (0..BLOCK).for_each(|j| to[j][i] = block[i][j]));
                        }
                        Some(slot) => *general.block(slot).0 = block,
                        None => unreachable!(),
                    }
                }
            }
            assert!(hub.factor_above(0.0) && general.factor());
            let right: Vec<Part> =
                (0..count).map(|_| core::array::from_fn(|_| random.number())).collect();
            let (mut found, mut expected) = (right.clone(), right);
            hub.solve(&mut found);
            general.solve(&mut expected);
            for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
                assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()));
            }
            // The product of the pivots is the determinant, whatever the order.
            let product = |pivots: &dyn Fn(usize) -> Part| -> f64 {
                (0..count).flat_map(pivots).map(f64::ln).sum()
            };
            let (a, b) = (product(&|k| hub.pivots(k)), product(&|k| general.pivots(k)));
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    }

    /// Chains of blocks of different sizes whose last blocks a matrix of low rank couples, as the
    /// joints of a platform on legs: without blocks for the pairs of last blocks, factors exist for
    /// the same shifts, and solutions are the same.
    #[test]
    fn chains_at_a_hub_agree_with_the_general_decomposition() {
        const CHAINS: usize = 8;
        const SIZES: [usize; 3] = [4, 5, 3];
        let mut random = Random::new(3);
        let sizes: Vec<usize> = (0..3 * CHAINS).map(|block| SIZES[block % 3]).collect();
        let hub: Vec<usize> = (0..CHAINS).map(|chain| 3 * chain + 2).collect();
        let along = || (0..CHAINS).flat_map(|c| [(3 * c, 3 * c + 1), (3 * c + 1, 3 * c + 2)]);
        let among =
            || hub.iter().flat_map(|a| hub.iter().filter(move |b| *b < a).map(|b| (*a, *b)));
        let mut linear = BlockCholesky::with_hub(&sizes, along(), &hub);
        let mut general = BlockCholesky::with_sizes(&sizes, along().chain(among()));
        assert!(linear.has_hub() && !general.has_hub());
        let mut part = |size: usize| -> Part {
            core::array::from_fn(|i| if i < size { random.number() } else { 0.0 })
        };
        // Outer products, whose sums are semidefinite. Each vector has parts in one or two blocks.
        let mut vectors: Vec<Vec<(usize, Part)>> = Vec::new();
        for (block, size) in sizes.iter().enumerate() {
            vectors.extend((0..4).map(|_| vec![(block, part(*size))]));
        }
        for (a, b) in along() {
            vectors.extend((0..3).map(|_| vec![(a, part(sizes[a])), (b, part(sizes[b]))]));
        }
        let columns: Vec<Vec<Part>> =
            (0..BLOCK).map(|_| hub.iter().map(|block| part(sizes[*block])).collect()).collect();
        let add = |matrix: &mut BlockCholesky, (a, x): (usize, Part), (b, y): (usize, Part)| {
            let Some(slot) = matrix.slot(a, b) else { unreachable!() };
            match matrix.block(slot) {
                (block, true) => add_outer(block, &y, &x),
                (block, false) => add_outer(block, &x, &y),
            }
        };
        let fill = |linear: &mut BlockCholesky, general: &mut BlockCholesky| {
            for matrix in [&mut *linear, &mut *general] {
                matrix.clear();
                for vector in &vectors {
                    for (k, a) in vector.iter().enumerate() {
                        vector[..=k].iter().for_each(|b| add(matrix, *a, *b));
                    }
                }
            }
            for (k, a) in hub.iter().enumerate() {
                let row: Block = core::array::from_fn(|c| columns[c][k]);
                linear.set_hub_row(*a, &row);
                for (other, b) in hub[..=k].iter().enumerate() {
                    for column in &columns {
                        add(general, (*a, column[k]), (*b, column[other]));
                    }
                }
            }
        };
        fill(&mut linear, &mut general);
        assert!((linear.least_diagonal() / general.least_diagonal() - 1.0).abs() < 1e-14);
        // Largest shift below all eigenvalues, by bisection.
        let mut greatest = |by_hub: bool| {
            let (mut below, mut above) = (0.0, 1.0);
            for _ in 0..40 {
                let middle = 0.5 * (below + above);
                fill(&mut linear, &mut general);
                let matrix = if by_hub { &mut linear } else { &mut general };
                matrix.shift(middle);
                if matrix.factor() { below = middle } else { above = middle }
            }
            below
        };
        let (by_hub, by_blocks) = (greatest(true), greatest(false));
        assert!(
            by_blocks > 1e-4 && (by_hub / by_blocks - 1.0).abs() < 1e-9,
            "{by_hub} {by_blocks}"
        );
        fill(&mut linear, &mut general);
        for matrix in [&mut linear, &mut general] {
            matrix.shift(0.5 * by_blocks);
            assert!(matrix.factor());
        }
        let right = |size: &usize| core::array::from_fn(|i| if i < *size { 1.0 } else { 0.0 });
        let mut found: Vec<Part> = sizes.iter().map(right).collect();
        let mut expected = found.clone();
        linear.solve(&mut found);
        general.solve(&mut expected);
        for (found, expected) in found.iter().flatten().zip(expected.iter().flatten()) {
            assert!((found - expected).abs() < 1e-9 * (1.0 + expected.abs()));
        }
        for block in 0..sizes.len() {
            let used = ..sizes[block];
            let product =
                |matrix: &BlockCholesky| matrix.pivots(block)[used].iter().product::<f64>();
            assert!(product(&linear) > 0.0 && product(&general) > 0.0, "{block}");
        }

        // A block of a pair of hub blocks, or a chain between two of them, needs all blocks.
        for direct in [vec![(2, 5)], vec![(1, 5)]] {
            let pairs = along().chain(direct);
            assert!(!BlockCholesky::with_hub(&sizes, pairs, &hub).has_hub());
        }
    }
}
