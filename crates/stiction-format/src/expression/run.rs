//! The stack machine.

use super::Fault;
use super::check::not_finite;
use super::function::Function;
use super::jet::Jet;
use super::parse::Op;
use crate::source::Span;

/// Instructions that give a number at every time. Made by the checker: they always fit together.
#[derive(Clone, Debug, Default)]
pub(crate) struct Formula {
    steps: Vec<(Op, Span)>,
}

/// The result of an operation; of too few arguments it is NaN.
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
        // A constant exponent also suits negative bases.
        Op::Power if b.first == 0.0 && b.second == 0.0 => a.powf(b.value),
        Op::Power => a.pow(b),
        Op::Call(function, _) => Function::apply(function, arguments),
        Op::Parameter(_) | Op::Time => Jet::constant(f64::NAN),
    }
}

type Watch<'a> = dyn FnMut(Op, &[Jet], &Span, Jet) -> bool + 'a;

impl Formula {
    pub(super) fn len(&self) -> usize {
        self.steps.len()
    }

    pub(super) fn push(&mut self, op: Op, span: Span) {
        self.steps.push((op, span));
    }

    /// Removes the numbers from `start` on.
    pub(super) fn cut_constants(&mut self, start: usize) -> Vec<Jet> {
        let start = start.min(self.steps.len());
        self.steps.split_off(start).into_iter().map(|(op, _)| apply(op, &[])).collect()
    }

    /// The number that stands at `at`.
    pub(super) fn number_at(&self, at: usize) -> Option<f64> {
        match self.steps.get(at) {
            Some((Op::Number(value, _), _)) => Some(*value),
            _ => None,
        }
    }

    /// The value, if it does not change in time.
    pub(super) fn constant(&self) -> Option<f64> {
        match self.steps.as_slice() {
            [(Op::Number(value, _), _)] => Some(*value),
            _ => None,
        }
    }

    /// The value at time `t` with its derivatives; NaN or infinite where there is none.
    pub(crate) fn at(&self, t: f64) -> Jet {
        self.run(t, &mut |_, _, _, _| true)
    }

    /// Where and why the value at time `t` is not finite, if it is not.
    pub(crate) fn fault_at(&self, t: f64) -> Option<Fault> {
        let mut fault = None;
        self.run(t, &mut |op, arguments, span, value| {
            if !value.is_finite() {
                fault = Some(not_finite(op, arguments, span.clone(), span));
            }
            fault.is_none()
        });
        fault
    }

    /// Shows every operation with its arguments at time `t`.
    pub(super) fn watch(&self, t: f64, see: &mut dyn FnMut(Op, &[Jet])) {
        self.run(t, &mut |op, arguments, _, _| {
            see(op, arguments);
            true
        });
    }

    /// Runs until `watch`, shown every operation with its arguments and result, says no.
    fn run(&self, t: f64, watch: &mut Watch<'_>) -> Jet {
        let mut stack: Vec<Jet> = Vec::with_capacity(8);
        for (op, span) in &self.steps {
            let count = match op {
                Op::Number(..) | Op::Parameter(_) | Op::Time => 0,
                Op::Negate => 1,
                Op::Call(_, count) => *count,
                _ => 2,
            };
            let from = stack.len().saturating_sub(count);
            let arguments = stack.get(from..).unwrap_or_default();
            let value = match op {
                Op::Time => Jet::time(t),
                op => apply(*op, arguments),
            };
            if !watch(*op, arguments, span, value) {
                break;
            }
            stack.truncate(from);
            stack.push(value);
        }
        stack.pop().unwrap_or(Jet::constant(f64::NAN))
    }

    /// A formula that is just a number.
    #[cfg(test)]
    pub(crate) fn of_number(value: f64) -> Self {
        Self { steps: vec![(Op::Number(value, super::Dimension::NONE), 0..0)] }
    }
}
