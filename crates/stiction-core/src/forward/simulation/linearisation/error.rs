//! Reasons for which there is no linearisation.

use crate::forward::error::ForwardError;

/// Reason for which an operating point has no linearisation.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LinearisationError {
    /// Friction, locks and prescribed motions prevent every motion.
    #[error("the mechanism cannot move at this position: {held}")]
    Held {
        /// The constraint that holds the mechanism, in words.
        held: String,
    },
    /// The constraints lose rank at the operating point.
    #[error(
        "the position is singular: the loop constraints lose rank (singularity index \
         {distance:.1e}), so the accelerations have no derivatives"
    )]
    Singular {
        /// Singularity distance.
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
    /// The friction law of an interface has internal states.
    #[error(
        "the friction law of interface {interface} has bristles (dahl, lugre), whose deflections \
         are further states that the linearisation does not include"
    )]
    Bristles {
        /// Index of the friction interface.
        interface: usize,
    },
    /// No acceleration satisfies the friction laws at the operating point.
    #[error("no acceleration satisfies all friction laws at this state")]
    NoAcceleration,
    /// Interfaces begin to slide from rest, so the motion differs on both sides of the operating point.
    #[error(
        "friction interfaces begin to slide from rest at this state: opposite disturbances cause \
         different motions, so there is no linearisation"
    )]
    BeginsToSlide {
        /// Indices of the friction interfaces.
        interfaces: Vec<usize>,
    },
    /// A motion of the mechanism changes no joint coordinate.
    #[error(
        "a motion of the mechanism has no joint coordinate that describes it, such as that of a free \
         body or of a ball joint; replace the ball joint by revolute joints or a universal joint"
    )]
    NoCoordinate,
    /// Accelerations cannot be evaluated at positions or rates near the operating point.
    #[error("{0}")]
    Forward(#[from] ForwardError),
}
