//! Balances of forces, moments and power.

use crate::identities::harness::{Verdict, try_everywhere};
use crate::identities::solve::{Solved, agree, solve};
use crate::identities::specimen::Specimen;
use stiction_core::dynamics::LoadAxes;
use stiction_core::spatial::Vec3;

#[test]
fn power_is_balanced() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let power = solve(&specimen.case())?.forces.power;
        let part = power.residual().abs() / power.turnover;
        // Tolerance for the rounding of about a hundred products.
        let holds = power.turnover == 0.0 || part <= 1e-12;
        Ok(if holds { Verdict::Holds } else { Verdict::Broken(format!("{part:e}: {power:?}")) })
    }
    try_everywhere("power is balanced", 0.5, identity);
}

/// Tests the Newton-Euler equations of each body about its centre of mass, in plain vectors: joint
/// reactions, weight and loads equal the rate of change of momentum. The balance of the whole
/// mechanism follows, since each reaction acts on two bodies with opposite signs.
#[test]
fn every_body_obeys_newton_and_euler() {
    fn identity(specimen: &Specimen) -> Result<Verdict, Verdict> {
        let case = specimen.case();
        let Solved { solver, forces, .. } = solve(&case)?;
        let (bodies, mechanism) = (solver.bodies(), &case.mechanism);
        let middle: Vec<Vec3<f64>> =
            mechanism.bodies().iter().zip(&bodies.pose).map(|(b, x)| x.apply(b.com)).collect();
        let mut acting = vec![(Vec3::zero(), Vec3::zero()); middle.len()];
        let mut largest = 0.0_f64;
        let mut act = |body: usize, force: Vec3<f64>, moment: Vec3<f64>, at: Vec3<f64>| {
            let (f, m) = &mut acting[body];
            *f += force;
            *m += moment + (at - middle[body]).cross(force);
            largest = largest.max(force.norm()).max(moment.norm());
        };
        for (index, joint) in mechanism.joints().iter().enumerate() {
            let ((force, moment), at) = (forces.reactions[index], bodies.frame_j[index].position);
            act(joint.successor.0, force, moment, at);
            act(joint.predecessor.0, -force, -moment, at);
        }
        for load in &case.loads {
            let pose = bodies.pose[load.body.0];
            let in_world = |v: Vec3<f64>| match load.axes {
                LoadAxes::World => v,
                LoadAxes::Body => pose.rotation * v,
            };
            act(load.body.0, in_world(load.force), in_world(load.moment), pose.apply(load.point));
        }
        let mut found = Vec::new();
        for (index, body) in mechanism.bodies().iter().enumerate().skip(1) {
            let (twist, rate) = (bodies.twist[index], bodies.acceleration[index]);
            let r = middle[index];
            let velocity = twist.linear + twist.angular.cross(r);
            let acceleration = rate.linear + rate.angular.cross(r) + twist.angular.cross(velocity);
            let rotation = bodies.pose[index].rotation;
            let inertia = rotation * body.inertia * rotation.transpose();
            let spin = inertia * rate.angular + twist.angular.cross(inertia * twist.angular);
            let (force, moment) = acting[index];
            let left = force - (acceleration - mechanism.gravity()) * body.mass;
            found.extend(left.to_array());
            found.extend((moment - spin).to_array());
        }
        let nothing = vec![0.0; found.len()];
        // Near singular positions, large forces act at lever arms of the size of the mechanism.
        Ok(agree("component of what is left", &nothing, &found, largest.max(1e-9), 1e-10))
    }
    try_everywhere("every body obeys Newton and Euler", 0.5, identity);
}
