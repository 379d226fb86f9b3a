//! Reference motions of actuators. If the motion of a job prescribes the coordinate of an actuator,
//! its signal is the reference of this actuator. Otherwise the reference is computed from the
//! motion of the whole mechanism.

use super::guide::Guide;
use super::job::{Feed, Job};
use crate::error::{Error, check_finite};
use std::f64::consts::TAU;
use stiction_core::forward::Forward;
use stiction_core::kinematics::{Coordinate, Target};
use stiction_format::{FrictionFeed, Signal};

/// Reference motions of the actuators that follow the motion of a job.
#[derive(Clone, Debug)]
pub(super) struct References<'a> {
    followers: Vec<Reference<'a>>,
    guide: Option<Guide<'a>>,
    now: Vec<Target<f64>>,
}

#[derive(Clone, Debug)]
struct Reference<'a> {
    actuator: usize,
    turns: bool,
    /// Signal of this actuator in the motion; `None` if the motion does not prescribe the actuator.
    signal: Option<&'a Signal>,
    /// Reference motion at the last evaluation, with an angle that is not wrapped to one turn, and
    /// the time of this evaluation, s.
    last: (Target<f64>, f64),
}

/// Finds the signal of an actuator's coordinate in the motion, if the motion prescribes this coordinate.
pub(super) fn own_signal<'a>(
    job: &Job<'a>,
    forward: &Forward,
    actuator: usize,
) -> Option<&'a Signal> {
    let (joint, dof) = forward.mechanism().actuators().nth(actuator)?;
    let own = Coordinate::Joint { joint, dof };
    let mut signals = job.motion.iter().flat_map(|motion| &motion.coordinates);
    signals.find(|(coordinate, _)| *coordinate == own).map(|(_, signal)| signal)
}

impl<'a> References<'a> {
    /// Returns true if the motion of the whole mechanism is computed, for reference motions or
    /// feed-forward efforts.
    pub(super) fn is_guided(&self) -> bool {
        self.guide.is_some()
    }

    /// Creates the references before the first sample; `starts` contains the start positions of the
    /// actuators, rad or m. The motion of the whole mechanism is computed only if it is required by
    /// an actuator without its own signal or by a feed-forward effort.
    pub(super) fn new(job: &Job<'a>, forward: &Forward, starts: &[f64]) -> Result<Self, Error> {
        let mechanism = forward.mechanism();
        let mut followers = Vec::new();
        for (actuator, (joint, dof)) in mechanism.actuators().enumerate() {
            if job.followers()[actuator] {
                let own = &mechanism.joints()[joint.0].joint_type.dofs()[dof];
                let start = Target { value: starts[actuator], rate: 0.0, acceleration: 0.0 };
                followers.push(Reference {
                    actuator,
                    turns: !own.translates(),
                    signal: own_signal(job, forward, actuator),
                    last: (start, job.from),
                });
            }
        }
        let reference = FrictionFeed::Reference;
        let efforts = matches!(job.drives, Feed::Inverse)
            || job.control.is_some_and(|control| control.friction == reference);
        let whole = efforts || followers.iter().any(|follower| follower.signal.is_none());
        let guide = if whole { Guide::new(job)? } else { None };
        let zero = Target { value: 0.0, rate: 0.0, acceleration: 0.0 };
        Ok(Self { followers, guide, now: vec![zero; starts.len()] })
    }

    /// Returns the reference motions of all actuators at a time, s; zeros for actuators that follow
    /// no motion.
    pub(super) fn at(&mut self, time: f64) -> Result<&[Target<f64>], Error> {
        let own: Vec<Option<Target<f64>>> =
            self.followers.iter().map(|follower| follower.own(time)).collect::<Result<_, _>>()?;
        if let Some(guide) = &mut self.guide {
            guide.go_to(time)?;
            guide.actuators(&mut self.now);
        }
        for (follower, own) in self.followers.iter_mut().zip(own) {
            let now = &mut self.now[follower.actuator];
            *now = follower.count_on(own.unwrap_or(*now), time);
        }
        Ok(&self.now)
    }

    /// Returns the inverse dynamics along the motion, at the instant of the last call of
    /// [`Self::at`]; `None` if no actuator or effort requires it.
    pub(super) fn guide(&mut self) -> Option<&mut Guide<'a>> {
        self.guide.as_mut()
    }

    /// Appends the last reference of each actuator to `numbers`, followed by the state of the
    /// inverse dynamics along the motion, if it is computed.
    pub(super) fn save(&self, numbers: &mut Vec<f64>) {
        for follower in &self.followers {
            let (last, time) = follower.last;
            numbers.extend([last.value, last.rate, time]);
        }
        if let Some(guide) = &self.guide {
            guide.save(numbers);
        }
    }

    /// Restores the state written by [`Self::save`] from the start of `numbers` and returns the
    /// remaining numbers; `None` if the numbers belong to another motion.
    pub(super) fn restore<'n>(&mut self, mut numbers: &'n [f64]) -> Option<&'n [f64]> {
        for follower in &mut self.followers {
            let (&[value, rate, time], rest) = numbers.split_first_chunk()?;
            follower.last = (Target { value, rate, acceleration: 0.0 }, time);
            numbers = rest;
        }
        match &mut self.guide {
            Some(guide) => guide.restore(numbers),
            None => Some(numbers),
        }
    }
}

impl Reference<'_> {
    fn own(&self, time: f64) -> Result<Option<Target<f64>>, Error> {
        let Some(signal) = self.signal else { return Ok(None) };
        check_finite([signal], time)?;
        Ok(Some(signal.at(time)))
    }

    /// Adds full turns to an angle to bring it closest to its expected value: the previous angle,
    /// extrapolated with the mean of the previous and the present rate. Displacements are not
    /// changed.
    fn count_on(&mut self, mut now: Target<f64>, time: f64) -> Target<f64> {
        let (last, before) = self.last;
        if self.turns {
            let expected = last.value + 0.5 * (time - before) * (last.rate + now.rate);
            now.value += TAU * ((expected - now.value) / TAU).round();
        }
        self.last = (now, time);
        now
    }
}
