//! Finite steps of floating bodies, along screw motions.

use super::bodies::State;
use crate::spatial::{Quaternion, Vec3};
use crate::topology::{Link, Topology};

impl State<f64> {
    /// Advances the coordinates by a finite step. Floating bodies move along a screw motion, with
    /// an error of fourth order in the step. For small corrections, [`Self::advance`] suffices.
    pub(crate) fn advance_far(&mut self, topology: &Topology, step: &[f64]) {
        self.advance(topology, step);
        for node in topology.nodes.iter().filter(|node| matches!(node.link, Link::Floating)) {
            let step = &step[node.tree_dofs.clone()];
            let [linear, angular] = halves(step);
            let turned = angular.cross(linear);
            let more = turned * 0.5 + angular.cross(turned) * (1.0 / 6.0);
            // The quaternion that `advance` computes from a rotation vector has an error of third
            // order.
            let turn = angular * (angular.dot(angular) / 12.0);
            let q = &mut self.coordinates[node.coordinates.clone()];
            let position = Vec3::new(q[0], q[1], q[2]) - linear;
            let moved = Quaternion::of_small(turn).rotation() * position + linear + more;
            q[..3].copy_from_slice(&moved.to_array());
            Quaternion::of_small(turn)
                .compose(Quaternion::from_coordinates(&q[3..]))
                .normalised()
                .write(&mut q[3..]);
        }
    }

    /// Corrects `step` for floating bodies, whose twists at two instants do not commute (Magnus
    /// expansion). Adds `factor` times the Lie bracket of `a` and `b`, which are rates or
    /// accelerations of the spanning tree.
    pub(crate) fn add_bracket(
        topology: &Topology,
        step: &mut [f64],
        factor: f64,
        (a, b): (&[f64], &[f64]),
    ) {
        for node in topology.nodes.iter().filter(|node| matches!(node.link, Link::Floating)) {
            let dofs = node.tree_dofs.clone();
            let [linear_a, angular_a] = halves(&a[dofs.clone()]);
            let [linear_b, angular_b] = halves(&b[dofs.clone()]);
            let linear = angular_a.cross(linear_b) + linear_a.cross(angular_b);
            let parts = [linear, angular_a.cross(angular_b)].map(|part| (part * factor).to_array());
            step[dofs].iter_mut().zip(parts.as_flattened()).for_each(|(own, part)| *own += part);
        }
    }
}

/// Splits the step of a floating body into its linear and angular parts.
fn halves(step: &[f64]) -> [Vec3<f64>; 2] {
    [0, 3].map(|k| Vec3::new(step[k], step[k + 1], step[k + 2]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::JointType;
    use crate::mechanism::{BodySpec, JointSpec, MechanismBuilder};

    /// Checks, by comparison with many small steps, that the error of one large step is of fourth
    /// order. The twist changes at a constant rate.
    #[test]
    fn one_step_follows_a_changing_twist() {
        // Three ball joints connect the body to the ground. All three are cut, so the body is
        // floating.
        let mut held = MechanismBuilder::new("held").body(BodySpec::new("body").mass(1.0));
        for name in ["a", "b", "c"] {
            held = held.joint(JointSpec::new(name, JointType::Spherical, "ground", "body"));
        }
        let topology = Topology::new(&held.build().unwrap());
        assert_eq!(topology.floating().count(), 1);
        assert_eq!((topology.coordinates(), topology.dofs()), (7, 6));
        let rates = [0.3, -0.2, 0.5, 0.7, -0.4, 0.2];
        let accelerations = [0.5, 0.1, -0.3, -0.6, 0.8, 0.4];
        let mut start = State::new(&topology);
        start.coordinates[..3].copy_from_slice(&[0.2, -0.4, 0.7]);
        let error = |duration: f64| {
            let mut far = start.clone();
            let along = |from: f64, to: f64| -> Vec<f64> {
                let (step, middle) = (to - from, 0.5 * (from + to));
                let each = rates.iter().zip(&accelerations);
                each.map(|(v, a)| step * (v + middle * a)).collect()
            };
            let mut step = along(0.0, duration);
            let factor = duration * duration * duration / 12.0;
            State::add_bracket(&topology, &mut step, factor, (&accelerations, &rates));
            far.advance_far(&topology, &step);
            let mut near = start.clone();
            let count = 4000;
            for k in 0..count {
                let at = |k: i32| duration * f64::from(k) / f64::from(count);
                near.advance_far(&topology, &along(at(k), at(k + 1)));
            }
            let pairs = far.coordinates.iter().zip(&near.coordinates);
            pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
        };
        let [large, small] = [0.2, 0.1].map(error);
        assert!(large < 1e-4 && small < large / 12.0, "{large} {small}");
    }
}
