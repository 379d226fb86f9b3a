//! Response of the frictionless balance to constant friction forces, four at a time.
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

/// Four right-hand sides, computed side by side.
const WIDTH: usize = 4;
type Four = Lanes<f64, WIDTH>;

/// Generalised friction force on each DOF of one interface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::dynamics) struct UnitFriction {
    pub(in crate::dynamics) interface: usize,
    pub(in crate::dynamics) against: [f64; 3],
}

/// Changes of all forces by one [`UnitFriction`].
#[derive(Clone, Debug, Default)]
pub(in crate::dynamics) struct UnitResponse {
    /// Changes of the complete wrenches of all joints, predecessor on successor, about the
    /// reference point.
    pub(in crate::dynamics) wrenches: Vec<Wrench<f64>>,
    pub(in crate::dynamics) efforts: Vec<f64>,
    /// Changes of the accelerations of local degrees of freedom.
    pub(in crate::dynamics) spins: Vec<f64>,
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
    response: UnitResponse,
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
        self.response.wrenches.resize(topology.joint_types.len(), Wrench::zero());
        self.response.efforts.resize(actuators, 0.0);
        self.response.spins.resize(structure.spin_nodes.len(), 0.0);
    }
}

impl Balance<f64> {
    /// Solves the balance of [`Self::factor_frictionless`] for each of these friction forces alone;
    /// calls `take` with the index of each friction force and its response.
    pub(in crate::dynamics) fn respond(
        &mut self,
        plan: &BalancePlan,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        units: &[UnitFriction],
        workspace: &mut LaneWorkspace,
        mut take: impl FnMut(usize, &UnitResponse),
    ) {
        workspace.fit(plan, plan.topology.actuators.len());
        if plan.is_one_matrix() {
            for (block, units) in units.chunks(WIDTH).enumerate() {
                self.respond_side_by_side(plan, parameters, bodies, units, workspace);
                for lane in 0..units.len() {
                    self.read_lane(plan, parameters, bodies, workspace, lane);
                    take(block * WIDTH + lane, &workspace.response);
                }
            }
            return;
        }
        let response = &mut workspace.response;
        let first = plan.structure.wrench_columns;
        for (index, unit) in units.iter().enumerate() {
            let interface = &parameters.interfaces[unit.interface];
            let (against, efforts) = (unit.against, &mut response.efforts);
            self.apply_friction_alone(plan, parameters, bodies, interface, (against, 1.0), efforts);
            response.wrenches.copy_from_slice(&self.joint_wrenches);
            let spins = response.spins.len();
            response.spins.copy_from_slice(&self.unknowns[first..first + spins]);
            take(index, response);
        }
    }

    /// Solves for the unknowns and the wrenches of nodes and cut joints under up to four friction forces.
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
                && structure.weighting == Weighting::Determined
            {
                // Friction at a tree joint enters the equations of the joint's own DOFs only.
                let first = topology.nodes[node].tree_dofs.start;
                for (&against, dof) in unit.against.iter().zip(interface.shape.dofs()) {
                    constants[first + dof].0[lane] = against;
                    if let Ok(equation) = structure.passive.binary_search(&(first + dof)) {
                        right[structure.first_balance_row() + equation].0[lane] = -against;
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
        // The solution, refined once.
        left.copy_from_slice(right);
        program.solve_lanes(&self.factors, left, solution);
        left.copy_from_slice(right);
        for (entry, value) in structure.entries.iter().zip(&self.entries) {
            left[entry.row] -= solution[entry.column] * Four::from_f64(*value);
        }
        program.solve_lanes(&self.factors, left, correction);
        for (solution, correction) in solution.iter_mut().zip(&*correction) {
            *solution += *correction;
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

    /// Copies one lane to the response.
    fn read_lane(
        &self,
        plan: &BalancePlan,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        workspace: &mut LaneWorkspace,
        lane: usize,
    ) {
        let BalancePlan { topology, structure, .. } = plan;
        let LaneWorkspace { solution, constants, cut_wrenches, node_wrenches, response, .. } =
            workspace;
        for (wrench, role) in response.wrenches.iter_mut().zip(&topology.role) {
            *wrench = match *role {
                Role::Cut { cut } => lane_of(&cut_wrenches[cut], lane),
                Role::Tree { node } => match topology.nodes[node].link {
                    Link::Joint { reversed: true, .. } => -lane_of(&node_wrenches[node], lane),
                    _ => lane_of(&node_wrenches[node], lane),
                },
            };
        }
        for (tree_dof, content) in topology.tree_dofs.iter().enumerate() {
            let Some(actuator) = content.actuator else { continue };
            let wrench = lane_of(&node_wrenches[content.node], lane);
            let friction = constants[tree_dof].0[lane];
            response.efforts[actuator] = bodies.screws[tree_dof].power(wrench) - friction;
        }
        for (index, gearing) in structure.gearings.iter().enumerate() {
            let multiplier = solution[structure.first_gearing() + index].0[lane];
            let coefficients = &parameters.gearings[gearing.gearing].coefficients;
            for ((tree_dof, _), coefficient) in gearing.dofs.iter().zip(coefficients) {
                if let Some(actuator) = topology.tree_dofs[*tree_dof].actuator {
                    response.efforts[actuator] -= coefficient * multiplier;
                }
            }
        }
        for (index, &actuator) in topology.cut_actuators.iter().enumerate() {
            response.efforts[actuator] = solution[topology.constraints + index].0[lane];
        }
        for (spin, acceleration) in response.spins.iter_mut().enumerate() {
            *acceleration = solution[structure.wrench_columns + spin].0[lane];
        }
    }
}

fn lane_of(wrench: &Wrench<Four>, lane: usize) -> Wrench<f64> {
    let of = |vector: crate::spatial::Vec3<Four>| {
        crate::spatial::Vec3::new(vector.x.0[lane], vector.y.0[lane], vector.z.0[lane])
    };
    Wrench { force: of(wrench.force), moment: of(wrench.moment) }
}

fn set_lane(wrench: &mut Wrench<Four>, lane: usize, value: Wrench<f64>) {
    for (to, from) in [(&mut wrench.force, value.force), (&mut wrench.moment, value.moment)] {
        (to.x.0[lane], to.y.0[lane], to.z.0[lane]) = (from.x, from.y, from.z);
    }
}
