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
use crate::mechanism::JointId;
use crate::spatial::{Vec3, Wrench};
use nalgebra::DMatrix;

/// A body with so many joints is where legs end.
const HUB: usize = 3;

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

/// What a joint carries in a self-stress, predecessor on successor, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLoad {
    /// The joint.
    pub joint: JointId,
    /// Force, N.
    pub force: Vec3<f64>,
    /// Moment about the joint's origin, N m.
    pub moment: Vec3<f64>,
}

/// What the constraints of a mechanism alone hold at a position.
#[derive(Clone, Debug)]
pub struct Constraints {
    /// Singular values of the constraints' part of the scaled balance, one for each equation,
    /// largest first.
    singular_values: Vec<f64>,
    /// For each way in which constraints alone can load each other, their amounts in the order of
    /// the constraints, forces in N and moments in N m, the largest (over the length) being one.
    self_stresses: Vec<Vec<f64>>,
    /// The least resistance of the bodies of legs with the hubs held; none if there are no legs.
    legs: Option<Vec<f64>>,
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

        let own = Svd::new(&transposed.transpose());
        let scales = statics.column_scales();
        let self_stresses = own
            .null_space(own.rank(RANK_TOLERANCE))
            .iter()
            .map(|stress| {
                let largest = stress.amax();
                constraints
                    .iter()
                    .zip(stress.iter())
                    .map(|(&k, x)| x / largest * scales[k])
                    .collect()
            })
            .collect();

        let system = statics.system();
        let bodies = all.nrows() / 6;
        let rows: Vec<usize> = (0..bodies)
            .filter(|&body| system.joints_at(body + 1) < HUB)
            .flat_map(|body| 6 * body..6 * body + 6)
            .collect();
        let legs = (!rows.is_empty() && rows.len() < all.nrows()).then(|| {
            let held = transposed.select_columns(&rows);
            let mut values = Svd::new(&held).singular_values.as_slice().to_vec();
            values.resize(rows.len(), 0.0);
            values
        });
        Self { singular_values, self_stresses, legs }
    }

    /// For each way in which the constraints alone can load each other, the joints that take part
    /// and the wrenches there, without a scale.
    pub fn self_stresses(&self, statics: &Statics) -> Vec<Vec<JointLoad>> {
        let system = statics.system();
        let in_joints = |stress: &Vec<f64>| {
            let mut wrenches = vec![Wrench::zero(); statics.joint_origins().len()];
            for ((unknown, unit), amount) in
                system.unknowns.iter().zip(&system.wrenches).zip(stress)
            {
                wrenches[unknown.joint()] += *unit * *amount;
            }
            let size = |wrench: &Wrench<f64>, origin: Vec3<f64>| {
                wrench.force.norm() + wrench.moment_about(origin).norm() / statics.length()
            };
            let places = wrenches.iter().zip(statics.joint_origins()).enumerate();
            places
                .filter(|(_, (wrench, origin))| size(wrench, **origin) > 1e-9)
                .map(|(joint, (wrench, origin))| JointLoad {
                    joint: JointId(joint),
                    force: wrench.force,
                    moment: wrench.moment_about(*origin),
                })
                .collect()
        };
        self.self_stresses.iter().map(in_joints).collect()
    }

    /// Distance to a singularity of a leg (type 1): to a position where bodies between the hubs
    /// (bodies with three joints or more) can move while the hubs stand still, idle spins apart. None
    /// if there are no such bodies or no hubs.
    pub fn leg_distance(&self, idle_spins: usize) -> Option<f64> {
        let values = self.legs.as_ref()?;
        let held = values.len().checked_sub(idle_spins + 1)?;
        values.get(held).copied()
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
