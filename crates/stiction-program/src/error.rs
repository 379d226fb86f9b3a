//! Errors that occur when a program is recorded or written as source code.

use crate::quantity::Quantity;
use crate::tunable::Tunable;
use core::fmt;
use stiction_core::kinematics::AssemblyError;

/// Error: no program can be recorded for a mechanism, or its source code cannot be generated. The
/// solver remains usable.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum RecordError {
    /// The signal contains no position.
    EmptySignal,
    /// The solver cannot follow the signal to one of its positions, or to a sample near this
    /// position.
    Signal {
        /// Index of the position in the signal.
        position: usize,
        /// Error of the solver.
        error: AssemblyError,
    },
    /// The solver cannot determine a fixed order of elimination: the position is singular, or both
    /// constraints and actuators are redundant.
    NoPlan,
    /// The list of quantities for derivatives is empty.
    NoQuantity,
    /// Source code with derivatives was requested of a program without them, see
    /// [`crate::Feedforward::with_derivatives`].
    NoDerivatives,
    /// The mechanism or the motion does not have this quantity.
    UnknownQuantity(Quantity),
    /// The mechanism does not have this parameter, or the parameter is a payload on a body without
    /// mass.
    NoTunable(Tunable),
    /// A number of the program is too large for the precision of its source code.
    TooLarge(f64),
    /// The mechanism has rigid gearings of joints, which programs do not support.
    Gearings,
    /// Forward dynamics: constraints or actuators are redundant, as are the constraints of a planar
    /// linkage of revolute joints, so that reactions are not unique.
    Redundant,
    /// Forward dynamics: bodies have local passive degrees of freedom, which the program does not
    /// support.
    IdleSpins,
    /// Forward dynamics: the numbers of actuators and prescribed coordinates differ or are zero.
    ActuatorCount {
        /// Number of actuators.
        actuators: usize,
        /// Number of prescribed coordinates.
        coordinates: usize,
    },
    /// Forward dynamics: the mechanism has drive trains, whose rotors and motor friction the
    /// program does not include.
    DriveTrains,
    /// Forward dynamics: an actuated coordinate has no inertia.
    NoInertia,
    /// The program does not reproduce the solver's results at states other than those of the
    /// recording.
    NotConfirmed,
    /// There is no machine code for this processor, and an interpreted program would be slower than
    /// the kernels.
    NotNative,
}

impl fmt::Display for RecordError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::EmptySignal => {
                write!(f, "the signal is empty: recording a program needs at least one position")
            }
            Self::Signal { position, error } => {
                write!(f, "position {position} of the signal (counted from 0): {error}")
            }
            Self::NoPlan => write!(
                f,
                "the position is singular, or both constraints and actuators are redundant"
            ),
            Self::NoQuantity => write!(f, "no quantity for the derivatives is given"),
            Self::NoDerivatives => write!(f, "the program was recorded without derivatives"),
            Self::UnknownQuantity(quantity) => write!(f, "the mechanism has no {quantity:?}"),
            Self::NoTunable(tunable) => {
                write!(f, "the mechanism has no {tunable:?}, or its body has no mass")
            }
            Self::TooLarge(number) => {
                write!(
                    f,
                    "the code would contain the number {number:e}, which is too large for \
                    its floating-point type"
                )
            }
            Self::Gearings => {
                write!(f, "programs do not support gearings between joints; use the general solver")
            }
            Self::Redundant => write!(
                f,
                "constraints or actuators are redundant, so that reactions are not unique; \
                 programs of forward dynamics need unique reactions"
            ),
            Self::IdleSpins => {
                write!(
                    f,
                    "bodies have local degrees of freedom, which programs of forward \
                           dynamics do not support"
                )
            }
            Self::ActuatorCount { actuators, coordinates } => write!(
                f,
                "forward dynamics needs as many actuators as prescribed coordinates, and at least one: \
                 there are {actuators} actuators and {coordinates} prescribed coordinates"
            ),
            Self::DriveTrains => {
                write!(
                    f,
                    "programs of forward dynamics do not support drive trains; use the general solver"
                )
            }
            Self::NoInertia => write!(f, "an actuated coordinate has no inertia"),
            Self::NotConfirmed => {
                write!(
                    f,
                    "the recorded program does not reproduce the results of the solver; use the \
                     solver"
                )
            }
            Self::NotNative => write!(f, "programs have no machine code for this processor"),
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
