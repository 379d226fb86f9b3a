//! Singularity indices of a position.
//!
//! The measure is a singular value of the balance of all bodies, made dimensionless with the
//! characteristic length: joint forces count in newtons, moments (about the joint's origin, and
//! about each body's centre of mass) in newtons times that length. At an index `d`, some unit
//! motion of the bodies meets a resistance of at most `d` per unit of generalised force. The index
//! does not depend on units, the order of bodies, the base, or the choice of cut joints.
//!
//! Equation (M5) of the book's theory.

use super::newton_euler::{NewtonEuler, Unknown};
use super::rank::{RANK_TOLERANCE, Statics};
use crate::joint::JointType;
use crate::linalg::{Svd, smallest_singular_value};
use crate::mechanism::JointId;
use crate::spatial::{Vec3, Wrench};
use nalgebra::{DMatrix, DVector};

/// Minimum number of joints of a hub, a body at which legs end.
const HUB: usize = 3;

/// Singularity indices at a position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// Type 2 (actuation) singularity index: zero if a motion other than passive spins is resisted
    /// by neither constraints nor actuators.
    pub actuation: f64,
    /// Constraint singularity index: zero if the constraints leave more motions than the generic
    /// mobility.
    pub constraint: f64,
}

impl Distances {
    /// Computes the indices for a balance with equal numbers of unknowns and equations: no
    /// redundancy, no passive spins, and one actuator per degree of freedom. Much faster than dense
    /// decompositions.
    pub(super) fn of_square(system: &NewtonEuler, joint_types: &[JointType]) -> Self {
        let scaled = system.scaled_matrix(joint_types);
        let is_constraint = |k: &usize| !matches!(system.unknowns[*k], Unknown::Drive { .. });
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

    /// Computes the indices by dense decompositions: `mobility` is the generic mobility of the
    /// constraints, `idle_spins` the number of passive spins in it.
    pub fn new(statics: &Statics, mobility: usize, idle_spins: usize) -> Self {
        Self {
            actuation: statics.actuation_distance(idle_spins),
            constraint: Constraints::new(statics).distance(mobility),
        }
    }
}

/// The load of a joint in a self-stress, predecessor on successor, world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLoad {
    /// The joint.
    pub joint: JointId,
    /// Force, N.
    pub force: Vec3<f64>,
    /// Moment about the joint's origin, N m.
    pub moment: Vec3<f64>,
}

/// Constraints of a mechanism at a position, gearings included, without actuators.
#[derive(Clone, Debug)]
pub struct Constraints<'a> {
    statics: &'a Statics,
    /// Indices of the constraints among the unknowns of the balance.
    unknowns: Vec<usize>,
    /// Constraint part of the scaled balance: a row for each constraint, a column for each
    /// equation.
    transposed: DMatrix<f64>,
    /// Singular values of this part, one for each equation, largest first.
    singular_values: Vec<f64>,
}

impl<'a> Constraints<'a> {
    /// Extracts the constraints of a decomposed balance.
    pub fn new(statics: &'a Statics) -> Self {
        let all = statics.scaled_matrix();
        let unknowns: Vec<usize> = (0..all.ncols())
            .filter(|&k| !matches!(statics.system().unknowns[k], Unknown::Drive { .. }))
            .collect();
        let transposed = all.select_columns(&unknowns).transpose();
        let singular_values = one_for_each_column(&transposed);
        Self { statics, unknowns, transposed, singular_values }
    }

    pub(super) fn statics(&self) -> &Statics {
        self.statics
    }

    /// Returns a row for each constraint, a column for each equation of the scaled balance.
    pub(super) fn transposed(&self) -> &DMatrix<f64> {
        &self.transposed
    }

    /// Basis of the self-stress states (null space of the equilibrium matrix): for each the loaded
    /// joints and their wrenches, unscaled.
    pub fn self_stresses(&self) -> Vec<Vec<JointLoad>> {
        self.stress_vectors().iter().map(|stress| self.loads(&(stress / stress.amax()))).collect()
    }

    /// Orthonormal basis of the self-stresses, as scaled values of [`Self::unknowns`].
    pub(crate) fn stress_vectors(&self) -> Vec<DVector<f64>> {
        let own = Svd::new(&self.transposed.transpose());
        own.null_space(own.rank(RANK_TOLERANCE))
    }

    /// The unknowns that are constraints.
    pub(crate) fn unknowns(&self) -> impl Iterator<Item = Unknown> + '_ {
        self.unknowns.iter().map(|&k| self.statics.system().unknowns[k])
    }

    /// Converts scaled values of [`Self::unknowns`] to N and N m.
    pub(crate) fn amounts(&self, scaled: &DVector<f64>) -> Vec<f64> {
        let scales = self.unknowns.iter().map(|&k| self.statics.column_scales()[k]);
        scales.zip(scaled.iter()).map(|(scale, amount)| scale * amount).collect()
    }

    /// Wrenches of the loaded joints for scaled values of [`Self::unknowns`].
    pub(crate) fn loads(&self, scaled: &DVector<f64>) -> Vec<JointLoad> {
        let (statics, system) = (self.statics, self.statics.system());
        let mut wrenches = vec![Wrench::zero(); statics.joint_origins().len()];
        let amounts = self.amounts(scaled);
        for unit in &system.wrenches {
            // Efforts are no constraints.
            if let Ok(own) = self.unknowns.binary_search(&unit.unknown) {
                wrenches[unit.joint] += unit.wrench * amounts[own];
            }
        }
        let places = wrenches.iter().zip(statics.joint_origins()).enumerate();
        let size = |load: &JointLoad| load.force.norm() + load.moment.norm() / statics.length();
        let loads: Vec<JointLoad> = places
            .map(|(joint, (wrench, origin))| JointLoad {
                joint: JointId(joint),
                force: wrench.force,
                moment: wrench.moment_about(origin),
            })
            .collect();
        let most = loads.iter().map(size).fold(0.0, f64::max);
        loads.into_iter().filter(|load| size(load) > 1e-9 * most).collect()
    }

    /// Type 1 (leg) singularity index: zero if bodies between the hubs (bodies with three or more
    /// joints) can move with fixed hubs, apart from passive spins. `None` without such bodies or
    /// hubs.
    pub fn leg_distance(&self, idle_spins: usize) -> Option<f64> {
        let of_legs = of_legs(self.statics.system());
        if of_legs.is_empty() || of_legs.len() == self.transposed.ncols() {
            return None;
        }
        let values = one_for_each_column(&self.transposed.select_columns(&of_legs));
        let last = values.len().checked_sub(idle_spins + 1)?;
        Some(zero_or(&values, last))
    }

    /// Instantaneous mobility of the constraints at this position.
    pub fn mobility(&self) -> usize {
        let largest = self.singular_values.first().copied().unwrap_or(0.0);
        self.singular_values.iter().filter(|&&s| s <= RANK_TOLERANCE * largest).count()
    }

    /// Constraint singularity index: zero if the constraints leave more than `mobility` motions.
    pub fn distance(&self, mobility: usize) -> f64 {
        let held = self.singular_values.len().saturating_sub(mobility);
        held.checked_sub(1).map_or(1.0, |last| zero_or(&self.singular_values, last))
    }
}

/// The singular value with this index; zero if the matrix has fewer singular values.
fn zero_or(values: &[f64], index: usize) -> f64 {
    let largest = values.first().copied().unwrap_or(0.0);
    values.get(index).copied().filter(|value| *value > RANK_TOLERANCE * largest).unwrap_or(0.0)
}

/// Rows of the equations of the bodies between hubs.
pub(super) fn of_legs(system: &NewtonEuler) -> Vec<usize> {
    (0..system.matrix.nrows() / 6)
        .filter(|&body| system.joints_at(body + 1) < HUB)
        .flat_map(|body| 6 * body..6 * body + 6)
        .collect()
}

/// Singular values of a matrix, largest first, one per column.
fn one_for_each_column(matrix: &DMatrix<f64>) -> Vec<f64> {
    Svd::new(matrix).singular_values.as_slice().to_vec()
}

impl Statics {
    /// Type 2 (actuation) singularity index: zero if a motion other than passive spins is resisted
    /// by neither constraints nor actuators.
    pub fn actuation_distance(&self, idle_spins: usize) -> f64 {
        let resisted = self.system().matrix.nrows().saturating_sub(idle_spins);
        match resisted.checked_sub(1) {
            None => 1.0,
            Some(last) => zero_or(self.singular_values(), last),
        }
    }
}
