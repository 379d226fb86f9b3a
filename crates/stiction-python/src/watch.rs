//! Signals and progress during a computation.

use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use stiction::run::inverse::Phase;

/// Time between two checks for signals; the progress function is called at the same interval.
const EVERY: Duration = Duration::from_millis(50);

/// Checks for signals, such as Ctrl-C, and calls a progress function, at regular intervals.
///
/// An exception that a signal or the progress function raises stops the computation and is raised
/// again after it.
pub(crate) struct Watch {
    progress: Option<Py<PyAny>>,
    state: Mutex<State>,
}

struct State {
    last: Instant,
    raised: Option<PyErr>,
    /// The last pair `(done, of)` passed to the progress function.
    reported: Option<(usize, usize)>,
}

impl Watch {
    /// Starts the checks for signals.
    pub(crate) fn new(progress: Option<Py<PyAny>>) -> Self {
        let state = State { last: Instant::now(), raised: None, reported: None };
        Self { progress, state: Mutex::new(state) }
    }

    /// Reports that `done` of `of` samples are complete; returns false if the computation must
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
        // The function may itself use this package, so nothing is locked while it runs.
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

    /// Reports that `done` of `of` samples are complete in one of the two phases of inverse dynamics; returns false if
    /// the computation must stop.
    pub(crate) fn goes_on_in(&self, phase: Phase, done: usize, of: usize) -> bool {
        match phase {
            Phase::Motion => self.goes_on(done, 2 * of),
            Phase::Forces => self.goes_on(of + done, 2 * of),
        }
    }

    /// Stores an exception of a function of the caller, which then stops the computation.
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
