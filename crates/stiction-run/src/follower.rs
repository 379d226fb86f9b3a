//! Mechanism that follows a prescribed motion from instant to instant.

use crate::error::{Error, check_finite};
use stiction_core::dynamics::{InverseDynamics, Settings};
use stiction_core::kinematics::{Coordinate, Target};
use stiction_format::{ModelFile, Motion};

/// Mechanism at one instant of a prescribed motion. It can be moved to other instants of the motion.
#[derive(Clone, Debug)]
pub struct Follower<'a> {
    motion: &'a Motion,
    /// Mechanism at the time [`Self::time`].
    pub solver: InverseDynamics,
    time: f64,
    /// Buffer for the values of the motion at the next instant.
    ahead: Vec<Target<f64>>,
}

impl<'a> Follower<'a> {
    /// Assembles the mechanism at the position that the motion prescribes at `time`, s.
    ///
    /// # Errors
    /// Returns [`Error::Assembly`] if the loops cannot be closed at this instant, and
    /// [`Error::NotFinite`] if the motion has no finite value there.
    pub fn new(model: &ModelFile, motion: &'a Motion, time: f64) -> Result<Self, Error> {
        check_finite(motion.signals(), time)?;
        let coordinates: Vec<Coordinate> =
            motion.coordinates.iter().map(|(coordinate, _)| *coordinate).collect();
        let targets: Vec<Target<f64>> = motion.at(time).collect();
        let (mechanism, initial_poses) = (model.mechanism.clone(), &model.initial_poses);
        let settings = Settings::default();
        let solver =
            InverseDynamics::new(mechanism, initial_poses, &coordinates, &targets, settings)
                .map_err(|error| Error::Assembly { time, error })?;
        Ok(Self { motion, solver, time, ahead: targets })
    }

    /// Evaluates the motion at `time`, s, and stores the values in [`Self::ahead`].
    fn read(&mut self, time: f64) -> Result<(), Error> {
        self.ahead.clear();
        for signal in self.motion.signals() {
            let value = signal.checked_at(time);
            self.ahead.push(value.map_err(|fault| Error::NotFinite(Box::new(fault)))?);
        }
        Ok(())
    }

    /// Returns the instant of the motion at which the mechanism is at present, s.
    pub fn time(&self) -> f64 {
        self.time
    }

    /// Moves the mechanism along the motion to `time`, s.
    ///
    /// # Errors
    /// See [`Follower::new`].
    pub fn go_to(&mut self, time: f64) -> Result<(), Error> {
        self.read(time)?;
        let Self { motion, ahead, .. } = self;
        let targets_at = |t: f64, targets: &mut [Target<f64>]| match t == time {
            true => targets.copy_from_slice(ahead),
            false => targets.iter_mut().zip(motion.at(t)).for_each(|(target, at)| *target = at),
        };
        let followed = self.solver.follow(self.time, time, targets_at);
        followed.or_else(|error| {
            // Reading a recorded motion may fail during the step.
            check_finite(self.motion.signals(), time)?;
            Err(Error::Assembly { time, error })
        })?;
        self.time = time;
        Ok(())
    }

    /// Moves the mechanism to the instant `time`, s, from prescribed coordinates, and from
    /// coordinates, rates and accelerations of the spanning tree, that are known from an earlier
    /// visit. Returns false and does not move the mechanism if these values do not satisfy the
    /// constraints.
    pub(crate) fn return_to(
        &mut self,
        time: f64,
        known: [&[f64]; 3],
        targets: &[Target<f64>],
    ) -> bool {
        let arrived = self.solver.return_to(known, targets);
        if arrived {
            self.time = time;
        }
        arrived
    }

    /// Moves the mechanism to the instant `time`, s, in a single step. Returns false and does not
    /// move the mechanism if the step is too long.
    pub(crate) fn step_to(&mut self, time: f64) -> bool {
        self.ahead.clear();
        self.ahead.extend(self.motion.at(time));
        let arrived = self.solver.follow_in_one_step(time - self.time, &self.ahead);
        if arrived {
            self.time = time;
        }
        arrived
    }

    /// Appends the time and the configuration of the mechanism to `numbers`.
    pub(crate) fn save(&self, numbers: &mut Vec<f64>) {
        let position = self.solver.save();
        numbers.extend([self.time, position.len() as f64]);
        numbers.extend(position);
    }

    /// Restores the state written by [`Self::save`] from the start of `numbers` and returns the
    /// remaining numbers. `None` if the numbers belong to another motion.
    pub(crate) fn restore<'n>(&mut self, numbers: &'n [f64]) -> Option<&'n [f64]> {
        let (&[time, length], rest) = numbers.split_first_chunk()?;
        let (position, rest) = rest.split_at_checked(length as usize)?;
        self.solver.restore(position)?;
        self.time = time;
        Some(rest)
    }
}
