//! Tables of a simulation.

use super::events::{Told, tell_all};
use super::rows::{Layout, Rows};
use super::summary::Summary;
use crate::table;
use std::io;
use stiction_core::forward::Event;

/// Writes the tables of a simulation, one row for each sample.
pub struct Tables<W: io::Write> {
    tables: table::Tables<W>,
}

impl<W: io::Write> Tables<W> {
    /// Names of the tables, in the order of the files passed to [`Self::new`].
    pub const FILES: [&'static str; 6] =
        ["forward.csv", "reactions.csv", "friction.csv", "bodies.csv", "energy.csv", "motion.csv"];

    /// Starts the tables with their headers.
    ///
    /// # Errors
    /// A header cannot be written.
    pub fn new(layout: &Layout, files: [W; 6]) -> io::Result<Self> {
        Ok(Self { tables: table::Tables::new(layout.headers(), files)? })
    }

    /// Continues tables that already have headers and rows.
    pub fn onward(files: [W; 6]) -> Self {
        Self { tables: table::Tables::continued(files) }
    }

    /// Flushes all buffers.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.tables.flush()
    }

    /// Adds a row to each table.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn add(&mut self, layout: &Layout, rows: &Rows) -> io::Result<()> {
        let actuated = layout.dof_of_actuator.iter();
        let motion = actuated.flat_map(|&dof| layout.motion_in(&rows.forward, dof)).copied();
        let motion: Vec<f64> = motion.collect();
        let all =
            [&rows.forward, &rows.reactions, &rows.friction, &rows.bodies, &rows.energy, &motion];
        self.tables.add(rows.time, all.map(Vec::as_slice))
    }

    /// Flushes all buffers and returns the files in their order.
    ///
    /// # Errors
    /// A file cannot be written.
    pub fn finish(self) -> io::Result<Vec<W>> {
        self.tables.finish()
    }
}

/// Reads the rows of existing tables, in the order of [`Tables::FILES`], and passes them to
/// `receive`.
///
/// # Errors
/// Returns a message if the tables do not have `count` rows of this layout.
pub fn read_rows(
    layout: &Layout,
    files: [&mut dyn io::Read; 6],
    count: usize,
    mut receive: impl FnMut(&Rows),
) -> Result<(), String> {
    let mut readers = Vec::new();
    for (file, header) in files.into_iter().zip(layout.headers()) {
        let mut reader = csv::Reader::from_reader(file);
        let known = reader.headers().map_err(|error| error.to_string())?;
        if known.iter().ne(header.iter().map(String::as_str)) {
            return Err("their columns are others".to_owned());
        }
        readers.push(reader.into_records());
    }
    let mut rows = Rows::default();
    for _ in 0..count {
        for (index, reader) in readers.iter_mut().enumerate() {
            let record = reader.next().ok_or("rows are missing")?.map_err(|e| e.to_string())?;
            let numbers = record.iter().map(str::parse).collect::<Result<Vec<f64>, _>>();
            let numbers = numbers.map_err(|error| error.to_string())?;
            let (time, row) = numbers.split_first().ok_or("a row is empty")?;
            let own = match index {
                0 => &mut rows.forward,
                1 => &mut rows.reactions,
                2 => &mut rows.friction,
                3 => &mut rows.bodies,
                4 => &mut rows.energy,
                _ => continue,
            };
            rows.time = *time;
            own.clear();
            own.extend_from_slice(row);
        }
        receive(&rows);
    }
    Ok(())
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
