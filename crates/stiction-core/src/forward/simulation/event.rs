//! What happened, and what can.

use super::Method;
use crate::forward::error::Competitor;
use crate::mechanism::JointId;

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub struct Event {
    /// s.
    pub time: f64,
    /// What.
    pub kind: EventKind,
}

/// What can happen.
#[derive(Clone, Debug, PartialEq)]
pub enum EventKind {
    /// A contact stops and sticks.
    Sticks {
        /// Index of the contact among all.
        interface: usize,
        /// Its joint.
        joint: JointId,
    },
    /// A contact begins to slide, or slides back.
    Slides {
        /// Index of the contact among all.
        interface: usize,
        /// Its joint.
        joint: JointId,
        /// Where to, along its freedoms.
        direction: [f64; 3],
    },
    /// More contacts stick than are needed to hold the mechanism: how they share the load does not follow
    /// from the laws. They share it in proportion to what they can bear (least squares); where that is
    /// beyond a limit, otherwise within all limits; where there is no room left, within 1e-5 of them.
    SharesNotUnique {
        /// How many shares are open.
        redundant: usize,
    },
    /// Other motions satisfy all laws as well; the one that goes on is connected with no friction.
    NotUnique {
        /// The joint whose load differs most.
        joint: JointId,
        /// See [`crate::forward::Instant::coupling`].
        coupling: f64,
        /// The others that were found.
        others: Vec<Competitor>,
    },
    /// Loops, and what is prescribed, lose rank at this position: two ways of moving meet. The motion goes on
    /// smoothly, on the way that it came.
    Singular {
        /// How many conditions depend on the others there that do not beside it.
        lost: usize,
    },
    /// Time is passed in another way from here on.
    Method {
        /// Which: event-driven or time-stepping.
        method: Method,
    },
    /// Velocities jump: friction leaves no acceleration (Painleve), and the step that goes on is the
    /// nearest that satisfies all laws at its end. Only with [`Method::TimeStepping`], or where the choice is
    /// automatic and contacts hold.
    Jump {
        /// The joint with the greatest load.
        joint: JointId,
        /// The largest change of a rate of the tree, rad/s or characteristic lengths per second.
        change: f64,
    },
}
