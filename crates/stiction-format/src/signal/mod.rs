//! Functions of time.

mod banded;
mod curve;
mod hermite;
mod monotone;
mod quintic;
pub(crate) mod recorded;
pub(crate) mod samples;
mod windows;

pub(crate) use curve::{Curve, Fill};
pub(crate) use hermite::Given;
pub(crate) use windows::{Window, agrees, is_long};

use crate::diagnostic::Diagnostic;
use crate::expression::Formula;
use crate::signal::recorded::Recorded;
use crate::source::{Place, Source, Span};
use std::sync::Arc;
use stiction_core::kinematics::Target;

/// A number that changes in time: a coordinate of a motion, a component of a load.
///
/// It comes from an expression, with exact derivatives, or from samples, as a spline. At a kink of
/// an expression (`abs`, `min`, `max`) the derivatives are those towards later times.
#[derive(Clone, Debug)]
pub struct Signal {
    shape: Shape,
}

#[derive(Clone, Debug)]
enum Shape {
    Constant(f64),
    Formula(Arc<Written>),
    Curve(Arc<Curve>),
    /// One of the curves of a recording that is read piece by piece.
    Recorded(Arc<Recorded>, usize),
}

/// A formula and where it stands.
#[derive(Debug)]
struct Written {
    formula: Formula,
    source: Arc<Source>,
    /// The whole value.
    value: Span,
    /// Where its text begins, if it stands in the source letter by letter.
    start: Option<usize>,
}

impl Signal {
    /// A number that does not change.
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

    pub(crate) fn curve(curve: Curve) -> Self {
        Self { shape: Shape::Curve(Arc::new(curve)) }
    }

    pub(crate) fn recorded(recording: &Arc<Recorded>, curve: usize) -> Self {
        Self { shape: Shape::Recorded(Arc::clone(recording), curve) }
    }

    /// Whether it is the same at all times, as written.
    pub fn is_constant(&self) -> bool {
        matches!(self.shape, Shape::Constant(_))
    }

    /// The value at time `t` (s) with its exact first and second time derivative, in SI units.
    ///
    /// A formula that has no finite value there gives what floating-point arithmetic gives, a recording
    /// that cannot be read any more gives NaN; [`Signal::fault_at`] then says why. A spline continues
    /// with its first and last piece outside of its samples.
    pub fn at(&self, t: f64) -> Target<f64> {
        match &self.shape {
            Shape::Constant(value) => Target { value: *value, rate: 0.0, acceleration: 0.0 },
            Shape::Formula(written) => {
                let jet = written.formula.at(t);
                Target { value: jet.value, rate: jet.first, acceleration: jet.second }
            }
            Shape::Curve(curve) => curve.at(t),
            Shape::Recorded(recording, curve) => recording.at(*curve, t),
        }
    }

    /// The time up to which, from `t` (s) on, looks at a few instants tell what it does, s: it says so before ramps
    /// and kinks, within the turns of a sine and where it peaks, and at samples.
    pub fn seen_until(&self, t: f64) -> f64 {
        match &self.shape {
            Shape::Constant(_) => f64::INFINITY,
            Shape::Formula(written) => written.formula.seen_until(t),
            Shape::Curve(curve) => curve.after(t).unwrap_or(f64::INFINITY),
            Shape::Recorded(recording, _) => recording.after(t).unwrap_or(f64::INFINITY),
        }
    }

    /// The value, if it does not change in time.
    pub fn as_constant(&self) -> Option<f64> {
        match self.shape {
            Shape::Constant(value) => Some(value),
            _ => None,
        }
    }

    /// Why the value or one of its derivatives is not finite at time `t` (s), if it is not.
    pub fn fault_at(&self, t: f64) -> Option<Diagnostic> {
        let written = match &self.shape {
            Shape::Constant(_) | Shape::Curve(_) => return None,
            Shape::Recorded(recording, _) => return recording.fault_at(t),
            Shape::Formula(written) => written,
        };
        let fault = written.formula.fault_at(t)?;
        let span = match written.start {
            Some(start) => start + fault.span.start..start + fault.span.end,
            None => written.value.clone(),
        };
        let message =
            format!("at t = {} s this is not a finite number", crate::diagnostic::number(t));
        let diagnostic = Diagnostic::error("not-finite", message)
            .at(Place::new(&written.source, span), fault.label)
            .maybe_help(fault.help);
        Some(diagnostic)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stands_still() {
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
