//! Stages of a program, each compiled for one state and for several states in parallel lanes.

use crate::code::Part;
use crate::memory::Memory;
use crate::run::{Runner, natural_lanes};
use std::sync::OnceLock;

/// `N` stages of a program that share memory slots, each compiled for one lane and, when needed
/// first, for all lanes of the processor.
#[derive(Debug)]
pub(crate) struct Compiled<const N: usize> {
    stages: [Vec<Part>; N],
    slots: usize,
    machine: bool,
    one: [Runner; N],
    many: OnceLock<[Runner; N]>,
    lanes: usize,
}

impl<const N: usize> Compiled<N> {
    /// Compiles the stages, which share `slots` memory slots for each lane. If `machine` is false,
    /// the stages are interpreted instead.
    pub(crate) fn new(stages: [Vec<Part>; N], slots: usize, machine: bool) -> Self {
        let one = stages.each_ref().map(|parts| Runner::new(parts, 1, slots, machine));
        Self { stages, slots, machine, one, many: OnceLock::new(), lanes: natural_lanes() }
    }

    /// Number of states that the vector code processes in parallel.
    pub(crate) fn lanes(&self) -> usize {
        self.lanes
    }

    /// Number of arithmetic operations of each stage.
    pub(crate) fn operations(&self) -> [usize; N] {
        self.stages.each_ref().map(|parts| parts.iter().map(Part::operations).sum())
    }

    /// Returns `true` if all stages are native machine code.
    pub(crate) fn is_machine_code(&self) -> bool {
        self.one.iter().all(Runner::is_machine_code)
    }

    /// Returns the stages compiled for one state if `lanes` is 1, otherwise those compiled for
    /// [`Self::lanes`] states.
    #[inline]
    pub(crate) fn runners(&self, lanes: usize) -> &[Runner; N] {
        if lanes == 1 {
            return &self.one;
        }
        let Self { stages, slots, machine, lanes, .. } = self;
        self.many.get_or_init(|| {
            stages.each_ref().map(|parts| Runner::new(parts, *lanes, *slots, *machine))
        })
    }

    /// Allocates memory for one state if `lanes` is 1, otherwise for [`Self::lanes`] states.
    pub(crate) fn memory(&self, lanes: usize) -> Memory {
        let scratch = self.runners(lanes).iter().map(Runner::scratch).max().unwrap_or(0);
        Memory::new(if lanes == 1 { 1 } else { self.lanes }, self.slots, scratch)
    }
}
