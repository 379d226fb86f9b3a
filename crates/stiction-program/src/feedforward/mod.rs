//! Program of inverse dynamics for a control loop: computes actuator forces from prescribed
//! coordinates, and also solves the loop closure.
//!
//! The program has five routines. The first computes the errors of the loop closures, and the
//! second corrects the position; both are repeated. The other three routines are those of
//! [`InverseProgram`](crate::InverseProgram): everything that does not depend on friction,
//! including the rates and accelerations of the loops; a Newton step for the friction forces, which
//! is repeated; and the forces.
//!
//! The routines serve two purposes: [`crate::emit`] writes them as source code, and
//! [`Feedforward::run`] executes them.

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

/// Recorded routines of one mechanism, from prescribed coordinates to actuator forces.
#[derive(Debug)]
pub struct Feedforward {
    sizes: FeedforwardSizes,
    /// Characteristic length, m.
    length: f64,
    /// Tree coordinates and prescribed values at the home position.
    home: (Vec<f64>, Vec<f64>),
    tunables: Vec<(Tunable, Vec<f64>)>,
    /// Slots of the unknowns of the coupling.
    pub(crate) unknown_slots: Vec<u32>,
    /// Data of the singularity index.
    pub(crate) index: IndexLayout,
    /// Routines without fused operations, for source code.
    pub(crate) source: Routines,
    /// Force routines for source code that return the complete wrench of each joint instead of only
    /// the joint force. The first routine also returns the wrenches without friction.
    pub(crate) wrenches: [Routine; 3],
    /// Routines of the poses and of the twists of all bodies except the ground, for source code;
    /// each has slots of its own. Inputs: tree coordinates, value and rate of each prescribed
    /// coordinate. The last result is the guard.
    pub(crate) kinematics: [Routine; 2],
    /// Derivatives, if requested.
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
    /// Number of coordinates of the spanning tree, which are the starting values of the loop
    /// closure.
    pub coordinates: usize,
    /// Number of values of all tunable parameters.
    pub tunables: usize,
    /// Number of unknowns of the coupled friction forces and reactions.
    pub unknowns: usize,
}

/// Code of one routine, and the slots of its results.
#[derive(Clone, Debug)]
pub(crate) struct Routine {
    pub(crate) parts: Vec<Part>,
    /// Slots of the results.
    pub(crate) results: Vec<u32>,
}

/// Position routines and force routines. The first slots of each group hold the inputs.
#[derive(Clone, Debug)]
pub(crate) struct Routines {
    /// Two routines: errors of the loop closures, and a correction. Both have the tree coordinates
    /// and the prescribed values as inputs. The first returns the sum of the squares of all errors,
    /// and the guard; the second returns the corrected coordinates.
    pub(crate) position: [Routine; 2],
    pub(crate) position_slots: usize,
    /// Three routines: preparation, Newton step, and forces. Their inputs are the tree coordinates,
    /// the tunable parameters, the value, rate and acceleration of each prescribed coordinate, and
    /// the unknowns of the coupled friction. The preparation returns initial unknowns, frictionless
    /// actuator forces, their guard, the determinant of the rate equations relative to that at the
    /// home position, and for source code the positions for the singularity index. The Newton step
    /// returns the next unknowns and three numbers that control convergence. The last routine
    /// returns actuator forces, the force of each joint, and the guard.
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

    /// Prescribed values, m or rad, at the home position, where the loops are closed first.
    pub fn home(&self) -> &[f64] {
        &self.home.1
    }

    /// True if the code contains derivatives, see [`Self::with_derivatives`].
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

    /// Numbers of arithmetic operations: of the loop errors, of a position correction, of the
    /// preparation, of a Newton step for the friction forces, and of the forces.
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

    /// Fingerprint of the recorded functions and their numbers. Equal models have equal fingerprints.
    pub fn fingerprint(&self) -> u64 {
        // FNV-1a (Fowler, Noll, Vo), 64 bits.
        let text = format!("{:?} {:?} {:?}", self.source, self.home, self.tunables);
        text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
            (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3)
        })
    }
}
