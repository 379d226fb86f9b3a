//! Progress of jobs that take longer than two seconds.

use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};
use stiction_run::inverse::Phase;

const PATIENCE: Duration = Duration::from_secs(2);
/// Where nobody watches a terminal, a line so often.
const LINE_EVERY: Duration = Duration::from_secs(10);

/// Tells how far a job is, once it takes long.
pub(crate) struct Progress {
    begun: Instant,
    told: Instant,
    bar: Option<(String, ProgressBar)>,
    watched: bool,
    /// The step of something that is no motion that was told last.
    step: Option<usize>,
}

impl Progress {
    pub(crate) fn new() -> Self {
        let now = Instant::now();
        Self {
            begun: now,
            told: now,
            bar: None,
            watched: std::io::stderr().is_terminal(),
            step: None,
        }
    }

    /// Called after every sample; looks at the clock now and then.
    pub(crate) fn tell(&mut self, phase: Phase, done: usize, of: usize) {
        self.tell_samples(words(phase), done, of);
    }

    /// The same for what has a name.
    pub(crate) fn tell_samples(&mut self, phase: &'static str, done: usize, of: usize) {
        self.tell_amount(phase, (done as u64, of as u64), "samples");
    }

    /// How much of a file has been read, bytes.
    pub(crate) fn tell_bytes(&mut self, file: &str, done: u64, of: u64) {
        const MEGA: u64 = 1_000_000;
        self.tell_amount(&format!("reading {file}"), (done / MEGA, of.div_ceil(MEGA)), "MB");
    }

    fn tell_amount(&mut self, phase: &str, (done, of): (u64, u64), unit: &str) {
        if self.begun.elapsed() < PATIENCE {
            return;
        }
        if self.watched {
            self.draw(phase, (done, of), unit);
        } else if self.told.elapsed() > LINE_EVERY || self.told == self.begun {
            self.told = Instant::now();
            tell!("{phase}: {done} of {of} {unit}");
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
            bar.set_position(done);
        }
    }

    /// Called now and then during each step of something that is no motion.
    pub(crate) fn tell_step(&mut self, what: &str, done: usize, of: usize) {
        if self.begun.elapsed() > PATIENCE && self.step != Some(done) {
            self.step = Some(done);
            tell!("{} of {of}: {what}", done + 1);
        }
    }

    /// Takes the bar away.
    pub(crate) fn clear(&mut self) {
        if let Some((_, bar)) = self.bar.take() {
            bar.finish_and_clear();
        }
    }
}

/// Whatever ends a job, its bar goes.
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
