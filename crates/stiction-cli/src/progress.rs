//! Display of the progress of computations that take longer than two seconds.

use crate::manners;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};
use stiction_run::inverse::Phase;

const PATIENCE: Duration = Duration::from_secs(2);
/// Time between two progress lines if standard error is not a terminal.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Display of the progress of a long computation: a bar on a terminal, otherwise a line every ten
/// seconds.
pub(crate) struct Progress {
    begun: Instant,
    printed: Instant,
    bar: Option<(String, ProgressBar)>,
    watched: bool,
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
            step: None,
        }
    }

    /// Updates the progress after a sample of inverse dynamics.
    pub(crate) fn update(&mut self, phase: Phase, done: usize, of: usize) {
        self.update_samples(words(phase), done, of);
    }

    /// Updates the progress of the computation named `phase` after a sample.
    pub(crate) fn update_samples(&mut self, phase: &'static str, done: usize, of: usize) {
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
        self.update_amount(what, (done as u64, of as u64), "parts");
    }

    fn update_amount(&mut self, phase: &str, (done, of): (u64, u64), unit: &str) {
        if self.begun.elapsed() < PATIENCE || manners::is_quiet() {
            return;
        }
        if self.watched {
            self.draw(phase, (done, of), unit);
        } else if self.printed.elapsed() > LINE_EVERY || self.printed == self.begun {
            self.printed = Instant::now();
            note!("{phase}: {done} of {of} {unit}");
        }
    }

    fn draw(&mut self, phase: &str, (done, of): (u64, u64), unit: &str) {
        let is_current = self.bar.as_ref().is_some_and(|(drawn, _)| drawn == phase);
        if !is_current {
            self.clear();
            let bar = ProgressBar::with_draw_target(Some(of), ProgressDrawTarget::stderr());
            let style =
                format!("{{msg}} [{{bar:30}}] {{human_pos}} of {{human_len}} {unit}, {{eta}} left");
            bar.set_style(
                ProgressStyle::with_template(&style)
                    .unwrap_or_else(|_| ProgressStyle::default_bar())
                    .progress_chars("=> "),
            );
            bar.set_message(phase.to_owned());
            self.bar = Some((phase.to_owned(), bar));
        }
        if let Some((_, bar)) = &self.bar {
            bar.set_length(of);
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

fn words(phase: Phase) -> &'static str {
    match phase {
        Phase::Motion => "following the motion",
        Phase::Forces => "computing forces",
    }
}
