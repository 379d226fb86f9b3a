//! Degrees of freedom, counted three ways, and what they are.
//!
//! Equations (M1) and (M2) of the book's theory.

use super::clearance::{Play, play};
use super::words::describe_dofs;
use crate::dynamics::InverseDynamics;
use crate::kinematics::{LoopsAt, body_twists};
use crate::mechanism::{BodyId, Mechanism};
use crate::spatial::{Twist, Vec3};

/// Singular values of the loops' equations below this, relative to the largest, count as zero.
/// Matrices are scaled to entries of order one, positions are closed to 1e-13.
pub(super) const NEGLIGIBLE: f64 = 1e-9;

/// How many degrees of freedom a mechanism has, idle spins included.
#[derive(Clone, Debug, PartialEq)]
pub struct Mobility {
    /// By counting bodies and joint freedoms (Gruebler, Kutzbach): right if all constraints are
    /// independent.
    pub gruebler: i64,
    /// At this position, to first order.
    pub instantaneous: usize,
    /// Motions of finite size from this position, traced.
    pub finite: usize,
    /// Whether `finite` is beyond doubt: what tracing did not find is blocked to second order. Otherwise
    /// it is blocked to third or higher order, or too close to call.
    pub finite_is_certain: bool,
    /// Whether branches of motion meet here: along each of them fewer motions are open than to second
    /// order here, or others.
    pub branches_meet: bool,
    /// Constraints that depend on others at this position.
    pub redundant_constraints: usize,
    /// The smallest singular value that counts as one and the largest that counts as zero, both
    /// relative to the largest of all: the gap that decides. None where there is no such value.
    pub gap: (Option<f64>, Option<f64>),
    /// What each moving body can do, in the order of the mechanism's bodies.
    pub bodies: Vec<BodyDofs>,
    /// What clearance makes of motions that are blocked to second order only; empty where such
    /// motions cannot be told from finite ones.
    pub play: Vec<Play>,
}

/// What a body can do at a position.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyDofs {
    /// The body's name.
    pub body: String,
    /// Independent motions in words.
    pub motions: Vec<String>,
    /// Those that are open to first order only; known where the two kinds can be told apart.
    pub first_order_only: Vec<String>,
}

impl Mechanism {
    /// The count of Gruebler and Kutzbach in space: six for each moving body, less what each joint
    /// holds.
    pub fn gruebler(&self) -> i64 {
        let held: usize = self.joints().iter().map(|j| j.joint_type.constraints().len()).sum();
        6 * (self.bodies().len() as i64 - 1) - held as i64
    }
}

impl Mobility {
    /// At the solver's present position.
    pub fn of(solver: &InverseDynamics) -> Self {
        let (topology, parameters) = (solver.topology(), solver.parameters());
        let state = solver.state();
        let mut loops = LoopsAt::new(topology, parameters, state, NEGLIGIBLE);
        let finite = loops.finite_mobility();
        let bodies = body_dofs(solver, &mut loops, finite);
        let blocked = loops.blocked_motions().len();
        let told = finite + blocked == loops.singular_values().len() - loops.rank;
        let play = if told { play(solver, &mut loops) } else { Vec::new() };
        let (rank, values) = (loops.rank, loops.singular_values());
        let relative = |index: usize| values.get(index).map(|value| value / values[0]);
        let gruebler = solver.mechanism().gruebler();
        let instantaneous = topology.dofs() - rank;
        Self {
            gruebler,
            instantaneous,
            finite,
            finite_is_certain: finite + blocked >= instantaneous,
            branches_meet: finite + blocked > instantaneous,
            redundant_constraints: (instantaneous as i64 - gruebler).max(0) as usize,
            gap: if rank == 0 { (None, None) } else { (relative(rank - 1), relative(rank)) },
            bodies,
            play,
        }
    }
}

fn body_dofs(solver: &InverseDynamics, loops: &mut LoopsAt<'_>, finite: usize) -> Vec<BodyDofs> {
    let (topology, parameters) = (solver.topology(), solver.parameters());
    let open = loops.open_motions();
    // Where branches of motion meet, the second order blocks too much.
    let told = open.to_second.len() == finite;
    let lasting = if told { &open.to_second } else { &open.all };
    let twists = |basis: &[Vec<f64>]| -> Vec<Vec<Twist<f64>>> {
        basis.iter().map(|rates| body_twists(topology, solver.bodies(), rates)).collect()
    };
    let (lasting, all) = (twists(lasting), twists(&open.all));
    let bodies = solver.mechanism().bodies();
    (1..bodies.len())
        .map(|body| {
            let com = solver.bodies().pose[body].apply(parameters.com[body]);
            let of_body = |twists: &[Vec<Twist<f64>>]| -> Vec<Twist<f64>> {
                twists.iter().map(|twists| twists[body]).collect()
            };
            let (motions, first_order_only) = describe_dofs(
                &of_body(&lasting),
                &of_body(&all),
                &joints_of(solver, body),
                com,
                parameters.origin,
                parameters.length,
            );
            BodyDofs { body: bodies[body].name.clone(), motions, first_order_only }
        })
        .collect()
}

/// Names and places, from the kernel origin, of the joints at a body.
fn joints_of(solver: &InverseDynamics, body: usize) -> Vec<(&str, Vec3<f64>)> {
    let joints = solver.mechanism().joints().iter().enumerate();
    let at = |id: BodyId| id == BodyId(body);
    let own = joints.filter(|(_, joint)| at(joint.predecessor) || at(joint.successor));
    own.map(|(k, joint)| (joint.name.as_str(), solver.bodies().frame_k[k].position)).collect()
}
