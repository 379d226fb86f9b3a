//! The tables of a simulation.

use super::events::{Told, tell_all};
use super::rows::{Layout, Rows};
use super::summary::Summary;
use crate::table::Table;
use std::io;
use stiction_core::forward::Event;

/// The tables of a simulation, row by row.
pub struct Tables<W: io::Write> {
    tables: Vec<Table<W>>,
}

impl<W: io::Write> Tables<W> {
    /// The names of the files, in the order in which they are handed to [`Self::new`].
    pub const FILES: [&'static str; 6] =
        ["forward.csv", "reactions.csv", "friction.csv", "bodies.csv", "energy.csv", "motion.csv"];

    /// Begins the tables.
    ///
    /// # Errors
    /// What the receivers say.
    pub fn new(layout: &Layout, files: [W; 6]) -> io::Result<Self> {
        let tables =
            files.into_iter().zip(headers(layout)).map(|(file, header)| Table::new(file, &header));
        Ok(Self { tables: tables.collect::<io::Result<_>>()? })
    }

    /// Goes on with tables that have their headers and rows.
    pub fn onward(files: [W; 6]) -> Self {
        Self { tables: files.into_iter().map(Table::onward).collect() }
    }

    /// Hands on what is buffered.
    ///
    /// # Errors
    /// What the receivers say.
    pub fn flush(&mut self) -> io::Result<()> {
        self.tables.iter_mut().try_for_each(Table::flush)
    }

    /// Adds a row to each.
    ///
    /// # Errors
    /// What the receivers say.
    pub fn add(&mut self, layout: &Layout, rows: &Rows) -> io::Result<()> {
        let motion: Vec<f64> = layout
            .dof_of_actuator
            .iter()
            .flat_map(|&dof| layout.motion_in(&rows.forward, dof))
            .copied()
            .collect();
        let all =
            [&rows.forward, &rows.reactions, &rows.friction, &rows.bodies, &rows.energy, &motion];
        for (table, row) in self.tables.iter_mut().zip(all) {
            table.number(rows.time)?;
            for value in row {
                table.number(*value)?;
            }
            table.end_row()?;
        }
        Ok(())
    }

    /// Writes what is buffered and gives the receivers back, in their order.
    ///
    /// # Errors
    /// What the receivers say.
    pub fn finish(self) -> io::Result<Vec<W>> {
        self.tables.into_iter().map(Table::finish).collect()
    }
}

/// The columns of the tables, in the order of [`Tables::FILES`].
fn headers(layout: &Layout) -> [Vec<String>; 6] {
    [
        layout.forward(),
        layout.reactions(),
        layout.friction(),
        layout.bodies(),
        layout.energy(),
        layout.motion(),
    ]
}

/// Reads the rows of tables that were written before, in the order of [`Tables::FILES`], and hands them on.
///
/// # Errors
/// In words, where these are not `count` rows of this layout.
pub fn read_rows(
    layout: &Layout,
    files: [&mut dyn io::Read; 6],
    count: usize,
    mut receive: impl FnMut(&Rows),
) -> Result<(), String> {
    let mut readers = Vec::new();
    for (file, header) in files.into_iter().zip(headers(layout)) {
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

/// Writes `events.csv`: a row for each event.
///
/// # Errors
/// What the receiver says.
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
