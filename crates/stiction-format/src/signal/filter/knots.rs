//! Equally spaced knots of the filter's spline, and the penalty on its fourth derivative.

use super::super::banded::Banded;
use super::super::bspline::{Knots, ORDER, local};
use std::sync::Arc;
use stiction_core::kinematics::Target;

/// Half bandwidth of matrices over B-splines of order six.
pub(super) const BAND: usize = ORDER - 1;

/// Equally spaced knots from `start` to `end`, s; the first and the last knot occur six times.
#[derive(Clone, Copy, Debug)]
pub(super) struct EqualKnots {
    pub(super) start: f64,
    pub(super) end: f64,
    pub(super) intervals: usize,
}

impl Knots for EqualKnots {
    fn at(&self, index: usize) -> f64 {
        self.knot((index.max(ORDER - 1) - (ORDER - 1)).min(self.intervals))
    }
}

impl EqualKnots {
    /// Number of B-splines on these knots.
    pub(super) fn size(&self) -> usize {
        self.intervals + ORDER - 1
    }

    /// Distance between neighbouring knots, s.
    pub(super) fn step(&self) -> f64 {
        (self.end - self.start) / self.intervals as f64
    }

    /// Returns the time of a knot, s. The index counts repeated knots only once.
    pub(super) fn knot(&self, index: usize) -> f64 {
        if index >= self.intervals {
            return self.end;
        }
        self.start + index as f64 * self.step()
    }

    /// All knots, s, without repetition.
    pub(super) fn times(&self) -> Arc<[f64]> {
        (0..=self.intervals).map(|k| self.knot(k)).collect()
    }

    /// Returns the index of the interval between knots that contains `t`, and the values at `t` of
    /// the six B-splines that can be nonzero in this interval. The first of these B-splines has the
    /// same index as the interval.
    pub(super) fn splines_at(&self, t: f64) -> (usize, [f64; ORDER]) {
        let place = ((t - self.start) / self.step()).floor().max(0.0) as usize;
        let first = place.min(self.intervals - 1);
        (first, self.splines::<ORDER>(first, t))
    }

    /// Value, rate and acceleration at a knot of the spline with these coefficients.
    pub(super) fn target_at(&self, coefficients: &[f64], knot: usize) -> Target<f64> {
        let first = knot.min(self.intervals - 1);
        self.target(local(coefficients, first), first, self.knot(knot))
    }

    /// Returns the index of the first of the six coefficients that determine the spline at a knot,
    /// and the weights of these coefficients in the rate and in the acceleration.
    pub(super) fn derivative_weights(&self, knot: usize) -> (usize, [[f64; ORDER]; 2]) {
        let first = knot.min(self.intervals - 1);
        let mut weights = [[0.0; ORDER]; 2];
        for k in 0..ORDER {
            let mut unit = [0.0; ORDER];
            unit[k] = 1.0;
            let Target { rate, acceleration, .. } = self.target(unit, first, self.knot(knot));
            weights[0][k] = rate;
            weights[1][k] = acceleration;
        }
        (first, weights)
    }

    /// Adds `factor` times the integral of the squared fourth derivative to `matrix`, as a
    /// quadratic form of the spline coefficients.
    pub(super) fn add_penalty(&self, matrix: &mut Banded, factor: f64) {
        for first in 0..self.intervals {
            // The fourth derivative is linear within an interval, so its values at both ends
            // determine it.
            let mut ends = [[0.0; 2]; ORDER];
            for (k, ends) in ends.iter_mut().enumerate() {
                let mut c = [0.0; ORDER];
                c[k] = 1.0;
                for order in (ORDER - 3..=ORDER).rev() {
                    self.differentiate(&mut c, first, order);
                }
                *ends = [c[ORDER - 2], c[ORDER - 1]];
            }
            let third = factor * self.step() / 3.0;
            for (i, a) in ends.iter().enumerate() {
                for (k, b) in ends.iter().enumerate() {
                    let mixed = 0.5 * (a[0] * b[1] + a[1] * b[0]);
                    let value = third * (a[0] * b[0] + mixed + a[1] * b[1]);
                    matrix.add(first + i, first + k, value);
                }
            }
        }
    }
}
