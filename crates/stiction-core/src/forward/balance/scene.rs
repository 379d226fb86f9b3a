//! Where a mechanism is and how it moves, as the balance needs them.

use crate::forward::mass_matrix::MassMatrix;
use crate::kinematics::Bodies;
use crate::parameters::Parameters;
use crate::spatial::Twist;
use crate::topology::Topology;

/// Position and velocity as the balance needs them.
#[derive(Clone, Copy)]
pub(in crate::forward) struct Scene<'a> {
    pub(in crate::forward) topology: &'a Topology,
    pub(in crate::forward) parameters: &'a Parameters<f64>,
    pub(in crate::forward) bodies: &'a Bodies<f64>,
    pub(in crate::forward) masses: &'a MassMatrix,
    /// For each freedom of the tree the characteristic length where it translates, else one.
    pub(in crate::forward) columns: &'a [f64],
}

impl Scene<'_> {
    /// How fast a body moves about the kernel origin, rad/s: what does not turn counts as turning at the
    /// characteristic length.
    pub(super) fn rate(&self, twist: &Twist<f64>) -> f64 {
        twist.angular.norm().max(twist.linear.norm() / self.parameters.length)
    }

    /// The greatest such rate of all bodies.
    pub(in crate::forward) fn fastest(&self) -> f64 {
        self.bodies.twist.iter().map(|twist| self.rate(twist)).fold(0.0, f64::max)
    }
}
