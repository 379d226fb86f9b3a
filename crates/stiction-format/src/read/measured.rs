//! Reads formulas of measured coordinates: efforts and stop conditions.

use super::context::Context;
use super::names::Names;
use super::path::{Orders, Unresolved, coordinate, resolve};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::document::{Node, Value};
use crate::expression::{
    self, Dimension, Fault, Measure, Quantity, Scope, TimeFormula, Unmeasured, of_one_kind,
};
use crate::law::{Condition, Law};
use crate::parameters::Parameters;
use crate::signal::Signal;
use crate::source::{Place, Source};
use std::cell::RefCell;
use std::sync::Arc;
use stiction_core::kinematics::Coordinate;

/// Scope of an expression whose names are parameters and measured coordinates.
struct Measurable<'a> {
    parameters: &'a Parameters,
    names: &'a Names,
    used: RefCell<Vec<(Coordinate, bool)>>,
}

impl<'a> Measurable<'a> {
    fn new(context: &Context<'a>, names: &'a Names) -> Self {
        Self { parameters: context.parameters, names, used: RefCell::default() }
    }
}

impl Scope for Measurable<'_> {
    fn find(&self, name: &str) -> Option<usize> {
        self.parameters.find(name)
    }

    fn value(&self, index: usize) -> Option<Quantity> {
        self.parameters.value(index)
    }

    fn names(&self) -> Vec<&str> {
        let mut names = self.parameters.names();
        names.extend(self.names.joint_names());
        names
    }

    fn measured(&self, name: &str, rate: bool) -> Option<Result<(usize, Dimension), Unmeasured>> {
        let meant = resolve(self.names, name).and_then(|m| coordinate(m, &Orders::new()));
        Some(match meant {
            Ok((coordinate, measure)) => {
                let translates = measure == Measure::Length;
                let measure = match (rate, translates) {
                    (false, _) => measure,
                    (true, true) => Measure::Speed,
                    (true, false) => Measure::AngularSpeed,
                };
                let mut used = self.used.borrow_mut();
                let place = used.iter().position(|known| *known == (coordinate, rate));
                let index = place.unwrap_or_else(|| {
                    used.push((coordinate, rate));
                    used.len() - 1
                });
                Ok((index, measure.dimension()))
            }
            Err(unresolved) => Err(explained(unresolved, self.names, name)),
        })
    }
}

fn explained(unresolved: Unresolved, names: &Names, name: &str) -> Unmeasured {
    match unresolved.explain(names, &[], name) {
        Some((message, help, _)) => (message, help),
        None => (format!("`{name}` is invalid"), None),
    }
}

/// An effort as a function of time, or as a formula that also depends on the measured state.
pub(crate) enum Effort {
    Signal(Signal),
    Law(Law),
}

/// Reads an effort as a number or an expression, which may contain the time and measured coordinates.
pub(crate) fn effort(
    context: &Context<'_>,
    names: &Names,
    value: &Value,
    measure: Measure,
) -> Option<Effort> {
    let Node::Text(text) = &value.node else {
        return context.signal(value, measure).map(Effort::Signal);
    };
    if context.is_full() {
        return None;
    }
    let scope = Measurable::new(context, names);
    match expression::in_time(&text.content, &scope, measure) {
        Ok(TimeFormula::Changing(formula)) if !scope.used.borrow().is_empty() => {
            Some(Effort::Law(Law::new(formula, scope.used.into_inner())))
        }
        Ok(_) => context.signal(value, measure).map(Effort::Signal),
        Err(fault) => {
            context.fault(&value.span, text, fault);
            None
        }
    }
}

/// Reads a condition that ends a simulation, such as `platform.z < 100 mm`.
pub(crate) fn condition(
    context: &Context<'_>,
    names: &Names,
    source: &Arc<Source>,
) -> Result<Condition, Diagnostics> {
    let text = source.text.as_str();
    let refuse = |span: std::ops::Range<usize>, message: &str| -> Diagnostics {
        Diagnostic::error("syntax", message)
            .at(Place::new(source, span), "not a condition")
            .help("write for example \"platform.z < 100 mm\" or \"d(leg1.P) > 0.5 m/s\"")
            .into()
    };
    let mut signs = text.match_indices(['<', '>', '=']);
    let Some((at, sign)) = signs.next() else {
        return Err(refuse(0..text.len(), "a condition compares two quantities with `<` or `>`"));
    };
    let (mut from, mut or_equal) = (at + 1, false);
    let mut next = signs.next();
    if let Some((second, "=")) = next
        && second == from
    {
        (from, next, or_equal) = (second + 1, signs.next(), true);
    }
    if let Some((second, _)) = next {
        return Err(refuse(second..second + 1, "a condition can contain only one comparison"));
    }
    if sign == "=" {
        let message = "an equality is true for an instant only; write `<` or `>` instead";
        return Err(refuse(at..from, message));
    }
    let (left, right) = (text.get(..at).unwrap_or_default(), text.get(from..).unwrap_or_default());
    let scope = Measurable::new(context, names);
    let formulas = of_one_kind([left, right], &scope);
    let [left, right] = formulas.map_err(|(fault, second)| {
        let Fault { span, code, message, label, help, echo: _ } = fault;
        let start = if second { from } else { 0 };
        let place = Place::new(source, start + span.start..start + span.end);
        Diagnostics::from(Diagnostic::error(code, message).at(place, label).maybe_help(help))
    })?;
    let used = scope.used.into_inner();
    let is_constant = used.is_empty() && !left.has_time() && !right.has_time();
    if is_constant {
        return Err(refuse(
            0..text.len(),
            "this condition does not depend on the motion or the time",
        ));
    }
    let law = |formula| Law::new(formula, used.clone());
    let text = text.trim().to_owned();
    Ok(Condition { text, left: law(left), right: law(right), is_less: sign == "<", or_equal })
}
