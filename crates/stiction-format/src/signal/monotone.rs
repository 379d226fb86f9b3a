//! Piecewise cubics through samples without overshoot.
//!
//! Slopes at the samples are weighted harmonic means of the slopes of the adjacent chords, and zero
//! where these have different signs (F. N. Fritsch and J. Butland, A method for constructing local
//! monotone piecewise cubic interpolants, SIAM J. Sci. Stat. Comput. 5, 1984).

use std::sync::Arc;
use stiction_core::kinematics::Target;

/// Description of the interpolation in words.
pub(crate) const DESCRIPTION: &str = "cubic between neighbouring samples, without overshoot (Fritsch and Butland); constant before the first and after the last sample";

/// Values and slopes at all samples. Each slope depends only on the sample and its two neighbours.
pub(crate) fn knots(times: &[f64], values: &[f64]) -> Vec<Target<f64>> {
    let chords: Vec<(f64, f64)> = times
        .windows(2)
        .zip(values.windows(2))
        .map(|(t, v)| (t[1] - t[0], (v[1] - v[0]) / (t[1] - t[0])))
        .collect();
    let still = |&value: &f64| Target { value, rate: 0.0, acceleration: 0.0 };
    let mut knots: Vec<Target<f64>> = values.iter().map(still).collect();
    for (knot, pair) in knots.iter_mut().skip(1).zip(chords.windows(2)) {
        let ((h0, s0), (h1, s1)) = (pair[0], pair[1]);
        if s0 * s1 > 0.0 {
            let (w0, w1) = (h0 + 2.0 * h1, 2.0 * h0 + h1);
            knot.rate = (w0 + w1) / (w1 / s0 + w0 / s1);
        }
    }
    // At the ends, the slope of the first or last chord is used; straight lines are then reproduced.
    if let (Some(first), Some((_, chord))) = (knots.first_mut(), chords.first()) {
        first.rate = *chord;
    }
    if let (Some(last), Some((_, chord))) = (knots.last_mut(), chords.last()) {
        last.rate = *chord;
    }
    knots
}

/// A function that is monotone between samples and constant before the first and after the last.
#[derive(Clone, Debug)]
pub(crate) struct Monotone {
    times: Arc<[f64]>,
    /// Values and slopes at the samples.
    knots: Vec<Target<f64>>,
}

impl Monotone {
    /// Creates the function from values and slopes at strictly increasing `times`, see [`knots`].
    pub(crate) fn of_knots(times: &Arc<[f64]>, knots: Vec<Target<f64>>) -> Self {
        Self { times: Arc::clone(times), knots }
    }

    /// Times of the samples, s.
    pub(crate) fn times(&self) -> &[f64] {
        &self.times
    }

    /// Evaluates the function at `t`, s. At a sample, the value is exactly that of the sample.
    pub(crate) fn at(&self, t: f64) -> Target<f64> {
        let still = |value: f64| Target { value, rate: 0.0, acceleration: 0.0 };
        let after = self.times.partition_point(|&time| time <= t);
        let ends = after.checked_sub(1).and_then(|i| {
            let knot = |i: usize| Some((*self.times.get(i)?, *self.knots.get(i)?));
            Some((knot(i)?, knot(after)?))
        });
        let Some(((t0, begin), (t1, end))) = ends else {
            let beyond = if after == 0 { self.knots.first() } else { self.knots.last() };
            return still(beyond.map_or(0.0, |knot| knot.value));
        };
        let (v0, d0, v1, d1) = (begin.value, begin.rate, end.value, end.rate);
        let h = t1 - t0;
        let u = (t - t0) / h;
        let chord = (v1 - v0) / h;
        let (c2, c3) = (3.0 * chord - 2.0 * d0 - d1, d0 + d1 - 2.0 * chord);
        Target {
            value: v0 + h * u * (d0 + u * (c2 + u * c3)),
            rate: d0 + u * (2.0 * c2 + u * 3.0 * c3),
            acceleration: (2.0 * c2 + 6.0 * u * c3) / h,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn curve(times: &Arc<[f64]>, values: &[f64]) -> Monotone {
        Monotone::of_knots(times, knots(times, values))
    }

    /// Checks that a jump between two samples, such as friction at a reversal, causes no overshoot.
    #[test]
    fn a_jump_causes_no_overshoot() {
        let times: Arc<[f64]> = (0..20).map(|k| f64::from(k) * 0.1).collect();
        let values: Vec<f64> = (0..20).map(|k| if k < 10 { -3.0 } else { 5.0 }).collect();
        let curve = curve(&times, &values);
        for k in 0..=400 {
            let t = f64::from(k) * 0.005;
            let value = curve.at(t).value;
            let flat = if t <= 0.9 {
                Some(-3.0)
            } else if t >= 1.0 {
                Some(5.0)
            } else {
                None
            };
            assert!((-3.0..=5.0).contains(&value), "{t}: {value}");
            assert!(flat.is_none_or(|flat| value == flat), "{t}: {value}");
        }
    }

    /// Checks that the error decreases approximately with the square of the distance between
    /// samples.
    #[test]
    fn convergence_order() {
        let error = |n: i32| {
            let times: Arc<[f64]> = (0..=n).map(|k| f64::from(k) / f64::from(n)).collect();
            let values: Vec<f64> = times.iter().map(|t| t.exp()).collect();
            let curve = curve(&times, &values);
            let at = |k: i32| f64::from(k) / 999.0;
            (0..1000).map(|k| (curve.at(at(k)).value - at(k).exp()).abs()).fold(0.0, f64::max)
        };
        // The slope at an end is that of a chord, so the function is only second-order accurate
        // there.
        assert!(error(10) < 5e-3 && error(20) < 0.3 * error(10), "{} {}", error(10), error(20));
    }

    #[test]
    fn samples_are_exact_and_constant_beyond() {
        let times: Arc<[f64]> = [0.0, 0.3, 1.0].into();
        let curve = curve(&times, &[1.0, -2.0, 7.0]);
        for (t, value) in [(-5.0, 1.0), (0.0, 1.0), (0.3, -2.0), (1.0, 7.0), (9.0, 7.0)] {
            assert_eq!(curve.at(t).value, value);
        }
        let one: Arc<[f64]> = [0.5].into();
        assert_eq!(self::curve(&one, &[4.0]).at(0.0).value, 4.0);
    }
}
