//! Why a mechanism has no program.

use crate::quantity::Quantity;
use core::fmt;
use stiction_core::kinematics::AssemblyError;

/// Why a mechanism has no program. Its solver serves it nevertheless.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RecordError {
    /// There are no positions to record at.
    EmptyCourse,
    /// The solver cannot be brought to a position of the course, or beside it.
    Signal {
        /// Its place in the course.
        position: usize,
        /// Why.
        error: AssemblyError,
    },
    /// The kernel has no plan: the solver's position is singular, or both constraints and actuators are redundant.
    NoPlan,
    /// There is no quantity to differentiate by.
    NoQuantity,
    /// A quantity that the mechanism does not have.
    UnknownQuantity(Quantity),
    /// Forward dynamics: constraints or actuators are redundant, as constraints are in a planar linkage of revolute
    /// joints, so that reactions are not unique.
    Redundant,
    /// Forward dynamics: bodies can spin idly.
    IdleSpins,
    /// Forward dynamics: there are more or fewer actuators than prescribed coordinates, or none.
    ActuatorCount {
        /// Actuators.
        actuators: usize,
        /// Prescribed coordinates.
        coordinates: usize,
    },
    /// Forward dynamics: something to be driven has no inertia.
    NoInertia,
    /// At other states than those from which it was made the program does not find what the solver finds.
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
