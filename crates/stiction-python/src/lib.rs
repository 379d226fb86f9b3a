//! Native part of the Python package `stiction`. It converts data between Python and the library
//! and contains no mechanics.
//!
//! The package's Python files (`python/stiction`) add names, documentation and types to the results
//! of this module. Every function releases the interpreter's lock while it computes, checks for
//! signals, and raises an exception of the package for every failure, including panics.

mod arrays;
mod failure;
mod model;
mod options;
mod states;
mod sweep;
mod tables;
mod watch;

use pyo3::prelude::*;

/// Native module of the package `stiction`; not for direct use.
#[pymodule(name = "_native")]
mod native {
    #[pymodule_export]
    use crate::model::NativeModel;
    #[pymodule_export]
    use crate::states::NativeStates;
    use pyo3::prelude::*;

    /// Names of the built-in models.
    #[pyfunction]
    fn gallery() -> Vec<&'static str> {
        stiction::gallery::names().collect()
    }

    /// Names and explanations of all outcomes of a row in a batch of states, in the order of the
    /// outcome codes.
    #[pyfunction]
    fn outcomes() -> Vec<(&'static str, &'static str)> {
        crate::states::OUTCOMES
            .iter()
            .map(|status| (stiction::status_name(*status), stiction::status_reason(*status)))
            .collect()
    }

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
