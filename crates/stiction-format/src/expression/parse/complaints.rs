//! Error messages of the expression parser.

use super::super::Fault;
use super::super::function::Function;
use super::super::token::TokenKind;
use super::super::unit::{self, UNITS};
use super::{CONSTANTS, Parser, reserved};
use crate::diagnostic::{did_you_mean, nearest, quoted};
use crate::source::Span;

impl Parser<'_> {
    pub(super) fn unclosed(&self, open: Span) -> Fault {
        match self.kind() {
            TokenKind::End => Fault::new(open, "this `(` is not closed", "opened here"),
            _ => self.left_over(),
        }
    }

    /// Error for an unexpected token where an operator or the end of the expression was expected.
    pub(super) fn left_over(&self) -> Fault {
        let span = self.span();
        let word = self.word_at(0);
        match self.kind() {
            TokenKind::Symbol(')') => {
                Fault::new(span, "this `)` has no matching `(`", "no `(` before it")
            }
            TokenKind::Symbol(',') => Fault::new(span, "unexpected comma", "expected an operator")
                .help("write decimals with a point: 0.5"),
            TokenKind::Name if unit::find(word).is_some() => {
                Fault::new(span, "a unit can only follow a number", "expected an operator")
                    .help(format!("to multiply by the unit, write `* 1 {word}`"))
            }
            TokenKind::Name if reserved(word).is_none() && self.scope.find(word).is_none() => {
                self.unknown(true)
            }
            _ => Fault::new(span, "an operator is missing", "expected an operator")
                .help("multiplication is written with `*`"),
        }
    }

    /// Error for an unknown name at the next token; `unit` is true if a unit was expected.
    pub(super) fn unknown(&self, unit: bool) -> Fault {
        let name = self.word_at(0);
        if !unit
            && name.contains('.')
            && let Some(Err((message, help))) = self.scope.measured(name, false)
        {
            return Fault::new(self.span(), message, "unknown name")
                .maybe_help(help)
                .code("unknown-name");
        }
        let units = UNITS.iter().map(|unit| unit.name);
        let mut known = self.scope.names();
        known.extend(Function::ALL.iter().map(|(name, _)| *name));
        known.extend(CONSTANTS.iter().map(|(name, _)| *name));
        let is_time = self.time && name == "T";
        let help = is_time
            .then(|| "the time is `t`".to_owned())
            .or_else(|| unit::advice(name))
            .or_else(|| {
                let candidates: Vec<_> = match unit {
                    true => units.clone().collect(),
                    false => {
                        known.iter().copied().chain(units.clone().filter(|u| u.len() > 2)).collect()
                    }
                };
                nearest(name, candidates).map(|near| format!("did you mean `{near}`?"))
            })
            .or_else(|| match unit {
                true => did_you_mean(name, "units", units),
                false if self.scope.names().is_empty() => {
                    Some("parameters are defined in the table [parameters]".to_owned())
                }
                false => did_you_mean(name, "parameters", self.scope.names()),
            });
        let message = match unit {
            true => format!("{} is not a unit", quoted(name)),
            false => format!("{} is not defined", quoted(name)),
        };
        let label = if unit { "unknown unit" } else { "unknown name" };
        let code = if unit { "unit" } else { "unknown-name" };
        Fault::new(self.span(), message, label).maybe_help(help).code(code)
    }
}
