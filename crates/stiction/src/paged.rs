//! Results of a whole run as a page, the `report.html` that the command line writes.

use crate::error::Error;
use crate::forward::Plan;
use crate::inverse::Inverse;
use crate::tabulated::ended;
use serde_json::Value;
use std::cell::Cell;
use stiction_run::Sink;
use stiction_run::forward::{self as simulated, Recorder};
use stiction_run::inverse::{Animation, Curves, Phase, Summary, draw_report, write_summary};

/// Report of a whole run, in memory.
#[derive(Debug)]
pub struct Paged {
    /// The page: the moving robot, plots, tables and verdicts. Self-contained HTML.
    pub page: String,
    /// Summary as text, as the command line prints it.
    pub text: String,
    /// Summary, with the keys of `summary.json`.
    pub summary: Value,
    /// `Ok` if the run reached its end, else the reason; the page then shows the part up to there.
    pub ended: Result<(), Error>,
}

impl Inverse {
    /// Computes all samples and draws their report. Reports progress: the phase, the samples done, and all
    /// samples; stops when `progress` returns `false`.
    ///
    /// ```
    /// let robot = stiction::Robot::builtin("five-bar")?;
    /// let report = robot.inverse().report(|_phase, _done, _of| true)?;
    /// assert!(report.page.starts_with("<!DOCTYPE html>"));
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// As [`Inverse::record`].
    pub fn report(
        &self,
        progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Paged, Error> {
        let job = self.job()?;
        let count = job.instants()?.count();
        let (mut summary, mut curves) = (Summary::new(&job), Curves::new(&job, count));
        let mut animation = Animation::new(&job, count);
        let verdict = self.record((&mut summary, &mut curves, &mut animation), progress)?;
        let page = draw_report(&job, (&summary, &verdict), &curves.figures(), &animation, None);
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = write_summary(&mut text, &job, &summary, &verdict);
        Ok(Paged { page, text, summary: summary.json(&job, &verdict), ended: Ok(()) })
    }
}

impl Plan {
    /// Simulates and draws the report. Reports progress, also within a sample: the samples done and all
    /// samples; stops when `progress` returns `false`.
    ///
    /// # Errors
    /// The robot cannot start. Later failures are in the result.
    pub fn report(&self, progress: impl Fn(usize, usize) -> bool) -> Result<Paged, Error> {
        let job = self.job();
        let count = job.instants()?.count();
        let sinks = (
            simulated::Summary::new(&job),
            simulated::Curves::new(&job, count),
            simulated::Animation::new(&job, count),
        );
        let mut recorder = Recorder::new(&job, sinks);
        let done = Cell::new(0);
        let outcome = self.record(
            |sample, _checkpoint| {
                done.set(done.get() + 1);
                recorder.add(sample)
            },
            &|| !progress(done.get(), count),
            None,
        )?;
        let (summary, curves, animation) = recorder.sink;
        let figures = curves.figures(&summary, &outcome.events);
        let page = simulated::draw_report(&job, (&summary, &outcome), &figures, &animation, None);
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = simulated::write_summary(&mut text, &job, &summary, &outcome);
        let json = summary.json(&job, &outcome);
        Ok(Paged { page, text, summary: json, ended: ended(&job, &summary, outcome) })
    }
}
