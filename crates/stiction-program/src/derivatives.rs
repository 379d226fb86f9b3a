//! Exact derivatives of driving forces, as a program beside that of inverse dynamics.

use crate::code::{Part, Slots, compile};
use crate::derivative_recipe::RecordedSlopes;
use crate::inverse::InverseProgram;
use crate::machine::fuses;
use crate::memory::Memory;
use crate::quantity::Quantity;
use crate::recipe::{Counts, Recipe};
use crate::run::{Runner, natural_lanes};
use crate::samples::{Sample, samples};
use crate::stages::early;
use crate::tree::put_tree;
use stiction::dynamics::{AppliedLoad, InverseDynamics};
use stiction::kinematics::{State, Target};

/// Inverse dynamics of one mechanism and the derivatives of its driving forces, exact to round-off, by chosen
/// quantities of motion and mechanism. Several directions at once.
///
/// A direction is a slope for each of the quantities; a unit slope of one alone gives the partial derivative.
/// Friction is that of sliding contacts, coupled to the loads, and its change with them is in the derivatives.
#[derive(Debug)]
pub struct DerivativeProgram {
    inverse: InverseProgram,
    /// The joints whose reactions the first is given.
    rubbing: Vec<usize>,
    quantities: Vec<Quantity>,
    /// What does not depend on directions, one state at a time.
    first: Runner,
    first_slots: usize,
    /// All directions side by side. It reads slots of the first.
    second: Runner,
    second_slots: usize,
    slopes: Vec<u32>,
    guard: u32,
    operations: [usize; 2],
    lanes: usize,
}

/// What runs of a [`DerivativeProgram`] read and write.
#[derive(Clone, Debug)]
pub struct DerivativeMemory {
    inverse: Memory,
    first: Memory,
    second: Memory,
}

impl DerivativeProgram {
    /// Records and compiles inverse dynamics and derivatives by these quantities; `solver`, `course` and
    /// `loads` as for [`InverseProgram::record`]. None where that has none, if there is no quantity, and if one does not exist.
    pub fn record(
        solver: &InverseDynamics,
        course: &[Vec<Target<f64>>],
        loads: &[AppliedLoad<f64>],
        quantities: &[Quantity],
    ) -> Option<Self> {
        Self::record_with(solver, course, loads, quantities, true)
    }

    /// The same, interpreted if `machine` is false: the slow way, for comparison.
    #[doc(hidden)]
    pub fn record_with(
        solver: &InverseDynamics,
        course: &[Vec<Target<f64>>],
        loads: &[AppliedLoad<f64>],
        quantities: &[Quantity],
        machine: bool,
    ) -> Option<Self> {
        if quantities.is_empty() {
            return None;
        }
        let inverse = InverseProgram::record_with(solver, course, loads, machine)?;
        let kernel = solver.kernel()?;
        let recipe = Recipe { kernel: &kernel, solver, loads };
        let samples: Vec<Vec<f64>> =
            samples(solver, course, loads)?.iter().map(Sample::of_tree).collect();
        let recorded = recipe.record_slopes(quantities, &samples)?;
        let given = (recipe.counts(0), recipe.rubbing());
        Some(Self::compile(inverse, given, quantities, &recorded, machine))
    }

    fn compile(
        inverse: InverseProgram,
        (counts, rubbing): (Counts, Vec<usize>),
        quantities: &[Quantity],
        recorded: &RecordedSlopes,
        machine: bool,
    ) -> Self {
        let ops = recorded.graph.ops();
        let fuse = machine && fuses();
        let given = counts.inputs() + 6 * rubbing.len();
        let mut slots = Slots::of_inputs(ops, 0..given);
        let mut wide = Slots::of_inputs(ops, given..given + quantities.len());
        let mut first = early(ops, &recorded.drives, |input| input >= given);
        let shared = first.clone();
        first.push(recorded.guard);
        let parts = compile(ops, &first, &mut slots, fuse);
        for node in shared {
            wide.put_common(node, slots.of(node).unwrap_or(0));
        }
        let wide_parts = compile(ops, &recorded.drives, &mut wide, fuse);
        let lanes = natural_lanes();
        let count = |parts: &[Part]| parts.iter().map(Part::operations).sum();
        Self {
            first: Runner::new(&parts, 1, slots.count(), machine),
            second: Runner::new(&wide_parts, lanes, wide.count(), machine),
            first_slots: slots.count(),
            second_slots: wide.count(),
            slopes: recorded.drives.iter().map(|node| wide.of(*node).unwrap_or(0)).collect(),
            guard: slots.of(recorded.guard).unwrap_or(0),
            operations: [count(&parts), count(&wide_parts)],
            quantities: quantities.to_vec(),
            inverse,
            rubbing,
            lanes,
        }
    }

    /// The program of inverse dynamics that it contains.
    pub fn inverse(&self) -> &InverseProgram {
        &self.inverse
    }

    /// The quantities by which it differentiates, in the order of slopes.
    pub fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    /// How many directions [`Self::differentiate`] takes at once on this processor.
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// Arithmetic operations beside those of [`InverseProgram::operations`]: once for a state, and for as many
    /// directions at once as there are lanes.
    pub fn operations(&self) -> [usize; 2] {
        self.operations
    }

    /// Room for runs.
    pub fn memory(&self) -> DerivativeMemory {
        let of = |lanes, slots, runner: &Runner| Memory::new(lanes, slots, runner.scratch());
        DerivativeMemory {
            inverse: self.inverse.memory(1),
            first: of(1, self.first_slots, &self.first),
            second: of(self.lanes, self.second_slots, &self.second),
        }
    }

    /// Finds all forces at a state of motion, with friction, and prepares derivatives there. The state must close
    /// the loops. Whether friction and reactions are in balance and what the programs take for granted holds,
    /// see [`InverseProgram::run`]; only then are there derivatives.
    pub fn run(
        &self,
        memory: &mut DerivativeMemory,
        state: &State<f64>,
        targets: &[Target<f64>],
        loads: &[AppliedLoad<f64>],
    ) -> bool {
        let DerivativeMemory { inverse, first, .. } = memory;
        self.inverse.set(inverse, 0, state, targets, loads);
        let mut settled = [false];
        self.inverse.run(inverse, &mut settled);
        let mut put = first.writer(0);
        put_tree(state, targets, loads, &mut put);
        for &joint in &self.rubbing {
            put(&self.inverse.reaction(inverse, 0, joint));
        }
        drop(put);
        self.first.run(&mut first.slots, &mut first.scratch);
        settled[0] && first.slots[self.guard as usize] > 0.0
    }

    /// Sets a direction, one for each lane: the slope of each quantity along it.
    pub fn set_direction(&self, memory: &mut DerivativeMemory, lane: usize, slopes: &[f64]) {
        for (k, slope) in slopes.iter().enumerate().take(self.quantities.len()) {
            memory.second.slots[k * self.lanes + lane] = *slope;
        }
    }

    /// Finds the slopes of all drives along the directions that are set, at the state of the last
    /// [`Self::run`].
    pub fn differentiate(&self, memory: &mut DerivativeMemory) {
        let DerivativeMemory { first, second, .. } = memory;
        self.second.run_with(&mut second.slots, &first.slots, &mut second.scratch);
    }

    /// The forces of the last [`Self::run`], lane 0 of [`Self::inverse`].
    pub fn forces<'a>(&self, memory: &'a DerivativeMemory) -> &'a Memory {
        &memory.inverse
    }

    /// The slope of a drive along a direction, N or N m for each unit of the direction.
    pub fn slope(&self, memory: &DerivativeMemory, lane: usize, drive: usize) -> f64 {
        memory.second.read(self.slopes[drive], lane)
    }

    /// All partial derivatives at the state of the last [`Self::run`]: for each drive those by all quantities,
    /// into `jacobian`, drive after drive.
    pub fn jacobian(&self, memory: &mut DerivativeMemory, jacobian: &mut [f64]) {
        let count = self.quantities.len();
        for first in (0..count).step_by(self.lanes) {
            let directions = &mut memory.second.slots[..count * self.lanes];
            directions.fill(0.0);
            let now = first..count.min(first + self.lanes);
            for quantity in now.clone() {
                directions[quantity * self.lanes + quantity - first] = 1.0;
            }
            self.differentiate(memory);
            for (drive, row) in jacobian.chunks_exact_mut(count).enumerate() {
                for quantity in now.clone() {
                    row[quantity] = self.slope(memory, quantity - first, drive);
                }
            }
        }
    }
}
