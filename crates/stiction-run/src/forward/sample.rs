//! Results of a simulation at one sample.

use crate::in_space::{self, SpacePoint, Tracked};
use stiction_core::dynamics::AppliedLoad;
use stiction_core::forward::{Energies, Forward, Instant};
use stiction_core::kinematics::Target;
use stiction_core::spatial::Pose;

/// Results of a simulation at one sample, borrowed from the simulation.
#[derive(Clone, Copy, Debug)]
pub struct Sample<'a> {
    /// Model of the mechanism for forward dynamics.
    pub forward: &'a Forward,
    /// State, accelerations, reactions and friction at the sample.
    pub instant: &'a Instant,
    /// Work done and energy dissipated since the start, J.
    pub energies: &'a Energies,
    /// Residual of the energy balance since the start, J.
    pub energy_error: f64,
    /// Position, rate and acceleration of each scalar degree of freedom of a joint. Angles are not
    /// wrapped to one turn.
    pub joints: &'a [Target<f64>],
    /// Reference position, rate and acceleration of each actuator; zeros for actuators that follow
    /// no motion.
    pub reference: &'a [Target<f64>],
    /// Bodies whose pose has a reference, as returned by [`Job::followed`](super::Job::followed).
    pub tracked: &'a [Tracked],
    /// Reference poses in the world of the bodies in `tracked`; NaN where the mechanism cannot follow the motion.
    pub reference_poses: &'a [Pose<f64>],
    /// External loads on the bodies at the sample.
    pub loads: &'a [AppliedLoad<f64>],
    /// Largest closure error of loops and gearings, m; errors of angles are multiplied by the characteristic length.
    pub closure: f64,
}

impl Sample<'_> {
    /// Returns the position, the reference position and the tracking errors of each body, in the
    /// order of `tracked`.
    pub fn in_space(&self) -> impl Iterator<Item = SpacePoint> {
        let origin = self.forward.parameters().origin;
        self.tracked.iter().zip(self.reference_poses).map(move |(tracked, reference)| {
            let pose = self.instant.bodies.pose[tracked.body];
            in_space::compare(&Pose { position: pose.position + origin, ..pose }, reference)
        })
    }
}
