//! Reference motion of the actuators, and the efforts that inverse dynamics computes for this
//! motion.

use super::job::Job;
use crate::error::Error;
use crate::{Follower, Tracked};
use stiction_core::dynamics::{AppliedLoad, FrictionMode};
use stiction_core::forward::Forward;
use stiction_core::kinematics::{Bodies, Target};
use stiction_core::spatial::Pose;
use stiction_format::Side;

/// Inverse dynamics along the motion that a simulation follows. It yields the reference motions of
/// the actuators.
#[derive(Clone, Debug)]
pub(super) struct Guide<'a> {
    job: crate::Job<'a>,
    /// Model with the same spanning tree as the state of the solver. The spanning tree of the
    /// simulated model may also contain motor shafts.
    tree: Forward,
    follower: Follower<'a>,
    loads: Vec<AppliedLoad<f64>>,
}

impl<'a> Guide<'a> {
    /// Creates the inverse dynamics at the first instant of the job's motion; `None` if the job has
    /// no motion.
    pub(super) fn new(job: &Job<'a>) -> Result<Option<Self>, Error> {
        let Some(motion) = job.motion else { return Ok(None) };
        let friction = if job.friction { FrictionMode::Converged } else { FrictionMode::Off };
        let (load, motion_name) = ((job.load_name.as_str(), job.load), &job.motion_name);
        let model = job.known_model();
        let along = crate::Job::new(model, (motion_name, motion), load);
        let job = crate::Job { friction, ..along };
        let mut follower = job.assemble(motion.start).map_err(of_reference)?;
        follower.solver.settings_mut().friction = friction;
        let tree = Forward::new(model.mechanism.without_friction(), &[]);
        Ok(Some(Self { job, tree, follower, loads: Vec::new() }))
    }

    /// Moves the solver to the instant `time` of the motion, s.
    pub(super) fn go_to(&mut self, time: f64) -> Result<(), Error> {
        if time == self.follower.time() {
            return Ok(());
        }
        self.follower.go_to(time).map_err(of_reference)
    }

    /// Appends the time and the configuration of the mechanism to `numbers`, for [`Self::restore`].
    pub(super) fn save(&self, numbers: &mut Vec<f64>) {
        self.follower.save(numbers);
    }

    /// Restores the state written by [`Self::save`] from the start of `numbers` and returns the
    /// remaining numbers; `None` if the numbers belong to another motion.
    pub(super) fn restore<'n>(&mut self, numbers: &'n [f64]) -> Option<&'n [f64]> {
        self.follower.restore(numbers)
    }

    /// Writes the position, rate and acceleration of each actuator at the present instant to `out`.
    pub(super) fn actuators(&self, out: &mut [Target<f64>]) {
        let (state, bodies) = (self.follower.solver.state(), self.follower.solver.bodies());
        for (target, (joint, dof)) in out.iter_mut().zip(self.tree.mechanism().actuators()) {
            *target = self.tree.joint_motion(state, bodies, joint, dof);
        }
    }

    /// Returns the poses, velocities and accelerations of all bodies at the present instant.
    pub(super) fn bodies(&self) -> &Bodies<f64> {
        self.follower.solver.bodies()
    }

    /// Returns the poses of `bodies` in the world at the present instant.
    pub(super) fn poses(&self, bodies: &[Tracked]) -> impl Iterator<Item = Pose<f64>> {
        let (solver, origin) = (&self.follower.solver, self.follower.solver.parameters().origin);
        let poses = bodies.iter().map(|tracked| solver.bodies().pose[tracked.body]);
        poses.map(move |pose| Pose { position: pose.position + origin, ..pose })
    }

    /// Computes the efforts, N or N m, that the motion requires at the present instant. Returns the
    /// efforts with friction, then those without friction.
    pub(super) fn drives(&mut self) -> Result<(&[f64], &[f64]), Error> {
        let (time, solver) = (self.follower.time(), &mut self.follower.solver);
        self.job.loads_of(solver, (time, Side::After), &mut self.loads)?;
        match solver.solve(&self.loads) {
            Ok(forces) => Ok((&forces.efforts, &forces.efforts_frictionless)),
            Err(error) => Err(Error::Forces { time, error }),
        }
    }
}

/// Returns the error of a motion as that of a reference motion, which differs from the simulated
/// motion.
fn of_reference(error: Error) -> Error {
    match error {
        Error::Assembly { time, error } => Error::Reference { time, error },
        other => other,
    }
}
