//! Piecewise quintics through samples.
//!
//! The spline is stored as value, rate and acceleration at every sample; these determine one quintic polynomial
//! between neighbouring samples. Derivatives that the samples do not contain are computed.

use super::banded::Banded;
use super::quintic;
use super::windows::{by_windows, is_long};
use std::ops::Range;
use std::sync::Arc;
use stiction_core::kinematics::Target;

/// Derivatives given at each sample of a coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Given {
    Values,
    /// Values and rates are given.
    Rates,
    /// Values, rates and accelerations are given.
    Accelerations,
}

impl Given {
    /// Describes the interpolation in words for this number of samples.
    pub(crate) fn describe(self, count: usize) -> String {
        match (self, count) {
            (Self::Values, 0..=6) => format!(
                "positions only: the polynomial of degree {} through all samples",
                count.saturating_sub(1)
            ),
            (Self::Values, _) => "positions only: quintic spline, continuous up to the fourth \
                derivative; not-a-knot ends (the fifth derivative is continuous at the two samples \
                next to each end)"
                .to_owned(),
            (Self::Rates, 0..=3) => format!(
                "positions and velocities: the polynomial of degree {} through all samples",
                (2 * count).saturating_sub(1)
            ),
            (Self::Rates, _) => "positions and velocities: quintic Hermite spline, continuous \
                 up to the third derivative (at the sample next to each end up to the fourth)"
                .to_owned(),
            (Self::Accelerations, _) => {
                "positions, velocities and accelerations: quintic between neighbouring samples, \
                 continuous up to the acceleration"
                    .to_owned()
            }
        }
    }
}

/// Values of one coordinate at the samples, with the derivatives that are given.
#[derive(Clone, Debug)]
pub(crate) struct Samples {
    values: Vec<f64>,
    rates: Option<Vec<f64>>,
    accelerations: Option<Vec<f64>>,
}

impl Samples {
    /// Creates the samples from columns: the values, then the rates and the accelerations if they
    /// are given.
    pub(crate) fn new(columns: impl IntoIterator<Item = Vec<f64>>) -> Self {
        let mut columns = columns.into_iter();
        Self {
            values: columns.next().unwrap_or_default(),
            rates: columns.next(),
            accelerations: columns.next(),
        }
    }

    fn given(&self) -> Given {
        match (&self.rates, &self.accelerations) {
            (None, _) => Given::Values,
            (Some(_), None) => Given::Rates,
            (Some(_), Some(_)) => Given::Accelerations,
        }
    }

    fn part(&self, window: &Range<usize>) -> Self {
        let part = |list: &Vec<f64>| list.get(window.clone()).unwrap_or_default().to_vec();
        Self {
            values: part(&self.values),
            rates: self.rates.as_ref().map(part),
            accelerations: self.accelerations.as_ref().map(part),
        }
    }

    /// Computes value, rate and acceleration at every sample from one system of equations for all
    /// samples.
    pub(crate) fn knots(self, times: &[f64]) -> Vec<Target<f64>> {
        let few = |degree_of_dof: usize| degree_of_dof * times.len() <= 6;
        let target = |(value, (rate, acceleration))| Target { value, rate, acceleration };
        let Self { values, rates, accelerations } = self;
        let (rates, accelerations) = match (rates, accelerations) {
            (Some(rates), Some(accelerations)) => (rates, accelerations),
            (Some(rates), None) => {
                let accelerations = if few(2) {
                    let known = |i: usize| (values.get(i).copied(), rates.get(i).copied());
                    times.iter().map(|&t| newton(times, known, t).1).collect()
                } else {
                    accelerations_for_rates(times, &values, &rates)
                };
                (rates, accelerations)
            }
            (None, _) if few(1) => {
                let known = |i: usize| (values.get(i).copied(), None);
                times.iter().map(|&t| newton(times, known, t)).unzip()
            }
            (None, _) => quintic::rates_and_accelerations(times, &values),
        };
        values.into_iter().zip(rates.into_iter().zip(accelerations)).map(target).collect()
    }
}

/// A function that is a quintic between neighbouring samples.
#[derive(Clone, Debug)]
pub(crate) struct Spline {
    times: Arc<[f64]>,
    knots: Vec<Target<f64>>,
    /// True if the solutions of neighbouring windows disagreed, so that the spline was solved for
    /// all samples at once.
    is_global: bool,
}

impl Spline {
    /// Creates the spline through `samples` at two or more strictly increasing `times`.
    pub(crate) fn new(times: &Arc<[f64]>, samples: Samples) -> Self {
        let part =
            |list: &[f64], window: Range<usize>| list.get(window).unwrap_or_default().to_vec();
        let (parted, is_global) = match samples.given() {
            Given::Accelerations => (None, false),
            Given::Values | Given::Rates => {
                let parted = by_windows(times, &samples.values, |window| {
                    samples.part(&window).knots(&part(times, window))
                });
                let is_global = parted.is_none() && is_long(times.len());
                (parted, is_global)
            }
        };
        let knots = parted.unwrap_or_else(|| samples.knots(times));
        Self { times: Arc::clone(times), knots, is_global }
    }

    /// Creates the spline with the given values, rates and accelerations at `times`.
    pub(crate) fn of_knots(times: &Arc<[f64]>, knots: Vec<Target<f64>>) -> Self {
        Self { times: Arc::clone(times), knots, is_global: false }
    }

    /// Tests whether a long spline was solved for all samples at once instead of window by window.
    pub(crate) fn is_global(&self) -> bool {
        self.is_global
    }

    /// Tests whether value, rate and acceleration are finite at all samples.
    pub(crate) fn is_finite(&self) -> bool {
        self.knots.iter().all(|k| (k.value + k.rate + k.acceleration).is_finite())
    }

    /// Times of the samples, s.
    pub(crate) fn times(&self) -> &[f64] {
        &self.times
    }

    /// Evaluates the spline at `t`, s. At a sample, the value is exactly that of the sample.
    pub(crate) fn at(&self, t: f64) -> Target<f64> {
        let last = self.times.len().saturating_sub(2);
        let i = self.times.partition_point(|&time| time <= t).saturating_sub(1).min(last);
        let piece = (
            self.times.get(i).zip(self.times.get(i + 1)),
            self.knots.get(i).zip(self.knots.get(i + 1)),
        );
        let (Some((&t0, &t1)), Some((&k0, &k1))) = piece else {
            return self.knots.first().copied().unwrap_or(Target {
                value: f64::NAN,
                rate: f64::NAN,
                acceleration: f64::NAN,
            });
        };
        // Evaluate from the nearer end, so that both end values are exact.
        if t - t0 <= t1 - t {
            between(k0, k1, t1 - t0, t - t0)
        } else {
            between(k1, k0, t0 - t1, t - t1)
        }
    }
}

/// Evaluates at `t` the quintic with value, rate and acceleration `a` at 0 and `b` at `h`; `h` may
/// be negative.
fn between(a: Target<f64>, b: Target<f64>, h: f64, t: f64) -> Target<f64> {
    let u = t / h;
    let rise = b.value - a.value;
    let (d0, d1) = (a.rate * h, b.rate * h);
    let (a0, a1) = (a.acceleration * h * h, b.acceleration * h * h);
    let c3 = 10.0 * rise - 6.0 * d0 - 4.0 * d1 - 1.5 * a0 + 0.5 * a1;
    let c4 = -15.0 * rise + 8.0 * d0 + 7.0 * d1 + 1.5 * a0 - a1;
    let c5 = 6.0 * rise - 3.0 * d0 - 3.0 * d1 - 0.5 * a0 + 0.5 * a1;
    Target {
        value: a.value + u * (d0 + u * (0.5 * a0 + u * (c3 + u * (c4 + u * c5)))),
        rate: (d0 + u * (a0 + u * (3.0 * c3 + u * (4.0 * c4 + u * 5.0 * c5)))) / h,
        acceleration: (a0 + u * (6.0 * c3 + u * (12.0 * c4 + u * 20.0 * c5))) / (h * h),
    }
}

/// Returns rate and acceleration at `t` of the polynomial through a few samples, by divided
/// differences with repeated nodes. `known` returns the value and, if it is given, the rate of a
/// sample.
fn newton(
    times: &[f64],
    known: impl Fn(usize) -> (Option<f64>, Option<f64>),
    t: f64,
) -> (f64, f64) {
    // Nodes, the current column of the table of divided differences, and the given rate at each
    // repeated node.
    let mut nodes: Vec<f64> = Vec::new();
    let mut column: Vec<f64> = Vec::new();
    let mut slopes: Vec<Option<f64>> = Vec::new();
    for (i, &time) in times.iter().enumerate() {
        if let (Some(value), rate) = known(i) {
            nodes.push(time);
            column.push(value);
            slopes.push(None);
            if let Some(rate) = rate {
                nodes.push(time);
                column.push(value);
                slopes.push(Some(rate));
            }
        }
    }
    // Coefficients of the polynomial in Newton's form, the highest last.
    let mut coefficients: Vec<f64> = column.first().copied().into_iter().collect();
    for order in 1..nodes.len() {
        let next = |k: usize| {
            let (low, high) = (nodes.get(k)?, nodes.get(k + order)?);
            let repeated = slopes.get(k + 1).copied().flatten().filter(|_| order == 1);
            let difference = column.get(k + 1)? - column.get(k)?;
            Some(repeated.unwrap_or(difference / (high - low)))
        };
        column = (0..nodes.len() - order).filter_map(next).collect();
        coefficients.extend(column.first());
    }
    let (mut value, mut rate, mut acceleration) = (0.0, 0.0, 0.0);
    for (coefficient, node) in coefficients.iter().zip(&nodes).rev() {
        acceleration = 2.0 * rate + (t - node) * acceleration;
        rate = value + (t - node) * rate;
        value = coefficient + (t - node) * value;
    }
    (rate, acceleration)
}

/// Computes the accelerations for which the quintic Hermite spline through values and rates has a
/// continuous third derivative at each inner sample, and a continuous fourth derivative at the
/// first and the last inner sample.
pub(super) fn accelerations_for_rates(times: &[f64], values: &[f64], rates: &[f64]) -> Vec<f64> {
    let n = times.len();
    let mut matrix = Banded::new(n, 2);
    let mut right = vec![0.0; n];
    let at = |list: &[f64], i: usize| list.get(i).copied().unwrap_or(f64::NAN);
    // Length of the interval that begins at sample `i`, slope of its chord, and the rates at its
    // ends.
    let interval = |i: usize| {
        let h = at(times, i + 1) - at(times, i);
        let slope = (at(values, i + 1) - at(values, i)) / h;
        (h, slope, at(rates, i), at(rates, i + 1))
    };
    for i in 1..n - 1 {
        let (h0, s0, v0, v1) = interval(i - 1);
        let (h1, s1, w0, w1) = interval(i);
        // The third derivative is (60 s0 - 24 v0 - 36 v1)/h0^2 + (-3 a_(i-1) + 9 a_i)/h0 on the
        // left of sample `i`, and (60 s1 - 36 w0 - 24 w1)/h1^2 + (-9 a_i + 3 a_(i+1))/h1 on the
        // right. The row equates both, multiplied by h0 h1.
        let (below, beside) = (h1, h0);
        matrix.set(i, i - 1, -3.0 * below);
        matrix.set(i, i, 9.0 * (below + beside));
        matrix.set(i, i + 1, -3.0 * beside);
        if let Some(right) = right.get_mut(i) {
            *right = (60.0 * s1 - 36.0 * w0 - 24.0 * w1) * (h0 / h1)
                - (60.0 * s0 - 24.0 * v0 - 36.0 * v1) * (h1 / h0);
        }
    }
    // The fourth derivative at the inner sample `i`, times h0^2, is (360 s0 - 168 v0 - 192 v1)/h0 -
    // 24 a_(i-1) + 36 a_i on the left. On the right it is (h0/h1)^2 times ((-360 s1 + 192 w0 + 168
    // w1)/h1 + 36 a_i - 24 a_(i+1)).
    // - 24 a_(i+1) on the right.
    // - 24 a_(i-1) + 36 a_i; right, times (h0/h1)^2: (-360 s1 + 192 w0 + 168 w1)/h1 + 36 a_i
    // - 24 a_(i+1).
    for (row, i) in [(0, 1), (n - 1, n - 2)] {
        let (h0, s0, v0, v1) = interval(i - 1);
        let (h1, s1, w0, w1) = interval(i);
        let ratio = (h0 / h1).powi(2);
        // The diagonal entry of the first row belongs to the first sample, that of the last row to
        // the last sample.
        matrix.set(row, i - 1, -24.0);
        matrix.set(row, i, 36.0 * (1.0 - ratio));
        matrix.set(row, i + 1, 24.0 * ratio);
        if let Some(right) = right.get_mut(row) {
            *right = ratio * (-360.0 * s1 + 192.0 * w0 + 168.0 * w1) / h1
                - (360.0 * s0 - 168.0 * v0 - 192.0 * v1) / h0;
        }
    }
    matrix.factor().solve(&mut right);
    right
}
