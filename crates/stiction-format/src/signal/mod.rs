//! Functions of time: formulas, and curves through samples or waypoints.

mod banded;
mod bspline;
mod curve;
pub(crate) mod filter;
mod hermite;
mod kinks;
pub(crate) mod law;
mod monotone;
pub(crate) mod quality;
mod quintic;
pub(crate) mod recorded;
pub(crate) mod samples;
pub(crate) mod waypoints;
mod windows;

pub(crate) use curve::{Curve, Interpolation};
pub(crate) use hermite::Given;
pub(crate) use kinks::RateJump;
pub(crate) use windows::{Window, agrees, is_long};

use crate::diagnostic::Diagnostic;
use crate::expression::Formula;
use crate::signal::recorded::Recorded;
use crate::signal::waypoints::{Course, Turning};
use crate::source::{Place, Source, Span};
use std::sync::Arc;
use stiction_core::kinematics::Target;

/// A function of time, for example a coordinate of a motion or a component of a load.
///
/// A signal is a constant, an expression with exact derivatives, a spline through samples, or a
/// motion through waypoints. At a kink of an expression (`abs`, `min`, `max`) the derivatives are
/// one-sided, towards later times.
#[derive(Clone, Debug)]
pub struct Signal {
    shape: Shape,
}

#[derive(Clone, Debug)]
enum Shape {
    Constant(f64),
    Formula(Arc<Written>),
    Curve(Arc<Curve>),
    /// Curve, given by its index, of a recording that is read in pieces.
    Recorded(Arc<Recorded>, usize),
    /// A coordinate that moves through waypoints.
    Course(Arc<Course>),
    /// A component of the rotation vector of a body that rotates through waypoints.
    Turning(Arc<Turning>, usize),
}

/// Formula with its place in the text.
#[derive(Debug)]
struct Written {
    formula: Formula,
    source: Arc<Source>,
    /// Place of the whole value in the text.
    value: Span,
    /// Byte offset of the formula's text in the source; `None` if the text contains escapes.
    start: Option<usize>,
}

impl Signal {
    /// Creates a signal with a constant value.
    pub fn constant(value: f64) -> Self {
        Self { shape: Shape::Constant(value) }
    }

    pub(crate) fn formula(
        formula: Formula,
        source: &Arc<Source>,
        value: Span,
        start: Option<usize>,
    ) -> Self {
        let written = Written { formula, source: Arc::clone(source), value, start };
        Self { shape: Shape::Formula(Arc::new(written)) }
    }

    /// Creates a spline through samples at strictly increasing times, s, with continuous rates and accelerations.
    pub fn through(times: &[f64], values: Vec<f64>) -> Self {
        let interpolation = Interpolation::Spline(Given::Values);
        Self::curve(Curve::through(interpolation, &times.into(), vec![values]))
    }

    pub(crate) fn curve(curve: Curve) -> Self {
        Self { shape: Shape::Curve(Arc::new(curve)) }
    }

    pub(crate) fn recorded(recording: &Arc<Recorded>, curve: usize) -> Self {
        Self { shape: Shape::Recorded(Arc::clone(recording), curve) }
    }

    pub(crate) fn course(course: Course) -> Self {
        Self { shape: Shape::Course(Arc::new(course)) }
    }

    /// Creates the signals of the three components of a body's rotation vector.
    pub(crate) fn turning(turning: Turning) -> [Self; 3] {
        let turning = Arc::new(turning);
        [0, 1, 2].map(|axis| Self { shape: Shape::Turning(Arc::clone(&turning), axis) })
    }

    /// Tests whether the signal was written as a constant.
    pub fn is_constant(&self) -> bool {
        matches!(self.shape, Shape::Constant(_))
    }

    /// Value at time `t` (s) with exact first and second time derivatives, in SI units.
    ///
    /// A formula without a finite value gives the result of floating-point arithmetic; a recording that can no longer
    /// be read gives NaN. [`Signal::fault_at`] gives the reason. Outside its samples, a spline continues with its
    /// first or last polynomial.
    pub fn at(&self, t: f64) -> Target<f64> {
        match &self.shape {
            Shape::Constant(value) => Target { value: *value, rate: 0.0, acceleration: 0.0 },
            Shape::Formula(written) => {
                let jet = written.formula.at(t);
                Target { value: jet.value, rate: jet.first, acceleration: jet.second }
            }
            Shape::Curve(curve) => curve.at(t),
            Shape::Recorded(recording, curve) => recording.at(*curve, t),
            Shape::Course(course) => course.at(t),
            Shape::Turning(turning, axis) => turning.at(t)[*axis],
        }
    }

    /// Returns a time, s, after `t` (s) such that a few samples between both times resolve the
    /// signal. The returned time lies before the next ramp or kink, within the period of a sine,
    /// before its next peak, or at the next sample.
    pub fn resolved_until(&self, t: f64) -> f64 {
        match &self.shape {
            Shape::Constant(_) => f64::INFINITY,
            Shape::Formula(written) => written.formula.resolved_until(t),
            Shape::Curve(curve) => curve.after(t).unwrap_or(f64::INFINITY),
            Shape::Recorded(recording, _) => recording.after(t).unwrap_or(f64::INFINITY),
            Shape::Course(course) => course.moves.after(t).unwrap_or(f64::INFINITY),
            Shape::Turning(turning, _) => turning.moves.after(t).unwrap_or(f64::INFINITY),
        }
    }

    /// Value of a constant signal; `None` for any other signal.
    pub fn as_constant(&self) -> Option<f64> {
        match self.shape {
            Shape::Constant(value) => Some(value),
            _ => None,
        }
    }

    /// Returns a diagnostic if the value or a derivative at time `t` (s) is not finite.
    pub fn fault_at(&self, t: f64) -> Option<Diagnostic> {
        self.checked_at(t).err()
    }

    /// Value with its derivatives at time `t` (s), as [`Self::at`] computes it.
    ///
    /// # Errors
    /// Returns the diagnostic of [`Self::fault_at`].
    pub fn checked_at(&self, t: f64) -> Result<Target<f64>, Diagnostic> {
        let written = match &self.shape {
            Shape::Constant(_) | Shape::Curve(_) | Shape::Course(_) | Shape::Turning(..) => {
                return Ok(self.at(t));
            }
            Shape::Recorded(recording, _) => {
                return recording.fault_at(t).map_or_else(|| Ok(self.at(t)), Err);
            }
            Shape::Formula(written) => written,
        };
        let fault = match written.formula.checked_at(t) {
            Ok(jet) => {
                return Ok(Target { value: jet.value, rate: jet.first, acceleration: jet.second });
            }
            Err(fault) => fault,
        };
        let span = match written.start {
            Some(start) => start + fault.span.start..start + fault.span.end,
            None => written.value.clone(),
        };
        let message =
            format!("this is not a finite number at t = {} s", crate::diagnostic::number(t));
        let diagnostic = Diagnostic::error("not-finite", message)
            .at(Place::new(&written.source, span), fault.label)
            .maybe_help(fault.help);
        Err(diagnostic)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_has_zero_rate() {
        let signal = Signal::constant(3.0);
        assert_eq!(signal.at(7.0), Target { value: 3.0, rate: 0.0, acceleration: 0.0 });
        assert_eq!(signal.as_constant(), Some(3.0));
        assert!(signal.fault_at(0.0).is_none());
    }

    #[test]
    fn a_number_as_a_formula_is_that_number() {
        let source = Arc::new(Source::new("a", "3"));
        let signal = Signal::formula(Formula::of_number(3.0), &source, 0..1, Some(0));
        assert_eq!(signal.at(1.0).value, 3.0);
    }
}
