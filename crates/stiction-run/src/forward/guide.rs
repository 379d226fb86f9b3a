//! Reference motion of the actuators, and the efforts that it requires.

use super::error::Error;
use super::job::Job;
use crate::inverse;
use stiction_core::dynamics::{AppliedLoad, FrictionMode, InverseDynamics};
use stiction_core::forward::Forward;
use stiction_core::kinematics::Target;
use stiction_format::Side;

/// Inverse-dynamics solver that follows the motion of a job.
#[derive(Clone, Debug)]
pub(super) struct Guide<'a> {
    job: inverse::Job<'a>,
    solver: InverseDynamics,
    /// Current time, s.
    time: f64,
    loads: Vec<AppliedLoad<f64>>,
}

impl<'a> Guide<'a> {
    /// Starts at the job's first instant; `None` if the job has no motion.
    pub(super) fn new(job: &Job<'a>) -> Result<Option<Self>, Error> {
        let Some(motion) = job.motion else { return Ok(None) };
        let friction = if job.friction { FrictionMode::Converged } else { FrictionMode::Off };
        let job = inverse::Job {
            model: job.model,
            motion,
            motion_name: job.motion_name.clone(),
            load: job.load,
            load_name: job.load_name.clone(),
            friction,
            step: None,
            friction_margin: false,
        };
        let time = motion.start;
        let mut solver = job.assemble(time).map_err(Error::Motion)?;
        solver.settings_mut().friction = friction;
        Ok(Some(Self { job, solver, time, loads: Vec::new() }))
    }

    /// Moves the solver to another instant, s.
    pub(super) fn go_to(&mut self, time: f64) -> Result<(), Error> {
        if time != self.time {
            self.job.follow(&mut self.solver, self.time, time).map_err(Error::Motion)?;
            self.time = time;
        }
        Ok(())
    }

    /// Appends the time and the position of the solver.
    pub(super) fn save(&self, numbers: &mut Vec<f64>) {
        let position = self.solver.save();
        numbers.extend([self.time, position.len() as f64]);
        numbers.extend(position);
    }

    /// Restores the state written by [`Self::save`] from the start of `numbers` and returns the
    /// rest; `None` if the numbers belong to another motion.
    pub(super) fn restore<'n>(&mut self, numbers: &'n [f64]) -> Option<&'n [f64]> {
        let (&[time, length], rest) = numbers.split_first_chunk()?;
        let (position, rest) = rest.split_at_checked(length as usize)?;
        self.solver.restore(position)?;
        self.time = time;
        Some(rest)
    }

    /// Writes the motions of the actuators to `out`.
    pub(super) fn actuators(&self, forward: &Forward, out: &mut [Target<f64>]) {
        let (state, bodies) = (self.solver.state(), self.solver.bodies());
        for (target, (joint, dof)) in out.iter_mut().zip(forward.mechanism().actuators()) {
            *target = forward.joint_motion(state, bodies, joint, dof);
        }
    }

    /// Efforts of the motion with and without friction, N or N m.
    pub(super) fn drives(&mut self) -> Result<(&[f64], &[f64]), Error> {
        let at = (self.time, Side::After);
        self.job.loads_of(&self.solver, at, &mut self.loads).map_err(Error::Motion)?;
        let time = self.time;
        match self.solver.solve(&self.loads) {
            Ok(forces) => Ok((&forces.efforts, &forces.efforts_frictionless)),
            Err(error) => Err(Error::Motion(inverse::Error::Forces { time, error })),
        }
    }
}
