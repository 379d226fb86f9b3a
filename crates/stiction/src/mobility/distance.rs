//! How far a position is from a singular one.
//!
//! The measure is a singular value of the balance of all bodies, made free of units by the
//! characteristic length: forces at joints count in newtons, moments (about the joint's origin, and
//! about each body's centre of mass) in newtons times that length. A distance `d` says: there is a
//! motion of the bodies, of size one, that is resisted by joint forces of no more than `d` for each
//! unit of generalised force. It does not depend on units, on the order of bodies, on the base, or
//! on which joints are cut.

use super::statics::{RANK_TOLERANCE, Statics};
use crate::dynamics::newton_euler::{NewtonEuler, Unknown};
use crate::joint::JointType;
use crate::linalg::{Svd, smallest_singular_value};
use nalgebra::DMatrix;

/// Both distances at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// To a singularity of actuation (type 2): a position where some motion, idle spins apart, is
    /// resisted neither by a constraint nor by an actuator.
    pub actuation: f64,
    /// To a singularity of constraint: a position where the constraints leave more motions than the
    /// mechanism is meant to have.
    pub constraint: f64,
}

impl Distances {
    /// For a balance that has as many unknowns as equations: nothing redundant, no idle spins, and
    /// just as many actuators as freedoms. Much faster than by decompositions.
    pub fn of_square(system: &NewtonEuler, joint_types: &[JointType]) -> Self {
        let scaled = system.scaled_matrix(joint_types);
        let is_constraint = |k: &usize| matches!(system.unknowns[*k], Unknown::Constraint { .. });
        let constraints: Vec<usize> = (0..scaled.ncols()).filter(is_constraint).collect();
        let only_constraints = scaled.select_columns(&constraints);
        Self {
            actuation: smallest_singular_value(&scaled),
            constraint: if constraints.is_empty() {
                1.0
            } else {
                smallest_singular_value(&only_constraints)
            },
        }
    }

    /// From decompositions: `mobility` is how many motions the constraints are meant to leave,
    /// `idle_spins` how many of them are spins that nothing resists.
    pub fn new(statics: &Statics, mobility: usize, idle_spins: usize) -> Self {
        Self {
            actuation: statics.actuation_distance(idle_spins),
            constraint: Constraints::new(statics).distance(mobility),
        }
    }
}

/// What the constraints of a mechanism alone hold at a position.
#[derive(Clone, Debug)]
pub struct Constraints {
    /// Singular values of the constraints' part of the scaled balance, one for each equation,
    /// largest first.
    singular_values: Vec<f64>,
}

impl Constraints {
    /// Looks at the constraints of a decomposed balance.
    pub fn new(statics: &Statics) -> Self {
        let all = statics.scaled_matrix();
        let constraints: Vec<usize> = (0..all.ncols())
            .filter(|&k| matches!(statics.system().unknowns[k], Unknown::Constraint { .. }))
            .collect();
        // Transposed: as many singular values as there are equations.
        let transposed =
            DMatrix::from_fn(constraints.len(), all.nrows(), |i, j| all[(j, constraints[i])]);
        let mut singular_values = Svd::new(&transposed).singular_values.as_slice().to_vec();
        singular_values.resize(all.nrows(), 0.0);
        Self { singular_values }
    }

    /// How many independent motions the constraints leave at this position.
    pub fn mobility(&self) -> usize {
        let largest = self.singular_values.first().copied().unwrap_or(0.0);
        self.singular_values.iter().filter(|&&s| s <= RANK_TOLERANCE * largest).count()
    }

    /// Distance to a singularity of constraint: to a position where the constraints leave more than
    /// `mobility` motions. Zero where they do.
    pub fn distance(&self, mobility: usize) -> f64 {
        let held = self.singular_values.len().saturating_sub(mobility);
        held.checked_sub(1).map_or(1.0, |last| self.singular_values[last])
    }
}

impl Statics {
    /// Distance to a singularity of actuation (type 2): to a position where some motion, idle spins
    /// apart, is resisted neither by a constraint nor by an actuator.
    pub fn actuation_distance(&self, idle_spins: usize) -> f64 {
        let resisted = self.system().matrix.nrows().saturating_sub(idle_spins);
        match resisted.checked_sub(1) {
            None => 1.0,
            Some(last) => self.singular_values().get(last).copied().unwrap_or(0.0),
        }
    }
}
