//! Mobility by three methods (Gruebler-Kutzbach count, instantaneous mobility, finite mobility),
//! and the independent motions of each body.
//!
//! Equations (M1) and (M2) of the book's theory.

use super::clearance::{Play, play};
use super::words::describe_dofs;
use crate::dynamics::InverseDynamics;
use crate::kinematics::{FiniteMotion, LoopsAt, body_twists};
use crate::mechanism::{BodyId, Mechanism};
use crate::spatial::{Twist, Vec3};

/// Relative singular values of the loop equations below this value count as zero. Matrices are
/// scaled to entries of order one, and loops are closed to 1e-13.
pub(super) const NEGLIGIBLE: f64 = 1e-9;
/// Relative singular values between [`ROUND_OFF`] and this value may be zero or non-zero, depending
/// on the last digits of the dimensions: configurations with motions blocked at second order are
/// accurate only to the square root of round-off.
const DOUBTFUL: f64 = 1e-6;
/// Relative singular values below this value are zero within round-off.
const ROUND_OFF: f64 = 1e-12;

/// Degrees of freedom of a mechanism, including passive spins.
#[derive(Clone, Debug, PartialEq)]
pub struct Mobility {
    /// Gruebler-Kutzbach count of bodies, joint constraints and gearings; valid for independent constraints.
    pub gruebler: i64,
    /// Instantaneous mobility at this configuration: number of independent motions that the
    /// constraints permit at first order.
    pub instantaneous: usize,
    /// Finite (full-cycle) mobility, starting from this configuration.
    pub finite: FiniteMobility,
    /// A motion traced over a finite distance within the closure tolerance, as evidence of finite
    /// mobility. `None` if all constraints are independent, because then no such evidence is
    /// required, or if no such motion was found.
    pub finite_motion: Option<FiniteMotion>,
    /// True if branches of motion meet at this configuration. The mobility along a branch may then
    /// differ from the second-order result.
    pub branches_meet: bool,
    /// Number of redundant constraints at this configuration.
    pub redundant_constraints: usize,
    /// Singular values that decide the rank: the smallest that counts as non-zero and the largest
    /// that counts as zero, both relative to the largest singular value; `None` for a value that
    /// does not exist.
    pub gap: (Option<f64>, Option<f64>),
    /// Independent motions of each moving body, in the order of the mechanism's bodies.
    pub bodies: Vec<BodyDofs>,
    /// Motions that are blocked at second order only, so that joint clearance permits them. Empty
    /// if the analysis cannot distinguish these motions from finite motions.
    pub play: Vec<Play>,
}

/// Finite mobility: the number of independent finite motions, or bounds on it.
///
/// The number is decided if tracing confirms all motions that are open at second order, and if the
/// singular values clearly decide the rank.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FiniteMobility {
    /// Lower bound: number of motions traced over a finite distance within the closure tolerance of
    /// the loops.
    pub traced: usize,
    /// Upper bound: number of motions that are open at first order and not blocked at second order.
    pub greatest: usize,
}

impl FiniteMobility {
    /// Returns the finite mobility if it is decided, otherwise `None`.
    pub fn decided(self) -> Option<usize> {
        (self.traced == self.greatest).then_some(self.traced)
    }

    /// Returns the lower and the upper bound.
    pub fn range(self) -> [usize; 2] {
        [self.traced, self.greatest]
    }
}

impl core::fmt::Display for FiniteMobility {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self.decided() {
            Some(number) => write!(f, "{number}"),
            None => write!(f, "{} to {}", self.traced, self.greatest),
        }
    }
}

/// Independent motions of a body at a configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct BodyDofs {
    /// Name of the body.
    pub body: String,
    /// Descriptions of the body's independent motions.
    pub motions: Vec<String>,
    /// Descriptions of the body's motions that are only instantaneous. Empty if the analysis cannot
    /// distinguish these motions from finite motions.
    pub first_order_only: Vec<String>,
}

impl Mechanism {
    /// Spatial Gruebler-Kutzbach count: six per moving body, less the constraints of all joints and the gearings.
    pub fn gruebler(&self) -> i64 {
        let constraints: usize =
            self.joints().iter().map(|j| j.joint_type.constraints().len()).sum();
        6 * (self.bodies().len() as i64 - 1) - (constraints + self.gearings().len()) as i64
    }
}

impl Mobility {
    /// Computes the mobility at the solver's current configuration.
    pub fn of(solver: &InverseDynamics) -> Self {
        let (topology, parameters) = (solver.topology(), solver.parameters());
        let state = solver.state();
        let mut loops = LoopsAt::new(topology, parameters, state, NEGLIGIBLE);
        let traced = loops.finite_mobility();
        let bodies = body_dofs(solver, &mut loops, traced);
        let names = solver.mechanism().bodies();
        let finite_motion = loops.finite_motion().map(|(body, moved, turned, closure)| {
            FiniteMotion { body: names[body].name.clone(), moved, turned, closure }
        });
        let blocked = loops.blocked_motions().len();
        let is_explained = traced + blocked == loops.mobility();
        let play = if is_explained { play(solver, &mut loops) } else { Vec::new() };
        let gap = loops.gap();
        let gruebler = solver.mechanism().gruebler();
        let instantaneous = loops.mobility();
        let is_clear = gap.0.is_none_or(|kept| kept > DOUBTFUL)
            && gap.1.is_none_or(|dropped| dropped < ROUND_OFF);
        let greatest = if is_clear && traced + blocked >= instantaneous {
            traced
        } else {
            let mut doubtful = LoopsAt::new(topology, parameters, state, DOUBTFUL);
            let open = topology.dofs() - doubtful.rank;
            traced.max(open.saturating_sub(doubtful.blocked_motions().len()))
        };
        Self {
            gruebler,
            instantaneous,
            finite: FiniteMobility { traced, greatest },
            finite_motion,
            branches_meet: traced + blocked > instantaneous,
            redundant_constraints: (instantaneous as i64 - gruebler).max(0) as usize,
            gap,
            bodies,
            play,
        }
    }
}

fn body_dofs(solver: &InverseDynamics, loops: &mut LoopsAt<'_>, traced: usize) -> Vec<BodyDofs> {
    let (topology, parameters) = (solver.topology(), solver.parameters());
    let open = loops.open_motions();
    // At an intersection of branches the second-order test blocks too many motions.
    let is_decided = open.second_order == traced;
    let lasting = if is_decided { &open.to_second } else { &open.all };
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

/// Lists the names of the joints of a body, and their positions relative to the reference point.
fn joints_of(solver: &InverseDynamics, body: usize) -> Vec<(&str, Vec3<f64>)> {
    let joints = solver.mechanism().joints().iter().enumerate();
    let at = |id: BodyId| id == BodyId(body);
    let own = joints.filter(|(_, joint)| at(joint.predecessor) || at(joint.successor));
    own.map(|(k, joint)| (joint.name.as_str(), solver.bodies().frame_k[k].position)).collect()
}
