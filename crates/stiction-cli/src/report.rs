//! Reports: choice of their folder, the command line that they show, and opening them in a browser.

use crate::arguments::{Report, Switch};
use crate::failure::Failure;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// File name of the report of a run.
pub(crate) const FILE: &str = "report.html";

impl Report {
    /// Returns whether reports are to be written.
    pub(crate) fn is_on(self) -> bool {
        self.report == Switch::On
    }

    /// Returns the folder of the results: that of `-o`, or a temporary folder if only `--open` is
    /// given. Without both options, returns `None`.
    pub(crate) fn folder(self, output: Option<&Path>) -> Result<Option<PathBuf>, Failure> {
        if self.open && !self.is_on() {
            return Err(Failure::input(
                "--open opens the report, but --report off writes no report",
            )
            .help("omit one of the two options"));
        }
        Ok(match output {
            None if self.open => {
                let name = format!("stiction-{}", std::process::id());
                Some(std::env::temp_dir().join(name))
            }
            output => output.map(Path::to_owned),
        })
    }

    /// Opens the report in `folder` in a browser if the user requested it.
    pub(crate) fn show(self, folder: Option<&Path>) {
        let Some(folder) = folder.filter(|_| self.open) else { return };
        let file = folder.join(FILE);
        if !open(&file) {
            note!("no browser could be started: open {} in a browser", file.display());
        }
    }
}

/// Starts the browser named by the environment variable `BROWSER`, or the default browser of the
/// system. Returns whether a browser was started.
fn open(file: &Path) -> bool {
    let own = std::env::var_os("BROWSER").filter(|program| !program.is_empty());
    let systems: &[&str] = if cfg!(target_os = "macos") {
        &["open"]
    } else if cfg!(windows) {
        &["explorer"]
    } else {
        &["xdg-open", "gio"]
    };
    let programs = own.into_iter().chain(systems.iter().map(Into::into));
    let start = |program: std::ffi::OsString| {
        let mut command = Command::new(&program);
        if program == "gio" {
            command.arg("open");
        }
        command.arg(file).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
        command.spawn().is_ok()
    };
    programs.into_iter().any(start)
}

/// Options that do not change the results; the command line in a report omits them.
const PASSING: [&str; 5] = ["--resume", "--json", "--open", "--quiet", "-q"];

/// Returns the command line of this run, quoted for a shell, without the options [`PASSING`].
pub(crate) fn command_line() -> String {
    let given = std::env::args_os().skip(1).map(|word| word.to_string_lossy().into_owned());
    let words = given.filter(|word| !PASSING.contains(&word.as_str())).map(|word| quoted(&word));
    std::iter::once("stiction".to_owned()).chain(words).collect::<Vec<_>>().join(" ")
}

/// Puts a word in quotes if a shell would otherwise change it.
fn quoted(word: &str) -> String {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_./=,:+%@".contains(c);
    if !word.is_empty() && word.chars().all(is_plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_are_quoted_for_a_shell() {
        assert_eq!(quoted("mu=0.2"), "mu=0.2");
        assert_eq!(quoted("A = 60 deg"), "'A = 60 deg'");
        assert_eq!(quoted("it's"), "'it'\\''s'");
        assert_eq!(quoted(""), "''");
    }
}
