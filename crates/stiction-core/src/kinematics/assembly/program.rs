//! Motion of the bodies by a recorded program.

use super::Assembly;
use crate::kinematics::bodies::Bodies;
use crate::kinematics::kernel_program::{KernelProgram, ProgramAtState, Stage};
use std::sync::Arc;

impl Assembly {
    /// Returns `true` if a program can compute the motion: programs know neither local degrees of
    /// freedom nor redundant rows.
    pub(crate) fn admits_program(&self) -> bool {
        let rows = self.model.constraints.row_count();
        rows == self.model.topology.dofs() && self.is_determined()
    }

    /// Uses `program`, recorded for this mechanism and these prescribed coordinates, for the motion
    /// at closed loops. Returns `true` if the program is valid at the present configuration.
    pub(crate) fn use_program(&mut self, program: Arc<dyn KernelProgram>) -> bool {
        let Self { state, targets, .. } = self;
        let mut program = ProgramAtState::new(program);
        let holds = program.go_to(&state.coordinates, targets);
        self.program = holds.then_some(program);
        holds
    }

    /// Returns the program, if its results belong to the present configuration and are valid.
    pub(crate) fn program(&mut self) -> Option<&mut ProgramAtState> {
        let Self { program, state, targets, .. } = self;
        program.as_mut().filter(|program| program.is_at(&state.coordinates, targets))
    }

    /// Returns the program as [`Self::program`], and the motion of the bodies.
    pub(crate) fn program_and_bodies(&self) -> (Option<&ProgramAtState>, &Bodies<f64>) {
        (self.program.as_ref(), &self.kinematics.bodies)
    }

    /// Returns the side of the present configuration, 1 or -1, up to a sign that is constant for a
    /// program; `None` if the program has not computed the motion there.
    pub(crate) fn side_by_program(&mut self) -> Option<f64> {
        Some(self.program()?.results(Stage::Motion).next::<1>()[0])
    }

    /// Computes rates, accelerations and the motion of all bodies at the present coordinates, which
    /// must close the loops, by the program. The poses are computed only if `with_places` is true;
    /// otherwise they must be up to date. Returns `false`, and changes nothing, if there is no
    /// program or if the program is not valid at this configuration.
    pub(super) fn moves_by_program(&mut self, with_places: bool) -> bool {
        let is_determined = self.is_determined();
        let Self { program: Some(program), state, targets, kinematics, .. } = self else {
            return false;
        };
        if !is_determined || !program.go_to(&state.coordinates, targets) {
            return false;
        }
        let mut results = program.results(Stage::Motion);
        let [_side] = results.next();
        results.fill(&mut state.rates);
        results.fill(&mut state.accelerations);
        kinematics.bodies.read(&mut results, with_places);
        kinematics.take_over(with_places);
        true
    }
}
