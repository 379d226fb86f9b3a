//! Display of the progress of computations that take longer than two seconds.

use crate::manners;
use indicatif::{HumanDuration, ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};
use stiction_run::inverse::Phase;

const PATIENCE: Duration = Duration::from_secs(2);
/// Time between two progress lines if standard error is not a terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Unit of the steps of an identification. Steps are repeated until the result no longer changes, so
/// their remaining time is unknown.
const PARTS: &str = "parts";

/// Display of the progress of a long computation: a bar on a terminal, otherwise a line every ten
/// seconds.
pub(crate) struct Progress {
    begun: Instant,
    printed: Instant,
    bar: Option<(String, ProgressBar)>,
    watched: bool,
    /// Name and begin of the present phase.
    phase: (String, Instant),
    /// Index of the study step that was printed last.
    step: Option<usize>,
}

impl Progress {
    pub(crate) fn new() -> Self {
        let now = Instant::now();
        Self {
            begun: now,
            printed: now,
            bar: None,
            watched: std::io::stderr().is_terminal(),
            phase: (String::new(), now),
            step: None,
        }
    }

    /// Updates the progress after a sample of inverse dynamics.
    pub(crate) fn update(&mut self, phase: Phase, done: usize, of: usize) {
        self.update_samples(words(phase), done, of);
    }

    /// Updates the progress of the computation named `phase` after a sample.
    pub(crate) fn update_samples(&mut self, phase: &str, done: usize, of: usize) {
        self.update_amount(phase, (done as u64, of as u64), "samples");
    }

    /// Updates the progress of a parameter study after a design.
    pub(crate) fn update_designs(&mut self, done: u64, of: u64) {
        self.update_amount("computing designs", (done, of), "designs");
    }

    /// Updates the progress of the search for an exciting motion after a step.
    pub(crate) fn update_search(&mut self, done: usize, of: usize) {
        self.update_amount("improving the motion", (done as u64, of as u64), "steps");
    }

    /// Updates the progress of reading a file; `done` and `of` are numbers of bytes.
    pub(crate) fn update_bytes(&mut self, file: &str, done: u64, of: u64) {
        const MEGA: u64 = 1_000_000;
        self.update_amount(&format!("reading {file}"), (done / MEGA, of.div_ceil(MEGA)), "MB");
    }

    /// Updates the progress of the step `what` of an identification after one of its parts.
    pub(crate) fn update_parts(&mut self, what: &str, done: usize, of: usize) {
        self.update_amount(what, (done as u64, of as u64), PARTS);
    }

    fn update_amount(&mut self, phase: &str, (done, of): (u64, u64), unit: &str) {
        if self.phase.0 != phase {
            self.phase = (phase.to_owned(), Instant::now());
        }
        if self.begun.elapsed() < PATIENCE || manners::is_quiet() {
            return;
        }
        if self.watched {
            self.draw(phase, (done, of), unit);
        } else if self.printed.elapsed() > LINE_EVERY || self.printed == self.begun {
            self.printed = Instant::now();
            note!("{}", line(phase, (done, of), unit));
        }
    }

    fn draw(&mut self, phase: &str, (done, of): (u64, u64), unit: &str) {
        let is_current = self.bar.as_ref().is_some_and(|(drawn, _)| drawn == phase);
        if !is_current {
            self.clear();
            let bar = ProgressBar::with_draw_target(Some(of), ProgressDrawTarget::stderr());
            let style = match of {
                0 | 1 => "{msg}, {prefix}".to_owned(),
                _ => format!(
                    "{{msg}} [{{bar:30}}] {{human_pos}} of {{human_len}} {unit}, {{prefix}}"
                ),
            };
            bar.set_style(
                ProgressStyle::with_template(&style)
                    .unwrap_or_else(|_| ProgressStyle::default_bar())
                    .progress_chars("=> "),
            );
            bar.set_message(phase.to_owned());
            self.bar = Some((phase.to_owned(), bar));
        }
        let left = if unit == PARTS { None } else { left(self.phase.1.elapsed(), done, of) };
        let time = match left {
            Some(left) => format!("{:#} left", HumanDuration(left)),
            None => format!("{:#} so far", HumanDuration(self.begun.elapsed())),
        };
        if let Some((_, bar)) = &self.bar {
            bar.set_length(of);
            bar.set_prefix(time);
            bar.set_position(done);
        }
    }

    /// Prints the name `what` of the current step of a study; `done` is the index of this step,
    /// from 0. Repeated calls in one step print its name once.
    pub(crate) fn update_step(&mut self, what: &str, done: usize, of: usize) {
        if self.begun.elapsed() > PATIENCE && self.step != Some(done) {
            self.step = Some(done);
            note!("{} of {of}: {what}", done + 1);
        }
    }

    /// Removes the progress bar.
    pub(crate) fn clear(&mut self) {
        if let Some((_, bar)) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// Removes the progress bar at the end of the computation, whether it succeeds or fails.
impl Drop for Progress {
    fn drop(&mut self) {
        self.clear();
    }
}

/// Returns the text of a progress line. A phase with a single part has no number.
fn line(phase: &str, (done, of): (u64, u64), unit: &str) -> String {
    if of < 2 { phase.to_owned() } else { format!("{phase}: {done} of {of} {unit}") }
}

/// Estimates the remaining time of a phase from the time `elapsed` since it began; `None` if none of
/// its parts is done.
fn left(elapsed: Duration, done: u64, of: u64) -> Option<Duration> {
    let part = done as f64 / of as f64;
    let left = Duration::try_from_secs_f64(elapsed.as_secs_f64() * (1.0 - part) / part);
    left.ok().filter(|_| done > 0)
}

fn words(phase: Phase) -> &'static str {
    match phase {
        Phase::Motion => "following the motion",
        Phase::Forces => "computing forces",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_remaining_time_is_proportional_to_the_remaining_parts() {
        let elapsed = Duration::from_secs(6);
        assert_eq!(left(elapsed, 0, 100), None);
        assert_eq!(left(elapsed, 75, 100), Some(Duration::from_secs(2)));
        assert_eq!(left(elapsed, 100, 100), Some(Duration::ZERO));
        assert_eq!(left(elapsed, 0, 0), None);
    }

    #[test]
    fn single_parts_are_not_counted() {
        assert_eq!(line("simulating the closed loop", (0, 1), PARTS), "simulating the closed loop");
        assert_eq!(line("fitting", (3, 8), PARTS), "fitting: 3 of 8 parts");
    }
}
