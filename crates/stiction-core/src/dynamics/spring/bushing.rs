//! Force and moment of bushings.
//!
//! Equation (B12) of the book's theory.

use crate::kinematics::{Bodies, RotationVector};
use crate::parameters::BushingParameters;
use crate::scalar::Scalar;
use crate::spatial::{Vec3, Wrench};

/// Deflection and wrench of a bushing at one instant.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BushingForce<T> {
    /// Displacement, m, and rotation vector, rad, of the second bushing frame relative to the
    /// first, in the axes of the first.
    pub(super) deflection: (Vec3<T>, Vec3<T>),
    /// Time derivatives of the displacement, m/s, and of the rotation vector, rad/s.
    pub(super) deflection_rate: (Vec3<T>, Vec3<T>),
    /// Angular velocity of the second bushing frame relative to the first, in the axes of the
    /// first, rad/s.
    pub(super) angular: Vec3<T>,
    /// Wrench on the body of the second bushing frame, about the reference point in world axes.
    pub(super) wrench: Wrench<T>,
}

impl<T: Scalar> BushingForce<T> {
    /// Computes the deflection and the wrench from poses and twists of the bodies.
    #[inline(never)]
    pub(super) fn of(bushing: &BushingParameters<T>, bodies: &Bodies<T>) -> Self {
        let [from, to] = bushing.ends;
        let (a, b) = (bodies.pose[from] * bushing.frames[0], bodies.pose[to] * bushing.frames[1]);
        let relative = bodies.twist[to] - bodies.twist[from];
        let own = |v: Vec3<T>| a.rotation.transpose_mul(v);
        let rotation = RotationVector::of(a.rotation.transpose() * b.rotation);
        let deflection = (own(b.position - a.position), rotation.value);
        // Velocity of the origin of the second frame relative to the first body.
        let (linear, angular) = (own(relative.velocity_at(b.position)), own(relative.angular));
        let rates = rotation.rate_matrix();
        let (force, gradient) = bushing.stiffness.times(deflection);
        let (damping_force, damping_moment) = bushing.damping.times((linear, angular));
        // The power of the elastic moment equals the gradient times the rate of the rotation
        // vector.
        let moment = rates.transpose() * gradient + damping_moment;
        let (force, moment) = (a.rotation * (force + damping_force), a.rotation * moment);
        let wrench = -(Wrench::force_through(force, b.position) + Wrench::couple(moment));
        Self { deflection, deflection_rate: (linear, rates * angular), angular, wrench }
    }
}

impl BushingForce<f64> {
    /// Returns true unless the bushing is twisted by nearly half a turn, where the rotation vector
    /// has no unique direction.
    pub(in crate::dynamics) fn has_direction(&self) -> bool {
        // Closer to half a turn, the direction loses digits and the moment jumps.
        const LARGEST: f64 = 3.1;
        let (_, rotation) = self.deflection;
        rotation.norm() < LARGEST
    }
}
