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
    /// Stick onset of a friction interface.
    Sticks {
        /// Index of the friction interface.
        interface: usize,
        /// Joint of the interface.
        joint: JointId,
    },
    /// Slip onset or reversal of slip of a friction interface.
    Slides {
        /// Index of the friction interface.
        interface: usize,
        /// Joint of the interface.
        joint: JointId,
        /// Direction of slip along the degrees of freedom of the interface.
        direction: [f64; 3],
    },
    /// More interfaces stick than are needed to hold the mechanism, so the friction laws do not determine
    /// their forces. The simulation distributes them in proportion to the friction limits (least squares).
    /// If one exceeds its limit, any distribution within all limits is taken, or one within 1e-5 of them.
    SharesNotUnique {
        /// Number of undetermined friction forces.
        redundant: usize,
    },
    /// Other solutions satisfy all laws as well. The simulation continues with the one that is connected with
    /// the frictionless solution.
    NotUnique {
        /// Joint whose normal force differs most between the solutions.
        joint: JointId,
        /// Uniqueness bound, see [`crate::forward::Instant::coupling`].
        coupling: f64,
        /// Other solutions.
        others: Vec<Competitor>,
    },
    /// The constraints of loops and prescribed joints lose rank at this position, where two branches of motion
    /// meet. The motion continues smoothly on its branch. Each passage is reported once.
    Singular {
        /// Number of constraints that are dependent only at this position.
        lost: usize,
    },
    /// A switching function of the inputs that ends the simulation is or becomes negative.
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
        /// Energy lost in the impact, J, apart from the work of friction and actuators.
        lost: f64,
    },
    /// The integration scheme changes.
    Method {
        /// New scheme: event-driven or time-stepping.
        method: Method,
    },
    /// Velocities jump within a step of 1e-8 s, because no acceleration satisfies all friction laws
    /// (Painlevé). The velocities after the jump satisfy all laws, with impulses in place of forces
    /// (Moreau). The dissipated work in the energy balance is friction impulse times mean velocity.
    /// Only during time stepping.
    Jump {
        /// Joint with the largest normal force.
        joint: JointId,
        /// Largest change of a rate of the tree, rad/s or characteristic lengths per second.
        change: f64,
        /// Joint rates that jump, the largest change first.
        rates: Vec<RateJump>,
    },
}

impl EventKind {
    /// Returns whether stick or slip begins, or velocities jump; other events tell about the solution.
    pub fn changes_motion(&self) -> bool {
        matches!(self, Self::Sticks { .. } | Self::Slides { .. } | Self::Jump { .. })
    }
}

/// Jump of the rate of one degree of freedom of a joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RateJump {
    /// The joint.
    pub joint: JointId,
    /// Index of the degree of freedom in its joint.
    pub dof: usize,
    /// Rate before the jump, rad/s or m/s.
    pub before: f64,
    /// Rate after the jump, rad/s or m/s.
    pub after: f64,
}
