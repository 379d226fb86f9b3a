//! Response of the factorised equations of motion to given joint wrenches.

use super::cholesky::solve_factored;
use super::redundancy;
use super::response::Response;
use super::sparse::SparseWorkspace;
use super::stages::Stages;
use super::{Balance, dot, fill};
use crate::forward::Forward;
use crate::forward::constraint_jacobian::each_dof;
use crate::forward::data::Data;
use crate::scalar::{Lanes, Scalar};
use crate::spatial::{Twist, Vec3, Wrench};
use crate::topology::{Link, Role};

/// Four scalars, one for each of four responses that are computed together by vector instructions.
pub(in crate::forward) type Four = Lanes<f64, 4>;

/// Buffers for computing responses.
#[derive(Clone, Debug, Default)]
pub(in crate::forward) struct Workspace {
    right: Vec<f64>,
    /// Generalised forces and accelerations of whole responses without given wrenches.
    start: (Vec<f64>, Vec<f64>),
    one: Stages<f64>,
    four: Stages<Four>,
    sparse: SparseWorkspace,
    redundancy: redundancy::Workspace,
}

impl Balance {
    /// Computes accelerations, multipliers and joint wrenches for given joint wrenches `efforts`
    /// (predecessor on successor), which act in addition to the constraint wrenches. If `whole`,
    /// the response includes loads, inertia forces and prescribed accelerations; otherwise it
    /// contains only the effect of the given wrenches.
    pub(in crate::forward) fn respond(
        &self,
        model: &Forward,
        data: &Data,
        efforts: &[(usize, Wrench<f64>)],
        whole: bool,
    ) -> Response {
        let mut response = Response::default();
        self.respond_into(model, data, efforts, whole, &mut Workspace::default(), &mut response);
        response
    }

    /// Computes the response like [`Self::respond`], reusing the buffers.
    pub(in crate::forward) fn respond_into(
        &self,
        model: &Forward,
        data: &Data,
        efforts: &[(usize, Wrench<f64>)],
        whole: bool,
        workspace: &mut Workspace,
        response: &mut Response,
    ) {
        if whole {
            self.prepare_whole(model, data, workspace);
            self.respond_whole(model, data, efforts, workspace, response);
            return;
        }
        let (n, one) = (model.topology.dofs(), &mut workspace.one);
        fill(&mut one.forces, n, 0.0);
        fill(&mut one.accelerations, n, 0.0);
        fill(&mut one.demand, data.bodies.pose.len(), Wrench::zero());
        self.respond_to((model, data), efforts, false, workspace, response);
    }

    /// Computes the parts of whole responses that do not depend on the given wrenches, for
    /// [`Self::respond_whole`].
    pub(in crate::forward) fn prepare_whole(
        &self,
        model: &Forward,
        data: &Data,
        workspace: &mut Workspace,
    ) {
        let n = model.topology.dofs();
        let Workspace { right, start: (forces, accelerations), .. } = workspace;
        forces.clear();
        forces.extend(data.masses.bias.iter().map(|bias| -bias));
        fill(accelerations, n, 0.0);
        if self.is_sparse() {
            return;
        }
        right.clear();
        right.extend(self.rows.rows.iter().map(|r| r.right * r.scale));
        self.space.shortest_into(right, accelerations);
        accelerations.iter_mut().zip(&model.columns).for_each(|(a, c)| *a *= c);
        for (row, force) in self.mass.chunks_exact(n.max(1)).zip(forces) {
            *force -= dot(row, accelerations);
        }
    }

    /// Computes the whole response to given wrenches, see [`Self::respond`]. Requires
    /// [`Self::prepare_whole`] for the same factorisation and data.
    pub(in crate::forward) fn respond_whole(
        &self,
        model: &Forward,
        data: &Data,
        efforts: &[(usize, Wrench<f64>)],
        workspace: &mut Workspace,
        response: &mut Response,
    ) {
        let Workspace { one, start: (forces, accelerations), .. } = &mut *workspace;
        one.forces.clone_from(forces);
        one.accelerations.clone_from(accelerations);
        one.demand.clone_from(&data.masses.bias_wrenches);
        self.respond_to((model, data), efforts, true, workspace, response);
    }

    /// Computes the response to given wrenches from the quantities in `workspace.one` without these
    /// wrenches, see [`Self::accelerate`].
    fn respond_to(
        &self,
        (model, data): (&Forward, &Data),
        efforts: &[(usize, Wrench<f64>)],
        whole: bool,
        workspace: &mut Workspace,
        response: &mut Response,
    ) {
        let Workspace { one, .. } = &mut *workspace;
        for &(joint, wrench) in efforts {
            each_dof(&model.topology, joint, |tree_dof, sign| {
                one.forces[tree_dof] += sign * data.bodies.screws[tree_dof].power(wrench);
            });
        }
        match self.sparse() {
            Some(sparse) => {
                let buffers = (&mut workspace.one, &mut workspace.sparse);
                self.respond_sparse(sparse, (model, data), efforts, whole, buffers);
            }
            None => self.accelerate(model, data, efforts, whole, one),
        }
        let Workspace { one, redundancy, .. } = workspace;
        response.accelerations.clone_from(&one.accelerations);
        response.multipliers.clone_from(&one.multipliers);
        response.wrenches.clone_from(&one.wrenches);
        self.redundancy.apply((model, data), &self.rows, whole, redundancy, response);
    }

    /// Computes the response to each of the given joint wrenches alone. Requires a dense factorisation.
    pub(in crate::forward) fn responses(
        &self,
        model: &Forward,
        data: &Data,
        efforts: &[(usize, Wrench<f64>)],
    ) -> Vec<Response> {
        let mut workspace = Workspace::default();
        let mut responses = Vec::with_capacity(efforts.len());
        for efforts in efforts.chunks(4) {
            self.accelerate_by_four(model, data, efforts, &mut workspace);
            let Workspace { four, redundancy, .. } = &mut workspace;
            for lane in 0..efforts.len() {
                let numbers = |of: &[Four]| of.iter().map(|x| x.0[lane]).collect();
                let mut response = Response {
                    accelerations: numbers(&four.accelerations),
                    multipliers: numbers(&four.multipliers),
                    wrenches: four.wrenches.iter().map(|wrench| wrench.lane(lane)).collect(),
                };
                let of = (model, data);
                self.redundancy.apply(of, &self.rows, false, redundancy, &mut response);
                responses.push(response);
            }
        }
        responses
    }

    /// Computes the joint wrenches and multipliers that each of up to four given joint wrenches
    /// causes alone. Requires a dense factorisation without redundant constraints.
    pub(in crate::forward) fn respond_to_four<'s>(
        &self,
        model: &Forward,
        data: &Data,
        efforts: &[(usize, Wrench<f64>)],
        workspace: &'s mut Workspace,
    ) -> (&'s [Wrench<Four>], &'s [Four]) {
        debug_assert!(!self.is_redundant(), "reactions are not unique");
        self.accelerate_by_four(model, data, efforts, workspace);
        (&workspace.four.wrenches, &workspace.four.multipliers)
    }

    /// Computes `workspace.four` for up to four given joint wrenches, each of which acts alone.
    fn accelerate_by_four(
        &self,
        model: &Forward,
        data: &Data,
        efforts: &[(usize, Wrench<f64>)],
        workspace: &mut Workspace,
    ) {
        debug_assert!(!self.is_sparse, "the dense factorisation is needed");
        let n = model.topology.dofs();
        let four = &mut workspace.four;
        fill(&mut four.forces, n, Four::zero());
        fill(&mut four.accelerations, n, Four::zero());
        fill(&mut four.demand, data.bodies.pose.len(), Wrench::zero());
        let mut lanes = [(0, Wrench::zero()); 4];
        for (k, (&(joint, effort), lane)) in efforts.iter().zip(&mut lanes).enumerate() {
            let only = Four::from_fn(|l| if l == k { 1.0 } else { 0.0 });
            *lane = (joint, effort.lift::<Four>() * only);
            each_dof(&model.topology, joint, |tree_dof, sign| {
                four.forces[tree_dof].0[k] += sign * data.bodies.screws[tree_dof].power(effort);
            });
        }
        self.accelerate(model, data, &lanes[..efforts.len().min(4)], false, four);
    }

    /// Computes the accelerations, multipliers and joint wrenches of a response by the dense
    /// factorisation. On entry, `stages` contains accelerations that satisfy the constraint rows,
    /// the generalised forces `f - h - M a` at these accelerations (see [`super`]), and the wrench
    /// that the joints must exert on each body at zero acceleration of the spanning tree.
    fn accelerate<T: Scalar>(
        &self,
        model: &Forward,
        data: &Data,
        efforts: &[(usize, Wrench<T>)],
        whole: bool,
        stages: &mut Stages<T>,
    ) {
        let n = model.topology.dofs();
        let Stages { forces, along, accelerations, multipliers, .. } = stages;
        // Forces projected onto the null space accelerate the mechanism.
        along.clear();
        along.extend(self.basis.chunks_exact(n.max(1)).map(|z| {
            let mut sum = T::zero();
            for (z, p) in z.iter().zip(&*forces) {
                sum += *p * T::from_f64(*z);
            }
            sum
        }));
        solve_factored(&self.factor, along);
        let chunks = self.basis.chunks_exact(n.max(1)).zip(self.momenta.chunks_exact(n.max(1)));
        for ((vector, momentum), amount) in chunks.zip(&*along) {
            for (a, z) in accelerations.iter_mut().zip(vector) {
                *a += *amount * T::from_f64(*z);
            }
            for (f, m) in forces.iter_mut().zip(momentum) {
                *f -= *amount * T::from_f64(*m);
            }
        }
        // The scaled residual `M a + h - f` lies in the row space of the scaled constraint
        // Jacobian.
        forces.iter_mut().zip(&model.columns).for_each(|(p, c)| *p *= T::from_f64(-c));
        self.space.amounts(forces, multipliers);
        for (multiplier, row) in multipliers.iter_mut().zip(&self.rows.rows) {
            *multiplier *= T::from_f64(row.scale);
        }
        self.load_joints(model, data, efforts, whole, stages);
    }

    /// Computes the self-stress state with the given multipliers: the joint wrenches that these
    /// multipliers cause at zero accelerations and without loads.
    pub(super) fn self_stress(
        &self,
        model: &Forward,
        data: &Data,
        multipliers: Vec<f64>,
        workspace: &mut Workspace,
    ) -> Response {
        let (n, one) = (model.topology.dofs(), &mut workspace.one);
        fill(&mut one.accelerations, n, 0.0);
        fill(&mut one.demand, data.bodies.pose.len(), Wrench::zero());
        one.multipliers.clone_from(&multipliers);
        self.load_joints(model, data, &[], false, one);
        let wrenches = one.wrenches.clone();
        Response { accelerations: vec![0.0; n], multipliers, wrenches }
    }

    /// Computes the wrenches of all joints from the accelerations, the multipliers and
    /// `stages.demand`. On entry, `stages.demand` contains the wrench that the joints must exert on
    /// each body at zero acceleration of the spanning tree.
    pub(super) fn load_joints<T: Scalar>(
        &self,
        model: &Forward,
        data: &Data,
        efforts: &[(usize, Wrench<T>)],
        whole: bool,
        stages: &mut Stages<T>,
    ) {
        let (topology, bodies, masses) = (&model.topology, &data.bodies, &data.masses);
        let Stages { accelerations, multipliers, twists, demand, wrenches, .. } = stages;
        let n = topology.dofs().max(1);
        let sum_of = |row: &[f64], accelerations: &[T], bias: f64| {
            let mut sum = T::from_f64(bias);
            for (a, r) in accelerations.iter().zip(row) {
                sum += *a * T::from_f64(*r);
            }
            sum
        };
        fill(twists, bodies.pose.len(), Twist::zero());
        for node in &topology.nodes {
            let mut sum = match (node.link, node.parent) {
                (Link::Joint { .. }, Some(parent)) => twists[topology.nodes[parent].body],
                _ => Twist::zero(),
            };
            for tree_dof in node.tree_dofs.clone() {
                sum += bodies.screws[tree_dof].lift() * accelerations[tree_dof];
            }
            twists[node.body] = sum;
            demand[node.body] += masses.inertia[node.body].times(sum);
        }
        fill(wrenches, topology.joint_types.len(), Wrench::zero());
        let in_cuts = |joint: usize| matches!(topology.role[joint], Role::Cut { .. });
        for (row, multiplier) in self.rows.rows.iter().zip(&*multipliers) {
            if in_cuts(row.joint) {
                wrenches[row.joint] += row.covector.lift() * *multiplier;
            }
        }
        for &(joint, wrench) in efforts {
            if in_cuts(joint) {
                wrenches[joint] += wrench;
            }
        }
        // A part of an effort accelerates the rotor and does not reach the joint. The wrenches of
        // joints in the spanning tree follow from the equilibrium of the bodies.
        let rows = masses.rotor_rows.chunks_exact(n).zip(masses.taken_rows.chunks_exact(n));
        for (rotor, (row, taken)) in masses.rotors.iter().zip(rows) {
            if let Some((body, momentum)) = rotor.carrier {
                let moment = momentum.lift() * sum_of(row, accelerations, 0.0);
                demand[body] += Wrench { force: Vec3::zero(), moment };
            }
            for part in &masses.rotor_parts[rotor.parts.clone()] {
                if in_cuts(part.joint) {
                    let bias = if whole { rotor.bias } else { 0.0 };
                    let taken = sum_of(taken, accelerations, bias);
                    wrenches[part.joint] -= part.covector.lift() * taken;
                }
            }
        }
        for cut in &topology.cuts {
            let (predecessor, successor) = topology.ends[cut.joint];
            demand[successor] -= wrenches[cut.joint];
            demand[predecessor] += wrenches[cut.joint];
        }
        for node in topology.nodes.iter().rev() {
            let Link::Joint { joint, reversed } = node.link else { continue };
            let wrench = demand[node.body];
            wrenches[joint] = if reversed { -wrench } else { wrench };
            if let Some(parent) = node.parent {
                demand[topology.nodes[parent].body] += wrench;
            }
        }
    }
}
