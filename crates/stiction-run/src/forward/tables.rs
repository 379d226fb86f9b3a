//! Result tables of a simulation, as CSV files or in memory.

use super::events::DescribedEvent;
use super::job::Job;
use super::rows::{Layout, Rows};
use super::summary::Summary;
use crate::table::Table;
use crate::{Sink, SinkError, table};
use std::io;
use stiction_core::forward::Event;

/// Writer of the tables of a simulation, one row for each sample.
pub struct Tables<W: io::Write> {
    tables: table::Tables<W>,
    layout: Layout,
}

impl<W: io::Write> Tables<W> {
    /// File names of the tables, in the order of the files passed to [`Self::new`].
    pub const FILES: [&'static str; 6] =
        ["forward.csv", "reactions.csv", "friction.csv", "bodies.csv", "energy.csv", "motion.csv"];

    /// Creates the tables and writes their headers; `files` are in the order of [`Self::FILES`].
    ///
    /// # Errors
    /// Returns an error if a header cannot be written.
    pub fn new(job: &Job<'_>, files: [W; 6]) -> io::Result<Self> {
        let layout = Layout::new(job);
        Ok(Self { tables: table::Tables::new(layout.headers(), files)?, layout })
    }

    /// Creates a writer for tables that already contain their headers and the rows of an
    /// interrupted simulation.
    pub fn onward(job: &Job<'_>, files: [W; 6]) -> Self {
        Self { tables: table::Tables::continued(files), layout: Layout::new(job) }
    }

    /// Flushes all buffers.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.tables.flush()
    }

    /// Flushes all buffers and returns the files in the order of [`Self::FILES`].
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn finish(self) -> io::Result<Vec<W>> {
        self.tables.finish()
    }
}

/// Collector of the tables of a simulation in memory, with the same numbers as [`Tables`].
pub struct Columns {
    tables: Vec<Table>,
    layout: Layout,
}

impl Columns {
    /// Creates the tables of a simulation with headers and without rows.
    pub fn new(job: &Job<'_>) -> Self {
        let layout = Layout::new(job);
        Self { tables: Table::all(Tables::<Vec<u8>>::FILES, layout.headers()), layout }
    }

    /// Returns the tables in the order of [`Tables::FILES`].
    pub fn finish(self) -> Vec<Table> {
        self.tables
    }
}

/// Passes the rows of all tables for one sample to `write`, in the order of [`Tables::FILES`] and
/// without the time.
fn each_row<R>(layout: &Layout, rows: &Rows, write: impl FnOnce([&[f64]; 6]) -> R) -> R {
    let actuated = layout.dof_of_actuator.iter();
    let motion = actuated.flat_map(|&dof| layout.motion_in(&rows.forward, dof)).copied();
    let motion: Vec<f64> = motion.collect();
    let bodies = [&rows.bodies[..], &rows.space].concat();
    let all = [&rows.forward, &rows.reactions, &rows.friction, &bodies, &rows.energy, &motion];
    write(all.map(Vec::as_slice))
}

impl<W: io::Write> Sink<Rows> for Tables<W> {
    fn add(&mut self, rows: &Rows) -> Result<(), SinkError> {
        let Self { tables, layout } = self;
        Ok(each_row(layout, rows, |all| tables.add(rows.time, all))?)
    }
}

impl Sink<Rows> for Columns {
    fn add(&mut self, rows: &Rows) -> Result<(), SinkError> {
        let Self { tables, layout } = self;
        each_row(layout, rows, |all| {
            tables.iter_mut().zip(all).for_each(|(table, row)| table.add(rows.time, row));
        });
        Ok(())
    }
}

/// Event of a simulation in words, as a row of `events.csv`.
#[derive(Clone, Debug, PartialEq)]
pub struct EventRow {
    /// Time of the event, s.
    pub time: f64,
    /// Kind of event, as a keyword.
    pub event: &'static str,
    /// Name of the friction interface, joint, body or other quantity to which the event belongs;
    /// empty if the event concerns the whole mechanism.
    pub at: String,
    /// Details of the event; may be empty.
    pub detail: String,
}

/// Describes the events of a simulation in words.
pub fn event_rows(summary: &Summary, events: &[Event]) -> Vec<EventRow> {
    let each = summary.described(events).into_iter();
    each.map(|DescribedEvent { time, what, at, detail }| EventRow { time, event: what, at, detail })
        .collect()
}

/// Writes `events.csv`, with one row for each event.
///
/// # Errors
/// Returns an error if the file cannot be written.
pub fn write_events(into: impl io::Write, summary: &Summary, events: &[Event]) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(into);
    writer.write_record(["time [s]", "event", "at", "detail"])?;
    for EventRow { time, event, at, detail } in event_rows(summary, events) {
        let mut cell = String::new();
        stiction_draw::numbers::exact(&mut cell, time);
        writer.write_record([cell.as_str(), event, &at, &detail])?;
    }
    writer.flush()
}
