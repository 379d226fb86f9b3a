//! Results of inverse dynamics or of a simulation in memory: the tables and the summary that the
//! command line writes.

use crate::error::Error;
use crate::forward::{Forward, Plan};
use crate::inverse::Inverse;
use serde_json::Value;
use std::cell::Cell;
use stiction_run::forward::{self as simulated, Ending, EventRow, Outcome, Recorder, event_rows};
use stiction_run::inverse::{Columns, Phase, Sample, Summary, Verdict, write_summary};
use stiction_run::{Job, Sink, Table};

/// Results of inverse dynamics along a motion or of a simulation: the tables and the content of
/// `summary.json` that the command line writes.
#[derive(Clone, Debug)]
pub struct Tabulated {
    /// Tables, each with the name of its file.
    pub tables: Vec<Table>,
    /// Summary, with the keys of `summary.json`.
    pub summary: Value,
    /// Summary as text, as the command line prints it.
    pub text: String,
}

/// Tables, summary and events of a simulation.
#[derive(Debug)]
pub struct TabulatedSimulation {
    /// Tables and summary.
    pub results: Tabulated,
    /// Events, in the order of time.
    pub events: Vec<EventRow>,
    /// Outcome of the simulation: `Ok` if the simulation reached its end time or a stop condition
    /// and its energy balance closes, else the reason.
    pub ended: Result<(), Error>,
}

impl Inverse {
    /// Computes all samples and returns the tables and the summary. Reports progress: the phase,
    /// the number of samples done, and their total number; stops when `progress` returns `false`.
    ///
    /// ```
    /// let robot = stiction::Robot::builtin("five-bar")?;
    /// let results = robot.inverse().tabulate(|_phase, _done, _of| true)?;
    /// assert_eq!(results.tables[0].header[0], "time [s]");
    /// # Ok::<(), stiction::Error>(())
    /// ```
    ///
    /// # Errors
    /// See [`Inverse::record`].
    pub fn tabulate(
        &self,
        progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<Tabulated, Error> {
        let job = self.job()?;
        let mut columns = Columns::new(&job);
        let (summary, verdict, text) = self.summarise(&job, &mut columns, progress)?;
        Ok(Tabulated { tables: columns.finish(), summary: summary.json(&job, &verdict), text })
    }

    /// Computes all samples and passes them to `sink`. Returns the summary, the verdict, and a text
    /// that contains both.
    pub(crate) fn summarise(
        &self,
        job: &Job<'_>,
        sink: &mut impl Sink<Sample>,
        progress: impl FnMut(Phase, usize, usize) -> bool,
    ) -> Result<(Summary, Verdict, String), Error> {
        let mut summary = Summary::new(job);
        let verdict = self.record((sink, &mut summary), progress)?;
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = write_summary(&mut text, job, &summary, &verdict);
        Ok((summary, verdict, text))
    }
}

impl Forward {
    /// Simulates and returns the tables and the summary; see [`Plan::tabulate`].
    ///
    /// # Errors
    /// The options contradict each other, or the robot cannot start.
    pub fn tabulate(
        &self,
        progress: impl Fn(usize, usize) -> bool,
    ) -> Result<TabulatedSimulation, Error> {
        self.plan()?.tabulate(progress)
    }
}

impl Plan {
    /// Simulates and returns the tables and the summary. Reports progress, also between samples:
    /// the number of samples done and their total number; stops when `progress` returns `false`.
    ///
    /// # Errors
    /// The robot cannot start. A simulation that fails later is no error: see
    /// [`TabulatedSimulation::ended`].
    pub fn tabulate(
        &self,
        progress: impl Fn(usize, usize) -> bool,
    ) -> Result<TabulatedSimulation, Error> {
        let job = self.job();
        let (columns, summary, outcome, text) =
            self.summarise(&job, simulated::Columns::new(&job), progress)?;
        let events = event_rows(&summary, &outcome.events);
        let tables = columns.finish();
        let json = summary.json(&job, &outcome);
        let ended = ended(&job, &summary, outcome);
        let results = Tabulated { tables, summary: json, text };
        Ok(TabulatedSimulation { results, events, ended })
    }

    /// Simulates and passes the rows of all samples to `sink`. Returns the sink, the summary, the
    /// outcome, and a text that contains summary and outcome.
    pub(crate) fn summarise<S: Sink<simulated::Rows>>(
        &self,
        job: &simulated::Job<'_>,
        sink: S,
        progress: impl Fn(usize, usize) -> bool,
    ) -> Result<(S, simulated::Summary, Outcome, String), Error> {
        let of = job.instants()?.count();
        let mut recorder = Recorder::new(job, (sink, simulated::Summary::new(job)));
        let done = Cell::new(0);
        let outcome = self.record(
            |sample, _checkpoint| {
                done.set(done.get() + 1);
                recorder.add(sample)
            },
            &|| !progress(done.get(), of),
            None,
        )?;
        let (sink, summary) = recorder.sink;
        let mut text = String::new();
        // Writing to a string does not fail.
        let _ = simulated::write_summary(&mut text, job, &summary, &outcome);
        Ok((sink, summary, outcome, text))
    }
}

/// Outcome of a simulation: `Ok` if the simulation reached its end time or a stop condition and its
/// energy balance closes, else the reason.
pub(crate) fn ended(
    job: &simulated::Job<'_>,
    summary: &simulated::Summary,
    outcome: Outcome,
) -> Result<(), Error> {
    let lost = summary.energy_lost(&job.settings, &outcome.events);
    match (outcome.ending, lost) {
        (Ending::Reached | Ending::Stopped(_), None) => Ok(()),
        (Ending::Reached | Ending::Stopped(_), Some(part)) => Err(energy_lost(part)),
        (Ending::Interrupted, _) => {
            Err(Error::interrupted(format!("interrupted at t = {} s", outcome.last)))
        }
        (Ending::Failed(error), _) => Err((*error).into()),
    }
}

/// Creates the error for a simulation whose energy balance has the relative error `part`.
pub fn energy_lost(part: f64) -> Error {
    Error::no_answer(format!(
        "the energy balance does not close: its relative error is {part:.1e}, so these results are wrong by \
         more than their tolerance"
    ))
    .with_help("give another tolerance or method; the column `error` of energy.csv shows when the error arises")
    .with_option("tolerance")
    .with_details(serde_json::json!({ "energy_error_relative": part }))
}
