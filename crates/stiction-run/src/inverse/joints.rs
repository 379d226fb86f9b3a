//! Motion of the joints along a run.

use crate::dofs::{Dof, dofs_of};
use crate::job::Job;
use core::f64::consts::TAU;
use stiction_core::dynamics::InverseDynamics;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_format::Signal;

/// Returns the coordinates, rates and accelerations of the degrees of freedom `dofs` at the
/// solver's pose; angles are at most half a turn from zero.
pub(super) fn joint_motions(
    solver: &InverseDynamics,
    dofs: &[Dof],
) -> impl Iterator<Item = Target<f64>> {
    dofs.iter().map(|dof| solver.joint_motion(dof.joint, dof.index))
}

/// Counts the full turns of joint angles from sample to sample.
pub(super) struct Turns<'a> {
    dofs: Vec<Dof>,
    /// Signal that prescribes each degree of freedom; `None` if it is not prescribed.
    prescribed: Vec<Option<&'a Signal>>,
    last: Option<(f64, Vec<Target<f64>>)>,
}

impl<'a> Turns<'a> {
    /// Creates the counter before the first sample.
    pub(super) fn new(job: &Job<'a>) -> Self {
        let dofs = dofs_of(&job.model.mechanism);
        let prescribed = |dof: &Dof| {
            let own = Coordinate::Joint { joint: dof.joint, dof: dof.index };
            let mut motion = job.motion.coordinates.iter();
            motion.find(|(coordinate, _)| *coordinate == own).map(|(_, signal)| signal)
        };
        let prescribed = dofs.iter().map(prescribed).collect();
        Self { dofs, prescribed, last: None }
    }

    /// Adds full turns to each angle, so that the result is as close as possible to the prescribed
    /// angle. If the angle is not prescribed, the result is as close as possible to the angle at
    /// the previous sample, extrapolated with the mean rate to `time`, s.
    pub(super) fn add(&mut self, time: f64, motion: &mut [Target<f64>]) {
        for (k, now) in motion.iter_mut().enumerate().filter(|(k, _)| !self.dofs[*k].translates) {
            let expected = match (self.prescribed[k], &self.last) {
                (Some(signal), _) => signal.at(time).value,
                (None, Some((before, last))) => {
                    last[k].value + 0.5 * (last[k].rate + now.rate) * (time - before)
                }
                (None, None) => continue,
            };
            now.value += TAU * ((expected - now.value) / TAU).round();
        }
        match &mut self.last {
            Some((before, last)) => {
                *before = time;
                last.copy_from_slice(motion);
            }
            none => *none = Some((time, motion.to_vec())),
        }
    }
}
