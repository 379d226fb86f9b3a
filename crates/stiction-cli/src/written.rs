//! Notes on the files that a run wrote.

use crate::report;
use std::io::{IsTerminal, stderr};
use std::path::{Path, PathBuf};

/// Prints a note that names the folder with the results. Without a folder, the note names the
/// option that writes results.
pub(crate) fn note_folder(folder: Option<&Path>, files: &[PathBuf]) {
    // The report on all runs comes after the reports of the single runs.
    let report = files.iter().rev().find(|path| path.ends_with(report::FILE));
    let report = report.map_or(String::new(), |path| format!("; report: {}", path.display()));
    match folder {
        Some(folder) => note!("\nwrote {} files into {}{report}", files.len(), folder.display()),
        None => note_files(&[], false),
    }
}

/// Prints a note that names the written files. If the user asked for no files, the note names the
/// option that writes them.
pub(crate) fn note_files(files: &[PathBuf], is_asked: bool) {
    if is_asked {
        let names: Vec<String> = files.iter().map(|name| name.display().to_string()).collect();
        note!("\nwrote {}", names.join(", "));
    } else if stderr().is_terminal() {
        note!("\nTables and plots: add -o DIR");
    }
}
