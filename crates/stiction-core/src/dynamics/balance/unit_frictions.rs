//! Response of the frictionless balance to unit friction forces: the changes of all wrenches and
//! efforts, computed for four friction forces at a time.
//!
//! Equation (B6) of the book's theory.

use super::Balance;
use crate::dynamics::plan::BalancePlan;
use crate::dynamics::structure::Weighting;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::scalar::{Lanes, Scalar};
use crate::spatial::Wrench;
use crate::topology::{Link, Role};

/// Number of right-hand sides solved simultaneously, one per SIMD lane.
pub(in crate::dynamics) const WIDTH: usize = 4;
/// Fraction of the largest entry of the right-hand side below which a residual counts as round-off.
const ROUND_OFF: f64 = 16.0 * f64::EPSILON;
pub(in crate::dynamics) type Four = Lanes<f64, WIDTH>;

/// Friction force of 1 N at one interface, expressed as the generalised force on each DOF of the
/// interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::dynamics) struct UnitFriction {
    pub(in crate::dynamics) interface: usize,
    pub(in crate::dynamics) against: [f64; 3],
}

/// Changes of all wrenches and efforts due to up to four [`UnitFriction`]s, one per SIMD lane.
#[derive(Clone, Debug, Default)]
pub(in crate::dynamics) struct UnitResponses {
    /// Change of the complete wrench of each joint, exerted by the predecessor on the successor,
    /// about the reference point.
    pub(in crate::dynamics) wrenches: Vec<Wrench<Four>>,
    pub(in crate::dynamics) efforts: Vec<Four>,
    /// Change of the acceleration of each local degree of freedom.
    pub(in crate::dynamics) spins: Vec<Four>,
}

/// Buffers of [`Balance::respond`].
#[derive(Clone, Debug, Default)]
pub(in crate::dynamics) struct LaneWorkspace {
    right: Vec<Four>,
    left: Vec<Four>,
    solution: Vec<Four>,
    correction: Vec<Four>,
    constants: Vec<Four>,
    cut_wrenches: Vec<Wrench<Four>>,
    node_wrenches: Vec<Wrench<Four>>,
    responses: UnitResponses,
    /// Actuator efforts, N or N m, due to a friction force of 1 N at a single interface.
    alone: Vec<f64>,
}

impl LaneWorkspace {
    fn fit(&mut self, plan: &BalancePlan, actuators: usize) {
        let BalancePlan { topology, structure, .. } = plan;
        for (numbers, count) in [
            (&mut self.right, structure.rows()),
            (&mut self.left, structure.rows()),
            (&mut self.solution, structure.size()),
            (&mut self.correction, structure.size()),
            (&mut self.constants, topology.dofs()),
        ] {
            numbers.resize(count, Four::zero());
        }
        self.cut_wrenches.resize(topology.cuts.len(), Wrench::zero());
        self.node_wrenches.resize(topology.nodes.len(), Wrench::zero());
        self.alone.resize(actuators, 0.0);
        let UnitResponses { wrenches, efforts, spins } = &mut self.responses;
        wrenches.resize(topology.joint_types.len(), Wrench::zero());
        efforts.resize(actuators, Four::zero());
        spins.resize(structure.spin_nodes.len(), Four::zero());
    }
}

impl Balance<f64> {
    /// Solves the frictionless balance, factorised by [`Self::factor_frictionless`], for each unit
    /// friction force separately. Calls `take` with the results for four friction forces at a time,
    /// in the order of `units`.
    pub(in crate::dynamics) fn respond(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        units: &[UnitFriction],
        workspace: &mut LaneWorkspace,
        mut take: impl FnMut(&UnitResponses),
    ) {
        workspace.fit(plan, plan.topology.actuators.len());
        for units in units.chunks(WIDTH) {
            if plan.is_one_matrix() {
                self.respond_side_by_side(plan, parameters, bodies, units, workspace);
                self.read_lanes(plan, parameters, bodies, workspace);
            } else {
                self.respond_one_by_one(plan, parameters, bodies, units, workspace);
            }
            take(&workspace.responses);
        }
    }

    /// Computes the responses to up to four unit friction forces, one after another.
    fn respond_one_by_one(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        units: &[UnitFriction],
        workspace: &mut LaneWorkspace,
    ) {
        let LaneWorkspace { responses, alone, .. } = workspace;
        let UnitResponses { wrenches, efforts, spins } = responses;
        let first = plan.structure.wrench_columns;
        wrenches.fill(Wrench::zero());
        efforts.fill(Four::zero());
        spins.fill(Four::zero());
        for (lane, unit) in units.iter().enumerate() {
            let interface = &parameters.interfaces[unit.interface];
            let friction = (unit.against, 1.0);
            let results = (plan.passes(), &mut **alone);
            self.apply_friction_alone(plan, parameters, bodies, interface, friction, results);
            for (lanes, wrench) in wrenches.iter_mut().zip(&self.joint_wrenches) {
                set_lane(lanes, lane, *wrench);
            }
            efforts.iter_mut().zip(&*alone).for_each(|(lanes, effort)| lanes.0[lane] = *effort);
            for (lanes, amount) in spins.iter_mut().zip(&self.unknowns[first..]) {
                lanes.0[lane] = *amount;
            }
        }
    }

    /// Computes the unknowns and the wrenches of nodes and cut joints in response to up to four
    /// unit friction forces simultaneously, one per SIMD lane.
    fn respond_side_by_side(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        units: &[UnitFriction],
        workspace: &mut LaneWorkspace,
    ) {
        let BalancePlan { topology, structure, program } = plan;
        let LaneWorkspace { right, left, solution, correction, constants, .. } = workspace;
        let (cut_wrenches, node_wrenches) =
            (&mut workspace.cut_wrenches, &mut workspace.node_wrenches);
        right.fill(Four::zero());
        constants.fill(Four::zero());
        cut_wrenches.fill(Wrench::zero());
        for (lane, unit) in units.iter().enumerate() {
            let interface = &parameters.interfaces[unit.interface];
            if let Role::Tree { node } = topology.role[interface.joint]
                && structure.weighting != Weighting::LeastEfforts
            {
                // Friction at a tree joint appears only in the equations of the DOFs of this joint.
                // Without efforts in the weighting, it has no part in the optimality conditions.
                let first = topology.nodes[node].tree_dofs.start;
                for (&against, dof) in unit.against.iter().zip(interface.shape.dofs()) {
                    constants[first + dof].0[lane] = against;
                    if let Some(equation) = structure.equation_of[first + dof] {
                        right[structure.first_balance_row() + equation].0[lane] = -against;
                    }
                }
                continue;
            }
            if let Role::Cut { cut } = topology.role[interface.joint]
                && structure.weighting == Weighting::Determined
            {
                // Friction at a cut joint loads the joints on the path around its loop.
                let wrench = bodies.wrench_of(topology, interface, unit.against);
                set_lane(&mut cut_wrenches[cut], lane, wrench);
                for &(node, sign) in &topology.cuts[cut].path {
                    for tree_dof in topology.nodes[node].tree_dofs.clone() {
                        if let Some(equation) = structure.equation_of[tree_dof] {
                            let power = self.rows[tree_dof].power(wrench);
                            let row = structure.first_balance_row() + equation;
                            right[row].0[lane] -= if sign > 0.0 { power } else { -power };
                        }
                    }
                }
                continue;
            }
            self.set_friction_alone(topology, bodies, interface, (unit.against, 1.0));
            self.begin_wrenches(topology);
            self.measure(plan, parameters, bodies);
            for (lanes, number) in right.iter_mut().zip(&self.right) {
                lanes.0[lane] = *number;
            }
            match topology.role[interface.joint] {
                Role::Tree { node } => {
                    for tree_dof in topology.nodes[node].tree_dofs.clone() {
                        constants[tree_dof].0[lane] = self.constants[tree_dof];
                    }
                }
                Role::Cut { cut } => {
                    set_lane(&mut cut_wrenches[cut], lane, self.cut_constants[cut])
                }
            }
        }
        // Solves, and refines the solution once unless its residual is round-off.
        left.copy_from_slice(right);
        program.solve_lanes(&self.factors, left, solution);
        left.copy_from_slice(right);
        for (entry, value) in structure.entries.iter().zip(&self.entries) {
            left[entry.row] -= solution[entry.column] * Four::from_f64(*value);
        }
        if !is_round_off(left, right) {
            program.solve_lanes(&self.factors, left, correction);
            for (solution, correction) in solution.iter_mut().zip(&*correction) {
                *solution += *correction;
            }
        }
        node_wrenches.fill(Wrench::zero());
        let cuts = topology.cuts.iter().zip(&structure.columns_of).zip(cut_wrenches);
        for ((cut, columns), wrench) in cuts {
            for &column in columns {
                *wrench += self.tilted[column].lift::<Four>() * solution[column];
            }
            for &(node, sign) in &cut.path {
                if sign > 0.0 {
                    node_wrenches[node] -= *wrench;
                } else {
                    node_wrenches[node] += *wrench;
                }
            }
        }
        for (spin, nodes) in structure.spin_nodes.iter().enumerate() {
            let amount = solution[structure.wrench_columns + spin];
            for (&node, demand) in nodes.iter().zip(&self.spin_demand[spin]) {
                node_wrenches[node] += demand.lift::<Four>() * amount;
            }
        }
    }

    /// Computes the [`UnitResponses`] from the unknowns and the wrenches of nodes and cut joints in
    /// `workspace`.
    fn read_lanes(
        &self,
        plan: &BalancePlan,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        workspace: &mut LaneWorkspace,
    ) {
        let BalancePlan { topology, structure, .. } = plan;
        let LaneWorkspace { solution, constants, cut_wrenches, node_wrenches, responses, .. } =
            workspace;
        let UnitResponses { wrenches, efforts, spins } = responses;
        for (wrench, role) in wrenches.iter_mut().zip(&topology.role) {
            *wrench = match *role {
                Role::Cut { cut } => cut_wrenches[cut],
                Role::Tree { node } => match topology.nodes[node].link {
                    Link::Joint { reversed: true, .. } => -node_wrenches[node],
                    _ => node_wrenches[node],
                },
            };
        }
        for (tree_dof, content) in topology.tree_dofs.iter().enumerate() {
            let Some(actuator) = content.actuator else { continue };
            let unit = bodies.screws[tree_dof].lift::<Four>();
            efforts[actuator] = unit.power(node_wrenches[content.node]) - constants[tree_dof];
        }
        for (index, gearing) in structure.gearings.iter().enumerate() {
            let multiplier = solution[structure.first_gearing() + index];
            let coefficients = &parameters.gearings[gearing.gearing].coefficients;
            for ((tree_dof, _), coefficient) in gearing.dofs.iter().zip(coefficients) {
                if let Some(actuator) = topology.tree_dofs[*tree_dof].actuator {
                    efforts[actuator] -= Four::from_f64(*coefficient) * multiplier;
                }
            }
        }
        for (index, &actuator) in topology.cut_actuators.iter().enumerate() {
            efforts[actuator] = solution[topology.constraints + index];
        }
        for (spin, acceleration) in spins.iter_mut().enumerate() {
            *acceleration = solution[structure.wrench_columns + spin];
        }
    }
}

/// Returns true if, in each lane, the residual is round-off relative to the largest entry of the
/// right-hand side. The solution is then exact for slightly perturbed coefficients.
fn is_round_off(residual: &[Four], right: &[Four]) -> bool {
    let mut limit = [0.0_f64; WIDTH];
    for Lanes(numbers) in right {
        limit = core::array::from_fn(|lane| {
            let size = numbers[lane].abs();
            if size > limit[lane] { size } else { limit[lane] }
        });
    }
    let limit = limit.map(|largest| ROUND_OFF * largest);
    // A right-hand side that is not a number makes the residual not a number, for which the
    // comparison is false.
    let is_small = |Lanes(numbers): &Four| {
        numbers.iter().zip(limit).fold(true, |all, (number, limit)| all & (number.abs() <= limit))
    };
    residual.iter().all(is_small) && limit.iter().all(|limit| limit.is_finite())
}

fn set_lane(wrench: &mut Wrench<Four>, lane: usize, value: Wrench<f64>) {
    for (to, from) in [(&mut wrench.force, value.force), (&mut wrench.moment, value.moment)] {
        (to.x.0[lane], to.y.0[lane], to.z.0[lane]) = (from.x, from.y, from.z);
    }
}
