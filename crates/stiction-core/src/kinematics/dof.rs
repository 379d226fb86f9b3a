//! Motions that loops and prescribed coordinates leave undetermined.

use super::bodies::Bodies;
use super::error::OpenDof;
use super::motion_constraints::Spin;
use crate::linalg::{Decomposition, Limit, SparseMatrix, Svd};
use crate::mechanism::BodyId;
use crate::parameters::Parameters;
use crate::spatial::{Twist, Vec3, describe_motion};
use crate::topology::{Actuator, Link, Topology};
use crate::words::significant;
use nalgebra::{DMatrix, DVector};

/// Singular values below this fraction of the largest one (or of 1, if that is greater) count as
/// zero. If a motion is blocked at second order only, configurations and singular values are
/// accurate to the square root of round-off, 1e-8.
const OPEN: f64 = 1e-6;

/// In motions of unit norm, components below this value count as zero.
pub(super) const SMALL: f64 = 1e-4;
/// Distance of a centre of mass from an axis, in characteristic lengths, below which the body was
/// probably meant to spin about the axis freely.
const CLOSE: f64 = 0.02;

/// Undetermined motions at a configuration.
pub(super) enum OpenMotion {
    /// All undetermined motions are local degrees of freedom of single bodies.
    Spins(Vec<Spin>),
    /// Some undetermined motions are not local degrees of freedom.
    Others(Vec<OpenTwist>),
}

/// An undetermined motion, described in words as the motion of one body.
pub(super) struct OpenTwist {
    body: usize,
    motion: String,
}

impl OpenTwist {
    pub(super) fn named(self, bodies: &[String]) -> OpenDof {
        OpenDof { body: bodies[self.body].clone(), motion: self.motion }
    }
}

/// Finds the motions that loops and prescribed coordinates leave undetermined at the current
/// configuration, from the scaled Jacobian `scaled` of these constraints.
pub(super) fn open_motions(
    topology: &Topology,
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    scaled: SparseMatrix,
    column_scales: &[f64],
) -> OpenMotion {
    let decomposition = decompose(scaled);
    let null = decomposition.orthonormal_null_space(decomposition.rank()).dense();
    // Compute the rates of the spanning tree in each undetermined motion, then the twists of the
    // bodies.
    let rates: Vec<DVector<f64>> = null
        .iter()
        .map(|n| DVector::from_iterator(n.len(), n.iter().zip(column_scales).map(|(x, s)| x * s)))
        .collect();
    let twists: Vec<Vec<Twist<f64>>> =
        rates.iter().map(|rates| body_twists(topology, bodies, rates.as_slice())).collect();
    match idle_spins(topology, parameters, bodies, &rates, &twists) {
        Some(spins) => OpenMotion::Spins(spins),
        None => OpenMotion::Others(
            twists.iter().map(|twists| in_words(parameters, bodies, twists)).collect(),
        ),
    }
}

/// Decomposes the scaled Jacobian of loops and coordinates, to decide which motions they leave
/// undetermined.
pub(super) fn decompose(scaled: SparseMatrix) -> Decomposition {
    let columns: Vec<usize> = (0..scaled.ncols()).collect();
    Decomposition::new(scaled, &columns, Limit::OfOrderOne(OPEN))
}

/// Computes the twists of all bodies from the rates of the spanning tree.
pub(crate) fn body_twists(
    topology: &Topology,
    bodies: &Bodies<f64>,
    rates: &[f64],
) -> Vec<Twist<f64>> {
    let mut twists = vec![Twist::zero(); bodies.pose.len()];
    for node in &topology.nodes {
        let mut twist = match (node.link, node.parent) {
            (Link::Joint { .. }, Some(parent)) => twists[topology.nodes[parent].body],
            _ => Twist::zero(),
        };
        for tree_dof in node.tree_dofs.clone() {
            twist += bodies.screws[tree_dof] * rates[tree_dof];
        }
        twists[node.body] = twist;
    }
    twists
}

/// Computes the rate of an actuator, rad/s or m/s, from the twists of all bodies.
pub(crate) fn actuator_rate(
    topology: &Topology,
    bodies: &Bodies<f64>,
    actuator: &Actuator,
    twists: &[Twist<f64>],
) -> f64 {
    let (predecessor, successor) = topology.ends[actuator.joint];
    let dof = &topology.joint_types[actuator.joint].dofs()[actuator.dof];
    let effort = bodies.effort(dof, actuator.joint);
    (twists[successor] - twists[predecessor]).power(effort)
}

/// Finds the passive spins: rotations of single bodies about axes through their centres of mass
/// that move no actuator. Returns `None` if there are other undetermined motions as well.
fn idle_spins(
    topology: &Topology,
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    rates: &[DVector<f64>],
    twists: &[Vec<Twist<f64>>],
) -> Option<Vec<Spin>> {
    let length = parameters.length;
    for actuator in &topology.actuators {
        let dof = &topology.joint_types[actuator.joint].dofs()[actuator.dof];
        let size = if dof.translates() { length } else { 1.0 };
        for twists in twists {
            if actuator_rate(topology, bodies, actuator, twists).abs() > SMALL * size {
                return None;
            }
        }
    }
    // Each row contains the components of one selected spin in all undetermined motions.
    let mut chosen = DMatrix::<f64>::zeros(0, rates.len());
    let mut spins = Vec::new();
    for body in 1..bodies.pose.len() {
        let pose = bodies.pose[body];
        let com = pose.apply(parameters.com[body]);
        let motion = DMatrix::from_columns(
            &twists
                .iter()
                .map(|twists| {
                    let (w, v) =
                        (twists[body].angular, twists[body].velocity_at(com) * (1.0 / length));
                    DVector::from_column_slice(&[w.x, w.y, w.z, v.x, v.y, v.z])
                })
                .collect::<Vec<_>>(),
        );
        let Svd { u, singular_values: values, .. } = Svd::new(&motion);
        if values[0] < SMALL {
            continue;
        }
        let moves_com = u.fixed_view::<3, 1>(3, 0).norm() > SMALL;
        if moves_com || (values.len() > 1 && values[1] > SMALL) {
            return None;
        }
        let axis = Vec3::new(u[(0, 0)], u[(1, 0)], u[(2, 0)]);
        let amounts = u.column(0).transpose() * motion;
        let count = chosen.nrows();
        let mut with = chosen.clone().insert_row(count, 0.0);
        with.row_mut(count).copy_from(&amounts);
        if Svd::new(&with.transpose()).singular_values.min() > SMALL {
            chosen = with;
            spins.push(Spin {
                body: BodyId(body),
                axis: pose.rotation.transpose_mul(axis).direction()?,
            });
        }
    }
    (spins.len() == rates.len()).then_some(spins)
}

/// Describes a motion in words by the motion of the body with the largest displacement.
fn in_words(
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    twists: &[Twist<f64>],
) -> OpenTwist {
    let size = |body: usize| {
        let twist = twists[body];
        let at = bodies.pose[body].apply(parameters.com[body]);
        twist.angular.norm() * parameters.length + twist.velocity_at(at).norm()
    };
    let body = (1..twists.len()).max_by(|&a, &b| size(a).total_cmp(&size(b))).unwrap_or(0);
    let twist = twists[body];
    // Convert the twist from the reference point to the origin of the world frame.
    let in_world = twist.about(-parameters.origin);
    let largest = twist.angular.norm() * parameters.length + twist.linear.norm();
    let mut motion = describe_motion(in_world * (1.0 / largest), parameters.length);
    if let Some(off) = almost_central(parameters, bodies, body, twist) {
        motion += &format!(
            "; its centre of mass is {} mm off this axis: on the axis, the rotation would not matter",
            significant(off * 1e3, 2)
        );
    }
    OpenTwist { body, motion }
}

/// Returns the distance of the centre of mass of a body from the axis of its rotation `twist`, m, if
/// the body rotates about an axis that passes close to it.
fn almost_central(
    parameters: &Parameters<f64>,
    bodies: &Bodies<f64>,
    body: usize,
    twist: Twist<f64>,
) -> Option<f64> {
    let spin = twist.angular.norm();
    let com = twist.velocity_at(bodies.pose[body].apply(parameters.com[body]));
    let along = twist.angular.dot(com).abs();
    let off = com.norm() / spin;
    let is_rotation = spin > 0.0 && along <= SMALL * spin * com.norm();
    let range = 0.1 * SMALL * parameters.length..CLOSE * parameters.length;
    (is_rotation && range.contains(&off)).then_some(off)
}
