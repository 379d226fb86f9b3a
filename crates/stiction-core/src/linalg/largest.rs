//! Maximum norm.

/// Returns the largest magnitude of the numbers; NaN if any number is NaN.
pub(crate) fn largest(numbers: &[f64]) -> f64 {
    let nan = |a: f64, b: f64| a.is_nan() || b.is_nan();
    numbers.iter().fold(0.0_f64, |m, x| if nan(m, *x) { f64::NAN } else { m.max(x.abs()) })
}
