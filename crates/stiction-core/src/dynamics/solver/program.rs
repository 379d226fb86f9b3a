//! Forces by a recorded program, where it is valid and satisfies the same tests as the kernels.

use super::{Compiled, InverseDynamics};
use crate::dynamics::coupling::FrictionCoupling;
use crate::dynamics::settings::FrictionMode;
use crate::friction_problem::normal_load::Configuration;
use crate::kinematics::{KernelProgram, Stage};
use crate::statics::{AppliedLoad, act_alike};
use std::sync::Arc;

/// Largest residual of the balance, relative to the largest joint wrench, of forces that a program
/// computes. Programs do not refine their solutions, so the tolerance is close to round-off.
const BALANCED: f64 = 1e-12;

/// Parts of a solver that belong to a program.
#[derive(Clone, Debug)]
pub(super) struct ProgramOfSolver {
    /// External loads at recording: bodies, points and axes must be the same.
    loads: Arc<[AppliedLoad<f64>]>,
    /// Side of the configuration at which the sign of the program is positive.
    side: Option<f64>,
}

impl InverseDynamics {
    /// Returns true if a recorded program can replace the kernels of this mechanism: forces and
    /// motion are determinate, without gearings and local degrees of freedom.
    #[doc(hidden)]
    pub fn admits_program(&self) -> bool {
        let Ok(Compiled { model, .. }) = &self.compiled else { return false };
        self.assembly.admits_program()
            && model.balance.structure.is_plain(&self.topology)
            && FrictionCoupling::stores(self.parameters.interfaces.len())
    }

    /// Uses a program recorded from this solver in place of the kernels, at configurations where
    /// the program is valid and its forces satisfy the balance. `loads` are the loads of the
    /// recording. Returns false, and does not use the program, if it is not valid at the present
    /// configuration, or unless [`Self::admits_program`].
    #[doc(hidden)]
    pub fn use_program(
        &mut self,
        program: Arc<dyn KernelProgram>,
        loads: &[AppliedLoad<f64>],
    ) -> bool {
        if !self.admits_program() {
            return false;
        }
        let side = self.side();
        if !self.assembly.use_program(program) {
            return false;
        }
        let sign = self.assembly.side_by_program();
        let side = side.zip(sign).map(|(side, sign)| side * sign);
        self.program = Some(ProgramOfSolver { loads: loads.into(), side });
        true
    }

    /// Returns true if a program has computed the motion at the present configuration.
    #[doc(hidden)]
    pub fn moves_by_program(&mut self) -> bool {
        self.assembly.program().is_some()
    }

    /// Returns true if a program may have computed the last forces.
    pub(in crate::dynamics) fn has_program(&self) -> bool {
        self.program.is_some()
    }

    /// Returns the side of the present configuration, if the program has computed its motion.
    pub(super) fn side_by_program(&mut self) -> Option<Option<f64>> {
        let ProgramOfSolver { side, .. } = self.program.as_ref()?;
        let sign = self.assembly.side_by_program()?;
        Some(side.map(|side| side * sign))
    }

    /// Solves for all forces by the program. Returns false if there is no program, if an interface
    /// rests, if the solution may not be unique, or if the forces do not satisfy the balance; the
    /// kernels must then solve.
    pub(super) fn by_program(&mut self, loads: &[AppliedLoad<f64>]) -> bool {
        let Some(ProgramOfSolver { loads: recorded, .. }) = &self.program else { return false };
        let fits = act_alike(loads, recorded);
        if self.settings.friction != FrictionMode::Converged || !fits {
            return false;
        }
        let first = self.assembly.state().coordinates.len() + 3 * self.assembly.targets().len();
        let numbers = loads.iter().flat_map(|load| {
            [load.force, load.moment].into_iter().flat_map(|vector| vector.to_array())
        });
        let Some(program) = self.assembly.program() else { return false };
        if !program.balance(first, numbers) {
            return false;
        }
        let Ok(Compiled { model, inverse }) = &mut self.compiled else { return false };
        let (program, bodies) = self.assembly.program_and_bodies();
        let Some(program) = program else { return false };
        let (parameters, settings) = (&*self.parameters, &self.settings);
        let mut results = program.results(Stage::Forces);
        inverse.begin_by_program(model, (parameters, bodies), settings, &mut results);
        if inverse.interfaces().iter().any(|interface| interface.sliding == 0.0) {
            return false;
        }
        let at = Configuration { parameters, bodies };
        let coupling = &mut self.friction_coupling;
        self.strength = coupling.begin_by_program(inverse, model, at, &mut results);
        if self.strength >= 1.0 || !coupling.solve_present(at) {
            return false;
        }
        let found = (|joint| coupling.present_wrench(joint), coupling.present_loads());
        inverse.adopt(model, parameters, bodies, (settings, BALANCED), found)
    }
}
