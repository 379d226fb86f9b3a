//! Moments that spinning rotors need from the bodies that carry them.
//!
//! Equation (G9) of the book's theory.

use crate::kinematics::{Bodies, Target};
use crate::parameters::{Parameters, RotorParameters};
use crate::scalar::Scalar;
use crate::spatial::Vec3;
use crate::topology::Topology;

/// Spinning rotor at one instant, in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorMotion<T> {
    /// Angular momentum per rate of the joint, along the axis.
    pub momentum: Vec3<T>,
    /// Moment that the joints of the carrying body exert in addition, N m: the rate of change of the rotor's
    /// angular momentum relative to that body.
    pub moment: Vec3<T>,
}

impl<T: Scalar> RotorMotion<T> {
    /// Rotor for accelerating bodies.
    // Not inlined: few mechanisms have spinning rotors, and every kernel of every scalar would grow.
    #[inline(never)]
    pub fn of(
        rotor: &RotorParameters<T>,
        topology: &Topology,
        parameters: &Parameters<T>,
        bodies: &Bodies<T>,
    ) -> Self {
        let at = (rotor.joint, rotor.dof);
        let Target { rate, acceleration, .. } =
            bodies.joint_motion(topology, parameters, at, T::zero());
        let momentum = (bodies.pose[rotor.body].rotation * rotor.axis) * rotor.momentum;
        let turning = bodies.twist[rotor.body].angular.cross(momentum);
        Self { momentum, moment: momentum * acceleration + turning * rate }
    }
}
