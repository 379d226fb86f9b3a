//! Table of a study, `sweep.csv`, and tables of designs that a user provides.

use super::row::{Row, Status};
use std::io;
use stiction_draw::numbers::exact;
use stiction_format::{Key, Setting};

/// Writer of the rows of a study as CSV: number of the row, varied keys, objectives, status.
pub struct Table<W: io::Write> {
    writer: csv::Writer<W>,
    cell: String,
}

impl<W: io::Write> Table<W> {
    /// Creates a table and writes its header.
    ///
    /// # Errors
    /// Returns an error if the header cannot be written.
    pub fn new(keys: &[Key], objectives: &[String], file: W) -> io::Result<Self> {
        let mut table = Self::continued(file);
        table.writer.write_record(header(keys, objectives))?;
        Ok(table)
    }

    /// Creates a writer for a table that already contains its header and the rows of an interrupted
    /// study.
    pub fn continued(file: W) -> Self {
        Self { writer: csv::Writer::from_writer(file), cell: String::new() }
    }

    /// Writes a row; `number` counts from 1.
    ///
    /// # Errors
    /// Returns an error if the row cannot be written.
    pub fn add(&mut self, number: u64, settings: &[Setting], row: &Row) -> io::Result<()> {
        self.writer.write_field(number.to_string())?;
        for setting in settings {
            self.writer.write_field(setting.to_string())?;
        }
        for value in &row.values {
            self.cell.clear();
            if let Some(value) = value {
                exact(&mut self.cell, *value);
            }
            self.writer.write_field(&self.cell)?;
        }
        self.writer.write_field(row.status.to_string())?;
        Ok(self.writer.write_record(None::<&[u8]>)?)
    }

    /// Flushes all buffers.
    ///
    /// # Errors
    /// Returns an error if the rows cannot be written.
    pub fn flush(&mut self) -> io::Result<()> {
        self.writer.flush()
    }
}

/// Returns the names of all columns in the table of a study.
pub fn header(keys: &[Key], objectives: &[String]) -> Vec<String> {
    let keys = keys.iter().map(Key::to_string);
    let first = std::iter::once("row".to_owned()).chain(keys);
    first.chain(objectives.iter().cloned()).chain(["status".to_owned()]).collect()
}

/// Row read from the table of a study.
#[derive(Clone, Debug, PartialEq)]
pub struct Record {
    /// Number of the row, counted from 1.
    pub number: u64,
    /// Values of the varied keys.
    pub settings: Vec<Setting>,
    /// Results of the design.
    pub row: Row,
}

impl Record {
    /// Parses a line with the given numbers of keys and objectives; `None` if the line is not a
    /// complete row.
    pub fn parse(line: &str, keys: usize, objectives: usize) -> Option<Self> {
        let fields = fields(line).filter(|fields| fields.len() == keys + objectives + 2)?;
        let mut cells = fields.iter().map(String::as_str);
        let number = cells.next()?.parse().ok()?;
        let settings = cells.by_ref().take(keys).map(Setting::of_cell).collect();
        let value = |cell: &str| match cell {
            "" => Some(None),
            cell => cell.parse().ok().map(Some),
        };
        let values = cells.by_ref().take(objectives).map(value).collect::<Option<Vec<_>>>()?;
        let status = Status::parse(cells.next()?)?;
        Some(Self { number, settings, row: Row { values, status } })
    }
}

/// Splits a line of CSV into its cells; `None` if the line is empty or not valid CSV.
pub fn fields(line: &str) -> Option<Vec<String>> {
    let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(line.as_bytes());
    let record = reader.records().next()?.ok()?;
    Some(record.iter().map(str::to_owned).collect())
}

/// Reader of a table of designs: a header with the varied keys, then one design per row.
pub struct DesignTable<R: io::Read> {
    records: csv::StringRecordsIntoIter<R>,
    keys: Vec<Key>,
}

impl<R: io::Read> DesignTable<R> {
    /// Creates a reader and reads the header of the table.
    ///
    /// # Errors
    /// Returns a message of one line if the header is invalid.
    pub fn new(from: R) -> Result<Self, String> {
        let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(from);
        let header = reader.headers().map_err(|error| error.to_string())?;
        let header = header.iter().map(|header| header.trim_start_matches('\u{feff}'));
        let keys = header.map(Key::of_header).collect::<Result<Vec<_>, _>>()?;
        if keys.is_empty() {
            return Err("the table has no columns".to_owned());
        }
        if let Some(k) =
            (1..keys.len()).find(|k| keys[..*k].iter().any(|key| key.path == keys[*k].path))
        {
            return Err(format!("two columns are named `{}`", keys[k].path));
        }
        Ok(Self { records: reader.into_records(), keys })
    }

    /// Returns the varied keys.
    pub fn keys(&self) -> &[Key] {
        &self.keys
    }
}

impl<R: io::Read> Iterator for DesignTable<R> {
    type Item = Result<Vec<Setting>, String>;

    fn next(&mut self) -> Option<Self::Item> {
        let record = self.records.next()?;
        Some(match record {
            // Each row of the table of a study must be one line.
            Ok(record) => Ok(record
                .iter()
                .map(|cell| Setting::of_cell(&cell.replace(['\n', '\r'], " ")))
                .collect()),
            Err(error) => Err(error.to_string()),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_as_they_were_written() {
        let keys = [Key::of_header("mu").unwrap(), Key::of_header("rod.mass [g]").unwrap()];
        let objectives = ["peak(a.effort) [N]".to_owned(), "min(b) [-]".to_owned()];
        let rows = [
            (vec![Some(1.0 / 3.0), Some(f64::INFINITY)], "ok"),
            (vec![Some(-0.1), None], "caution: leaves its range, \"x\""),
            (vec![None, None], "no answer: at t = 0 s: locked"),
            (vec![None, None], "failed: expected a mass"),
        ];
        let mut file = Vec::new();
        let mut table = Table::new(&keys, &objectives, &mut file).unwrap();
        let settings = [Setting::Number(1e-7), Setting::Text("2*m, as given".to_owned())];
        for (k, (values, status)) in rows.iter().enumerate() {
            let row = Row { values: values.clone(), status: Status::parse(status).unwrap() };
            table.add(k as u64 + 1, &settings, &row).unwrap();
        }
        drop(table);
        let text = String::from_utf8(file).unwrap();
        let mut lines = text.lines();
        assert_eq!(lines.next(), Some("row,mu,rod.mass [g],peak(a.effort) [N],min(b) [-],status"));
        for (k, (line, (values, status))) in lines.zip(&rows).enumerate() {
            let record = Record::parse(line, 2, 2).unwrap();
            assert_eq!((record.number, &record.settings[..]), (k as u64 + 1, &settings[..]));
            assert_eq!(
                (&record.row.values, record.row.status.to_string().as_str()),
                (values, *status)
            );
        }
        for damaged in
            ["", "1,2", "x,0.1,2,3,4,ok", "1,0.1,2,three,4,ok", "1,0.1,2,3,4,o", "1,0.1,2,3"]
        {
            assert_eq!(Record::parse(damaged, 2, 2), None, "{damaged}");
        }
    }

    #[test]
    fn tables_of_designs() {
        let text = "# two rods\nmu, rod.mass [g]\n0.1,200\n,2*m\n0.2\n";
        let mut table = DesignTable::new(text.as_bytes()).unwrap();
        assert_eq!(table.keys()[1].to_string(), "rod.mass [g]");
        let text = |text: &str| Setting::Text(text.to_owned());
        assert_eq!(table.next(), Some(Ok(vec![Setting::Number(0.1), Setting::Number(200.0)])));
        assert_eq!(table.next(), Some(Ok(vec![text(""), text("2*m")])));
        assert!(table.next().unwrap().unwrap_err().contains("line"));
        for wrong in ["a,a\n1,2\n", "a [furlong]\n1\n", "a,\n1,2\n"] {
            assert!(DesignTable::new(wrong.as_bytes()).is_err(), "{wrong}");
        }
    }
}
