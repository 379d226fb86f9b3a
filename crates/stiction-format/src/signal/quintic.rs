//! The quintic spline through values: rates and accelerations at the samples.
//!
//! The spline is a sum of B-splines of order six. Their knots are the samples except the second and third from each
//! end (not-a-knot condition). The collocation matrix is banded and totally positive, so elimination needs no
//! pivoting; the time needed is proportional to the number of samples.

use super::banded::Banded;
use super::bspline::{Knots, ORDER, local};

/// Half bandwidth of the collocation matrix, which contains the values of the B-splines at the
/// samples.
const BAND: usize = 4;

/// Computes the rates and accelerations of the spline at all samples; there must be at least seven.
pub(super) fn rates_and_accelerations(times: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let n = values.len().min(times.len());
    let knots = SampleKnots { times, count: n };
    let mut matrix = Banded::new(n, BAND);
    for (row, &t) in times.iter().enumerate() {
        let first = knots.first_spline(row);
        for (k, value) in knots.splines::<ORDER>(first, t).into_iter().enumerate() {
            matrix.set(row, first + k, value);
        }
    }
    let mut coefficients = values.to_vec();
    matrix.factor().solve(&mut coefficients);
    times
        .iter()
        .enumerate()
        .map(|(row, &t)| {
            let first = knots.first_spline(row);
            let knot = knots.target(local(&coefficients, first), first, t);
            (knot.rate, knot.acceleration)
        })
        .unzip()
}

/// The knots: the first sample six times, then the fourth to the fourth-last sample, then the last sample six times.
struct SampleKnots<'a> {
    times: &'a [f64],
    count: usize,
}

impl Knots for SampleKnots<'_> {
    fn at(&self, index: usize) -> f64 {
        let sample = match index.checked_sub(ORDER) {
            None => 0,
            Some(inner) if inner + ORDER < self.count => inner + 3,
            Some(_) => self.count.saturating_sub(1),
        };
        self.times.get(sample).copied().unwrap_or(f64::NAN)
    }
}

impl SampleKnots<'_> {
    /// Index of the first of the six B-splines that can be nonzero in the interval that begins at a
    /// sample.
    fn first_spline(&self, sample: usize) -> usize {
        sample.saturating_sub(2).min(self.count.saturating_sub(ORDER))
    }
}

#[cfg(test)]
mod tests {
    use super::super::hermite::{Samples, Spline};
    use std::sync::Arc;
    use stiction_core::kinematics::Target;

    /// Value and derivatives of a polynomial, lowest power first.
    fn polynomial(c: &[f64], t: f64) -> Target<f64> {
        let sum = |factor: fn(f64) -> f64, lost: i32| -> f64 {
            c.iter()
                .enumerate()
                .map(|(k, c)| {
                    let power = k as i32 - lost;
                    if power < 0 { 0.0 } else { factor(k as f64) * c * t.powi(power) }
                })
                .sum()
        };
        Target {
            value: sum(|_| 1.0, 0),
            rate: sum(|k| k, 1),
            acceleration: sum(|k| k * (k - 1.0), 2),
        }
    }

    /// Sample times from 0 to 1; neighbouring steps differ by up to a factor of three.
    fn uneven(n: usize) -> Arc<[f64]> {
        let steps: Vec<f64> = (0..n - 1).map(|i| [1.0, 0.4, 1.2, 0.7][i % 4]).collect();
        let total: f64 = steps.iter().sum();
        let mut t = 0.0;
        let mut times = vec![0.0];
        times.extend(steps.iter().map(|step| {
            t += step / total;
            t
        }));
        times.into()
    }

    fn sampled(times: &Arc<[f64]>, kind: usize, f: &dyn Fn(f64) -> Target<f64>) -> Spline {
        let list = |pick: fn(Target<f64>) -> f64| times.iter().map(|&t| pick(f(t))).collect();
        let (values, rates, accelerations) =
            (list(|k| k.value), list(|k| k.rate), list(|k| k.acceleration));
        Spline::new(times, Samples::new([values, rates, accelerations].into_iter().take(kind + 1)))
    }

    /// Checks that all kinds of spline reproduce quintics if there are enough samples, and
    /// polynomials of lower degree with fewer samples.
    #[test]
    fn polynomials_are_reproduced() {
        let c = [0.3, -1.0, 2.0, 0.5, -1.5, 0.7];
        for kind in 0..3 {
            for n in 2..40 {
                let times = uneven(n);
                let determined = (n * (kind + 1)).min(6);
                let f = |t| polynomial(&c[..determined], t);
                let spline = sampled(&times, kind, &f);
                for step in 0..=100 {
                    let t = step as f64 / 100.0;
                    let (found, expected) = (spline.at(t), f(t));
                    // Round-off of values of order one; second differences over steps of 1/n magnify it by n^2, the
                    // condition of the splines by about ten.
                    let tolerance = 1e-14 * (1.0 + (n * n) as f64);
                    assert!((found.value - expected.value).abs() < 1e-13, "{kind} {n} {t}");
                    assert!((found.rate - expected.rate).abs() < tolerance, "{kind} {n} {t}");
                    let error = (found.acceleration - expected.acceleration).abs();
                    assert!(error < 10.0 * tolerance, "{kind} {n} {t} {error:e}");
                }
            }
        }
    }

    #[test]
    fn samples_are_met_exactly() {
        let times = uneven(23);
        let f = |t: f64| Target {
            value: (3.0 * t).sin(),
            rate: 3.0 * (3.0 * t).cos(),
            acceleration: 1.0,
        };
        for kind in 0..3 {
            let spline = sampled(&times, kind, &f);
            for &t in times.iter() {
                assert_eq!(spline.at(t).value, f(t).value);
            }
        }
    }

    /// Checks that halving the step divides the error by about 2^6 (value), 2^5 (rate) and 2^4
    /// (acceleration), or more.
    #[test]
    fn errors_fall_with_the_order_of_a_quintic() {
        let f = |t: f64| {
            let (s, c) = (6.0 * t).sin_cos();
            Target { value: s, rate: 6.0 * c, acceleration: -36.0 * s }
        };
        for kind in 0..3 {
            let error = |n: usize| {
                let spline = sampled(&uneven(n), kind, &f);
                let mut worst = [0.0f64; 3];
                for step in 0..=1000 {
                    let t = step as f64 / 1000.0;
                    let (a, b) = (spline.at(t), f(t));
                    let errors =
                        [a.value - b.value, a.rate - b.rate, a.acceleration - b.acceleration];
                    for (worst, error) in worst.iter_mut().zip(errors) {
                        *worst = worst.max(error.abs());
                    }
                }
                worst
            };
            let (coarse, fine) = (error(21), error(41));
            for (derivative, (coarse, fine)) in coarse.iter().zip(&fine).enumerate() {
                let order = (coarse / fine).log2();
                let expected = 6.0 - derivative as f64;
                assert!(order > expected - 0.5, "{kind} {derivative}: order {order}");
            }
        }
    }

    /// Checks that the third derivative, computed by differences of the acceleration, does not jump
    /// at the samples.
    #[test]
    fn pieces_join_smoothly() {
        let times = uneven(30);
        let f = |t: f64| Target {
            value: (6.0 * t).sin(),
            rate: 6.0 * (6.0 * t).cos(),
            acceleration: 0.0,
        };
        let h = 1e-4;
        for kind in 0..2 {
            let spline = sampled(&times, kind, &f);
            for &t in &times[1..29] {
                let a = |t: f64| spline.at(t).acceleration;
                let third = (a(t + h) - a(t)) / h - (a(t) - a(t - h)) / h;
                // A jump of the third derivative would be of the order of 6^5 times the step, 100.
                // Without a jump, the difference is h times the fourth derivative, 0.13.
                assert!(third.abs() < 0.5, "{kind} {t}: {third}");
            }
        }
    }

    #[test]
    fn a_long_recording_takes_linear_time() {
        let n = 200_000;
        let times: Arc<[f64]> = (0..n).map(|i| i as f64 * 1e-3).collect();
        let f = |t: f64| Target { value: t.sin(), rate: t.cos(), acceleration: -t.sin() };
        for kind in 0..3 {
            let spline = sampled(&times, kind, &f);
            assert!(spline.is_finite());
            let t = 100.0005;
            assert!((spline.at(t).value - t.sin()).abs() < 1e-12);
        }
    }
}
