//! Tables of a run of inverse dynamics: as CSV, or in memory.

use super::rows::{Rows, TABLES};
use super::sample::Sample;
use crate::job::Job;
use crate::table::{self, Table, header};
use crate::{Sink, SinkError};
use std::io;

/// Writes the tables of a run, one row for each sample.
///
/// `inverse.csv` has the actuators, the power balance, the closure error and the singularity indices;
/// `joints.csv` the motion of every scalar joint coordinate and the lengths of legs; `reactions.csv` the
/// complete wrench of every joint; `friction.csv` every friction interface; `bodies.csv` the motion of every
/// body; `motors.csv` the power of every motor and where it goes; `contributions.csv` the contribution of every
/// friction interface to every actuator's effort.
pub struct Tables<W: io::Write> {
    tables: table::Tables<W>,
    rows: Rows,
    /// True if the run has this table.
    has: [bool; 7],
}

impl<W: io::Write> Tables<W> {
    /// Names of the job's tables, in the order of the files passed to [`Self::new`].
    pub fn files(job: &Job<'_>) -> Vec<&'static str> {
        let names = TABLES.into_iter().zip(Rows::of_job(job)).filter(|(_, has)| *has);
        names.map(|(name, _)| name).collect()
    }

    /// Starts the tables with their headers.
    ///
    /// # Errors
    /// A header cannot be written.
    pub fn new(job: &Job<'_>, files: Vec<W>) -> io::Result<Self> {
        let rows = Rows::new(job);
        let tables = table::Tables::new(headers(&rows, job), files)?;
        Ok(Self { tables, rows, has: Rows::of_job(job) })
    }

    /// Flushes all buffers and returns the files in their order.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(self) -> io::Result<Vec<W>> {
        self.tables.finish()
    }
}

/// Keeps the tables of a run in memory, with the numbers of [`Tables`].
pub struct Columns {
    tables: Vec<Table>,
    rows: Rows,
    has: [bool; 7],
}

impl Columns {
    /// Starts the tables of a job.
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

/// Headers of the tables of a job, with the time.
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
