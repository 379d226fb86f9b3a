//! Tables of a run of inverse dynamics, as CSV or in memory.

use super::rows::{Rows, TABLES};
use super::sample::Sample;
use crate::job::Job;
use crate::table::{self, Table, header};
use crate::{Sink, SinkError};
use std::io;

/// Writer of the tables of a run, one row for each sample:
///
/// - `inverse.csv`: actuators, power balance, closure error and singularity indices;
/// - `joints.csv`: motion of every scalar joint coordinate, and lengths of legs;
/// - `reactions.csv`: complete wrench of every joint;
/// - `friction.csv`: state of every friction interface;
/// - `bodies.csv`: motion of every body;
/// - `motors.csv`: power of every motor, and its losses;
/// - `contributions.csv`: contribution of every friction interface to every actuator's effort.
pub struct Tables<W: io::Write> {
    tables: table::Tables<W>,
    rows: Rows,
    /// True for each table in [`TABLES`] that the run has.
    has: [bool; 7],
}

impl<W: io::Write> Tables<W> {
    /// File names of the tables of all jobs.
    pub const FILES: [&'static str; 7] = TABLES;

    /// Returns the file names of the job's tables, in the order of the files passed to
    /// [`Self::new`].
    pub fn files(job: &Job<'_>) -> Vec<&'static str> {
        let names = TABLES.into_iter().zip(Rows::of_job(job)).filter(|(_, has)| *has);
        names.map(|(name, _)| name).collect()
    }

    /// Creates the tables and writes their headers; `files` are in the order of [`Self::files`].
    ///
    /// # Errors
    /// Returns an error if a header cannot be written.
    pub fn new(job: &Job<'_>, files: Vec<W>) -> io::Result<Self> {
        let rows = Rows::new(job);
        let tables = table::Tables::new(headers(&rows, job), files)?;
        Ok(Self { tables, rows, has: Rows::of_job(job) })
    }

    /// Flushes all buffers and returns the files in the order of [`Self::files`].
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn finish(self) -> io::Result<Vec<W>> {
        self.tables.finish()
    }
}

/// Collects the tables of a run in memory. The numbers are the same as in the files that [`Tables`]
/// writes.
pub struct Columns {
    tables: Vec<Table>,
    rows: Rows,
    has: [bool; 7],
}

impl Columns {
    /// Creates the tables of a job without rows.
    pub fn new(job: &Job<'_>) -> Self {
        let rows = Rows::new(job);
        let names = Tables::<Vec<u8>>::files(job);
        Self { tables: Table::all(names, headers(&rows, job)), rows, has: Rows::of_job(job) }
    }

    /// Returns the tables.
    pub fn finish(self) -> Vec<Table> {
        self.tables
    }
}

/// Returns the headers of all tables of a job, including the time column.
fn headers(rows: &Rows, job: &Job<'_>) -> Vec<Vec<String>> {
    let headers = rows.headers.iter().zip(Rows::of_job(job)).filter(|(_, has)| *has);
    headers.map(|(columns, _)| header(columns.iter().cloned())).collect()
}

impl<W: io::Write> Sink<Sample> for Tables<W> {
    fn add(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.rows.fill(sample);
        let rows = self.rows.rows.iter().zip(self.has).filter(|(_, has)| *has);
        Ok(self.tables.add(sample.time, rows.map(|(row, _)| row.as_slice()))?)
    }
}

impl Sink<Sample> for Columns {
    fn add(&mut self, sample: &Sample) -> Result<(), SinkError> {
        self.rows.fill(sample);
        let rows = self.rows.rows.iter().zip(self.has).filter(|(_, has)| *has);
        self.tables.iter_mut().zip(rows).for_each(|(table, (row, _))| table.add(sample.time, row));
        Ok(())
    }
}
