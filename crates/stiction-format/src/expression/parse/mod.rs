//! Parser that compiles the tokens of an expression to instructions of the stack machine. The
//! grammar is:
//!
//! ```text
//! sum     = product (("+" | "-") product)*
//! product = signed (("*" | "/") signed)*
//! signed  = ("+" | "-")* power
//! power   = atom ("^" signed)?
//! atom    = number units? | units | name | name "(" sum ("," sum)* ")" | "(" sum ")"
//! units   = unit ("^" integer)? (("/")? unit ("^" integer)?)*      only one "/", and nothing after it
//! ```
//!
//! Units directly after a number bind tighter than any operator: `5 mm / 2 s` is (5 mm)/(2 s).

mod complaints;
mod units;

pub(crate) use units::unit_of;

use super::dimension::Dimension;
use super::function::Function;
use super::token::{Token, TokenKind, tokens};
use super::unit::{self, Scale};
use super::{Fault, Scope, Unmeasured};
use crate::diagnostic::{nearest, quoted};
use crate::source::Span;
use std::f64::consts;

/// Maximum nesting depth of parentheses, powers and calls.
const DEEPEST: usize = 64;

const CONSTANTS: &[(&str, f64)] = &[("pi", consts::PI), ("e", consts::E)];

/// One instruction of the stack machine.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Op {
    Number(f64, Dimension),
    Parameter(usize),
    Time,
    /// A measured coordinate or rate: its index in the scope, and its dimension.
    Measured(usize, Dimension),
    Negate,
    Add,
    Subtract,
    Multiply,
    Divide,
    Power,
    Call(Function, usize),
}

impl Op {
    /// Number of arguments that the instruction takes from the stack.
    pub(super) fn arguments(self) -> usize {
        match self {
            Self::Number(..) | Self::Parameter(_) | Self::Time | Self::Measured(..) => 0,
            Self::Negate => 1,
            Self::Call(_, count) => count,
            Self::Add | Self::Subtract | Self::Multiply | Self::Divide | Self::Power => 2,
        }
    }
}

/// A compiled expression: its instructions, each with the place of its operator or operand in the
/// text.
#[derive(Clone, Debug)]
pub(crate) struct Program {
    pub(crate) steps: Vec<(Op, Span)>,
}

impl Program {
    /// Indices of the parameters that the program uses.
    pub(crate) fn parameters(&self) -> impl Iterator<Item = usize> + '_ {
        self.steps.iter().filter_map(|(op, _)| match op {
            Op::Parameter(index) => Some(*index),
            _ => None,
        })
    }
}

/// Meaning of a reserved name, such as `a unit`; `None` if the name is available for a parameter.
pub(crate) fn reserved(name: &str) -> Option<&'static str> {
    if unit::find(name).is_some() && !unit::yields_to_parameters(name) {
        Some("a unit")
    } else if Function::find(name).is_some() {
        Some("a function")
    } else if CONSTANTS.iter().any(|(constant, _)| *constant == name) {
        Some("a constant")
    } else if name == "t" {
        Some("the time")
    } else {
        None
    }
}

/// Compiles `text` to instructions. `time` is true if the expression may contain the time `t`.
pub(crate) fn parse(text: &str, scope: &dyn Scope, time: bool) -> Result<Program, Fault> {
    let tokens = tokens(text)?;
    let mut parser = Parser { text, tokens, at: 0, scope, time, steps: Vec::new(), depth: 0 };
    if parser.kind() == TokenKind::End {
        return Err(Fault::new(0..text.len(), "the expression is empty", "expected an expression"));
    }
    parser.sum()?;
    match parser.kind() {
        TokenKind::End => Ok(Program { steps: parser.steps }),
        _ => Err(parser.left_over()),
    }
}

struct Parser<'a> {
    text: &'a str,
    tokens: Vec<Token>,
    at: usize,
    scope: &'a dyn Scope,
    time: bool,
    steps: Vec<(Op, Span)>,
    depth: usize,
}

impl<'a> Parser<'a> {
    fn kind_at(&self, ahead: usize) -> TokenKind {
        self.tokens.get(self.at + ahead).map_or(TokenKind::End, |token| token.kind)
    }

    fn kind(&self) -> TokenKind {
        self.kind_at(0)
    }

    fn span(&self) -> Span {
        let end = self.text.len()..self.text.len();
        self.tokens.get(self.at).map_or(end, |token| token.span.clone())
    }

    fn word_at(&self, ahead: usize) -> &'a str {
        let span = self.tokens.get(self.at + ahead).map(|token| token.span.clone());
        span.and_then(|span| self.text.get(span)).unwrap_or_default()
    }

    fn accept(&mut self, symbol: char) -> bool {
        let found = self.kind() == TokenKind::Symbol(symbol);
        self.at += usize::from(found);
        found
    }

    fn emit(&mut self, op: Op, span: Span) {
        self.steps.push((op, span));
    }

    fn nested<T>(&mut self, inner: fn(&mut Self) -> Result<T, Fault>) -> Result<T, Fault> {
        if self.depth == DEEPEST {
            return Err(Fault::new(
                self.span(),
                "the expression is nested too deeply",
                format!("this is level {}", DEEPEST + 1),
            )
            .help("define a part of it as a parameter in [parameters]"));
        }
        self.depth += 1;
        let result = inner(self);
        self.depth -= 1;
        result
    }

    fn sum(&mut self) -> Result<(), Fault> {
        self.product()?;
        while let TokenKind::Symbol(symbol @ ('+' | '-')) = self.kind() {
            let span = self.span();
            self.at += 1;
            self.product()?;
            self.emit(if symbol == '+' { Op::Add } else { Op::Subtract }, span);
        }
        Ok(())
    }

    fn product(&mut self) -> Result<(), Fault> {
        self.signed()?;
        while let TokenKind::Symbol(symbol @ ('*' | '/')) = self.kind() {
            let span = self.span();
            self.at += 1;
            self.signed()?;
            self.emit(if symbol == '*' { Op::Multiply } else { Op::Divide }, span);
        }
        Ok(())
    }

    fn signed(&mut self) -> Result<(), Fault> {
        let mut minus = None;
        while let TokenKind::Symbol(symbol @ ('+' | '-')) = self.kind() {
            if symbol == '-' {
                minus = if minus.is_some() { None } else { Some(self.span()) };
            }
            self.at += 1;
        }
        self.power()?;
        if let Some(span) = minus {
            self.emit(Op::Negate, span);
        }
        Ok(())
    }

    fn power(&mut self) -> Result<(), Fault> {
        self.atom()?;
        let span = self.span();
        if self.accept('^') {
            self.nested(Self::signed)?;
            self.emit(Op::Power, span);
        }
        Ok(())
    }

    fn atom(&mut self) -> Result<(), Fault> {
        let span = self.span();
        match self.kind() {
            TokenKind::Number => {
                let digits = self.word_at(0);
                self.at += 1;
                let (scale, dimension) = match self.unit_here() {
                    Some(_) => self.units()?,
                    None => (Scale::ONE, Dimension::NONE),
                };
                let value = scale.apply_to_digits(digits);
                let span = span.start..self.before();
                if !value.is_finite() {
                    let label = "the greatest number is about 1.8e308";
                    return Err(Fault::new(span, "the number is too large", label));
                }
                self.emit(Op::Number(value, dimension), span);
            }
            TokenKind::Name if self.is_rate() => self.rate()?,
            TokenKind::Name if self.kind_at(1) == TokenKind::Symbol('(') => self.call()?,
            TokenKind::Name if self.measured(0, false).is_some_and(|m| m.is_ok()) => {
                self.coordinate(false)?;
            }
            TokenKind::Name if self.unit_here().is_some() => {
                let named = self.scope.find(self.word_at(0));
                let (scale, dimension) = self.units()?;
                let end = self.before();
                let unit = Op::Number(scale.apply(1.0), dimension);
                // A parameter cannot have the name of a unit. If such a parameter is defined
                // nevertheless, the name refers to the parameter.
                self.emit(named.map_or(unit, Op::Parameter), span.start..end);
            }
            TokenKind::Name => self.name()?,
            TokenKind::Symbol('(') => {
                self.at += 1;
                self.nested(Self::sum)?;
                if !self.accept(')') {
                    return Err(self.unclosed(span));
                }
            }
            TokenKind::Symbol(symbol) => {
                return Err(Fault::new(
                    span,
                    format!("a number or a name is missing before `{symbol}`"),
                    "expected a number or a name",
                ));
            }
            TokenKind::End => {
                return Err(Fault::new(
                    span,
                    "the expression is incomplete",
                    "expected a number or a name",
                ));
            }
        }
        Ok(())
    }

    fn measured(&self, ahead: usize, rate: bool) -> Option<Result<(usize, Dimension), Unmeasured>> {
        self.scope.measured(self.word_at(ahead), rate)
    }

    /// Tests if the next tokens begin a rate, `d(`, and the expression may contain measured
    /// coordinates.
    fn is_rate(&self) -> bool {
        self.word_at(0) == "d"
            && self.kind_at(1) == TokenKind::Symbol('(')
            && self.measured(2, true).is_some()
    }

    /// Reads the rate of a measured coordinate, `d(NAME)`.
    fn rate(&mut self) -> Result<(), Fault> {
        let open = self.span();
        self.at += 2;
        if self.kind() != TokenKind::Name {
            return Err(Fault::new(
                self.span(),
                "`d` takes the name of a coordinate",
                "not a name",
            )
            .help("write for example `d(leg1.P)`"));
        }
        self.coordinate(true)?;
        if !self.accept(')') {
            return Err(self.unclosed(open));
        }
        Ok(())
    }

    /// Reads the name of a measured coordinate.
    fn coordinate(&mut self, rate: bool) -> Result<(), Fault> {
        let (span, name) = (self.span(), self.word_at(0));
        if self.scope.find(name).is_some() {
            let message = format!("{} is ambiguous: a parameter and a coordinate", quoted(name));
            return Err(Fault::new(span, message, "two meanings").help("rename the parameter"));
        }
        match self.measured(0, rate) {
            Some(Ok((index, dimension))) => self.emit(Op::Measured(index, dimension), span),
            Some(Err((message, help))) => {
                return Err(Fault::new(span, message, "not a coordinate")
                    .maybe_help(help)
                    .code("unknown-name"));
            }
            None => return Err(self.unknown(false)),
        }
        self.at += 1;
        Ok(())
    }

    fn call(&mut self) -> Result<(), Fault> {
        let span = self.span();
        let name = self.word_at(0);
        let Some(function) = Function::find(name) else {
            let what = match reserved(name) {
                Some(what) => format!("{} is {what}, not a function", quoted(name)),
                None if self.scope.find(name).is_some() => {
                    format!("{} is a parameter, not a function", quoted(name))
                }
                None => format!("there is no function {}", quoted(name)),
            };
            let functions = Function::ALL.iter().map(|(name, _)| *name);
            let help = match self.scope.find(name).is_some() || reserved(name).is_some() {
                true => Some(format!("to multiply, write `{name}*(…)`")),
                false => nearest(name, functions.clone())
                    .map(|near| format!("did you mean `{near}`?"))
                    .or_else(|| {
                        Some(format!("functions: {}", functions.collect::<Vec<_>>().join(", ")))
                    }),
            };
            return Err(Fault::new(span, what, "not a function").maybe_help(help));
        };
        self.at += 1;
        let open = self.span();
        self.at += 1;
        let mut count = 0;
        if self.kind() != TokenKind::Symbol(')') {
            loop {
                self.nested(Self::sum)?;
                count += 1;
                if !self.accept(',') {
                    break;
                }
            }
        }
        if !self.accept(')') {
            return Err(self.unclosed(open));
        }
        let (least, most) = function.arity();
        if count < least || count > most {
            let arguments =
                |n: usize| if n == 1 { "1 argument".into() } else { format!("{n} arguments") };
            let expected = match (least, most) {
                (least, most) if least == most => arguments(least),
                (least, _) => format!("at least {}", arguments(least)),
            };
            return Err(Fault::new(
                span.start..self.before(),
                format!("`{name}` takes {expected}"),
                format!("{} given", arguments(count)),
            )
            .help(format!("write `{}`", function.usage())));
        }
        if function == Function::Sign && self.scope.measured("", false).is_none() {
            let message = "`sign` can be used only in formulas of measured coordinates";
            return Err(
                Fault::new(span, message, "the value jumps here").help("write `tanh(x/width)`")
            );
        }
        self.emit(Op::Call(function, count), span.start..self.before());
        Ok(())
    }

    fn name(&mut self) -> Result<(), Fault> {
        let span = self.span();
        let name = self.word_at(0);
        // Parameters take precedence: a parameter with the name of a constant or of the time is
        // reported as an error at its definition.
        if let Some(index) = self.scope.find(name) {
            self.emit(Op::Parameter(index), span);
        } else if let Some((_, value)) = CONSTANTS.iter().find(|(known, _)| *known == name) {
            self.emit(Op::Number(*value, Dimension::NONE), span);
        } else if name == "t" {
            if !self.time {
                return Err(Fault::new(
                    span,
                    "`t` (the time) can be used only in motions and loads",
                    "this value cannot depend on time",
                ));
            }
            self.emit(Op::Time, span);
        } else {
            return Err(self.unknown(false));
        }
        self.at += 1;
        Ok(())
    }

    /// Byte offset of the end of the last token that was read.
    fn before(&self) -> usize {
        self.at.checked_sub(1).and_then(|at| self.tokens.get(at)).map_or(0, |token| token.span.end)
    }
}
