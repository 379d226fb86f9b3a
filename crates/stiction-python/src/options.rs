//! Conversion of options of Python calls to values of the library.

use crate::failure::input;
use pyo3::prelude::*;
use std::num::NonZeroUsize;
use stiction::FrictionMode;

/// Converts the word of the option `friction` (`on`, `one-pass`, `off`) to a friction mode.
pub(crate) fn friction(py: Python<'_>, word: &str) -> PyResult<FrictionMode> {
    match word {
        "on" => Ok(FrictionMode::Converged),
        "one-pass" => Ok(FrictionMode::OnePass),
        "off" => Ok(FrictionMode::Off),
        _ => {
            let what = format!("`friction` is `{}`", word.escape_debug());
            Err(input(py, &what, "give True, False, \"on\", \"one-pass\" or \"off\""))
        }
    }
}

/// Converts the option `threads` to a number of threads; `None` selects the number of processor
/// cores.
pub(crate) fn threads(py: Python<'_>, threads: Option<usize>) -> PyResult<NonZeroUsize> {
    let cores = || std::thread::available_parallelism().unwrap_or(NonZeroUsize::MIN);
    match threads {
        None => Ok(cores()),
        Some(count) => match NonZeroUsize::new(count) {
            Some(count) if count.get() <= MOST_THREADS => Ok(count),
            _ => {
                let what = format!("`threads` is {count}");
                Err(input(py, &what, &format!("give a number from 1 to {MOST_THREADS}")))
            }
        },
    }
}

/// Largest number of threads that an option may request.
const MOST_THREADS: usize = 1024;
