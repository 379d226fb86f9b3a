//! What springs do at one instant.

use crate::kinematics::Bodies;
use crate::parameters::SpringParameters;
use crate::scalar::Scalar;
use crate::spatial::{Vec3, Wrench};

/// A spring at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpringForce<T> {
    /// The distance of its ends, m.
    pub length: T,
    /// The rate of that distance, m/s; zero where the ends coincide.
    pub rate: T,
    /// The force along the line between the ends, positive where it draws them together, N.
    pub tension: T,
    /// The wrench on the body of the second end, world axes about the kernel origin; on the body of
    /// the first end acts its negative.
    pub wrench: Wrench<T>,
}

impl<T: Scalar> SpringForce<T> {
    /// From poses and twists of the bodies.
    ///
    /// Ends that coincide are on no line: then only `stiffness * (vector between the ends)`, which
    /// is zero, is left of the force. See [`Self::has_direction`].
    // Few mechanisms have springs: not worth its weight in every kernel of every scalar.
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
        // Of a spring without free length the force is linear in `span`, also through zero.
        let along = spring.damping * rate - spring.stiffness * spring.free_length;
        let force = -(span * spring.stiffness + direction * along);
        let tension = spring.stiffness * length + along;
        Self { length, rate, tension, wrench: Wrench { force, moment: b.cross(force) } }
    }
}

impl SpringForce<f64> {
    /// Whether the force's direction is known: the ends are apart, or it needs none. `length` is
    /// characteristic.
    pub fn has_direction(&self, spring: &SpringParameters<f64>, length: f64) -> bool {
        // Closer than this the direction is made of the rounding of the bodies' poses.
        const APART: f64 = 1e-12;
        let needs_none = spring.stiffness * spring.free_length == 0.0 && spring.damping == 0.0;
        needs_none || self.length > APART * length
    }

    /// The power of the spring on its two bodies, W: from its length alone, not from its wrench.
    pub fn power(&self) -> f64 {
        -self.tension * self.rate
    }

    /// The velocities of both ends times the force, as magnitudes, W.
    pub fn turnover(&self, spring: &SpringParameters<f64>, bodies: &Bodies<f64>) -> f64 {
        let speed = |(&body, &point): (&usize, &Vec3<f64>)| {
            bodies.twist[body].velocity_at(bodies.pose[body].apply(point)).norm()
        };
        let speeds: f64 = spring.ends.iter().zip(&spring.points).map(speed).sum();
        speeds * self.wrench.force.norm()
    }
}
