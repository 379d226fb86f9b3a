//! Checks for signals and reports of progress to Python during a computation.

use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use stiction::run::inverse::Phase;

/// Time between two checks for signals, and between two calls of the progress function.
const EVERY: Duration = Duration::from_millis(50);

/// Checks for signals, such as Ctrl-C, and calls a progress function of the Python caller, at
/// regular intervals during a computation.
///
/// An exception that a signal or the progress function raises stops the computation. The exception
/// is raised again after the computation has stopped.
pub(crate) struct Watch {
    progress: Option<Py<PyAny>>,
    state: Mutex<State>,
}

struct State {
    last: Instant,
    raised: Option<PyErr>,
    /// Latest pair of samples done and total number of samples that was reported; `None` before the
    /// first report.
    reported: Option<(usize, usize)>,
}

impl Watch {
    /// Creates a watch that calls the given progress function, if any.
    pub(crate) fn new(progress: Option<Py<PyAny>>) -> Self {
        let state = State { last: Instant::now(), raised: None, reported: None };
        Self { progress, state: Mutex::new(state) }
    }

    /// Reports that `done` of `of` samples are complete; returns `false` if the computation must
    /// stop.
    pub(crate) fn goes_on(&self, done: usize, of: usize) -> bool {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if state.raised.is_some() {
            return false;
        }
        let ends = done == of && self.progress.is_some() && state.reported != Some((done, of));
        if state.last.elapsed() < EVERY && !ends {
            return true;
        }
        state.last = Instant::now();
        state.reported = Some((done, of));
        // The progress function may itself use this package, so `state` is not locked while the
        // function runs.
        drop(state);
        let outcome = Python::attach(|py| {
            py.check_signals()?;
            let Some(progress) = &self.progress else { return Ok(()) };
            progress.call1(py, (done, of)).map(|_| ())
        });
        match outcome {
            Ok(()) => true,
            Err(error) => {
                let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
                state.raised.get_or_insert(error);
                false
            }
        }
    }

    /// Reports that `done` of `of` samples are complete in one of the two phases of inverse
    /// dynamics, motion and forces; returns `false` if the computation must stop.
    pub(crate) fn goes_on_in(&self, phase: Phase, done: usize, of: usize) -> bool {
        match phase {
            Phase::Motion => self.goes_on(done, 2 * of),
            Phase::Forces => self.goes_on(of + done, 2 * of),
        }
    }

    /// Stores an exception that a function of the Python caller raised, so that [`Self::finish`]
    /// returns it.
    pub(crate) fn keep(&self, error: PyErr) {
        self.state.lock().unwrap_or_else(PoisonError::into_inner).raised.get_or_insert(error);
    }

    /// Returns the result of the computation, or the exception that stopped it.
    pub(crate) fn finish<T>(&self, result: PyResult<T>) -> PyResult<T> {
        let raised = self.state.lock().unwrap_or_else(PoisonError::into_inner).raised.take();
        match raised {
            Some(error) => Err(error),
            None => result,
        }
    }
}
