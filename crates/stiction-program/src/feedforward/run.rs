//! Execution of [`Feedforward`] programs on this processor.

use super::Feedforward;
use crate::inverse::{STEPS, settle};
use crate::memory::Memory;

/// Largest number of corrections of the position in the loop closure.
pub(crate) const CORRECTIONS: usize = 12;
/// Closure error below which the loops need no further correction; lengths are divided by the
/// characteristic length, angles are in rad. Near singular positions, efforts magnify this error by
/// up to a thousand.
pub(crate) const DONE: f64 = 1e-14;
/// Largest closure error at which the loops count as closed if corrections no longer reduce the
/// error.
pub(crate) const CLOSED: f64 = 1e-11;

/// Value of a coordinate that few loops reach, rad or m, and at which round-off does not keep loops
/// open.
const FAR: f64 = 10.0;

/// Inputs and results of a [`Feedforward`], and its tree coordinates from the last loop closure.
#[derive(Clone, Debug)]
pub struct FeedforwardMemory {
    /// Tree coordinates of the last position with closed loops.
    coordinates: Vec<f64>,
    position: Memory,
    forces: Memory,
    /// Buffer for copying results of routines to inputs.
    moved: Vec<f64>,
}

/// Outcome of [`Feedforward::run`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Outcome {
    /// Closure error of the loops; lengths are divided by the characteristic length, angles are in
    /// rad.
    pub residual: f64,
    /// Determinant of the rate equations relative to that at the home position: zero at singular
    /// positions.
    pub determinant: f64,
    /// Number of corrections of the position, and number of Newton steps for the friction forces.
    pub passes: [usize; 2],
    /// Reason why there are no forces with friction; `None` if these forces are valid.
    pub shortfall: Option<Shortfall>,
}

/// Reason why a [`Feedforward`] program computes no forces with friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shortfall {
    /// The loops cannot be closed, starting from the last position.
    Open,
    /// The position is singular, or a singular position lies between it and the home position.
    Singular,
    /// The friction coupling has no solution, a friction interface is at rest, or another
    /// assumption made at recording does not hold. Forces without friction are valid.
    Friction,
}

impl Feedforward {
    /// Allocates the memory of the program, with the loops closed at the home position.
    pub fn memory(&self) -> FeedforwardMemory {
        let (position, forces) = &self.code;
        let mut memory = FeedforwardMemory {
            coordinates: self.home.0.clone(),
            position: position.memory(1),
            forces: forces.memory(1),
            moved: vec![0.0; self.sizes.coordinates.max(self.sizes.unknowns)],
        };
        let first = self.sizes.coordinates;
        let values = self.tunables.iter().flat_map(|(_, values)| values);
        for (slot, value) in memory.forces.slots[first..].iter_mut().zip(values) {
            *slot = *value;
        }
        memory
    }

    /// Sets the values of all tunable parameters, in the order of [`Self::tunables`].
    pub fn tune(&self, memory: &mut FeedforwardMemory, values: &[f64]) {
        let first = self.sizes.coordinates;
        let slots = &mut memory.forces.slots[first..first + self.sizes.tunables];
        for (slot, value) in slots.iter_mut().zip(values) {
            *slot = *value;
        }
    }

    /// Sets the tree coordinates from which the next loop closure starts.
    pub(crate) fn start_at(&self, memory: &mut FeedforwardMemory, coordinates: &[f64]) {
        memory.coordinates.copy_from_slice(coordinates);
    }

    /// Closes the loops at the prescribed values `q`, starting from the last position. Returns the
    /// closure error and the number of corrections, or only the closure error if it remains too
    /// large.
    fn close(&self, memory: &mut FeedforwardMemory, q: &[f64]) -> Result<(f64, usize), f64> {
        let FeedforwardMemory { coordinates, position, moved, .. } = memory;
        let Memory { slots, scratch, .. } = position;
        let [errors, correction] = &self.native.position;
        let runners = self.code.0.runners(1);
        let count = coordinates.len();
        slots[..count].copy_from_slice(coordinates);
        slots[count..count + q.len()].copy_from_slice(q);
        let mut before = f64::INFINITY;
        for pass in 0..=CORRECTIONS {
            runners[0].run(slots, scratch);
            let [square, guard] = [0, 1].map(|k| slots[errors.results[k] as usize]);
            let residual = square.sqrt();
            if !(residual.is_finite() && guard > 0.0) {
                return Err(residual);
            }
            if residual <= DONE || (residual <= CLOSED && residual >= 0.5 * before) {
                coordinates.copy_from_slice(&slots[..count]);
                return Ok((residual, pass));
            }
            before = residual;
            runners[1].run(slots, scratch);
            for (moved, slot) in moved.iter_mut().zip(&correction.results) {
                *moved = slots[*slot as usize];
            }
            slots[..count].copy_from_slice(&moved[..count]);
        }
        Err(before)
    }

    /// Returns true if the loops cannot be closed at the value [`FAR`] of the first prescribed
    /// coordinate. The loop of a screw and a guide closes at any value, except for round-off.
    pub(crate) fn is_bounded(&self) -> bool {
        let mut far = vec![0.0; self.sizes.prescribed];
        if let Some(first) = far.first_mut() {
            *first = FAR;
        }
        self.close(&mut self.memory(), &far).is_err()
    }

    /// Computes actuator forces with friction at positions, rates and accelerations of the
    /// prescribed coordinates. The loop closure starts from the last position.
    ///
    /// # Panics
    /// If the length of `q`, `v` or `a` is not the number of prescribed coordinates.
    pub fn run(&self, memory: &mut FeedforwardMemory, q: &[f64], v: &[f64], a: &[f64]) -> Outcome {
        let count = self.sizes.prescribed;
        assert_eq!([q.len(), v.len(), a.len()], [count; 3], "values of {count} coordinates");
        let mut outcome =
            Outcome { residual: 0.0, determinant: 0.0, passes: [0; 2], shortfall: None };
        match self.close(memory, q) {
            Ok((residual, passes)) => (outcome.residual, outcome.passes[0]) = (residual, passes),
            Err(residual) => {
                return Outcome { residual, shortfall: Some(Shortfall::Open), ..outcome };
            }
        }
        let FeedforwardMemory { coordinates, forces, moved, .. } = memory;
        let Memory { slots, scratch, .. } = forces;
        let [preparation, step, last] = &self.native.forces;
        let runners = self.code.1.runners(1);
        let (tree, unknowns, drives) =
            (self.sizes.coordinates, self.sizes.unknowns, self.sizes.drives);
        slots[..tree].copy_from_slice(coordinates);
        let targets = slots[tree + self.sizes.tunables..].iter_mut();
        let values = (0..count).flat_map(|k| [q[k], v[k], a[k]]);
        targets.zip(values).for_each(|(slot, value)| *slot = value);
        runners[0].run(slots, scratch);
        let [guard, determinant] =
            [0, 1].map(|k| slots[preparation.results[unknowns + drives + k] as usize]);
        outcome.determinant = determinant;
        if determinant.is_nan() || determinant <= 0.0 {
            return Outcome { shortfall: Some(Shortfall::Singular), ..outcome };
        }
        // The routines read the unknowns from input slots, to which results must be copied.
        let mut copy = |slots: &mut [f64], from: &[u32]| {
            for (moved, slot) in moved.iter_mut().zip(&from[..unknowns]) {
                *moved = slots[*slot as usize];
            }
            for (to, value) in self.unknown_slots.iter().zip(&*moved) {
                slots[*to as usize] = *value;
            }
        };
        copy(slots, &preparation.results);
        let mut changes = [0.0];
        let mut done = unknowns == 0;
        for pass in 0..STEPS {
            runners[1].run(slots, scratch);
            let control = [0, 1, 2].map(|k| [slots[step.results[unknowns + k] as usize]]);
            outcome.passes[1] = pass + 1;
            done = done || settle(control, &mut changes)[0];
            if done {
                break;
            }
            copy(slots, &step.results);
        }
        runners[2].run(slots, scratch);
        let holds = slots[last.results[drives + 3 * self.sizes.joints] as usize] > 0.0;
        if !(done && holds && guard > 0.0) {
            outcome.shortfall = Some(Shortfall::Friction);
        }
        outcome
    }

    /// Returns an actuator force with friction, N or N m, computed by the last [`Self::run`].
    pub fn drive(&self, memory: &FeedforwardMemory, drive: usize) -> f64 {
        memory.forces.read(self.native.forces[2].results[drive], 0)
    }

    /// Returns an actuator force without friction, N or N m, computed by the last [`Self::run`].
    pub fn ideal_drive(&self, memory: &FeedforwardMemory, drive: usize) -> f64 {
        memory.forces.read(self.native.forces[0].results[self.sizes.unknowns + drive], 0)
    }

    /// Returns the force that the predecessor of a joint exerts on the successor, N, world axes,
    /// computed by the last [`Self::run`].
    pub fn joint_force(&self, memory: &FeedforwardMemory, joint: usize) -> [f64; 3] {
        let first = self.sizes.drives + 3 * joint;
        core::array::from_fn(|axis| {
            memory.forces.read(self.native.forces[2].results[first + axis], 0)
        })
    }
}
