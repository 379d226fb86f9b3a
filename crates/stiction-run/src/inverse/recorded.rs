//! Recorded program in place of the kernels, for runs with many samples.

use crate::follower::Follower;
use crate::instants::Instants;
use crate::job::Job;
use stiction_core::dynamics::FrictionMode;
use stiction_core::kinematics::Target;
use stiction_format::Side;
use stiction_program::RecordedKernels;

/// Least number of samples for which recording a program takes less time than it saves.
const MANY: usize = 2000;
/// Number of instants of the motion near which the program is recorded.
const INSTANTS: usize = 10;

impl Job<'_> {
    /// Lets the solver of `follower`, which is at the first instant, compute by a recorded program,
    /// if the run has so many samples that this saves time and if a program can be recorded.
    pub(super) fn record_program(&self, follower: &mut Follower<'_>, instants: &Instants) {
        let count = instants.count();
        let has_friction = !follower.solver.parameters().interfaces.is_empty();
        let is_suitable = self.friction == FrictionMode::Converged && !self.friction_margin;
        if count < MANY || !has_friction || !is_suitable {
            return;
        }
        let signal: Vec<Vec<Target<f64>>> = (0..INSTANTS)
            .map(|k| self.motion.at(instants.at(k * (count - 1) / INSTANTS)).collect())
            .collect();
        let mut loads = Vec::new();
        let first = (instants.at(0), Side::After);
        // Without a program the kernels compute all samples, and report errors.
        if self.loads_of(&follower.solver, first, &mut loads).is_ok()
            && let Ok(program) = RecordedKernels::record(&follower.solver, &signal, &loads)
        {
            follower.solver.use_program(program, &loads);
        }
    }
}
