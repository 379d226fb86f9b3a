//! Single quantities with units, for options of programs.

use crate::expression::{Dimension, constant, parse};
use crate::parameters::Parameters;

/// A time in seconds: a plain number (`0.01`), or an expression with units (`10 ms`, `1 min + 30 s`).
///
/// ```
/// use stiction_format::seconds;
///
/// assert_eq!(seconds("0.25"), Ok(0.25));
/// assert_eq!(seconds("250 ms"), Ok(0.25));
/// assert_eq!(seconds("3 mm").unwrap_err(), "expected a time, found a length");
/// ```
///
/// # Errors
/// The reason, one line.
pub fn seconds(text: &str) -> Result<f64, String> {
    if let Ok(number) = text.trim().parse() {
        return Ok(number);
    }
    let scope = Parameters::default();
    let quantity = parse(text, &scope, false)
        .and_then(|program| constant(&program, &scope))
        .map_err(|fault| fault.message)?;
    let dimension = quantity.dimension;
    match dimension.same(Dimension::TIME) || dimension.same(Dimension::NONE) {
        true => Ok(quantity.value),
        false => Err(format!("expected a time, found {}", dimension.describe())),
    }
}
