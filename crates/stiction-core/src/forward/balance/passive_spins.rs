//! Passive spins without inertia: rotations of a single body about an axis without moment of
//! inertia, for example of a rod between two balls. The rate of a passive spin stays constant, and
//! the joints cannot transmit a moment about its axis. A body without mass and inertia that a
//! single joint connects has no passive spin, because its inertia is missing altogether, as that of
//! a pendulum without mass.

use super::{Balance, Massless};
use crate::forward::Forward;
use crate::forward::constraint_jacobian::each_dof;
use crate::forward::data::Data;
use crate::kinematics::body_twists;
use crate::spatial::{Twist, Vec3, Wrench};
use crate::topology::Link;

/// The moment about a spin axis without inertia counts as zero if it is below this fraction of the
/// largest acting moment. The spin axis is computed as the direction in which the inertia is below
/// a threshold, so the error of this direction is about the square root of the threshold.
const NEGLIGIBLE: f64 = 1e-6;
/// A body counts as at rest if its speed is below this fraction of the speed of the fastest body.
const AT_REST: f64 = 1e-6;

impl Balance {
    /// Returns true if there are passive spins without inertia.
    pub(in crate::forward) fn has_passive_spins(&self) -> bool {
        !self.passive_spins.is_empty()
    }

    /// Checks that no moment acts about the axis of a passive spin without inertia. If `effort`
    /// contains a joint and its wrench, checks the moment of this wrench alone; otherwise checks
    /// the moments of loads and inertia forces.
    ///
    /// # Errors
    /// Returns the body about whose spin axis a moment acts; the acceleration of this spin is
    /// undefined.
    pub(in crate::forward) fn check_passive_spins(
        &self,
        model: &Forward,
        data: &Data,
        effort: Option<(usize, Wrench<f64>)>,
    ) -> Result<(), Massless> {
        for rates in &self.passive_spins {
            let (mut sum, mut size) = (0.0, 0.0);
            match effort {
                None => {
                    for (rate, bias) in rates.iter().zip(&data.masses.bias) {
                        sum += rate * bias;
                        size += (rate * bias).abs();
                    }
                    let moments = data.masses.bias_wrenches.iter().map(|w| w.moment.norm());
                    size = moments.fold(size, f64::max);
                }
                Some((joint, wrench)) => {
                    each_dof(&model.topology, joint, |tree_dof, sign| {
                        sum += sign * data.bodies.screws[tree_dof].power(wrench) * rates[tree_dof];
                    });
                    size = wrench.moment_about(data.bodies.frame_j[joint].position).norm();
                }
            }
            if sum.abs() > NEGLIGIBLE * size {
                return Err(Massless { body: fastest_body(model, data, rates).0 });
            }
        }
        Ok(())
    }

    /// Removes the component of the tree accelerations that would change the rates of passive spins
    /// without inertia.
    pub(in crate::forward) fn keep_passive_spins(
        &self,
        model: &Forward,
        data: &Data,
        accelerations: &mut [f64],
    ) {
        let (topology, bodies) = (&model.topology, &data.bodies);
        for rates in &self.passive_spins {
            let (body, _) = fastest_body(model, data, rates);
            let angular = |amounts: &[f64]| {
                let mut sum = Vec3::zero();
                let mut next = topology.node_of_body[body].map(|node| &topology.nodes[node]);
                while let Some(node) = next {
                    for tree_dof in node.tree_dofs.clone() {
                        sum += bodies.screws[tree_dof].angular * amounts[tree_dof];
                    }
                    next = match node.link {
                        Link::Joint { .. } => node.parent.map(|parent| &topology.nodes[parent]),
                        Link::Floating => None,
                    };
                }
                sum
            };
            let axis = angular(rates);
            let square = axis.norm_squared();
            if square > 0.0 {
                let acceleration = angular(accelerations) + bodies.bias[body].angular;
                let amount = acceleration.dot(axis) / square;
                accelerations.iter_mut().zip(rates).for_each(|(a, rate)| *a -= amount * rate);
            }
        }
    }
}

/// Returns true if a motion without inertia is the passive spin of a single body. `rates` are the
/// rates of the spanning tree in this motion.
pub(super) fn is_passive_spin(model: &Forward, data: &Data, rates: &[f64]) -> bool {
    let (body, alone) = fastest_body(model, data, rates);
    let joints = model.topology.ends.iter().filter(|(a, b)| *a == body || *b == body).count();
    let (mass, inertia) = (model.parameters.mass[body], model.parameters.inertia[body]);
    alone && (joints > 1 || mass > 0.0 || inertia.trace() > 0.0)
}

/// Returns the index of the fastest body for given rates of the spanning tree, and true if this
/// body rotates and no other body moves.
pub(super) fn fastest_body(model: &Forward, data: &Data, rates: &[f64]) -> (usize, bool) {
    let twists = body_twists(&model.topology, &data.bodies, rates);
    let size = |twist: &Twist<f64>| model.twist_rate(twist);
    let fastest = (0..twists.len()).max_by(|a, b| size(&twists[*a]).total_cmp(&size(&twists[*b])));
    let Some(fastest) = fastest else { return (0, false) };
    let least = AT_REST * size(&twists[fastest]);
    let turns = twists[fastest].angular.norm() > least;
    let alone = twists.iter().filter(|twist| size(twist) > least).count() == 1;
    (fastest, turns && alone)
}
