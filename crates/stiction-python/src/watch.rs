//! Signals and progress during a computation.

use pyo3::prelude::*;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Time between looks at signals and calls of the progress function.
const EVERY: Duration = Duration::from_millis(50);

/// Looks at signals, such as Ctrl-C, and calls a progress function now and then.
///
/// An exception of either stops the computation and is raised after it.
pub(crate) struct Watch {
    progress: Option<Py<PyAny>>,
    state: Mutex<State>,
}

struct State {
    last: Instant,
    raised: Option<PyErr>,
    /// The last pair that the progress function got.
    reported: Option<(usize, usize)>,
}

impl Watch {
    /// Starts to watch.
    pub(crate) fn new(progress: Option<Py<PyAny>>) -> Self {
        let state = State { last: Instant::now(), raised: None, reported: None };
        Self { progress, state: Mutex::new(state) }
    }

    /// Tests if the computation goes on; `done` of `of` samples are complete.
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
        // The function may itself use this package: nothing is locked while it runs.
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

    /// Keeps an exception of a function of the caller, which then stops the computation.
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
