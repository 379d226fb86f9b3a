//! Instrumental variables: the regression uses only the part of each column that the instruments
//! explain, so that errors of the measured motion do not bias the estimate.
//!
//! Equation (I11) of the book's theory. Source: Söderström, Stoica, *Instrumental variable methods for system
//! identification*, Springer (1983); for robots Janot, Vandanjon, Gautier, *A generic instrumental variable approach for
//! industrial robot identification*, IEEE Trans. Control Systems Technology 22 (2014).

use super::Problem;
use super::map::transposed_product;
use crate::block::Block;
use crate::rows::Rows;
use nalgebra::{DMatrix, SymmetricEigen};
use std::borrow::Cow;

/// A direction counts as round-off if its eigenvalue is at most this fraction of the largest one.
/// The eigenvalues are those of the instruments' normal matrix, scaled to a unit diagonal.
const NEGLIGIBLE: f64 = 1e-12;

impl Problem<'_> {
    /// Fits the columns `W` by the instruments `Z` with the weights `D` and returns the coefficients
    /// of the instruments, `(Z^T D Z)^+ Z^T D W`. `None` if there are no instruments.
    pub(super) fn projection(
        &self,
        noise: &[f64],
        weights: &[Vec<Vec<f64>>],
    ) -> Option<DMatrix<f64>> {
        if !self.blocks.iter().flat_map(|b| &b.channels).any(|rows| rows.instruments.is_some()) {
            return None;
        }
        let size = self.parameters.len();
        let [mut own, mut cross] = [DMatrix::zeros(size, size), DMatrix::zeros(size, size)];
        for (block, weights) in self.blocks.iter().zip(weights) {
            for ((rows, weights), noise) in block.channels.iter().zip(weights).zip(noise) {
                let mut weighted = instruments(rows).clone();
                for (row, weight) in weights.iter().enumerate() {
                    weighted.row_mut(row).scale_mut(weight * block.independence / (noise * noise));
                }
                own += transposed_product(&weighted, instruments(rows));
                cross += transposed_product(&weighted, &rows.matrix);
            }
        }
        let scale = own.diagonal().map(|d| if d > 0.0 { d.sqrt().recip() } else { 0.0 });
        let unit = DMatrix::from_fn(size, size, |i, k| own[(i, k)] * scale[i] * scale[k]);
        if !unit.iter().chain(&cross).all(|x| x.is_finite()) {
            // The decomposition of numbers that are not finite would not end. Without a design no
            // parameter is identified.
            return Some(DMatrix::zeros(size, size));
        }
        let eigen = SymmetricEigen::new((&unit + unit.transpose()) * 0.5);
        let largest = eigen.eigenvalues.max();
        let inverse = eigen.eigenvalues.map(|value| match value > NEGLIGIBLE * largest {
            true => value.recip(),
            false => 0.0,
        });
        let scaled = DMatrix::from_fn(size, size, |i, k| scale[i] * cross[(i, k)]);
        let mut along = eigen.eigenvectors.tr_mul(&scaled);
        along.row_iter_mut().zip(inverse.iter()).for_each(|(mut row, factor)| row *= *factor);
        let solution = &eigen.eigenvectors * along;
        Some(DMatrix::from_fn(size, size, |i, k| scale[i] * solution[(i, k)]))
    }

    /// Returns the blocks for the normal equations. If there are instruments, each column is
    /// replaced by the part of it that the instruments explain, and rows without instruments become
    /// zero.
    pub(super) fn design(&self, projection: Option<&DMatrix<f64>>) -> Cow<'_, [Block]> {
        let Some(projection) = projection else { return Cow::Borrowed(self.blocks) };
        let mut blocks = self.blocks.to_vec();
        for rows in blocks.iter_mut().flat_map(|block| &mut block.channels) {
            let empty = rows.rows_without_instruments();
            rows.matrix = instruments(rows) * projection;
            empty.into_iter().for_each(|row| rows.right[row] = 0.0);
        }
        Cow::Owned(blocks)
    }
}

/// Returns the instruments of `rows`; without instruments, returns the columns of `rows`.
fn instruments(rows: &Rows) -> &DMatrix<f64> {
    rows.instruments.as_ref().unwrap_or(&rows.matrix)
}
