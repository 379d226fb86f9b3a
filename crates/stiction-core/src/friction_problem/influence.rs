//! Influence operator: maps friction unknowns to the joint wrenches of all friction interfaces.

use super::small_system::{Four, blocks_of, by_width};
use crate::scalar::{Lanes, Scalar};
use crate::spatial::{Vec3, Wrench};

/// Two numbers that are computed together in SIMD lanes.
pub(super) type Two = Lanes<f64, 2>;

/// Linear operator from friction unknowns, one or more per interface, to the wrenches at the joints
/// of the interfaces.
pub(crate) trait Influence {
    /// Calls `put(row, column, wrench)` for each pair of interface and unknown: `wrench` is the
    /// change of the total wrench at the joint of interface `row` per unit of unknown `column`.
    fn visit(&mut self, put: impl FnMut(usize, usize, Wrench<f64>));
}

/// Influence operator with one unknown per interface, stored as a matrix. Each interface has six
/// rows, one per component of the wrench at its joint (force first). The columns are in blocks of
/// four; the last block is padded with zeros.
#[derive(Clone, Debug, Default)]
pub(crate) struct InfluenceMatrix {
    count: usize,
    blocks: Vec<Four>,
}

impl InfluenceMatrix {
    /// Stores `operator`, which has `count` interfaces with one unknown each. Reuses the buffer.
    pub(super) fn store(&mut self, count: usize, operator: &mut impl Influence) {
        let width = blocks_of(count);
        self.count = count;
        self.blocks.clear();
        self.blocks.resize(6 * count * width, Four::zero());
        operator.visit(|row, column, Wrench { force, moment }| {
            let components = [force.x, force.y, force.z, moment.x, moment.y, moment.z];
            let rows = &mut self.blocks[6 * width * row..6 * width * (row + 1)];
            for (row, component) in rows.chunks_exact_mut(width).zip(components) {
                row[column / 4].0[column % 4] = component;
            }
        });
    }

    /// Stores an operator that has `count` interfaces with one unknown each. `of(row, block)`
    /// returns the wrench at the joint of interface `row` per unit of each of the four unknowns in
    /// `block`.
    pub(super) fn store_blocks(&mut self, count: usize, of: impl Fn(usize, usize) -> Wrench<Four>) {
        let width = blocks_of(count);
        self.count = count;
        self.blocks.resize(6 * count * width, Four::zero());
        for (row, rows) in self.blocks.chunks_exact_mut(6 * width).enumerate() {
            for block in 0..width {
                let Wrench { force, moment } = of(row, block);
                let components = [force.x, force.y, force.z, moment.x, moment.y, moment.z];
                for (row, component) in rows.chunks_exact_mut(width).zip(components) {
                    row[block] = component;
                }
            }
        }
    }

    /// Number of interfaces.
    pub(super) fn count(&self) -> usize {
        self.count
    }

    /// Wrench at the joint of an interface per unit of each of the unknowns `2 pair` and
    /// `2 pair + 1`.
    #[inline]
    pub(super) fn pair(&self, interface: usize, pair: usize) -> Wrench<Two> {
        let width = blocks_of(self.count);
        let rows = &self.blocks[6 * width * interface + pair / 2..][..5 * width + 1];
        let first = 2 * (pair % 2);
        let [a, b, c, d, e, f] = core::array::from_fn(|k| {
            let Lanes(row) = &rows[k * width];
            Lanes([row[first], row[first + 1]])
        });
        Wrench { force: Vec3::new(a, b, c), moment: Vec3::new(d, e, f) }
    }

    /// Iterates over the six rows of an interface (three force components, then three moment
    /// components). Each row consists of blocks of four columns.
    pub(super) fn rows(&self, interface: usize) -> impl Iterator<Item = &[Four]> {
        let width = blocks_of(self.count);
        self.blocks[6 * width * interface..6 * width * (interface + 1)].chunks_exact(width)
    }

    /// Computes the wrench at the joint of an interface for given values of the unknowns, which are
    /// in blocks of four.
    pub(super) fn apply(&self, interface: usize, unknowns: &[Four]) -> Wrench<f64> {
        let width = blocks_of(self.count);
        let rows = &self.blocks[6 * width * interface..6 * width * (interface + 1)];
        let mut sums = [0.0; 6];
        let fold = |lanes: Four| {
            let [a, b, c, d] = lanes.0;
            (a + b) + (c + d)
        };
        by_width!(
            width,
            W => {
                let (rows, _) = rows.as_chunks::<W>();
                if let (Some(rows), Some(x)) = (rows.first_chunk::<6>(), unknowns.first_chunk::<W>()) {
                    for (sum, row) in sums.iter_mut().zip(rows) {
                        let mut lanes = Four::zero();
                        for k in 0..W {
                            lanes += row[k] * x[k];
                        }
                        *sum = fold(lanes);
                    }
                }
            },
            for (sum, row) in sums.iter_mut().zip(rows.chunks_exact(width)) {
                let mut lanes = Four::zero();
                row.iter().zip(unknowns).for_each(|(u, x)| lanes += *u * *x);
                *sum = fold(lanes);
            }
        );
        let [force, moment] = [0, 3].map(|i| Vec3::new(sums[i], sums[i + 1], sums[i + 2]));
        Wrench { force, moment }
    }

    /// Writes to `sums` the linear combination of the six rows of an interface with `factors`.
    pub(super) fn combine(&self, interface: usize, factors: [f64; 6], sums: &mut [Four]) {
        let width = blocks_of(self.count);
        let rows = &self.blocks[6 * width * interface..6 * width * (interface + 1)];
        by_width!(
            width,
            W => {
                let (rows, _) = rows.as_chunks::<W>();
                if let (Some(rows), Some(sums)) =
                    (rows.first_chunk::<6>(), sums.first_chunk_mut::<W>())
                {
                    let mut total = [Four::zero(); W];
                    for (row, factor) in rows.iter().zip(factors) {
                        let factor = Four::from_f64(factor);
                        for k in 0..W {
                            total[k] += row[k] * factor;
                        }
                    }
                    *sums = total;
                }
            },
            {
                sums.fill(Four::zero());
                for (row, factor) in rows.chunks_exact(width).zip(factors) {
                    let factor = Four::from_f64(factor);
                    sums.iter_mut().zip(row).for_each(|(sum, u)| *sum += factor * *u);
                }
            }
        );
    }
}
