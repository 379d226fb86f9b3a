//! Conversion of arrays from and to NumPy.

use crate::failure::{input, type_name};
use numpy::{IntoPyArray, PyArray1, PyArrayDyn, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;
use pyo3::sync::PyOnceLock;

/// Numbers of an array argument. They are copied, because other threads may change the array during
/// the computation.
pub(crate) struct Numbers {
    pub(crate) values: Vec<f64>,
    /// True if the argument is a single row (an array of one dimension).
    pub(crate) is_single: bool,
    /// Number of rows.
    pub(crate) rows: usize,
}

static FLOATS: PyOnceLock<Py<PyAny>> = PyOnceLock::new();

/// Reads the argument `name`, an array of shape (count,) or (rows, count), where count is the
/// number of coordinates in `names`.
pub(crate) fn numbers(name: &str, value: &Bound<'_, PyAny>, names: &[String]) -> PyResult<Numbers> {
    let py = value.py();
    let mut read = value.cast::<PyArrayDyn<f64>>().ok().and_then(copied);
    if read.is_none() {
        let find = || {
            let module = py.import("stiction._errors")?;
            Ok::<_, PyErr>(module.getattr("_floats")?.unbind())
        };
        let floats = FLOATS.get_or_try_init(py, find)?.bind(py).call1((name, value))?;
        read = floats.cast::<PyArrayDyn<f64>>().ok().and_then(copied);
    }
    let Some((shape, values)) = read else {
        let what = format!("`{name}` is a {}, which cannot be read as an array", type_name(value));
        return Err(input(py, &what, "give an array of floating-point numbers"));
    };
    let count = names.len();
    let (is_single, rows) = match *shape {
        [columns] if columns == count => (true, 1),
        [rows, columns] if columns == count => (false, rows),
        _ => {
            let what = format!("`{name}` has the shape {}", shown(&shape));
            let help = format!(
                "give ({count},) for one state or (n, {count}) for n states: one column for each of {}",
                names.join(", ")
            );
            return Err(input(py, &what, &help));
        }
    };
    Ok(Numbers { values, is_single, rows })
}

/// Copies the shape and the numbers of an array. Returns `None` if the numbers are not contiguous
/// and aligned in memory, or while another function writes to them.
fn copied(array: &Bound<'_, PyArrayDyn<f64>>) -> Option<(Vec<usize>, Vec<f64>)> {
    // `as_slice` also accepts arrays in column-major order, whose numbers are in another order.
    if !array.is_c_contiguous() {
        return None;
    }
    let read = array.try_readonly().ok()?;
    Some((array.shape().to_vec(), read.as_slice().ok()?.to_vec()))
}

/// Formats a shape in Python notation.
pub(crate) fn shown(shape: &[usize]) -> String {
    match shape {
        [one] => format!("({one},)"),
        several => {
            let all: Vec<String> = several.iter().map(usize::to_string).collect();
            format!("({})", all.join(", "))
        }
    }
}

/// Creates an array of the given shape from `values`, without copying.
pub(crate) fn array<'py>(
    py: Python<'py>,
    values: Vec<f64>,
    shape: &[usize],
) -> PyResult<Bound<'py, PyArrayDyn<f64>>> {
    let size = shape.iter().product::<usize>();
    if values.len() != size {
        return Err(PyMemoryError::new_err(
            "an array does not have as many values as its shape requires",
        ));
    }
    let flat: Bound<'py, PyArray1<f64>> = values.into_pyarray(py);
    flat.reshape(shape)
}
