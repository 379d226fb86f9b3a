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
/// Largest product of the period and the bandwidth for default gains, relative to the damping ratio.
/// From 4 on, the loop is unstable, because the damping is less than the delay of half a period takes away.
const DAMPED: f64 = 2.0;
/// Smallest growth of errors in one period that is reported. Slower growth depends on friction and on other
/// forces that the analysis neglects.
const REPORTED: f64 = 1.01;
/// Fraction of the usual bandwidth below which lowered gains deserve a caution.
const USEFUL: f64 = 0.05;

/// Stability of the loop of a controller and the actuators at the start of the simulation.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Tuning {
    /// Bandwidth of the default gains, rad/s, if the sampling period requires a lower one than
    /// usual.
    pub lowered: Option<f64>,
    /// Factor by which the slowest decaying or fastest growing error changes in each sampling
    /// period, without friction; `None` for a controller in continuous time, and if the mass
    /// matrix of the actuators is not known.
    pub growth: Option<f64>,
}

impl Tuning {
    /// Combines the stability with different payloads: the lowest bandwidth and the fastest growth.
    pub(super) fn worst(self, other: Self) -> Self {
        let of = |a: Option<f64>, b: Option<f64>, choose: fn(f64, f64) -> f64| match (a, b) {
            (Some(a), Some(b)) => Some(choose(a, b)),
            _ => a.or(b),
        };
        Self {
            lowered: of(self.lowered, other.lowered, f64::min),
            growth: of(self.growth, other.growth, f64::max),
        }
    }

    /// Returns the stability as JSON, the bandwidth in Hz.
    pub(super) fn json(&self) -> Value {
        json!({
            "growth_per_period": self.growth,
            "lowered_bandwidth": self.lowered.map(|bandwidth| bandwidth / TAU),
        })
    }

    /// Returns a note if default gains were lowered. `period` is the sampling period, s.
    pub(super) fn note(&self, period: f64) -> Option<String> {
        let lowered = self.lowered?;
        Some(format!(
            "the default gains have a bandwidth of {} Hz instead of {} Hz: with the sampling period \
             of {} s, higher gains come close to instability; a shorter `period` permits them",
            number(lowered / TAU),
            number(Control::USUAL_BANDWIDTH / TAU),
            number(period)
        ))
    }

    /// Returns a caution if the loop is unstable or hardly acts. `period` is the sampling period, s.
    pub(super) fn caution(&self, period: f64) -> Option<String> {
        if let Some(growth) = self.growth.filter(|growth| *growth > REPORTED) {
            return Some(format!(
                "the controller is unstable at the start: without friction, errors grow by a \
                 factor of {} in each sampling period of {} s; give lower gains, more damping or a \
                 shorter `period`",
                number(growth),
                number(period)
            ));
        }
        self.lowered.filter(|lowered| *lowered < USEFUL * Control::USUAL_BANDWIDTH).map(|lowered| {
            format!(
                "the controller hardly acts: default gains with a bandwidth of {} Hz are the highest \
                 that leave a margin to instability; give `kp` and `kd`, or a shorter `period`",
                number(lowered / TAU)
            )
        })
    }
}

/// Gains of a sampled controller and the mass matrix on which they act.
#[derive(Clone, Debug)]
pub(super) struct SampledLoop {
    /// Mass matrix of the actuators that the controller moves, kg or kg m^2.
    pub(super) masses: DMatrix<f64>,
    /// Gains on positions, on rates, and on integrals of positions.
    pub(super) proportional: DVector<f64>,
    pub(super) derivative: DVector<f64>,
    pub(super) integral: DVector<f64>,
    /// Sampling period, s.
    pub(super) period: f64,
    /// True if the controller computes rates from positions.
    pub(super) differences: bool,
}

impl SampledLoop {
    /// Returns the largest factor by which an error changes in one period: the spectral radius of
    /// the sampled loop. Returns `None` for a controller in continuous time, without actuators, and
    /// if the mass matrix is not invertible.
    pub(super) fn growth(&self) -> Option<f64> {
        let (n, period) = (self.masses.nrows(), self.period);
        if period <= 0.0 || n == 0 {
            return None;
        }
        let inverse = self.masses.clone().try_inverse()?;
        let per_mass = |gains: &DVector<f64>| &inverse * DMatrix::from_diagonal(gains);
        let mut by_position = per_mass(&self.proportional);
        let (mut by_rate, mut by_last) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        let rate_gains = per_mass(&self.derivative);
        if self.differences {
            by_position += &rate_gains / period;
            by_last -= &rate_gains / period;
        } else {
            by_rate = rate_gains;
        }
        // State: errors of positions and of rates, errors of positions at the last sample, integral
        // parts of the efforts.
        let unit = DMatrix::<f64>::identity(n, n);
        let mut step = DMatrix::zeros(4 * n, 4 * n);
        let mut put = |row: usize, column: usize, block: DMatrix<f64>| {
            step.view_mut((row * n, column * n), (n, n)).copy_from(&block);
        };
        for (row, of_position, of_rate, advance) in
            [(0, 1.0, period, 0.5 * period * period), (1, 0.0, 1.0, period)]
        {
            put(row, 0, &unit * of_position - &by_position * advance);
            put(row, 1, &unit * of_rate - &by_rate * advance);
            put(row, 2, &by_last * -advance);
            put(row, 3, &inverse * advance);
        }
        put(2, 0, unit.clone());
        put(3, 0, DMatrix::from_diagonal(&self.integral) * -period);
        // An integral part that nothing changes would count as an error that does not decay.
        let integrates =
            DVector::from_iterator(n, self.integral.iter().map(|k| f64::from(*k > 0.0)));
        put(3, 3, DMatrix::from_diagonal(&integrates));
        if !step.iter().all(|x| x.is_finite()) {
            return None;
        }
        let values = step.try_schur(f64::EPSILON, 10_000)?.complex_eigenvalues();
        Some(values.iter().map(|z| z.norm()).fold(0.0, f64::max))
    }
}

/// Returns the largest bandwidth, rad/s, of default gains with the given damping ratio and sampling
/// period, s, that leaves a margin to instability; infinite without a limit, and without damping,
/// where no gains are stable. The gains of each actuator are proportional to its effective mass, an
/// entry on the diagonal of the mass matrix. The actuators are coupled, so the loop is faster than
/// each of them alone: its fastest rate gain is that of a single mass, divided by the smallest
/// eigenvalue of the mass matrix scaled to a unit diagonal.
pub(super) fn largest_bandwidth(masses: &DMatrix<f64>, damping: f64, period: f64) -> f64 {
    let n = masses.nrows();
    let over = |k: usize| masses[(k, k)].sqrt().recip();
    let scaled =
        DMatrix::from_fn(n, n, |i, j| 0.5 * (masses[(i, j)] + masses[(j, i)]) * over(i) * over(j));
    let rate = 2.0 * damping * period;
    if n == 0 || rate <= 0.0 || !scaled.iter().all(|x| x.is_finite()) {
        return f64::INFINITY;
    }
    // At a singular position, rounding determines the smallest eigenvalue.
    let least = scaled.symmetric_eigenvalues().min().max(n as f64 * f64::EPSILON);
    (BRISK * least / rate).min(DAMPED * damping / period)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn single(kp: f64, kd: f64, differences: bool) -> f64 {
        with_integral(kp, kd, 0.0, differences)
    }

    fn with_integral(kp: f64, kd: f64, ki: f64, differences: bool) -> f64 {
        let (masses, period) = (DMatrix::from_element(1, 1, 2.0), 0.01);
        let [proportional, derivative, integral] =
            [kp, kd, ki].map(|gain| DVector::from_element(1, 2.0 * gain));
        let sampled =
            SampledLoop { masses, proportional, derivative, integral, period, differences };
        sampled.growth().unwrap()
    }

    /// A sampled double integrator with gains kp and kd per mass is stable for
    /// kp T^2/2 < kd T < 2 (Jury's criterion). The integral part requires about ki < kp kd.
    #[test]
    fn the_limits_of_a_single_mass_are_those_of_jury() {
        assert!(single(100.0, 199.0, false) < 1.0);
        assert!(single(100.0, 201.0, false) > 1.001);
        assert!(single(100.0, 0.51, false) < 1.0);
        assert!(single(100.0, 0.49, false) > 1.00004);
        // Rates from differences are half a period late. Without kp, errors of the rate follow
        // z^2 + (kd T/2 - 1) z + kd T/2 = 0.
        assert!(single(0.0, 150.0, true) < 1.0 + 1e-7);
        let growth = single(100.0, 240.0, true);
        assert!((growth - 1.2_f64.sqrt()).abs() < 0.01, "{growth}");
        let (kp, kd) = (100.0, 20.0);
        assert!(with_integral(kp, kd, 0.8 * kp * kd, false) < 1.0);
        assert!(with_integral(kp, kd, 1.3 * kp * kd, false) > 1.0);
        // Without gains, errors of the rate stay, and errors of the position grow linearly.
        assert!((single(0.0, 0.0, false) - 1.0).abs() < 1e-6);
    }

    /// Two coupled masses: above the limit the loop becomes unstable, below it the loop is stable.
    #[test]
    fn the_largest_bandwidth_is_stable() {
        let masses = DMatrix::from_row_slice(2, 2, &[2.0, 3.98, 3.98, 8.0]);
        let (damping, period) = (1.0, 1e-3);
        let growth = |omega: f64| {
            let diagonal = masses.diagonal();
            [false, true].map(|differences| {
                let sampled = SampledLoop {
                    masses: masses.clone(),
                    proportional: &diagonal * (omega * omega),
                    derivative: &diagonal * (2.0 * damping * omega),
                    integral: DVector::zeros(2),
                    period,
                    differences,
                };
                sampled.growth().unwrap()
            })
        };
        let omega = largest_bandwidth(&masses, damping, period);
        assert!(omega < 60.0);
        assert!(growth(omega).iter().all(|growth| *growth < 1.0));
        assert!(growth(2.2 * omega)[0] > REPORTED);
        // A single mass has the limit of a rate gain of half its inverse period.
        let single = largest_bandwidth(&DMatrix::from_element(1, 1, 3.0), damping, period);
        assert!((single - 500.0).abs() < 1e-9);
        assert_eq!(largest_bandwidth(&masses, damping, 0.0), f64::INFINITY);
        // With little damping, the delay by sampling limits the bandwidth.
        let single = largest_bandwidth(&DMatrix::from_element(1, 1, 3.0), 0.1, 0.01);
        assert!((single - 20.0).abs() < 1e-9);
        // Actuators that the robot cannot move independently.
        let singular = DMatrix::from_row_slice(2, 2, &[1.0, 1.0, 1.0, 1.0]);
        assert!(largest_bandwidth(&singular, damping, period) < 1e-9);
    }
}
