//! Singularity indices of a configuration.
//!
//! An index is a singular value of the matrix of force and moment balances of all bodies. The
//! matrix is made dimensionless with the characteristic length: joint forces are in newtons,
//! moments (about the joint's origin, and about each body's centre of mass) in newtons times that
//! length. If an index is `d`, there is a unit motion of the bodies along which joint forces of
//! unit norm exert a generalised force of at most `d`. The index does not depend on units, the
//! order of bodies, the pose of the base, or the choice of cut joints.
//!
//! Equation (M5) of the book's theory.

use super::newton_euler::{NewtonEuler, Unknown};
use super::rank::{RANK_LIMIT, Statics};
use crate::joint::JointType;
use crate::linalg::{Decomposition, SparseMatrix, Svd, smallest_singular_value};
use crate::mechanism::JointId;
use crate::spatial::Vec3;
use nalgebra::DVector;
use std::sync::OnceLock;

/// Minimum number of joints in loops of a hub: a body, such as a platform, at which legs end.
const HUB: usize = 3;

/// Singularity indices of a mechanism at one configuration, dimensionless.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Distances {
    /// Type 2 (actuation) singularity index: zero if neither constraints nor actuators resist a
    /// motion other than passive spins.
    pub actuation: f64,
    /// Constraint singularity index: zero if the constraints permit more motions than in a generic
    /// configuration.
    pub constraint: f64,
}

impl Distances {
    /// Computes the indices from balance equations with as many unknowns as equations: without
    /// redundancy, without passive spins, and with one actuator per degree of freedom. This is much
    /// faster than dense decompositions.
    pub(super) fn of_square(system: &NewtonEuler, joint_types: &[JointType]) -> Self {
        let scaled = system.scaled_matrix(joint_types).to_dense();
        let constraints = constraints_of(system);
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

    /// Computes the indices by dense decompositions. `mobility` is the generic mobility of the
    /// constraints; `idle_spins` is the number of passive spins, which this mobility includes.
    pub fn new(statics: &Statics, mobility: usize, idle_spins: usize) -> Self {
        Self {
            actuation: statics.actuation_distance(idle_spins),
            constraint: Constraints::new(statics).distance(mobility),
        }
    }
}

/// Reaction of a joint in a self-stress state, exerted by the predecessor on the successor, in
/// world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLoad {
    /// Joint with this reaction.
    pub joint: JointId,
    /// Force, N.
    pub force: Vec3<f64>,
    /// Moment about the joint's origin, N m.
    pub moment: Vec3<f64>,
}

/// Constraints of a mechanism at a configuration, including gearings but no actuators.
#[derive(Clone, Debug)]
pub struct Constraints<'a> {
    statics: &'a Statics,
    /// Indices of the constraints among the unknowns of [`NewtonEuler`].
    unknowns: Vec<usize>,
    /// Transposed constraint columns of the scaled balance matrix, with one row for each constraint
    /// and one column for each equation.
    matrix: SparseMatrix,
    /// Decomposition of `matrix`, which is computed at its first use.
    transposed: OnceLock<Decomposition>,
}

impl<'a> Constraints<'a> {
    /// Extracts the constraints from the decomposed balance equations of all bodies.
    pub fn new(statics: &'a Statics) -> Self {
        let all = statics.scaled_matrix();
        let unknowns = constraints_of(statics.system());
        let matrix = all.select_columns(&unknowns).transpose();
        Self { statics, unknowns, matrix, transposed: OnceLock::new() }
    }

    /// Returns the balance of which these are the constraints.
    pub fn statics(&self) -> &Statics {
        self.statics
    }

    /// Returns the decomposition of the transposed constraints: a row for each constraint, a column
    /// for each equation of the scaled balance.
    pub(super) fn transposed(&self) -> &Decomposition {
        self.transposed.get_or_init(|| {
            let bodies = self.statics.system().bodies_of_rows();
            Decomposition::new(self.matrix.clone(), &bodies, RANK_LIMIT)
        })
    }

    /// Computes a basis of the self-stress states (null space of the equilibrium matrix). Each
    /// state consists of the loaded joints and their wrenches, in N and N m.
    pub fn self_stresses(&self) -> Vec<Vec<JointLoad>> {
        let own = self.equilibrium();
        let each = own.null_space(own.rank()).into_iter().map(|mut stress| {
            let size = stress.iter().map(|(_, x)| x.abs()).fold(0.0, f64::max);
            stress.iter_mut().for_each(|(_, x)| *x /= size);
            self.loads(&stress)
        });
        each.collect()
    }

    /// Computes an orthonormal basis of the self-stress states, as scaled values of
    /// [`Self::unknowns`].
    pub(crate) fn stress_vectors(&self) -> Vec<DVector<f64>> {
        let own = self.equilibrium();
        own.orthonormal_null_space(own.rank()).dense()
    }

    /// Decomposes the equilibrium matrix, with one row for each equation and one column for each
    /// constraint.
    fn equilibrium(&self) -> Decomposition {
        let joints = self.statics.system().joints_of_unknowns();
        let joints: Vec<usize> = self.unknowns.iter().map(|&k| joints[k]).collect();
        Decomposition::new(self.matrix.transpose(), &joints, RANK_LIMIT)
    }

    /// Lists the unknowns of the balance that belong to constraints.
    pub(crate) fn unknowns(&self) -> impl Iterator<Item = Unknown> + '_ {
        self.unknowns.iter().map(|&k| self.statics.system().unknowns[k])
    }

    /// Converts scaled values of [`Self::unknowns`] to N and N m.
    pub(crate) fn amounts(&self, scaled: &DVector<f64>) -> Vec<f64> {
        let scales = self.unknowns.iter().map(|&k| self.statics.column_scales()[k]);
        scales.zip(scaled.iter()).map(|(scale, amount)| scale * amount).collect()
    }

    /// Computes the wrenches of the loaded joints from scaled values of [`Self::unknowns`].
    pub(crate) fn loads(&self, scaled: &[(usize, f64)]) -> Vec<JointLoad> {
        let statics = self.statics;
        let amounts = scaled.iter().map(|&(own, x)| {
            let unknown = self.unknowns[own];
            (unknown, statics.column_scales()[unknown] * x)
        });
        let wrenches = statics.system().sparse_wrenches(amounts);
        let size = |load: &JointLoad| load.force.norm() + load.moment.norm() / statics.length();
        let loads: Vec<JointLoad> = wrenches
            .into_iter()
            .map(|(joint, wrench)| JointLoad {
                joint: JointId(joint),
                force: wrench.force,
                moment: wrench.moment_about(statics.joint_origin(joint)),
            })
            .collect();
        let most = loads.iter().map(size).fold(0.0, f64::max);
        loads.into_iter().filter(|load| size(load) > 1e-9 * most).collect()
    }

    /// Computes the type 1 (leg) singularity index, see [`leg_distance`].
    pub fn leg_distance(&self, idle_spins: usize) -> Option<f64> {
        leg_distance(self.statics.system(), self.statics.scaled_matrix(), idle_spins)
    }

    /// Decomposes the transposed constraints, restricted to the columns `of_legs`: the equations of
    /// the bodies between hubs.
    pub(super) fn legs(&self, of_legs: &[usize]) -> Decomposition {
        // The six equations of each body form a group.
        let groups: Vec<usize> = (0..of_legs.len()).map(|k| k / 6).collect();
        let own = self.matrix.select_columns(of_legs);
        Decomposition::new(own, &groups, RANK_LIMIT)
    }

    /// Instantaneous mobility at this configuration: number of independent motions that the
    /// constraints permit.
    pub fn mobility(&self) -> usize {
        self.matrix.ncols() - self.transposed().rank()
    }

    /// Constraint singularity index: zero if the constraints permit more than `mobility` motions.
    pub fn distance(&self, mobility: usize) -> f64 {
        let held = self.matrix.ncols().saturating_sub(mobility);
        held.checked_sub(1).map_or(1.0, |last| zero_or(self.transposed(), last))
    }
}

/// Computes the type 1 (leg) singularity index from the balance of all bodies and its scaled matrix.
/// The index is zero if bodies between hubs can move, apart from passive spins, while the hubs are
/// fixed. Hubs are bodies at which three or more chains of loops meet. Returns `None` if the
/// mechanism has no hubs or no bodies between hubs.
pub fn leg_distance(system: &NewtonEuler, scaled: &SparseMatrix, idle_spins: usize) -> Option<f64> {
    let of_legs = of_legs(system);
    let last = of_legs.len().checked_sub(idle_spins + 1)?;
    let constraints = scaled.select_columns(&constraints_of(system)).transpose();
    let legs = constraints.select_columns(&of_legs);
    // The bodies of different legs have no constraint in common, so each leg has its own singular
    // values.
    let mut values = Vec::with_capacity(of_legs.len());
    for leg in legs.independent_blocks() {
        values.extend_from_slice(Svd::new(&leg.to_dense()).singular_values.as_slice());
    }
    values.sort_by(|a, b| b.total_cmp(a));
    let is_resisted = values[last] > RANK_LIMIT.value(values[0]);
    Some(if is_resisted { values[last] } else { 0.0 })
}

/// Lists the unknowns of the balance that belong to constraints.
fn constraints_of(system: &NewtonEuler) -> Vec<usize> {
    let is_constraint = |k: &usize| !matches!(system.unknowns[*k], Unknown::Drive { .. });
    (0..system.unknowns.len()).filter(is_constraint).collect()
}

/// Returns the singular value with the given index, counted from the largest value; zero if the
/// index is at or above the rank.
fn zero_or(decomposition: &Decomposition, index: usize) -> f64 {
    if index < decomposition.rank() { decomposition.value(index) } else { 0.0 }
}

/// Lists the rows of the balance that belong to bodies between hubs; none if there are no hubs.
/// Bodies of open chains, such as fingers at the end of an arm, belong to no leg and make no body a
/// hub.
pub(super) fn of_legs(system: &NewtonEuler) -> Vec<usize> {
    let joints = system.joints_of_loops();
    if joints.iter().skip(1).all(|&count| count < HUB) {
        return Vec::new();
    }
    (0..system.matrix.nrows() / 6)
        .filter(|&body| (1..HUB).contains(&joints[body + 1]))
        .flat_map(|body| 6 * body..6 * body + 6)
        .collect()
}

impl Statics {
    /// Computes the type 2 (actuation) singularity index: zero if neither constraints nor actuators
    /// resist a motion other than passive spins.
    pub fn actuation_distance(&self, idle_spins: usize) -> f64 {
        let resisted = self.system().matrix.nrows().saturating_sub(idle_spins);
        match resisted.checked_sub(1) {
            None => 1.0,
            Some(last) => zero_or(self.decomposition(), last),
        }
    }
}
