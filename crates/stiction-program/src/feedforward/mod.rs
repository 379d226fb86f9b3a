//! Program of inverse dynamics for a control loop: from prescribed coordinates to actuator forces,
//! positions included.
//!
//! The program has five routines. The first computes the errors of the loop closures, the second
//! corrects the position, and both are repeated. The other three are those of
//! [`InverseProgram`](crate::InverseProgram): everything that does not depend on friction, a Newton
//! step of the coupling, which is repeated, and the forces. Rates and accelerations of the loops
//! are part of the third.
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
    /// Tree coordinates and prescribed values at home.
    home: (Vec<f64>, Vec<f64>),
    tunables: Vec<(Tunable, Vec<f64>)>,
    /// Slots of the unknowns of the coupling.
    pub(crate) unknown_slots: Vec<u32>,
    /// Data of the singularity index.
    pub(crate) index: IndexLayout,
    /// Routines without fused operations, for source code.
    pub(crate) source: Routines,
    /// Force routines for source code that return the complete wrench of each joint instead of its
    /// force. The first of them also returns the wrenches without friction.
    pub(crate) wrenches: [Routine; 3],
    /// Poses and twists of all bodies except the ground, for source code; each routine has its own slots. Inputs:
    /// tree coordinates, value and rate of each prescribed coordinate. Last result: the guard.
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
    /// Number of coordinates of the spanning tree, which are the state of the loops.
    pub coordinates: usize,
    /// Number of values of all tunable parameters.
    pub tunables: usize,
    /// Number of unknowns of the coupling of friction and reactions.
    pub unknowns: usize,
}

/// Code, and the slots of its results.
#[derive(Clone, Debug)]
pub(crate) struct Routine {
    pub(crate) parts: Vec<Part>,
    /// Slots of the results.
    pub(crate) results: Vec<u32>,
}

/// The position routines and the force routines. Each group has its own slots, the first of which
/// hold the inputs.
#[derive(Clone, Debug)]
pub(crate) struct Routines {
    /// Two routines: errors of the loop closures, and a correction. Inputs of both: tree
    /// coordinates, prescribed values. Results of the errors: the sum of the squares of all errors,
    /// and the guard. Results of the correction: the corrected coordinates.
    pub(crate) position: [Routine; 2],
    pub(crate) position_slots: usize,
    /// Three routines: preparation, Newton step, and forces. Inputs of all: tree coordinates,
    /// tunable parameters, value, rate and acceleration of each prescribed coordinate, unknowns of
    /// the coupling. Results of the preparation: initial unknowns, frictionless actuator forces,
    /// their guard, the determinant of the rate equations relative to that at home, and for source
    /// code the positions for the singularity index. Results of the Newton step: next unknowns and
    /// the three control values. Results of the forces: actuator forces, force of each joint,
    /// guard.
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

    /// Prescribed values at home, the position from which the loops are closed first, m or rad.
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

    /// Tree coordinates at home.
    pub(crate) fn home_coordinates(&self) -> &[f64] {
        &self.home.0
    }

    /// Number of arithmetic operations: of the loop errors, of a correction, of the preparation,
    /// of a Newton step of the coupling, and of the forces.
    pub fn operations(&self) -> [usize; 5] {
        self.operations_with(false)
    }

    /// Number of operations, as in [`Self::operations`], optionally with the wrenches of all joints.
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
