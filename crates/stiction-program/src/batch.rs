//! Computation of forces at many states. A program of inverse dynamics evaluates several states in
//! parallel lanes; at states where the program is invalid, the general solver computes the forces.

use crate::inverse::InverseProgram;
use crate::program_inputs::StateOfMotion;
use stiction_core::dynamics::{InverseDynamics, InverseError};
use stiction_core::kinematics::AssemblyError;

/// Forces at one state, as [`InverseProgram::run_all`] passes them to its callback.
#[derive(Clone, Copy, Debug)]
pub struct ForcesAt<'a> {
    /// Index of the state in the list of states.
    pub state: usize,
    /// Actuator forces, N or N m.
    pub drives: &'a [f64],
    /// Total wrench that the predecessor of each joint exerts on the successor: force, N, then
    /// moment about the joint's origin, N m, world axes.
    pub reactions: &'a [[f64; 6]],
    /// `true` if the general solver computed the forces, because the program is invalid at this
    /// state.
    pub redone: bool,
}

/// Error: the forces at a state cannot be computed.
#[derive(Clone, Debug, PartialEq)]
pub struct StateError {
    /// Index of the state in the list of states.
    pub state: usize,
    /// Cause of the error.
    pub cause: StateErrorCause,
}

/// Cause of a [`StateError`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StateErrorCause {
    /// The solver cannot move from its present configuration to this state.
    Position(AssemblyError),
    /// The solver cannot compute the forces at this state.
    Forces(InverseError),
}

impl core::fmt::Display for StateError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match &self.cause {
            StateErrorCause::Position(error) => write!(f, "state {}: {error}", self.state),
            StateErrorCause::Forces(error) => write!(f, "state {}: {error}", self.state),
        }
    }
}

impl core::error::Error for StateError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match &self.cause {
            StateErrorCause::Position(error) => Some(error),
            StateErrorCause::Forces(error) => Some(error),
        }
    }
}

impl InverseProgram {
    /// Computes the forces with friction at all states, and calls `tell` with the forces of each
    /// state, in the order of the states. `solver` must be the solver from which the program was
    /// recorded. It moves to each state at which the program is invalid (see [`Self::run`]), for
    /// example because a friction interface is at rest, and computes the forces there. Returns the
    /// number of these states.
    ///
    /// # Errors
    /// [`StateError`] for the first state at which `solver` finds no forces. Forces of the
    /// preceding states have already been passed to `tell`.
    ///
    /// # Panics
    /// See [`Self::set_bodies`].
    pub fn run_all(
        &self,
        solver: &mut InverseDynamics,
        states: &[StateOfMotion<'_>],
        mut tell: impl FnMut(ForcesAt<'_>),
    ) -> Result<usize, StateError> {
        let lanes = self.lanes();
        let mut memory = self.memory(lanes);
        let mut settled = vec![false; lanes];
        let (drive_count, joint_count, _) = self.sizes();
        let mut drives = vec![0.0; drive_count];
        let mut reactions = vec![[0.0; 6]; joint_count];
        let mut left = 0;
        states.iter().for_each(|state| self.check(state.targets, state.loads));
        for first in (0..states.len()).step_by(lanes) {
            self.set_lanes(&mut memory, &states[first..states.len().min(first + lanes)]);
            self.run(&mut memory, &mut settled);
            for (lane, state) in (first..states.len()).take(lanes).enumerate() {
                if settled[lane] {
                    for (k, drive) in drives.iter_mut().enumerate() {
                        *drive = self.drive(&memory, lane, k);
                    }
                    for (joint, reaction) in reactions.iter_mut().enumerate() {
                        *reaction = self.reaction(&memory, lane, joint);
                    }
                } else {
                    left += 1;
                    let fail = |cause| StateError { state, cause };
                    let StateOfMotion { targets, loads, .. } = states[state];
                    let moved = solver.move_to(targets);
                    moved.map_err(|error| fail(StateErrorCause::Position(error)))?;
                    let forces = solver.solve(loads);
                    let forces = forces.map_err(|error| fail(StateErrorCause::Forces(error)))?;
                    drives.copy_from_slice(&forces.efforts);
                    for (own, (force, moment)) in reactions.iter_mut().zip(&forces.reactions) {
                        let ([a, b, c], [d, e, f]) = (force.to_array(), moment.to_array());
                        *own = [a, b, c, d, e, f];
                    }
                }
                let redone = !settled[lane];
                tell(ForcesAt { state, drives: &drives, reactions: &reactions, redone });
            }
        }
        Ok(left)
    }
}
