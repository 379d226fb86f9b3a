//! Moments that the carrying bodies must exert on spinning rotors.
//!
//! Equation (G9) of the book's theory.

use crate::kinematics::{Bodies, Target};
use crate::parameters::{Parameters, RotorParameters};
use crate::scalar::Scalar;
use crate::spatial::Vec3;
use crate::topology::Topology;

/// Angular momentum and moment of a spinning rotor at one instant, in world axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RotorMotion<T> {
    /// Angular momentum of the rotor about its axis per unit rate of the joint, kg m^2/s per rad/s
    /// or m/s.
    pub momentum: Vec3<T>,
    /// Additional moment that the joints of the carrying body exert because the rotor spins, N m:
    /// the rate of change of the angular momentum of the rotor relative to its carrier.
    pub moment: Vec3<T>,
}

impl<T: Scalar> RotorMotion<T> {
    /// Computes the angular momentum and the moment of a rotor from the motion of the bodies.
    // Not inlined: few mechanisms have spinning rotors, and the code of every scalar type would
    // grow.
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
