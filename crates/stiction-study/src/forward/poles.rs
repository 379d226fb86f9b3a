//! Forces that pass through infinity.

use stiction_model::Course;

/// Instants that are looked at: a prime number, so that none is a simple part of the whole, as poles often are.
const LOOKS: usize = 4099;
/// Growth towards a change of sign from which it is no zero.
const GROWTH: f64 = 1e3;

/// The instant at which a course changes its sign by way of infinity, between these instants; the first of several. A pole
/// without a change of sign makes whatever it drives too fast, which is told by itself.
pub fn pole(course: &Course, from: f64, until: f64) -> Option<f64> {
    let value = |t: f64| course.at(t).value;
    let at = |k: usize| from + (until - from) * (k as f64 / LOOKS as f64);
    let mut left = (from, value(from));
    for k in 1..=LOOKS {
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

/// Bisects towards the change of sign: at a zero values vanish, at a jump they stay, at a pole they grow.
fn between(value: &dyn Fn(f64) -> f64, left: (f64, f64), right: (f64, f64)) -> Option<f64> {
    let (mut low, mut high) = (left, right);
    loop {
        let middle = 0.5 * (low.0 + high.0);
        if middle <= low.0 || middle >= high.0 {
            break;
        }
        let found = value(middle);
        match found {
            found if !found.is_finite() => return Some(middle),
            0.0 => return None,
            found if found * low.1 > 0.0 => low = (middle, found),
            found => high = (middle, found),
        }
    }
    let before = left.1.abs().min(right.1.abs());
    let grown = low.1.abs().min(high.1.abs());
    (grown > GROWTH * before).then_some(low.0)
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
        for at in [0.25, 0.251_234_5] {
            let pole = found(&|t| 1.0 / (t - at)).unwrap();
            assert!((pole - at).abs() < 1e-12, "{pole}");
        }
        let pole = found(&|t| (std::f64::consts::PI * (t + 0.25)).tan()).unwrap();
        assert!((pole - 0.25).abs() < 1e-12, "{pole}");
    }
}
