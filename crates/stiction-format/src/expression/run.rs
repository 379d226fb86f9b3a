//! Stack machine that evaluates compiled expressions and their first two time derivatives.

use super::Fault;
use super::check::not_finite;
use super::function::Function;
use super::jet::Jet;
use super::parse::Op;
use crate::source::Span;

/// A compiled expression whose dimensions have been checked: instructions that compute a number in
/// SI units for any given time.
#[derive(Clone, Debug, Default)]
pub(crate) struct Formula {
    pub(super) steps: Vec<(Op, Span)>,
}

/// Computes the result of one operation; NaN if arguments are missing, or if `op` is a parameter,
/// the time or a measured coordinate.
pub(super) fn apply(op: Op, arguments: &[Jet]) -> Jet {
    let argument = |k: usize| arguments.get(k).copied().unwrap_or(Jet::constant(f64::NAN));
    let (a, b) = (argument(0), argument(1));
    match op {
        Op::Number(value, _) => Jet::constant(value),
        Op::Negate => -a,
        Op::Add => a + b,
        Op::Subtract => a - b,
        Op::Multiply => a * b,
        Op::Divide => a / b,
        // A constant exponent also permits negative bases.
        Op::Power if b.first == 0.0 && b.second == 0.0 => a.powf(b.value),
        Op::Power => a.pow(b),
        Op::Call(function, _) => Function::apply(function, arguments),
        Op::Parameter(_) | Op::Time | Op::Measured(..) => Jet::constant(f64::NAN),
    }
}

type Visitor<'a> = dyn FnMut(Op, &[Jet], &Span, Jet) -> bool + 'a;

impl Formula {
    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    pub(super) fn push(&mut self, op: Op, span: Span) {
        self.steps.push((op, span));
    }

    /// Removes the instructions from index `start` on, all of which must be constants, and returns
    /// their values.
    pub(super) fn cut_constants(&mut self, start: usize) -> Vec<Jet> {
        let start = start.min(self.steps.len());
        self.steps.split_off(start).into_iter().map(|(op, _)| apply(op, &[])).collect()
    }

    /// Value of the instruction at index `at`; `None` if it is not a number.
    pub(super) fn number_at(&self, at: usize) -> Option<f64> {
        match self.steps.get(at) {
            Some((Op::Number(value, _), _)) => Some(*value),
            _ => None,
        }
    }

    /// Value of a constant formula; `None` if the formula is not a single number.
    pub(super) fn constant(&self) -> Option<f64> {
        match self.steps.as_slice() {
            [(Op::Number(value, _), _)] => Some(*value),
            _ => None,
        }
    }

    /// Value of the formula at time `t`, s, with its derivatives; NaN or infinite where undefined.
    pub(crate) fn at(&self, t: f64) -> Jet {
        self.run(t, &mut |_, _, _, _| true)
    }

    /// Value of the formula at time `t`, s, with its derivatives.
    ///
    /// # Errors
    /// Returns the place and reason if the result of an operation is not finite.
    pub(crate) fn checked_at(&self, t: f64) -> Result<Jet, Fault> {
        let mut fault = None;
        let value = self.run(t, &mut |op, arguments, span, value| {
            if !value.is_finite() {
                fault = Some(not_finite(op, arguments, span.clone(), span));
            }
            fault.is_none()
        });
        fault.map_or(Ok(value), Err)
    }

    /// Evaluates the formula at time `t`, s, and calls `see` for every operation with its
    /// arguments.
    pub(super) fn visit(&self, t: f64, see: &mut dyn FnMut(Op, &[Jet])) {
        self.run(t, &mut |op, arguments, _, _| {
            see(op, arguments);
            true
        });
    }

    /// Evaluates the formula at time `t`, s. Calls `visit` for every operation with its arguments,
    /// place and result; stops early if `visit` returns false.
    fn run(&self, t: f64, visit: &mut Visitor<'_>) -> Jet {
        let mut stack: Vec<Jet> = Vec::with_capacity(8);
        for (op, span) in &self.steps {
            let count = op.arguments();
            let from = stack.len().saturating_sub(count);
            let arguments = stack.get(from..).unwrap_or_default();
            let value = match op {
                Op::Time => Jet::time(t),
                op => apply(*op, arguments),
            };
            if !visit(*op, arguments, span, value) {
                break;
            }
            stack.truncate(from);
            stack.push(value);
        }
        stack.pop().unwrap_or(Jet::constant(f64::NAN))
    }

    /// A formula that is a single number.
    #[cfg(test)]
    pub(crate) fn of_number(value: f64) -> Self {
        Self { steps: vec![(Op::Number(value, super::Dimension::NONE), 0..0)] }
    }
}
