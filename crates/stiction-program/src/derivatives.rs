//! Program that computes exact derivatives of actuator forces in addition to inverse dynamics.

use crate::error::RecordError;
use crate::inverse::{DerivativeCode, InverseProgram};
use crate::memory::Memory;
use crate::quantity::Quantity;
use crate::run::natural_lanes;
use stiction_core::dynamics::{AppliedLoad, InverseDynamics};
use stiction_core::kinematics::{State, Target};

/// Program that computes inverse dynamics of one mechanism and the derivatives of its actuator
/// forces with respect to selected quantities of the motion and the mechanism. Derivatives are
/// exact to round-off, and are computed for several directions at once.
///
/// A direction consists of a slope (rate of change) for each quantity; a unit slope of one quantity
/// alone yields the partial derivative with respect to this quantity. The derivatives assume that
/// all friction interfaces slide, and include the change of friction with the normal loads.
///
/// ```
/// use stiction_core::dynamics::{InverseDynamics, Settings};
/// use stiction_core::joint::JointType;
/// use stiction_core::kinematics::{Coordinate, Target};
/// use stiction_core::mechanism::{BodyId, BodySpec, JointId, JointSpec, MechanismBuilder};
/// use stiction_core::spatial::Vec3;
/// use stiction_program::{DerivativeProgram, Quantity};
///
/// let pendulum = MechanismBuilder::new("pendulum")
///     .gravity(Vec3::new(0.0, -9.81, 0.0))
///     .body(BodySpec::new("bob").mass(2.0).com(Vec3::new(0.5, 0.0, 0.0)))
///     .joint(JointSpec::new("pivot", JointType::Revolute, "ground", "bob").actuated())
///     .build()?;
/// let angle = Coordinate::Joint { joint: JointId(0), dof: 0 };
/// let at = |value| vec![Target { value, rate: 0.0, acceleration: 0.0 }];
/// let solver = InverseDynamics::new(pendulum, &[], &[angle], &at(0.0), Settings::default())?;
/// let signal: Vec<_> = (0..10).map(|k| at(0.1 * f64::from(k))).collect();
/// let quantities = [Quantity::Mass(BodyId(1)), Quantity::Acceleration(0)];
/// let program = DerivativeProgram::record(&solver, &signal, &[], &quantities)?;
///
/// let mut memory = program.memory();
/// let mut jacobian = [0.0; 2];
/// assert!(program.run(&mut memory, solver.state(), &signal[0], &[]));
/// program.jacobian(&mut memory, &mut jacobian);
/// // With respect to the mass: g l. With respect to the acceleration: the inertia m l^2.
/// assert!((jacobian[0] - 9.81 * 0.5).abs() < 1e-14);
/// assert!((jacobian[1] - 2.0 * 0.5 * 0.5).abs() < 1e-14);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct DerivativeProgram {
    inverse: InverseProgram,
    code: DerivativeCode,
    quantities: Vec<Quantity>,
    lanes: usize,
}

/// Inputs, results and scratch values of a [`DerivativeProgram`].
#[derive(Clone, Debug)]
pub struct DerivativeMemory {
    inverse: Memory,
    directions: Memory,
    /// True if the derivatives can be computed at the last evaluated state.
    is_ready: bool,
}

impl DerivativeProgram {
    /// Records and compiles inverse dynamics and its derivatives with respect to `quantities`.
    /// `solver`, `signal` and `loads` are as in [`InverseProgram::record`].
    ///
    /// # Errors
    /// See [`RecordError`]: the errors of [`InverseProgram::record`], and an error if `quantities`
    /// is empty or contains a quantity that does not exist.
    pub fn record(
        solver: &InverseDynamics,
        signal: &[Vec<Target<f64>>],
        loads: &[AppliedLoad<f64>],
        quantities: &[Quantity],
    ) -> Result<Self, RecordError> {
        Self::record_with(solver, signal, loads, quantities, true)
    }

    /// Records and compiles a program as [`Self::record`] does. If `machine` is false, the program
    /// is interpreted, which is slow and intended for tests of the machine code.
    #[doc(hidden)]
    pub fn record_with(
        solver: &InverseDynamics,
        signal: &[Vec<Target<f64>>],
        loads: &[AppliedLoad<f64>],
        quantities: &[Quantity],
        machine: bool,
    ) -> Result<Self, RecordError> {
        if quantities.is_empty() {
            return Err(RecordError::NoQuantity);
        }
        let (inverse, code) =
            InverseProgram::record_with_derivatives(solver, signal, loads, quantities, machine)?;
        let (quantities, lanes) = (quantities.to_vec(), natural_lanes());
        Ok(Self { inverse, code, quantities, lanes })
    }

    /// Program of inverse dynamics to which the derivatives belong.
    pub fn inverse(&self) -> &InverseProgram {
        &self.inverse
    }

    /// Quantities with respect to which actuator forces are differentiated, in the order of the
    /// slopes of a direction.
    pub fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    /// Number of directions that [`Self::differentiate`] processes in parallel on this processor.
    pub fn lanes(&self) -> usize {
        self.lanes
    }

    /// Numbers of arithmetic operations in addition to [`InverseProgram::operations`]: first those
    /// that are executed once for each state, then those that are executed for each group of
    /// [`Self::lanes`] directions.
    pub fn operations(&self) -> [usize; 2] {
        self.code.operations
    }

    /// Allocates the memory of the program.
    pub fn memory(&self) -> DerivativeMemory {
        let DerivativeCode { preparation, directions, slots, .. } = &self.code;
        let mut inverse = self.inverse.memory(1);
        inverse.provide(preparation.scratch());
        let directions = Memory::new(self.lanes, *slots, directions.scratch());
        DerivativeMemory { inverse, directions, is_ready: false }
    }

    /// Computes all forces with friction at a state, and prepares the derivatives at this state.
    /// The state must close the loops. Returns `true` if the iteration of the friction forces has
    /// converged and the assumptions of the program are satisfied, see [`InverseProgram::run`];
    /// otherwise all derivatives are NaN.
    ///
    /// # Panics
    /// See [`InverseProgram::set`].
    #[must_use = "if the result is false, forces and slopes are invalid"]
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
        for &(joint, slot) in &self.code.reactions {
            let reaction = self.inverse.reaction(inverse, 0, joint);
            inverse.slots[slot..][..6].copy_from_slice(&reaction);
        }
        self.code.preparation.run(&mut inverse.slots, &mut inverse.scratch);
        memory.is_ready = settled[0] && inverse.slots[self.code.guard as usize] > 0.0;
        memory.is_ready
    }

    /// Sets the direction of one lane: a slope for each quantity. [`Self::jacobian`] overwrites all
    /// directions.
    ///
    /// # Panics
    /// If the lane does not exist, or the number of slopes differs from that of the quantities.
    pub fn set_direction(&self, memory: &mut DerivativeMemory, lane: usize, slopes: &[f64]) {
        let (found, expected) = (slopes.len(), self.quantities.len());
        assert!(
            found == expected,
            "expected {expected} slopes, one for each quantity, found {found}"
        );
        assert!(lane < self.lanes, "lane {lane} of {}", self.lanes);
        for (k, slope) in slopes.iter().enumerate() {
            memory.directions.slots[k * self.lanes + lane] = *slope;
        }
    }

    /// Computes the slopes of all actuator forces along the directions of all lanes, at the state
    /// of the last [`Self::run`]. All slopes are NaN if there was no run, or if the last run
    /// returned `false`.
    pub fn differentiate(&self, memory: &mut DerivativeMemory) {
        let DerivativeMemory { inverse, directions, is_ready } = memory;
        let Memory { slots, scratch, .. } = directions;
        self.code.directions.run_with(slots, &inverse.slots, scratch);
        if !*is_ready {
            // Existing slopes would belong to another state.
            for slope in &self.code.slopes {
                slots[*slope as usize * self.lanes..][..self.lanes].fill(f64::NAN);
            }
        }
    }

    /// Returns the memory that contains the forces of the last [`Self::run`], in lane 0. The
    /// methods of the program [`Self::inverse`] read these forces.
    pub fn forces<'a>(&self, memory: &'a DerivativeMemory) -> &'a Memory {
        &memory.inverse
    }

    /// Derivative of the actuator force with index `drive` along the direction of a lane, N or N m
    /// per unit of the direction. It was computed by the last [`Self::differentiate`].
    pub fn slope(&self, memory: &DerivativeMemory, lane: usize, drive: usize) -> f64 {
        memory.directions.read(self.code.slopes[drive], lane)
    }

    /// Computes all partial derivatives at the state of the last [`Self::run`]. `jacobian` receives
    /// one row for each actuator and one column for each quantity, row by row. All derivatives are
    /// NaN if there was no run, or if the last run returned `false`.
    ///
    /// # Panics
    /// If the length of `jacobian` is not the number of actuators times the number of quantities.
    pub fn jacobian(&self, memory: &mut DerivativeMemory, jacobian: &mut [f64]) {
        let count = self.quantities.len();
        let (found, expected) = (jacobian.len(), count * self.code.slopes.len());
        assert!(found == expected, "room for {found} derivatives, not for {expected}");
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
