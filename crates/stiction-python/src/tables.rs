//! Tables of a run as arrays.

use crate::arrays::array;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use stiction::{Error, Tabulated};

/// One table: its file name, its headers, and an array of shape (columns, rows).
type Table<'py> = (&'static str, Vec<String>, Bound<'py, PyArrayDyn<f64>>);
/// Tables of a run, the summary as JSON, and the summary as text.
pub(crate) type Results<'py> = (Vec<Table<'py>>, String, String);

/// Converts the results of a run to NumPy arrays and texts.
pub(crate) fn results(py: Python<'_>, tabulated: Tabulated) -> PyResult<Results<'_>> {
    let Tabulated { tables, summary, text } = tabulated;
    let tables = tables.into_iter().map(|table| {
        let (file, header, rows) = (table.file, table.header.clone(), table.rows());
        let shape = [header.len(), rows];
        Ok((file, header, array(py, table.into_columns(), &shape)?))
    });
    Ok((tables.collect::<PyResult<_>>()?, summary.to_string(), text))
}

/// Returns the error that ended a simulation; `None` if the simulation reached its end.
pub(crate) fn ending(ended: &Result<(), Error>) -> Option<&Error> {
    ended.as_ref().err()
}
