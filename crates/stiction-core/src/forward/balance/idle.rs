//! Spins of single bodies without inertia about that axis, a rod between two balls about itself: they keep their
//! rate, and nothing may act on them.

use super::scene::Scene;
use super::{Balance, Massless};
use crate::forward::constraint_jacobian::each_dof;
use crate::kinematics::body_twists;
use crate::spatial::{Twist, Vec3, Wrench};
use crate::topology::Link;

/// Moments about a spin without inertia below this part of their size are none: what counts as no inertia
/// leaves its axis uncertain by the root of that.
const PUSHED: f64 = 1e-6;
/// Bodies slower than this part of the fastest stand.
const ALONE: f64 = 1e-6;

impl Balance {
    /// Whether there are spins without inertia.
    pub(in crate::forward) fn has_idle(&self) -> bool {
        !self.idle.is_empty()
    }

    /// Whether nothing acts on spins without inertia: neither what acts on the bodies nor a wrench of a joint.
    ///
    /// # Errors
    /// The spin that something acts on; its acceleration is not defined.
    pub(in crate::forward) fn pushed(
        &self,
        scene: &Scene<'_>,
        effort: Option<(usize, Wrench<f64>)>,
    ) -> Result<(), Massless> {
        for rates in &self.idle {
            let (mut sum, mut size) = (0.0, 0.0);
            match effort {
                None => {
                    for (rate, bias) in rates.iter().zip(&scene.masses.bias) {
                        sum += rate * bias;
                        size += (rate * bias).abs();
                    }
                    let weight = scene.masses.demand.iter().map(|wrench| wrench.moment.norm());
                    size = weight.fold(size, f64::max);
                }
                Some((joint, wrench)) => {
                    each_dof(scene.topology, joint, |tree_dof, sign| {
                        sum += sign * scene.bodies.screws[tree_dof].power(wrench) * rates[tree_dof];
                    });
                    size = wrench.moment_about(scene.bodies.frame_j[joint].position).norm();
                }
            }
            if sum.abs() > PUSHED * size {
                return Err(Massless { body: moving(scene, rates).0 });
            }
        }
        Ok(())
    }

    /// Takes from accelerations of the tree what would change the rates of spins without inertia.
    pub(in crate::forward) fn keep_spins(&self, scene: &Scene<'_>, accelerations: &mut [f64]) {
        let Scene { topology, bodies, .. } = *scene;
        for rates in &self.idle {
            let (body, _) = moving(scene, rates);
            let turn = |amounts: &[f64]| {
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
            let axis = turn(rates);
            let square = axis.norm_squared();
            if square > 0.0 {
                let has = turn(accelerations) + bodies.bias[body].angular;
                let amount = has.dot(axis) / square;
                accelerations.iter_mut().zip(rates).for_each(|(a, rate)| *a -= amount * rate);
            }
        }
    }
}

/// The body that rates of the tree move most, and whether they turn it and leave all others alone: a rod between
/// two balls about itself.
pub(super) fn moving(scene: &Scene<'_>, rates: &[f64]) -> (usize, bool) {
    let twists = body_twists(scene.topology, scene.bodies, rates);
    let size = |twist: &Twist<f64>| scene.rate(twist);
    let fastest = (0..twists.len()).max_by(|a, b| size(&twists[*a]).total_cmp(&size(&twists[*b])));
    let Some(fastest) = fastest else { return (0, false) };
    let least = ALONE * size(&twists[fastest]);
    let turns = twists[fastest].angular.norm() > least;
    let alone = twists.iter().filter(|twist| size(twist) > least).count() == 1;
    (fastest, turns && alone)
}
