//! Low-pass filter for recordings: a smoothing spline with a stated cut-off frequency.
//!
//! Among all quintic splines on equal knots, the filtered signal `f` minimises `∫ (f - y)^2 dt + λ
//! ∫ (f'''')^2 dt`, with the first integral as a sum over the samples. Away from the ends this is a
//! filter without phase shift whose amplitude is `1/(1 + λ ω^8)`, as that of a Butterworth filter
//! of order four that is run forward and backward. `λ` is chosen so that this amplitude is `1/√2`
//! (-3 dB) at the cut-off frequency, which is 0.896 times the cut-off frequency of the Butterworth
//! filter run once. No assumption is made about the signal beyond its ends: cubics pass unchanged,
//! so the ends do not ring. Derivatives are those of the spline and need no differences.
//!
//! An interval over which the samples fit a constant within their noise becomes exactly constant:
//! see [`rest`].

mod knots;
mod low_pass;
mod rest;
mod samples;
mod suggestion;

pub use low_pass::{LowPass, Smooth};
pub(crate) use rest::Rest;
pub(crate) use samples::Samples;
pub(crate) use suggestion::suggest;

use super::banded::{Banded, Factored};
use super::quality::Peak;
use super::{Curve, Given, Interpolation};
use knots::{BAND, EqualKnots};
use std::f64::consts::TAU;

/// Knots per period of the cut-off frequency. Up to twice the cut-off frequency, the spline then
/// has the same frequency response as a smoothing spline with a knot at each sample.
const KNOTS_PER_PERIOD: f64 = 8.0;
/// Maximum number of knots, for which the equations need about 500 MB.
pub(crate) const MAX_KNOTS: f64 = 1.5e6;
/// Minimum number of periods of the cut-off frequency in a recording.
pub(crate) const MIN_PERIODS: f64 = 1.0;
/// Maximum ratio of the cut-off frequency to the sampling rate.
pub(crate) const MAX_RATIO: f64 = 0.4;
/// `λ` times the eighth power of the cut-off frequency (rad/s). With this value, the amplitude at
/// the cut-off frequency is `1/√2`.
const WEIGHT: f64 = std::f64::consts::SQRT_2 - 1.0;
/// Upper limit of the estimated noise near the cut-off frequency, as a multiple of that of white
/// noise whose third differences have the same rms value.
const MOST_COLOURED: f64 = 3.0;
/// Number of standard deviations of the noise up to which a difference between filtered
/// accelerations is attributed to noise.
const SMEARING_SIGMAS: f64 = 4.0;
/// Greatest difference between the step responses of two filters whose cut-off frequencies have the ratio 1.5, relative
/// to the height of the step. At the step itself, the filtered signal is wrong by half of the height.
const STEP_DIFFERENCE: f64 = 0.1194;
/// Product of the cut-off frequency and the time in which the filtered signal rises from 10 % to 90 % of a step.
const RISE: f64 = 0.40;
/// Integral of the squared amplitude of filtered accelerations, `∫ (u^2/(1 + WEIGHT u^8))^2 du`
/// from 0 to infinity, where `u` is the ratio of frequency to cut-off frequency. In closed form
/// `(3/64) π/sin(3π/8) WEIGHT^(-5/8)`.
const ACCELERATION_AREA: f64 = 0.276_51;
/// `∫ (1/(1 + WEIGHT u^8))^2 du` and `∫ (u/(1 + WEIGHT u^8))^2 du` from 0 to infinity, for value and rate. In
/// closed form `(7/64) π/sin(π/8) WEIGHT^(-1/8)` and `(5/64) π/sin(3π/8) WEIGHT^(-3/8)`.
const AREAS: [f64; 2] = [1.002_48, 0.369_71];

/// Rise time, s, of the filtered signal at a step, from 10 % to 90 % of the height of the step, for
/// a cut-off frequency, Hz.
pub(crate) fn rise_time(cutoff: f64) -> f64 {
    RISE / cutoff
}

/// Number of knots of the filter's spline for a cut-off frequency, Hz, and a duration, s.
pub(crate) fn knots_needed(cutoff: f64, duration: f64) -> f64 {
    (KNOTS_PER_PERIOD * cutoff * duration).ceil()
}

/// A filtered signal and its properties.
#[derive(Clone, Debug)]
pub(crate) struct Filtered {
    pub(crate) curve: Curve,
    /// Standard deviation of the part that the filter removes, SI units of the signal.
    pub(crate) removed: f64,
    /// Standard deviation of the noise that remains in the acceleration, m/s^2 or rad/s^2.
    pub(crate) acceleration_noise: f64,
    /// Standard deviations of the noise that remains in value and rate, SI units.
    pub(crate) noise_left: [f64; 2],
    /// Largest magnitude of the filtered acceleration.
    pub(crate) acceleration: Peak,
    /// Largest loss of acceleration by smoothing, beyond what noise explains: the difference from a
    /// filter with 1.5 times the cut-off frequency, minus the effect of noise. Zero if noise
    /// explains the whole difference.
    pub(crate) smearing: Peak,
    /// Error of the acceleration at the time of `smearing` if the acceleration has a step there:
    /// half the height of the step, estimated from the difference of the two filters.
    pub(crate) error_at_step: f64,
    /// Times at which the signal is at rest, s.
    pub(crate) rests: Vec<Rest>,
}

/// Least-squares equations of several signals sampled at the same times.
#[derive(Clone, Debug)]
struct Equations {
    cutoff: f64,
    knots: EqualKnots,
    /// Products of each two B-splines, weighted and summed over the samples.
    gram: Banded,
    /// Right-hand sides of the equations, one list for each signal: its products with the
    /// B-splines, weighted and summed over the samples.
    rights: Vec<Vec<f64>>,
    /// For each signal, its square, weighted and summed over the samples.
    squares: Vec<f64>,
    /// Sum of the weights of all samples, s.
    weights: f64,
    count: usize,
}

impl Equations {
    fn new(cutoff: f64, (start, end): (f64, f64), signals: usize) -> Self {
        let intervals = knots_needed(cutoff, end - start).max(BAND as f64) as usize;
        let knots = EqualKnots { start, end, intervals };
        Self {
            cutoff,
            knots,
            gram: Banded::new(knots.size(), BAND),
            rights: vec![vec![0.0; knots.size()]; signals],
            squares: vec![0.0; signals],
            weights: 0.0,
            count: 0,
        }
    }

    /// Adds a sample of all signals. The weight is the time interval that the sample represents, s.
    fn push(&mut self, t: f64, values: &[f64], weight: f64) {
        let (first, splines) = self.knots.splines_at(t);
        for (i, a) in splines.iter().enumerate() {
            for (k, b) in splines.iter().enumerate() {
                self.gram.add(first + i, first + k, weight * a * b);
            }
        }
        for ((right, squares), value) in self.rights.iter_mut().zip(&mut self.squares).zip(values) {
            for (entry, spline) in right.iter_mut().skip(first).zip(&splines) {
                *entry += weight * spline * value;
            }
            *squares += weight * value * value;
        }
        self.weights += weight;
        self.count += 1;
    }

    /// Mean time between samples, s.
    fn step(&self) -> f64 {
        self.weights / self.count.max(1) as f64
    }

    /// Computes the matrix of the least-squares equations, with the penalty on the fourth
    /// derivative.
    fn matrix(&self) -> Banded {
        let mut matrix = self.gram.clone();
        self.knots.add_penalty(&mut matrix, WEIGHT / (TAU * self.cutoff).powi(8));
        matrix
    }

    fn solve(&self) -> Solution<'_> {
        let factored = self.matrix().factor();
        let inverse = factored.inverse_within_band();
        let size = self.knots.size();
        let near = |row: usize| row.saturating_sub(BAND)..(row + BAND + 1).min(size);
        let product = |row: usize| -> f64 {
            near(row).map(|k| inverse.get(row, k) * self.gram.get(k, row)).sum()
        };
        let parameters = (0..size).map(product).sum();
        Solution { equations: self, factored, inverse, parameters }
    }
}

/// Solution of the least-squares equations without rest conditions.
struct Solution<'a> {
    equations: &'a Equations,
    factored: Factored,
    /// Entries, within the band, of the inverse of the matrix of the equations.
    inverse: Banded,
    /// Effective number of parameters of the fit.
    parameters: f64,
}

impl Solution<'_> {
    fn coefficients(&self, signal: usize) -> Vec<f64> {
        let mut c = self.equations.rights[signal].clone();
        self.factored.solve(&mut c);
        c
    }

    /// Standard deviations of rate and acceleration at a knot if the samples contain white noise of
    /// unit variance.
    fn spread(&self, knot: usize) -> [f64; 2] {
        let (first, weights) = self.equations.knots.derivative_weights(knot);
        weights.map(|weights| {
            let mut sum = 0.0;
            for (i, a) in weights.iter().enumerate() {
                for (k, b) in weights.iter().enumerate() {
                    sum += a * self.inverse.get(first + i, first + k) * b;
                }
            }
            (self.equations.step() * sum.max(0.0)).sqrt()
        })
    }

    /// Mean square of the residuals of a signal.
    fn mean_square(&self, signal: usize, c: &[f64]) -> f64 {
        let equations = self.equations;
        let fitted = dot(c, &equations.gram.times(c));
        let sum = equations.squares[signal] - 2.0 * dot(c, &equations.rights[signal]) + fitted;
        // Rounding can make this difference of nearly equal numbers negative.
        sum.max(f64::EPSILON * equations.squares[signal]) / equations.weights
    }

    /// Standard deviation of the noise of a signal, from the residuals.
    fn noise(&self, signal: usize, c: &[f64]) -> f64 {
        let count = self.equations.count as f64;
        let left = (count - self.parameters).max(1.0);
        (self.mean_square(signal, c) * count / left).sqrt()
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Filters all signals of the samples.
pub(crate) fn filter(samples: &Samples) -> Vec<Filtered> {
    let equations = &samples.equations;
    let solution = equations.solve();
    let finer = samples.finer.as_ref().map(Equations::solve);
    let fit = |signal: usize| {
        let c = solution.coefficients(signal);
        let removed = solution.noise(signal, &c);
        // If the cut-off frequency is too low, the residuals contain the motion itself.
        let noise = removed.min(MOST_COLOURED * samples.roughness(signal));
        let rested = rest::impose(&solution, signal, &c, noise);
        let knots = rested.knots(samples.offset(signal));
        let times = equations.knots.times();
        let mut acceleration = Peak::default();
        for (&time, knot) in times.iter().zip(&knots) {
            acceleration.raise(knot.acceleration.abs(), time);
        }
        let curve = Curve::of_knots(Interpolation::Spline(Given::Values), &times, knots);
        let (mut smearing, mut error_at_step) = (Peak::default(), 0.0);
        if let Some(finer) = &finer {
            let c = finer.coefficients(signal);
            let rested = rest::impose(finer, signal, &c, noise);
            for (k, knot) in rested.knots(0.0).iter().enumerate() {
                let time = finer.equations.knots.knot(k);
                let difference = (knot.acceleration - curve.at(time).acceleration).abs();
                let [_, spread] = finer.spread(k);
                let size = difference - SMEARING_SIGMAS * noise * spread;
                if size > smearing.size {
                    error_at_step = 0.5 * difference / STEP_DIFFERENCE;
                }
                smearing.raise(size, time);
            }
        }
        let cutoff = TAU * equations.cutoff;
        let density = 2.0 * noise * noise * equations.step() / TAU;
        Filtered {
            curve,
            removed,
            acceleration_noise: (density * ACCELERATION_AREA * cutoff.powi(5)).sqrt(),
            noise_left: [
                (density * AREAS[0] * cutoff).sqrt(),
                (density * AREAS[1] * cutoff.powi(3)).sqrt(),
            ],
            acceleration,
            smearing,
            error_at_step,
            rests: rested.rests,
        }
    };
    (0..equations.rights.len()).map(fit).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;
    use stiction_core::kinematics::Target;

    /// Normally distributed numbers of unit variance, by splitmix64 and Box and Muller.
    fn normal(mut seed: u64) -> impl FnMut() -> f64 {
        let mut uniform = move || {
            seed = seed.wrapping_add(0x9e37_79b9_7f4a_7c15);
            let mut z = seed;
            z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
            z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
            ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
        };
        move || (-2.0 * (1.0 - uniform()).ln()).sqrt() * (TAU * uniform()).cos()
    }

    fn sampled(rate: f64, duration: f64, mut f: impl FnMut(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
        let count = (rate * duration).round() as usize;
        let times: Vec<f64> = (0..=count).map(|k| k as f64 / rate).collect();
        let values = times.iter().map(|&t| f(t)).collect();
        (times, values)
    }

    fn filtered(cutoff: f64, times: &[f64], values: &[f64]) -> Filtered {
        let (start, end) = (times[0], times[times.len() - 1]);
        let rate = (times.len() - 1) as f64 / (end - start);
        let mut samples = Samples::new(cutoff, (start, end), 1).with_finer(rate, MAX_KNOTS);
        for (&t, &value) in times.iter().zip(values) {
            samples.push(t, &[value]);
        }
        filter(&samples.finish()).remove(0)
    }

    /// Motion from rest to rest in 2 s, by the minimum-jerk quintic.
    fn quintic(t: f64) -> Target<f64> {
        let (s, u) = (0.05, (t / 2.0).clamp(0.0, 1.0));
        Target {
            value: s * u.powi(3) * (10.0 - 15.0 * u + 6.0 * u * u),
            rate: s * 30.0 * u * u * (1.0 - u).powi(2) / 2.0,
            acceleration: s * 60.0 * u * (1.0 - 2.0 * u) * (1.0 - u) / 4.0,
        }
    }

    /// Checks the amplitude of sines in the middle of a long recording, without phase shift: `1/√2`
    /// at the cut-off frequency, `1/(1 + WEIGHT/256)` at half of it.
    #[test]
    fn amplitudes_are_those_of_the_stated_filter() {
        for (ratio, expected) in [(1.0, 0.5f64.sqrt()), (0.5, 1.0 / (1.0 + WEIGHT / 256.0))] {
            let frequency = 5.0 * ratio;
            let (times, values) = sampled(1000.0, 8.0, |t| (TAU * frequency * (t - 4.0)).cos());
            let found = filtered(5.0, &times, &values).curve.at(4.0);
            // The spline with eight knots per period has the response of one with a knot at each sample.
            assert!((found.value - expected).abs() < 1e-3, "{ratio}: {}", found.value);
            assert!(found.rate.abs() < 1e-3 * TAU * frequency, "{ratio}: {}", found.rate);
        }
    }

    /// Checks that the noise remaining in the acceleration after filtering has the predicted
    /// standard deviation, and that a signal of noise alone is at rest.
    #[test]
    fn noise_of_the_acceleration_is_predicted() {
        let mut noise = normal(7);
        let (times, values) = sampled(1000.0, 60.0, |_| 1e-5 * noise());
        let found = filtered(10.0, &times, &values);
        let square = |t: &f64| found.curve.at(*t).acceleration.powi(2);
        let middle = &times[5000..55_000];
        // With some 1100 independent values, the estimate is accurate to about 3 %. Rest is imposed on pure noise, so
        // the comparison uses a signal that moves.
        let moving: Vec<f64> =
            times.iter().zip(&values).map(|(t, y)| y + 0.1 * (0.5 * t).sin()).collect();
        let moving = filtered(10.0, &times, &moving);
        let error = |t: &f64| (moving.curve.at(*t).acceleration + 0.025 * (0.5 * t).sin()).powi(2);
        let rms = (middle.iter().map(error).sum::<f64>() / middle.len() as f64).sqrt();
        assert!((rms / moving.acceleration_noise - 1.0).abs() < 0.1, "{rms}");
        assert_eq!(middle.iter().map(square).sum::<f64>(), 0.0, "a signal of noise alone rests");
    }

    /// Checks that cubics pass unchanged up to both ends, so that the ends do not ring.
    #[test]
    fn cubics_pass_unchanged() {
        let f = |t: f64| Target {
            value: 1.0 + 0.3 * t - 2.0 * t * t + 0.7 * t.powi(3),
            rate: 0.3 - 4.0 * t + 2.1 * t * t,
            acceleration: -4.0 + 4.2 * t,
        };
        let (times, values) = sampled(500.0, 1.5, |t| f(t).value);
        let found = filtered(6.0, &times, &values);
        for &t in &times {
            let (a, b) = (found.curve.at(t), f(t));
            // Round-off of values of order one; second derivatives magnify it by the square of the number of knots
            // per second.
            assert!((a.value - b.value).abs() < 1e-11, "{t}");
            assert!((a.acceleration - b.acceleration).abs() < 1e-7, "{t}");
        }
    }

    /// Checks the suggested cut-off frequency for noisy motions from rest to rest. The acceleration
    /// must be accurate to 5 % of its peak, also at the ends, and the motion must begin and end
    /// exactly at rest.
    #[test]
    fn the_suggested_filter_restores_a_motion_between_rests() {
        for seed in 0..20 {
            let mut noise = normal(seed);
            let (times, values) = sampled(1000.0, 2.0, |t| quintic(t).value + 20e-6 * noise());
            let cutoff = suggest(&times, std::slice::from_ref(&values)).unwrap();
            let found = filtered(cutoff, &times, &values);
            let error =
                |t: &f64| (found.curve.at(*t).acceleration - quintic(*t).acceleration).abs();
            let worst = times.iter().map(error).fold(0.0, f64::max);
            assert!(worst < 0.05 * 0.0722, "seed {seed}, {cutoff} Hz: {worst}");
            assert_eq!(found.smearing.size, 0.0, "seed {seed}");
            for t in [0.0, 2.0] {
                let end = found.curve.at(t);
                assert_eq!((end.rate, end.acceleration), (0.0, 0.0), "seed {seed}");
            }
        }
    }

    /// Checks that dwells between motions are exactly at rest, and that motions between dwells are
    /// not.
    #[test]
    fn noisy_dwells_rest() {
        let f = |t: f64| quintic(t - 1.0).value + quintic(t - 5.0).value;
        for seed in 0..10 {
            let mut noise = normal(seed);
            let (times, values) = sampled(1000.0, 8.0, |t| f(t) + 20e-6 * noise());
            let found = filtered(6.0, &times, &values);
            assert_eq!(found.rests.len(), 3, "seed {seed}: {:?}", found.rests);
            for t in [0.0, 0.5, 0.9, 3.3, 4.0, 4.7, 7.2, 8.0] {
                assert_eq!(found.curve.at(t).rate, 0.0, "seed {seed}, {t}");
            }
            for t in [1.3, 2.0, 2.7, 5.3, 6.0, 6.7] {
                assert!(found.curve.at(t).rate > 0.01, "seed {seed}, {t}");
            }
        }
    }

    /// Checks the reported smearing of a motion whose acceleration has a step of 4. The step
    /// responses of two filters whose cut-off frequencies have the ratio 1.5 differ by at most
    /// 0.1194 of the step, according to numerical inversion of their frequency responses; four
    /// standard deviations of the noise are subtracted. At the step, the filtered acceleration is
    /// wrong by half of the step, 2.
    #[test]
    fn smearing_of_acceleration_steps_is_reported() {
        // Acceleration 2 for 1 s, then -2 for 1 s.
        let f = |t: f64| if t < 1.0 { t * t } else { 2.0 - (2.0 - t) * (2.0 - t) };
        for (seed, size, least) in [(1, 0.0, 0.11), (2, 20e-6, 0.07)] {
            let mut noise = normal(seed);
            let (times, values) = sampled(1000.0, 2.0, |t| f(t) + size * noise());
            let found = filtered(8.0, &times, &values);
            let error = (found.curve.at(1.0 - 1e-9).acceleration - 2.0).abs();
            assert!((error / 2.0 - 1.0).abs() < 0.1, "{error}");
            assert!((found.error_at_step / error - 1.0).abs() < 0.25, "{}", found.error_at_step);
            let Peak { size, time } = found.smearing;
            assert!((least * 4.0..0.13 * 4.0).contains(&size), "{size}");
            assert!((time - 1.0).abs() < rise_time(8.0), "{time}");
        }
    }

    /// Checks the constants `AREAS` and `ACCELERATION_AREA`, and their closed forms, by the
    /// trapezoidal rule.
    #[test]
    fn areas_of_value_rate_and_acceleration() {
        let u = |k: usize| 1e-3 * k as f64;
        let amplitude = |u: f64| 1.0 / (1.0 + WEIGHT * u.powi(8));
        let closed = [
            7.0 / 64.0 * PI / (0.125 * PI).sin() * WEIGHT.powf(-0.125),
            5.0 / 64.0 * PI / (0.375 * PI).sin() * WEIGHT.powf(-0.375),
            3.0 / 64.0 * PI / (0.375 * PI).sin() * WEIGHT.powf(-0.625),
        ];
        for (order, stated) in [AREAS[0], AREAS[1], ACCELERATION_AREA].into_iter().enumerate() {
            let value = |u: f64| (u.powi(order as i32) * amplitude(u)).powi(2);
            // The trapezoidal rule gives the value at zero half the weight of the others.
            let area: f64 =
                (0..20_000).map(|k| 1e-3 * value(u(k))).sum::<f64>() - 5e-4 * value(0.0);
            assert!((stated - closed[order]).abs() < 1e-4, "{order}: {}", closed[order]);
            assert!((area - closed[order]).abs() < 1e-6, "{order}: {area}");
        }
    }
}
