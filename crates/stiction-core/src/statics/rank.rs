//! Rank analysis of the force and moment balance of all bodies: forces of joints and actuators at a
//! configuration, and their uniqueness.
//!
//! Equations (B7) and (B9) of the book's theory.

use super::distance::JointLoad;
use super::newton_euler::{NewtonEuler, Unknown};
use super::weakest::GainedTwist;
use crate::linalg::{Decomposition, Limit, SparseMatrix, SparseVector, Svd, to_dense};
use crate::mechanism::{JointId, Mechanism};
use crate::parameters::Weights;
use crate::spatial::{Pose, Vec3, Wrench};
use nalgebra::{DMatrix, DVector};
use std::sync::OnceLock;

/// Relative singular values below this limit count as zero. The matrix is scaled to entries of
/// order one, and configurations are accurate to 1e-13, so exact zeros appear as values below
/// 1e-12. If values are small but above the limit (near a singularity), the system is solved and
/// the singularity index reported.
pub(super) const RANK_LIMIT: Limit = Limit::OfLargest(1e-10);

/// Force and moment balance of all bodies at one configuration, with the singular value
/// decomposition of its matrix.
#[derive(Clone, Debug)]
pub struct Statics {
    system: NewtonEuler,
    row_scales: Vec<f64>,
    column_scales: Vec<f64>,
    /// The balance matrix, made dimensionless by scaling.
    scaled: SparseMatrix,
    /// Decomposition of `scaled`, which is computed at its first use.
    decomposition: OnceLock<Decomposition>,
    /// Basis of the self-stress states: scaled unknowns with zero resultant on every body. Computed
    /// at its first use.
    null: OnceLock<Vec<SparseVector>>,
    drive_weights: Vec<f64>,
    /// Pose of each joint's frame J relative to the reference point.
    frames: Vec<Pose<f64>>,
    /// Weights from the declared compliances of the joints; `None` if no joint declares a
    /// compliance.
    compliance: Option<Vec<Weights<f64>>>,
    length: f64,
}

/// Values of the unknowns (constraint multipliers and efforts) that balance a load.
#[derive(Clone, Debug, PartialEq)]
pub struct StaticSolution {
    /// Values of [`NewtonEuler::unknowns`], in N or N m.
    pub unknowns: DVector<f64>,
}

/// A load that reactions and actuator forces cannot balance.
#[derive(Clone, Debug, PartialEq)]
pub struct InfeasibleLoad {
    /// Unconstrained motion on which the load does work.
    pub motion: GainedTwist,
    /// Unbalanced generalised force along the motion, in N m, or in N if the body that describes
    /// the motion does not turn.
    pub missing: f64,
}

/// A self-stress: a change of internal forces that does not affect the motion of the bodies.
#[derive(Clone, Debug, PartialEq)]
pub struct NullDirection {
    /// Change of each actuator effort, in the order of the actuators, N or N m.
    pub drives: Vec<f64>,
    /// Change of the wrench at each affected joint.
    pub joints: Vec<JointLoad>,
}

impl Statics {
    /// Sets up the balance of all bodies. `frames` are the poses of the frames J of all joints
    /// relative to the reference point.
    pub fn new(mechanism: &Mechanism, system: NewtonEuler, frames: Vec<Pose<f64>>) -> Self {
        let types: Vec<_> = mechanism.joints().iter().map(|j| j.joint_type).collect();
        let scaled = system.scaled_matrix(&types);
        let row_scales: Vec<f64> = (0..scaled.nrows()).map(|i| system.row_scale(i)).collect();
        let column_scales = system.column_scales(&types);
        let length = mechanism.characteristic_length();
        let drive_weights = mechanism
            .actuators()
            .map(|(joint, dof)| {
                let unit = mechanism.joints()[joint.0].joint_type.dofs()[dof].units().1;
                if unit == "N m" { 1.0 / length } else { 1.0 }
            })
            .collect();
        Self {
            system,
            row_scales,
            column_scales,
            scaled,
            decomposition: OnceLock::new(),
            null: OnceLock::new(),
            drive_weights,
            frames,
            compliance: Weights::declared(mechanism),
            length,
        }
    }

    /// The balance matrix, made dimensionless by scaling.
    pub fn scaled_matrix(&self) -> &SparseMatrix {
        &self.scaled
    }

    pub(super) fn decomposition(&self) -> &Decomposition {
        self.decomposition.get_or_init(|| {
            let joints = self.system.joints_of_unknowns();
            Decomposition::new(self.scaled.clone(), &joints, RANK_LIMIT)
        })
    }

    fn null(&self) -> &[SparseVector] {
        self.null.get_or_init(|| self.decomposition().null_space(self.rank()))
    }

    /// Scale of each unknown: the characteristic length for moments, 1 for forces.
    pub(super) fn column_scales(&self) -> &[f64] {
        &self.column_scales
    }

    /// Origin of a joint relative to the reference point, m.
    pub(super) fn joint_origin(&self, joint: usize) -> Vec3<f64> {
        self.frames[joint].position
    }

    /// The characteristic length, m.
    pub(crate) fn length(&self) -> f64 {
        self.length
    }

    /// Linear system of the force and moment balance of all bodies.
    pub fn system(&self) -> &NewtonEuler {
        &self.system
    }

    /// Number of linearly independent equations of the balance.
    pub fn rank(&self) -> usize {
        self.decomposition().rank()
    }

    /// Singular values of the scaled system, largest first, by a dense decomposition.
    pub fn singular_values(&self) -> &[f64] {
        self.decomposition().svd().singular_values.as_slice()
    }

    /// Degree of static indeterminacy: number of redundant constraints and actuators.
    pub fn redundancy(&self) -> usize {
        self.null().len()
    }

    /// Number of motions that neither constraints nor actuators resist.
    pub fn open_motions(&self) -> usize {
        self.row_scales.len() - self.rank()
    }

    /// Computes the factors of `units` for which the sum of `demand` and all multiplied units is
    /// feasible, as far as possible. Each unit is the additional demand of one passive spin.
    pub fn amounts_into_reach(
        &self,
        demand: &DVector<f64>,
        friction: &[Wrench<f64>],
        units: &[DVector<f64>],
    ) -> Vec<f64> {
        if units.is_empty() {
            return Vec::new();
        }
        // Computes the infeasible part of a demand.
        let outside = |rows: &DVector<f64>| {
            let scaled = self.scale_rows(rows);
            let inside = self.apply(&self.particular(&scaled));
            scaled - inside
        };
        let columns: Vec<_> = units.iter().map(outside).collect();
        let missing = outside(&self.less_friction(demand, friction));
        // Normalise each unit, because their sizes differ like the inertias of the bodies.
        let sizes: Vec<f64> = columns.iter().map(|c| c.norm().max(f64::MIN_POSITIVE)).collect();
        let scaled: Vec<_> = columns.iter().zip(&sizes).map(|(c, s)| c / *s).collect();
        let svd = Svd::new(&DMatrix::from_columns(&scaled));
        let amounts = svd.solve(&missing, svd.rank(DETERMINED));
        amounts.iter().zip(&sizes).map(|(a, s)| -a / s).collect()
    }

    /// Subtracts the friction wrenches of all joints from a demand. Constraints and actuators must
    /// balance the remaining demand.
    fn less_friction(&self, demand: &DVector<f64>, friction: &[Wrench<f64>]) -> DVector<f64> {
        let mut rest = demand.clone();
        for (joint, &wrench) in friction.iter().enumerate() {
            self.system.add_joint_wrench(&mut rest, joint, -wrench);
        }
        rest
    }

    pub(super) fn scale_rows(&self, rows: &DVector<f64>) -> DVector<f64> {
        let scaled = rows.iter().zip(&self.row_scales).map(|(x, s)| x * s);
        DVector::from_iterator(rows.len(), scaled)
    }

    /// Returns, for each unknown, `true` if it is statically determinate.
    pub fn determined(&self) -> Vec<bool> {
        // Null vectors have unit norm: components of the order of round-off count as zero.
        let mut free = vec![0.0; self.column_scales.len()];
        self.null().iter().flatten().for_each(|(k, x)| free[*k] += x * x);
        free.into_iter().map(|square: f64| square.sqrt() < DETERMINED).collect()
    }

    /// Returns, for each actuator, `true` if its effort is statically determinate.
    pub fn determined_drives(&self) -> Vec<bool> {
        // Actuator efforts are the last unknowns.
        let mut unknowns = self.determined();
        unknowns.split_off(unknowns.len() - self.drive_weights.len())
    }

    /// Returns, for each gearing, `true` if its effort is statically determinate.
    pub fn determined_gearings(&self) -> Vec<bool> {
        let each = self.determined().into_iter().zip(&self.system.unknowns);
        let own = each.filter(|(_, unknown)| matches!(unknown, Unknown::Gearing { .. }));
        own.map(|(determined, _)| determined).collect()
    }

    /// Returns, for each joint and each component of its total wrench (force x y z, then moment x y
    /// z about the joint's origin, world axes), `true` if the balance alone determines the
    /// component.
    pub fn determined_reactions(&self) -> Vec<[bool; 6]> {
        let mut determined = vec![[true; 6]; self.frames.len()];
        for (joint, wrench) in self.self_stresses().flatten() {
            let moment = wrench.moment_about(self.frames[joint].position) * (1.0 / self.length);
            let six = [wrench.force.to_array(), moment.to_array()].concat();
            for (flag, component) in determined[joint].iter_mut().zip(six) {
                *flag &= component.abs() < DETERMINED;
            }
        }
        determined
    }

    /// Computes a basis of the self-stress states. Each state consists of the loaded joints and
    /// their wrenches about the reference point. The unknowns of each state have unit norm.
    pub fn self_stresses(&self) -> impl Iterator<Item = Vec<(usize, Wrench<f64>)>> + '_ {
        self.null().iter().map(|vector| self.wrenches_of(vector))
    }

    /// Computes a basis of the null space of the balance. Each direction consists of the actuator
    /// efforts and the wrenches of the loaded joints, in N and N m.
    pub fn null_directions(&self) -> Vec<NullDirection> {
        let count = self.drive_weights.len();
        let each = self.null().iter().map(|vector| {
            let size = vector.iter().map(|(_, x)| x.abs()).fold(0.0, f64::max);
            let scaled: SparseVector = vector.iter().map(|&(k, x)| (k, x / size)).collect();
            let mut drives = vec![0.0; count];
            let first = self.column_scales.len() - count;
            for &(k, x) in scaled.iter().filter(|(k, _)| *k >= first) {
                drives[k - first] = clean(x) * self.column_scales[k];
            }
            let loads = self.wrenches_of(&scaled).into_iter();
            NullDirection {
                drives,
                joints: loads
                    .map(|(joint, wrench)| JointLoad {
                        joint: JointId(joint),
                        force: wrench.force,
                        moment: wrench.moment_about(self.frames[joint].position),
                    })
                    .filter(|l| l.force.norm() + l.moment.norm() / self.length > DETERMINED)
                    .collect(),
            }
        });
        each.collect()
    }

    /// Computes the wrenches, about the reference point, of the joints loaded by the scaled
    /// unknowns.
    fn wrenches_of(&self, scaled: &[(usize, f64)]) -> Vec<(usize, Wrench<f64>)> {
        self.system.sparse_wrenches(scaled.iter().map(|&(k, x)| (k, x * self.column_scales[k])))
    }

    /// Computes reactions and efforts for a demand ([`NewtonEuler::demand`]). If reactions or
    /// efforts are statically indeterminate, minimises first the actuator efforts, then the
    /// reactions, with the declared weighting [`crate::dynamics::Weighting`]. `friction` contains
    /// the friction wrench of each joint. These wrenches load the bodies and are part of the
    /// weighted reactions.
    ///
    /// # Errors
    /// Returns [`InfeasibleLoad`] if the demand is infeasible.
    pub fn carry(
        &self,
        demand: &DVector<f64>,
        friction: &[Wrench<f64>],
    ) -> Result<StaticSolution, InfeasibleLoad> {
        let scaled = self.scale_rows(&self.less_friction(demand, friction));
        let particular = self.particular(&scaled);
        self.check_range(&scaled, &particular)?;
        Ok(self.distributed(particular, friction))
    }

    /// Computes reactions and efforts for the feasible part of a demand. The result is linear in
    /// the demand and the friction wrenches.
    pub(crate) fn carry_what_can_be(
        &self,
        demand: &DVector<f64>,
        friction: &[Wrench<f64>],
    ) -> StaticSolution {
        let scaled = self.scale_rows(&self.less_friction(demand, friction));
        self.distributed(self.particular(&scaled), friction)
    }

    fn distributed(
        &self,
        mut particular: DVector<f64>,
        friction: &[Wrench<f64>],
    ) -> StaticSolution {
        self.distribute(&mut particular, friction);
        let unknowns = particular.iter().zip(&self.column_scales).map(|(x, s)| x * s);
        StaticSolution { unknowns: DVector::from_iterator(particular.len(), unknowns) }
    }

    /// Computes the minimum-norm least-squares solution for a scaled demand.
    fn particular(&self, scaled: &DVector<f64>) -> DVector<f64> {
        let solve =
            |right: &DVector<f64>| DVector::from_vec(self.decomposition().solve(right.as_slice()));
        let first = solve(scaled);
        // One step of iterative refinement.
        let residual = scaled - self.apply(&first);
        &first + solve(&residual)
    }

    fn apply(&self, scaled: &DVector<f64>) -> DVector<f64> {
        let unknowns = scaled.iter().zip(&self.column_scales).map(|(x, s)| x * s);
        let unknowns: Vec<f64> = unknowns.collect();
        self.scale_rows(&DVector::from_vec(self.system.matrix.times(&unknowns)))
    }

    fn check_range(
        &self,
        scaled: &DVector<f64>,
        particular: &DVector<f64>,
    ) -> Result<(), InfeasibleLoad> {
        let residual = scaled - self.apply(particular);
        let size = scaled.amax().max(particular.amax());
        if residual.amax() <= 1e-9 * size {
            return Ok(());
        }
        // The residual is a combination of unconstrained motions, along which no unknown exerts a
        // force.
        let motion = self.scale_rows(&residual);
        let demand = scaled.dot(&residual);
        let described = self.described(&motion);
        // Scale the residual to the reported motion, and scale the demand along this motion in the
        // same way.
        let size = motion_size(&motion, described.body, described.turns);
        Err(InfeasibleLoad { missing: demand / size, motion: described })
    }

    /// Moves the solution within the null space to minimise first the actuator efforts, then the
    /// reactions.
    fn distribute(&self, solution: &mut DVector<f64>, friction: &[Wrench<f64>]) {
        if self.null().is_empty() {
            return;
        }
        let null: Vec<_> =
            self.null().iter().map(|vector| to_dense(vector, solution.len())).collect();
        let mut open = DMatrix::from_columns(&null);
        let drives: Vec<usize> = (0..self.system.unknowns.len())
            .filter(|&k| matches!(self.system.unknowns[k], Unknown::Drive { .. }))
            .collect();
        // Stage 1: actuator efforts.
        let efforts = |x: &DVector<f64>| {
            DVector::from_iterator(
                drives.len(),
                drives
                    .iter()
                    .zip(&self.drive_weights)
                    .map(|(&k, weight)| x[k] * self.column_scales[k] * weight),
            )
        };
        if !drives.is_empty() {
            let columns: Vec<_> = open.column_iter().map(|c| efforts(&c.into_owned())).collect();
            let response = DMatrix::from_columns(&columns);
            open = least(&response, &efforts(solution), open, solution);
        }
        // Stage 2: reactions, weighted first by the declared compliances, then equally for all
        // joints.
        let none = vec![Wrench::zero(); friction.len()];
        for weights in [self.compliance.as_deref(), None] {
            if open.ncols() == 0 {
                return;
            }
            let columns: Vec<_> =
                open.column_iter().map(|c| self.weighed(&c.into_owned(), &none, weights)).collect();
            let response = DMatrix::from_columns(&columns);
            let now = self.weighed(solution, friction, weights);
            open = least(&response, &now, open, solution);
        }
    }

    /// Computes the reactions of all joints from scaled unknowns and friction wrenches, multiplied
    /// by the square roots of their weights for a least-squares problem. `weights` are declared
    /// compliances; with `None`, all joints have equal weights. The result has six components for
    /// each joint.
    fn weighed(
        &self,
        scaled: &DVector<f64>,
        friction: &[Wrench<f64>],
        weights: Option<&[Weights<f64>]>,
    ) -> DVector<f64> {
        let unknowns = scaled.iter().zip(&self.column_scales).map(|(x, s)| x * s);
        let unknowns = DVector::from_iterator(scaled.len(), unknowns);
        let wrenches = self.system.joint_wrenches(&unknowns, friction);
        let numbers = wrenches.iter().zip(&self.frames).enumerate().flat_map(|(joint, (w, j))| {
            let (force, moment) = (w.force, w.moment_about(j.position) * (1.0 / self.length));
            let Some(weights) = weights.map(|weights| weights[joint]) else {
                return [force.to_array(), moment.to_array()].concat();
            };
            let root = |v: Vec3<f64>, w: Vec3<f64>| {
                let own = j.rotation.transpose_mul(v).to_array();
                own.iter().zip(w.to_array()).map(|(v, w)| v * w.sqrt()).collect::<Vec<f64>>()
            };
            let squares = self.length * self.length;
            [root(force, weights.force), root(moment, weights.moment * squares)].concat()
        });
        DVector::from_iterator(6 * friction.len(), numbers)
    }
}

/// Returns zero for a value of the order of round-off, otherwise the value itself.
fn clean(part: f64) -> f64 {
    if part.abs() < DETERMINED { 0.0 } else { part }
}

/// Computes the speed of a body in a motion of all bodies: the angular velocity in rad/s if
/// `turns`, otherwise the velocity of the centre of mass in m/s.
fn motion_size(motion: &DVector<f64>, body: usize, turns: bool) -> f64 {
    motion.fixed_rows::<3>(6 * (body - 1) + if turns { 3 } else { 0 }).norm()
}

/// Components of null-space vectors below this value are round-off. An unknown without larger
/// components is statically determinate.
pub(crate) const DETERMINED: f64 = 1e-8;

/// Adds `open * amounts` to `solution`, with the amounts that minimise the norm of
/// `now + response * amounts`. Returns combinations of the columns of `open` along which this norm
/// does not change.
fn least(
    response: &DMatrix<f64>,
    now: &DVector<f64>,
    open: DMatrix<f64>,
    solution: &mut DVector<f64>,
) -> DMatrix<f64> {
    let svd = Svd::new(response);
    // The entries of `response` belong to unit self-stresses: they are of order one, or round-off.
    let rank = svd.singular_values.iter().filter(|&&s| s > DETERMINED).count();
    let amounts = -svd.solve(now, rank);
    let rest: Vec<_> = svd.null_space(rank).iter().map(|direction| &open * direction).collect();
    *solution += &open * amounts;
    if rest.is_empty() { DMatrix::zeros(open.nrows(), 0) } else { DMatrix::from_columns(&rest) }
}
