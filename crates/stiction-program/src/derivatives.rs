//! Exact derivatives of driving forces, as a program beside that of inverse dynamics.

use crate::inverse::{Beside, InverseProgram};
use crate::memory::Memory;
use crate::quantity::Quantity;
use crate::run::natural_lanes;
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
    beside: Beside,
    quantities: Vec<Quantity>,
    lanes: usize,
}

/// What runs of a [`DerivativeProgram`] read and write.
#[derive(Clone, Debug)]
pub struct DerivativeMemory {
    inverse: Memory,
    directions: Memory,
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
        let (inverse, beside) =
            InverseProgram::record_beside(solver, course, loads, quantities, machine)?;
        let (quantities, lanes) = (quantities.to_vec(), natural_lanes());
        Some(Self { inverse, beside, quantities, lanes })
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
        self.beside.operations
    }

    /// Room for runs.
    pub fn memory(&self) -> DerivativeMemory {
        let Beside { preparation, directions, slots, .. } = &self.beside;
        let mut inverse = self.inverse.memory(1);
        inverse.provide(preparation.scratch());
        let directions = Memory::new(self.lanes, *slots, directions.scratch());
        DerivativeMemory { inverse, directions }
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
        let inverse = &mut memory.inverse;
        self.inverse.set(inverse, 0, state, targets, loads);
        let mut settled = [false];
        self.inverse.run(inverse, &mut settled);
        for &(joint, slot) in &self.beside.reactions {
            let reaction = self.inverse.reaction(inverse, 0, joint);
            inverse.slots[slot..][..6].copy_from_slice(&reaction);
        }
        self.beside.preparation.run(&mut inverse.slots, &mut inverse.scratch);
        settled[0] && inverse.slots[self.beside.guard as usize] > 0.0
    }

    /// Sets a direction, one for each lane: the slope of each quantity along it.
    pub fn set_direction(&self, memory: &mut DerivativeMemory, lane: usize, slopes: &[f64]) {
        for (k, slope) in slopes.iter().enumerate().take(self.quantities.len()) {
            memory.directions.slots[k * self.lanes + lane] = *slope;
        }
    }

    /// Finds the slopes of all drives along the directions that are set, at the state of the last
    /// [`Self::run`].
    pub fn differentiate(&self, memory: &mut DerivativeMemory) {
        let DerivativeMemory { inverse, directions } = memory;
        let Memory { slots, scratch, .. } = directions;
        self.beside.directions.run_with(slots, &inverse.slots, scratch);
    }

    /// The forces of the last [`Self::run`], lane 0 of [`Self::inverse`].
    pub fn forces<'a>(&self, memory: &'a DerivativeMemory) -> &'a Memory {
        &memory.inverse
    }

    /// The slope of a drive along a direction, N or N m for each unit of the direction.
    pub fn slope(&self, memory: &DerivativeMemory, lane: usize, drive: usize) -> f64 {
        memory.directions.read(self.beside.slopes[drive], lane)
    }

    /// All partial derivatives at the state of the last [`Self::run`]: for each drive those by all quantities,
    /// into `jacobian`, drive after drive.
    pub fn jacobian(&self, memory: &mut DerivativeMemory, jacobian: &mut [f64]) {
        let count = self.quantities.len();
        for first in (0..count).step_by(self.lanes) {
            let directions = &mut memory.directions.slots[..count * self.lanes];
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
