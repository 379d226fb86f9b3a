//! Conditions on the tree's accelerations: loops stay closed, held freedoms move as they must.

use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::spatial::{Twist, Wrench};
use crate::topology::{Link, Role, Topology};

/// A freedom of a joint that is held, by friction or by whatever prescribes it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Held {
    pub(super) joint: usize,
    pub(super) dof: usize,
    /// Its prescribed acceleration, rad/s^2 or m/s^2; zero where friction holds.
    pub(super) acceleration: f64,
    /// Whether an actuator holds it (else friction).
    pub(super) drives: bool,
    /// The effort that friction can exert on it, by which shares of friction are measured.
    pub(super) grip: f64,
    /// The effort about which shares are least.
    pub(super) share: f64,
}

/// One condition: a covector on the relative motion of a joint's two bodies.
#[derive(Clone, Debug)]
pub(super) struct Row {
    pub(super) joint: usize,
    /// Its multiplier's unit wrench, predecessor on successor, about the kernel origin.
    pub(super) covector: Wrench<f64>,
    /// The value that it must take on the tree's accelerations.
    pub(super) right: f64,
    /// Whether an actuator holds it.
    pub(super) drives: bool,
    /// Of what friction holds, the effort that it can exert.
    pub(super) grip: Option<f64>,
    /// Of what friction holds, the effort about which shares are least.
    pub(super) share: f64,
    /// Makes errors of angles and lengths comparable.
    pub(super) scale: f64,
}

/// All conditions at one position and velocity.
#[derive(Clone, Debug, Default)]
pub(super) struct Rows {
    pub(super) rows: Vec<Row>,
    /// Row by row over the tree's freedoms.
    pub(super) matrix: Vec<f64>,
}

impl Rows {
    /// Needs bodies placed and, for the right-hand sides, moved.
    pub(super) fn new(
        topology: &Topology,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        held: &[Held],
    ) -> Self {
        let mut rows = Self::default();
        rows.update(topology, parameters, bodies, held);
        rows
    }

    /// The same in the room that is there.
    pub(super) fn update(
        &mut self,
        topology: &Topology,
        parameters: &Parameters<f64>,
        bodies: &Bodies<f64>,
        held: &[Held],
    ) {
        let n = topology.dofs();
        let Self { rows, matrix } = self;
        rows.clear();
        for cut in &topology.cuts {
            let joint = cut.joint;
            let (j, k) = (&bodies.frame_j[joint], &bodies.frame_k[joint]);
            let open = opening(topology, parameters, bodies, joint);
            for constraint in topology.joint_types[joint].constraints() {
                let covector = constraint.wrench(j, k, parameters.pitch[joint]);
                let scale = if constraint.is_moment() { 1.0 } else { 1.0 / parameters.length };
                let right = -open.power(covector);
                rows.push(Row {
                    joint,
                    covector,
                    right,
                    drives: false,
                    grip: None,
                    share: 0.0,
                    scale,
                });
            }
        }
        for held in held {
            let joint = held.joint;
            let dof = &topology.joint_types[joint].dofs()[held.dof];
            let covector = bodies.effort(dof, joint);
            // Of a joint of the tree the rate is the tree's own.
            let right = match topology.role[joint] {
                Role::Tree { .. } => held.acceleration,
                Role::Cut { .. } => {
                    let open = opening(topology, parameters, bodies, joint);
                    held.acceleration - open.power(covector)
                }
            };
            let scale = if dof.translates() { 1.0 / parameters.length } else { 1.0 };
            let drives = held.drives;
            let grip = (!drives).then_some(held.grip);
            let share = held.share;
            rows.push(Row { joint, covector, right, drives, grip, share, scale });
        }
        matrix.clear();
        matrix.resize(rows.len() * n, 0.0);
        for (row, entries) in rows.iter().zip(matrix.chunks_exact_mut(n.max(1))) {
            each_dof(topology, row.joint, |tree_dof, sign| {
                entries[tree_dof] = sign * bodies.screws[tree_dof].power(row.covector);
            });
        }
    }
}

/// The freedoms of the tree that move a joint's bodies against each other, with signs.
pub(super) fn each_dof(topology: &Topology, joint: usize, mut of: impl FnMut(usize, f64)) {
    match topology.role[joint] {
        Role::Cut { cut } => {
            for &(node, sign) in &topology.cuts[cut].path {
                topology.nodes[node].tree_dofs.clone().for_each(|tree_dof| of(tree_dof, sign));
            }
        }
        Role::Tree { node } => {
            let node = &topology.nodes[node];
            let reversed = matches!(node.link, Link::Joint { reversed: true, .. });
            let sign = if reversed { -1.0 } else { 1.0 };
            node.tree_dofs.clone().for_each(|tree_dof| of(tree_dof, sign));
        }
    }
}

/// The relative acceleration of a joint's bodies, beyond what its own rates explain, where the tree does
/// not accelerate.
fn opening(
    topology: &Topology,
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    joint: usize,
) -> Twist<f64> {
    let (predecessor, successor) = topology.ends[joint];
    let own = bodies.joint_bias(topology, parameters, joint);
    bodies.bias[successor] - bodies.bias[predecessor] - own
}
