//! What a decomposed balance answers to efforts in the joints.

use super::cholesky::solve_factored;
use super::redundancy;
use super::response::Response;
use super::scene::Scene;
use super::{Balance, dot, fill};
use crate::forward::constraint_jacobian::each_dof;
use crate::scalar::{Lanes, Scalar};
use crate::spatial::{Twist, Wrench};
use crate::topology::{Link, Role};

/// Numbers of four responses at once.
pub(in crate::forward) type Four = Lanes<f64, 4>;

/// What answers efforts, and room for it.
#[derive(Clone, Debug)]
struct Answer<T> {
    /// What drives the tree's freedoms; then what is left of it.
    push: Vec<T>,
    along: Vec<T>,
    accelerations: Vec<T>,
    multipliers: Vec<T>,
    sums: Vec<Twist<T>>,
    /// What joints must exert on each body.
    beyond: Vec<Wrench<T>>,
    wrenches: Vec<Wrench<T>>,
}

impl<T> Default for Answer<T> {
    fn default() -> Self {
        Self {
            push: Vec::new(),
            along: Vec::new(),
            accelerations: Vec::new(),
            multipliers: Vec::new(),
            sums: Vec::new(),
            beyond: Vec::new(),
            wrenches: Vec::new(),
        }
    }
}

/// Room for one response after the other.
#[derive(Clone, Debug, Default)]
pub(in crate::forward) struct Scratch {
    right: Vec<f64>,
    one: Answer<f64>,
    four: Answer<Four>,
    /// Also for the rule of shares.
    spread: redundancy::Room,
}

impl Balance {
    /// The response to wrenches that joints exert beyond their constraints (predecessor on
    /// successor); with all else that acts if `whole`, alone if not.
    pub(in crate::forward) fn respond(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<f64>)],
        whole: bool,
    ) -> Response {
        let mut response = Response::default();
        self.respond_into(scene, efforts, whole, &mut Scratch::default(), &mut response);
        response
    }

    /// The same in the room that is there.
    pub(in crate::forward) fn respond_into(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<f64>)],
        whole: bool,
        scratch: &mut Scratch,
        response: &mut Response,
    ) {
        let n = scene.topology.dofs();
        let Scratch { right, one, spread, .. } = scratch;
        fill(&mut one.push, n, 0.0);
        if whole {
            one.push.iter_mut().zip(&scene.masses.bias).for_each(|(p, b)| *p = -b);
            one.beyond.clone_from(&scene.masses.demand);
            right.clear();
            right.extend(self.rows.rows.iter().map(|r| r.right * r.scale));
            self.space.shortest_into(right, &mut one.accelerations);
            one.accelerations.iter_mut().zip(scene.columns).for_each(|(a, c)| *a *= c);
            for (row, push) in scene.masses.matrix.chunks_exact(n.max(1)).zip(&mut one.push) {
                *push -= dot(row, &one.accelerations);
            }
        } else {
            fill(&mut one.beyond, scene.bodies.pose.len(), Wrench::zero());
            fill(&mut one.accelerations, n, 0.0);
        }
        for &(joint, wrench) in efforts {
            each_dof(scene.topology, joint, |tree_dof, sign| {
                one.push[tree_dof] += sign * scene.bodies.screws[tree_dof].power(wrench);
            });
        }
        self.answer(scene, efforts, one);
        response.accelerations.clone_from(&one.accelerations);
        response.multipliers.clone_from(&one.multipliers);
        response.wrenches.clone_from(&one.wrenches);
        self.spread.apply(scene, &self.rows, whole, spread, response);
    }

    /// The wrenches of all joints under up to four efforts, each alone; only where nothing is redundant.
    pub(in crate::forward) fn respond_to_four<'s>(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<f64>)],
        scratch: &'s mut Scratch,
    ) -> &'s [Wrench<Four>] {
        debug_assert!(self.spread.stresses.is_empty(), "shares are open");
        let n = scene.topology.dofs();
        let four = &mut scratch.four;
        fill(&mut four.push, n, Four::zero());
        fill(&mut four.accelerations, n, Four::zero());
        fill(&mut four.beyond, scene.bodies.pose.len(), Wrench::zero());
        let mut lanes = [(0, Wrench::zero()); 4];
        for (k, (&(joint, effort), lane)) in efforts.iter().zip(&mut lanes).enumerate() {
            let only = Four::from_fn(|l| if l == k { 1.0 } else { 0.0 });
            *lane = (joint, effort.lift::<Four>() * only);
            each_dof(scene.topology, joint, |tree_dof, sign| {
                four.push[tree_dof].0[k] += sign * scene.bodies.screws[tree_dof].power(effort);
            });
        }
        self.answer(scene, &lanes[..efforts.len().min(4)], four);
        &four.wrenches
    }

    /// What follows from accelerations that satisfy the rows, from what drives the freedoms beyond them, efforts
    /// included, and from what joints must exert on each body where nothing accelerates.
    fn answer<T: Scalar>(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<T>)],
        answer: &mut Answer<T>,
    ) {
        let n = scene.topology.dofs();
        let Answer { push, along, accelerations, multipliers, .. } = answer;
        // What is left along the freedoms accelerates them.
        along.clear();
        along.extend(self.basis.chunks_exact(n.max(1)).map(|z| {
            let mut sum = T::zero();
            for (z, p) in z.iter().zip(&*push) {
                sum += *p * T::from_f64(*z);
            }
            sum
        }));
        solve_factored(&self.factor, along);
        let chunks = self.basis.chunks_exact(n.max(1)).zip(self.moved.chunks_exact(n.max(1)));
        for ((vector, momentum), amount) in chunks.zip(&*along) {
            for (a, z) in accelerations.iter_mut().zip(vector) {
                *a += *amount * T::from_f64(*z);
            }
            for (p, m) in push.iter_mut().zip(momentum) {
                *p -= *amount * T::from_f64(*m);
            }
        }
        // `M a + h - f`, scaled, lies in what the rows span.
        push.iter_mut().zip(scene.columns).for_each(|(p, c)| *p *= T::from_f64(-c));
        self.space.amounts(push, multipliers);
        for (multiplier, row) in multipliers.iter_mut().zip(&self.rows.rows) {
            *multiplier *= T::from_f64(row.scale);
        }
        self.load_joints(scene, efforts, answer);
    }

    /// The response of multipliers alone: nothing accelerates, nothing else acts.
    pub(super) fn load(
        &self,
        scene: &Scene<'_>,
        multipliers: Vec<f64>,
        scratch: &mut Scratch,
    ) -> Response {
        let (n, one) = (scene.topology.dofs(), &mut scratch.one);
        fill(&mut one.accelerations, n, 0.0);
        fill(&mut one.beyond, scene.bodies.pose.len(), Wrench::zero());
        one.multipliers.clone_from(&multipliers);
        self.load_joints(scene, &[], one);
        let wrenches = one.wrenches.clone();
        Response { accelerations: vec![0.0; n], multipliers, wrenches }
    }

    /// The wrenches of all joints from accelerations and multipliers, and what they must exert beyond.
    fn load_joints<T: Scalar>(
        &self,
        scene: &Scene<'_>,
        efforts: &[(usize, Wrench<T>)],
        answer: &mut Answer<T>,
    ) {
        let Scene { topology, bodies, masses, .. } = *scene;
        let Answer { accelerations, multipliers, sums, beyond, wrenches, .. } = answer;
        fill(sums, bodies.pose.len(), Twist::zero());
        for node in &topology.nodes {
            let mut sum = match (node.link, node.parent) {
                (Link::Joint { .. }, Some(parent)) => sums[topology.nodes[parent].body],
                _ => Twist::zero(),
            };
            for tree_dof in node.tree_dofs.clone() {
                sum += bodies.screws[tree_dof].lift() * accelerations[tree_dof];
            }
            sums[node.body] = sum;
            beyond[node.body] += masses.inertia[node.body].times(sum);
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
        for cut in &topology.cuts {
            let (predecessor, successor) = topology.ends[cut.joint];
            beyond[successor] -= wrenches[cut.joint];
            beyond[predecessor] += wrenches[cut.joint];
        }
        for node in topology.nodes.iter().rev() {
            let Link::Joint { joint, reversed } = node.link else { continue };
            let wrench = beyond[node.body];
            wrenches[joint] = if reversed { -wrench } else { wrench };
            if let Some(parent) = node.parent {
                beyond[topology.nodes[parent].body] += wrench;
            }
        }
    }
}
