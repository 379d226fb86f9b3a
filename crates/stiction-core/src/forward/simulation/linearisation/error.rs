//! Reasons why the dynamics cannot be linearised at an operating point.

use crate::forward::error::ForwardError;

/// Reason why the dynamics cannot be linearised at an operating point.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinearisationError {
    /// Friction, locks and prescribed motions prevent every motion.
    #[error("the mechanism cannot move at this position: {held}")]
    Held {
        /// Description of the constraint that prevents the motion.
        held: String,
    },
    /// The constraints lose rank at the operating point.
    #[error(
        "the position is singular: the loop constraints lose rank (singularity index \
         {distance:.1e}), so the accelerations have no derivatives"
    )]
    Singular {
        /// Singularity index of the constraints, between zero and one.
        distance: f64,
    },
    /// The friction of an interface at rest is at its limit.
    #[error(
        "friction interface {interface} is at rest at its static friction limit: opposite \
         disturbances cause different motions, so there is no linearisation"
    )]
    AtLimit {
        /// Index of the friction interface.
        interface: usize,
    },
    /// The friction law of an interface has internal states (bristle deflections).
    #[error(
        "the friction law of interface {interface} has bristles (dahl, lugre), whose deflections \
         are further states that the linearisation does not include"
    )]
    Bristles {
        /// Index of the friction interface.
        interface: usize,
    },
    /// No accelerations satisfy the friction laws at the operating point.
    #[error("no acceleration satisfies all friction laws at this state")]
    NoAcceleration,
    /// Interfaces begin to slide from rest, so the motion on one side of the operating point
    /// differs from that on the other side.
    #[error(
        "friction interfaces begin to slide from rest at this state: opposite disturbances cause \
         different motions, so there is no linearisation"
    )]
    BeginsToSlide {
        /// Indices of the friction interfaces that begin to slide.
        interfaces: Vec<usize>,
    },
    /// No scalar joint coordinate describes a possible motion of the mechanism, for example the
    /// rotation of a ball joint.
    #[error(
        "the mechanism has a motion without a joint coordinate, such as that of a free body or of \
         a ball joint; replace the ball joint with revolute joints or a universal joint"
    )]
    NoCoordinate,
    /// Accelerations cannot be evaluated near the operating point.
    #[error("{0}")]
    Forward(#[from] ForwardError),
}
