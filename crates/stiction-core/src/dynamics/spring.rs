//! Spring forces at one instant.

use crate::kinematics::Bodies;
use crate::parameters::SpringParameters;
use crate::scalar::Scalar;
use crate::spatial::{Vec3, Wrench};

/// Length, rate and force of a spring at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringForce<T> {
    /// Distance between its ends, m.
    pub length: T,
    /// Rate of that distance, m/s; zero if the ends coincide.
    pub rate: T,
    /// Force along the line between the ends, N; positive in tension.
    pub tension: T,
    /// Wrench on the body of the second end about the reference point, world axes; its negative
    /// acts on the body of the first end.
    pub wrench: Wrench<T>,
}

impl<T: Scalar> SpringForce<T> {
    /// Spring force from poses and twists of the bodies.
    ///
    /// If the ends coincide, the direction is undefined, and only the linear part `stiffness *
    /// span` of the force, which is zero, remains; see [`Self::has_direction`].
    // Not inlined: few mechanisms have springs, and every kernel of every scalar would grow.
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
        // Without a free length the force is linear in `span`, also through zero.
        let along = spring.damping * rate - spring.stiffness * spring.free_length;
        let force = -(span * spring.stiffness + direction * along);
        let tension = spring.stiffness * length + along;
        Self { length, rate, tension, wrench: Wrench { force, moment: b.cross(force) } }
    }
}

impl SpringForce<f64> {
    /// True if the direction of the force is defined, or the force needs none. `length` is the
    /// characteristic length, m.
    pub fn has_direction(&self, spring: &SpringParameters<f64>, length: f64) -> bool {
        // Closer ends define no direction: it would be round-off of the poses.
        const APART: f64 = 1e-12;
        let needs_none = spring.stiffness * spring.free_length == 0.0 && spring.damping == 0.0;
        needs_none || self.length > APART * length
    }

    /// Power of the spring on its two bodies, W; computed from the rate of its length, not from its
    /// wrench.
    pub fn power(&self) -> f64 {
        -self.tension * self.rate
    }

    /// Speeds of both ends times the force, W: the scale of round-off in the power.
    pub fn turnover(&self, spring: &SpringParameters<f64>, bodies: &Bodies<f64>) -> f64 {
        let speed = |(&body, &point): (&usize, &Vec3<f64>)| {
            bodies.twist[body].velocity_at(bodies.pose[body].apply(point)).norm()
        };
        let speeds: f64 = spring.ends.iter().zip(&spring.points).map(speed).sum();
        speeds * self.wrench.force.norm()
    }
}
