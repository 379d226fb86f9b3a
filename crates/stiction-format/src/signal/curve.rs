//! A function through samples, whichever way the gaps are filled.

use super::hermite::{Given, Samples, Spline};
use super::monotone::{self, Monotone};
use crate::signal::samples::first_after;
use std::sync::Arc;
use stiction_core::kinematics::Target;

/// How the gaps between samples are filled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fill {
    /// By a spline, as smoothly as what is given allows.
    Spline(Given),
    /// Without overshoot.
    Monotone,
}

impl Fill {
    /// How many columns of numbers it takes.
    pub(crate) fn columns(self) -> usize {
        match self {
            Self::Monotone | Self::Spline(Given::Values) => 1,
            Self::Spline(Given::Rates) => 2,
            Self::Spline(Given::Accelerations) => 3,
        }
    }

    /// How the gaps of so many samples are filled, in words.
    pub(crate) fn describe(self, count: usize) -> String {
        match self {
            Self::Spline(given) => given.describe(count),
            Self::Monotone => monotone::WORDS.to_owned(),
        }
    }

    /// Value, rate and acceleration at all samples, from the equations of all of them.
    pub(crate) fn knots(self, times: &[f64], columns: Vec<Vec<f64>>) -> Vec<Target<f64>> {
        match self {
            Self::Spline(_) => Samples::new(columns).knots(times),
            Self::Monotone => {
                let values = columns.into_iter().next().unwrap_or_default();
                monotone::knots(times, &values)
            }
        }
    }

    /// Whether knots depend on samples far away, so that it must be seen whether windows agree.
    pub(crate) fn reaches_far(self) -> bool {
        matches!(self, Self::Spline(Given::Values | Given::Rates))
    }
}

/// A function through samples.
#[derive(Clone, Debug)]
pub(crate) enum Curve {
    Spline(Spline),
    Monotone(Monotone),
}

impl Curve {
    /// The function through samples of which all are at hand.
    pub(crate) fn through(fill: Fill, times: &Arc<[f64]>, columns: Vec<Vec<f64>>) -> Self {
        match fill {
            Fill::Spline(_) => Self::Spline(Spline::new(times, Samples::new(columns))),
            Fill::Monotone => Self::of_knots(fill, times, fill.knots(times, columns)),
        }
    }

    /// The function with these knots.
    pub(crate) fn of_knots(fill: Fill, times: &Arc<[f64]>, knots: Vec<Target<f64>>) -> Self {
        match fill {
            Fill::Spline(_) => Self::Spline(Spline::of_knots(times, knots)),
            Fill::Monotone => Self::Monotone(Monotone::of_knots(times, knots)),
        }
    }

    /// Whether all that was computed is finite.
    pub(crate) fn is_finite(&self) -> bool {
        match self {
            Self::Spline(spline) => spline.is_finite(),
            // Slopes lie between those of chords.
            Self::Monotone(_) => true,
        }
    }

    /// Whether it is long and had to be solved at once all the same.
    pub(crate) fn is_stiff(&self) -> bool {
        matches!(self, Self::Spline(spline) if spline.is_stiff())
    }

    /// The first instant of a sample after `t`, s; nothing after the last.
    pub(crate) fn after(&self, t: f64) -> Option<f64> {
        let times = match self {
            Self::Spline(spline) => spline.times(),
            Self::Monotone(monotone) => monotone.times(),
        };
        first_after(times, t)
    }

    /// The value at `t`, exactly that of the sample where there is one.
    pub(crate) fn at(&self, t: f64) -> Target<f64> {
        match self {
            Self::Spline(spline) => spline.at(t),
            Self::Monotone(monotone) => monotone.at(t),
        }
    }
}
