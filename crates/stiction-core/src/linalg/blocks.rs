//! Cholesky decomposition of sparse symmetric positive definite block matrices.

use super::block::{
    BLOCK, Block, NOTHING, Part, UNIT, dot, inverse_factor, lower_times, multiply_lower,
    subtract_product, subtract_square, upper_times,
};
use super::elimination_order::EliminationOrder;
use super::hub_cholesky::HubCholesky;

/// Cholesky decomposition of a sparse block matrix. The order of elimination is chosen once, from
/// the pattern of nonzero blocks alone. This is admissible because any order is stable for positive
/// definite matrices.
#[derive(Clone, Debug)]
pub(crate) struct BlockCholesky {
    /// Elimination step in which each block row is eliminated.
    place: Vec<usize>,
    /// For each elimination step, the number of rows in use in its block row.
    sizes: Vec<usize>,
    /// Index in `below` of the first block of each elimination step, followed by the total number
    /// of blocks in `below`.
    starts: Vec<usize>,
    /// For each block in `below`, the elimination step of its block row.
    rows: Vec<usize>,
    /// Index in `below` of the block that the product of two blocks of one elimination step
    /// changes. There is an entry for each pair of different blocks, step after step.
    updates: Vec<usize>,
    diagonal: Vec<Block>,
    /// Blocks below the diagonal, stored transposed: all products are then sums of outer products,
    /// which compilers vectorise.
    below: Vec<Block>,
    /// Copies of `diagonal` and `below` before the decomposition, made by [`BlockCholesky::keep`].
    kept_diagonal: Vec<Block>,
    kept_below: Vec<Block>,
    solution: Vec<Part>,
    /// Matrix of the last block rows if only a matrix of low rank couples them, and the elimination
    /// step of the first one.
    hub: Option<(usize, HubCholesky)>,
}

/// Location of a matrix block in the storage of [`BlockCholesky`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Slot {
    Diagonal(usize),
    /// Block below the diagonal. If `transposed`, the stored block is the transpose of the
    /// requested block.
    Below {
        index: usize,
        transposed: bool,
    },
}

impl BlockCholesky {
    /// Prepares a matrix of `count` block rows. The blocks on the diagonal, at the index pairs in
    /// `pairs` and at the mirrored pairs may be nonzero.
    pub(crate) fn new(count: usize, pairs: impl Iterator<Item = (usize, usize)>) -> Self {
        Self::with_sizes(&vec![BLOCK; count], pairs)
    }

    /// Prepares a matrix like [`Self::new`], in whose block rows only the first `sizes` rows and
    /// columns are in use. All other entries, except on the diagonal, must be zero, and also those
    /// of right-hand sides.
    pub(crate) fn with_sizes(sizes: &[usize], pairs: impl Iterator<Item = (usize, usize)>) -> Self {
        Self::in_order(EliminationOrder::new(sizes.len(), pairs), sizes)
    }

    /// Prepares a matrix like [`Self::with_sizes`], to which a matrix `V V^T` with six columns is
    /// added ([`Self::set_hub_row`]). Only the block rows `hub` of `V` are not zero. If the other
    /// blocks do not couple these block rows, the cost grows linearly with their number, and they
    /// have no blocks for their pairs; otherwise the added matrix must be written to the blocks,
    /// see [`Self::has_hub`].
    pub(crate) fn with_hub(
        sizes: &[usize],
        pairs: impl Iterator<Item = (usize, usize)>,
        hub: &[usize],
    ) -> Self {
        let pairs: Vec<(usize, usize)> = pairs.collect();
        let count = sizes.len();
        let mut is_hub = vec![false; count];
        hub.iter().for_each(|block| is_hub[*block] = true);
        let among = hub.iter().enumerate().flat_map(|(k, a)| hub[..k].iter().map(|b| (*a, *b)));
        let mut order = EliminationOrder::new(count, pairs.iter().copied().chain(among));
        let first = count - hub.len();
        let are_last = order.nodes[first..].iter().all(|block| is_hub[*block]);
        let couples_none =
            |around: &Vec<usize>| around.iter().filter(|block| is_hub[**block]).count() < 2;
        let is_separate = order.neighbours[..first].iter().all(couples_none);
        let are_apart = pairs.iter().all(|(a, b)| a == b || !(is_hub[*a] && is_hub[*b]));
        let is_linear = !hub.is_empty() && are_last && is_separate && are_apart;
        if is_linear {
            order.neighbours[first..].iter_mut().for_each(Vec::clear);
        }
        let mut made = Self::in_order(order, sizes);
        made.hub = is_linear.then(|| (first, HubCholesky::new(hub.len())));
        made
    }

    fn in_order(order: EliminationOrder, sizes: &[usize]) -> Self {
        let count = sizes.len();
        let mut place = vec![0; count];
        order.nodes.iter().enumerate().for_each(|(step, block)| place[*block] = step);
        let (mut starts, mut rows) = (vec![0], Vec::new());
        for column in &order.neighbours {
            let mut steps: Vec<usize> = column.iter().map(|block| place[*block]).collect();
            steps.sort_unstable();
            rows.extend(steps);
            starts.push(rows.len());
        }
        let mut made = Self {
            sizes: order.nodes.iter().map(|block| sizes[*block]).collect(),
            place,
            diagonal: vec![NOTHING; count],
            below: vec![NOTHING; rows.len()],
            kept_diagonal: Vec::new(),
            kept_below: Vec::new(),
            solution: Vec::new(),
            hub: None,
            starts,
            rows,
            updates: Vec::new(),
        };
        for step in 0..count {
            let own = &made.rows[made.starts[step]..made.starts[step + 1]];
            let mut updates = Vec::new();
            for (k, &column) in own.iter().enumerate() {
                // The product of a block with itself changes a diagonal block, which needs no
                // index.
                for &row in &own[k + 1..] {
                    updates.extend(made.find(row, column));
                }
            }
            made.updates.extend(updates);
        }
        made
    }

    fn find(&self, row: usize, column: usize) -> Option<usize> {
        let range = self.starts[column]..self.starts[column + 1];
        let found = self.rows[range.clone()].binary_search(&row).ok()?;
        Some(range.start + found)
    }

    /// Returns the storage location of the block in block row `a` and block column `b`; `None` if
    /// this block is zero and not stored.
    pub(crate) fn slot(&self, a: usize, b: usize) -> Option<Slot> {
        let (row, column) = (self.place[a], self.place[b]);
        if row == column {
            return Some(Slot::Diagonal(row));
        }
        let index = self.find(row.max(column), row.min(column))?;
        Some(Slot::Below { index, transposed: row > column })
    }

    /// Sets all blocks to zero.
    pub(crate) fn clear(&mut self) {
        self.diagonal.fill(NOTHING);
        self.below.fill(NOTHING);
        if let Some((_, hub)) = &mut self.hub {
            hub.clear();
        }
    }

    /// Returns `true` if the matrix of low rank of [`Self::with_hub`] has no blocks.
    pub(crate) fn has_hub(&self) -> bool {
        self.hub.is_some()
    }

    /// Sets a block row of `V`, see [`Self::with_hub`]. `columns` contains the columns of this
    /// block row.
    pub(crate) fn set_hub_row(&mut self, block: usize, columns: &Block) {
        if let Some((first, hub)) = &mut self.hub {
            hub.set_row(self.place[block] - *first, columns);
        }
    }

    /// Returns the block at a storage location, and a flag that is `true` if the block is stored
    /// transposed. The lower triangles of blocks on the diagonal are not used.
    pub(crate) fn block(&mut self, slot: Slot) -> (&mut Block, bool) {
        match slot {
            Slot::Diagonal(step) => (&mut self.diagonal[step], false),
            Slot::Below { index, transposed } => (&mut self.below[index], transposed),
        }
    }

    /// Subtracts `by` times the identity matrix from the matrix.
    pub(crate) fn shift(&mut self, by: f64) {
        for block in &mut self.diagonal {
            (0..BLOCK).for_each(|i| block[i][i] -= by);
        }
    }

    /// Returns the smallest diagonal entry in use: an upper bound of the smallest eigenvalue.
    pub(crate) fn least_diagonal(&self) -> f64 {
        let mut least = f64::INFINITY;
        for (step, (block, size)) in self.diagonal.iter().zip(&self.sizes).enumerate() {
            let hub = self.hub.as_ref().filter(|(first, _)| step >= *first);
            let added =
                hub.map_or([0.0; BLOCK], |(first, hub)| hub.low_rank_diagonal(step - first));
            least = (0..*size).map(|i| block[i][i] + added[i]).fold(least, f64::min);
        }
        least
    }

    /// Saves a copy of the matrix, which [`Self::restore`] copies back after a decomposition.
    pub(crate) fn keep(&mut self) {
        self.kept_diagonal.clone_from(&self.diagonal);
        self.kept_below.clone_from(&self.below);
    }

    /// Restores the matrix saved by [`Self::keep`].
    pub(crate) fn restore(&mut self) {
        self.diagonal.copy_from_slice(&self.kept_diagonal);
        self.below.copy_from_slice(&self.kept_below);
    }

    /// Decomposes the matrix in place; returns `false` if it is not positive definite.
    pub(crate) fn factor(&mut self) -> bool {
        self.factor_above(0.0)
    }

    /// Decomposes the matrix in place. Returns `false` at the first pivot that does not exceed
    /// `least` or is not finite.
    pub(crate) fn factor_above(&mut self, least: f64) -> bool {
        let mut next = 0;
        for step in 0..self.before_hub() {
            // Constant sizes are faster.
            let eliminated = match self.sizes[step] {
                BLOCK => self.eliminate(step, BLOCK, least, &mut next),
                size => self.eliminate(step, size, least, &mut next),
            };
            if !eliminated {
                return false;
            }
        }
        let Some((first, hub)) = &mut self.hub else { return true };
        let rest = self.diagonal[*first..].iter().zip(&self.sizes[*first..]);
        for (k, (block, size)) in rest.enumerate() {
            let own = hub.block(k);
            *own = *block;
            (*size..BLOCK).for_each(|i| own[i][i] = 1.0);
        }
        hub.factor_above(least)
    }

    /// Number of elimination steps before those of the hub.
    fn before_hub(&self) -> usize {
        self.hub.as_ref().map_or(self.diagonal.len(), |(first, _)| *first)
    }

    /// Eliminates the block row of a step, of which `size` rows are in use. `next` is the index in
    /// [`Self::updates`] of the first product of this step. Returns `false` at the first pivot that
    /// does not exceed `least` or is not finite.
    #[inline(always)]
    fn eliminate(&mut self, step: usize, size: usize, least: f64, next: &mut usize) -> bool {
        let Self { diagonal, below, rows, updates, .. } = self;
        let mut inverse = UNIT;
        if !inverse_factor(&mut diagonal[step], &mut inverse, size, least) {
            return false;
        }
        let own = self.starts[step]..self.starts[step + 1];
        // Products change blocks of later steps only.
        let (blocks, after) = below.split_at_mut(own.end);
        let blocks = &mut blocks[own.start..];
        blocks.iter_mut().for_each(|block| multiply_lower(&inverse, block, size));
        for ((k, block), row) in blocks.iter().enumerate().zip(&rows[own.clone()]) {
            subtract_square(&mut diagonal[*row], block, size);
            for of_row in &blocks[k + 1..] {
                let to = &mut after[updates[*next] - own.end];
                subtract_product(to, (block, of_row), size);
                *next += 1;
            }
        }
        diagonal[step] = inverse;
        true
    }

    /// Returns the pivots of a block row after [`Self::factor`]: the diagonal entries of the row
    /// after the elimination of all previous rows.
    pub(crate) fn pivots(&self, block: usize) -> Part {
        let step = self.place[block];
        if let Some((first, hub)) = self.hub.as_ref().filter(|(first, _)| step >= *first) {
            return hub.pivots(step - first);
        }
        let inverse = &self.diagonal[step];
        core::array::from_fn(|k| inverse[k][k].powi(-2))
    }

    /// Solves for the right-hand side `vector` in place, after [`Self::factor`]. `vector` contains
    /// six components for each block row, in the row order of the matrix; components that
    /// [`Self::with_sizes`] excludes must be zero.
    pub(crate) fn solve(&mut self, vector: &mut [Part]) {
        let mut solution = core::mem::take(&mut self.solution);
        self.solve_with(vector, &mut solution);
        self.solution = solution;
    }

    /// Solves as [`Self::solve`], with `x` as the work space.
    pub(crate) fn solve_with(&self, vector: &mut [Part], x: &mut Vec<Part>) {
        x.resize(self.diagonal.len(), [0.0; BLOCK]);
        for (part, place) in vector.iter().zip(&self.place) {
            x[*place] = *part;
        }
        for step in 0..self.before_hub() {
            // Constant sizes are faster.
            match self.sizes[step] {
                BLOCK => self.substitute(step, BLOCK, x),
                size => self.substitute(step, size, x),
            }
        }
        if let Some((first, hub)) = &self.hub {
            hub.solve(&mut x[*first..]);
        }
        for step in (0..self.before_hub()).rev() {
            match self.sizes[step] {
                BLOCK => self.substitute_back(step, BLOCK, x),
                size => self.substitute_back(step, size, x),
            }
        }
        for (part, place) in vector.iter_mut().zip(&self.place) {
            *part = x[*place];
        }
    }

    /// Forward substitution with the block column of a step, of which `size` columns are in use.
    #[inline(always)]
    fn substitute(&self, step: usize, size: usize, x: &mut [Part]) {
        let own = lower_times(&self.diagonal[step], &x[step]);
        x[step] = own;
        let blocks = self.starts[step]..self.starts[step + 1];
        for (block, row) in self.below[blocks.clone()].iter().zip(&self.rows[blocks]) {
            // The row stays in registers.
            let mut other = x[*row];
            for (entries, amount) in block.iter().zip(own).take(size) {
                (0..BLOCK).for_each(|i| other[i] -= entries[i] * amount);
            }
            x[*row] = other;
        }
    }

    /// Back substitution with the block column of a step, of which `size` columns are in use.
    #[inline(always)]
    fn substitute_back(&self, step: usize, size: usize, x: &mut [Part]) {
        let mut own = x[step];
        let blocks = self.starts[step]..self.starts[step + 1];
        for (block, row) in self.below[blocks.clone()].iter().zip(&self.rows[blocks]) {
            let other = x[*row];
            for (own, entries) in own.iter_mut().zip(block).take(size) {
                *own -= dot(entries, &other);
            }
        }
        x[step] = upper_times(&self.diagonal[step], &own[..size.min(BLOCK)]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use nalgebra::{DMatrix, DVector};

    /// Checks the solution for a hub with chains around it against the dense matrix.
    #[test]
    fn agrees_with_a_dense_decomposition() {
        let mut random = Random::new(3);
        let pairs = [(0, 1), (1, 2), (0, 3), (3, 4), (0, 5), (5, 6), (4, 6), (2, 7)];
        let count = 8;
        let mut matrix = DMatrix::<f64>::zeros(BLOCK * count, BLOCK * count);
        for (a, b) in pairs.into_iter().chain((0..count).map(|k| (k, k))) {
            let block = DMatrix::from_fn(BLOCK, BLOCK, |_, _| random.number());
            // Products with their own transposes are positive semidefinite.
            let mut wide = DMatrix::zeros(BLOCK * count, BLOCK);
            wide.view_mut((BLOCK * a, 0), (BLOCK, BLOCK)).copy_from(&block);
            wide.view_mut((BLOCK * b, 0), (BLOCK, BLOCK)).copy_from(&(block.transpose() * 0.7));
            matrix += &wide * wide.transpose();
        }
        matrix += DMatrix::identity(BLOCK * count, BLOCK * count) * 0.1;
        let mut sparse = BlockCholesky::new(count, pairs.into_iter());
        for a in 0..count {
            for b in 0..=a {
                let Some(slot) = sparse.slot(a, b) else { continue };
                let (block, transposed) = sparse.block(slot);
                for i in 0..BLOCK {
                    for j in 0..BLOCK {
                        let (row, column) = if transposed { (j, i) } else { (i, j) };
                        block[row][column] = matrix[(BLOCK * a + i, BLOCK * b + j)];
                    }
                }
            }
        }
        assert!(sparse.factor());
        let right: Vec<Part> =
            (0..count).map(|_| core::array::from_fn(|_| random.number())).collect();
        let mut found = right.clone();
        sparse.solve(&mut found);
        let right = DVector::from_iterator(BLOCK * count, right.into_iter().flatten());
        let found = DVector::from_iterator(BLOCK * count, found.into_iter().flatten());
        let residual = (matrix * found - right).amax();
        assert!(residual < 1e-12, "{residual}");
    }

    #[test]
    fn indefinite_matrices_are_refused() {
        let mut sparse = BlockCholesky::new(2, [(0, 1)].into_iter());
        assert!(!sparse.factor());
    }
}
