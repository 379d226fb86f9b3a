//! A table of numbers as CSV.

use std::io;
use stiction_draw::numbers::exact;

/// One table as CSV.
pub struct Table<W: io::Write> {
    writer: csv::Writer<W>,
    cell: String,
}

impl<W: io::Write> Table<W> {
    pub(crate) fn new(into: W, header: &[String]) -> io::Result<Self> {
        let mut writer = csv::Writer::from_writer(into);
        writer.write_record(header)?;
        Ok(Self { writer, cell: String::new() })
    }

    /// Goes on with a table that has its header, and maybe rows.
    pub(crate) fn onward(into: W) -> Self {
        Self { writer: csv::Writer::from_writer(into), cell: String::new() }
    }

    /// Hands on what is buffered.
    pub(crate) fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }

    /// A number with all its digits, in the shortest way that reads back as the same number.
    pub(crate) fn number(&mut self, value: f64) -> io::Result<()> {
        self.cell.clear();
        exact(&mut self.cell, value);
        self.writer.write_field(&self.cell)?;
        Ok(())
    }

    /// Whether something is so, as 1 or 0.
    pub(crate) fn flag(&mut self, value: bool) -> io::Result<()> {
        self.writer.write_field(if value { "1" } else { "0" })?;
        Ok(())
    }

    pub(crate) fn end_row(&mut self) -> io::Result<()> {
        self.writer.write_record(None::<&[u8]>)?;
        Ok(())
    }

    /// Writes what is buffered and gives the receiver back.
    ///
    /// # Errors
    /// What the receiver says.
    pub fn finish(self) -> io::Result<W> {
        self.writer
            .into_inner()
            .map_err(|error| io::Error::new(error.error().kind(), error.to_string()))
    }
}
