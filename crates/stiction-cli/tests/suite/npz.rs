//! Tables as NumPy archives, written and read.

use crate::program::Folder;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::process::Command;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipArchive, ZipWriter};

/// Headers and numbers of the columns of an archive, in order; decoded here from the documented
/// format.
fn columns(folder: &Folder, name: &str) -> Vec<(String, Vec<f64>)> {
    let mut archive = ZipArchive::new(File::open(folder.0.join(name)).unwrap()).unwrap();
    let count = archive.len();
    let column = |index| {
        let mut file = archive.by_index(index).unwrap();
        let mut content = Vec::new();
        file.read_to_end(&mut content).unwrap();
        assert_eq!(content[..8], *b"\x93NUMPY\x01\x00");
        let length = 10 + usize::from(u16::from_le_bytes([content[8], content[9]]));
        assert_eq!(length % 64, 0);
        let header = std::str::from_utf8(&content[10..length]).unwrap();
        let (chunks, rest) = content[length..].as_chunks::<8>();
        assert!(rest.is_empty());
        let shape =
            format!("{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}", chunks.len());
        assert_eq!(header.trim_end(), shape);
        let name = file.name().unwrap().strip_suffix(".npy").unwrap().to_owned();
        (name, chunks.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect())
    };
    (0..count).map(column).collect()
}

fn same(folder: &Folder, csv: &str, npz: &str) {
    let text = folder.read(csv);
    let mut lines = text.lines();
    let columns = columns(folder, npz);
    let header: Vec<&str> = columns.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(lines.next().unwrap(), header.join(","));
    let mut rows = 0;
    for (row, line) in lines.enumerate() {
        for (cell, (name, numbers)) in line.split(',').zip(&columns) {
            assert_eq!(cell.parse::<f64>().unwrap().to_bits(), numbers[row].to_bits(), "{name}");
        }
        rows += 1;
    }
    assert!(rows > 1 && columns.iter().all(|(_, numbers)| numbers.len() == rows));
}

/// The archives contain the same numbers as the tables, bit by bit, and only the requested files
/// remain.
#[test]
fn archives_have_the_numbers_of_the_tables() {
    let folder = Folder::new("npz-tables");
    let run = |arguments: &[&str]| {
        let said = folder.stiction(arguments);
        assert_eq!(said.code, 0, "{}", said.err);
    };
    run(&["inverse", "five-bar", "-o", "a", "--format", "csv,npz"]);
    for table in ["inverse", "reactions", "friction", "bodies", "joints", "contributions"] {
        same(&folder, &format!("a/{table}.csv"), &format!("a/{table}.npz"));
    }
    let before = fs::read(folder.0.join("a/inverse.npz")).unwrap();
    run(&["inverse", "five-bar", "-o", "a", "--format", "npz"]);
    assert!(fs::read(folder.0.join("a/inverse.npz")).unwrap() == before, "equal runs, equal bytes");
    let files = Folder(folder.0.join("a")).files();
    assert!(!files.iter().any(|name| name.ends_with(".csv")), "{files:?}");
    run(&["inverse", "five-bar", "-o", "a"]);
    let files = Folder(folder.0.join("a")).files();
    assert!(!files.iter().any(|name| name.ends_with(".npz")), "{files:?}");
    run(&["forward", "five-bar", "--until", "0.1 s", "-o", "f", "--format", "csv,npz"]);
    same(&folder, "f/forward.csv", "f/forward.npz");
    same(&folder, "f/energy.csv", "f/energy.npz");
}

/// A program without MCAP support reports this before any computation.
#[cfg(not(feature = "mcap"))]
#[test]
fn mcap_is_refused_without_its_support() {
    let folder = Folder::new("mcap-refused");
    for command in ["inverse", "forward"] {
        let said = folder.stiction(&[command, "five-bar", "-o", "a", "--format", "mcap"]);
        assert_eq!(said.code, 2, "{}", said.err);
        assert!(said.err.contains("--features mcap"), "{}", said.err);
        assert!(!folder.0.join("a").exists());
    }
}

/// The joint states in an MCAP log of a run can be read as a recording.
#[cfg(feature = "mcap")]
#[test]
fn mcap_logs_have_the_joint_states() {
    let folder = Folder::new("mcap-tables");
    for (command, joints) in [("inverse", "joints"), ("forward", "forward")] {
        let said = folder.stiction(&[command, "four-bar", "-o", "a", "--format", "csv,mcap"]);
        assert_eq!(said.code, 0, "{}", said.err);
        let log = fs::read(folder.0.join(format!("a/{command}.mcap"))).unwrap();
        let text = stiction_format::csv_of_mcap(&log, false).unwrap();
        let table = fs::read_to_string(folder.0.join(format!("a/{joints}.csv"))).unwrap();
        let column = |text: &str, name: &str| -> Vec<f64> {
            let mut rows = text.lines().map(|row| row.split(','));
            let at = rows.next().unwrap().position(|header| header == name).unwrap();
            rows.map(|mut row| row.nth(at).unwrap().parse().unwrap()).collect()
        };
        let positions = column(&text, "A");
        assert!(positions.len() > 10);
        assert_eq!(positions, column(&table, "A.position [rad]"), "{command}");
        let again = folder.stiction(&[command, "four-bar", "-o", "b", "--format", "mcap"]);
        assert_eq!(again.code, 0, "{}", again.err);
        assert!(fs::read(folder.0.join(format!("b/{command}.mcap"))).unwrap() == log);
        assert!(!folder.0.join(format!("b/{joints}.csv")).exists());
    }
}

/// A recording gives the same results from an archive, stored or compressed, as from a CSV table.
#[test]
fn archives_are_recordings() {
    let folder = Folder::new("npz-recording");
    let motion = |t: f64| (0.05 * (2.0 * t).sin(), 0.38 + 0.03 * (3.0 * t).cos());
    let times: Vec<f64> = (0..101).map(|k| f64::from(k) / 100.0).collect();
    let mut csv = "time [s],tool.x [m],tool.y [mm]\n".to_owned();
    for &t in &times {
        let (x, y) = motion(t);
        csv += &format!("{t},{x},{}\n", 1000.0 * y);
    }
    folder.write("log.csv", &csv);
    let column = |of: &dyn Fn(f64) -> f64| times.iter().map(|t| of(*t)).collect::<Vec<_>>();
    let columns = [
        ("tool.x [m]", column(&|t| motion(t).0)),
        ("time", column(&|t| t)),
        ("tool.y [mm]", column(&|t| 1000.0 * motion(t).1)),
    ];
    for (file, method) in
        [("log.npz", CompressionMethod::Stored), ("small.npz", CompressionMethod::Deflated)]
    {
        let mut archive = ZipWriter::new(File::create(folder.0.join(file)).unwrap());
        for (name, numbers) in &columns {
            let options = SimpleFileOptions::default().compression_method(method);
            archive.start_file(format!("{name}.npy"), options).unwrap();
            let mut header = format!(
                "{{'descr': '<f8', 'fortran_order': False, 'shape': ({},), }}",
                numbers.len()
            );
            header += &" ".repeat(117 - header.len());
            header.push('\n');
            archive.write_all(b"\x93NUMPY\x01\x00").unwrap();
            archive.write_all(&(header.len() as u16).to_le_bytes()).unwrap();
            archive.write_all(header.as_bytes()).unwrap();
            numbers.iter().for_each(|number| archive.write_all(&number.to_le_bytes()).unwrap());
        }
        archive.finish().unwrap();
    }
    let results = |log: &str| {
        let said = folder.stiction(&["inverse", "five-bar", "--motion", log, "-o", "out"]);
        assert_eq!(said.code, 0, "{}", said.err);
        folder.read("out/inverse.csv")
    };
    let expected = results("log.csv");
    assert_eq!(results("log.npz"), expected);
    assert_eq!(results("small.npz"), expected);
    folder.write("bad.npz", "time,x\n");
    let said = folder.stiction(&["inverse", "five-bar", "--motion", "bad.npz"]);
    assert!(said.code == 2 && said.err.contains("not an NPZ archive"), "{}", said.err);
}

/// NumPy, if it is installed, reads the archives.
#[test]
fn numpy_reads_archives() {
    let folder = Folder::new("npz-numpy");
    assert_eq!(folder.stiction(&["inverse", "four-bar", "-o", "a", "--format", "csv,npz"]).code, 0);
    let script = "\
import sys
try:
    import numpy
except ImportError:
    sys.exit(3)
archive = numpy.load('a/inverse.npz')
table = numpy.loadtxt('a/inverse.csv', delimiter=',', skiprows=1)
names = open('a/inverse.csv').readline().strip().split(',')
assert list(archive.keys()) == names
for k, name in enumerate(names):
    assert numpy.array_equal(archive[name], table[:, k]), name
";
    match Command::new("python3").args(["-c", script]).current_dir(&folder.0).output() {
        Ok(output) if output.status.code() == Some(3) => {
            eprintln!("skipped: NumPy is not installed")
        }
        Err(_) => eprintln!("skipped: Python is not installed"),
        Ok(output) => {
            assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        }
    }
}
