//! Tables as NumPy archives (NPZ): an array of 64-bit numbers for each column, named by the column's header.

use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Memory, bytes, for the columns that are converted in one pass over the table. If a single column
/// needs more memory, it is still converted in one pass.
const MEMORY: usize = 64 << 20;

/// Converts a table of numbers, a CSV file with all digits, to an NPZ archive.
///
/// The arrays are uncompressed and in the order of the columns. The memory use does not grow with
/// the number of columns, because the table is read once for each group of columns that fits into
/// 64 MiB.
///
/// # Errors
/// Returns an error if a file cannot be read or written, or if a cell is not a number.
pub fn npz_of_csv(mut table: impl Read + Seek, archive: impl Write + Seek) -> io::Result<()> {
    let mut rows = 0;
    let header = each_row(&mut table, |_| {
        rows += 1;
        Ok(())
    })?;
    let at_once = (MEMORY / (8 * rows.max(1))).max(1);
    let mut zip = ZipWriter::new(BufWriter::new(archive));
    // With a fixed time stamp, equal tables give equal bytes.
    let options = SimpleFileOptions::default()
        .compression_method(CompressionMethod::Stored)
        .last_modified_time(zip::DateTime::default());
    for first in (0..header.len()).step_by(at_once) {
        let group = first..(first + at_once).min(header.len());
        let mut columns: Vec<Vec<u8>> = vec![Vec::with_capacity(8 * rows); group.len()];
        each_row(&mut table, |row| {
            for (column, cell) in columns.iter_mut().zip(row.iter().skip(first)) {
                column.extend_from_slice(&number(cell)?.to_le_bytes());
            }
            Ok(())
        })?;
        for (name, column) in header[group].iter().zip(&columns) {
            let is_large = column.len() > u32::MAX as usize - 1024;
            zip.start_file(format!("{name}.npy"), options.large_file(is_large))?;
            zip.write_all(&npy_header(column.len() / 8))?;
            zip.write_all(column)?;
        }
    }
    zip.finish()?.into_inner().map_err(|error| error.into_error())?.flush()
}

/// Calls `receive` with each row of a table, and returns the header of the table.
fn each_row(
    table: &mut (impl Read + Seek),
    mut receive: impl FnMut(&csv::StringRecord) -> io::Result<()>,
) -> io::Result<Vec<String>> {
    table.seek(SeekFrom::Start(0))?;
    let mut reader = csv::Reader::from_reader(BufReader::new(table));
    let header = reader.headers()?.iter().map(str::to_owned).collect();
    let mut row = csv::StringRecord::new();
    while reader.read_record(&mut row)? {
        receive(&row)?;
    }
    Ok(header)
}

fn number(cell: &str) -> io::Result<f64> {
    cell.parse().map_err(|_| {
        io::Error::new(io::ErrorKind::InvalidData, format!("`{cell}` in a table is not a number"))
    })
}

/// Returns the header of an NPY file, version 1.0, for a one-dimensional array of `count`
/// little-endian doubles.
fn npy_header(count: usize) -> Vec<u8> {
    /// Length, bytes, of the magic number, the version and the header length of an NPY file.
    const PREFIX: usize = 10;
    const ALIGNED: usize = 64;
    let mut text = format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({count},), }}");
    while !(PREFIX + text.len() + 1).is_multiple_of(ALIGNED) {
        text.push(' ');
    }
    text.push('\n');
    let mut header = b"\x93NUMPY\x01\x00".to_vec();
    header.extend_from_slice(&(text.len() as u16).to_le_bytes());
    header.extend_from_slice(text.as_bytes());
    header
}
