//! Evaluation of formulas of measured coordinates, which may have kinks and jumps.
//!
//! `abs`, `min`, `max` and `sign` of measured quantities are not smooth. A simulation locates the
//! instants at which they change their branch. Each of these functions has one or more switching
//! functions, whose sign (side) selects the branch; the branch stays the same until the next
//! located instant.

use super::function::Function;
use super::jet::Jet;
use super::parse::Op;
use super::run::{Formula, apply};

impl Formula {
    /// Number of switching functions of the formula.
    pub(crate) fn switches(&self) -> usize {
        let each = self.steps.iter().map(|(op, _)| match op {
            Op::Call(Function::Abs | Function::Sign, _) => 1,
            Op::Call(Function::Min | Function::Max, count) => count - 1,
            _ => 0,
        });
        each.sum()
    }

    /// Tests if the formula contains an operation whose result may have kinks.
    pub(crate) fn may_have_kinks(&self) -> bool {
        self.steps.iter().any(|(op, _)| match op {
            Op::Call(function, _) => matches!(
                function,
                Function::Abs
                    | Function::Min
                    | Function::Max
                    | Function::Sqrt
                    | Function::Asin
                    | Function::Acos
            ),
            op => *op == Op::Power,
        })
    }

    /// Tests if the formula contains the time.
    pub(crate) fn has_time(&self) -> bool {
        self.steps.iter().any(|(op, _)| *op == Op::Time)
    }

    /// Evaluates the formula at time `t`, s, with the values `measured` of the coordinates and
    /// rates. The closure `side` receives the value of each switching function and returns true if
    /// the function counts as positive.
    pub(crate) fn at_state(
        &self,
        t: f64,
        measured: &[f64],
        mut side: impl FnMut(f64) -> bool,
    ) -> f64 {
        let mut stack: Vec<f64> = Vec::with_capacity(8);
        for (op, _) in &self.steps {
            let from = stack.len().saturating_sub(op.arguments());
            let arguments = stack.get(from..).unwrap_or_default();
            let first = arguments.first().copied().unwrap_or(f64::NAN);
            let value = match *op {
                Op::Time => t,
                Op::Measured(index, _) => measured.get(index).copied().unwrap_or(f64::NAN),
                Op::Call(Function::Abs, _) => {
                    if side(first) {
                        first
                    } else {
                        -first
                    }
                }
                Op::Call(Function::Sign, _) => {
                    if side(first) {
                        1.0
                    } else {
                        -1.0
                    }
                }
                Op::Call(function @ (Function::Min | Function::Max), _) => {
                    let mut chosen = first;
                    for &next in arguments.iter().skip(1) {
                        let is_first = side(chosen - next) == (function == Function::Max);
                        chosen = if is_first { chosen } else { next };
                    }
                    chosen
                }
                op => {
                    let jets: Vec<Jet> = arguments.iter().map(|x| Jet::constant(*x)).collect();
                    apply(op, &jets).value
                }
            };
            stack.truncate(from);
            stack.push(value);
        }
        stack.pop().unwrap_or(f64::NAN)
    }
}
