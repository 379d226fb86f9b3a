//! Force and moment balance: solves for all reactions for a given motion, with linearised friction.
//!
//! Equation (B6) of the book's theory.

mod apply_friction;
mod loading;
mod system;
mod unit_frictions;

pub(in crate::dynamics) use unit_frictions::{
    Four, LaneWorkspace, UnitFriction, UnitResponses, WIDTH,
};

use super::plan::BalancePlan;
use super::structure::BalanceStructure;
use crate::kinematics::{Bodies, Results};
use crate::linalg::StaticLu;
use crate::parameters::Parameters;
use crate::scalar::Scalar;
use crate::spatial::{Twist, Vec3, Wrench};
use crate::topology::{Link, Role, Topology};

/// Force and moment balance of all bodies at one instant, with the buffers for its solution.
#[derive(Clone, Debug)]
pub(crate) struct Balance<T> {
    /// Wrench that motion, external loads and springs require at each node: the sum over the body
    /// of the node and all its descendants in the spanning tree.
    demand: Vec<Wrench<T>>,
    /// Inertia wrench per unit acceleration of each local degree of freedom, for each node in
    /// [`BalanceStructure::spin_nodes`]. The wrench of a node includes the descendants of its body.
    spin_demand: Vec<Vec<Wrench<T>>>,
    /// Wrench per unit of each wrench unknown (matrix column), acting at the cut joint of this
    /// unknown, without friction.
    columns: Vec<Wrench<T>>,
    /// Wrench per unit of each wrench unknown, acting at the cut joint of this unknown, including
    /// the linearised friction of the joint.
    tilted: Vec<Wrench<T>>,
    /// Row of the balance equation of each DOF of the spanning tree, `row.power(wrench) =
    /// constant`, where the joint of the DOF transmits `wrench`.
    rows: Vec<Twist<T>>,
    constants: Vec<T>,
    /// Part of the wrench at each cut joint that is due to friction and does not depend on the
    /// unknowns.
    cut_constants: Vec<Wrench<T>>,
    /// Wrench that the joint of each node transmits, exerted by the parent on the child.
    node_wrenches: Vec<Wrench<T>>,
    /// Wrench at each cut joint, exerted by the predecessor on the successor.
    cut_wrenches: Vec<Wrench<T>>,
    entries: Vec<T>,
    factors: Vec<T>,
    /// True if matrix entries and factors belong to the frictionless balance at the present
    /// configuration.
    is_frictionless: bool,
    right: Vec<T>,
    correction: Vec<T>,
    pub(super) unknowns: Vec<T>,
    /// Complete wrench of each joint, exerted by the predecessor on the successor.
    pub(super) joint_wrenches: Vec<Wrench<T>>,
}

impl<T: Scalar> Balance<T> {
    pub(super) fn new(plan: &BalancePlan) -> Self {
        let BalancePlan { topology, structure, program } = plan;
        let zeros = |n| vec![T::zero(); n];
        let wrenches = |n| vec![Wrench::zero(); n];
        Self {
            demand: wrenches(topology.nodes.len()),
            spin_demand: structure.spin_nodes.iter().map(|nodes| wrenches(nodes.len())).collect(),
            columns: wrenches(structure.wrench_columns),
            tilted: wrenches(structure.wrench_columns),
            rows: vec![Twist::zero(); topology.dofs()],
            constants: zeros(topology.dofs()),
            cut_constants: wrenches(topology.cuts.len()),
            node_wrenches: wrenches(topology.nodes.len()),
            cut_wrenches: wrenches(topology.cuts.len()),
            entries: zeros(structure.entries.len()),
            factors: zeros(program.values()),
            is_frictionless: false,
            right: zeros(structure.rows()),
            correction: zeros(structure.size()),
            unknowns: zeros(structure.size()),
            joint_wrenches: wrenches(topology.joint_types.len()),
        }
    }

    /// Returns true if all buffers have the same sizes as the buffers of `other`.
    pub(super) fn fits(&self, other: &Self) -> bool {
        self.entries.len() == other.entries.len()
            && self.factors.len() == other.factors.len()
            && self.right.len() == other.right.len()
            && self.unknowns.len() == other.unknowns.len()
            && self.columns.len() == other.columns.len()
            && self.spin_demand.len() == other.spin_demand.len()
            && self.spin_demand.iter().zip(&other.spin_demand).all(|(a, b)| a.len() == b.len())
    }

    /// Factorises and solves the balance with linearised friction. Returns the sign of the product
    /// of all pivots.
    pub(super) fn solve(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) -> T {
        self.assemble(plan, parameters, bodies);
        let sign = plan.program.factor(&self.entries, &mut self.factors);
        self.solve_factored(plan, parameters, bodies, plan.passes());
        sign
    }

    /// Returns the reciprocal pivots of the last factorisation.
    pub(super) fn reciprocal_pivots(&self, program: &StaticLu) -> Vec<T> {
        program.pivots().map(|slot| self.factors[slot]).collect()
    }

    /// Returns the unknowns that determine all wrenches: the wrenches at the cut joints, and the
    /// accelerations of local degrees of freedom.
    pub(super) fn carried(&self, structure: &BalanceStructure) -> (Vec<Wrench<T>>, Vec<T>) {
        (
            self.cut_wrenches.clone(),
            self.unknowns[structure.wrench_columns..][..self.spin_demand.len()].to_vec(),
        )
    }

    /// Computes all wrenches from the wrenches at the cut joints and the accelerations of local degrees
    /// of freedom.
    pub(super) fn carry(&mut self, plan: &BalancePlan, cuts: &[Wrench<T>], spins: &[T]) {
        let BalancePlan { topology, structure, .. } = plan;
        self.node_wrenches.copy_from_slice(&self.demand);
        self.cut_wrenches.fill(Wrench::zero());
        for (cut, wrench) in cuts.iter().enumerate() {
            self.add_at_cut(topology, cut, *wrench);
        }
        for ((nodes, demand), spin) in structure.spin_nodes.iter().zip(&self.spin_demand).zip(spins)
        {
            for (&node, &demand) in nodes.iter().zip(demand) {
                self.node_wrenches[node] += demand * *spin;
            }
        }
        self.collect(topology);
    }

    /// Computes all wrenches from the wrenches at the cut joints, for a mechanism without local
    /// degrees of freedom.
    pub(super) fn carry_plainly(
        &mut self,
        plan: &BalancePlan,
        cuts: impl Iterator<Item = Wrench<T>>,
    ) {
        let topology = &plan.topology;
        self.node_wrenches.copy_from_slice(&self.demand);
        self.cut_wrenches.fill(Wrench::zero());
        for (cut, wrench) in cuts.enumerate() {
            self.add_at_cut(topology, cut, wrench);
        }
        self.collect(topology);
    }

    /// Calls `put` with the components of the wrenches that the nodes require, and of the joint
    /// wrenches.
    pub(super) fn write_wrenches(&self, mut put: impl FnMut(&[T])) {
        for Wrench { force: f, moment: m } in self.demand.iter().chain(&self.joint_wrenches) {
            put(&[f.x, f.y, f.z, m.x, m.y, m.z]);
        }
    }

    /// Sets the generalised friction force on each DOF of the spanning tree. The residual of the
    /// balance includes these forces.
    pub(super) fn set_constants(&mut self, constants: &[T]) {
        self.constants.copy_from_slice(constants);
    }

    /// Sets the unknowns to zero, and all wrenches to their values for zero unknowns.
    fn begin_wrenches(&mut self, topology: &Topology) {
        self.unknowns.fill(T::zero());
        self.node_wrenches.copy_from_slice(&self.demand);
        self.cut_wrenches.fill(Wrench::zero());
        for cut in 0..topology.cuts.len() {
            self.add_at_cut(topology, cut, self.cut_constants[cut]);
        }
    }

    /// Solves the balance with the last factorisation in `passes` passes (the first solve and the
    /// iterative refinements), and computes all joint wrenches.
    fn solve_factored(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        passes: usize,
    ) {
        let BalancePlan { topology, structure, program } = plan;
        self.begin_wrenches(topology);
        for pass in 1..=passes {
            self.measure(plan, parameters, bodies);
            program.solve(&self.factors, &mut self.right, &mut self.correction);
            if pass < passes {
                // Derivatives follow from the residual of the last pass, equation (P8) of the
                // book's theory.
                self.correction.iter_mut().for_each(|change| *change = change.held());
            }
            self.correct(topology, structure);
        }
        self.collect(topology);
    }

    /// Factorises the frictionless balance at the configuration of `other`, and sets the wrenches
    /// due to motion and external loads to zero.
    pub(super) fn factor_frictionless(
        &mut self,
        other: &Self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) {
        self.demand.fill(Wrench::zero());
        self.columns.copy_from_slice(&other.columns);
        for (demand, others) in self.spin_demand.iter_mut().zip(&other.spin_demand) {
            demand.copy_from_slice(others);
        }
        self.rows.copy_from_slice(&bodies.screws);
        self.tilted.copy_from_slice(&self.columns);
        if other.is_frictionless {
            self.entries.copy_from_slice(&other.entries);
            self.factors.copy_from_slice(&other.factors);
            return;
        }
        self.assemble(plan, parameters, bodies);
        plan.program.factor(&self.entries, &mut self.factors);
    }

    /// Computes the actuator efforts, N or N m: for each actuated DOF the effort that the joint
    /// transmits, minus the efforts of friction and gearings. `friction_efforts` contains the
    /// generalised friction force on each DOF of the spanning tree.
    pub(super) fn read_efforts(
        &self,
        plan: &BalancePlan,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
        friction_efforts: &[T],
        efforts: &mut [T],
    ) {
        let BalancePlan { topology, structure, .. } = plan;
        for (tree_dof, content) in topology.tree_dofs.iter().enumerate() {
            let (Some(actuator), Link::Joint { joint, reversed }) =
                (content.actuator, topology.nodes[content.node].link)
            else {
                continue;
            };
            let effort = bodies.screws[tree_dof].power(self.joint_wrenches[joint]);
            let effort = if reversed { -effort } else { effort };
            efforts[actuator] = effort - friction_efforts[tree_dof];
        }
        structure.subtract_gearings(topology, parameters, &self.unknowns, efforts);
        for (index, &actuator) in topology.cut_actuators.iter().enumerate() {
            efforts[actuator] = self.unknowns[topology.constraints + index];
        }
    }

    /// Adds a wrench at a cut joint, and the effect of this wrench on the joints of the spanning
    /// tree.
    fn add_at_cut(&mut self, topology: &Topology, cut: usize, wrench: Wrench<T>) {
        self.cut_wrenches[cut] += wrench;
        for &(node, sign) in &topology.cuts[cut].path {
            if sign > 0.0 {
                self.node_wrenches[node] -= wrench;
            } else {
                self.node_wrenches[node] += wrench;
            }
        }
    }

    /// Adds the correction from the last linear solve to the unknowns, and its effect to all
    /// wrenches.
    fn correct(&mut self, topology: &Topology, structure: &BalanceStructure) {
        for (unknown, correction) in self.unknowns.iter_mut().zip(&self.correction) {
            *unknown += *correction;
        }
        for (cut, columns) in structure.columns_of.iter().enumerate() {
            let mut change = Wrench::zero();
            for &column in columns {
                change += self.tilted[column] * self.correction[column];
            }
            self.add_at_cut(topology, cut, change);
        }
        for (spin, nodes) in structure.spin_nodes.iter().enumerate() {
            let change = self.correction[structure.wrench_columns + spin];
            for (&node, &demand) in nodes.iter().zip(&self.spin_demand[spin]) {
                self.node_wrenches[node] += demand * change;
            }
        }
    }

    /// Collects the complete wrenches of all joints from the wrenches of nodes and cut joints.
    fn collect(&mut self, topology: &Topology) {
        for (joint, role) in topology.role.iter().enumerate() {
            self.joint_wrenches[joint] = match *role {
                Role::Cut { cut } => self.cut_wrenches[cut],
                Role::Tree { node } => match topology.nodes[node].link {
                    Link::Joint { reversed: true, .. } => -self.node_wrenches[node],
                    _ => self.node_wrenches[node],
                },
            };
        }
    }
}

impl Balance<f64> {
    /// Reads the numbers that [`Self::write_wrenches`] puts, and sets the rows of the balance
    /// without friction.
    pub(super) fn read_wrenches(&mut self, bodies: &Bodies<f64>, numbers: &mut Results<'_>) {
        for wrench in self.demand.iter_mut().chain(&mut self.joint_wrenches) {
            let [a, b, c, u, v, w] = numbers.next();
            *wrench = Wrench { force: Vec3::new(a, b, c), moment: Vec3::new(u, v, w) };
        }
        self.is_frictionless = false;
        self.rows.copy_from_slice(&bodies.screws);
    }

    /// Returns the smallest magnitude of the pivots of the last factorisation; their units are powers
    /// of the metre. Does not allocate.
    pub(super) fn smallest_pivot(&self, program: &StaticLu) -> f64 {
        program.smallest_pivot(&self.factors, |_, _| 1.0)
    }

    /// Returns the matrix entries computed by [`Self::assemble`].
    pub(super) fn into_entries(self) -> Vec<f64> {
        self.entries
    }

    /// Computes the actuator efforts, N or N m, due to the given unknowns alone: without inertia
    /// forces, external loads and friction.
    pub(super) fn efforts_of(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        unknowns: &[f64],
    ) -> Vec<f64> {
        let BalancePlan { topology, structure, .. } = plan;
        self.tilted.copy_from_slice(&self.columns);
        self.node_wrenches.fill(Wrench::zero());
        self.cut_wrenches.fill(Wrench::zero());
        self.unknowns.fill(0.0);
        self.correction[..unknowns.len()].copy_from_slice(unknowns);
        self.correct(topology, structure);
        let mut efforts = vec![0.0; topology.actuators.len()];
        for (tree_dof, content) in topology.tree_dofs.iter().enumerate() {
            if let Some(actuator) = content.actuator {
                efforts[actuator] = bodies.screws[tree_dof].power(self.node_wrenches[content.node]);
            }
        }
        structure.subtract_gearings(topology, parameters, &self.unknowns, &mut efforts);
        for (index, &actuator) in topology.cut_actuators.iter().enumerate() {
            efforts[actuator] = self.unknowns[topology.constraints + index];
        }
        efforts
    }
}
