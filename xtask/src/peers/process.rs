//! Protocol between this program and a running harness, see `peers/harness.hpp`.

use std::io::{BufRead, BufReader, Write};
use std::process::{Child, ChildStdin, ChildStdout, Command, Stdio};

/// Computation that a harness can time.
pub(crate) struct Subject {
    pub(crate) name: String,
    /// Largest relative difference from the expected forces.
    pub(crate) difference: f64,
}

pub(crate) struct Process {
    pub(crate) name: &'static str,
    pub(crate) subjects: Vec<Subject>,
    child: Child,
    requests: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Process {
    pub(crate) fn start(name: &'static str, command: &mut Command) -> Result<Self, String> {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| format!("{name}: {error}"))?;
        let requests = child.stdin.take();
        let output = child.stdout.take().ok_or("no output")?;
        let mut process =
            Self { name, subjects: Vec::new(), child, requests, answers: BufReader::new(output) };
        loop {
            let line = process.line()?;
            let words: Vec<&str> = line.split_whitespace().collect();
            match words.as_slice() {
                ["ready"] => return Ok(process),
                ["subject", subject, difference] => {
                    let difference = difference.parse().map_err(|_| process.unexpected(&line))?;
                    process.subjects.push(Subject { name: subject.to_string(), difference });
                }
                _ => return Err(process.unexpected(&line)),
            }
        }
    }

    /// Runs `count` evaluations of a subject; returns the time of one, ns.
    pub(crate) fn batch(&mut self, subject: usize, count: usize) -> Result<f64, String> {
        let request = format!("{} {count}\n", self.subjects[subject].name);
        let stdin = self.requests.as_mut().ok_or("no input")?;
        stdin.write_all(request.as_bytes()).map_err(|error| format!("{}: {error}", self.name))?;
        let line = self.line()?;
        let time: f64 = line.trim().parse().map_err(|_| self.unexpected(&line))?;
        if time.is_finite() && time > 0.0 { Ok(time) } else { Err(self.unexpected(&line)) }
    }

    fn line(&mut self) -> Result<String, String> {
        let mut line = String::new();
        match self.answers.read_line(&mut line) {
            Ok(0) => Err(format!("{} has ended", self.name)),
            Ok(_) => Ok(line),
            Err(error) => Err(format!("{}: {error}", self.name)),
        }
    }

    fn unexpected(&self, line: &str) -> String {
        format!("{} sent the unexpected line `{}`", self.name, line.trim())
    }
}

impl Drop for Process {
    /// Closes the standard input of the harness, which then exits.
    fn drop(&mut self) {
        self.requests = None;
        // The exit status is irrelevant.
        let _ = self.child.wait();
    }
}
