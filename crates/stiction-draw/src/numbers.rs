//! Formatting of numbers for readers and for programs.

pub use stiction_core::words::significant;

/// Magnitude from which [`fixed`] writes four significant digits, because fixed decimals would show
/// more digits than a double has.
const LONGEST: f64 = 1e15;
/// Magnitude from which [`exact`] writes numbers with a power of ten.
const PLAIN: f64 = 1e16;
/// Largest number of significant decimal digits of a double.
const MOST_DIGITS: usize = 17;
/// Room for the text of a number that [`exact`] writes, in bytes. The longest text has 24 bytes.
const ROOM: usize = 2 * HALF;
const HALF: usize = 16;

/// Formats a number with four significant digits.
pub fn number(x: f64) -> String {
    significant(x, 4)
}

/// Formats a number that should be zero, such as a residual, with one digit and a power of ten.
pub fn order(x: f64) -> String {
    if x == 0.0 { "0".to_owned() } else { format!("{x:.0e}") }
}

/// Formats a ratio in percent; returns a dash for `None`.
pub fn percent(ratio: Option<f64>) -> String {
    ratio.map_or("-".to_owned(), |ratio| match 100.0 * ratio {
        percent if percent.abs() < 1e5 => format!("{} %", fixed(percent, 1)),
        percent => format!("{percent:.1e} %"),
    })
}

/// Formats a number with a fixed number of decimals; zero has no sign.
pub fn fixed(x: f64, decimals: usize) -> String {
    let decimals = decimals.min(MOST_DIGITS);
    if x.abs() >= LONGEST {
        return significant(x, 4);
    }
    let text = format!("{x:.decimals$}");
    match text.strip_prefix('-') {
        Some(rest) if rest.bytes().all(|c| c == b'0' || c == b'.') => rest.to_owned(),
        _ => text,
    }
}

/// Appends a number with all its digits in the shortest form that reads back as the same number:
/// plain between 1e-5 and 1e16, else with a power of ten.
pub fn exact(out: &mut String, x: f64) {
    let mut room = [0; ROOM];
    let length = put(&mut room, digits(&mut zmij::Buffer::new(), x), x);
    out.extend(room[..length].iter().map(|byte| char::from(*byte)));
}

/// Writes numbers as [`exact`], each after a comma, and the end of the line, from the byte `end` of
/// `line` on. Returns the place after them; the bytes from there on are unspecified.
pub fn finish_line(line: &mut Vec<u8>, mut end: usize, numbers: &[f64]) -> usize {
    let longest = end + (1 + ROOM) * numbers.len() + 1;
    if line.len() < longest {
        line.resize(longest, 0);
    }
    let mut buffer = zmij::Buffer::new();
    for x in numbers {
        line[end] = b',';
        end += 1;
        // There is room after every number.
        if let Some(room) = line[end..].first_chunk_mut() {
            end += put(room, digits(&mut buffer, *x), *x);
        }
    }
    line[end] = b'\n';
    end + 1
}

/// Returns the shortest digits of a number, possibly with an unnecessary decimal `.0` or plus sign.
#[inline]
fn digits(buffer: &mut zmij::Buffer, x: f64) -> &[u8] {
    // Flags and absent parts fill many columns.
    match x {
        1.0 => b"1",
        0.0 if x.is_sign_positive() => b"0",
        _ if x.abs() < PLAIN => buffer.format_finite(x).as_bytes(),
        _ => buffer.format(x).as_bytes(),
    }
}

/// Writes the digits of the number `x` to the start of `room`, without an unnecessary decimal or
/// plus sign. Returns the number of bytes.
#[inline]
fn put(room: &mut [u8; ROOM], digits: &[u8], x: f64) -> usize {
    let length = digits.len();
    // Two copies of a constant length, which overlap, take less time than a call of the function of
    // the system that copies any length.
    match (digits.first_chunk::<HALF>(), digits.last_chunk::<HALF>()) {
        (Some(first), Some(last)) => {
            room[..HALF].copy_from_slice(first);
            room[length - HALF..length].copy_from_slice(last);
        }
        _ if length == 1 => room[0] = digits[0],
        _ => room[..length].copy_from_slice(digits),
    }
    // Only powers of ten from 1e16 on have a plus sign.
    if x.abs() >= PLAIN
        && let Some(plus) = digits.iter().position(|byte| *byte == b'+')
    {
        room.copy_within(plus + 1..length, plus);
        return length - 1;
    }
    if room[..length].ends_with(b".0") { length - 2 } else { length }
}

/// Returns the text for NaN (`none`) and for infinities; `None` for a finite number.
pub fn not_finite(x: f64) -> Option<&'static str> {
    match x {
        x if x.is_nan() => Some("none"),
        f64::INFINITY => Some("∞"),
        f64::NEG_INFINITY => Some("-∞"),
        _ => None,
    }
}

/// Replaces the hyphens that stand for minus signs of numbers and of their exponents by true minus signs, for texts that
/// people read. Texts that programs read or that a reader copies, such as tables in files, options and names, keep the
/// hyphen.
pub fn with_minus(text: &str) -> String {
    const MINUS: char = '−';
    let begins = |c: Option<char>| c.is_some_and(|c| c.is_ascii_digit() || matches!(c, '.' | '∞'));
    let mut shown = String::with_capacity(text.len());
    let mut letters = text.chars().peekable();
    // The last two letters.
    let mut before = [None, None];
    while let Some(letter) = letters.next() {
        let follows = match before {
            [_, None] => true,
            [Some(digit), Some('e')] if digit.is_ascii_digit() => true,
            [_, Some(c)] => c.is_whitespace() || "([{=≈<>,;:±/".contains(c),
        };
        let is_minus = letter == '-' && follows && begins(letters.peek().copied());
        shown.push(if is_minus { MINUS } else { letter });
        before = [before[1], Some(letter)];
    }
    shown
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_after_the_point() {
        assert_eq!(fixed(-0.0001, 2), "0.00");
        assert_eq!(fixed(-0.0, 0), "0");
        assert_eq!(fixed(2.5, 3), "2.500");
        assert_eq!(fixed(-10.0, 0), "-10");
        assert_eq!(fixed(-1e300, 3), "-1.000e300");
    }

    #[test]
    fn zero_percent_has_no_sign() {
        assert_eq!(percent(Some(-0.0)), "0.0 %");
        assert_eq!(percent(Some(-1e-6)), "0.0 %");
        assert_eq!(percent(Some(-0.123)), "-12.3 %");
        assert_eq!(percent(Some(2e3)), "2.0e5 %");
    }

    /// Checks that [`exact`] writes the same texts as the standard library.
    #[test]
    fn all_digits() {
        let mut random = stiction_core::random::Random::new(4);
        let powers = (-320..309).map(|power| 10f64.powi(power) * (1.0 + random.number()));
        let corners = [0.0, -0.0, 1.0, 1e-5, 9.99e-6, 1e15, 1e16, 123456789.0, -2.5, 0.1 + 0.2];
        let none =
            [f64::INFINITY, f64::NEG_INFINITY, f64::NAN, f64::MAX, f64::MIN_POSITIVE, 5e-324];
        for x in powers.chain(corners).chain(none) {
            let plain = x == 0.0 || (1e-5..1e16).contains(&x.abs());
            let mut text = String::new();
            exact(&mut text, x);
            assert_eq!(text, if plain { format!("{x}") } else { format!("{x:e}") });
            let mut line = b"0".to_vec();
            let end = finish_line(&mut line, 1, &[x; 5]);
            assert_eq!(line[..end], *format!("0{}\n", format!(",{text}").repeat(5)).as_bytes());
        }
    }

    /// Checks that only hyphens before a number become minus signs: not those within names, words and ranges.
    #[test]
    fn minus_signs_are_those_of_numbers() {
        assert_eq!(with_minus("-12.5 N at -1e-9 s"), "−12.5 N at −1e−9 s");
        assert_eq!(with_minus("[-1, -.5] to -∞, x=-2"), "[−1, −.5] to −∞, x=−2");
        for text in
            ["leg-1 to leg-2", "3-RPS", "-", "- 1", "computed-torque", "2020-01-02", "piece-5"]
        {
            assert_eq!(with_minus(text), text);
        }
    }

    #[test]
    fn non_finite_numbers_have_names() {
        assert_eq!(not_finite(f64::NAN), Some("none"));
        assert_eq!(not_finite(f64::NEG_INFINITY), Some("-∞"));
        assert_eq!(not_finite(0.0), None);
    }
}
