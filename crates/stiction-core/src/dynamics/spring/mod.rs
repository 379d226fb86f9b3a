//! Spring forces at one instant.
//!
//! Equation (B10) of the book's theory.

mod bushing;
mod energy;
mod fault;
mod joint;

pub(crate) use energy::spring_powers;
pub(crate) use fault::SpringFault;

use crate::kinematics::Bodies;
use crate::parameters::{Parameters, SpringParameters};
use crate::scalar::Scalar;
use crate::spatial::Wrench;

/// Length, rate and force of a spring at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringForce<T> {
    /// Distance between the ends of the spring, m.
    pub length: T,
    /// Rate of change of `length`, m/s; zero if the ends coincide.
    pub rate: T,
    /// Tensile force along the line between the ends, N; negative in compression.
    pub tension: T,
    /// Wrench on the body of the second end about the reference point, world axes. The opposite
    /// wrench acts on the body of the first end.
    pub wrench: Wrench<T>,
}

impl<T: Scalar> SpringForce<T> {
    /// Computes the spring force from poses and twists of the bodies.
    ///
    /// If the ends coincide, the direction is undefined. The result then contains only the linear
    /// part `stiffness * span` of the force, which is zero; see [`Self::has_direction`].
    // Not inlined: few mechanisms have springs, and the code of every scalar type would grow.
    #[inline(never)]
    pub fn of(spring: &SpringParameters<T>, bodies: &Bodies<T>) -> Self {
        let [from, to] = spring.ends;
        let a = bodies.pose[from].apply(spring.points[0]);
        let b = bodies.pose[to].apply(spring.points[1]);
        let span = b - a;
        let length = span.norm();
        let over = length.if_positive(length.if_positive(length, T::one()).recip(), T::zero());
        let direction = span * over;
        let approach = bodies.twist[to].velocity_at(b) - bodies.twist[from].velocity_at(a);
        let rate = direction.dot(approach);
        // Without a free length the force is linear in `span`, even where `span` is zero.
        let along = spring.damping * rate - spring.stiffness * spring.free_length - spring.preload;
        let force = -(span * spring.stiffness + direction * along);
        let tension = spring.stiffness * length + along;
        Self { length, rate, tension, wrench: Wrench { force, moment: b.cross(force) } }
    }

    /// Returns the scale of round-off in the power of the spring, W: the sum of the speeds of both
    /// ends times the magnitude of the force.
    pub fn turnover(&self, spring: &SpringParameters<T>, bodies: &Bodies<T>) -> T {
        let speed = |end: usize| {
            let body = spring.ends[end];
            bodies.twist[body].velocity_at(bodies.pose[body].apply(spring.points[end])).norm()
        };
        (speed(0) + speed(1)) * self.wrench.force.norm()
    }
}

/// Calls `apply` for each spring, joint spring and bushing, with the indices of its two bodies and
/// the wrench on the second body, about the reference point in world axes. The opposite wrench acts
/// on the first body.
// Not inlined: few mechanisms have springs, and inlined code of nested scalar types takes minutes
// to compile.
#[inline(never)]
pub(crate) fn spring_wrenches<T: Scalar>(
    parameters: &Parameters<T>,
    bodies: &Bodies<T>,
    mut apply: impl FnMut([usize; 2], Wrench<T>),
) {
    for spring in &parameters.springs {
        apply(spring.ends, SpringForce::of(spring, bodies).wrench);
    }
    for (spring, &coordinate) in parameters.joint_springs.iter().zip(&bodies.spring_coordinates) {
        apply(spring.ends, joint::wrench(spring, bodies, coordinate));
    }
    for spring in &parameters.bushings {
        apply(spring.ends, bushing::BushingForce::of(spring, bodies).wrench);
    }
}

impl SpringForce<f64> {
    /// Returns true if the direction of the force is defined, or if the force vanishes where its
    /// direction is undefined. `length` is the characteristic length, m.
    pub fn has_direction(&self, spring: &SpringParameters<f64>, length: f64) -> bool {
        // If the distance of the ends is below this fraction of the characteristic length, their
        // direction is round-off of the poses.
        const APART: f64 = 1e-12;
        let offset = spring.stiffness * spring.free_length + spring.preload;
        let needs_none = offset == 0.0 && spring.damping == 0.0;
        needs_none || self.length > APART * length
    }
}
