//! Formatting of numbers in texts for users.

/// Largest number of significant digits to write: 17 decimal digits identify every `f64`.
const MOST_DIGITS: usize = 17;

/// Formats a number with a given number of significant digits: in decimal notation from 1e-4 to
/// below 1e6, otherwise in scientific notation. `digits` is limited to the range from 1 to 17.
pub fn significant(x: f64, digits: usize) -> String {
    if x == 0.0 {
        return "0".to_owned();
    }
    let decimals = digits.clamp(1, MOST_DIGITS) - 1;
    let scientific = format!("{x:.decimals$e}");
    // The exponent is read after rounding, which may have turned 9.9999 into 10.
    let exponent = scientific.split_once('e').and_then(|(_, e)| e.parse::<i32>().ok());
    match exponent {
        Some(exponent @ -4..6) => {
            let decimals = (decimals as i32 - exponent).max(0) as usize;
            format!("{x:.decimals$}")
        }
        _ => scientific,
    }
}

/// Formats a number as [`significant`] does, but without trailing zeros after the decimal point.
pub(crate) fn brief(x: f64, digits: usize) -> String {
    let text = significant(x, digits);
    let (number, power) = text.split_at(text.find('e').unwrap_or(text.len()));
    if !number.contains('.') {
        return text;
    }
    format!("{}{power}", number.trim_end_matches('0').trim_end_matches('.'))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_that_count() {
        assert_eq!(significant(0.0, 4), "0");
        assert_eq!(significant(-0.0, 4), "0");
        assert_eq!(significant(1.0, 4), "1.000");
        assert_eq!(significant(-12.3456, 4), "-12.35");
        assert_eq!(significant(12345.6, 4), "12346");
        assert_eq!(significant(9.99996, 4), "10.00");
        assert_eq!(significant(999_999.7, 4), "1.000e6");
        assert_eq!(significant(1e-4, 2), "0.00010");
        assert_eq!(significant(0.000_099_9, 2), "0.00010");
        assert_eq!(significant(1.234e-5, 2), "1.2e-5");
        assert_eq!(significant(f64::MAX, 0), "2e308");
        assert_eq!(significant(1.0 / 3.0, 999).len(), 19);
    }

    #[test]
    fn no_zeros_at_the_end() {
        assert_eq!(brief(0.25, 4), "0.25");
        assert_eq!(brief(1200.0, 4), "1200");
        assert_eq!(brief(-3e-7, 4), "-3e-7");
        assert_eq!(brief(0.0, 4), "0");
    }
}
