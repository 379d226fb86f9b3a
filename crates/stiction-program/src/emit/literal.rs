//! Numbers as literals of programming languages.

use super::Precision;

/// Formats a number as a decimal literal that compilers read back as the same number in the given
/// precision. The literal contains a decimal point or an exponent and has no suffix.
pub(crate) fn literal(number: f64, precision: Precision) -> String {
    match precision {
        Precision::Double => format!("{number:?}"),
        Precision::Float => format!("{:?}", number as f32),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn literals_read_back() {
        for number in [1.0, -0.1, 1e-9, 1.0 / 3.0, 6.02e23, 1e21, f64::MAX] {
            let text = literal(number, Precision::Double);
            assert_eq!(text.parse::<f64>(), Ok(number));
            assert!(text.contains(['.', 'e']), "{text}");
        }
        assert_eq!(literal(0.1, Precision::Float), "0.1");
        assert_eq!(literal(1e-60, Precision::Float), "0.0");
    }
}
