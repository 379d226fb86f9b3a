//! Expressions with units: `"128.48 mm"`, `"2*l1 + 5 mm"`, `"5 mm*sin(2*pi*t)"`.
//!
//! An expression is compiled to instructions of a stack machine instead of a tree, so that no input
//! can overflow the call stack.

mod check;
pub(crate) mod dimension;
mod function;
pub(crate) mod jet;
mod measure;
mod parse;
mod run;
mod sampling;
mod state;
#[cfg(test)]
mod tests;
pub(crate) mod token;
pub(crate) mod unit;

pub(crate) use check::{Quantity, TimeFormula, constant, in_time, of_one_kind};
pub(crate) use dimension::Dimension;
pub(crate) use measure::Measure;
pub(crate) use parse::{Program, parse, reserved, unit_of};
pub(crate) use run::Formula;

use crate::source::Span;

/// An error in an expression, with its place in the text of the expression.
#[derive(Clone, Debug)]
pub(crate) struct Fault {
    pub(crate) span: Span,
    pub(crate) code: &'static str,
    pub(crate) message: String,
    pub(crate) label: String,
    pub(crate) help: Option<String>,
    /// True if the error is a consequence of another error, which is reported elsewhere.
    pub(crate) echo: bool,
}

impl Fault {
    pub(crate) fn new(span: Span, message: impl Into<String>, label: impl Into<String>) -> Self {
        let (message, label) = (message.into(), label.into());
        Self { span, code: "expression", message, label, help: None, echo: false }
    }

    pub(crate) fn code(mut self, code: &'static str) -> Self {
        self.code = code;
        self
    }

    pub(crate) fn help(self, help: impl Into<String>) -> Self {
        self.maybe_help(Some(help.into()))
    }

    /// Replaces the advice to write a unit such as `kg m` if a quantity of the kind `measure` cannot
    /// have this unit and the text `whole` consists only of a number and the unit.
    pub(crate) fn with_unit_of(self, measure: Measure, whole: &str) -> Self {
        let before = whole.get(..self.span.start).unwrap_or_default();
        let is_alone =
            self.span.end == whole.trim_end().len() && before.trim().parse::<f64>().is_ok();
        let advised = self.help.as_ref().and_then(|help| {
            let unit = help.strip_prefix("write `")?.strip_suffix('`')?;
            Some(unit_of(unit).ok()?.1)
        });
        match advised {
            Some(unit) if is_alone && measure.complaint(unit).is_some() => {
                self.help(format!("expected {}", measure.expected()))
            }
            _ => self,
        }
    }

    pub(crate) fn maybe_help(mut self, help: Option<String>) -> Self {
        self.help = help;
        self
    }
}

/// Named values that expressions can use.
pub(crate) trait Scope {
    /// Index of the parameter with this name; `None` if there is no such parameter.
    fn find(&self, name: &str) -> Option<usize>;
    /// Value of a parameter; `None` if the definition of the parameter is invalid.
    fn value(&self, index: usize) -> Option<Quantity>;
    /// Names of all parameters, for suggestions.
    fn names(&self) -> Vec<&str>;
    /// Looks up a measured coordinate, or the rate of a coordinate if `rate` is true. Returns the
    /// index and dimension of the coordinate or rate; for any other name, an error message and
    /// help. Returns `None` where expressions cannot use coordinates.
    fn measured(&self, name: &str, rate: bool) -> Option<Result<(usize, Dimension), Unmeasured>> {
        let _ = (name, rate);
        None
    }
}

/// Error message and optional help for a name that is not a measured coordinate.
pub(crate) type Unmeasured = (String, Option<String>);
