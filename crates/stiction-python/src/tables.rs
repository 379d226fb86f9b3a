//! Conversion of the tables of inverse dynamics or of a simulation to NumPy arrays.

use crate::arrays::array;
use numpy::PyArrayDyn;
use pyo3::prelude::*;
use stiction::{Error, Tabulated};

/// One table: file name, headers of the columns, and values of shape (columns, rows).
type Table<'py> = (&'static str, Vec<String>, Bound<'py, PyArrayDyn<f64>>);
/// Tables of inverse dynamics or of a simulation, the summary as JSON, and the summary as text.
pub(crate) type Results<'py> = (Vec<Table<'py>>, String, String);

/// Converts the results of inverse dynamics or of a simulation to NumPy arrays and texts.
pub(crate) fn results(py: Python<'_>, tabulated: Tabulated) -> PyResult<Results<'_>> {
    let Tabulated { tables, summary, text } = tabulated;
    let tables = tables.into_iter().map(|table| {
        let (file, header, rows) = (table.file, table.header.clone(), table.rows());
        let shape = [header.len(), rows];
        Ok((file, header, array(py, table.into_columns(), &shape)?))
    });
    Ok((tables.collect::<PyResult<_>>()?, summary.to_string(), text))
}

/// Returns the error that ended a simulation early; `None` if the simulation did not end early.
pub(crate) fn ending(ended: &Result<(), Error>) -> Option<&Error> {
    ended.as_ref().err()
}
