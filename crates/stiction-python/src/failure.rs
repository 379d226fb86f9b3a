//! Conversion of errors and panics to exceptions of the Python package.

use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;
use pyo3::types::PyType;
use std::panic::{AssertUnwindSafe, catch_unwind};
use stiction::{Error, ErrorKind};

static RAISED: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

/// Returns the package's Python function that creates an exception from an error.
fn maker(py: Python<'_>) -> PyResult<&Bound<'_, PyAny>> {
    let find = || Ok::<_, PyErr>(py.import("stiction._errors")?.getattr("_from_native")?.unbind());
    Ok(RAISED.get_or_try_init(py, find)?.bind(py))
}

/// Creates the Python exception for an error of the library.
pub(crate) fn exception(py: Python<'_>, error: &Error) -> PyErr {
    let kind = match error.kind() {
        _ if error.diagnostics().is_some() => "model",
        ErrorKind::NoAnswer => "no-answer",
        ErrorKind::Interrupted => "interrupted",
        ErrorKind::Output => "output",
        _ => "input",
    };
    make(py, (kind, error.message(), error.help(), error.option(), error.to_json().to_string()))
}

/// Creates the Python exception for invalid input; `help` is the suggestion.
pub(crate) fn input(py: Python<'_>, message: &str, help: &str) -> PyErr {
    make(py, ("input", message.to_owned(), Some(help), None, "{}".to_owned()))
}

type Content<'a> = (&'static str, String, Option<&'a str>, Option<&'static str>, String);

fn make(py: Python<'_>, content: Content<'_>) -> PyErr {
    match maker(py).and_then(|maker| maker.call1(content)) {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// Runs a function and converts a panic to a Python exception.
pub(crate) fn guarded<T>(py: Python<'_>, run: impl FnOnce() -> PyResult<T>) -> PyResult<T> {
    catch_unwind(AssertUnwindSafe(run)).unwrap_or_else(|panic| {
        let text = panic
            .downcast_ref::<&str>()
            .map(|text| (*text).to_owned())
            .or_else(|| panic.downcast_ref::<String>().cloned())
            .unwrap_or_default();
        let help =
            "this is a defect of the program; please report it with the input that caused it";
        Err(make(py, ("internal", text, Some(help), None, "{}".to_owned())))
    })
}

/// Runs `compute` without the lock of the Python interpreter; converts errors and panics to
/// exceptions.
pub(crate) fn computed<T: Send>(
    py: Python<'_>,
    compute: impl FnOnce() -> Result<T, Error> + Send,
) -> PyResult<T> {
    guarded(py, || py.detach(compute).map_err(|error| exception(py, &error)))
}

/// Returns the name of the type of a Python object, for messages.
pub(crate) fn type_name(object: &Bound<'_, PyAny>) -> String {
    let of: Bound<'_, PyType> = object.get_type();
    of.name().map_or_else(|_| "object".to_owned(), |name| name.to_string())
}
