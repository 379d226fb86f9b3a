//! Recorded programs that replace the kernels of one mechanism along a motion.

use super::coordinate::Target;
use core::fmt::Debug;
use core::ops::Range;
use std::sync::Arc;

/// Stage of a [`KernelProgram`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Rates, accelerations and motion of all bodies at coordinates that close the loops.
    Motion,
    /// Forces without friction, and responses to unit friction forces, at the configuration of the
    /// last [`Self::Motion`].
    Forces,
}

/// Straight-line program recorded from the kernels for one mechanism. Its inputs are, in this
/// order: the coordinates of the spanning tree, the targets of the prescribed coordinates (value,
/// rate, acceleration), and the external loads (force, moment).
pub trait KernelProgram: Debug + Send + Sync {
    /// Allocates memory for one state.
    fn memory(&self) -> ProgramMemory;

    /// Runs a stage. Returns `false` if an assumption made at recording does not hold at this
    /// state; the results are then invalid.
    fn run(&self, stage: Stage, memory: &mut ProgramMemory) -> bool;

    /// Returns the range of the results of a stage in [`ProgramMemory::slots`].
    fn results(&self, stage: Stage) -> Range<usize>;
}

/// Memory of a [`KernelProgram`].
#[derive(Clone, Debug, Default)]
pub struct ProgramMemory {
    /// Inputs, followed by results and values that one stage passes to the next.
    pub slots: Vec<f64>,
    /// Intermediate values of a stage.
    pub scratch: Vec<f64>,
}

/// Program with its memory, and the configuration at which it ran last.
#[derive(Clone, Debug)]
pub(crate) struct ProgramAtState {
    program: Arc<dyn KernelProgram>,
    memory: ProgramMemory,
    /// True if the assumptions of the stage [`Stage::Motion`] hold at the inputs in the memory.
    holds: bool,
}

impl ProgramAtState {
    pub(crate) fn new(program: Arc<dyn KernelProgram>) -> Self {
        let memory = program.memory();
        Self { program, memory, holds: false }
    }

    /// Runs the stage [`Stage::Motion`]. Returns `false` if the program is not valid there.
    pub(super) fn go_to(&mut self, coordinates: &[f64], targets: &[Target<f64>]) -> bool {
        let slots = &mut self.memory.slots[..coordinates.len() + 3 * targets.len()];
        let (first, rest) = slots.split_at_mut(coordinates.len());
        first.copy_from_slice(coordinates);
        for (slots, target) in rest.chunks_exact_mut(3).zip(targets) {
            slots.copy_from_slice(&[target.value, target.rate, target.acceleration]);
        }
        self.holds = self.program.run(Stage::Motion, &mut self.memory);
        self.holds
    }

    /// Returns `true` if the results of the stage [`Stage::Motion`] are those for these inputs, and
    /// valid.
    pub(super) fn is_at(&self, coordinates: &[f64], targets: &[Target<f64>]) -> bool {
        let (first, rest) = self.memory.slots.split_at(coordinates.len());
        let is_same = |(slots, target): (&[f64], &Target<f64>)| {
            slots == [target.value, target.rate, target.acceleration]
        };
        self.holds && first == coordinates && rest.chunks_exact(3).zip(targets).all(is_same)
    }

    /// Runs the stage [`Stage::Forces`] for external loads, which are the inputs from the index
    /// `first` on. Returns `false` if the program is not valid.
    pub(crate) fn balance(&mut self, first: usize, loads: impl Iterator<Item = f64>) -> bool {
        self.memory.slots[first..].iter_mut().zip(loads).for_each(|(slot, load)| *slot = load);
        self.holds && self.program.run(Stage::Forces, &mut self.memory)
    }

    /// Returns the results of a stage.
    #[inline]
    pub(crate) fn results(&self, stage: Stage) -> Results<'_> {
        Results(self.memory.slots.get(self.program.results(stage)).unwrap_or(&[]))
    }
}

/// Numbers of a program that are read one after the other. Missing numbers are NaN, which no check
/// accepts.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Results<'a>(&'a [f64]);

impl<'a> Results<'a> {
    /// Creates a reader of `numbers`.
    pub(crate) fn new(numbers: &'a [f64]) -> Self {
        Self(numbers)
    }

    /// Returns the next `count` numbers; none if fewer are left.
    pub(crate) fn take(&mut self, count: usize) -> &'a [f64] {
        let (first, rest) = self.0.split_at_checked(count).unwrap_or_default();
        self.0 = rest;
        first
    }

    /// Reads the next `N` numbers.
    #[inline]
    pub(crate) fn next<const N: usize>(&mut self) -> [f64; N] {
        match self.0.split_first_chunk() {
            Some((first, rest)) => {
                self.0 = rest;
                *first
            }
            None => [f64::NAN; N],
        }
    }

    /// Reads numbers into all of `numbers`.
    #[inline]
    pub(crate) fn fill(&mut self, numbers: &mut [f64]) {
        match self.0.split_at_checked(numbers.len()) {
            Some((first, rest)) => {
                self.0 = rest;
                numbers.copy_from_slice(first);
            }
            None => numbers.fill(f64::NAN),
        }
    }
}
