//! Notes on the files that a run wrote.

use std::io::{IsTerminal, stderr};
use std::path::{Path, PathBuf};

/// Prints a note that names the folder with the results, or the option that writes them.
pub(crate) fn note_folder(folder: Option<&Path>, files: usize) {
    match folder {
        Some(folder) => note!("\nwrote {files} files into {}", folder.display()),
        None => note_files(&[], false),
    }
}

/// Prints a note that names the files that were written, or the option that writes them.
pub(crate) fn note_files(files: &[PathBuf], is_asked: bool) {
    if is_asked {
        let names: Vec<String> = files.iter().map(|name| name.display().to_string()).collect();
        note!("\nwrote {}", names.join(", "));
    } else if stderr().is_terminal() {
        note!("\nTables and plots: add -o DIR");
    }
}
