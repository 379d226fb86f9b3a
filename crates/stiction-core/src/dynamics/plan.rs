//! Selection of the weighting and the elimination order of the balance.

use super::balance::Balance;
use super::error::InverseError;
use super::interfaces::{Coupling, Interfaces};
use super::structure::{BalanceStructure, Weighting};
use crate::kinematics::Bodies;
use crate::linalg::{
    Decomposition, Limit, Plan, Scales, SparseMatrix, SparseVector, StaticLu, Svd, to_dense,
};
use crate::parameters::Parameters;
use crate::random::Random;
use crate::topology::Topology;
use nalgebra::{DMatrix, DVector};
use std::sync::Arc;

/// Structure and elimination order of the balance of a mechanism, for any scalar type.
#[derive(Clone, Debug)]
pub(crate) struct BalancePlan {
    pub(super) topology: Arc<Topology>,
    pub(super) structure: BalanceStructure,
    pub(super) program: StaticLu,
}

/// Fraction of the largest singular value below which singular values count as zero. Matrices are
/// scaled to entries of order one, and configurations are accurate to 1e-13.
const NEGLIGIBLE: f64 = 1e-9;
/// Magnitude of a pivot of the scaled balance below which the singular values are checked. A small
/// pivot does not imply a small singular value, but a small singular value implies a small pivot.
const SUSPICIOUS_PIVOT: f64 = 1e-3;

impl BalancePlan {
    /// Compiles the balance at the configuration of `bodies`. `spin_responses` contains the
    /// accelerations of the spanning tree per unit acceleration of each local degree of freedom.
    pub(super) fn new(
        topology: &Arc<Topology>,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        spin_responses: &[Vec<f64>],
    ) -> Result<Self, InverseError> {
        let spin_bodies: Vec<Vec<usize>> = spin_responses
            .iter()
            .map(|response| accelerated_bodies(topology, parameters, bodies, response))
            .collect();
        let plain = BalanceStructure::new(topology, Weighting::Determined, &spin_bodies);
        let sample = Sample { topology, parameters, bodies, spin_responses };
        let entries = sample.entries(&plain);
        // If there are as many unknowns as equations and no small pivot, the balance is neither
        // redundant nor singular. This test avoids a singular value decomposition, whose cost grows
        // with the cube of the number of unknowns.
        if plain.passive.len() == plain.unknowns() && spin_bodies.is_empty() {
            let nothing = SparseMatrix::new((0, 0), core::iter::empty());
            let (rows, columns) = scales(topology, parameters, &plain, &nothing);
            let scales = Scales { rows: &rows, columns: &columns };
            let plan = Plan::new(plain.rows(), plain.size(), &plain.entries, &entries, scales);
            if let Some(plan) = plan.ok().filter(|plan| plan.smallest_pivot > SUSPICIOUS_PIVOT) {
                return Ok(sample.plan(plain, plan.compile()));
            }
        }
        let entries = plain.entries.iter().zip(entries);
        let entries = entries.map(|(entry, value)| (entry.row, entry.column, value));
        let matrix = SparseMatrix::new((plain.passive.len(), plain.unknowns()), entries);
        let weighting = weighting(&sample, &plain, &matrix)?;
        let structure = BalanceStructure::new(topology, weighting, &spin_bodies);
        let numbers = sample.entries(&structure);
        let (rows, columns) = scales(topology, parameters, &structure, &matrix);
        let scales = Scales { rows: &rows, columns: &columns };
        let plan =
            Plan::new(structure.rows(), structure.size(), &structure.entries, &numbers, scales)
                .map_err(|_| InverseError::Singular)?;
        Ok(sample.plan(structure, plan.compile()))
    }

    /// Returns the weighting that selects a solution of a redundant balance.
    pub(crate) fn weighting(&self) -> Weighting {
        self.structure.weighting
    }

    /// Returns the number of solves per factorisation: the first solve and the iterative
    /// refinements.
    pub(super) fn passes(&self) -> usize {
        // Accelerations of local degrees of freedom change the weighted wrenches.
        let bordered = self.structure.weighting != Weighting::Determined;
        if bordered && !self.structure.spin_nodes.is_empty() { 3 } else { 2 }
    }

    /// Returns true if the factorised matrix contains all terms of the equations, so that one solve
    /// yields all unknowns up to round-off.
    pub(super) fn is_one_matrix(&self) -> bool {
        self.passes() == 2
    }

    /// Returns the number of multiply-subtract operations of one factorisation.
    pub(crate) fn operations(&self) -> usize {
        self.program.operations()
    }
}

/// Configuration at which the entries of the balance matrix are evaluated.
struct Sample<'a> {
    topology: &'a Arc<Topology>,
    parameters: &'a Parameters<f64>,
    bodies: &'a Bodies<f64>,
    spin_responses: &'a [Vec<f64>],
}

impl Sample<'_> {
    fn plan(&self, structure: BalanceStructure, program: StaticLu) -> BalancePlan {
        BalancePlan { topology: Arc::clone(self.topology), structure, program }
    }

    /// Computes the entries of the frictionless balance matrix.
    fn entries(&self, structure: &BalanceStructure) -> Vec<f64> {
        let &Self { parameters, bodies, spin_responses, .. } = self;
        let plan = self.plan(structure.clone(), StaticLu::default());
        let mut balance = Balance::new(&plan);
        balance.load(&plan, parameters, bodies, &[]);
        for (spin, response) in spin_responses.iter().enumerate() {
            balance.load_spin(&plan, parameters, bodies, spin, response);
        }
        let interfaces = Interfaces::new(parameters.interfaces.len());
        balance.apply_friction(&plan, parameters, bodies, &interfaces, Coupling::None);
        balance.assemble(&plan, parameters, bodies);
        balance.into_entries()
    }
}

/// Returns the indices of the bodies that accelerate if the DOFs of the spanning tree have the
/// accelerations `response`.
fn accelerated_bodies(
    topology: &Topology,
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    response: &[f64],
) -> Vec<usize> {
    let mut bodies = bodies.clone();
    bodies.bias.fill(crate::spatial::Twist::zero());
    bodies.accelerate(topology, response);
    let size = |body: usize| {
        let com = bodies.pose[body].apply(parameters.com[body]);
        let twist = bodies.acceleration[body];
        twist.angular.norm() + twist.velocity_at(com).norm() / parameters.length
    };
    (1..bodies.pose.len()).filter(|&body| size(body) > NEGLIGIBLE).collect()
}

/// Computes scaling factors for the rows and for the columns of the balance matrix, which make its
/// entries comparable in size.
fn scales(
    topology: &Topology,
    parameters: &Parameters<f64>,
    structure: &BalanceStructure,
    matrix: &SparseMatrix,
) -> (Vec<f64>, Vec<f64>) {
    let length = parameters.length;
    let row = |&tree_dof: &usize| {
        if topology.tree_dof_translates(&topology.tree_dofs[tree_dof]) { 1.0 } else { 1.0 / length }
    };
    let equations: Vec<f64> = structure.passive.iter().map(row).collect();
    let mut unknowns = Vec::new();
    for cut in &topology.cuts {
        for constraint in topology.joint_types[cut.joint].constraints() {
            unknowns.push(if constraint.is_moment() { length } else { 1.0 });
        }
    }
    for &actuator in &topology.cut_actuators {
        let actuator = topology.actuators[actuator];
        let dof = topology.joint_types[actuator.joint].dofs()[actuator.dof];
        unknowns.push(if dof.translates() { 1.0 } else { length });
    }
    for spin in 0..structure.spin_nodes.len() {
        // Inertias have no natural scale: their columns are normalised to size one.
        let column = matrix.column(structure.wrench_columns + spin);
        let size = column.map(|(row, x)| (x * equations[row]).abs()).fold(0.0, f64::max);
        unknowns.push(if size > 0.0 { 1.0 / size } else { 1.0 });
    }
    for gearing in &structure.gearings {
        let own = topology.gearings.iter().find(|own| own.gearing == gearing.gearing);
        let is_force = own.is_some_and(|own| own.is_length);
        unknowns.push(if is_force { 1.0 } else { length });
    }
    match structure.weighting {
        Weighting::Determined => (equations, unknowns),
        _ => {
            // The bordered matrix is scaled symmetrically.
            let rows = unknowns.iter().chain(&equations).copied().collect();
            let columns = unknowns.iter().chain(&equations).copied().collect();
            (rows, columns)
        }
    }
}

/// Selects the weighting that the redundancy of the balance at this configuration requires. Returns
/// [`Weighting::Determined`] if the balance is not redundant.
fn weighting(
    sample: &Sample<'_>,
    structure: &BalanceStructure,
    matrix: &SparseMatrix,
) -> Result<Weighting, InverseError> {
    let &Sample { topology, parameters, .. } = sample;
    let (rows, columns) = scales(topology, parameters, structure, matrix);
    let scaled = matrix.scaled(&rows, &columns);
    if scaled.ncols() < scaled.nrows() {
        return Err(InverseError::Singular);
    }
    if scaled.nrows() == 0 && scaled.ncols() == 0 {
        return Ok(Weighting::Determined);
    }
    let redundant = scaled.ncols() - scaled.nrows();
    let unknowns: Vec<usize> = (0..scaled.ncols()).collect();
    let decomposition = Decomposition::new(scaled, &unknowns, Limit::OfLargest(NEGLIGIBLE));
    let null = decomposition.null_space(decomposition.rank());
    if null.len() > redundant {
        return Err(InverseError::Singular);
    }
    if redundant == 0 {
        return Ok(Weighting::Determined);
    }
    let driven = effort_response(sample, structure, &null, &columns);
    // There are far more null vectors than efforts; the transpose has the same singular values.
    let singular_values = Svd::new(&driven.transpose()).singular_values;
    match singular_values.iter().filter(|&&s| s > NEGLIGIBLE).count() {
        0 if parameters.compliance.is_some() => Ok(Weighting::LeastEnergy),
        0 => Ok(Weighting::LeastReactions),
        // Efforts at geared DOFs depend on the gearings, which this weighting does not contain.
        rank if rank == redundant && structure.gearings.is_empty() => Ok(Weighting::LeastEfforts),
        _ => Err(InverseError::TwoWeightings),
    }
}

/// Number of random sums that replace null vectors, if these outnumber the actuators by more.
const SUMS: usize = 8;

/// Returns the effort of each actuator (rows) for each null vector of the balance (columns);
/// torques are divided by the characteristic length. Far more null vectors than actuators are
/// replaced by a few random sums of them: the rank is then less than their number, and the only
/// question is whether it is zero, which the sums answer with probability one.
fn effort_response(
    sample: &Sample<'_>,
    structure: &BalanceStructure,
    null: &[SparseVector],
    column_scales: &[f64],
) -> DMatrix<f64> {
    let &Sample { topology, parameters, bodies, .. } = sample;
    let plan = sample.plan(structure.clone(), StaticLu::default());
    let mut balance = Balance::new(&plan);
    balance.load(&plan, parameters, bodies, &[]);
    let length = column_scales.len();
    let vectors: Vec<DVector<f64>> = match null.len() <= topology.actuators.len() + SUMS {
        true => null.iter().map(|vector| to_dense(vector, length)).collect(),
        false => Random::new(5).sums(null, length, SUMS),
    };
    // Efforts due to these vectors alone.
    let mut driven = DMatrix::zeros(topology.actuators.len(), vectors.len());
    for (k, vector) in vectors.iter().enumerate() {
        let unknowns: Vec<f64> = vector.iter().zip(column_scales).map(|(x, s)| x * s).collect();
        let efforts = balance.efforts_of(&plan, parameters, bodies, &unknowns);
        for (actuator, effort) in efforts.into_iter().enumerate() {
            let content = topology.actuators[actuator];
            let dof = topology.joint_types[content.joint].dofs()[content.dof];
            let scale = if dof.translates() { 1.0 } else { 1.0 / parameters.length };
            driven[(actuator, k)] = effort * scale;
        }
    }
    driven
}
