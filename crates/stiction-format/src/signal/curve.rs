//! A function of time through samples, with any kind of interpolation.

use super::hermite::{Given, Samples, Spline};
use super::monotone::{self, Monotone};
use crate::signal::samples::first_after;
use std::sync::Arc;
use stiction_core::kinematics::Target;

/// Kind of interpolation between samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Interpolation {
    /// A spline that is as smooth as the given derivatives allow.
    Spline(Given),
    /// Piecewise cubic without overshoot.
    Monotone,
}

impl Interpolation {
    /// Number of columns that the interpolation needs: values, and rates and accelerations if they
    /// are given.
    pub(crate) fn columns(self) -> usize {
        match self {
            Self::Monotone | Self::Spline(Given::Values) => 1,
            Self::Spline(Given::Rates) => 2,
            Self::Spline(Given::Accelerations) => 3,
        }
    }

    /// Describes the interpolation in words for this number of samples.
    pub(crate) fn describe(self, count: usize) -> String {
        match self {
            Self::Spline(given) => given.describe(count),
            Self::Monotone => monotone::DESCRIPTION.to_owned(),
        }
    }

    /// Computes value, rate and acceleration at all samples together. `columns` contains the
    /// values, and the rates and accelerations if they are given.
    pub(crate) fn knots(self, times: &[f64], columns: Vec<Vec<f64>>) -> Vec<Target<f64>> {
        match self {
            Self::Spline(_) => Samples::new(columns).knots(times),
            Self::Monotone => {
                let values = columns.into_iter().next().unwrap_or_default();
                monotone::knots(times, &values)
            }
        }
    }

    /// Tests whether rates or accelerations at a sample depend on distant samples. The results of
    /// neighbouring windows of a long recording must then be compared.
    pub(crate) fn reaches_far(self) -> bool {
        matches!(self, Self::Spline(Given::Values | Given::Rates))
    }
}

/// A function of time through samples.
#[derive(Clone, Debug)]
pub(crate) enum Curve {
    Spline(Spline),
    Monotone(Monotone),
}

impl Curve {
    /// Interpolates samples that are all in memory.
    pub(crate) fn through(
        interpolation: Interpolation,
        times: &Arc<[f64]>,
        columns: Vec<Vec<f64>>,
    ) -> Self {
        match interpolation {
            Interpolation::Spline(_) => Self::Spline(Spline::new(times, Samples::new(columns))),
            Interpolation::Monotone => {
                Self::of_knots(interpolation, times, interpolation.knots(times, columns))
            }
        }
    }

    /// Creates the function from value, rate and acceleration at each sample.
    pub(crate) fn of_knots(
        interpolation: Interpolation,
        times: &Arc<[f64]>,
        knots: Vec<Target<f64>>,
    ) -> Self {
        match interpolation {
            Interpolation::Spline(_) => Self::Spline(Spline::of_knots(times, knots)),
            Interpolation::Monotone => Self::Monotone(Monotone::of_knots(times, knots)),
        }
    }

    /// Tests whether value, rate and acceleration are finite at all samples.
    pub(crate) fn is_finite(&self) -> bool {
        match self {
            Self::Spline(spline) => spline.is_finite(),
            // The slopes are bounded by those of the adjacent chords, and thus finite.
            Self::Monotone(_) => true,
        }
    }

    /// Tests whether the spline of a long recording was solved for all samples at once instead of
    /// window by window.
    pub(crate) fn is_global(&self) -> bool {
        matches!(self, Self::Spline(spline) if spline.is_global())
    }

    /// Time of the first sample after `t`, s; `None` if no sample follows.
    pub(crate) fn after(&self, t: f64) -> Option<f64> {
        let times = match self {
            Self::Spline(spline) => spline.times(),
            Self::Monotone(monotone) => monotone.times(),
        };
        first_after(times, t)
    }

    /// Evaluates the function at `t`, s. At a sample, the value is exactly that of the sample.
    pub(crate) fn at(&self, t: f64) -> Target<f64> {
        match self {
            Self::Spline(spline) => spline.at(t),
            Self::Monotone(monotone) => monotone.at(t),
        }
    }
}
