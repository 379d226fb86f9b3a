//! Stages of a program, each compiled for one state and for several states in parallel lanes.

use crate::code::Part;
use crate::memory::Memory;
use crate::run::{Runner, natural_lanes};

/// `N` stages of a program that share memory slots, each compiled for one lane and for all lanes of
/// the processor.
#[derive(Debug)]
pub(crate) struct Compiled<const N: usize> {
    slots: usize,
    operations: [usize; N],
    one: [Runner; N],
    many: [Runner; N],
    lanes: usize,
}

impl<const N: usize> Compiled<N> {
    /// Compiles the stages, which share `slots` memory slots for each lane. If `machine` is false,
    /// the stages are interpreted instead.
    pub(crate) fn new(stages: &[Vec<Part>; N], slots: usize, machine: bool) -> Self {
        let lanes = natural_lanes();
        let runners =
            |lanes| stages.each_ref().map(|parts| Runner::new(parts, lanes, slots, machine));
        let operations = stages.each_ref().map(|parts| parts.iter().map(Part::operations).sum());
        Self { slots, operations, one: runners(1), many: runners(lanes), lanes }
    }

    /// Number of states that the vector code processes in parallel.
    pub(crate) fn lanes(&self) -> usize {
        self.lanes
    }

    /// Number of arithmetic operations of each stage.
    pub(crate) fn operations(&self) -> [usize; N] {
        self.operations
    }

    /// Returns `true` if all stages are native machine code.
    pub(crate) fn is_machine_code(&self) -> bool {
        self.one.iter().chain(&self.many).all(Runner::is_machine_code)
    }

    /// Returns the stages compiled for one state if `lanes` is 1, otherwise those compiled for
    /// [`Self::lanes`] states.
    pub(crate) fn runners(&self, lanes: usize) -> &[Runner; N] {
        if lanes == 1 { &self.one } else { &self.many }
    }

    /// Allocates memory for one state if `lanes` is 1, otherwise for [`Self::lanes`] states.
    pub(crate) fn memory(&self, lanes: usize) -> Memory {
        let scratch = self.runners(lanes).iter().map(Runner::scratch).max().unwrap_or(0);
        Memory::new(if lanes == 1 { 1 } else { self.lanes }, self.slots, scratch)
    }
}
