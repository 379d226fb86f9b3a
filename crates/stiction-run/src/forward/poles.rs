//! Poles of signals: instants at which a signal changes its sign through infinity.

use stiction_format::Signal;

/// Number of equal intervals in which the search looks for changes of sign. The number is prime, so
/// that poles at simple fractions of the duration do not lie on the ends of the intervals.
const INTERVALS: usize = 4099;
/// Factor of growth that distinguishes a pole from a zero or a jump. At a pole, the values grow by
/// more than this factor during the last bisections, typically by about a million.
const GROWTH: f64 = 1e3;
/// Width of the interval next to a change of sign over which the growth of the values is measured,
/// in units of the spacing of floating-point numbers. A signal without a pole hardly changes over
/// this width.
const NEAR: f64 = 1048576.0;

/// Finds the first instant between `from` and `until`, s, at which a signal changes its sign
/// through infinity. Poles without a change of sign are not detected.
pub fn pole(signal: &Signal, from: f64, until: f64) -> Option<f64> {
    if signal.is_constant() {
        return None;
    }
    let value = |t: f64| signal.at(t).value;
    let at = |k: usize| from + (until - from) * (k as f64 / INTERVALS as f64);
    let mut left = (from, value(from));
    for k in 1..=INTERVALS {
        let right = (at(k), value(at(k)));
        if left.1 * right.1 < 0.0
            && let Some(found) = between(&value, left, right)
        {
            return Some(found);
        }
        left = right;
    }
    None
}

/// Locates the change of sign between the points `left` and `right`, each a pair of time, s, and
/// value, by bisection. The values vanish at a zero, stay finite at a jump, and grow at a pole.
/// Returns the instant of the change, s, if it is a pole.
fn between(value: &dyn Fn(f64) -> f64, left: (f64, f64), right: (f64, f64)) -> Option<f64> {
    let least = |low: (f64, f64), high: (f64, f64)| low.1.abs().min(high.1.abs());
    let (mut low, mut high) = (left, right);
    let mut near = None;
    loop {
        let middle = 0.5 * (low.0 + high.0);
        if middle <= low.0 || middle >= high.0 {
            break;
        }
        if high.0 - low.0 <= NEAR * f64::EPSILON * low.0.abs().max(high.0.abs()) {
            near.get_or_insert(least(low, high));
        }
        let found = value(middle);
        match found {
            // A jump written as a quotient, such as `x / abs(x)`, is zero divided by zero at its
            // instant.
            found if found.is_nan() => break,
            found if found.is_infinite() => return Some(middle),
            0.0 => return None,
            found if found * low.1 > 0.0 => low = (middle, found),
            found => high = (middle, found),
        }
    }
    (least(low, high) > GROWTH * near?).then_some(low.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_and_jumps_are_no_poles() {
        let found =
            |value: &dyn Fn(f64) -> f64| between(value, (0.0, value(0.0)), (1.0, value(1.0)));
        assert_eq!(found(&|t| t - 0.3), None);
        assert_eq!(found(&|t| if t < 0.3 { -2.0 } else { 2.0 }), None);
        assert_eq!(found(&|t| (1e9 * (t - 0.3)).tanh()), None);
        assert_eq!(found(&|t| if t < 0.3 { -1e-17 } else { 2.0 }), None);
        assert_eq!(found(&|t| (t - 0.3) / (t - 0.3).abs()), None);
        assert_eq!(found(&|t| (t - 0.3).powi(9)), None);
        for at in [0.25, 0.251_234_5] {
            let pole = found(&|t| 1.0 / (t - at)).unwrap();
            assert!((pole - at).abs() < 1e-12, "{pole}");
        }
        let steep = found(&|t| (t - 0.25).powi(-3)).unwrap();
        assert!((steep - 0.25).abs() < 1e-12, "{steep}");
        let pole = found(&|t| (std::f64::consts::PI * (t + 0.25)).tan()).unwrap();
        assert!((pole - 0.25).abs() < 1e-12, "{pole}");
    }
}
