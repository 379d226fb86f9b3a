//! Program of inverse dynamics for a control loop, which computes actuator forces from prescribed
//! coordinates. In contrast to [`InverseProgram`](crate::InverseProgram), it also closes the loops.
//!
//! The program has five routines. The first computes the closure errors of the loops, and the
//! second corrects the position; both are repeated until the loops are closed. The other three
//! routines are those of [`InverseProgram`](crate::InverseProgram). The third computes everything
//! that does not depend on friction, including the rates and accelerations of the loops. The fourth
//! is a Newton step for the friction forces, which is repeated, and the fifth computes the forces.
//!
//! [`crate::emit`] writes these routines as source code, and [`Feedforward::run`] executes them.

mod derivatives;
mod index_layout;
mod kinematics;
mod record;
mod run;

pub(crate) use derivatives::Derivatives;
pub(crate) use index_layout::{INDEX_PASSES, IndexLayout, Term};
pub(crate) use run::{CLOSED, CORRECTIONS, DONE};
pub use run::{FeedforwardMemory, Outcome, Shortfall};

use crate::code::Part;
use crate::compiled::Compiled;
use crate::tunable::Tunable;

/// Recorded program of inverse dynamics for one mechanism: closes the loops at prescribed
/// coordinates, and computes the actuator forces. It can be executed or written as source code.
#[derive(Debug)]
pub struct Feedforward {
    sizes: FeedforwardSizes,
    /// Characteristic length, m.
    length: f64,
    /// Tree coordinates and prescribed values at the home position.
    home: (Vec<f64>, Vec<f64>),
    tunables: Vec<(Tunable, Vec<f64>)>,
    /// Slots of the unknowns of the coupled friction forces and reactions.
    pub(crate) unknown_slots: Vec<u32>,
    /// Data with which source code computes the singularity index.
    pub(crate) index: IndexLayout,
    /// Routines without fused operations, for source code.
    pub(crate) source: Routines,
    /// Force routines for source code that return the complete wrench of each joint instead of only
    /// the joint force. The first routine also returns the wrenches without friction.
    pub(crate) wrenches: [Routine; 3],
    /// Routines of the poses and of the twists of all bodies except the ground, for source code;
    /// each has slots of its own. Inputs are the tree coordinates, and the value and rate of each
    /// prescribed coordinate. The last result is a guard, which is positive while the assumptions
    /// made at recording hold.
    pub(crate) kinematics: [Routine; 2],
    /// Routines of the derivatives of actuator forces, if requested.
    pub(crate) derivatives: Option<Derivatives>,
    /// Routines for execution on this processor.
    native: Routines,
    code: (Compiled<2>, Compiled<3>),
}

/// Numbers of inputs and results of a [`Feedforward`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FeedforwardSizes {
    /// Number of prescribed coordinates.
    pub prescribed: usize,
    /// Number of actuators.
    pub drives: usize,
    /// Number of joints.
    pub joints: usize,
    /// Number of bodies, without the ground.
    pub bodies: usize,
    /// Number of coordinates of the spanning tree. The loop closure starts from their last values.
    pub coordinates: usize,
    /// Number of values of all tunable parameters.
    pub tunables: usize,
    /// Number of unknowns of the coupled friction forces and reactions.
    pub unknowns: usize,
}

/// Compiled code of one routine, and the slots of its results.
#[derive(Clone, Debug)]
pub(crate) struct Routine {
    pub(crate) parts: Vec<Part>,
    /// Slots of the results.
    pub(crate) results: Vec<u32>,
}

/// Position routines and force routines. The first slots of each group contain the inputs. Guards
/// among the results are positive while the assumptions made at recording hold.
#[derive(Clone, Debug)]
pub(crate) struct Routines {
    /// Two routines: closure errors of the loops, and a correction of the position. Both have the
    /// tree coordinates and the prescribed values as inputs. The first returns the sum of the
    /// squares of all errors, and a guard; the second returns the corrected coordinates.
    pub(crate) position: [Routine; 2],
    pub(crate) position_slots: usize,
    /// Three routines: preparation, Newton step, and forces. Their inputs are the tree coordinates,
    /// the tunable parameters, the value, rate and acceleration of each prescribed coordinate, and
    /// the unknowns of the coupled friction. The preparation returns initial unknowns, frictionless
    /// actuator forces, their guard, the determinant of the rate equations relative to that at the
    /// home position, and for source code the geometric data for the singularity index. The Newton
    /// step returns the next unknowns and three numbers that control convergence. The last routine
    /// returns actuator forces, the force of each joint, and a guard.
    pub(crate) forces: [Routine; 3],
    pub(crate) force_slots: usize,
}

impl Routine {
    fn operations(&self) -> usize {
        self.parts.iter().map(Part::operations).sum()
    }
}

impl Feedforward {
    /// Numbers of inputs and results.
    pub fn sizes(&self) -> FeedforwardSizes {
        self.sizes
    }

    /// Tunable parameters with their values in the model; loads come last.
    pub fn tunables(&self) -> &[(Tunable, Vec<f64>)] {
        &self.tunables
    }

    /// Prescribed values, m or rad, at the home position: the first position of the recorded
    /// signal. New memory starts with the loops closed at this position.
    pub fn home(&self) -> &[f64] {
        &self.home.1
    }

    /// Returns true if the program contains derivatives, see [`Self::with_derivatives`].
    pub fn has_derivatives(&self) -> bool {
        self.derivatives.is_some()
    }

    /// Characteristic length, m.
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    /// Tree coordinates at the home position.
    pub(crate) fn home_coordinates(&self) -> &[f64] {
        &self.home.0
    }

    /// Numbers of arithmetic operations of the five routines: closure errors of the loops, position
    /// correction, preparation, Newton step for the friction forces, and forces.
    pub fn operations(&self) -> [usize; 5] {
        self.operations_with(false)
    }

    /// Numbers of operations, as in [`Self::operations`], with the wrenches of all joints if
    /// `wrenches` is true.
    pub(crate) fn operations_with(&self, wrenches: bool) -> [usize; 5] {
        let [a, b] = &self.source.position;
        let [c, d, e] = if wrenches { &self.wrenches } else { &self.source.forces };
        [a, b, c, d, e].map(Routine::operations)
    }

    /// Fingerprint of the program: a hash of its routines, home position and tunable parameters.
    /// Equal models have equal fingerprints.
    pub fn fingerprint(&self) -> u64 {
        // FNV-1a (Fowler, Noll, Vo), 64 bits.
        let text = format!("{:?} {:?} {:?}", self.source, self.home, self.tunables);
        text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
    }
}
