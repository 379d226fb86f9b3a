//! Tables of a simulation.

use super::events::{Told, tell_all};
use super::job::Job;
use super::rows::{Layout, Rows};
use super::summary::Summary;
use crate::{Sink, SinkError, table};
use std::io;
use stiction_core::forward::Event;

/// Writes the tables of a simulation, one row for each sample.
pub struct Tables<W: io::Write> {
    tables: table::Tables<W>,
    layout: Layout,
}

impl<W: io::Write> Tables<W> {
    /// Names of the tables, in the order of the files passed to [`Self::new`].
    pub const FILES: [&'static str; 6] =
        ["forward.csv", "reactions.csv", "friction.csv", "bodies.csv", "energy.csv", "motion.csv"];

    /// Starts the tables with their headers.
    ///
    /// # Errors
    /// A header cannot be written.
    pub fn new(job: &Job<'_>, files: [W; 6]) -> io::Result<Self> {
        let layout = Layout::new(job);
        Ok(Self { tables: table::Tables::new(layout.headers(), files)?, layout })
    }

    /// Continues tables that already have headers and rows.
    pub fn onward(job: &Job<'_>, files: [W; 6]) -> Self {
        Self { tables: table::Tables::continued(files), layout: Layout::new(job) }
    }

    /// Flushes all buffers.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.tables.flush()
    }

    /// Flushes all buffers and returns the files in their order.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(self) -> io::Result<Vec<W>> {
        self.tables.finish()
    }
}

impl<W: io::Write> Sink<Rows> for Tables<W> {
    fn add(&mut self, rows: &Rows) -> Result<(), SinkError> {
        let Self { tables, layout } = self;
        let actuated = layout.dof_of_actuator.iter();
        let motion = actuated.flat_map(|&dof| layout.motion_in(&rows.forward, dof)).copied();
        let motion: Vec<f64> = motion.collect();
        let all =
            [&rows.forward, &rows.reactions, &rows.friction, &rows.bodies, &rows.energy, &motion];
        Ok(tables.add(rows.time, all.map(Vec::as_slice))?)
    }
}

/// Writes `events.csv`, one row for each event.
///
/// # Errors
/// The file cannot be written.
pub fn write_events(into: impl io::Write, summary: &Summary, events: &[Event]) -> io::Result<()> {
    let mut writer = csv::Writer::from_writer(into);
    writer.write_record(["time [s]", "event", "at", "detail"])?;
    for Told { time, what, at, detail } in
        tell_all(&summary.layout, summary.at_rest_first(), events)
    {
        let mut cell = String::new();
        stiction_draw::numbers::exact(&mut cell, time);
        writer.write_record([cell.as_str(), what, &at, &detail])?;
    }
    writer.flush()
}
