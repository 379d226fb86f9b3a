//! Sparse system of the loop closures: `S = V W V^T`, where `V` has a row for each constraint at a
//! cut joint.
//!
//! `V` has a column for each DOF of the spanning tree. For projections, `V` is the constraint
//! Jacobian, and the diagonal matrix `W` contains one for each DOF that may change and zero for all
//! other DOFs. For accelerations, `V` is the constraint Jacobian after forward elimination of the
//! tree, and `W` is the diagonal matrix of the inverse pivots. The rows of one cut joint form a
//! block; `S` couples two blocks only if their loops share bodies. Many loops that share a single
//! body are decomposed in a particular form, see [`System`]. If constraints are redundant,
//! `S` is singular. A small multiple of a definite matrix is then added; the pivots of the sum show
//! which rows are dependent, and iterative refinement removes the error.

use super::system::System;
use crate::forward::constraint_jacobian::ConstraintRow;
use crate::linalg::{BLOCK, Part, Slot, add_outer, dot, largest};
use crate::topology::{Link, Role, Topology};

/// Fraction of the largest diagonal entry below which the diagonal entry of a row counts as
/// round-off.
const ZERO: f64 = 1e-20;
/// Size of the added definite matrix, relative to the scaled system with unit diagonal.
const ADDED: f64 = 1e-8;
/// Smallest pivot of an independent row, relative to the diagonal; pivots of dependent rows are
/// below [`DEPENDENT`].
const INDEPENDENT: f64 = 1e-5;
const DEPENDENT: f64 = 2e-7;
/// Smallest pivot above which a solution without an added matrix needs no iterative refinement. The
/// relative error of such a solution is the unit round-off divided by this pivot.
const REGULAR: f64 = 9e-4;
/// The iterative refinement ends if the residual is below this fraction of the right-hand side.
const SETTLED: f64 = 1e-15;
/// Largest number of refinement iterations.
const CORRECTIONS: usize = 6;

/// Set of DOFs for which the rows of a cut joint have nonzero entries.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::forward) enum Reach {
    /// DOFs on the path between the two bodies of the joint.
    Loop,
    /// DOFs on the paths from both bodies of the joint to the roots of their trees.
    Roots,
}

/// Symmetric positive definite matrix with one row and one column for each constraint row, in the
/// form of a function. The function calls its argument with each pair of rows that contributes, and
/// with the contribution to the entry of this pair.
pub(in crate::forward) type Definite<'a> = &'a dyn Fn(&mut dyn FnMut(Place, Place, f64));

/// Location of a constraint row in the system: index of the block, and index of the row in the
/// block.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::forward) struct Place {
    pub(in crate::forward) block: usize,
    pub(in crate::forward) row: usize,
}

/// Sparse system of the loop closures and its Cholesky factor.
#[derive(Clone, Debug)]
pub(in crate::forward) struct Closures {
    /// Location of each constraint row in the system; `None` for rows at joints of the spanning
    /// tree.
    pub(in crate::forward) places: Vec<Option<Place>>,
    /// Number of rows of each block.
    counts: Vec<usize>,
    /// Scale factor of each row that makes residuals of angles and lengths comparable.
    units: Vec<Part>,
    /// For each node, the index in `blocks` at which the list of the node starts. The last number
    /// is the length of `blocks`.
    starts: Vec<usize>,
    /// Concatenated lists, one for each node: the blocks that have nonzero entries for the DOFs of
    /// the node, in ascending order.
    blocks: Vec<usize>,
    /// For each node, the index in `slots` at which the list of the node starts. The list contains
    /// the slot of `matrix` for each pair of blocks in the list of the node in `blocks`; it is
    /// empty for a hub.
    pairs: Vec<usize>,
    slots: Vec<Slot>,
    /// For each DOF, the start of its column in `values`.
    firsts: Vec<usize>,
    /// Node of each DOF.
    nodes: Vec<usize>,
    /// Nonzero entries of `V`, column by column. For each DOF, there is one array per block with
    /// nonzero entries for this DOF, with one number per row of the block.
    values: Vec<Part>,
    /// Factor of each row that scales the diagonal of `S` to one.
    scales: Vec<Part>,
    weights: Vec<f64>,
    /// Norm of each row of the constraint Jacobian, see [`Self::set_size`].
    sizes: Vec<Part>,
    /// Diagonal of the added definite matrix, scaled like the system.
    diagonal: Vec<Part>,
    matrix: System,
    /// Factor of the added definite matrix; zero if no matrix is added.
    pub(in crate::forward) added: f64,
    /// Number of independent rows.
    pub(in crate::forward) rank: usize,
    /// Singularity index: smallest distance of an independent row from the span of the preceding
    /// rows, relative to the norm of the largest row; one if the system has no rows.
    pub(in crate::forward) distance: f64,
    /// Smallest pivot of an independent row in the scaled system, one if the system has no rows.
    least_pivot: f64,
}

/// Buffers of [`Closures::solve`].
#[derive(Clone, Debug, Default)]
pub(in crate::forward) struct Buffers {
    residual: Vec<Part>,
    solution: Vec<Part>,
    along: Vec<f64>,
    one: Vec<Part>,
}

impl Closures {
    /// Allocates the system for a topology.
    pub(in crate::forward) fn new(topology: &Topology, reach: Reach) -> Self {
        let mut of_node = vec![Vec::new(); topology.nodes.len()];
        for (block, cut) in topology.cuts.iter().enumerate() {
            match reach {
                Reach::Loop => cut.path.iter().for_each(|(node, _)| of_node[*node].push(block)),
                Reach::Roots => {
                    let (predecessor, successor) = topology.ends[cut.joint];
                    for body in [predecessor, successor] {
                        topology.ancestors(body).into_iter().for_each(|n| of_node[n].push(block));
                    }
                }
            }
        }
        let (mut starts, mut blocks) = (vec![0], Vec::new());
        for own in &mut of_node {
            own.dedup();
            blocks.extend_from_slice(own);
            starts.push(blocks.len());
        }
        let floats = |node: usize| matches!(topology.nodes[node].link, Link::Floating);
        let matrix = System::new(topology.cuts.len(), &of_node, floats);
        let (mut pairs, mut slots) = (vec![0], Vec::new());
        for (node, own) in of_node.iter().enumerate() {
            let own = if matrix.is_hub(node) { &[][..] } else { own };
            for (k, a) in own.iter().enumerate() {
                slots.extend(own[..=k].iter().filter_map(|b| matrix.slot(*a, *b)));
            }
            pairs.push(slots.len());
        }
        let (mut firsts, mut nodes, mut count) = (Vec::new(), Vec::new(), 0);
        for (index, node) in topology.nodes.iter().enumerate() {
            for _ in node.tree_dofs.clone() {
                firsts.push(count);
                nodes.push(index);
                count += of_node[index].len();
            }
        }
        Self {
            places: Vec::new(),
            counts: vec![0; topology.cuts.len()],
            units: vec![[1.0; BLOCK]; topology.cuts.len()],
            starts,
            blocks,
            pairs,
            slots,
            firsts,
            nodes,
            values: vec![[0.0; BLOCK]; count],
            scales: vec![[1.0; BLOCK]; topology.cuts.len()],
            weights: Vec::new(),
            sizes: vec![[0.0; BLOCK]; topology.cuts.len()],
            diagonal: vec![[0.0; BLOCK]; topology.cuts.len()],
            matrix,
            added: 0.0,
            rank: 0,
            distance: 1.0,
            least_pivot: 1.0,
        }
    }

    /// Returns the number of blocks.
    pub(in crate::forward) fn count(&self) -> usize {
        self.counts.len()
    }

    /// Assigns the constraint rows to blocks and sets all entries to zero. Returns false if a block
    /// has too many rows, or if a row is the constraint of a gearing.
    pub(in crate::forward) fn assign(
        &mut self,
        topology: &Topology,
        rows: &[ConstraintRow],
    ) -> bool {
        self.counts.fill(0);
        self.places.clear();
        for row in rows {
            if row.gearing.is_some() {
                return false;
            }
            let Role::Cut { cut: block } = topology.role[row.joint] else {
                self.places.push(None);
                continue;
            };
            let next = self.counts[block];
            if next == BLOCK {
                return false;
            }
            self.counts[block] += 1;
            self.units[block][next] = row.scale;
            self.places.push(Some(Place { block, row: next }));
        }
        self.values.fill([0.0; BLOCK]);
        self.sizes.fill([0.0; BLOCK]);
        true
    }

    /// Sets the norm of a row of the constraint Jacobian, with scales that make angles and lengths
    /// comparable. The scaled system does not show that a row vanishes, as rows of linkages do at
    /// dead centres.
    pub(in crate::forward) fn set_size(&mut self, at: Place, size: f64) {
        self.sizes[at.block][at.row] = size;
    }

    /// Adds `value` to the entry of `V` in the row at `at` and the column of a DOF.
    pub(in crate::forward) fn add(&mut self, tree_dof: usize, at: Place, value: f64) {
        let node = self.nodes[tree_dof];
        let own = &self.blocks[self.starts[node]..self.starts[node + 1]];
        if let Ok(k) = own.binary_search(&at.block) {
            self.values[self.firsts[tree_dof] + k][at.row] += value;
        }
    }

    /// Computes and factorises the system. `weights` contains the weight of each DOF, which is zero
    /// for excluded DOFs. Adds a small multiple of the matrix `definite` if rows are redundant.
    /// Returns false if the pivots do not clearly separate independent from dependent rows.
    pub(in crate::forward) fn factor(
        &mut self,
        weights: impl Iterator<Item = f64>,
        definite: Definite<'_>,
    ) -> bool {
        self.weights.clear();
        self.weights.extend(weights);
        self.scale();
        self.assemble();
        self.added = 0.0;
        self.matrix.keep();
        // The factorisation stops at the first dependent row. Detecting redundancy costs little
        // more than knowing it in advance, and the result depends only on the configuration.
        if self.matrix.factor_above(INDEPENDENT) {
            return self.count_independent(false);
        }
        self.matrix.restore();
        self.add_definite(definite);
        self.matrix.factor_above(0.0) && self.count_independent(true)
    }

    /// Computes the matrix of the system from the scaled rows.
    fn assemble(&mut self) {
        self.matrix.clear();
        for d in 0..self.weights.len() {
            let weight = self.weights[d];
            let node = self.nodes[d];
            let count = self.starts[node + 1] - self.starts[node];
            if weight == 0.0 || count == 0 {
                continue;
            }
            let own = &self.values[self.firsts[d]..self.firsts[d] + count];
            if self.matrix.is_hub(node) {
                let column = self.nodes[..d].iter().rev().take_while(|n| **n == node).count();
                let blocks = &self.blocks[self.starts[node]..];
                let entries = blocks.iter().copied().zip(own.iter().copied());
                self.matrix.set_column((column, weight), entries);
                continue;
            }
            let mut slots = self.slots[self.pairs[node]..self.pairs[node + 1]].iter();
            for (k, a) in own.iter().enumerate() {
                let weighted = a.map(|x| x * weight);
                for (b, slot) in own[..=k].iter().zip(&mut slots) {
                    match self.matrix.block(*slot) {
                        (block, false) => add_outer(block, &weighted, b),
                        (block, true) => add_outer(block, b, &weighted),
                    }
                }
            }
        }
        for (block, &count) in self.counts.iter().enumerate() {
            if let Some(slot) = self.matrix.slot(block, block) {
                let (own, _) = self.matrix.block(slot);
                (count..BLOCK).for_each(|k| own[k][k] = 1.0);
            }
        }
    }

    /// Adds a small multiple of the matrix `definite` to the system.
    fn add_definite(&mut self, definite: Definite<'_>) {
        let Self { scales, matrix, added, diagonal, .. } = self;
        let scale = |at: Place| scales[at.block][at.row];
        // A diagonal entry is the sum of the contributions of all joints along the loop.
        diagonal.fill([0.0; BLOCK]);
        definite(&mut |a, b, entry| {
            if a == b {
                diagonal[a.block][a.row] += (entry * scale(a) * scale(a)).abs();
            }
        });
        let largest = diagonal.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
        *added = ADDED / largest;
        definite(&mut |a, b, entry| {
            if let Some(slot) = matrix.slot(a.block, b.block) {
                let entry = *added * entry * scale(a) * scale(b);
                match matrix.block(slot) {
                    (block, false) => block[a.row][b.row] += entry,
                    (block, true) => block[b.row][a.row] += entry,
                }
            }
        });
    }

    /// Scales the rows so that the diagonal of the system is one.
    fn scale(&mut self) {
        self.scales.fill([0.0; BLOCK]);
        let Self { values, scales, units, weights, nodes, starts, blocks, firsts, .. } = self;
        for (d, weight) in weights.iter().enumerate() {
            let own = &blocks[starts[nodes[d]]..starts[nodes[d] + 1]];
            for (block, value) in own.iter().zip(&values[firsts[d]..]) {
                (0..BLOCK).for_each(|k| scales[*block][k] += weight * value[k] * value[k]);
            }
        }
        let units = || units.iter().flatten();
        let size = |(scale, unit): (&f64, &f64)| scale * unit * unit;
        let each = scales.iter().flatten().zip(units()).map(size);
        let largest = each.fold(f64::MIN_POSITIVE, f64::max);
        for (scale, unit) in scales.iter_mut().flatten().zip(units()) {
            // A larger scale would raise the round-off of a vanishing row to order one.
            *scale = if size((scale, unit)) > ZERO * largest {
                1.0 / scale.sqrt()
            } else {
                unit / largest.sqrt()
            };
        }
        for d in 0..weights.len() {
            let own = &blocks[starts[nodes[d]]..starts[nodes[d] + 1]];
            for (block, value) in own.iter().zip(&mut values[firsts[d]..]) {
                (0..BLOCK).for_each(|k| value[k] *= scales[*block][k]);
            }
        }
    }

    /// Counts the independent rows by their pivots, and sets `rank`, `distance` and `least_pivot`.
    /// Returns false if a pivot is neither large enough for an independent row nor small enough for
    /// a dependent row.
    fn count_independent(&mut self, some_dependent: bool) -> bool {
        let (mut distance, mut least, mut rank) = (1.0_f64, 1.0_f64, 0);
        let largest = self.sizes.iter().flatten().copied().fold(f64::MIN_POSITIVE, f64::max);
        for (block, &count) in self.counts.iter().enumerate() {
            let pivots = self.matrix.pivots(block);
            for (pivot, size) in pivots[..count].iter().zip(&self.sizes[block]) {
                if *pivot > INDEPENDENT {
                    least = least.min(*pivot);
                    distance = distance.min(pivot.sqrt() * size / largest);
                    rank += 1;
                } else if !some_dependent || *pivot > DEPENDENT || pivot.is_nan() {
                    return false;
                }
            }
        }
        (self.rank, self.distance, self.least_pivot) = (rank, distance, least);
        true
    }

    /// Multiplies a right-hand side in place by the scale factors of the rows. `right` has one
    /// array for each block.
    pub(in crate::forward) fn scaled(&self, right: &mut [Part]) {
        for (right, scale) in right.iter_mut().zip(&self.scales) {
            (0..BLOCK).for_each(|k| right[k] *= scale[k]);
        }
    }

    /// Returns the entry of a solution for the row at `at`, converted from scaled to physical
    /// units.
    pub(in crate::forward) fn unscaled(&self, solution: &[Part], at: Place) -> f64 {
        solution[at.block][at.row] * self.scales[at.block][at.row]
    }

    /// Adds `factor` times `V x` to `to`. The rows of `V` are scaled; `x` returns the entry for a
    /// DOF.
    pub(in crate::forward) fn add_product(
        &self,
        x: impl Fn(usize) -> f64,
        factor: f64,
        to: &mut [Part],
    ) {
        for d in 0..self.nodes.len() {
            let node = self.nodes[d];
            let own = &self.blocks[self.starts[node]..self.starts[node + 1]];
            if own.is_empty() {
                continue;
            }
            let amount = factor * x(d);
            for (block, value) in own.iter().zip(&self.values[self.firsts[d]..]) {
                (0..BLOCK).for_each(|k| to[*block][k] += amount * value[k]);
            }
        }
    }

    /// Returns the component of `V^T y` for a DOF of the spanning tree. The rows of `V` are scaled.
    pub(in crate::forward) fn along(&self, tree_dof: usize, y: &[Part]) -> f64 {
        let node = self.nodes[tree_dof];
        let own = &self.blocks[self.starts[node]..self.starts[node + 1]];
        let values = &self.values[self.firsts[tree_dof]..];
        own.iter().zip(values).map(|(block, value)| dot(value, &y[*block])).sum()
    }

    /// Adds `factor` times `S y` to `to`.
    pub(in crate::forward) fn add_system(
        &self,
        y: &[Part],
        factor: f64,
        to: &mut [Part],
        along: &mut Vec<f64>,
    ) {
        along.clear();
        along.extend((0..self.nodes.len()).map(|d| match self.weights[d] {
            0.0 => 0.0,
            weight => weight * self.along(d, y),
        }));
        self.add_product(|d| along[d], factor, to);
    }

    /// Solves `S y = right` and writes the solution to `right`. If `S` is singular, ignores the
    /// component of `right` outside the range of `S`, which is round-off.
    pub(in crate::forward) fn solve(&self, right: &mut [Part], buffers: &mut Buffers) {
        let Buffers { residual, solution, along, one } = buffers;
        let size = largest(right.as_flattened());
        if size == 0.0 {
            return;
        }
        residual.clear();
        residual.extend_from_slice(right);
        solution.clear();
        solution.resize(right.len(), [0.0; BLOCK]);
        let mut before = f64::INFINITY;
        if self.added == 0.0 && self.least_pivot > REGULAR {
            self.matrix.solve_with(right, one);
            return;
        }
        for _ in 0..CORRECTIONS {
            self.matrix.solve_with(residual, one);
            for (sum, change) in solution.iter_mut().zip(&*residual) {
                (0..BLOCK).for_each(|k| sum[k] += change[k]);
            }
            residual.copy_from_slice(right);
            self.add_system(solution, -1.0, residual, along);
            let left = largest(residual.as_flattened());
            // The remaining residual is round-off, or lies outside the range of `S`.
            if left <= SETTLED * size || left > 0.5 * before || left.is_nan() {
                break;
            }
            before = left;
        }
        right.copy_from_slice(solution);
    }

    /// Solves in place with the factorised matrix, including the added definite matrix, without
    /// iterative refinement.
    pub(in crate::forward) fn solve_once(&self, right: &mut [Part], buffers: &mut Buffers) {
        self.matrix.solve_with(right, &mut buffers.one);
    }
}
