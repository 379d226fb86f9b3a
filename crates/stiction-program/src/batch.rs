//! Forces at many states: by the program, side by side, and by its solver where the program does not hold.

use crate::inverse::InverseProgram;
use crate::program_inputs::StateOfMotion;
use stiction_core::dynamics::{InverseDynamics, InverseError};
use stiction_core::kinematics::AssemblyError;

/// Forces at one state.
#[derive(Clone, Copy, Debug)]
pub struct ForcesAt<'a> {
    /// Which of the states.
    pub state: usize,
    /// Driving forces, N or N m.
    pub drives: &'a [f64],
    /// Each joint's complete wrench, predecessor on successor: force, then moment about the joint's origin,
    /// world axes.
    pub reactions: &'a [[f64; 6]],
    /// Whether the solver found them.
    pub redone: bool,
}

/// Why a state has no forces.
#[derive(Clone, Debug, PartialEq)]
pub struct StateError {
    /// Which of the states.
    pub state: usize,
    /// Why.
    pub cause: StateErrorCause,
}

/// See [`StateError`].
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum StateErrorCause {
    /// The solver cannot be brought there from where it was last.
    Position(AssemblyError),
    /// No forces, or none that can be found.
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
    /// Finds the forces with friction at all states and tells them in their order; gives the number of
    /// states that were left to the solver, because a contact rests there or a branch is taken that was not
    /// recorded. The solver must be that of the program, and is brought from state to state.
    ///
    /// # Errors
    /// The first state for which the solver finds no forces; those before it are told.
    ///
    /// # Panics
    /// As [`Self::set_bodies`].
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
