//! Sparse matrices in compressed column storage.

use crate::disjoint_sets::DisjointSets;
use nalgebra::DMatrix;

/// Sparse matrix in compressed column storage; the row indices of a column are distinct and in
/// ascending order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SparseMatrix {
    rows: usize,
    /// Index of the first entry of each column, followed by the number of entries.
    starts: Vec<usize>,
    indices: Vec<usize>,
    values: Vec<f64>,
}

impl SparseMatrix {
    /// Builds a matrix from entries `(row, column, value)`. Entries with the same indices are
    /// added; zero entries are dropped.
    pub fn new(
        (rows, columns): (usize, usize),
        entries: impl Iterator<Item = (usize, usize, f64)>,
    ) -> Self {
        // Most entries are not zero.
        let mut own = Vec::with_capacity(entries.size_hint().1.unwrap_or(0));
        own.extend(entries.filter(|(.., value)| *value != 0.0));
        let entries: Vec<(usize, usize, f64)> = own;
        let mut starts = vec![0; columns + 1];
        entries.iter().for_each(|(_, column, _)| starts[column + 1] += 1);
        for column in 0..columns {
            starts[column + 1] += starts[column];
        }
        let mut places = vec![(0, 0.0); entries.len()];
        let mut next = starts.clone();
        for (row, column, value) in entries {
            places[next[column]] = (row, value);
            next[column] += 1;
        }
        let mut made = Self {
            rows,
            starts: Vec::with_capacity(columns + 1),
            indices: Vec::with_capacity(places.len()),
            values: Vec::with_capacity(places.len()),
        };
        made.starts.push(0);
        for column in 0..columns {
            let own = &mut places[starts[column]..starts[column + 1]];
            // The sort is stable, so sums of entries with the same indices do not depend on other
            // entries.
            own.sort_by_key(|(row, _)| *row);
            for (k, &(row, value)) in own.iter().enumerate() {
                match made.values.last_mut() {
                    Some(sum) if k > 0 && own[k - 1].0 == row => *sum += value,
                    _ => {
                        made.indices.push(row);
                        made.values.push(value);
                    }
                }
            }
            made.starts.push(made.values.len());
        }
        made
    }

    /// Number of entries.
    pub(crate) fn count(&self) -> usize {
        self.values.len()
    }

    /// Number of rows.
    pub fn nrows(&self) -> usize {
        self.rows
    }

    /// Number of columns.
    pub fn ncols(&self) -> usize {
        self.starts.len() - 1
    }

    /// Yields the row indices and values of the entries of a column, in ascending row order.
    pub fn column(&self, column: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.starts[column]..self.starts[column + 1];
        self.indices[range.clone()].iter().copied().zip(self.values[range].iter().copied())
    }

    /// Yields all entries as `(row, column, value)`, column by column.
    pub fn entries(&self) -> impl Iterator<Item = (usize, usize, f64)> + '_ {
        (0..self.ncols()).flat_map(|k| self.column(k).map(move |(row, value)| (row, k, value)))
    }

    /// Returns the matrix with row `i` multiplied by `rows[i]` and column `k` multiplied by
    /// `columns[k]`.
    #[must_use]
    pub fn scaled(&self, rows: &[f64], columns: &[f64]) -> Self {
        let mut scaled = self.clone();
        for (column, factor) in columns.iter().enumerate() {
            for k in self.starts[column]..self.starts[column + 1] {
                // Multiply in the same order as for dense matrices, so that the products are
                // identical.
                scaled.values[k] = self.values[k] * rows[self.indices[k]] * factor;
            }
        }
        scaled
    }

    /// Returns the matrix that consists of the columns with the given indices, in the given order.
    #[must_use]
    pub fn select_columns(&self, columns: &[usize]) -> Self {
        let each = columns.iter().enumerate();
        let entries = each
            .flat_map(|(to, &from)| self.column(from).map(move |(row, value)| (row, to, value)));
        Self::new((self.rows, columns.len()), entries)
    }

    /// Returns the square matrix of the rows and columns with the given indices, in ascending order.
    #[must_use]
    pub(crate) fn select(&self, indices: &[usize]) -> Self {
        let entries = indices.iter().enumerate().flat_map(|(to, &from)| {
            let of_row = move |(row, value)| Some((indices.binary_search(&row).ok()?, to, value));
            self.column(from).filter_map(of_row)
        });
        Self::new((indices.len(), indices.len()), entries)
    }

    /// Splits the matrix into blocks that have no rows or columns in common, ordered by their first
    /// columns. The blocks contain all columns and all rows with entries, in the order of the
    /// matrix.
    pub(crate) fn independent_blocks(&self) -> Vec<Self> {
        // Columns with entries in the same row belong to one block.
        let mut sets = DisjointSets::new(self.ncols());
        let mut column_of = vec![None; self.rows];
        for (row, column, _) in self.entries() {
            let &mut other = column_of[row].get_or_insert(column);
            sets.unite(other, column);
        }
        let mut block_of = vec![0; self.ncols()];
        let mut blocks: Vec<(usize, Vec<usize>)> = Vec::new();
        for column in 0..self.ncols() {
            let first = sets.least(column);
            if first == column {
                block_of[column] = blocks.len();
                blocks.push((0, Vec::new()));
            }
            block_of[column] = block_of[first];
            blocks[block_of[column]].1.push(column);
        }
        // Place of each row in its block.
        let mut places = vec![0; self.rows];
        for (place, column) in places.iter_mut().zip(column_of) {
            if let Some(column) = column {
                let (rows, _) = &mut blocks[block_of[column]];
                *place = *rows;
                *rows += 1;
            }
        }
        let each = blocks.into_iter().map(|(rows, columns)| {
            let of_column = |(to, &from): (usize, &usize)| {
                let own = self.column(from);
                own.map(|(row, value)| (places[row], to, value)).collect::<Vec<_>>()
            };
            let entries = columns.iter().enumerate().flat_map(of_column);
            Self::new((rows, columns.len()), entries)
        });
        each.collect()
    }

    /// Returns the transposed matrix.
    #[must_use]
    pub fn transpose(&self) -> Self {
        let mut starts = vec![0; self.rows + 1];
        self.indices.iter().for_each(|row| starts[row + 1] += 1);
        for row in 0..self.rows {
            starts[row + 1] += starts[row];
        }
        let (mut indices, mut values) = (vec![0; self.count()], vec![0.0; self.count()]);
        let mut next = starts.clone();
        for (row, column, value) in self.entries() {
            (indices[next[row]], values[next[row]]) = (column, value);
            next[row] += 1;
        }
        Self { rows: self.ncols(), starts, indices, values }
    }

    /// Returns the product with a vector.
    pub fn times(&self, vector: &[f64]) -> Vec<f64> {
        let mut product = vec![0.0; self.rows];
        for (column, amount) in vector.iter().enumerate() {
            if *amount != 0.0 {
                self.column(column).for_each(|(row, value)| product[row] += value * amount);
            }
        }
        product
    }

    /// Returns the product with a vector that has the given components.
    pub(crate) fn times_sparse(&self, vector: &[(usize, f64)]) -> Vec<f64> {
        let mut product = vec![0.0; self.rows];
        for &(column, amount) in vector {
            self.column(column).for_each(|(row, value)| product[row] += value * amount);
        }
        product
    }

    /// Returns the product of the transposed matrix with a vector.
    pub fn transposed_times(&self, vector: &[f64]) -> Vec<f64> {
        let product = |k| self.column(k).map(|(row, value)| value * vector[row]).sum();
        (0..self.ncols()).map(product).collect()
    }

    /// Returns the dense product with the transposed matrix: the sum of the outer products of the
    /// columns with themselves.
    pub fn times_transposed(&self) -> DMatrix<f64> {
        let mut product = DMatrix::zeros(self.rows, self.rows);
        for k in 0..self.ncols() {
            for (column, factor) in self.column(k) {
                let mut target = product.column_mut(column);
                self.column(k).for_each(|(row, value)| target[row] += value * factor);
            }
        }
        product
    }

    /// Returns the matrix in dense storage.
    pub fn to_dense(&self) -> DMatrix<f64> {
        let mut matrix = DMatrix::zeros(self.rows, self.ncols());
        self.entries().for_each(|(row, column, value)| matrix[(row, column)] = value);
        matrix
    }
}

#[cfg(test)]
mod tests {
    use super::SparseMatrix;

    /// Checks the blocks of a matrix with interleaved rows, an empty row and an empty column.
    #[test]
    fn independent_blocks_have_all_entries() {
        let entries = [(0, 0, 1.0), (4, 0, 2.0), (1, 1, 3.0), (4, 3, 4.0), (0, 3, 5.0)];
        let matrix = SparseMatrix::new((5, 4), entries.into_iter());
        let blocks = matrix.independent_blocks();
        let expected = [
            SparseMatrix::new(
                (2, 2),
                [(0, 0, 1.0), (1, 0, 2.0), (1, 1, 4.0), (0, 1, 5.0)].into_iter(),
            ),
            SparseMatrix::new((1, 1), [(0, 0, 3.0)].into_iter()),
            SparseMatrix::new((0, 1), [].into_iter()),
        ];
        assert_eq!(blocks, expected);
    }
}
