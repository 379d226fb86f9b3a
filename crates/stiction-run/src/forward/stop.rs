//! Conditions that end a simulation.

use super::control_law::{Measured, actuator_motion};
use crate::{Error, SinkError};
use std::fmt;
use std::sync::Arc;
use stiction_core::forward::View;
use stiction_format::Condition;

/// Condition that ends a simulation.
#[derive(Clone, Debug)]
pub enum Stop {
    /// Condition that compares two formulas.
    Formula(Condition),
    /// Condition that evaluates a function of the caller.
    Function(StopFunction),
}

type Compute = dyn Fn(&Measured<'_>) -> Result<f64, SinkError> + Send + Sync;

/// Function that the caller provides as a stop condition. The simulation ends at the instant at
/// which the value of the function becomes negative.
#[derive(Clone)]
pub struct StopFunction {
    name: String,
    compute: Arc<Compute>,
}

impl StopFunction {
    /// Creates a stop condition from a function. `name` identifies the condition in events and
    /// messages.
    ///
    /// The function receives the measured state without reference motions. It is evaluated at trial
    /// states of integration steps and therefore must depend on its argument only.
    pub fn new(
        name: &str,
        compute: impl Fn(&Measured<'_>) -> Result<f64, SinkError> + Send + Sync + 'static,
    ) -> Self {
        Self { name: name.to_owned(), compute: Arc::new(compute) }
    }
}

impl fmt::Debug for StopFunction {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("StopFunction").field("name", &self.name).finish_non_exhaustive()
    }
}

impl Stop {
    /// Returns the text of the condition as the user wrote it, or the name of the function.
    pub fn text(&self) -> &str {
        match self {
            Self::Formula(condition) => &condition.text,
            Self::Function(function) => &function.name,
        }
    }

    /// Returns the value of the condition in a state of a mechanism with `actuators` actuators; the
    /// value is negative if the condition is true.
    ///
    /// # Errors
    /// Returns an error if the condition has no value in this state, or if the function failed.
    pub(super) fn distance(&self, view: &View<'_>, actuators: usize) -> Result<f64, Error> {
        let distance = match self {
            Self::Formula(condition) => condition.distance(view.time, |c| view.measure(c)),
            Self::Function(function) => {
                let (positions, rates) = actuator_motion(view, actuators);
                let (time, reference) = (view.time, &[][..]);
                let measured = Measured { time, positions: &positions, rates: &rates, reference };
                (function.compute)(&measured).map_err(Error::Receiver)?
            }
        };
        if distance.is_nan() {
            let (condition, time) = (self.text().to_owned(), view.time);
            return Err(Error::NoCondition { condition, time });
        }
        Ok(distance)
    }

    /// Returns true if the condition can depend on time explicitly.
    pub(super) fn has_time(&self) -> bool {
        match self {
            Self::Formula(condition) => condition.has_time(),
            Self::Function(_) => true,
        }
    }

    /// Returns the end, s, of the interval from `t`, s, in which a few samples resolve the explicit
    /// dependence of the condition on time. Infinite for a function, whose dependence on time is
    /// unknown.
    pub(super) fn resolved_until(&self, t: f64) -> f64 {
        match self {
            Self::Formula(condition) => condition.resolved_until(t),
            Self::Function(_) => f64::INFINITY,
        }
    }
}

impl From<Condition> for Stop {
    fn from(condition: Condition) -> Self {
        Self::Formula(condition)
    }
}
