//! Stability of the loop of a sampled controller and the actuators, without friction, at the start
//! of a simulation.
//!
//! Between two samples, efforts are constant, and the accelerations follow from the mass matrix of
//! the actuators. Gravity, velocity-dependent forces and friction are neglected: high gains become
//! unstable within few samples, in which these forces hardly change.

use nalgebra::{DMatrix, DVector};
use serde_json::{Value, json};
use std::f64::consts::TAU;
use stiction_draw::numbers::number;
use stiction_format::Control;

/// Largest product of the period and the rate gain per mass for default gains. At 1, an error of the
/// rate is corrected within one period; from 2 on, the loop is unstable.
const BRISK: f64 = 1.0;
/// Growth of errors in one period that counts as a rounding error.
const ROUNDED: f64 = 1e-9;

/// Stability of a controller at the start of the simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tuning {
    /// Bandwidth of the default gains, rad/s, if the sampling period requires a lower one than
    /// usual.
    pub lowered: Option<f64>,
    /// Factor by which errors grow in each sampling period, if the loop is unstable without
    /// friction.
    pub growth: Option<f64>,
}

impl Tuning {
    /// Returns the stability as JSON, the bandwidth in Hz.
    pub(super) fn json(&self) -> Value {
        json!({
            "stable": self.growth.is_none(),
            "growth_per_period": self.growth,
            "lowered_bandwidth": self.lowered.map(|bandwidth| bandwidth / TAU),
        })
    }

    /// Returns a note if default gains were lowered. `period` is the sampling period, s.
    pub(super) fn note(&self, period: f64) -> Option<String> {
        let hertz = |bandwidth: f64| number(bandwidth / TAU);
        self.lowered.map(|lowered| {
            format!(
                "the gains of the controller have a bandwidth of {} Hz instead of {} Hz: coupled \
                 actuators sampled every {} s need the lower one; give a shorter `period` for more",
                hertz(lowered),
                hertz(Control::USUAL_BANDWIDTH),
                number(period)
            )
        })
    }

    /// Returns a caution if the loop is unstable. `period` is the sampling period, s.
    pub(super) fn caution(&self, period: f64) -> Option<String> {
        self.growth.map(|growth| {
            format!(
                "the controller is unstable at the start: without friction, errors grow by a factor of {} in \
                 each sampling period of {} s; give lower gains, a lower `bandwidth` or a shorter `period`",
                number(growth),
                number(period)
            )
        })
    }
}

/// Gains of a sampled controller and the mass matrix on which they act.
#[derive(Clone, Debug)]
pub(super) struct SampledLoop {
    /// Mass matrix of the actuators that the controller moves, kg or kg m^2.
    pub(super) masses: DMatrix<f64>,
    /// Gains on positions and on rates.
    pub(super) proportional: DVector<f64>,
    pub(super) derivative: DVector<f64>,
    /// Sampling period, s.
    pub(super) period: f64,
    /// True if the controller computes rates from positions.
    pub(super) differences: bool,
}

impl SampledLoop {
    /// Returns the factor by which the fastest growing error increases in each period, or `None` if
    /// the loop is stable, is continuous in time, or has no invertible mass matrix.
    pub(super) fn growth(&self) -> Option<f64> {
        let Self { proportional, derivative, period, .. } = self;
        if *period <= 0.0 {
            return None;
        }
        let n = self.masses.nrows();
        let inverse = self.masses.clone().try_inverse()?;
        let position_gains = &inverse * DMatrix::from_diagonal(proportional);
        let rate_gains = &inverse * DMatrix::from_diagonal(derivative);
        // State: errors of positions, errors of rates, errors of positions at the last sample.
        let mut step = DMatrix::zeros(3 * n, 3 * n);
        let unit = DMatrix::<f64>::identity(n, n);
        let mut by_position = position_gains;
        let (mut by_rate, mut by_last) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        if self.differences {
            by_position += &rate_gains / *period;
            by_last -= &rate_gains / *period;
        } else {
            by_rate = rate_gains;
        }
        for (row, kinematic, advance) in [
            (0, [&unit * 1.0, &unit * *period], 0.5 * period * period),
            (n, [&unit * 0.0, &unit * 1.0], *period),
        ] {
            let [position, rate] = kinematic;
            step.view_mut((row, 0), (n, n)).copy_from(&(position - &by_position * advance));
            step.view_mut((row, n), (n, n)).copy_from(&(rate - &by_rate * advance));
            step.view_mut((row, 2 * n), (n, n)).copy_from(&(&by_last * -advance));
        }
        step.view_mut((2 * n, 0), (n, n)).copy_from(&unit);
        if !step.iter().all(|x| x.is_finite()) {
            return None;
        }
        let values = step.try_schur(f64::EPSILON, 10_000)?.complex_eigenvalues();
        let growth = values.iter().map(|z| z.norm()).fold(0.0, f64::max);
        (growth > 1.0 + ROUNDED).then_some(growth)
    }
}

/// Returns the largest bandwidth, rad/s, of default gains with the given damping ratio and sampling
/// period, s, that leaves a margin to instability; infinite without a limit. The gains of each
/// actuator are proportional to its element on the diagonal of the mass matrix. The coupling of the
/// actuators makes the loop faster than each of them alone: its fastest rate gain is that of a
/// single mass, divided by the smallest eigenvalue of the mass matrix scaled to a unit diagonal.
pub(super) fn largest_bandwidth(masses: &DMatrix<f64>, damping: f64, period: f64) -> f64 {
    let n = masses.nrows();
    let over = |k: usize| masses[(k, k)].sqrt().recip();
    let scaled =
        DMatrix::from_fn(n, n, |i, j| 0.5 * (masses[(i, j)] + masses[(j, i)]) * over(i) * over(j));
    if n == 0 || !scaled.iter().all(|x| x.is_finite()) {
        return f64::INFINITY;
    }
    let least = scaled.symmetric_eigenvalues().min();
    let rate = 2.0 * damping * period;
    match least > 0.0 && rate > 0.0 {
        true => BRISK * least / rate,
        false => f64::INFINITY,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single(kp: f64, kd: f64, differences: bool) -> Option<f64> {
        let (masses, period) = (DMatrix::from_element(1, 1, 2.0), 0.01);
        let (proportional, derivative) =
            (DVector::from_element(1, 2.0 * kp), DVector::from_element(1, 2.0 * kd));
        SampledLoop { masses, proportional, derivative, period, differences }.growth()
    }

    /// A sampled double integrator with gains kp and kd per mass is stable for
    /// kp T^2/2 < kd T < 2 (Jury's criterion).
    #[test]
    fn the_limits_of_a_single_mass_are_those_of_jury() {
        assert_eq!(single(100.0, 199.0, false), None);
        assert!(single(100.0, 201.0, false).unwrap() > 1.001);
        assert_eq!(single(100.0, 0.51, false), None);
        assert!(single(100.0, 0.49, false).unwrap() > 1.00004);
        // Rates from differences are half a period late. Without kp, errors of the rate follow
        // z^2 + (kd T/2 - 1) z + kd T/2 = 0.
        assert_eq!(single(0.0, 150.0, true), None);
        let growth = single(100.0, 240.0, true).unwrap();
        assert!((growth - 1.2_f64.sqrt()).abs() < 0.01, "{growth}");
    }

    /// Two coupled masses: without the limit the loop is unstable, with it the loop is stable.
    #[test]
    fn the_largest_bandwidth_is_stable() {
        let masses = DMatrix::from_row_slice(2, 2, &[2.0, 3.98, 3.98, 8.0]);
        let (damping, period) = (1.0, 1e-3);
        let growth = |omega: f64| {
            let diagonal = masses.diagonal();
            let proportional = &diagonal * (omega * omega);
            let derivative = &diagonal * (2.0 * damping * omega);
            let masses = masses.clone();
            [false, true].map(|differences| {
                let (proportional, derivative) = (proportional.clone(), derivative.clone());
                let masses = masses.clone();
                SampledLoop { masses, proportional, derivative, period, differences }.growth()
            })
        };
        let omega = largest_bandwidth(&masses, damping, period);
        assert!(omega < 60.0);
        assert_eq!(growth(omega), [None, None]);
        let [growth, _] = growth(2.2 * omega);
        assert!(growth.is_some());
        // A single mass has the limit of a rate gain of half its inverse period.
        let single = largest_bandwidth(&DMatrix::from_element(1, 1, 3.0), damping, period);
        assert!((single - 500.0).abs() < 1e-9);
        assert_eq!(largest_bandwidth(&masses, damping, 0.0), f64::INFINITY);
    }
}
