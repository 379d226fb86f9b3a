//! Storage and Cholesky decomposition of the system of the loop closures.

use crate::linalg::{BLOCK, Block, BlockCholesky, HubCholesky, Part, Slot};

/// Number of loops that share one node from which [`System::Hub`] is used, if only one node is
/// shared.
const MANY: usize = 7;

/// System of the loop closures and its Cholesky decomposition.
#[derive(Clone, Debug)]
pub(super) enum System {
    /// Blocks of all pairs of loops that share a node.
    Blocks(Box<BlockCholesky>),
    /// Many loops that share only the DOFs of one node, such as a platform on many legs. Their
    /// pairs need no blocks.
    Hub { node: usize, matrix: HubCholesky },
}

impl System {
    /// Allocates the system of `count` loops. `of_node` contains the loops of each node, and
    /// `floats` tells whether the body of a node floats: definite matrices are added only for
    /// joints.
    pub(super) fn new(
        count: usize,
        of_node: &[Vec<usize>],
        floats: impl Fn(usize) -> bool,
    ) -> Self {
        let mut shared = (0..of_node.len()).filter(|&node| of_node[node].len() > 1);
        if let (Some(node), None) = (shared.next(), shared.next())
            && of_node[node].len() >= MANY
            && floats(node)
        {
            return Self::Hub { node, matrix: HubCholesky::new(count) };
        }
        let pairs = of_node.iter().flat_map(|own| {
            own.iter().enumerate().flat_map(move |(k, a)| own[..k].iter().map(move |b| (*a, *b)))
        });
        Self::Blocks(Box::new(BlockCholesky::new(count, pairs)))
    }

    /// Returns true if the DOFs of a node are columns of the low-rank matrix and have no blocks.
    pub(super) fn is_hub(&self, index: usize) -> bool {
        matches!(self, Self::Hub { node, .. } if *node == index)
    }

    /// Sets the entries of all loops for a DOF of the hub, and its weight. `column` is the index of
    /// the DOF in the hub. Has no effect without a hub.
    pub(super) fn set_column(
        &mut self,
        (column, weight): (usize, f64),
        entries: impl Iterator<Item = (usize, Part)>,
    ) {
        if let Self::Hub { matrix, .. } = self {
            matrix.set_column(column, weight, entries);
        }
    }

    /// Returns the location of a block, see [`BlockCholesky::slot`].
    pub(super) fn slot(&self, a: usize, b: usize) -> Option<Slot> {
        match self {
            Self::Blocks(matrix) => matrix.slot(a, b),
            Self::Hub { .. } => (a == b).then_some(Slot::Diagonal(a)),
        }
    }

    /// Returns the block at a location, see [`BlockCholesky::block`].
    pub(super) fn block(&mut self, slot: Slot) -> (&mut Block, bool) {
        match (self, slot) {
            (Self::Blocks(matrix), slot) => matrix.block(slot),
            // All blocks of such a system are diagonal, see [`Self::slot`].
            (Self::Hub { matrix, .. }, Slot::Diagonal(index) | Slot::Below { index, .. }) => {
                (matrix.block(index), false)
            }
        }
    }

    pub(super) fn clear(&mut self) {
        match self {
            Self::Blocks(matrix) => matrix.clear(),
            Self::Hub { matrix, .. } => matrix.clear(),
        }
    }

    pub(super) fn keep(&mut self) {
        match self {
            Self::Blocks(matrix) => matrix.keep(),
            Self::Hub { matrix, .. } => matrix.keep(),
        }
    }

    pub(super) fn restore(&mut self) {
        match self {
            Self::Blocks(matrix) => matrix.restore(),
            Self::Hub { matrix, .. } => matrix.restore(),
        }
    }

    /// Decomposes the system in place. Returns false at the first pivot that does not exceed
    /// `least`.
    pub(super) fn factor_above(&mut self, least: f64) -> bool {
        match self {
            Self::Blocks(matrix) => matrix.factor_above(least),
            Self::Hub { matrix, .. } => matrix.factor_above(least),
        }
    }

    pub(super) fn pivots(&self, block: usize) -> [f64; BLOCK] {
        match self {
            Self::Blocks(matrix) => matrix.pivots(block),
            Self::Hub { matrix, .. } => matrix.pivots(block),
        }
    }

    /// Solves for a right-hand side in place, with a buffer.
    pub(super) fn solve_with(&self, right: &mut [Part], buffer: &mut Vec<Part>) {
        match self {
            Self::Blocks(matrix) => matrix.solve_with(right, buffer),
            Self::Hub { matrix, .. } => matrix.solve(right),
        }
    }
}
