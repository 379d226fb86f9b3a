//! Rank-revealing triangular factor of a sparse matrix.
//!
//! Computes the factor `R` of `A P = Q R` by Householder reflections of dense frontal matrices
//! (Duff and Reid 1983), without storing `Q`. A column is dependent if its remainder after the
//! elimination of other columns is zero; `R` has no row for such a column (Heath 1982).

use super::elimination_order::EliminationOrder;
use super::sparse::SparseMatrix;

/// Order in which groups of columns are eliminated, for all matrices with the same nonzero pattern.
#[derive(Clone, Debug)]
pub(crate) struct ColumnOrder {
    /// Columns in the order of their elimination.
    columns: Vec<usize>,
    /// Position of each column in `columns`.
    places: Vec<usize>,
    /// Elimination step of each entry of `columns`. The columns of a group have the same step.
    steps: Vec<usize>,
}

impl ColumnOrder {
    /// Orders the columns of a matrix. `groups` contains a group index for each column; the columns
    /// of a group are eliminated together.
    pub(crate) fn new(matrix: &SparseMatrix, groups: &[usize]) -> Self {
        let count = groups.iter().max().map_or(0, |last| last + 1);
        let rows = matrix.transpose();
        let mut pairs = Vec::new();
        let (mut own, mut before) = (Vec::new(), Vec::new());
        for row in 0..rows.ncols() {
            own.clear();
            own.extend(rows.column(row).map(|(column, _)| groups[column]));
            own.sort_unstable();
            own.dedup();
            // The equations of one body often have the same groups.
            if own != before {
                for (k, &a) in own.iter().enumerate() {
                    pairs.extend(own[k + 1..].iter().map(|&b| (a, b)));
                }
                core::mem::swap(&mut own, &mut before);
            }
        }
        let order = EliminationOrder::new(count, pairs.into_iter());
        let mut members = vec![Vec::new(); count];
        groups.iter().enumerate().for_each(|(column, group)| members[*group].push(column));
        let mut made =
            Self { columns: Vec::new(), places: vec![0; groups.len()], steps: Vec::new() };
        for (step, group) in order.nodes.iter().enumerate() {
            for &column in &members[*group] {
                made.places[column] = made.columns.len();
                made.columns.push(column);
                made.steps.push(step);
            }
        }
        made
    }

    /// Orders the columns of a matrix individually: each column is a group.
    pub(crate) fn one_by_one(matrix: &SparseMatrix) -> Self {
        Self::new(matrix, &(0..matrix.ncols()).collect::<Vec<_>>())
    }

    /// Adds one column, which is eliminated last.
    pub(crate) fn followed_by_one(mut self) -> Self {
        let step = self.steps.last().map_or(0, |last| last + 1);
        self.places.push(self.columns.len());
        self.columns.push(self.columns.len());
        self.steps.push(step);
        self
    }
}

/// Triangular factor `R` of a sparse matrix, with rows in the order of elimination.
#[derive(Clone, Debug)]
pub(crate) struct SparseQr {
    columns: usize,
    /// Column of the first entry (the pivot) of each row.
    pivots: Vec<usize>,
    /// Dependent columns, in ascending order.
    dependent: Vec<usize>,
    /// Index in `values` of the first entry of each row, followed by the number of entries.
    starts: Vec<usize>,
    /// Column index of each entry, row by row.
    indices: Vec<usize>,
    /// Value of each entry, row by row.
    values: Vec<f64>,
    /// Frobenius norm of the remainders of the dependent columns, which are set to zero.
    dropped: f64,
}

/// Frontal matrix: dense rows whose nonzero entries lie in a few columns.
#[derive(Default)]
struct Front {
    /// Positions of the front's columns in [`ColumnOrder::columns`], ascending.
    places: Vec<usize>,
    rows: usize,
    /// Entries of the front in column-major order.
    values: Vec<f64>,
}

impl SparseQr {
    /// Factorises a matrix. A column counts as dependent if the norm of its remainder is at most
    /// `negligible`.
    pub(crate) fn new(matrix: &SparseMatrix, order: &ColumnOrder, negligible: f64) -> Self {
        let steps = order.steps.last().map_or(0, |last| last + 1);
        let mut fronts = Fronts::new(matrix, order, steps);
        let mut waiting: Vec<Vec<Front>> = (0..steps).map(|_| Vec::new()).collect();
        let mut made = Self {
            columns: matrix.ncols(),
            pivots: Vec::new(),
            dependent: Vec::new(),
            starts: vec![0],
            indices: Vec::with_capacity(2 * matrix.count()),
            values: Vec::with_capacity(2 * matrix.count()),
            dropped: 0.0,
        };
        let mut place = 0;
        for step in 0..steps {
            let own = place..order.steps.partition_point(|s| *s <= step);
            let parts = core::mem::take(&mut waiting[step]);
            let mut front = fronts.merged(step, own.clone(), order, parts);
            let pivots = made.eliminate(&mut front, own.len(), order, negligible);
            place = own.end;
            let rest = fronts.remainder(front, pivots, own.len());
            match rest.places.first() {
                Some(first) if rest.rows > 0 => waiting[order.steps[*first]].push(rest),
                _ => fronts.spare.push(rest),
            }
        }
        made.dropped = made.dropped.sqrt();
        made.dependent.sort_unstable();
        made
    }

    /// Eliminates the first `own` columns of a front, the column with the largest remainder first.
    /// Returns the number of rows added to the factor.
    fn eliminate(
        &mut self,
        front: &mut Front,
        own: usize,
        order: &ColumnOrder,
        negligible: f64,
    ) -> usize {
        let mut pivots = 0;
        for done in 0..own {
            let (best, norm) = (done..own)
                .map(|k| (k, front.norm(k, pivots)))
                .fold((done, 0.0), |a, b| if b.1 > a.1 { b } else { a });
            // NaN also ends the elimination; the NaN values remain visible in the factor.
            if norm <= negligible || pivots == front.rows {
                for k in done..own {
                    self.dropped += front.norm(k, pivots).powi(2);
                    self.dependent.push(order.columns[front.places[k]]);
                }
                break;
            }
            front.swap(done, best);
            // Columns that are not yet eliminated remain among the first `own` columns.
            front.reflect(done, pivots, norm);
            pivots += 1;
        }
        for row in 0..pivots {
            self.pivots.push(order.columns[front.places[row]]);
            for k in row..front.places.len() {
                let value = front.values[k * front.rows + row];
                if value != 0.0 {
                    self.indices.push(order.columns[front.places[k]]);
                    self.values.push(value);
                }
            }
            self.starts.push(self.values.len());
        }
        pivots
    }

    /// Returns the number of independent columns.
    pub(crate) fn rank(&self) -> usize {
        self.pivots.len()
    }

    /// Returns the indices of the dependent columns, in ascending order.
    pub(crate) fn dependent(&self) -> &[usize] {
        &self.dependent
    }

    /// Returns the Frobenius norm of the remainders of the dependent columns. The norm is an upper
    /// bound on the singular values that count as zero.
    pub(crate) fn dropped(&self) -> f64 {
        self.dropped
    }

    /// Yields the magnitudes of the diagonal entries: the norms of the remainders of the independent
    /// columns.
    pub(crate) fn diagonal(&self) -> impl Iterator<Item = f64> + '_ {
        (0..self.rank()).map(|row| self.values[self.starts[row]].abs())
    }

    /// Yields the column indices and values of a row of `R`, the pivot first.
    fn row(&self, row: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let range = self.starts[row]..self.starts[row + 1];
        self.indices[range.clone()].iter().copied().zip(self.values[range].iter().copied())
    }

    /// Returns the transposed factor, which has one column for each row of the factor.
    pub(crate) fn transposed(&self) -> SparseMatrix {
        let entries = (0..self.rank())
            .flat_map(|row| self.row(row).map(move |(column, value)| (column, row, value)));
        SparseMatrix::new((self.columns, self.rank()), entries)
    }

    /// Solves `R x = y` with zero for the unknowns of dependent columns. `y` has one value for each
    /// row of `R`, `x` one value for each column.
    pub(crate) fn solve(&self, y: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; self.columns];
        for row in (0..self.rank()).rev() {
            let mut entries = self.row(row);
            let Some((pivot, diagonal)) = entries.next() else { continue };
            let sum: f64 = entries.map(|(column, value)| value * x[column]).sum();
            x[pivot] = (y[row] - sum) / diagonal;
        }
        x
    }

    /// Solves the equations of `R^T y = x` that belong to independent columns. `x` has one value
    /// for each column of `R`, `y` one value for each row.
    pub(crate) fn solve_transposed(&self, mut x: Vec<f64>) -> Vec<f64> {
        let mut y = vec![0.0; self.rank()];
        for row in 0..self.rank() {
            let mut entries = self.row(row);
            let Some((pivot, diagonal)) = entries.next() else { continue };
            y[row] = x[pivot] / diagonal;
            entries.for_each(|(column, value)| x[column] -= value * y[row]);
        }
        y
    }

    /// Computes the least-squares solution of the equations whose matrix is the factorised one
    /// without its last column; this column is their right-hand side and must be eliminated last.
    pub(crate) fn solution_for_last(&self) -> Vec<f64> {
        let last = self.columns - 1;
        let mut x = vec![0.0; self.columns];
        x[last] = -1.0;
        for row in (0..self.rank()).rev().filter(|row| self.pivots[*row] != last) {
            let mut entries = self.row(row);
            let Some((pivot, diagonal)) = entries.next() else { continue };
            x[pivot] = -entries.map(|(column, value)| value * x[column]).sum::<f64>() / diagonal;
        }
        x.truncate(last);
        x
    }

    /// Computes a basis of the null space, with one vector for each dependent column. Each vector
    /// is a list of pairs of column index and value. It contains its dependent column with the
    /// value one, and otherwise only independent columns. Components below `negligible` are
    /// omitted.
    pub(crate) fn null_vectors(&self, negligible: f64) -> Vec<Vec<(usize, f64)>> {
        let mut row_of = vec![usize::MAX; self.columns];
        self.pivots.iter().enumerate().for_each(|(row, pivot)| row_of[*pivot] = row);
        let by_columns = self.transposed().transpose();
        let mut sums = vec![0.0; self.rank()];
        let each = self.dependent.iter().map(|&dependent| {
            let mut vector = Vec::new();
            let mut open = std::collections::BTreeSet::new();
            let mut place =
                |column: usize,
                 amount: f64,
                 sums: &mut [f64],
                 open: &mut std::collections::BTreeSet<usize>| {
                    for (row, value) in by_columns.column(column) {
                        if row != row_of[column] {
                            sums[row] += value * amount;
                            open.insert(row);
                        }
                    }
                    vector.push((column, amount));
                };
            place(dependent, 1.0, &mut sums, &mut open);
            // Process the later rows first, because earlier rows contain the pivot columns of later
            // rows.
            while let Some(row) = open.pop_last() {
                let amount = -core::mem::take(&mut sums[row]) / self.values[self.starts[row]];
                if amount.abs() > negligible {
                    place(self.pivots[row], amount, &mut sums, &mut open);
                }
            }
            vector.sort_unstable_by_key(|(column, _)| *column);
            vector
        });
        each.collect()
    }
}

/// Rows of the matrix by the steps in which they are eliminated, and buffers for fronts.
struct Fronts {
    by_rows: SparseMatrix,
    /// Rows in the order of the steps that eliminate their first columns.
    rows: Vec<usize>,
    /// Index in `rows` of the first row of each step, followed by the number of rows.
    starts: Vec<usize>,
    /// Index in the front of each position of [`ColumnOrder::columns`]; used only while a front is
    /// formed, otherwise [`NOWHERE`].
    columns: Vec<usize>,
    /// Fronts whose storage is used again.
    spare: Vec<Front>,
}

/// Index of a column that is not in the front.
const NOWHERE: usize = usize::MAX;

impl Fronts {
    fn new(matrix: &SparseMatrix, order: &ColumnOrder, steps: usize) -> Self {
        let by_rows = matrix.transpose();
        let step_of = |row: usize| {
            let places = by_rows.column(row).map(|(column, _)| order.places[column]);
            places.min().map(|first| order.steps[first])
        };
        let steps_of: Vec<Option<usize>> = (0..by_rows.ncols()).map(step_of).collect();
        let mut starts = vec![0; steps + 1];
        steps_of.iter().flatten().for_each(|step| starts[step + 1] += 1);
        for step in 0..steps {
            starts[step + 1] += starts[step];
        }
        let mut next = starts.clone();
        let mut rows = vec![0; starts[steps]];
        for (row, step) in steps_of.iter().enumerate() {
            if let Some(step) = *step {
                rows[next[step]] = row;
                next[step] += 1;
            }
        }
        Self { by_rows, rows, starts, columns: vec![NOWHERE; matrix.ncols()], spare: Vec::new() }
    }

    /// Stacks the rows of the matrix that belong to a step and the rows of several fronts. The
    /// columns at the positions `own` come first.
    fn merged(
        &mut self,
        step: usize,
        own: core::ops::Range<usize>,
        order: &ColumnOrder,
        parts: Vec<Front>,
    ) -> Front {
        let mut made = self.spare.pop().unwrap_or_default();
        let Self { by_rows, rows, starts, columns, spare } = self;
        let rows = &rows[starts[step]..starts[step + 1]];
        let Front { places, values, rows: count } = &mut made;
        places.clear();
        let mut add = |place: usize| {
            if columns[place] == NOWHERE {
                columns[place] = 0;
                places.push(place);
            }
        };
        own.for_each(&mut add);
        for &row in rows {
            by_rows.column(row).for_each(|(column, _)| add(order.places[column]));
        }
        parts.iter().flat_map(|part| &part.places).for_each(|place| add(*place));
        places.sort_unstable();
        places.iter().enumerate().for_each(|(k, place)| columns[*place] = k);
        *count = rows.len() + parts.iter().map(|part| part.rows).sum::<usize>();
        values.clear();
        values.resize(*count * places.len(), 0.0);
        for (first, &row) in rows.iter().enumerate() {
            for (column, value) in by_rows.column(row) {
                values[columns[order.places[column]] * *count + first] = value;
            }
        }
        let mut first = rows.len();
        for part in &parts {
            for (k, place) in part.places.iter().enumerate() {
                let to = columns[*place] * *count + first;
                values[to..to + part.rows]
                    .copy_from_slice(&part.values[k * part.rows..(k + 1) * part.rows]);
            }
            first += part.rows;
        }
        places.iter().for_each(|place| columns[*place] = NOWHERE);
        spare.extend(parts);
        made
    }

    /// Returns the rows of a front from index `done` on, without the first `own` columns. If there
    /// are more such rows than remaining columns, reduces the rows to triangular form.
    fn remainder(&mut self, mut front: Front, done: usize, own: usize) -> Front {
        let rest = front.places.len() - own;
        let mut end = front.rows;
        if end - done > rest {
            for k in 0..rest {
                let norm = front.norm(own + k, done + k);
                if norm > 0.0 {
                    front.reflect(own + k, done + k, norm);
                }
            }
            end = done + rest;
        }
        let mut made = self.spare.pop().unwrap_or_default();
        made.rows = end - done;
        made.places.clear();
        made.places.extend_from_slice(&front.places[own..]);
        made.values.clear();
        for column in front.values.chunks_exact(front.rows.max(1)).skip(own) {
            made.values.extend_from_slice(&column[done..end]);
        }
        self.spare.push(front);
        made
    }
}

impl Front {
    /// Computes the norm of the entries of a column in the rows from `from` on.
    fn norm(&self, column: usize, from: usize) -> f64 {
        let part = &self.values[column * self.rows + from..(column + 1) * self.rows];
        part.iter().map(|x| x * x).sum::<f64>().sqrt()
    }

    fn swap(&mut self, a: usize, b: usize) {
        if a != b {
            self.places.swap(a, b);
            let (before, from) = self.values.split_at_mut(b * self.rows);
            before[a * self.rows..(a + 1) * self.rows].swap_with_slice(&mut from[..self.rows]);
        }
    }

    /// Applies a Householder reflection to the rows from index `from` on. The reflection maps the
    /// entries of `column` in these rows to a multiple of the first unit vector; `norm` is their
    /// norm. Changes this column and all columns after it.
    fn reflect(&mut self, column: usize, from: usize, norm: f64) {
        let rows = self.rows;
        let (before, behind) = self.values.split_at_mut((column + 1) * rows);
        let reflector = &mut before[column * rows + from..];
        let new = if reflector[0] > 0.0 { -norm } else { norm };
        reflector[0] -= new;
        // Half the squared norm of the reflector.
        let half = -new * reflector[0];
        if half > 0.0 {
            for other in behind.chunks_exact_mut(rows) {
                let other = &mut other[from..];
                let sum: f64 = reflector.iter().zip(&*other).map(|(a, b)| a * b).sum();
                let amount = sum / half;
                other.iter_mut().zip(&*reflector).for_each(|(x, r)| *x -= amount * r);
            }
        }
        reflector.fill(0.0);
        reflector[0] = new;
    }
}
