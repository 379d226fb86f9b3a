//! Runs the program as a user does.
#![allow(dead_code, reason = "each test uses its part")]

pub(crate) mod models;

use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// An empty folder for one test.
pub(crate) struct Folder(pub(crate) PathBuf);

impl Folder {
    pub(crate) fn new(name: &str) -> Self {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
        let _ = fs::remove_dir_all(&path);
        fs::create_dir_all(&path).unwrap();
        Self(path)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.0.join(name), text).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.0.join(name)).unwrap_or_else(|error| panic!("{name}: {error}"))
    }

    /// Names of the files in the folder, sorted.
    pub(crate) fn files(&self) -> Vec<String> {
        let entries = fs::read_dir(&self.0).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs `stiction` in this folder.
    pub(crate) fn stiction<S: AsRef<str>>(&self, arguments: &[S]) -> Said {
        Said::from(self.command(arguments).output().unwrap())
    }

    /// Runs `stiction` with a text on its standard input.
    pub(crate) fn stiction_given<S: AsRef<str>>(&self, arguments: &[S], text: &str) -> Said {
        let mut child = self.spawned(self.command(arguments).stdin(Stdio::piped()));
        child.stdin.take().unwrap().write_all(text.as_bytes()).unwrap();
        Said::from(child.wait_with_output().unwrap())
    }

    /// The command `stiction` in this folder.
    pub(crate) fn command<S: AsRef<str>>(&self, arguments: &[S]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_stiction"));
        command.current_dir(&self.0).env("NO_COLOR", "1");
        command.args(arguments.iter().map(AsRef::as_ref));
        command
    }

    /// Starts a run and waits until its output appears in the folder.
    pub(crate) fn begin(&self, arguments: &[&str], has_begun: impl Fn() -> bool) -> Child {
        let child = self.spawned(&mut self.command(arguments));
        let begun = Instant::now();
        while !has_begun() {
            assert!(begun.elapsed().as_secs() < 60, "nothing is written");
            std::thread::sleep(Duration::from_millis(5));
        }
        child
    }

    fn spawned(&self, command: &mut Command) -> Child {
        command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap()
    }
}

/// Output and exit code of a program.
#[derive(Debug)]
pub(crate) struct Said {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl From<Output> for Said {
    fn from(output: Output) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self {
            code: output.status.code().expect("it was not killed"),
            out: text(output.stdout),
            err: text(output.stderr),
        }
    }
}

impl Said {
    /// Asserts that the program ended with exit code `code` and that its messages contain all of
    /// `texts`, wherever lines are broken.
    #[track_caller]
    pub(crate) fn fails(&self, code: i32, texts: &[&str]) {
        assert_eq!(self.code, code, "{}{}", self.out, self.err);
        let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
        for text in texts {
            assert!(words(&self.err).contains(&words(text)), "no `{text}` in:\n{}", self.err);
        }
    }

    /// Asserts that the program ended with exit code 0; returns its output.
    #[track_caller]
    pub(crate) fn succeeds(&self) -> &str {
        assert_eq!(self.code, 0, "{}{}", self.out, self.err);
        &self.out
    }
}

/// Parses a JSON text.
pub(crate) fn json(text: &str) -> serde_json::Value {
    serde_json::from_str(text).unwrap_or_else(|error| panic!("{error}: {text}"))
}

/// Numbers of a column, given its complete name.
pub(crate) fn column(table: &str, name: &str) -> Vec<f64> {
    let mut lines = table.lines();
    let header: Vec<&str> = lines.next().unwrap().split(',').collect();
    let place = header.iter().position(|cell| *cell == name);
    let place = place.unwrap_or_else(|| panic!("no column {name} in {header:?}"));
    lines.map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
}
