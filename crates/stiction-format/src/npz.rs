//! Converts recordings in NumPy archives (NPZ) to CSV tables.

use std::fmt::Write;
use std::io::{Cursor, Read};
use zip::ZipArchive;

/// Maximum total size of the unpacked arrays of an archive, bytes.
const LARGEST: u64 = 1 << 30;

/// An array of the archive, which becomes a column of the table.
struct Column {
    name: String,
    numbers: Vec<f64>,
}

/// Converts the arrays of an NPZ archive to a table in CSV, with a column for each array and the time first. Names of
/// arrays are column headers such as `platform.x [mm]`; `time` without a unit is in seconds.
///
/// # Errors
/// Returns the reason as the end of the sentence "cannot read FILE: ".
pub fn csv_of_npz(bytes: &[u8]) -> Result<String, String> {
    let mut archive = ZipArchive::new(Cursor::new(bytes)).map_err(|error| {
        format!("it is not an NPZ archive ({error}); write it with numpy.savez")
    })?;
    let mut columns = Vec::new();
    let mut left = LARGEST;
    for index in 0..archive.len() {
        let file = archive.by_index(index).map_err(|error| error.to_string())?;
        let name = file.name().map_err(|error| error.to_string())?;
        let name = name.strip_suffix(".npy").unwrap_or(&name).to_owned();
        let mut content = Vec::new();
        let read = file.take(left + 1).read_to_end(&mut content);
        read.map_err(|error| format!("the array `{name}` is damaged: {error}"))?;
        left = left
            .checked_sub(content.len() as u64)
            .ok_or_else(|| "its arrays are larger than 1 GB in total".to_owned())?;
        let numbers = array(&content).map_err(|why| format!("the array `{name}` {why}"))?;
        if name.contains(['"', '\n', '\r', ',']) {
            return Err(format!("the array name {name:?} cannot be used as a column name"));
        }
        columns.push(Column { name, numbers });
    }
    let is_time = |column: &Column| column.name == "time" || column.name.starts_with("time [");
    let time = columns.iter().position(is_time).ok_or_else(|| {
        let names: Vec<&str> = columns.iter().take(8).map(|column| column.name.as_str()).collect();
        format!("it has no array `time`; its arrays are {}", names.join(", "))
    })?;
    columns[..=time].rotate_right(1);
    let count = columns[0].numbers.len();
    if let Some(other) = columns.iter().find(|column| column.numbers.len() != count) {
        return Err(format!(
            "the array `{}` has {} numbers, `{}` has {count}",
            other.name,
            other.numbers.len(),
            columns[0].name
        ));
    }
    let mut out = String::new();
    let names: Vec<&str> = columns.iter().map(|column| column.name.as_str()).collect();
    out += &names.join(",").replacen("time,", "time [s],", usize::from(names[0] == "time"));
    out.push('\n');
    for row in 0..count {
        for (k, column) in columns.iter().enumerate() {
            let comma = if k > 0 { "," } else { "" };
            // Writing to a string cannot fail. The digits are the fewest that read back as the same number.
            let _ = write!(out, "{comma}{:e}", column.numbers[row]);
        }
        out.push('\n');
    }
    Ok(out)
}

/// Reads the numbers of an array in NumPy's format NPY. The array must be one-dimensional, or have
/// a single row or column.
fn array(content: &[u8]) -> Result<Vec<f64>, String> {
    let not_array = || "is not a NumPy array".to_owned();
    let rest = content.strip_prefix(b"\x93NUMPY").ok_or_else(not_array)?;
    let (version, rest) = rest.split_first_chunk::<2>().ok_or_else(not_array)?;
    let (length, rest) = match version[0] {
        1 => rest.split_first_chunk().map(|(n, rest)| (usize::from(u16::from_le_bytes(*n)), rest)),
        2 | 3 => rest.split_first_chunk().map(|(n, rest)| (u32::from_le_bytes(*n) as usize, rest)),
        _ => return Err(format!("has version {} of the format, which is unknown", version[0])),
    }
    .ok_or_else(not_array)?;
    let (header, data) = rest.split_at_checked(length).ok_or_else(not_array)?;
    let header = String::from_utf8_lossy(header);
    let after = |key: &str| {
        let (_, rest) = header.split_once(key)?;
        Some(rest.trim_start().strip_prefix(':')?.trim_start())
    };
    let descr = after("'descr'").and_then(|rest| rest.strip_prefix('\'')?.split('\'').next());
    let descr = descr
        .ok_or_else(|| "is a structured array; write a plain one for each column".to_owned())?;
    let shape = after("'shape'").and_then(|rest| rest.strip_prefix('(')?.split(')').next());
    let shape = shape.ok_or_else(not_array)?;
    let lengths: Option<Vec<usize>> = shape
        .split(',')
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .map(|part| part.trim_end_matches('L').parse().ok())
        .collect();
    let lengths = lengths.ok_or_else(not_array)?;
    if lengths.is_empty() || lengths.iter().filter(|length| **length != 1).count() > 1 {
        return Err(format!(
            "has the shape ({shape}); write a one-dimensional array for each column"
        ));
    }
    let count: usize = lengths.iter().product();
    let numbers = numbers(descr, data)
        .ok_or_else(|| format!("has the type `{descr}`; write floating-point or whole numbers"))?;
    if numbers.len() != count {
        return Err(format!("has {} numbers, its header says {count}", numbers.len()));
    }
    Ok(numbers)
}

/// Decodes real numbers of a NumPy type such as `<f8`; returns `None` if the type is not supported.
fn numbers(descr: &str, data: &[u8]) -> Option<Vec<f64>> {
    let (order, kind) = descr.split_at_checked(1)?;
    let is_big = match order {
        "<" | "|" => false,
        ">" => true,
        "=" => cfg!(target_endian = "big"),
        _ => return None,
    };
    fn all<const N: usize>(data: &[u8], is_big: bool, read: fn([u8; N]) -> f64) -> Vec<f64> {
        let (chunks, _) = data.as_chunks::<N>();
        let one = |chunk: &[u8; N]| {
            let mut bytes = *chunk;
            if is_big {
                bytes.reverse();
            }
            read(bytes)
        };
        chunks.iter().map(one).collect()
    }
    Some(match kind {
        "f8" => all(data, is_big, f64::from_le_bytes),
        "f4" => all(data, is_big, |bytes| f64::from(f32::from_le_bytes(bytes))),
        "i8" => all(data, is_big, |bytes| i64::from_le_bytes(bytes) as f64),
        "i4" => all(data, is_big, |bytes| f64::from(i32::from_le_bytes(bytes))),
        "i2" => all(data, is_big, |bytes| f64::from(i16::from_le_bytes(bytes))),
        "i1" => all(data, is_big, |bytes| f64::from(i8::from_le_bytes(bytes))),
        "u8" => all(data, is_big, |bytes| u64::from_le_bytes(bytes) as f64),
        "u4" => all(data, is_big, |bytes| f64::from(u32::from_le_bytes(bytes))),
        "u2" => all(data, is_big, |bytes| f64::from(u16::from_le_bytes(bytes))),
        "u1" => all(data, is_big, |bytes| f64::from(u8::from_le_bytes(bytes))),
        _ => return None,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Creates an array file as `numpy.save` writes it, with a header of version 1.0 padded to a
    /// multiple of 64 bytes.
    fn npy(descr: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let mut text =
            format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': {shape}, }}");
        while (11 + text.len()) % 64 != 0 {
            text.push(' ');
        }
        text.push('\n');
        let mut file = b"\x93NUMPY\x01\x00".to_vec();
        file.extend((text.len() as u16).to_le_bytes());
        file.extend(text.as_bytes());
        file.extend(data);
        file
    }

    #[test]
    fn numbers_of_all_types() {
        let doubles: Vec<u8> = [1.5_f64, -2.0].iter().flat_map(|x| x.to_be_bytes()).collect();
        assert_eq!(array(&npy(">f8", "(2,)", &doubles)), Ok(vec![1.5, -2.0]));
        let singles: Vec<u8> = [0.25_f32].iter().flat_map(|x| x.to_le_bytes()).collect();
        assert_eq!(array(&npy("<f4", "(1, 1)", &singles)), Ok(vec![0.25]));
        assert_eq!(array(&npy("<i2", "(2, 1)", &[0xff, 0xff, 3, 0])), Ok(vec![-1.0, 3.0]));
        assert_eq!(array(&npy("|u1", "(3,)", &[1, 2, 255])), Ok(vec![1.0, 2.0, 255.0]));
    }

    #[test]
    fn other_arrays_are_refused() {
        let why = |file: &[u8]| array(file).unwrap_err();
        assert!(why(b"PK").contains("not a NumPy array"));
        assert!(why(&npy("<f8", "(2, 2)", &[0; 32])).contains("one-dimensional"));
        assert!(why(&npy("<f8", "()", &[0; 8])).contains("one-dimensional"));
        assert!(why(&npy("<c16", "(1,)", &[0; 16])).contains("`<c16`"));
        assert!(why(&npy("|O", "(1,)", &[0; 16])).contains("`|O`"));
        assert!(why(&npy("<f8", "(3,)", &[0; 16])).contains("has 2 numbers, its header says 3"));
        for end in 0..100 {
            // Checks that truncated files cause no panic.
            let _ = array(&npy("<f8", "(1,)", &[0; 8])[..end]);
        }
        assert!(csv_of_npz(b"time,x\n").unwrap_err().contains("not an NPZ archive"));
    }
}
