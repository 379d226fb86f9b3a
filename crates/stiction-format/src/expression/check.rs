//! Dimension check of expressions and evaluation of their constant parts.

use super::function::{Function, Rule};
use super::parse::{Op, Program, parse};
use super::run::{Formula, apply};
use super::{Dimension, Fault, Scope};
use crate::expression::Measure;
use crate::source::Span;

/// A number in SI units, and its dimension.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Quantity {
    pub(crate) value: f64,
    pub(crate) dimension: Dimension,
}

/// An expression that may contain the time, after its dimension has been checked.
#[derive(Clone, Debug)]
pub(crate) enum TimeFormula {
    Constant(f64),
    Changing(Formula),
}

/// Evaluates an expression that does not contain the time; returns its value and dimension.
pub(crate) fn constant(program: &Program, scope: &dyn Scope) -> Result<Quantity, Fault> {
    let (dimension, formula) = analyse(program, scope, Dimension::NONE)?;
    let value = formula.constant().unwrap_or(f64::NAN);
    Ok(Quantity { value, dimension })
}

/// Compiles an expression that may contain the time `t`, in seconds, and checks that its result is
/// a quantity of the kind `measure`.
///
/// Both `5 mm*sin(2*pi*t)`, with a dimensionless `t`, and `10 mm/s*t`, with `t` as a time, are
/// common. Both interpretations of `t` yield the same numbers, so an expression is valid if its
/// dimensions are consistent in either interpretation.
pub(crate) fn in_time(
    text: &str,
    scope: &dyn Scope,
    measure: Measure,
) -> Result<TimeFormula, Fault> {
    let program = parse(text, scope, true)?;
    let read = |time: Dimension| {
        let (dimension, formula) = analyse(&program, scope, time)?;
        match measure.complaint(dimension) {
            None => Ok(formula),
            Some(fault) => Err(fault(0..text.len())),
        }
    };
    let formula = match (read(Dimension::NONE), read(Dimension::TIME)) {
        (Ok(formula), _) | (_, Ok(formula)) => formula,
        (Err(plain), Err(timed)) => {
            // Report the error of the interpretation that the author probably meant.
            let is_timed = |(op, _): &(Op, Span)| matches!(op, Op::Number(_, d) if d.has_time());
            return Err(if program.steps.iter().any(is_timed) { timed } else { plain });
        }
    };
    Ok(match formula.constant() {
        Some(value) => TimeFormula::Constant(value),
        None => TimeFormula::Changing(formula),
    })
}

/// Compiles two expressions that are compared with each other. Checks that they have the same
/// dimension or that one of them is a plain number. The flag beside a fault is true if the fault is
/// in the second expression.
pub(crate) fn of_one_kind(
    [left, right]: [&str; 2],
    scope: &dyn Scope,
) -> Result<[Formula; 2], (Fault, bool)> {
    let programs = [
        parse(left, scope, true).map_err(|fault| (fault, false))?,
        parse(right, scope, true).map_err(|fault| (fault, true))?,
    ];
    let read = |time: Dimension| {
        let (a, first) = analyse(&programs[0], scope, time).map_err(|fault| (fault, false))?;
        let (b, second) = analyse(&programs[1], scope, time).map_err(|fault| (fault, true))?;
        let is_alike = a.same(b) && a.is_ratio() == b.is_ratio();
        if is_alike || a.is_bare() || b.is_bare() {
            return Ok([first, second]);
        }
        let (found, expected) = (b.describe(), a.describe());
        let fault = Fault::new(
            0..right.len(),
            format!("{expected} is compared with {found}"),
            format!("this is {found}"),
        );
        Err((fault.code("dimension"), true))
    };
    read(Dimension::TIME).or_else(|fault| read(Dimension::NONE).map_err(|_| fault))
}

/// Entry on the stack of the dimension check: the result of a subexpression.
struct Part {
    dimension: Dimension,
    span: Span,
    /// Index, in the formula, of the first instruction that computes the result.
    start: usize,
    /// True if the result is a number, pushed by a single instruction.
    constant: bool,
}

/// Returns the dimension of a program's result, and the instructions of the program with constant
/// subexpressions evaluated. `time` is the dimension of `t`.
fn analyse(
    program: &Program,
    scope: &dyn Scope,
    time: Dimension,
) -> Result<(Dimension, Formula), Fault> {
    let mut stack: Vec<Part> = Vec::new();
    let mut formula = Formula::default();
    for (op, span) in &program.steps {
        let count = op.arguments();
        let parts = stack.split_off(stack.len().saturating_sub(count));
        let (op, dimension) = match *op {
            Op::Number(value, dimension) => (Op::Number(value, Dimension::NONE), dimension),
            Op::Parameter(index) => {
                let Some(quantity) = scope.value(index) else {
                    return Err(Fault { echo: true, ..Fault::new(span.clone(), "", "") });
                };
                (Op::Number(quantity.value, Dimension::NONE), quantity.dimension)
            }
            Op::Time => (Op::Time, time),
            Op::Measured(index, dimension) => (Op::Measured(index, dimension), dimension),
            op => (op, dimension_of(op, span, &parts, &formula)?),
        };
        let start = parts.first().map_or(formula.len(), |part| part.start);
        let end = parts.last().map_or(span.end, |part| part.span.end);
        let whole = parts.first().map_or(span.start, |part| part.span.start.min(span.start))
            ..end.max(span.end);
        let varies = matches!(op, Op::Time | Op::Measured(..));
        let mut constant = !varies && parts.iter().all(|part| part.constant);
        if constant && count > 0 {
            let arguments = formula.cut_constants(start);
            let value = apply(op, &arguments).value;
            if !value.is_finite() {
                return Err(not_finite(op, &arguments, span.clone(), &whole));
            }
            formula.push(Op::Number(value, Dimension::NONE), whole.clone());
        } else {
            constant &= matches!(op, Op::Number(..));
            formula.push(op, span.clone());
        }
        stack.push(Part { dimension, span: whole, start, constant });
    }
    // A parsed program leaves exactly one entry on the stack.
    let dimension = stack.pop().map_or(Dimension::NONE, |part| part.dimension);
    Ok((dimension, formula))
}

fn dimension_of(
    op: Op,
    span: &Span,
    parts: &[Part],
    formula: &Formula,
) -> Result<Dimension, Fault> {
    let dimension = |k: usize| parts.get(k).map_or(Dimension::NONE, |part| part.dimension);
    let (a, b) = (dimension(0), dimension(1));
    let too_large = || Fault::new(span.clone(), "the powers of the units are too large", "");
    match op {
        Op::Negate => Ok(a),
        Op::Add | Op::Subtract if a.same(b) => Ok(a.sum(b)),
        Op::Add | Op::Subtract => {
            let verb = if op == Op::Add { "added to" } else { "subtracted from" };
            let (a_words, b_words) = (a.describe(), b.describe());
            let fault = Fault::new(
                span.clone(),
                format!("{b_words} cannot be {verb} {a_words}"),
                format!("left: {a_words}, right: {b_words}"),
            )
            .code("dimension");
            let plain = a.is_none() || b.is_none();
            Err(fault.maybe_help(plain.then(|| "give the plain number a unit".to_owned())))
        }
        Op::Multiply => a.times(b).map(Dimension::of_arithmetic).ok_or_else(too_large),
        Op::Divide => a.over(b).map(Dimension::of_arithmetic).ok_or_else(too_large),
        Op::Power => power_dimension(parts, formula),
        Op::Call(function, _) => call_dimension(function, parts),
        Op::Number(..) | Op::Parameter(_) | Op::Time | Op::Measured(..) => Ok(Dimension::NONE),
    }
}

fn power_dimension(parts: &[Part], formula: &Formula) -> Result<Dimension, Fault> {
    let [base, exponent] = parts else { return Ok(Dimension::NONE) };
    if !exponent.dimension.is_none() {
        return Err(Fault::new(
            exponent.span.clone(),
            format!("an exponent is a plain number, not {}", exponent.dimension.describe()),
            "expected a plain number",
        )
        .code("dimension"));
    }
    if base.dimension == Dimension::NONE {
        return Ok(Dimension::NONE);
    }
    let value = exponent.constant.then(|| formula.number_at(exponent.start)).flatten();
    let Some(value) = value else {
        if base.dimension.is_none() {
            return Ok(Dimension::NONE);
        }
        return Err(Fault::new(
            exponent.span.clone(),
            format!("{} can only be raised to a constant power", base.dimension.describe()),
            "this changes in time",
        ));
    };
    base.dimension.power(value).ok_or_else(|| {
        Fault::new(
            exponent.span.clone(),
            format!("{} cannot be raised to this power", base.dimension.describe()),
            "no unit exists for the result",
        )
    })
}

fn call_dimension(function: Function, parts: &[Part]) -> Result<Dimension, Fault> {
    let first = parts.first().map_or(Dimension::NONE, |part| part.dimension);
    let name = function.name();
    match function.rule() {
        Rule::Plain => {
            let Some(part) = parts.iter().find(|part| !part.dimension.is_none()) else {
                return Ok(Dimension::NONE);
            };
            let takes = match function {
                Function::Sin | Function::Cos | Function::Tan => "an angle",
                _ => "a plain number",
            };
            Err(Fault::new(
                part.span.clone(),
                format!("`{name}` takes {takes}, not {}", part.dimension.describe()),
                format!("expected {takes}"),
            )
            .code("dimension"))
        }
        Rule::Root => first.power(0.5).ok_or_else(|| {
            let span = parts.first().map_or(0..0, |part| part.span.clone());
            Fault::new(
                span,
                format!("no unit exists for the square root of {}", first.describe()),
                "",
            )
        }),
        rule => match parts.iter().find(|part| !part.dimension.same(first)) {
            None if rule == Rule::Keep => Ok(first),
            None => Ok(Dimension::NONE),
            Some(other) => Err(Fault::new(
                other.span.clone(),
                format!(
                    "`{name}` compares {} with {}",
                    first.describe(),
                    other.dimension.describe()
                ),
                format!("expected {}, like the first argument", first.describe()),
            )
            .code("dimension")),
        },
    }
}

/// Fault for the operation `op` whose result is not finite. `span` is the place of the operator,
/// `whole` the place of the operation with its arguments.
pub(super) fn not_finite(op: Op, arguments: &[super::jet::Jet], span: Span, whole: &Span) -> Fault {
    let reason = match op {
        Op::Divide if arguments.get(1).is_some_and(|x| x.value == 0.0) => Some("division by zero"),
        Op::Power if arguments.first().is_some_and(|x| x.value < 0.0) => {
            Some("a fractional power of a negative number")
        }
        Op::Power if arguments.first().is_some_and(|x| x.value == 0.0) => {
            Some("a negative power of zero")
        }
        Op::Call(function, _) => function.complaint(arguments),
        _ => None,
    };
    match reason {
        Some(reason) => Fault::new(span, "this is not a finite number", reason),
        None => Fault::new(whole.clone(), "this is not a finite number", "too large to compute"),
    }
    .code("not-finite")
}
