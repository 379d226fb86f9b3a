//! Constants of the sine and cosine functions that generated code may contain. These functions
//! reduce the angle by quarter turns and evaluate power series.

/// Number of leading bits in each of the first two parts of a quarter turn. Products of these parts
/// with an integer below 2^13 are therefore exact.
const BITS: u32 = 40;

/// Rounds a number towards zero to its leading [`BITS`] bits.
fn leading(x: f64) -> f64 {
    f64::from_bits(x.to_bits() & !((1 << (53 - BITS)) - 1))
}

/// Returns a quarter turn, rad, as a sum of three numbers, accurate to 130 bits.
fn quarter_turn() -> [f64; 3] {
    // pi/2 as a sum: the nearest double, and the next two terms.
    let (high, low, lowest) =
        (core::f64::consts::FRAC_PI_2, 6.123_233_995_736_766e-17, -1.497_384_904_859_183_3e-33);
    let first = leading(high);
    let rest = high - first;
    let sum = rest + low;
    let error = low - (sum - rest);
    let second = leading(sum);
    [first, second, (sum - second) + (error + lowest)]
}

/// Returns the names and literals of all constants, with which the template is filled.
pub(crate) fn values() -> Vec<(&'static str, String)> {
    let [first, second, third] = quarter_turn();
    let text = |x: f64| format!("{x:?}");
    // Series about zero: within an eighth of a turn, the first omitted term is below 1e-17.
    let series = |first: u32| {
        let mut factorial: f64 = (1..=first).map(f64::from).product();
        let mut terms = Vec::new();
        for k in 0..7 {
            terms.push(1.0 / factorial * if k % 2 == 0 { 1.0 } else { -1.0 });
            let next = f64::from(first + 2 * k);
            factorial *= (next + 1.0) * (next + 2.0);
        }
        // Horner's scheme.
        let mut rest = String::new();
        for (k, term) in terms.iter().enumerate().rev() {
            rest = match k {
                6 => text(*term),
                _ => format!("{} + z * ({rest})", text(*term)),
            };
        }
        rest
    };
    vec![
        ("QUARTERS", text(core::f64::consts::FRAC_2_PI)),
        ("QUARTER_1", text(first)),
        ("QUARTER_2", text(second)),
        ("QUARTER_3", text(third)),
        // With z = x^2: the sine is x - z x / 6 + ..., here without the first term; the cosine is 1
        // - z / 2 + z^2 / 24 - ..., here from the third term on.
        ("SINE", series(3)),
        ("COSINE", series(4)),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_quarter_turn_add_up() {
        let [first, second, third] = quarter_turn();
        assert_eq!(first + second, core::f64::consts::FRAC_PI_2);
        // For x near pi, sin(x) equals pi - x. The sine therefore yields digits of pi beyond those
        // of the double, independently of the constants above.
        let low = (core::f64::consts::PI).sin() / 2.0;
        let found = second - (core::f64::consts::FRAC_PI_2 - first) + third;
        assert!((found - low).abs() < 1e-30, "{found} {low}");
    }
}
