//! Errors of recordings.

use crate::quantity::Quantity;
use core::fmt;
use stiction_core::kinematics::AssemblyError;

/// Error: a mechanism has no program. Its solver remains usable.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RecordError {
    /// The signal contains no position.
    EmptyCourse,
    /// The solver cannot follow the signal to a position or its neighbourhood.
    Signal {
        /// Index of the position in the signal.
        position: usize,
        /// Error of the solver.
        error: AssemblyError,
    },
    /// The kernel has no plan: the solver's position is singular, or both constraints and actuators
    /// are redundant.
    NoPlan,
    /// The list of quantities for derivatives is empty.
    NoQuantity,
    /// The mechanism has no such quantity.
    UnknownQuantity(Quantity),
    /// Forward dynamics: constraints or actuators are redundant, as are the constraints of a planar
    /// linkage of revolute joints, so that reactions are not unique.
    Redundant,
    /// Forward dynamics: bodies have local passive DOFs.
    IdleSpins,
    /// Forward dynamics: the numbers of actuators and prescribed coordinates differ or are zero.
    ActuatorCount {
        /// Number of actuators.
        actuators: usize,
        /// Number of prescribed coordinates.
        coordinates: usize,
    },
    /// Forward dynamics: rotors and motor friction of drive trains are not included.
    DriveTrains,
    /// Forward dynamics: an actuated coordinate has no inertia.
    NoInertia,
    /// The program does not reproduce the solver's results at states other than those of the
    /// recording.
    NotConfirmed,
}

impl fmt::Display for RecordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::EmptyCourse => write!(f, "there are no positions to record a program at"),
            Self::Signal { position, error } => {
                write!(f, "position {position} of the course (counted from 0): {error}")
            }
            Self::NoPlan => write!(
                f,
                "the position is singular, or both constraints and actuators are redundant"
            ),
            Self::NoQuantity => write!(f, "there is no quantity to differentiate by"),
            Self::UnknownQuantity(quantity) => write!(f, "the mechanism has no {quantity:?}"),
            Self::Redundant => write!(
                f,
                "constraints or actuators are redundant, so that reactions are not unique; programs of forward \
                 dynamics need them to be"
            ),
            Self::IdleSpins => {
                write!(f, "bodies can spin idly; programs of forward dynamics know no such spins")
            }
            Self::ActuatorCount { actuators, coordinates } => write!(
                f,
                "programs of forward dynamics need as many actuators as prescribed coordinates, and at least one: \
                 there are {actuators} and {coordinates}"
            ),
            Self::DriveTrains => {
                write!(
                    f,
                    "programs of forward dynamics do not include drive trains; use the solver"
                )
            }
            Self::NoInertia => write!(f, "something to be driven has no inertia"),
            Self::NotConfirmed => {
                write!(f, "the program does not find what the solver finds; use the solver")
            }
        }
    }
}

impl core::error::Error for RecordError {
    fn source(&self) -> Option<&(dyn core::error::Error + 'static)> {
        match self {
            Self::Signal { error, .. } => Some(error),
            _ => None,
        }
    }
}
