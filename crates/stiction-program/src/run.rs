//! Executable parts of a program, for states in parallel lanes.

use crate::code::{Call, Code, Part};
use crate::encode::{Set, Width};
use crate::machine::{Machine, instructions};

/// Executable part of a program: a block of straight-line code, or function calls.
#[derive(Debug)]
enum Piece {
    Machine(Machine),
    /// Straight-line code for the interpreter, where machine code is impossible or not requested.
    Interpreted(Code),
    Calls(Vec<Call>),
}

/// Executable parts of a program, prepared for a fixed number of lanes.
#[derive(Debug)]
pub(crate) struct Runner {
    lanes: usize,
    pieces: Vec<Piece>,
    scratch: usize,
}

/// Largest number of lanes on any processor. It is also the number of lanes on processors for which
/// machine code is not supported.
pub(crate) const MOST_LANES: usize = 8;

/// Evaluates `$call` with the constant `$l` equal to `$lanes`, the number of lanes of a program.
macro_rules! by_lanes {
    ($lanes:expr, $l:ident => $call:expr) => {
        match $lanes {
            1 => {
                const $l: usize = 1;
                $call
            }
            2 => {
                const $l: usize = 2;
                $call
            }
            4 => {
                const $l: usize = 4;
                $call
            }
            _ => {
                const $l: usize = $crate::run::MOST_LANES;
                $call
            }
        }
    };
}
pub(crate) use by_lanes;

/// Returns the number of lanes of this processor, or [`MOST_LANES`] if machine code for it is not
/// supported.
pub(crate) fn natural_lanes() -> usize {
    instructions().map_or(MOST_LANES, |set| Set::widest(set).lanes())
}

impl Runner {
    /// Prepares parts for one, two, four or eight lanes, with `slots` memory slots for each lane.
    /// If `machine` is true, straight-line code becomes machine code where possible; otherwise it
    /// is interpreted.
    pub(crate) fn new(parts: &[Part], lanes: usize, slots: usize, machine: bool) -> Self {
        let width = match lanes {
            1 => Width::One,
            2 => Width::Two,
            4 => Width::Four,
            _ => Width::Eight,
        };
        let mut scratch = 0;
        let pieces = parts
            .iter()
            .map(|part| match part {
                Part::Calls(calls) => Piece::Calls(calls.clone()),
                Part::Code(code) => {
                    let code = &code.scheduled();
                    let made = machine.then(|| Machine::new(code, width, slots)).flatten();
                    match made {
                        Some(made) => {
                            scratch = scratch.max(made.scratch());
                            Piece::Machine(made)
                        }
                        None => {
                            scratch = scratch.max(code.steps.len() * lanes);
                            Piece::Interpreted(code.clone())
                        }
                    }
                }
            })
            .collect();
        Self { lanes, pieces, scratch }
    }

    /// Number of scratch values that a run needs.
    pub(crate) fn scratch(&self) -> usize {
        self.scratch
    }

    /// Returns `true` if no part is interpreted.
    pub(crate) fn is_machine_code(&self) -> bool {
        !self.pieces.iter().any(|piece| matches!(piece, Piece::Interpreted(_)))
    }

    /// Executes all parts in order.
    #[inline]
    pub(crate) fn run(&self, slots: &mut [f64], scratch: &mut [f64]) {
        self.run_with(slots, &[], scratch);
    }

    /// Executes all parts in order; `common` contains the numbers that all lanes share.
    #[inline]
    pub(crate) fn run_with(&self, slots: &mut [f64], common: &[f64], scratch: &mut [f64]) {
        for piece in &self.pieces {
            match piece {
                Piece::Machine(machine) => machine.run(slots, common, scratch),
                Piece::Interpreted(code) => {
                    by_lanes!(self.lanes, L => code.interpret::<L>(slots, common, scratch));
                }
                Piece::Calls(calls) => {
                    for call in calls {
                        let [a, b] = call.arguments.map(|slot| slot as usize * self.lanes);
                        let to = call.result as usize * self.lanes;
                        for lane in 0..self.lanes {
                            slots[to + lane] = call.function.of(slots[a + lane], slots[b + lane]);
                        }
                    }
                }
            }
        }
    }
}
