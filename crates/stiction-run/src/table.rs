//! Tables of numbers, as CSV or in memory, with one row for each record of a run.

use std::io;
use stiction_draw::numbers::{exact, finish_line};

/// Names of the columns for each joint reaction.
pub(crate) const REACTION: [&str; 7] =
    ["fx [N]", "fy [N]", "fz [N]", "mx [N m]", "my [N m]", "mz [N m]", "determined"];

/// Returns the header of a table: the time, followed by the given columns.
pub(crate) fn header(columns: impl IntoIterator<Item = String>) -> Vec<String> {
    std::iter::once("time [s]".to_owned()).chain(columns).collect()
}

/// Returns the names of the columns for several objects with the same quantities:
/// `object.quantity`.
pub(crate) fn columns<'a>(
    objects: impl IntoIterator<Item = &'a str>,
    quantities: &[&str],
) -> Vec<String> {
    let of =
        |object: &'a str| quantities.iter().map(move |quantity| format!("{object}.{quantity}"));
    objects.into_iter().flat_map(of).collect()
}

/// Table of a run in memory, with the same columns as the CSV file.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// Name of the CSV file that contains the same table.
    pub file: &'static str,
    /// Header of each column, with its unit in square brackets. The first column is the time, s.
    pub header: Vec<String>,
    /// Values of the table, row by row.
    values: Vec<f64>,
}

impl Table {
    /// Creates tables without rows, each with its file name and its header.
    pub(crate) fn all(
        files: impl IntoIterator<Item = &'static str>,
        headers: impl IntoIterator<Item = Vec<String>>,
    ) -> Vec<Self> {
        let each = files.into_iter().zip(headers);
        each.map(|(file, header)| Self { file, header, values: Vec::new() }).collect()
    }

    /// Adds a row: the time, s, followed by all other values.
    pub(crate) fn add(&mut self, time: f64, row: &[f64]) {
        self.values.push(time);
        self.values.extend_from_slice(row);
    }

    /// Returns the number of rows.
    pub fn rows(&self) -> usize {
        self.values.len() / self.header.len().max(1)
    }

    /// Returns the values column by column: all rows of the first column, followed by all rows of
    /// the second, and so on.
    pub fn into_columns(self) -> Vec<f64> {
        let (rows, columns) = (self.rows(), self.header.len());
        let mut turned = Vec::with_capacity(self.values.len());
        for column in 0..columns {
            turned.extend((0..rows).map(|row| self.values[row * columns + column]));
        }
        turned
    }
}

/// Writer of the tables of a run as CSV. Each sample adds a row to every table.
pub(crate) struct Tables<W: io::Write> {
    tables: Vec<W>,
    /// Time of the present row, with which the row of every table begins.
    time: String,
    /// Buffer that begins with the present row of a table.
    line: Vec<u8>,
}

impl<W: io::Write> Tables<W> {
    /// Creates tables and writes their headers. Each row is written separately, so files should be
    /// buffered.
    pub(crate) fn new(
        headers: impl IntoIterator<Item = Vec<String>>,
        files: impl IntoIterator<Item = W>,
    ) -> io::Result<Self> {
        let mut tables = Self::continued(files);
        for (table, header) in tables.tables.iter_mut().zip(headers) {
            let mut table = csv::Writer::from_writer(table);
            table.write_record(header)?;
            table.flush()?;
        }
        Ok(tables)
    }

    /// Creates a writer for tables that already contain their headers and rows.
    pub(crate) fn continued(files: impl IntoIterator<Item = W>) -> Self {
        Self { tables: files.into_iter().collect(), time: String::new(), line: Vec::new() }
    }

    /// Adds a row to each table: the time, s, followed by the values of the table with all digits.
    pub(crate) fn add<'r>(
        &mut self,
        time: f64,
        rows: impl IntoIterator<Item = &'r [f64]>,
    ) -> io::Result<()> {
        self.time.clear();
        exact(&mut self.time, time);
        let begun = self.time.len();
        self.line.resize(self.line.len().max(begun), 0);
        self.line[..begun].copy_from_slice(self.time.as_bytes());
        for (table, row) in self.tables.iter_mut().zip(rows) {
            // Numbers need no quotes; a CSV writer that searches for characters to quote would take
            // most of the time.
            let end = finish_line(&mut self.line, begun, row);
            table.write_all(&self.line[..end])?;
        }
        Ok(())
    }

    /// Flushes all buffers.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.tables.iter_mut().try_for_each(W::flush)
    }

    /// Flushes all buffers and returns the files in the order of the tables.
    pub(crate) fn finish(mut self) -> io::Result<Vec<W>> {
        self.flush()?;
        Ok(self.tables)
    }
}
