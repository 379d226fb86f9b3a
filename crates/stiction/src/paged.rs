//! Results of inverse dynamics or of a simulation as an HTML page, the `report.html` that the
//! command line writes.

use crate::error::Error;
use crate::forward::Plan;
use crate::inverse::Inverse;
use crate::tabulated::ended;
use serde_json::Value;
use stiction_run::forward as simulated;
use stiction_run::inverse::{Animation, Curves, Phase, draw_report};

/// Report of inverse dynamics along a motion or of a simulation, in memory.
#[derive(Debug)]
pub struct Paged {
    /// The page: self-contained HTML with the moving robot, plots, tables and verdicts.
    pub page: String,
    /// Summary as text, as the command line prints it.
    pub text: String,
    /// Summary, with the keys of `summary.json`.
    pub summary: Value,
    /// `Ok` if the computation reached its end. Otherwise, the reason; the page then shows the
    /// results up to the time at which the computation ended.
    pub ended: Result<(), Error>,
}

impl Inverse {
    /// Computes all samples and draws their report. Reports progress: the phase, the number of samples done, and
    /// their total number; stops when `progress` returns `false`.
    ///
    /// ```
    /// let robot = stiction::Robot::builtin("five-bar")?;
    /// let report = robot.inverse().report(|_phase, _done, _of| true)?;
    /// assert!(report.page.starts_with("<!DOCTYPE html>"));
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// See [`Inverse::record`].
    pub fn report(
        &self,
        progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Paged, Error> {
        let job = self.job()?;
        let count = job.instants()?.count();
        let mut sinks = (Curves::new(&job, count), Animation::new(&job, count));
        let (summary, verdict, text) = self.summarise(&job, &mut sinks, progress)?;
        let (curves, animation) = sinks;
        let page = draw_report(&job, (&summary, &verdict), &curves.figures(), &animation, None);
        Ok(Paged { page, text, summary: summary.json(&job, &verdict), ended: Ok(()) })
    }
}

impl Plan {
    /// Simulates and returns the report. Reports progress, also between samples: the number of
    /// samples done and their total number; stops when `progress` returns `false`.
    ///
    /// # Errors
    /// The robot cannot start. A simulation that fails later is no error: see [`Paged::ended`].
    pub fn report(&self, progress: impl Fn(usize, usize) -> bool) -> Result<Paged, Error> {
        let job = self.job();
        let count = job.instants()?.count();
        let sinks = (simulated::Curves::new(&job, count), simulated::Animation::new(&job, count));
        let (sinks, summary, outcome, text) = self.summarise(&job, sinks, progress)?;
        let (curves, animation) = sinks;
        let figures = curves.figures(&summary, &outcome.events);
        let page = simulated::draw_report(&job, (&summary, &outcome), &figures, &animation, None);
        let json = summary.json(&job, &outcome);
        Ok(Paged { page, text, summary: json, ended: ended(&job, &summary, outcome) })
    }
}
