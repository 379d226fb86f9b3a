//! Conversion of routines to lists of statements, from which code in any programming language is
//! generated.
//!
//! The workspace contains the inputs, followed by the values that one routine computes and another
//! reads. All other values are local variables. Each routine copies its results to a separate
//! array.

use crate::code::{Call, Code, Part, Source, Step};
use crate::feedforward::Routine;
use crate::graph::Function;
use std::collections::HashMap;

/// Operand of a statement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Operand {
    /// Local variable, by its number.
    Local(usize),
    /// Value in the workspace, by its index.
    Work(usize),
    /// Constant.
    Number(f64),
}

/// Statement of a routine. Each local variable is assigned once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Statement {
    /// A local variable receives the result of an operation on up to three operands.
    Step { to: usize, step: Step, operands: [Operand; 3] },
    /// A local variable receives the value of a function of up to two arguments.
    Call { to: usize, function: Function, arguments: [Operand; 2] },
    /// Two local variables receive the sine and the cosine of an angle. One of them may be unused.
    SineCosine { sine: usize, cosine: usize, angle: Operand, uses: [bool; 2] },
    /// The entry of the workspace with index `to` receives a value.
    Keep { to: usize, from: Operand },
    /// The entry of the result array with index `to` receives a value.
    Result { to: usize, from: Operand },
}

/// Statements of several routines, which share a workspace.
#[derive(Clone, Debug)]
pub(crate) struct Listing {
    pub(crate) routines: Vec<Vec<Statement>>,
    /// Number of values in the workspace.
    pub(crate) work: usize,
    /// Largest number of results of a routine.
    pub(crate) results: usize,
}

impl Routine {
    /// Returns the slots that the routine reads, and the slots that it writes.
    fn slots(&self) -> [Vec<u32>; 2] {
        let (mut read, mut written) = (Vec::new(), Vec::new());
        let source = |source: Source, read: &mut Vec<u32>| {
            if let Source::Slot(slot) = source {
                read.push(slot);
            }
        };
        for part in &self.parts {
            match part {
                Part::Code(code) => {
                    let operands = code.steps.iter().flat_map(|step| step.operands());
                    operands.for_each(|operand| source(operand, &mut read));
                    for (from, slot) in &code.stores {
                        source(*from, &mut read);
                        written.push(*slot);
                    }
                }
                Part::Calls(calls) => {
                    for call in calls {
                        read.extend(call.arguments);
                        written.push(call.result);
                    }
                }
            }
        }
        read.extend(&self.results);
        [read, written]
    }
}

impl Listing {
    /// Lists the statements of `routines`, which run one after the other. `inputs` are the slots of
    /// the inputs, in the order of the workspace.
    pub(crate) fn new(routines: &[Routine], inputs: &[u32]) -> Self {
        let mut places: HashMap<u32, usize> =
            inputs.iter().enumerate().map(|(place, slot)| (*slot, place)).collect();
        let mut work = inputs.len();
        let slots: Vec<_> = routines.iter().map(Routine::slots).collect();
        for (k, [_, written]) in slots.iter().enumerate() {
            for slot in written {
                let is_read = slots
                    .iter()
                    .enumerate()
                    .any(|(other, [read, _])| other != k && read.contains(slot));
                if is_read && !places.contains_key(slot) {
                    places.insert(*slot, work);
                    work += 1;
                }
            }
        }
        let results = routines.iter().map(|routine| routine.results.len()).max().unwrap_or(0);
        let list = |routine| Writer::list(routine, &places);
        Self { routines: routines.iter().map(list).collect(), work, results }
    }
}

impl Listing {
    /// Returns all numbers that occur in the statements as constants.
    pub(crate) fn numbers(self) -> Vec<f64> {
        let operands = |statement: Statement| match statement {
            Statement::Step { operands, .. } => operands.to_vec(),
            Statement::Call { arguments, .. } => arguments.to_vec(),
            Statement::SineCosine { angle, .. } => vec![angle],
            Statement::Keep { from, .. } | Statement::Result { from, .. } => vec![from],
        };
        let number = |operand| match operand {
            Operand::Number(x) => Some(x),
            Operand::Local(_) | Operand::Work(_) => None,
        };
        self.routines.into_iter().flatten().flat_map(operands).filter_map(number).collect()
    }
}

/// Writer of the statements of one routine.
struct Writer<'a> {
    places: &'a HashMap<u32, usize>,
    /// For each slot, the operand that contains its value at the current point of the routine.
    known: HashMap<u32, Operand>,
    statements: Vec<Statement>,
    locals: usize,
}

impl<'a> Writer<'a> {
    fn list(routine: &Routine, places: &'a HashMap<u32, usize>) -> Vec<Statement> {
        let mut own = Self { places, known: HashMap::new(), statements: Vec::new(), locals: 0 };
        for part in &routine.parts {
            match part {
                Part::Code(code) => own.code(&code.scheduled()),
                Part::Calls(calls) => own.calls(calls),
            }
        }
        for (to, slot) in routine.results.iter().enumerate() {
            let from = own.slot(*slot);
            own.statements.push(Statement::Result { to, from });
        }
        own.statements
    }

    fn local(&mut self) -> usize {
        self.locals += 1;
        self.locals - 1
    }

    fn slot(&self, slot: u32) -> Operand {
        let in_work = || self.places.get(&slot).map(|place| Operand::Work(*place));
        // A slot that nothing writes contains zero, as in the memory of compiled programs.
        self.known.get(&slot).copied().or_else(in_work).unwrap_or(Operand::Number(0.0))
    }

    fn keep(&mut self, slot: u32, from: Operand) {
        self.known.insert(slot, from);
        if let Some(to) = self.places.get(&slot) {
            self.statements.push(Statement::Keep { to: *to, from });
        }
    }

    fn code(&mut self, code: &Code) {
        let mut steps: Vec<Operand> = Vec::with_capacity(code.steps.len());
        for step in &code.steps {
            let mut operands = [Operand::Number(0.0); 3];
            for (operand, source) in operands.iter_mut().zip(step.operands()) {
                *operand = self.source(source, code, &steps);
            }
            let to = self.local();
            self.statements.push(Statement::Step { to, step: *step, operands });
            steps.push(Operand::Local(to));
        }
        for (source, slot) in &code.stores {
            let from = self.source(*source, code, &steps);
            self.keep(*slot, from);
        }
    }

    fn source(&self, source: Source, code: &Code, steps: &[Operand]) -> Operand {
        match source {
            Source::Slot(slot) | Source::Common(slot) => self.slot(slot),
            Source::Constant(place) => Operand::Number(code.constants[place as usize]),
            Source::Step(step) => steps[step as usize],
        }
    }

    fn calls(&mut self, calls: &[Call]) {
        let mut open: Vec<Call> = calls.to_vec();
        while let Some(call) = open.first().copied() {
            open.remove(0);
            let arguments = call.arguments.map(|slot| self.slot(slot));
            let partner = match call.function {
                Function::Sin => Some(Function::Cos),
                Function::Cos => Some(Function::Sin),
                _ => None,
            };
            let Some(partner) = partner else {
                let to = self.local();
                self.statements.push(Statement::Call { to, function: call.function, arguments });
                self.keep(call.result, Operand::Local(to));
                continue;
            };
            let is_other = |other: &Call| {
                other.function == partner && self.slot(other.arguments[0]) == arguments[0]
            };
            let other = open.iter().position(is_other).map(|at| open.remove(at));
            let (sine, cosine) = (self.local(), self.local());
            let is_sine = call.function == Function::Sin;
            let uses = [is_sine || other.is_some(), !is_sine || other.is_some()];
            let angle = arguments[0];
            self.statements.push(Statement::SineCosine { sine, cosine, angle, uses });
            let (own, paired) = if is_sine { (sine, cosine) } else { (cosine, sine) };
            self.keep(call.result, Operand::Local(own));
            if let Some(other) = other {
                self.keep(other.result, Operand::Local(paired));
            }
        }
    }
}
