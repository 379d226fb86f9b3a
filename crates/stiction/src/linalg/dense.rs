//! Dense decompositions for analysis.

use nalgebra::{DMatrix, DVector};

/// An orthonormal basis of the vectors that `matrix` maps to nothing: right singular vectors whose
/// singular values are at most `negligible` times the largest.
pub fn null_space(matrix: &DMatrix<f64>, negligible: f64) -> Vec<DVector<f64>> {
    let columns = matrix.ncols();
    if columns == 0 {
        return Vec::new();
    }
    // The decomposition gives as many right vectors as there are rows: fill up with zero rows.
    let mut square = DMatrix::zeros(matrix.nrows().max(columns), columns);
    square.rows_mut(0, matrix.nrows()).copy_from(matrix);
    let svd = square.svd(false, true);
    let Some(right) = svd.v_t else { return Vec::new() };
    let largest = svd.singular_values.max();
    (0..columns)
        .filter(|&k| svd.singular_values[k] <= negligible * largest)
        .map(|k| right.row(k).transpose())
        .collect()
}
