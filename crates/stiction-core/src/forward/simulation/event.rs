//! Events of a simulation.

use super::Method;
use crate::forward::error::Competitor;
use crate::mechanism::{BodyId, JointId};

/// Event of a simulation.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// Time, s.
    pub time: f64,
    /// Kind of event.
    pub kind: EventKind,
}

/// Kind of an event.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// An interface begins to stick.
    Sticks {
        /// Index of the friction interface.
        interface: usize,
        /// Joint of the interface.
        joint: JointId,
    },
    /// An interface begins to slip, or its slip reverses.
    Slides {
        /// Index of the friction interface.
        interface: usize,
        /// Joint of the interface.
        joint: JointId,
        /// Direction of slip, one component for each degree of freedom of the interface.
        direction: [f64; 3],
    },
    /// More interfaces stick than are needed to lock the mechanism, so the friction laws do not
    /// determine the individual friction forces. The simulation distributes the friction forces in
    /// proportion to the friction limits (least squares) and, close to singular positions, limits
    /// the normal loads. Normal loads and the next slip onset can depend on this distribution. If a
    /// friction force exceeds its limit, the simulation selects another distribution, in which
    /// friction forces exceed their limits at most by the relative amount 1e-5.
    SharesNotUnique {
        /// Number of friction forces that are statically indeterminate.
        redundant: usize,
    },
    /// Other solutions satisfy all friction laws as well. The simulation continues with the
    /// solution that is connected to the frictionless solution.
    NotUnique {
        /// Joint whose normal force differs most between the solutions.
        joint: JointId,
        /// Uniqueness bound, see [`crate::forward::Instant::coupling`].
        coupling: f64,
        /// The other solutions that were found.
        others: Vec<Competitor>,
    },
    /// The constraints of loops and prescribed joints lose rank at this configuration, where two
    /// branches of motion meet. The simulation continues smoothly on the present branch. Each
    /// passage is reported once.
    Singular {
        /// Number of constraints that are dependent at this configuration but independent at
        /// neighbouring configurations.
        lost: usize,
    },
    /// A switching function of the inputs that ends the simulation is negative.
    Ends {
        /// Index of the switching function.
        switch: usize,
    },
    /// A body picks up or places a part.
    Payload {
        /// The body.
        body: BodyId,
        /// True if the part is picked up, by a plastic impact.
        picked_up: bool,
        /// Energy lost in the impact, J, excluding the work of friction and actuators during the
        /// impact.
        lost: f64,
    },
    /// The integration scheme changes.
    Method {
        /// New integration scheme: event-driven or time-stepping.
        method: Method,
    },
    /// Velocities jump within a step of 1e-8 s, because no accelerations satisfy all friction laws
    /// (Painlevé paradox). The velocities after the jump satisfy all laws with impulses in place of
    /// forces (Moreau). In the energy balance, the dissipated work is the friction impulse times
    /// the mean velocity. Occurs only during time stepping.
    Jump {
        /// Joint with the largest normal force.
        joint: JointId,
        /// Largest change of a rate of the spanning tree, rad/s or characteristic lengths per
        /// second.
        change: f64,
        /// Joint rates that jump, sorted by decreasing change.
        rates: Vec<RateJump>,
    },
}

impl EventKind {
    /// Returns true if the event begins stick or slip, or is a velocity jump. All other events are
    /// information about the solution.
    pub fn changes_motion(&self) -> bool {
        matches!(self, Self::Sticks { .. } | Self::Slides { .. } | Self::Jump { .. })
    }
}

/// Jump of the rate of one degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateJump {
    /// Joint of the degree of freedom.
    pub joint: JointId,
    /// Index of the degree of freedom in the joint.
    pub dof: usize,
    /// Rate before the jump, rad/s or m/s.
    pub before: f64,
    /// Rate after the jump, rad/s or m/s.
    pub after: f64,
}
