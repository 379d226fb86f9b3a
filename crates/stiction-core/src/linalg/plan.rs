//! Chooses the pivots of an elimination whose order stays fixed for all later values of the matrix.

use super::static_lu::StaticLu;
use std::collections::{BTreeMap, BTreeSet};

/// Row and column index of a matrix entry.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Entry {
    /// Row index.
    pub row: usize,
    /// Column index.
    pub column: usize,
}

/// Scale factors that make rows and columns of different units comparable. Pivots are selected by
/// the size of `row[i] * entry * column[j]`; the elimination itself does not use the factors.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Scales<'a> {
    /// One factor for each row; an empty slice means that all factors are one.
    pub rows: &'a [f64],
    /// One factor for each column; an empty slice means that all factors are one.
    pub columns: &'a [f64],
}

#[cfg(test)]
impl Scales<'_> {
    /// Leaves the matrix unscaled: all factors are one.
    pub(crate) const NONE: Self = Self { rows: &[], columns: &[] };
}

/// Pivots for all columns of a matrix, with the nonzero pattern for which they were chosen.
#[derive(Clone, Debug)]
pub(crate) struct Plan {
    pub(super) rows: usize,
    pub(super) columns: usize,
    pub(super) entries: Vec<Entry>,
    /// Row and column of each pivot, in the order of elimination.
    pub(super) pivots: Vec<(usize, usize)>,
    /// Magnitude of the smallest scaled pivot.
    pub smallest_pivot: f64,
}

/// Error: some columns of a matrix depend on the others.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct RankDeficient {
    /// Columns without a pivot.
    pub columns: Vec<usize>,
}

/// Smallest admissible pivot, as a fraction of the largest entry in its column. A larger threshold
/// is more accurate; a smaller threshold admits more pivots that keep the factors sparse.
const THRESHOLD: f64 = 0.25;
/// Scaled entries below this fraction of the largest entry of the matrix count as round-off.
const NEGLIGIBLE: f64 = 1e-11;
/// Number of candidate columns for each pivot. The candidates are the columns with the fewest
/// entries in rows that are not yet eliminated.
const CANDIDATES: usize = 4;

impl Plan {
    /// Chooses a pivot for each column by size and by fill-in (Markowitz 1957, with a threshold),
    /// based on the values `numbers` of one representative matrix. Every listed entry is
    /// structurally nonzero, even if its value is zero. Repeated entries are added.
    ///
    /// # Errors
    /// Returns [`RankDeficient`] if some columns depend on the others.
    pub(crate) fn new(
        rows: usize,
        columns: usize,
        entries: &[Entry],
        numbers: &[f64],
        scales: Scales<'_>,
    ) -> Result<Self, RankDeficient> {
        let factor = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(1.0);
        let mut active = Active::new(rows, columns);
        for (entry, number) in entries.iter().zip(numbers) {
            let scale = factor(scales.rows, entry.row) * factor(scales.columns, entry.column);
            active.add(entry.row, entry.column, number * scale);
        }
        let negligible = NEGLIGIBLE * active.largest();
        let mut pivots = Vec::with_capacity(columns);
        let mut smallest_pivot = f64::INFINITY;
        while let Some((row, column)) = active.choose(negligible) {
            smallest_pivot = smallest_pivot.min(active.eliminate(row, column).abs());
            pivots.push((row, column));
        }
        if pivots.len() < columns {
            return Err(RankDeficient { columns: active.open_columns() });
        }
        Ok(Self { rows, columns, entries: entries.to_vec(), pivots, smallest_pivot })
    }

    /// Compiles the plan to a [`StaticLu`], which eliminates in the order of the plan.
    pub(crate) fn compile(&self) -> StaticLu {
        StaticLu::compile(self)
    }
}

/// Part of the matrix whose rows and columns are not yet eliminated.
struct Active {
    rows: Vec<BTreeMap<usize, f64>>,
    /// For each column, the rows that are not yet eliminated and have an entry in the column.
    columns: Vec<BTreeSet<usize>>,
    /// Columns that are not yet eliminated, in ascending order of (number of remaining rows with an
    /// entry, column index). This order avoids a search over all columns for each pivot.
    open: BTreeSet<(usize, usize)>,
}

impl Active {
    fn new(rows: usize, columns: usize) -> Self {
        Self {
            rows: vec![BTreeMap::new(); rows],
            columns: vec![BTreeSet::new(); columns],
            open: (0..columns).map(|column| (0, column)).collect(),
        }
    }

    fn add(&mut self, row: usize, column: usize, number: f64) {
        *self.rows[row].entry(column).or_insert(0.0) += number;
        let count = self.columns[column].len();
        if self.columns[column].insert(row) {
            self.open.remove(&(count, column));
            self.open.insert((count + 1, column));
        }
    }

    /// Removes a row from the list of remaining rows of a column that is not yet eliminated.
    fn close_row(&mut self, row: usize, column: usize) {
        let count = self.columns[column].len();
        if self.columns[column].remove(&row) {
            self.open.remove(&(count, column));
            self.open.insert((count - 1, column));
        }
    }

    fn largest(&self) -> f64 {
        self.rows.iter().flat_map(BTreeMap::values).fold(0.0, |max, x| x.abs().max(max))
    }

    fn open_columns(&self) -> Vec<usize> {
        let mut columns: Vec<usize> = self.open.iter().map(|&(_, column)| column).collect();
        columns.sort_unstable();
        columns
    }

    /// Returns the row and column of the best pivot in the candidate columns; `None` if no column
    /// has an entry above `negligible`.
    fn choose(&self, negligible: f64) -> Option<(usize, usize)> {
        let mut best: Option<(usize, f64, usize, usize)> = None;
        let mut seen = 0;
        for &(count, column) in &self.open {
            let size = |row: &usize| self.rows[*row].get(&column).map_or(0.0, |x| x.abs());
            let largest = self.columns[column].iter().map(size).fold(0.0, f64::max);
            if largest.is_nan() || largest <= negligible {
                continue;
            }
            for &row in &self.columns[column] {
                let magnitude = size(&row);
                if magnitude < THRESHOLD * largest {
                    continue;
                }
                let fill = (self.rows[row].len() - 1) * (count - 1);
                let better = best.is_none_or(|(least, size, ..)| {
                    fill < least || (fill == least && magnitude > size)
                });
                if better {
                    best = Some((fill, magnitude, row, column));
                }
            }
            seen += 1;
            if seen == CANDIDATES {
                break;
            }
        }
        best.map(|(_, _, row, column)| (row, column))
    }

    /// Eliminates a column with the given pivot and removes the pivot's row and column from the
    /// remaining matrix. Returns the value of the pivot.
    fn eliminate(&mut self, row: usize, column: usize) -> f64 {
        let pivot_row = core::mem::take(&mut self.rows[row]);
        // The remaining rows have entries only in columns that are not yet eliminated.
        for &other in pivot_row.keys() {
            self.close_row(row, other);
        }
        self.open.remove(&(self.columns[column].len(), column));
        let pivot = pivot_row[&column];
        for target in core::mem::take(&mut self.columns[column]) {
            let factor = self.rows[target].remove(&column).unwrap_or(0.0) / pivot;
            for (&other, &number) in pivot_row.iter().filter(|(c, _)| **c != column) {
                self.add(target, other, -factor * number);
            }
        }
        pivot
    }
}
